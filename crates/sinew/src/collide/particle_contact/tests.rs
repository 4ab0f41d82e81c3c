//! The broad phase, particles flung beyond its margins, and batches against the scalar path.

use glam::{Quat, Vec3};

use super::{NormalImpulse, NormalImpulses};
use crate::lanes::InstructionSet;
use crate::test_random::Random;

use crate::particles::{ParticleSeed, Places};
use crate::recipes::{BoxSpec, ClothSpec, box_3d, cloth_grid};
use crate::{
    BodyContacts, Collider, Combine, Frame, Layers, Material, Plane, Shape, Simulation, Wind,
};

/// A cloth of 1 m × 1 m in a wind, hung by two corners 3 m above the ground, if there is any.
fn hung() -> Simulation {
    let spec = ClothSpec::default();
    let mut cloth = cloth_grid(&spec).unwrap();
    for corner in [spec.index(0, 0), spec.index(spec.columns, 0)] {
        cloth.pin(corner).unwrap();
    }
    let mut world = Simulation::default();
    for mut seed in cloth.particles {
        seed.position.y += 3.0;
        world.particles.push(seed).unwrap();
    }
    world.distances_mut().extend(cloth.distances);
    *world.forces.surfaces = cloth.triangles;
    world.forces.winds.push(Wind::steady(Vec3::Z * 3.0));
    world
}

fn ball(at: Vec3) -> Collider {
    Collider::fixed(Shape::sphere(0.2).unwrap(), Frame { translation: at, ..Frame::IDENTITY })
}

/// The rows of the cloth that are tested for contacts, at the start of a step.
fn tested_rows(world: &mut Simulation) -> Vec<u32> {
    world.begin_step(1.0 / 60.0).unwrap();
    let (contacts, plan) = (world.particle_contacts().clone(), world.plan().clone());
    let number = plan.islands.of[0] as usize;
    let rows = &plan.islands.members[plan.islands.list[number].members.clone()];
    contacts
        .in_reach(&Places::all(&mut world.particles), number, rows, InstructionSet::best())
        .0
        .to_vec()
}

#[test]
fn only_rows_that_may_touch_something_are_tested() {
    let mut world = hung();
    world.boundaries.planes.push(Plane::ground(0.0));
    world.colliders.push(ball(Vec3::new(0.0, 30.0, 0.0)));
    assert_eq!(tested_rows(&mut world), [0; 0], "nothing is near");
    // In front of its lower edge, which is at 2.5 m.
    world.colliders.push(ball(Vec3::new(0.0, 2.4, 0.15)));
    let near = tested_rows(&mut world);
    assert!(!near.is_empty() && near.len() < 100, "{}", near.len());
    assert!(near.iter().all(|&row| row >= 10 * 21), "{near:?}");
    // A ground just below it is near its lowest row, too.
    world.boundaries.planes.push(Plane::ground(2.495));
    let low = tested_rows(&mut world);
    assert!(low.len() < 100 && (20 * 21..21 * 21).all(|row| low.contains(&row)), "{low:?}");
    world.boundaries.planes.pop();
    world.boundaries.plane_constraint = Plane::new(Vec3::ZERO, Vec3::Z);
    assert_eq!(tested_rows(&mut world).len(), 21 * 21, "a world in 2D");
}

#[test]
fn what_is_out_of_reach_changes_no_bit() {
    let run = |mut world: Simulation| -> Vec<Vec3> {
        (0..60).for_each(|_| {
            world.step(1.0 / 60.0).unwrap();
        });
        (0..world.particles.len()).map(|i| world.particles.position(i)).collect()
    };
    let alone = run(hung());
    let mut world = hung();
    world.boundaries.planes.push(Plane::ground(0.0));
    world.boundaries.boxes.push(crate::InsideBox::new(Vec3::splat(-9.0), Vec3::splat(9.0)));
    world.colliders.push(ball(Vec3::new(0.0, -5.0, 0.0)));
    assert_eq!(run(world), alone);
}

