//! Where a bounce ends and rest begins: at twice the speed that the gravity on a body adds to it in a substep, whatever the gravity of the world.

use sinew::glam::{Quat, Vec3};
use sinew::recipes::{SolidShape, SolidSpec, solid};
use sinew::{
    Attractor, BodyContacts, Collider, Frame, Material, ParticleSeed, Plane, Shape, Simulation,
};

/// What lands on what.
const CASES: [(Thing, Ground); 8] = [
    (Thing::Particle, Ground::Collider),
    (Thing::Particle, Ground::Plane),
    (Thing::Particle, Ground::Particle),
    (Thing::Particle, Ground::Sheet),
    (Thing::Particle, Ground::Rigid),
    (Thing::Ball, Ground::Collider),
    (Thing::Box, Ground::Collider),
    (Thing::Ball, Ground::Rigid),
];

#[derive(Clone, Copy, Debug, PartialEq)]
enum Thing {
    Particle,
    Ball,
    Box,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Ground {
    Collider,
    Plane,
    Particle,
    Sheet,
    Rigid,
}

fn contacts() -> BodyContacts {
    let material = Material::default().with_friction(0.5).with_restitution(0.5);
    BodyContacts { material, with_bodies: true, ..Default::default() }
}

fn particle(world: &mut Simulation, seed: ParticleSeed) -> u32 {
    let row = world.particles.push(seed).unwrap();
    let body = world.bodies.len() as u32 - 1;
    world.particles.set_body(row as usize, Some(body));
    row
}

fn body(world: &mut Simulation, contacts: BodyContacts) {
    world.bodies.push(Default::default());
    world.contacts.push(contacts);
}

/// A thing of radius 0.1 whose lowest point is `height` above a ground at y = 0, with `velocity` downwards; returns its rows.
fn scene(
    world: &mut Simulation,
    (thing, ground): (Thing, Ground),
    (height, velocity): (f32, f32),
) -> core::ops::Range<usize> {
    let shape = |thing| match thing {
        Thing::Box => Shape::cuboid(Vec3::splat(0.2)).unwrap(),
        _ => Shape::sphere(0.1).unwrap(),
    };
    let rigid = |world: &mut Simulation, shape: Shape, at: Vec3, pinned: bool| {
        let spec = SolidSpec { shape: SolidShape::Collider(shape), ..Default::default() };
        let mut body = solid(&spec).unwrap().transformed(Quat::IDENTITY, at);
        (0..8).filter(|_| pinned).for_each(|particle| body.pin(particle).unwrap());
        body.build_colliding(world, contacts()).unwrap()
    };
    match ground {
        Ground::Collider => {
            let floor = Collider::fixed(Shape::half_space(), Frame::IDENTITY);
            world.colliders.push(floor.with_material(contacts().material));
        }
        Ground::Plane => world.boundaries.planes.push(Plane {
            friction: 0.5,
            restitution: 0.5,
            ..Plane::ground(0.0)
        }),
        Ground::Particle => {
            body(world, contacts());
            particle(world, ParticleSeed::at(Vec3::NEG_Y * 2.0).with_radius(2.0).pinned());
        }
        Ground::Sheet => {
            body(world, BodyContacts { surface: true, ..contacts() });
            let corner = |x, z| ParticleSeed::at(Vec3::new(x, -0.01, z)).with_radius(0.01).pinned();
            let corners = [(-1.0, -1.0), (0.0, 1.2), (1.0, -1.0)];
            let rows = corners.map(|(x, z)| particle(world, corner(x, z)));
            world.forces.surfaces.push(rows);
        }
        Ground::Rigid => {
            let cube = Shape::cuboid(Vec3::splat(2.0)).unwrap();
            rigid(world, cube, Vec3::NEG_Y, true);
        }
    }
    let at = Vec3::Y * (height + 0.1);
    let rows = if thing == Thing::Particle {
        body(world, contacts());
        let row = particle(world, ParticleSeed::at(at).with_radius(0.1)) as usize;
        row..row + 1
    } else {
        rigid(world, shape(thing), at, false)
    };
    rows.clone().for_each(|row| world.particles.set_velocity(row, Vec3::NEG_Y * velocity));
    rows
}

/// The greatest speed of some rows in twenty ticks after two seconds, m/s.
fn fastest_after_two_seconds(world: &mut Simulation, rows: core::ops::Range<usize>) -> f32 {
    let mut worst = 0.0_f32;
    for tick in 0..140 {
        world.step(1.0 / 60.0).unwrap();
        if tick >= 120 {
            let speeds = rows.clone().map(|row| world.velocity_now(row).length());
            worst = speeds.fold(worst, f32::max);
        }
    }
    worst
}

/// With a gravity scale of 3 each substep adds more than the threshold that followed from the world's gravity: what lay on the floor bounced for ever, at
/// 0.08 m/s.
#[test]
fn what_is_heavier_than_the_world_comes_to_rest() {
    for (case, (scale, substeps)) in CASES
        .into_iter()
        .flat_map(|case| [(1.0, 4), (3.0, 4), (3.0, 10), (3.0, 40), (12.0, 4)].map(|of| (case, of)))
    {
        let mut world = Simulation::default();
        world.settings.substeps = substeps;
        let rows = scene(&mut world, case, (0.05, 0.0));
        rows.clone().for_each(|row| world.particles.set_gravity_scale(row, scale));
        let worst = fastest_after_two_seconds(&mut world, rows.clone());
        let low = world.particles.position(rows.start).y;
        println!("{case:?}, scale {scale}, {substeps} substeps: {worst} m/s");
        assert!(worst < 1e-3 && low > -0.05, "{case:?}, {scale}, {substeps}: {worst}, {low}");
    }
}

/// The same on a planet: gravity of an attractor alone.
#[test]
fn what_an_attractor_alone_pulls_down_comes_to_rest() {
    for case in CASES {
        let mut world = Simulation::default();
        world.settings.substeps = 10;
        world.forces.gravity = Vec3::ZERO;
        // 10 m/s² at the ground.
        world.forces.attractors.push(Attractor::new(Vec3::NEG_Y * 100.0, 1e5));
        let rows = scene(&mut world, case, (0.05, 0.0));
        let worst = fastest_after_two_seconds(&mut world, rows);
        println!("{case:?}: {worst} m/s");
        assert!(worst < 1e-3, "{case:?}: {worst}");
    }
}

/// With a gravity scale of 0.1 the threshold was ten times too high: what came down with less did not bounce at all.
#[test]
fn what_is_lighter_than_the_world_still_bounces() {
    for (case, substeps) in CASES.into_iter().flat_map(|case| [4, 10].map(|of| (case, of))) {
        let h = 1.0 / 60.0 / substeps as f32;
        let mut world = Simulation::default();
        world.settings.substeps = 1;
        // Between the two thresholds, 2 and 20 times this.
        let each = 0.1 * 9.81 * h;
        let thrown = 15.0 * each;
        let rows = scene(&mut world, case, (2.3 * thrown * h, thrown));
        rows.clone().for_each(|row| world.particles.set_gravity_scale(row, 0.1));
        let mut up = 0.0_f32;
        for _ in 0..8 {
            world.step(h).unwrap();
            let velocity = rows.clone().map(|row| world.particles.velocity(row).y).sum::<f32>();
            up = up.max(velocity / rows.len() as f32);
        }
        println!("{case:?}, {substeps} substeps: up at {up} of {thrown} m/s");
        assert!(
            up > 0.5 * thrown - 2.0 * each && up < 0.5 * thrown + 3.0 * each,
            "{case:?}, {substeps}: up at {up} of {thrown} m/s"
        );
    }
}
