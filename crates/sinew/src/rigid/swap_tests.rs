//! From particles to a body and back: what must be preserved, for any compound.

use glam::{DVec3, Quat, Vec3};

use super::*;
use crate::pose::{Motion, motion};
use crate::test_random::Random;
use crate::{Distance, ParticleSeed, Simulation};

impl Random {
    fn any_rotation(&mut self) -> Quat {
        let q = [self.number(), self.number(), self.number(), self.number() + 0.1];
        let length = q.iter().map(|x| x * x).sum::<f32>().sqrt();
        Quat::from_array(q.map(|x| x / length))
    }
}

/// A rigid compound: rest positions, and present positions, velocities and masses of its particles.
struct Compound {
    rest: Vec<Vec3>,
    now: Vec<(Vec3, Vec3, f32)>,
    rotation: Quat,
}

/// 4 to 20 particles of random masses, anywhere in the rest frame, scaled by `shape`, turned, moved and spinning.
fn random(random: &mut Random, shape: Vec3) -> Compound {
    let count = 4 + (random.number().abs() * 17.0) as usize;
    let (aside, tilt) = (random.vector() * 2.0, random.any_rotation());
    let rest: Vec<Vec3> = (0..count).map(|_| turn(tilt, random.vector() * shape) + aside).collect();
    let (rotation, place) = (random.any_rotation(), random.vector());
    let (velocity, spin) = (random.vector() * 5.0, random.vector() * 8.0);
    let point = |r: &Vec3| {
        let p = turn(rotation, *r) + place;
        (p, velocity + spin.cross(p), 0.1 + random.number().abs() * 3.0)
    };
    let now = rest.iter().map(point).collect();
    Compound { rest, now, rotation }
}

fn turn(q: Quat, v: Vec3) -> Vec3 {
    let q = DQuat::from_array(q.to_array().map(f64::from)).normalize();
    (q * v.as_dvec3()).as_vec3()
}

/// Momentum and angular momentum about the origin, and the scales for their errors.
fn momenta(points: &[(Vec3, Vec3, f32)]) -> (DVec3, DVec3, f64, f64) {
    let (mut p, mut l, mut p_size, mut l_size) = (DVec3::ZERO, DVec3::ZERO, 0.0, 0.0);
    for (x, v, m) in points {
        let each = v.as_dvec3() * f64::from(*m);
        p += each;
        l += x.as_dvec3().cross(each);
        p_size += each.length();
        l_size += x.as_dvec3().length() * each.length();
    }
    (p, l, p_size, l_size)
}

fn body(compound: &Compound, previous: Quat) -> RigidBody {
    let points = compound.now.iter().copied();
    RigidBody::from_particles(Vec3::ZERO, points, &compound.rest, previous).unwrap()
}

fn placed(body: &RigidBody, compound: &Compound) -> Vec<(Vec3, Vec3, f32)> {
    let masses = compound.now.iter().map(|&(_, _, m)| m);
    body.place(&compound.rest).zip(masses).map(|((p, v), m)| (p, v, m)).collect()
}

/// The largest relative changes by a swap to the body and back: of P, L, positions and velocities.
fn there_and_back(compound: &Compound) -> [f64; 4] {
    let body = body(compound, compound.rotation);
    let after = placed(&body, compound);
    let (p, l, p_size, l_size) = momenta(&compound.now);
    let (p2, l2, ..) = momenta(&after);
    // The body has the same momenta while it is one.
    assert!((body.momentum() - p).length() < 1e-5 * p_size);
    let off = (body.angular_momentum_about_zero() - l).length() / l_size;
    assert!(off < 1e-5, "{off} {body:?}");
    let size = compound.now.iter().fold(1.0, |s: f32, (x, ..)| s.max(x.length()));
    let speed = compound.now.iter().fold(1.0, |s: f32, (_, v, _)| s.max(v.length()));
    let worst = |of: fn(&(Vec3, Vec3, f32)) -> Vec3, by: f32| {
        let pairs = after.iter().zip(&compound.now);
        pairs.fold(0.0, |w: f64, (a, b)| w.max(f64::from((of(a) - of(b)).length() / by)))
    };
    [
        (p2 - p).length() / p_size,
        (l2 - l).length() / l_size,
        worst(|x| x.0, size),
        worst(|x| x.1, speed),
    ]
}

#[test]
fn random_compounds_are_the_same_after_a_swap_there_and_back() {
    for (shape, name) in [(Vec3::ONE, "solid"), (Vec3::new(1.0, 1.0, 0.0), "flat")] {
        let (mut source, mut worst) = (Random::new(3), [0.0_f64; 4]);
        for _ in 0..500 {
            let off = there_and_back(&random(&mut source, shape));
            worst = std::array::from_fn(|i| worst[i].max(off[i]));
        }
        println!("{name}: P, L, position, velocity {worst:?}");
        assert!(worst.iter().all(|&off| off < 1e-5), "{name}: {worst:?}");
    }
}