#[test]
fn what_is_flung_out_of_reach_touches_what_is_there() {
    for plate in [false, true] {
        let mut world = hung();
        if plate {
            let thin = Shape::cuboid(Vec3::new(4.0, 0.01, 4.0)).unwrap();
            world.colliders.push(Collider::fixed(thin, Frame::IDENTITY));
        } else {
            world.boundaries.planes.push(Plane::ground(0.0));
        }
        // Without its rods, so that nothing holds it back.
        let last = world.particles.len() - 1;
        world.distances_mut().retain(|d| d.a as usize != last && d.b as usize != last);
        let substeps = world.begin_step(1.0 / 60.0).unwrap();
        for substep in 0..substeps {
            world.begin_substep();
            world.accumulate_forces();
            if substep == 3 {
                world.particles.set_velocity(last, Vec3::Y * -3000.0);
            }
            world.integrate();
            world.solve_constraints();
        }
        world.end_step();
        assert!(world.particles.position(last).y > 0.0, "{}", world.particles.position(last));
    }
}

/// Boxes of particles that fall side by side onto a level ground at a height of 0, each with its own contact settings.
fn falling(contacts: impl Fn(u32) -> BodyContacts) -> Simulation {
    let mut world = Simulation::default();
    let cube = box_3d(&BoxSpec::default()).unwrap();
    for i in 0..24 {
        let at = Vec3::new(2.0 * i as f32, 0.8, 0.0);
        let turned = glam::Quat::from_xyzw(0.1, 0.2, 0.3, 1.0).normalize();
        let cube = cube.transformed(turned, at);
        cube.build(&mut world).unwrap();
        let rows = world.particles.len() - 8..world.particles.len();
        for row in rows {
            world.particles.set_velocity(row, Vec3::X * 2.0);
            world.particles.set_body(row, Some(i));
        }
        world.contacts.push(contacts(i));
    }
    world
}

/// Positions after 40 steps.
fn run(world: &mut Simulation) -> Vec<Vec3> {
    for _ in 0..40 {
        world.step(1.0 / 60.0).unwrap();
    }
    (0..world.particles.len()).map(|i| world.particles.position(i)).collect()
}

fn level() -> Collider {
    Collider::fixed(Shape::half_space(), Frame::IDENTITY)
}

fn room() -> Collider {
    let size = Vec3::new(200.0, 40.0, 200.0);
    Collider::fixed(Shape::inside_box(size).unwrap(), Frame::at(Vec3::Y * 20.0))
}

/// Whether these boxes can be solved in instance batches. Temporal blocking of substeps must be possible in any case.
fn plain(world: &mut Simulation, boxes: core::ops::Range<u32>) -> bool {
    world.begin_step(1.0 / 60.0).unwrap();
    assert!(world.is_undisturbed());
    let contacts = world.particle_contacts().clone();
    boxes.map(|i| contacts.of_batch(8 * i..8 * i + 8, 0..0)).all(|found| found.is_some())
}

#[test]
fn a_collider_that_is_a_plane_or_a_box_holds_as_a_boundary_does_to_the_bit_and_in_the_same_way() {
    let as_boundary = |box_: bool| {
        let mut world = falling(|_| BodyContacts::default());
        if box_ {
            let (min, max) = (Vec3::new(-100.0, 0.0, -100.0), Vec3::new(100.0, 40.0, 100.0));
            world.boundaries.boxes.push(crate::InsideBox::new(min, max));
        } else {
            world.boundaries.planes.push(Plane::ground(0.0));
        }
        world
    };
    for (box_, collider) in [(false, level()), (true, room())] {
        let mut world = falling(|_| BodyContacts::default());
        world.colliders.push(collider);
        assert_eq!(plain(&mut world.clone(), 0..24), !box_, "eight at a time, but in a box");
        let mut boundary = as_boundary(box_);
        assert_eq!(plain(&mut boundary.clone(), 0..24), !box_);
        assert!(run(&mut world) == run(&mut boundary), "box {box_}");
    }
}

