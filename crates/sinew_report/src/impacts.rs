//! Rows K5 and K6: collisions keep momentum, and with restitution 1 energy.

use sinew::glam::{DVec3, Quat, Vec3};
use sinew::recipes::{BoxLayout, BoxSpec, box_3d};
use sinew::{
    BodyContacts, BodySettings, Collider, Frame, Material, ParticleSeed, Shape, Simulation,
};

use crate::Row;
use crate::case::cases;
use crate::measure::{Dice, TICK, empty, largest, step, vector};

cases! {
    "K5" two_balls_bounce_by_their_masses_and_restitution;
    "K5" a_ball_into_two_that_touch_and_a_row_of_five_keep_their_energy;
    "K6" two_hundred_balls_in_a_box_keep_their_energy_for_a_minute;
}

/// A material without friction, so that nothing turns a ball.
fn smooth(restitution: f32) -> Material {
    Material::default().with_friction(0.0).with_restitution(restitution)
}

/// Adds a ball with a radius, metres, a mass, kg, and restitution `e`.
fn add(world: &mut Simulation, radius: f32, mass: f32, at: Vec3, velocity: Vec3, e: f32) {
    // A box with the moments of inertia of a solid ball.
    let size = Vec3::splat(radius * libm::sqrtf(2.4));
    let layout = BoxLayout::Equimomental;
    let spec = BoxSpec { size, mass, layout, ..BoxSpec::default() };
    let mut body = box_3d(&spec).expect("a sound box");
    body.parts[0].shape = Some(Shape::sphere(radius).expect("a sound sphere"));
    let contacts = BodyContacts { material: smooth(e), ..Default::default() };
    let body = body.transformed(Quat::IDENTITY, at);
    for i in body.build_colliding(world, contacts).expect("room") {
        world.particles.set_velocity(i, velocity);
    }
}

/// Adds a particle that collides as a ball with a radius, metres, and restitution `e`.
fn add_particle(world: &mut Simulation, radius: f32, at: Vec3, velocity: Vec3, e: f32) {
    let seed = ParticleSeed::at(at).with_velocity(velocity).with_radius(radius);
    let row = world.particles.push(seed).expect("a sound particle") as usize;
    world.particles.set_body(row, Some(world.bodies.len() as u32));
    world.bodies.push(BodySettings::default());
    world.contacts.push(BodyContacts { material: smooth(e), ..Default::default() });
}

/// Kinetic energy, J, and momentum, kg·m/s, from the mean velocities of the last substep.
fn sums(world: &Simulation) -> (f64, DVec3) {
    let particles = &world.particles;
    let each = (0..particles.len()).map(|i| {
        let (v, m) = (particles.velocity(i).as_dvec3(), f64::from(particles.mass(i)));
        (0.5 * m * v.length_squared(), v * m)
    });
    each.fold((0.0, DVec3::ZERO), |sum, one| (sum.0 + one.0, sum.1 + one.1))
}

/// Runs a simulation of balls. Returns the final energy relative to the initial one, the relative change of momentum, and the largest gain of energy in a step,
/// relative to the initial energy.
fn run(world: &mut Simulation, ticks: u32) -> [f64; 3] {
    let (energy, momentum) = sums(world);
    let (mut now, mut gain) = ((energy, momentum), 0.0_f64);
    for _ in 0..ticks {
        step(world, TICK);
        let next = sums(world);
        gain = largest([gain, next.0 - now.0]);
        now = next;
    }
    [now.0 / energy, (now.1 - momentum).length() / momentum.length(), gain / energy]
}

/// Energy that two smooth balls keep, relative to the initial one. One comes along x at 2 m/s; the line between the centres at contact has an angle to x whose
/// sine is `aside`.
fn left(masses: [f64; 2], e: f64, aside: f64) -> f64 {
    let share = masses[1] / (masses[0] + masses[1]);
    1.0 - (1.0 - e * e) * (1.0 - aside * aside) * share
}

/// Momentum is accurate to 2e-5 at worst: rounding a position of a metre gives 2e-5 m/s at 2400 substeps a second.
fn two_balls_bounce_by_their_masses_and_restitution() -> Vec<Row> {
    let mut rows = Vec::new();
    for e in [1.0_f64, 0.5] {
        for masses in [[1.0, 1.0], [1.0, 5.0], [5.0, 1.0]] {
            for aside in [0.0, 0.5] {
                let (mut energy, mut rest) = (f64::NAN, [0.0_f64; 2]);
                let expected = left(masses, e, aside);
                for substeps in [4, 10, 40] {
                    let mut world = empty(substeps);
                    let [first, second] = masses.map(|mass| mass as f32);
                    add(&mut world, 0.5, first, Vec3::ZERO, Vec3::X * 2.0, e as f32);
                    let there = Vec3::new(2.03, aside as f32, 0.0);
                    add(&mut world, 0.5, second, there, Vec3::ZERO, e as f32);
                    let [seen, momentum, gain] = run(&mut world, 120);
                    let off = (seen - expected).abs();
                    if energy.is_nan() || off.is_nan() || off > (energy - expected).abs() {
                        energy = seen;
                    }
                    rest = [largest([rest[0], momentum]), largest([rest[1], gain])];
                }
                let [a, b] = masses;
                let way = if aside == 0.0 { "head-on" } else { "obliquely" };
                // With e < 1 the direction of the normal matters, and a contact starts up to one substep's travel early: 8 mm at 4 substeps, for a ball of 1 m.
                let share = if e == 1.0 { 1e-3 } else { 5e-3 };
                let what =
                    format!("energy kept when a ball of {a} kg hits one of {b} kg {way}, e = {e}");
                rows.push(Row::relative(what, "", expected, energy, share));
                rows.push(Row::at_most("its change of momentum", "", 2.5e-5, rest[0]));
                rows.push(Row::at_most("largest gain of energy in a step", "", 5e-6, rest[1]));
            }
        }
    }
    rows
}

