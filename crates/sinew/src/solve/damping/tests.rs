//! Relative motion within a body is damped, and its overall motion is kept.

use glam::{DVec3, Quat, Vec3};

use crate::collide::{BodyContacts, Collider, Frame, Shape};
use crate::recipes::{RagdollSpec, ragdoll};
use crate::{BodySettings, Distance, ParticleSeed, Simulation, Sleep, Spring};

/// Momentum, and angular momentum about the origin.
fn momenta(world: &Simulation) -> (DVec3, DVec3) {
    let particles = &world.particles;
    (0..particles.len()).fold((DVec3::ZERO, DVec3::ZERO), |(p, l), i| {
        let gained = particles.velocity(i).as_dvec3() * f64::from(particles.mass(i));
        (p + gained, l + particles.position(i).as_dvec3().cross(gained))
    })
}

/// A body of particles without constraints, at these places, without gravity.
fn loose(particles: &[(Vec3, Vec3, f32)], damping: f32) -> Simulation {
    let mut world = Simulation::default();
    world.forces.gravity = Vec3::ZERO;
    world.bodies.push(BodySettings { damping, ..BodySettings::default() });
    for &(place, velocity, mass) in particles {
        let seed = ParticleSeed::at(place).with_mass(mass);
        let row = world.particles.push(seed.with_velocity(velocity)).unwrap();
        world.particles.set_body(row as usize, Some(0));
    }
    world
}

#[test]
fn what_goes_on_inside_dies_away_at_its_rate() {
    // Uniform expansion is no motion of a rigid body.
    let corners = [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y];
    let going = Vec3::new(3.0, -1.0, 2.0);
    let grows = corners.map(|corner| (corner, going + corner, 2.0));
    let mut world = loose(&grows, 2.0);
    for _ in 0..60 {
        world.step(1.0 / 60.0).unwrap();
    }
    for (i, corner) in corners.into_iter().enumerate() {
        let wanted = going + corner * libm::expf(-2.0);
        let off = world.particles.velocity(i).distance(wanted);
        assert!(off < 1e-5, "{i}: {} for {wanted}", world.particles.velocity(i));
    }
}

#[test]
fn neither_momentum_changes() {
    let mut some = [(Vec3::ZERO, Vec3::ZERO, 1.0); 7];
    for (i, (place, velocity, mass)) in some.iter_mut().enumerate() {
        let i = i as f32;
        *place = Vec3::new(libm::sinf(i), libm::cosf(2.3 * i), libm::sinf(5.1 * i + 1.0)) * 3.0;
        *velocity = Vec3::new(libm::cosf(1.7 * i), libm::sinf(0.9 * i), libm::cosf(4.0 * i)) * 2.0;
        *mass = 1.0 + i;
    }
    let mut world = loose(&some, 5.0);
    let (p, l) = momenta(&world);
    for _ in 0..30 {
        world.step(1.0 / 60.0).unwrap();
    }
    let (now_p, now_l) = momenta(&world);
    assert!((now_p - p).length() < 1e-5 * p.length(), "{p} {now_p}");
    assert!((now_l - l).length() < 1e-4 * l.length(), "{l} {now_l}");
}

#[test]
fn a_figure_falls_and_spins_as_without() {
    let fallen = |damping: f32| {
        let mut world = Simulation::default();
        let doll = ragdoll(&RagdollSpec { damping, ..RagdollSpec::default() }).unwrap();
        let rows = doll.build(&mut world).unwrap();
        for i in rows {
            let arm = world.particles.position(i) - Vec3::Y;
            world.particles.set_velocity(i, Vec3::X * 3.0 + Vec3::Y.cross(arm) * 2.0);
        }
        let mass: f64 =
            (0..world.particles.len()).map(|i| f64::from(world.particles.mass(i))).sum();
        for _ in 0..60 {
            world.step(1.0 / 60.0).unwrap();
        }
        let (p, _) = momenta(&world);
        p / mass
    };
    let (with, without) = (fallen(20.0), fallen(0.0));
    assert!((with - without).length() < 1e-4, "{with} {without}");
}