#[test]
fn settings_of_one_body_change_no_bit_of_others() {
    let ice = Material { friction: 0.0, friction_rule: Combine::Min, ..Material::default() };
    let rubber = Material::default().with_restitution(0.8);
    let layers = Layers::new(2, 2);
    let settings = [
        BodyContacts { material: ice, ..BodyContacts::default() },
        BodyContacts { material: rubber, ..BodyContacts::default() },
        BodyContacts { layers, ..BodyContacts::default() },
        BodyContacts { events: true, ..BodyContacts::default() },
    ];
    for collider in [level(), room()] {
        let mut alike = falling(|_| BodyContacts::default());
        alike.colliders.push(collider.clone());
        let expected = run(&mut alike);
        for own in settings {
            // The last eight have different settings.
            let mut world = falling(|i| if i < 16 { BodyContacts::default() } else { own });
            world.colliders.push(collider.clone());
            let half_space = collider.shape == Shape::half_space();
            assert_eq!(plain(&mut world.clone(), 0..16), half_space);
            let found = run(&mut world);
            assert!(found[..16 * 8] == expected[..16 * 8], "{own:?}");
            let (theirs, others) = (&found[16 * 8..], &expected[16 * 8..]);
            let low = theirs.iter().map(|at| at.y).fold(f32::INFINITY, f32::min);
            let along = |list: &[Vec3]| list.iter().map(|at| at.x).sum::<f32>() / list.len() as f32;
            let far = along(theirs) - along(others);
            match own {
                _ if own.layers == layers => assert!(low < -0.5, "falls through: {low}"),
                _ if own.material == ice => assert!(far > 0.3 && low > -0.01, "slides: {far}"),
                _ if own.material == rubber => {
                    let high = theirs.iter().map(|at| at.y).sum::<f32>() / theirs.len() as f32;
                    assert!(high > 0.55 && low > -0.05, "bounces: {high} {low}");
                }
                _ => assert!(far.abs() < 0.05 && low > -0.01, "the same but for rounding: {far}"),
            }
        }
    }
}

#[test]
fn a_room_that_is_turned_moves_or_is_a_sensor_is_found_and_does_what_it_should() {
    let turned = Frame::new(Vec3::Y * 20.0, glam::Quat::from_xyzw(0.0, 1e-3, 0.0, 1.0));
    let up = Frame::at(Vec3::Y * 20.01);
    for (collider, holds) in [
        (Collider { start: turned, end: turned, ..room() }, true),
        (room().moving_to(up), true),
        (Collider { sensor: true, ..room() }, false),
        (Collider { layers: Layers::NONE, ..room() }, false),
    ] {
        let mut world = falling(|_| BodyContacts::default());
        world.colliders.push(collider.clone());
        for _ in 0..40 {
            world.step(1.0 / 60.0).unwrap();
            // It stops there.
            world.colliders[0].start = world.colliders[0].end;
        }
        let low = (0..world.particles.len()).map(|i| world.particles.position(i).y);
        let low = low.fold(f32::INFINITY, f32::min);
        assert!(if holds { low > -0.02 } else { low < -0.5 }, "{low} {collider:?}");
    }
}

