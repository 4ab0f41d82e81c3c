//! Impacts of particles, of rigid bodies, and of both with each other and with walls: one problem, whatever takes part.

use sinew::glam::{Quat, Vec3};
use sinew::{Collider, Frame, Material, Shape, Simulation};

use crate::contacts::{DT, run, throw};

fn elastic(restitution: f32) -> Material {
    Material::default().with_friction(0.0).with_restitution(restitution)
}

fn empty(substeps: u32) -> Simulation {
    let mut world = Simulation::default();
    world.settings.substeps = substeps;
    world.forces.gravity = Vec3::ZERO;
    world
}

/// Kinetic energy, J, and momentum, kg·m/s, from the mean velocities of the last substep.
fn sums(world: &Simulation) -> (f64, Vec3) {
    let particles = &world.particles;
    (0..particles.len()).fold((0.0, Vec3::ZERO), |(energy, momentum), i| {
        let (v, m) = (particles.velocity(i), particles.mass(i));
        (energy + f64::from(0.5 * m * v.length_squared()), momentum + v * m)
    })
}

/// The bits of the positions and velocities of some rows.
fn bits(world: &Simulation, rows: core::ops::Range<usize>) -> Vec<[[u32; 3]; 2]> {
    let particles = &world.particles;
    let of = |v: Vec3| v.to_array().map(f32::to_bits);
    rows.map(|i| [of(particles.position(i)), of(particles.velocity(i))]).collect()
}

/// Single particles bounced off body colliders one after the other, before the impacts of these and of particles among themselves were solved: what touched two
/// kinds of things in one substep lost energy, or gained it.
#[test]
fn particles_and_bodies_in_a_row_keep_energy_and_momentum() {
    let round = Shape::sphere(0.5).unwrap();
    let (particle, ball) = (None, Some(&round));
    let mut failures = Vec::new();
    for (name, row) in [
        ("a particle into balls", [particle, ball, ball, ball]),
        ("a ball into particles", [ball, particle, particle, particle]),
        ("a particle into both", [particle, particle, ball, particle]),
        ("a ball into both", [ball, particle, ball, ball]),
    ] {
        for (substeps, gap) in
            [4, 10, 40].into_iter().flat_map(|n| [(n, 0.0), (n, 1e-5), (n, 1e-3)])
        {
            let mut world = empty(substeps);
            for (k, &what) in row.iter().enumerate() {
                let at = if k == 0 { 0.0 } else { 2.0 + (k - 1) as f32 * (1.0 + gap) };
                let velocity = if k == 0 { Vec3::X * 2.0 } else { Vec3::ZERO };
                throw(&mut world, (what, 0.5), (Vec3::X * at, velocity), elastic(1.0));
            }
            let (energy, momentum) = sums(&world);
            run(&mut world, 2.0, DT);
            let (left, now) = sums(&world);
            let (left, off) = (left / energy, (now - momentum).length() / momentum.length());
            println!("{name}, {substeps} substeps, gaps of {gap}: {left} {off}");
            if (left - 1.0).abs() > 1e-3 || off > 1e-4 {
                failures.push((name, substeps, gap, left, off));
            }
        }
    }
    assert!(failures.is_empty(), "{failures:?}");
}

/// Thirty-two particles and as many balls of the same size between elastic walls.
fn gas(substeps: u32, restitution: f32) -> Simulation {
    let mut world = empty(substeps);
    let material = elastic(restitution);
    let room = Shape::inside_box(Vec3::ONE).unwrap();
    world.colliders.push(Collider::fixed(room, Frame::IDENTITY).with_material(elastic(1.0)));
    let round = Shape::sphere(0.08).unwrap();
    for i in 0..64_u32 {
        let place = |i: u32| 0.24 * (i % 4) as f32 - 0.36;
        let at = Vec3::new(place(i), place(i / 4), place(i / 16));
        let turn = i as f32 * 2.4;
        let velocity = Vec3::new(libm::cosf(turn), libm::sinf(turn), libm::sinf(turn * 1.7));
        let shape = ((i + i / 4 + i / 16) % 2 == 0).then_some(&round);
        throw(&mut world, (shape, 0.08), (at, velocity), material);
    }
    world
}