#[test]
fn collinear_compounds_keep_all_but_a_spin_about_their_line_which_particles_cannot_have() {
    let (mut source, mut worst) = (Random::new(5), [0.0_f64; 4]);
    for _ in 0..500 {
        let off = there_and_back(&random(&mut source, Vec3::X));
        worst = std::array::from_fn(|i| worst[i].max(off[i]));
    }
    println!("collinear: P, L, position, velocity {worst:?}");
    assert!(worst.iter().all(|&off| off < 1e-5), "{worst:?}");

    let rest = [-Vec3::X, Vec3::X];
    let rod = [(-Vec3::X, Vec3::ZERO, 1.0), (Vec3::X, Vec3::ZERO, 1.0)];
    let mut rod =
        RigidBody::from_particles(Vec3::ZERO, rod.into_iter(), &rest, Quat::IDENTITY).unwrap();
    rod.angular_velocity = Vec3::new(9.0, 1.0, 0.0);
    let now = rod.place(&rest).map(|(p, v)| (p, v, 1.0));
    let back = RigidBody::from_particles(Vec3::ZERO, now, &rest, Quat::IDENTITY).unwrap();
    assert!((back.angular_velocity - Vec3::Y).length() < 1e-6, "{}", back.angular_velocity);
}

#[test]
fn a_single_particle_keeps_its_momentum_and_the_rotation_that_it_had() {
    let (rest, previous) = ([Vec3::new(1.0, 2.0, 3.0)], Quat::from_xyzw(0.6, 0.0, 0.0, 0.8));
    let particle = (Vec3::new(4.0, 5.0, 6.0), Vec3::new(-1.0, 0.5, 2.0), 3.0);
    let body =
        RigidBody::from_particles(Vec3::ZERO, [particle].into_iter(), &rest, previous).unwrap();
    assert!((body.rotation - previous).length() < 1e-6);
    assert_eq!((body.angular_velocity, body.inertia), (Vec3::ZERO, Mat3::ZERO));
    assert_eq!(body.place(&rest).next(), Some((particle.0, particle.1)));
}

#[test]
fn the_body_moves_as_the_particles_say_and_its_frame_is_theirs() {
    let mut source = Random::new(11);
    for _ in 0..200 {
        let compound = random(&mut source, Vec3::ONE);
        let body = body(&compound, Quat::IDENTITY);
        let Motion { mass, barycentre, velocity, angular_velocity, inertia } =
            motion(compound.now.iter().copied()).unwrap();
        assert!((body.mass - mass).abs() <= 1e-6 * mass);
        assert!((body.position - barycentre).length() < 1e-6);
        assert!((body.velocity - velocity).length() < 1e-5);
        assert!((body.angular_velocity - angular_velocity).length() < 1e-3);
        let size = inertia.x_axis.length() + inertia.y_axis.length() + inertia.z_axis.length();
        let off = body.world_inertia().as_mat3() - inertia;
        assert!(off.to_cols_array().iter().all(|x| x.abs() < 1e-5 * size), "{off}");
        for (r, (p, ..)) in compound.rest.iter().zip(&compound.now) {
            assert!((body.pose().point(*r) - *p).length() < 2e-6 * (1.0 + r.length()));
        }
    }
}

#[test]
fn corners_of_a_box_become_a_body_three_times_as_hard_to_turn_as_the_solid() {
    let size = Vec3::new(1.0, 2.0, 3.0);
    let side = |i: u8| f32::from(i & 1) - 0.5;
    let rest: Vec<Vec3> =
        (0..8).map(|i| Vec3::new(side(i), side(i >> 1), side(i >> 2)) * size).collect();
    let points = rest.iter().map(|&r| (r, Vec3::ZERO, 0.5));
    let body = RigidBody::from_particles(Vec3::ZERO, points, &rest, Quat::IDENTITY).unwrap();
    let solid = RigidBody::solid_box(size, 4.0).inertia * 3.0;
    assert!(body.inertia.abs_diff_eq(solid, 1e-5), "{} {solid}", body.inertia);
}

#[test]
fn a_hundred_swaps_in_a_row_drift_no_more_than_round_off() {
    let mut source = Random::new(17);
    for shape in [Vec3::ONE, Vec3::new(1.0, 1.0, 0.0), Vec3::X] {
        let (mut positions, mut p_drift, mut l_drift) = (0.0_f32, 0.0_f64, 0.0_f64);
        for _ in 0..50 {
            let mut compound = random(&mut source, shape);
            let first = compound.now.clone();
            let mut rotation = compound.rotation;
            for _ in 0..100 {
                let body = body(&compound, rotation);
                rotation = body.rotation;
                compound.now = placed(&body, &compound);
            }
            let (p, l, p_size, l_size) = momenta(&first);
            let (p2, l2, ..) = momenta(&compound.now);
            p_drift = p_drift.max((p2 - p).length() / p_size);
            l_drift = l_drift.max((l2 - l).length() / l_size);
            for ((a, ..), (b, ..)) in compound.now.iter().zip(&first) {
                positions = positions.max((*a - *b).length());
            }
        }
        println!("{shape}: position {positions:.1e} m, P {p_drift:.1e}, L {l_drift:.1e}");
        assert!(positions < 1e-4 && p_drift < 1e-5 && l_drift < 1e-5);
    }
}