/// The two halves of a body that was cut apart, one of which flew off at 10 m/s without gravity, still dragged each other along over any distance: after a
/// second at the rate of 5/s both went at 5.5 m/s. The same for a limb that was held by springs alone. Beside a piece, single particles of the body are
/// another one.
#[test]
fn what_has_come_off_a_body_flies_off_undamped() {
    for by_springs in [false, true] {
        let places: Vec<_> = (0..11).map(|i| (Vec3::Y * i as f32, Vec3::ZERO, 1.0)).collect();
        let mut world = loose(&places, 5.0);
        for i in 0..10 {
            let spring = Spring { a: i, b: i + 1, rest: 1.0, stiffness: 100.0, damping: 0.0 };
            if by_springs {
                world.forces.springs.push(spring);
            } else {
                world.extend_distances([Distance::new(i, i + 1, 1.0)]);
            }
        }
        let run = |world: &mut Simulation| {
            for i in 0..11 {
                let bent = Vec3::Z * (i % 2) as f32;
                let away = if i > 4 { Vec3::X * 10.0 } else { Vec3::ZERO };
                world.particles.set_velocity(i, bent + away);
            }
            for _ in 0..120 {
                world.step(1.0 / 60.0).unwrap();
            }
            let mean = |mut rows: core::ops::Range<usize>| {
                let count = rows.len() as f32;
                rows.try_fold(Vec3::ZERO, |sum, i| Some(sum + world.particles.velocity(i) / count))
            };
            [mean(0..5), mean(5..11)].map(|v| v.unwrap().x)
        };
        let whole = run(&mut world.clone());
        assert!((whole[1] - whole[0]).abs() < 9.0, "{whole:?}");
        if by_springs {
            world.forces.springs.remove(4);
        } else {
            world.remove_distance(4);
        }
        let [here, away] = run(&mut world);
        assert!(here.abs() < 1e-4 && (away - 10.0).abs() < 1e-4, "{by_springs}: {here} {away}");
        // Each piece is still damped.
        let relative = world.particles.velocity(1) - world.particles.velocity(2);
        assert!(relative.length() < 0.1, "{by_springs}: {relative}");
    }
}

#[test]
fn what_is_no_number_damps_nothing() {
    let mut world = loose(&[(Vec3::ZERO, Vec3::X, 1.0), (Vec3::X, Vec3::Y, 1.0)], f32::NAN);
    world.step(1.0 / 60.0).unwrap();
    assert_eq!(world.particles.velocity(0), Vec3::X);
    let mut world = loose(&[(Vec3::ZERO, Vec3::X, 1.0), (Vec3::X, Vec3::Y, 1.0)], 1.0);
    world.particles.set_velocity(1, Vec3::NAN);
    world.step(1.0 / 60.0).unwrap();
    assert_eq!(world.particles.velocity(0), Vec3::X);
}

/// The head of a figure that hung over the edge of a step swung from its neck by 4 cm for minutes, and a quarter of all figures that were thrown onto stairs
/// never fell asleep.
#[test]
fn figures_that_lie_on_stairs_fall_asleep() {
    let mut world = Simulation::default();
    let stair = Shape::cuboid(Vec3::new(1.0, 10.0, 40.0)).unwrap();
    for n in 0..40 {
        let place = Vec3::new(n as f32 - 10.5, -0.2 * (n as f32 - 10.0) - 5.0, 0.0);
        world.colliders.push(Collider::fixed(stair.clone(), Frame::at(place)));
    }
    let doll = ragdoll(&RagdollSpec::default()).unwrap();
    let own = BodyContacts { with_bodies: true, with_itself: true, ..BodyContacts::default() };
    for n in 1..20 {
        let n = n as f32;
        let turned = Quat::from_rotation_y(0.3 * n) * Quat::from_rotation_x(0.1 * n);
        let doll = doll.transformed(turned, Vec3::new(0.0, 3.0, 2.0 * n - 20.0));
        doll.build_colliding(&mut world, own).unwrap();
    }
    world.sleep.resize(19, Sleep::allowed());
    for _ in 0..20 * 60 {
        world.step(1.0 / 60.0).unwrap();
    }
    let asleep = world.sleep.iter().filter(|body| body.asleep).count();
    assert!(asleep >= 18, "{asleep} of 19");
}