/// Particles bounced off bodies by themselves: what touched both and a wall in one substep gained or lost energy.
#[test]
fn a_gas_of_particles_and_bodies_keeps_its_energy() {
    let left = [4, 10, 40].map(|substeps| {
        let mut world = gas(substeps, 1.0);
        let (began, _) = sums(&world);
        run(&mut world, 10.0, DT);
        let left = sums(&world).0 / began;
        println!("{substeps} substeps: {left}");
        left
    });
    assert!(left.iter().all(|left| (0.99..1.01).contains(left)), "{left:?}");
}

#[test]
fn a_gas_at_one_half_gains_nothing() {
    for substeps in [4, 10, 40] {
        let mut world = gas(substeps, 0.5);
        let (began, _) = sums(&world);
        let (mut before, mut gained) = (began, 0.0_f64);
        for _ in 0..300 {
            world.step(DT).unwrap();
            let now = sums(&world).0;
            gained = gained.max(now / before - 1.0);
            before = now;
        }
        println!("{substeps} substeps: {} left, at most {gained} gained in a step", before / began);
        assert!(gained < 1e-4 && before < 0.5 * began, "{substeps}: {gained}, {}", before / began);
    }
}

/// A particle onto a ball that touches another one and a wall, at `at`.
fn cluster(world: &mut Simulation, at: Vec3, restitution: f32) {
    let round = Shape::sphere(0.5).unwrap();
    let material = elastic(restitution);
    for (x, y, what, speed) in [
        (0.5, 0.0, Some(&round), 0.0),
        (1.5, 0.0, Some(&round), 0.0),
        (2.45, 0.3, None, -3.0),
        (1.5, 1.0, None, 0.0),
        (0.52, -1.3, None, -2.0),
    ] {
        throw(world, (what, 0.5), (at + Vec3::new(x, y, 0.0), Vec3::X * speed), material);
    }
}

/// What takes part follows from what was changed, as in all other stages: nothing far away matters. A contact was solved again after a change of its own, so a
/// particle that bounced off a wall alone had other last bits if anything touched elsewhere.
#[test]
fn an_impact_elsewhere_changes_no_bit() {
    let results = [None, Some(0.0), Some(0.5), Some(1.0)].map(|beside| {
        let mut world = empty(10);
        let turned = Quat::from_rotation_arc(Vec3::Y, Vec3::X);
        let wall = Collider::fixed(Shape::half_space(), Frame::new(Vec3::ZERO, turned));
        world.colliders.push(wall.with_material(elastic(1.0)));
        throw(
            &mut world,
            (None, 0.5),
            (Vec3::new(0.52, 5.0, 0.0), Vec3::NEG_X * 1.7),
            elastic(0.8),
        );
        cluster(&mut world, Vec3::ZERO, 0.8);
        let rows = 0..world.particles.len();
        if let Some(restitution) = beside {
            cluster(&mut world, Vec3::Z * 20.0, restitution);
        }
        let mut seen = Vec::new();
        for _ in 0..20 {
            world.step(DT).unwrap();
            seen.push(bits(&world, rows.clone()));
        }
        assert!(world.particles.velocity(rows.end - 5).length() > 0.05, "the impact arrives");
        seen
    });
    assert!(results.iter().all(|one| *one == results[0]));
}