#[test]
fn a_compound_in_a_simulation_far_away_becomes_a_body_flies_on_and_comes_back() {
    let far = Vec3::new(5000.0, 200.0, -7000.0);
    let rest = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::new(0.25, 0.125, 1.0)];
    let build = |origin: Vec3| {
        let mut world = Simulation::default();
        for (i, r) in rest.iter().enumerate() {
            let seed = ParticleSeed::at(origin + *r).with_mass(1.0 + i as f32);
            let velocity = Vec3::new(1.0, 3.0, 0.5) + Vec3::new(1.0, 2.0, -3.0).cross(*r);
            world.particles.push(seed.with_velocity(velocity)).unwrap();
        }
        for a in 0..4 {
            for b in a + 1..4 {
                let length = rest[a as usize].distance(rest[b as usize]);
                world.distances_mut().push(Distance::new(a, b, length));
            }
        }
        world
    };
    let fly = |origin: Vec3| {
        let (mut world, rows) = (build(origin), [0, 1, 2, 3]);
        let body = |world: &Simulation| {
            RigidBody::from_rows(&world.particles, &rows, &rest, Quat::IDENTITY).unwrap()
        };
        for _ in 0..30 {
            world.step(1.0 / 60.0).unwrap();
        }
        let mut flying = body(&world);
        let before = flying;
        let at = |world: &Simulation| rows.map(|i| world.particles.relative_to(i, origin));
        let stood = at(&world);
        flying.write_rows(&mut world.particles, &rows, &rest).unwrap();
        let jump = stood.iter().zip(at(&world)).map(|(a, b)| (*a - b).length());
        // The swap removes the rods' own error, and changes nothing else.
        assert!(jump.fold(0.0, f32::max) < 1e-4);
        for _ in 0..120 {
            let weight = Vec3::NEG_Y * 9.81 * flying.mass;
            flying.step(weight, Vec3::ZERO, 1.0 / 240.0, RigidIntegrator::Verlet).unwrap();
        }
        flying.write_rows(&mut world.particles, &rows, &rest).unwrap();
        let after = RigidBody { origin: flying.origin, ..body(&world) };
        assert!((after.momentum() - flying.momentum()).length() < 1e-4);
        assert!((after.angular_momentum() - flying.angular_momentum()).length() < 1e-4);
        assert!((after.angular_momentum() - before.angular_momentum()).length() < 1e-4);
        assert!(after.rotation.dot(flying.rotation).abs() > 1.0 - 1e-6);
        for _ in 0..30 {
            world.step(1.0 / 60.0).unwrap();
        }
        at(&world)
    };
    let (here, there) = (fly(Vec3::ZERO), fly(far));
    for (a, b) in here.iter().zip(&there) {
        // Less than the spacing of f32 out there, 0.5 mm.
        assert!((*a - *b).length() < 4e-4, "{a} {b}");
    }
}

#[test]
fn what_makes_no_body_is_refused() {
    let point = (Vec3::X, Vec3::Y, 1.0);
    let from = |points: &[(Vec3, Vec3, f32)], rest: &[Vec3]| {
        RigidBody::from_particles(Vec3::ZERO, points.iter().copied(), rest, Quat::IDENTITY)
    };
    assert_eq!(from(&[], &[]), Err(RigidFault::Particles));
    assert_eq!(from(&[point], &[]), Err(RigidFault::Particles));
    assert_eq!(from(&[(Vec3::X, Vec3::Y, f32::INFINITY)], &[Vec3::X]), Err(RigidFault::Particles));
    for bad in [(Vec3::NAN, Vec3::Y, 1.0), (Vec3::Y, Vec3::INFINITY, 1.0)] {
        assert!(from(&[point, bad], &[Vec3::X, Vec3::Y]).is_err());
    }
    assert!(from(&[point, point], &[Vec3::X, Vec3::NAN]).is_err());
    assert!(from(&[(Vec3::X, Vec3::Y, 0.0), point], &[Vec3::X, Vec3::Y]).is_ok());

    let mut world = Simulation::default();
    world.particles.push(ParticleSeed::at(Vec3::ONE)).unwrap();
    let body = RigidBody::default();
    for (rows, rest) in [(vec![0, 1], vec![Vec3::X; 2]), (vec![0], vec![Vec3::X; 2])] {
        let written = body.write_rows(&mut world.particles, &rows, &rest);
        assert_eq!(written, Err(RigidFault::Particles));
    }
    assert!(RigidBody::from_rows(&world.particles, &[1], &[Vec3::X], Quat::IDENTITY).is_err());
    assert_eq!(world.particles.position(0), Vec3::ONE);
}
