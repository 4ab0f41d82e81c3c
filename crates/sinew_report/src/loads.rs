//! Rows K7, K8 and K10: stacks, bodies at rest, and slopes.

use sinew::glam::{Quat, Vec3};
use sinew::recipes::{BoxSpec, RopeSpec, box_3d, rope};
use sinew::{BodyContacts, Collider, Frame, GradientAt, Material, ParticleSeed, Shape, Simulation};

use crate::Row;
use crate::case::cases;
use crate::measure::{G, TICK, largest, step, steps};

cases! {
    "K7" light_cubes_carry_heavy_ones;
    "K8" bodies_at_rest_have_no_velocity_and_a_pendulum_has_the_exact_one;
    "K10" what_lies_on_a_slope_slides_if_and_only_if_it_is_steeper_than_its_friction;
}

fn on_a_floor(substeps: u32) -> Simulation {
    let mut world = Simulation::default();
    world.settings.substeps = substeps;
    world.colliders.push(Collider::fixed(Shape::half_space(), Frame::IDENTITY));
    world
}

/// Adds a cube of 1 m with its centre at `height` metres.
fn add_cube(world: &mut Simulation, mass: f32, height: f32) {
    let spec = BoxSpec { mass, ..BoxSpec::default() };
    let body = box_3d(&spec).expect("a sound box").transformed(Quat::IDENTITY, Vec3::Y * height);
    body.build_colliding(world, BodyContacts::default()).expect("room");
}

/// Mean height of some particles, metres.
fn height(world: &Simulation, rows: core::ops::Range<usize>) -> f64 {
    let count = rows.len() as f64;
    rows.map(|i| f64::from(world.particles.position(i).y)).sum::<f64>() / count
}

/// Cubes of 1 m stacked for 20 s: how far one of them was ever below its place, relative to the height of the stack. The report states their overlap, and does
/// not count as converged where that exceeds the tolerance.
fn light_cubes_carry_heavy_ones() -> Vec<Row> {
    let mut rows = Vec::new();
    for masses in [&[1.0, 1000.0][..], &[1.0, 100.0], &[1.0, 10.0, 100.0]] {
        for substeps in [4, 10, 40] {
            let mut world = on_a_floor(substeps);
            for (k, &mass) in masses.iter().enumerate() {
                add_cube(&mut world, mass, 0.5 + k as f32);
            }
            let mut sunk = 0.0_f64;
            let count = masses.len();
            for _ in 0..1200 {
                step(&mut world, TICK);
                let low = (0..count).map(|k| 0.5 + k as f64 - height(&world, 8 * k..8 * k + 8));
                sunk = largest(low.chain([sunk]));
            }
            let what = format!("sinking of cubes of {masses:?} kg, {substeps} substeps");
            rows.push(Row::at_most(what, "of their height", 0.01, sunk / count as f64));
            let (report, tolerance) = (world.report(), world.settings.tolerance);
            let deepest = (1..count)
                .map(|k| height(&world, 8 * k - 8..8 * k) + 1.0 - height(&world, 8 * k..8 * k + 8));
            let deepest = largest(deepest);
            rows.push(Row::absolute(
                "reported error minus actual overlap",
                "m",
                0.0,
                f64::from(report.error) - deepest,
                1e-5,
            ));
            let honest = report.converged == (report.error <= tolerance);
            rows.push(Row::at_least(
                "converged is reported if and only if within the tolerance",
                "",
                1.0,
                honest.into(),
            ));
        }
    }
    rows
}

/// Speeds from the fifth second to the tenth. The pendulum starts level and is 1 m long.
fn bodies_at_rest_have_no_velocity_and_a_pendulum_has_the_exact_one() -> Vec<Row> {
    let mut rows = Vec::new();
    for (substeps, most) in [(1, 1e-4), (4, 1e-4), (10, 1.2e-4), (40, 1e-3)] {
        let mut world = on_a_floor(substeps);
        add_cube(&mut world, 2.0, 0.5);
        let hangs = Vec3::new(3.0, 5.0, 0.0);
        let spec =
            RopeSpec { from: hangs, to: hangs - Vec3::Y, segments: 10, ..RopeSpec::default() };
        let hanging = RopeSpec { pin_start: true, ..spec };
        rope(&hanging).expect("a sound rope").build(&mut world).expect("room");
        let seed = ParticleSeed::at(Vec3::new(6.0, 0.1, 0.0)).with_radius(0.1);
        let ball = world.particles.push(seed).expect("a sound particle") as usize;
        let pivot = Vec3::new(10.0, 5.0, 0.0);
        let spec = RopeSpec { from: pivot, to: pivot + Vec3::X, segments: 1, ..hanging };
        let mut pendulum = rope(&spec).expect("a sound rope");
        pendulum.settings.gradient_at = Some(GradientAt::StepStart);
        let swings = pendulum.build(&mut world).expect("room").end - 1;
        let (mut still, mut swung) = (0.0_f64, 0.0_f64);
        for tick in 0..600 {
            step(&mut world, TICK);
            if tick >= 300 {
                let speeds = (0..=ball).map(|i| f64::from(world.velocity_now(i).length()));
                still = largest(speeds.chain([still]));
            }
            let fallen = f64::from(pivot.y - world.particles.position(swings).y);
            // Only where it is fast: near the turning points a relative error has no meaning.
            if (10..120).contains(&tick) && fallen > 0.2 {
                let speed = libm::sqrt(2.0 * G * fallen);
                let seen = f64::from(world.velocity_now(swings).length());
                swung = largest([swung, (seen / speed - 1.0).abs()]);
            }
        }
        let what = format!("largest speed of bodies at rest, {substeps} substeps");
        rows.push(Row::at_most(what, "m/s", most, still));
        if substeps > 1 {
            rows.push(Row::at_most("relative error of the speed of a pendulum", "", 1e-3, swung));
        }
    }
    rows
}