/// A contact was solved again after a change of its own, so a particle that bounced off a wall by itself had other last bits if anything touched elsewhere.
#[test]
fn a_bounce_off_a_wall_has_the_same_bits_whatever_touches_elsewhere() {
    let results = [0.1, -0.1].map(|gap| {
        let mut world = empty(10);
        let turned = Quat::from_rotation_arc(Vec3::Y, Vec3::new(0.3, 0.8, -0.5).normalize());
        let wall = Collider::fixed(Shape::half_space(), Frame::new(Vec3::ZERO, turned));
        world.colliders.push(wall.with_material(elastic(0.7).with_friction(0.3)));
        let material = elastic(0.6).with_friction(0.2);
        for i in 0..20 {
            let at = Vec3::new(0.3, 0.8, -0.5).normalize() * (0.5 + 0.01 * i as f32);
            let at = at + Vec3::new(0.8, -0.3, 0.0) * (3.0 * i as f32);
            let velocity = Vec3::new(-0.2, -1.3, 0.1 * i as f32);
            throw(&mut world, (None, 0.5), (at, velocity), material);
        }
        let rows = 0..world.particles.len();
        // Two balls approach each other, nearby in time and far away in space.
        for side in [-1.0, 1.0] {
            let at = Vec3::new(20.0, 300.0, 20.0 + side * (0.5 + gap));
            throw(&mut world, (None, 0.5), (at, Vec3::Z * (-0.1 * side)), elastic(1.0));
        }
        run(&mut world, 0.5, DT);
        bits(&world, rows)
    });
    assert!(results[0] == results[1]);
}

/// An impact on a body that nothing can move was passed on to all that touched it.
#[test]
fn an_impact_on_an_immovable_body_does_not_reach_what_else_it_carries() {
    let results = [false, true].map(|beside| {
        let mut world = Simulation::default();
        let slab = Shape::cuboid(Vec3::new(100.0, 1.0, 4.0)).unwrap();
        throw(&mut world, (Some(&slab), 0.0), (Vec3::Y * -0.5, Vec3::ZERO), elastic(0.8));
        for i in 0..world.particles.len() {
            let seed = world.particles.seed(i).pinned();
            world.particles.set(i, seed).unwrap();
        }
        let cube = Shape::cuboid(Vec3::ONE).unwrap();
        let mut drop = |x: f32, height: f32, spin: Vec3| {
            let (at, before) = (Vec3::new(x, height, 0.1 * height), world.particles.len());
            throw(&mut world, (Some(&cube), 0.0), (at, Vec3::NEG_Y * 3.0), elastic(0.8));
            for i in before..world.particles.len() {
                let arm = world.particles.position(i) - at;
                let velocity = world.particles.velocity(i) + spin.cross(arm);
                world.particles.set_velocity(i, velocity);
            }
            before..world.particles.len()
        };
        let mut rows = 0..0;
        for k in 0..12 {
            let spin = Vec3::new(0.3 * k as f32, 0.7, 1.0 - 0.2 * k as f32);
            rows = 8..drop(-40.0 + 3.0 * k as f32, 0.9 + 0.05 * k as f32, spin).end;
        }
        if beside {
            for k in 0..16 {
                let (x, height) = (20.0 + (k / 4) as f32 * 2.0, 0.6 + 1.02 * (k % 4) as f32);
                drop(x, height, Vec3::new(0.1, 0.3, -0.1 * k as f32));
            }
        }
        run(&mut world, 1.0, DT);
        bits(&world, rows)
    });
    assert!(results[0] == results[1]);
}

/// The slip of a particle on a cube was 1e-31 m/s, whose square is zero: its friction, divided by nothing, was 1e7 N·s.
#[test]
fn a_column_of_cubes_and_particles_with_friction_stays_in_its_room() {
    let mut world = Simulation::default();
    let material = Material::default().with_restitution(0.3);
    let room = Shape::inside_box(Vec3::new(2.0, 20.0, 2.0)).unwrap();
    world.colliders.push(Collider::fixed(room, Frame::IDENTITY).with_material(material));
    let cube = Shape::cuboid(Vec3::splat(0.2)).unwrap();
    for i in 0..6 {
        let at = Vec3::new(-0.75, -9.5 + 0.3 * i as f32, -0.75);
        let shape = (i % 3 == 0).then_some(&cube);
        throw(&mut world, (shape, 0.1), (at, Vec3::new(0.1, -1.0, 0.05)), material);
    }
    for _ in 0..120 {
        world.step(DT).unwrap();
        let farthest = (0..world.particles.len()).map(|i| world.particles.position(i).length());
        assert!(farthest.fold(0.0, f32::max) < 10.2);
    }
}
