//! A world in which everything sleeps skips its substeps. The result is bitwise the same, also in what happens after a change.

use sinew::constraints::Plane;
use sinew::glam::{Quat, Vec3};
use sinew::recipes::{BoxSpec, RopeSpec, box_3d, rope};
use sinew::{
    BodyCollider, BodyContacts, BodySettings, Collider, ContactParticipant, Control, Distance,
    Frame, Material, ParticleSeed, Pin, Shape, Simulation, Sleep, Spring, Wind,
};

use crate::rigid_states::{DT, bits, phases};

/// Boxes on the ground and on each other, a rope next to them, and a ball at rest.
fn level() -> Simulation {
    let mut world = Simulation::default();
    world.boundaries.planes.push(Plane::ground(0.0));
    let contacts = BodyContacts { with_bodies: true, ..Default::default() };
    for (x, y) in [(0.0, 0.25), (0.0, 0.75), (2.0, 0.25)] {
        let spec = BoxSpec { size: Vec3::splat(0.5), ..BoxSpec::default() };
        let blueprint = box_3d(&spec).unwrap().transformed(Quat::IDENTITY, Vec3::new(x, y, 0.0));
        blueprint.build_colliding(&mut world, contacts).unwrap();
    }
    let spec = RopeSpec {
        from: Vec3::new(4.0, 0.03, 0.0),
        to: Vec3::new(5.0, 0.03, 0.0),
        segments: 6,
        radius: 0.03,
        ..Default::default()
    };
    let laid = rope(&spec).unwrap().build(&mut world).unwrap();
    let body = world.bodies.len() as u32;
    world.bodies.push(BodySettings::default());
    world.contacts.push(BodyContacts::default());
    laid.for_each(|row| world.particles.set_body(row, Some(body)));
    let ball = Frame::at(Vec3::new(-2.0, 0.5, 0.0));
    world.colliders.push(Collider::fixed(Shape::sphere(0.5).unwrap(), ball));
    world.sleep.resize(world.bodies.len(), Sleep::allowed());
    world
}

/// The visible state: time, bits of the particles, and sleep flags.
fn visible(world: &Simulation) -> (u64, Vec<[u32; 7]>, Vec<bool>) {
    (world.time.to_bits(), bits(world), world.sleep.iter().map(|body| body.asleep).collect())
}