/// A particle flung out of reach used to be tested against everything, whatever its layers, with the friction of the collider alone.
#[test]
fn what_is_flung_out_of_reach_keeps_its_layers() {
    for layers in [Layers::new(2, 2), Layers::default()] {
        let mut world = Simulation::default();
        for (body, at) in [(0, Vec3::ZERO), (1, Vec3::Z * 50.0)] {
            let row = world.particles.push(ParticleSeed::at(at).with_radius(0.1)).unwrap();
            world.particles.set_body(row as usize, Some(body));
            world.contacts.push(BodyContacts::default());
        }
        world.contacts[0].layers = layers;
        // One that is near, and one in its path.
        let meets = Layers::new(3, 3);
        world.colliders.push(Collider { layers: meets, ..ball(Vec3::Y * 0.5) });
        let wall = Shape::cuboid(Vec3::new(0.2, 10.0, 10.0)).unwrap();
        world.colliders.push(Collider::fixed(wall, Frame::at(Vec3::X * 5.0)));
        let substeps = world.begin_step(1.0 / 60.0).unwrap();
        for substep in 0..substeps {
            world.begin_substep();
            world.accumulate_forces();
            if substep == 3 {
                world.particles.set_velocity(0, Vec3::X * 6000.0);
            }
            world.integrate();
            world.solve_constraints();
        }
        world.end_step();
        let through = world.particles.position(0).x > 5.0;
        assert_eq!(through, layers != Layers::default(), "{}", world.particles.position(0));
    }
}

/// Shapes of every kind, with and without a closed form; some turned, some moving, one a sensor, some overlapping.
fn obstacles() -> Vec<Collider> {
    let turned = |at: Vec3| Frame::new(at, Quat::from_xyzw(0.3, -0.2, 0.5, 1.0));
    let moving = |shape: Shape, at: Vec3| {
        let end =
            Frame::new(at + Vec3::new(0.02, -0.03, 0.01), Quat::from_xyzw(0.3, -0.1, 0.5, 1.0));
        Collider::fixed(shape, turned(at)).moving_to(end)
    };
    let corners = [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_ONE].map(|corner| corner * 0.2);
    vec![
        Collider::fixed(Shape::half_space(), turned(Vec3::new(0.0, -0.3, 0.0))),
        ball(Vec3::new(0.3, 0.1, 0.2)),
        moving(Shape::sphere(0.15).unwrap(), Vec3::new(-0.3, 0.1, 0.2)),
        Collider::fixed(Shape::capsule(0.1, 0.3).unwrap(), turned(Vec3::new(0.0, 0.0, 0.3))),
        moving(Shape::cuboid(Vec3::new(0.3, 0.2, 0.1)).unwrap(), Vec3::new(0.2, 0.0, -0.2)),
        Collider::fixed(
            Shape::cuboid(Vec3::splat(0.25)).unwrap(),
            turned(Vec3::new(-0.2, 0.2, 0.0)),
        ),
        Collider::fixed(Shape::cylinder(0.15, 0.2).unwrap(), turned(Vec3::new(0.0, 0.1, -0.3))),
        Collider::fixed(Shape::hull(&corners).unwrap(), turned(Vec3::new(-0.3, -0.1, -0.3))),
        Collider { sensor: true, ..ball(Vec3::new(0.0, 0.2, 0.0)) },
    ]
}

/// Asserts that the island of the first row is projected to the same bits in batches and row by row; returns how many candidates touch something.
fn same_in_batches(world: &Simulation, round: u32) -> usize {
    let plan = world.plan();
    let number = plan.islands.of[0] as usize;
    let rows = &plan.islands.members[plan.islands.list[number].members.clone()];
    let ends = |batches: bool, instructions: InstructionSet| {
        let (mut particles, mut contacts) =
            (world.particles.clone(), world.particle_contacts().clone());
        assert!(contacts.has_batches(number), "there is something to compare");
        if !batches {
            contacts.batches.clear();
        }
        let mut impulses = vec![NormalImpulse::default(); contacts.candidates.len()];
        let depth = contacts.project_island(
            &mut Places::all(&mut particles),
            &mut NormalImpulses::all(&mut impulses),
            (number, rows),
            (contacts.interval(round % 10, 0, 1), instructions),
        );
        let bits = |v: Vec3| v.to_array().map(f32::to_bits);
        let positions: Vec<_> = particles.position.iter().map(|q| bits(q.truncate())).collect();
        let sums: Vec<_> = impulses
            .iter()
            .map(|one| (bits(one.normal), bits(one.carried), one.depth.to_bits()))
            .collect();
        (depth.to_bits(), positions, sums)
    };
    let truth = ends(false, InstructionSet::Scalar);
    for set in InstructionSet::ALL {
        assert!(ends(true, set) == truth, "{set:?}, round {round}");
    }
    truth.2.iter().filter(|(_, _, sum)| *sum != 0).count()
}