/// A block, a particle with a radius and a rope on planes: the distance in two seconds with 1.02 and with 0.98 of the friction that holds them, and the error
/// of the distance with 0.9 of it. The last is not claimed at 40 substeps: the depth by which a substep of gravity presses them in is less than the rounding of
/// a position some metres down (K9).
fn what_lies_on_a_slope_slides_if_and_only_if_it_is_steeper_than_its_friction() -> Vec<Row> {
    let mut rows = Vec::new();
    for (kind, name) in ["block", "particle", "rope"].into_iter().enumerate() {
        for degrees in [10.0_f64, 25.0, 40.0] {
            let (tan, sin) = (libm::tan(degrees.to_radians()), libm::sin(degrees.to_radians()));
            let (mut stuck, mut slid, mut off) = (0.0_f64, f64::INFINITY, 0.0_f64);
            for substeps in [4, 10, 40] {
                let gone = |share: f64| slides(kind, degrees, (tan * share) as f32, substeps);
                stuck = largest([stuck, gone(1.02)]);
                slid = slid.min(gone(0.98));
                if substeps < 40 {
                    let expected = 2.0 * G * sin * 0.1;
                    off = largest([off, (gone(0.9) / expected - 1.0).abs()]);
                }
            }
            let what =
                format!("distance that a {name} slides down {degrees}° with enough friction");
            rows.push(Row::at_most(what, "m", 1e-3, stuck));
            // A quarter of the exact distance in two seconds: with 40 substeps a rope of 40 g loses two thirds of so short a distance.
            let least = G * sin * 0.01;
            rows.push(Row::at_least("and with 2 % too little", "m", least, slid));
            rows.push(Row::at_most("relative error of the distance with 0.9 of it", "", 0.02, off));
        }
    }
    rows
}

/// Distance that a block (0), a particle (1) or a rope (2) slides down a plane in two seconds, metres.
fn slides(kind: usize, degrees: f64, friction: f32, substeps: u32) -> f64 {
    let half = 0.5 * degrees.to_radians();
    let turned = Quat::from_xyzw(0.0, 0.0, -libm::sin(half) as f32, libm::cos(half) as f32);
    let mut world = Simulation::default();
    world.settings.substeps = substeps;
    let material = Material::default().with_friction(friction);
    let slope = Frame::new(Vec3::ZERO, turned);
    world.colliders.push(Collider::fixed(Shape::half_space(), slope).with_material(material));
    let contacts = BodyContacts { material, ..BodyContacts::default() };
    let body = match kind {
        0 => {
            let spec = BoxSpec { size: Vec3::new(1.0, 0.4, 1.0), ..BoxSpec::default() };
            box_3d(&spec).expect("a sound box").transformed(turned, turned * Vec3::Y * 0.2)
        }
        1 => {
            let spec = RopeSpec { segments: 1, radius: 0.1, ..RopeSpec::default() };
            let mut one = rope(&spec).expect("a sound rope");
            one.particles.truncate(1);
            one.distances.clear();
            one.particles[0].position = turned * Vec3::Y * 0.1;
            one.parts.clear();
            one
        }
        _ => {
            let end = |x: f32| turned * Vec3::new(x, 0.05, 0.0);
            let (from, to) = (end(-0.5), end(0.5));
            let spec = RopeSpec { from, to, segments: 10, radius: 0.05, ..RopeSpec::default() };
            rope(&spec).expect("a sound rope")
        }
    };
    let rows = body.build_colliding(&mut world, contacts).expect("room");
    let along = |world: &Simulation| {
        let places = rows.clone().map(|i| world.particles.position(i));
        f64::from(places.sum::<Vec3>().dot(turned * Vec3::X)) / rows.len() as f64
    };
    let from = along(&world);
    steps(&mut world, TICK, 120);
    along(&world) - from
}