/// With `e = 1`, and gaps of zero and of 0.01 mm.
fn a_ball_into_two_that_touch_and_a_row_of_five_keep_their_energy() -> Vec<Row> {
    let mut rows = Vec::new();
    let pair = |gap: f32| [1.0, -1.0].map(|side| Vec3::new(2.0, 0.0, side * (0.5 + gap))).to_vec();
    let row = |gap: f32| (0..4).map(|k| Vec3::X * (2.0 + k as f32 * (1.0 + gap))).collect();
    let layouts: [(&str, &dyn Fn(f32) -> Vec<Vec3>); 2] =
        [("two that touch", &pair), ("a row of four", &row)];
    // A particle is a single rounding of each coordinate, a ball the mean of eight.
    let kinds: [(&str, fn(&mut Simulation, Vec3, Vec3), f64); 2] = [
        ("ball", |world, at, velocity| add(world, 0.5, 1.0, at, velocity, 1.0), 1.0),
        ("particle", |world, at, velocity| add_particle(world, 0.5, at, velocity, 1.0), 3.0),
    ];
    let all = layouts.iter().flat_map(|layout| kinds.iter().map(move |kind| (layout, kind)));
    for ((name, layout), (kind, add, rounding)) in all {
        let mut worst = [0.0_f64; 3];
        for substeps in [4, 10, 40] {
            for gap in [0.0, 1e-5] {
                let mut world = empty(substeps);
                add(&mut world, Vec3::ZERO, Vec3::X * 2.0);
                for at in layout(gap) {
                    add(&mut world, at, Vec3::ZERO);
                }
                let [energy, momentum, gain] = run(&mut world, 120);
                for (worst, seen) in worst.iter_mut().zip([(energy - 1.0).abs(), momentum, gain]) {
                    *worst = largest([*worst, seen]);
                }
            }
        }
        rows.push(Row::at_most(
            format!("change of energy of a {kind} into {name}"),
            "",
            1e-3,
            worst[0],
        ));
        rows.push(Row::at_most("its change of momentum", "", rounding * 2.5e-5, worst[1]));
        rows.push(Row::at_most("largest gain of energy in a step", "", rounding * 1e-5, worst[2]));
    }
    rows
}

/// Balls of 10 cm radius at up to 3.5 m/s between six planes, without gravity.
fn two_hundred_balls_in_a_box_keep_their_energy_for_a_minute() -> Vec<Row> {
    let mut rows = Vec::new();
    for (share, least) in [(0.05_f32, 0.99), (0.3, 0.95)] {
        for substeps in [4, 10] {
            let mut world = empty(substeps);
            let (count, radius) = (200, 0.1_f32);
            let volume =
                count as f32 * 4.0 / 3.0 * core::f32::consts::PI * radius * radius * radius;
            let side = libm::cbrtf(volume / share);
            for normal in [Vec3::X, Vec3::Y, Vec3::Z].into_iter().flat_map(|axis| [axis, -axis]) {
                let turned = Quat::from_rotation_arc(Vec3::Y, normal);
                let wall = Frame::new(normal * (-0.5 * side), turned);
                world
                    .colliders
                    .push(Collider::fixed(Shape::half_space(), wall).with_material(smooth(1.0)));
            }
            let (mut dice, each) = (Dice(7), 6);
            for i in 0..count {
                let cell = Vec3::new(
                    (i % each) as f32,
                    (i / each % each) as f32,
                    (i / each / each) as f32,
                );
                let at = (cell + 0.5) * (side / each as f32) - side * 0.5;
                let velocity = (vector(&mut dice) * 2.0).as_vec3();
                add(&mut world, radius, 1.0, at, velocity, 1.0);
            }
            let [energy, ..] = run(&mut world, 3600);
            let what =
                format!("energy kept by 200 balls that fill {share} of a box, {substeps} substeps");
            rows.push(Row::at_least(what, "", least, energy));
            rows.push(Row::at_most("and at most the initial energy", "", 1.001, energy));
        }
    }
    rows
}