type Edit = (&'static str, fn(&mut Simulation));

/// Changes from outside. Each must end the skipping, whether it moves something or not.
const EDITS: [Edit; 24] = [
    ("a velocity", |world| world.particles.set_velocity(0, Vec3::X)),
    ("an impulse", |world| world.particles.add_impulse(9, Vec3::Y)),
    ("an impulse on several", |world| world.particles.apply_impulse(&[0, 1, 2, 3], Vec3::Y)),
    ("an angular impulse", |world| {
        world.particles.apply_angular_impulse(&[0, 1, 2, 3, 4, 5, 6, 7], Vec3::Y);
    }),
    ("a place", |world| {
        let at = world.particles.position(26);
        world.particles.set_position(26, at + Vec3::Y * 0.2);
    }),
    ("a displacement", |world| world.particles.displace(26, Vec3::Y * 0.2)),
    ("a teleport", |world| {
        world.particles.teleport(&[8, 9, 10, 11, 12, 13, 14, 15], Vec3::Y, Quat::IDENTITY);
        world.check_sleepers();
    }),
    ("a motion", |world| world.particles.set_motion(&[16, 17, 18, 19], Vec3::Y, Vec3::X)),
    ("a force", |world| world.particles.set_external_force(0, Vec3::Y * 1000.0)),
    ("a mass", |world| {
        let seed = world.particles.seed(0);
        world.particles.set(0, ParticleSeed { mass: 100.0, ..seed }).unwrap();
        world.particles.set_body(0, Some(0));
    }),
    ("a wake", |world| world.particles.wake(0)),
    ("a particle", |world| {
        let seed = ParticleSeed::at(Vec3::new(2.0, 3.0, 0.0)).with_mass(5.0).with_radius(0.1);
        world.particles.push(seed).unwrap();
    }),
    ("gravity", |world| world.forces.gravity = Vec3::new(5.0, -9.81, 0.0)),
    ("a wind", |world| world.forces.winds.push(Wind::steady(Vec3::X * 100.0))),
    ("a spring", |world| {
        world.forces.springs.push(Spring {
            a: 0,
            b: 24,
            rest: 0.1,
            stiffness: 1000.0,
            damping: 1.0,
        });
    }),
    ("a control", |world| {
        world.forces.controls.push(Control::force("jet", [0_u32, 1, 2, 3], Vec3::Y * 500.0));
    }),
    ("a tie", |world| world.distances_mut().push(Distance::new(0, 24, 1.0))),
    ("a cut", |world| _ = world.remove_distance(0)),
    ("a lower ground", |world| world.boundaries.planes[0].offset = -1.0),
    ("a pin", |world| {
        let at = world.particles.position(26) + Vec3::Y;
        world.boundaries.pins.push(Pin { particle: 26, target: at });
    }),
    ("a ball that comes", |world| {
        let end = Frame::at(Vec3::new(-0.6, 0.5, 0.0));
        world.colliders[0].end = end;
    }),
    ("ice", |world| {
        let ice = Material { friction: 0.0, ..Default::default() };
        world.contacts.iter_mut().for_each(|body| body.material = ice);
    }),
    ("a listener", |world| world.contacts[0].events = true),
    ("a pair that is ignored", |world| {
        world.ignored.push([ContactParticipant::Body(0), ContactParticipant::Body(1)]);
    }),
];

#[test]
fn skipped_steps_at_rest_change_no_bit() {
    let mut asleep = level();
    for _ in 0..200 {
        asleep.step(DT).unwrap();
    }
    assert!(asleep.sleep.iter().all(|body| body.asleep));
    let mut moved = 0;
    for (what, edit) in EDITS {
        let (mut world, mut stepped) = (asleep.clone(), asleep.clone());
        for tick in 0..5 {
            // A clone does not have the record of a world at rest, and needs two steps to establish it again.
            assert_eq!(is_skipped(&mut world), tick >= 2, "{what}");
            phases(&mut stepped, |_, _| {});
        }
        let before = visible(&world);
        edit(&mut world);
        edit(&mut stepped);
        assert!(!is_skipped(&mut world), "{what} is not noticed");
        phases(&mut stepped, |_, _| {});
        for tick in 0..120 {
            assert_eq!(visible(&world), visible(&stepped), "{what}, {tick} ticks later");
            is_skipped(&mut world);
            phases(&mut stepped, |_, _| {});
        }
        moved += usize::from(visible(&world).1 != before.1);
    }
    assert!(moved > EDITS.len() / 2, "{moved} of them move something");
}

/// A step of another length, or with another number of substeps, is not covered by the record of a world at rest.
#[test]
fn a_step_of_another_length_is_not_skipped() {
    let mut world = level();
    for _ in 0..200 {
        world.step(DT).unwrap();
    }
    assert!(world.is_settled());
    assert!(!world.step_at_rest(2.0 * DT));
    world.settings.substeps = 4;
    assert!(!world.step_at_rest(DT));
    world.settings.substeps = 10;
    let before = world.time;
    assert!(world.step_at_rest(DT));
    assert!((world.time - before - f64::from(DT)).abs() < 1e-8);
}

/// Takes a step, and returns whether its substeps were skipped.
fn is_skipped(world: &mut Simulation) -> bool {
    let at_once = world.step_at_rest(DT);
    if !at_once {
        world.step(DT).unwrap();
    }
    at_once
}

/// Two bones with a joint lie on the ground at an angle to each other, and a box that stays awake lies either within their bounding box, or at the end of one.
/// Returns whether the bones sleep.
fn sleeps_beside(box_at: Vec3) -> bool {
    let mut world = Simulation::default();
    world.boundaries.planes.push(Plane::ground(0.0));
    let corners = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 0.0, 1.0)].map(|at| at + Vec3::Y * 0.1);
    let rows = corners.map(|at| world.particles.push(ParticleSeed::at(at)).unwrap());
    for (two, id) in rows.windows(2).zip(0..) {
        world.distances_mut().push(Distance::new(two[0], two[1], 1.0));
        let bone = BodyCollider::segment([two[0], two[1]], 1.0, 0.1, id).unwrap();
        world.body_colliders_mut().push(bone);
    }
    rows.iter().for_each(|&row| world.particles.set_body(row as usize, Some(0)));
    world.bodies.push(BodySettings::default());
    let contacts = BodyContacts { with_bodies: true, ..Default::default() };
    world.contacts.push(contacts);
    let spec = BoxSpec { size: Vec3::splat(0.2), ..BoxSpec::default() };
    let lies = box_3d(&spec).unwrap().transformed(Quat::IDENTITY, box_at + Vec3::Y * 0.1);
    lies.build_colliding(&mut world, contacts).unwrap();
    *world.sleep = vec![Sleep::allowed(), Sleep { keeps_awake: true, ..Sleep::allowed() }];
    (0..60).for_each(|_| {
        world.step(DT).unwrap();
    });
    world.sleep[0].asleep
}

#[test]
fn a_box_between_the_bones_of_a_body_keeps_it_awake_only_where_it_touches_one() {
    assert!(sleeps_beside(Vec3::new(0.3, 0.0, 0.7)), "it is half a metre from either bone");
    assert!(!sleeps_beside(Vec3::new(1.0, 0.0, 1.205)), "it lies at the end of one");
}

/// A support that went in just the tick in which a body fell asleep was not missed: the body's hash was that of the air below it, and it floated until something
/// woke it.
#[test]
fn what_loses_its_support_falls_in_whatever_tick_that_is() {
    for by_box in [false, true] {
        for ticks in 20..40 {
            let mut world = Simulation::default();
            let ground = Shape::cuboid(Vec3::new(4.0, 1.0, 4.0)).unwrap();
            let below = Frame::new(Vec3::NEG_Y * if by_box { 0.9 } else { 0.5 }, Quat::IDENTITY);
            world.colliders.push(Collider::fixed(ground, below));
            let mut rows = Vec::new();
            for height in if by_box { vec![-0.2, 0.2] } else { vec![0.2] } {
                let spec = BoxSpec { size: Vec3::splat(0.4), ..Default::default() };
                let body = box_3d(&spec).unwrap().transformed(Quat::IDENTITY, Vec3::Y * height);
                rows.push(body.build_colliding(&mut world, BodyContacts::default()).unwrap());
            }
            world.sleep.resize(world.bodies.len(), Sleep::allowed());
            for _ in 0..ticks {
                world.step(DT).unwrap();
            }
            if by_box {
                // Out from under the other one.
                for row in rows.remove(0) {
                    let at = world.particles.position(row);
                    world.particles.set_position(row, at + Vec3::X * 3.0);
                }
                world.check_sleepers();
            } else {
                world.colliders.clear();
            }
            let upper = rows[0].clone();
            let height = |world: &Simulation| world.particles.position(upper.start).y;
            let began = height(&world);
            for _ in 0..20 {
                world.step(DT).unwrap();
            }
            let fallen = began - height(&world);
            assert!(fallen > 0.2, "after {ticks} ticks, on a box: {by_box}: {fallen}");
        }
    }
}