/// Moves a row that is not pinned from where the substep begins.
fn move_row(world: &mut Simulation, row: usize, by: Vec3) {
    if world.particles.position[row].w > 0.0 {
        world.particles.start[row] = world.particles.position[row];
        world.particles.position[row] += by.extend(0.0);
    }
}

#[test]
fn rows_in_batches_end_where_each_of_them_would_one_by_one() {
    let mut random = Random::new(1);
    let mut place = || random.vector() * 0.5;
    let mut touched = 0;
    for round in 0..40 {
        let mut world = hung();
        world.forces.winds.clear();
        world.boundaries.planes.push(Plane::ground(-0.2).with_friction(0.4));
        world.colliders = obstacles();
        for row in 0..world.particles.len() {
            world.particles.set_position(row, place());
            // Fast particles get a wide margin, so that none of them exceeds it.
            world.particles.set_velocity(row, place() * 300.0);
        }
        world.begin_step(1.0 / 60.0).unwrap();
        for row in 0..world.particles.len() {
            // Some move far, through thin shapes, and most hardly at all.
            let to = place();
            move_row(&mut world, row, if row % 7 == 0 { to } else { to * 0.02 });
        }
        touched += same_in_batches(&world, round);
    }
    // Of an overlap from before the substep only a part is corrected in it.
    assert!(touched > 2000, "{touched} contacts were compared");
}

/// A heightfield and a mesh of hills, turned.
fn terrains() -> [Shape; 2] {
    let height = |i: u32| 0.1 * libm::sinf(0.9 * (i % 10) as f32) * libm::cosf((i / 10) as f32);
    let heights: Vec<f32> = (0..100).map(height).collect();
    let field = Shape::height_field(10, 10, &heights, Vec3::new(2.0, 1.0, 2.0)).unwrap();
    let vertices = (0..100)
        .map(|i| Vec3::new(0.2 * (i % 10) as f32 - 0.9, height(i), 0.2 * (i / 10) as f32 - 0.9));
    let cells = (0..90).filter(|i| i % 10 < 9);
    let triangles = cells.flat_map(|i| [[i, i + 10, i + 1], [i + 10, i + 11, i + 1]]);
    [field, Shape::mesh(vertices.collect(), triangles.collect()).unwrap()]
}

#[test]
fn rows_on_a_terrain_end_in_batches_where_each_of_them_would_one_by_one() {
    let mut random = Random::new(2);
    for terrain in terrains() {
        let (mut touched, mut faces) = (0, 0);
        for round in 0..20 {
            let mut world = hung();
            world.forces.winds.clear();
            let frame = Frame::new(Vec3::new(0.3, -0.2, 0.1), Quat::from_xyzw(0.2, 0.1, -0.1, 1.0));
            world.colliders = vec![Collider::fixed(terrain.clone(), frame)];
            for row in 0..world.particles.len() {
                let nearest = terrain.nearest(random.vector() * Vec3::new(0.8, 0.1, 0.8));
                let above = world.particles.radius[row] + 0.004 * random.number();
                let at = frame.point(nearest.point + nearest.normal * above);
                world.particles.set_position(row, at);
                world.particles.set_velocity(row, random.vector() * 0.2);
            }
            world.begin_step(1.0 / 60.0).unwrap();
            faces += world.particle_contacts().faces.len();
            for row in 0..world.particles.len() {
                move_row(&mut world, row, random.vector() * 0.002);
            }
            touched += same_in_batches(&world, round);
        }
        assert!(touched > 400 && faces > 400, "{touched} contacts, {faces} faces were compared");
    }
}
