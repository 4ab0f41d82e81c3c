//! Rows F1 to F4: gravity, forces of the game, springs and charges, each against the exact motion.

use core::f64::consts::TAU;

use sinew::glam::Vec3;
use sinew::pose::motion;
use sinew::recipes::{BoxLayout, BoxSpec, box_3d};
use sinew::{Control, Electric, ParticleSeed, Simulation, Spring};

use crate::Row;
use crate::case::cases;
use crate::measure::{G, at, empty, period, rises, step, steps};

cases! {
    "F1" bodies_of_any_mass_fall_alike;
    "F2" a_control_force_accelerates_by_f_over_m;
    "F2" a_control_force_on_a_compound_acts_at_its_barycentre_or_at_a_point;
    "F3" a_spring_swings_at_its_period_and_keeps_momentum;
    "F3" a_damped_spring_loses_its_swing_at_the_rate_of_its_damping;
    "F4" two_charges_circle_each_other_in_keplers_time;
    "F4" like_charges_approach_to_the_distance_that_their_energy_gives;
    "F4" softening_bounds_the_force_between_close_charges;
}

fn bodies_of_any_mass_fall_alike() -> Vec<Row> {
    let mut world = Simulation::default();
    for (x, mass) in [(0.0, 0.001), (1.0, 1.0), (2.0, 1000.0)] {
        let seed = ParticleSeed::at(Vec3::X * x).with_mass(mass);
        world.particles.push(seed).expect("a sound particle");
    }
    steps(&mut world, 1.0 / 60.0, 120);
    let y = [0, 1, 2].map(|i| at(&world, i).y);
    vec![
        Row::relative("fall of 1 kg in 2 s", "m", -2.0 * G, y[1], 1e-5),
        // 1/m and m·(1/m) are rounded, so the force is accurate to 1e-7.
        Row::absolute("1 g falls farther than 1000 kg by", "m", 0.0, y[2] - y[0], 2e-6),
    ]
}

fn a_control_force_accelerates_by_f_over_m() -> Vec<Row> {
    let (mass, force) = (4.0, Vec3::new(6.0, -2.0, 3.0));
    let mut world = empty(10);
    world.particles.push(ParticleSeed::at(Vec3::ZERO).with_mass(mass)).expect("a sound particle");
    world.particles.set_external_force(0, force);
    steps(&mut world, 1.0 / 60.0, 120);
    let exact = 0.5 * 7.0 / 4.0 * 4.0;
    vec![Row::relative(
        "distance of 4 kg under 7 N in 2 s: F t²/2m",
        "m",
        exact,
        at(&world, 0).length(),
        1e-5,
    )]
}

/// A 1×2×3 m box of 12 kg has moments of inertia of 13, 10 and 5 kg·m²: 13 N along z at 1 m along y give it 1 rad/s² about x.
fn a_control_force_on_a_compound_acts_at_its_barycentre_or_at_a_point() -> Vec<Row> {
    let answer = |point: Option<Vec3>| {
        let mut world = empty(1);
        let spec = BoxSpec {
            size: Vec3::new(1.0, 2.0, 3.0),
            mass: 12.0,
            layout: BoxLayout::Equimomental,
            ..BoxSpec::default()
        };
        let rows = box_3d(&spec).expect("a sound box").build(&mut world).expect("room");
        let thrust = Control::force("thruster", (0..8).collect::<Vec<_>>(), Vec3::Z * 13.0);
        world.forces.controls.push(Control { point, ..thrust });
        world.ledger();
        let particles = &world.particles;
        // With accelerations in place of velocities, `motion` returns the acceleration of the body.
        let started =
            rows.map(|i| (particles.position(i), particles.acceleration(i), particles.mass(i)));
        motion(started).expect("a compound of finite particles")
    };
    let (centred, aside) = (answer(None), answer(Some(Vec3::Y)));
    vec![
        Row::relative(
            "13 N on a box of 12 kg, at its barycentre: F/M",
            "m/s²",
            13.0 / 12.0,
            f64::from(centred.velocity.z),
            5e-7,
        ),
        Row::absolute(
            "angular acceleration by it",
            "rad/s²",
            0.0,
            f64::from(centred.angular_velocity.length()),
            5e-7,
        ),
        Row::relative(
            "the same at a point: F/M",
            "m/s²",
            13.0 / 12.0,
            f64::from(aside.velocity.z),
            5e-7,
        ),
        Row::relative(
            "angular acceleration by it: I⁻¹ r × F",
            "rad/s²",
            1.0,
            f64::from(aside.angular_velocity.x),
            5e-7,
        ),
    ]
}

/// Two masses on a spring of 40 N/m, stretched by 20 % of its rest length of 1 m.
fn pair(damping: f32) -> Simulation {
    let mut world = empty(1);
    for (x, mass) in [(0.0, 1.0), (1.2, 3.0)] {
        let seed = ParticleSeed::at(Vec3::X * x).with_mass(mass);
        world.particles.push(seed).expect("a sound particle");
    }
    world.forces.springs.push(Spring { a: 0, b: 1, rest: 1.0, stiffness: 40.0, damping });
    world
}

fn stretch(world: &Simulation) -> f64 {
    f64::from(world.particles.separation(1, 0).x) - 1.0
}

fn a_spring_swings_at_its_period_and_keeps_momentum() -> Vec<Row> {
    let (mut world, h, mu) = (pair(0.0), 1.0_f32 / 240.0, 0.75);
    let omega = libm::sqrt(40.0 / mu);
    let measured = period(&rises(&mut world, h, 20.0, stretch));
    let momentum = world.ledger().momentum.length();
    let turn = omega * f64::from(h);
    vec![
        // Verlet shifts the period by (ωh)²/24 (I9); 1e-5 is for interpolating the crossings.
        Row::relative(
            "period 2π√(μ/k) at 1/240 s",
            "s",
            TAU / omega,
            measured,
            turn * turn / 24.0 + 1e-5,
        ),
        // 4800 roundings of either sign, 6e-8 each, of the 1.1 kg·m/s amplitude of each end's momentum.
        Row::absolute("momentum of both after 20 s", "kg·m/s", 0.0, momentum, 6e-8 * 70.0 * 1.1),
    ]
}

/// The damping force uses the velocity of half a step ago. So the amplitude shrinks by `√(1 - β)` a step, where `β = b h/μ`. That is the rate `b/2μ` times
/// `1 + β/2 + …`, which is of first order in `h`.
fn a_damped_spring_loses_its_swing_at_the_rate_of_its_damping() -> Vec<Row> {
    let (h, b, mu) = (1.0_f32 / 240.0, 1.0_f32, 0.75);
    let mut world = pair(b);
    let mut swing = vec![stretch(&world)];
    for _ in 0..(5.0 / h) as u32 {
        step(&mut world, h);
        swing.push(stretch(&world));
    }
    // Peaks are found by the parabola through three samples.
    let mut peaks = vec![(0.0, swing[0])];
    for k in 1..swing.len() - 1 {
        let [a, m, c] = [swing[k - 1], swing[k], swing[k + 1]];
        if m > a && m >= c {
            let off = 0.5 * (a - c) / (a - 2.0 * m + c);
            peaks.push((k as f64 + off, m - 0.25 * (a - c) * off));
        }
    }
    let (first, last) = (peaks[1], peaks[peaks.len() - 1]);
    let seconds = (last.0 - first.0) * f64::from(h);
    let rate = libm::log(first.1 / last.1) / seconds;
    let (exact, beta) = (f64::from(b) / (2.0 * mu), f64::from(b * h) / mu);
    let own = -0.5 * libm::log1p(-beta) / f64::from(h);
    steps(&mut world, h, 240 * 20);
    vec![
        // A peak interpolated between three samples is accurate to 1e-6 of the first, and the last one is a tenth of that.
        Row::relative(
            "decay of the swing by the method, ζ = 0.09, 1/240 s",
            "1/s",
            own,
            rate,
            1e-4,
        ),
        Row::relative("the same compared with b/2μ", "1/s", exact, rate, 0.5 * beta * (1.0 + beta)),
        Row::absolute("length in the end", "m", 1.0, 1.0 + stretch(&world), 1e-6),
    ]
}

/// Opposite charges of 1 and 2 µC on 2 and 3 g: K|q₁q₂| = 0.01798 N·m².
fn two_charges_circle_each_other_in_keplers_time() -> Vec<Row> {
    let (q, m, r) = ([1e-6_f32, -2e-6], [0.002_f32, 0.003], 1.0_f32);
    let mut world = empty(10);
    let strength = f64::from(world.forces.electric.constant * (q[0] * q[1]).abs());
    let mu = f64::from(m[0] * m[1] / (m[0] + m[1]));
    let exact = TAU * libm::sqrt(mu * f64::from(r * r * r) / strength);
    let speed = TAU * f64::from(r) / exact;
    for i in 0..2 {
        let side = if i == 0 { 1.0 } else { -1.0 };
        let share = side * (mu / f64::from(m[i])) as f32;
        let seed = ParticleSeed::at(Vec3::X * (share * r))
            .with_velocity(Vec3::Y * (share * speed as f32))
            .with_mass(m[i])
            .with_charge(q[i]);
        world.particles.push(seed).expect("a sound particle");
    }
    let height = |w: &Simulation| f64::from(w.particles.separation(0, 1).y);
    let times = rises(&mut world, 1.0 / 60.0, exact * 5.5, height);
    let apart = f64::from(world.particles.separation(0, 1).length());
    let momentum = world.ledger().momentum.length() / (mu * speed);
    vec![
        Row::relative("period of a circle: 2π√(μr³/K|q₁q₂|)", "s", exact, period(&times), 1e-4),
        Row::relative("their distance after 5.5 turns", "m", f64::from(r), apart, 1e-4),
        // 6200 substeps of one rounding each, either sign.
        Row::absolute("total momentum, relative to that of one", "", 0.0, momentum, 6e-8 * 80.0),
    ]
}

fn like_charges_approach_to_the_distance_that_their_energy_gives() -> Vec<Row> {
    let (charge, h) = (1e-6_f32, 1.0 / 9600.0);
    let mut world = empty(1);
    for side in [-1.0_f32, 1.0] {
        let seed = ParticleSeed::at(Vec3::X * side)
            .with_velocity(Vec3::X * (-side * 5.0))
            .with_mass(0.01)
            .with_charge(charge);
        world.particles.push(seed).expect("a sound particle");
    }
    let energy = world.ledger().energy();
    let strength = f64::from(world.forces.electric.constant * charge * charge);
    let mut closest = f64::INFINITY;
    for _ in 0..3000 {
        step(&mut world, h);
        closest = closest.min(f64::from(world.particles.separation(0, 1).length()));
    }
    let back = world.ledger().energy();
    // They turn round within √(d m/2F) = 5 ms, which is 50 steps: the error is about 1/50² / 24 = 2e-5.
    vec![
        Row::relative("closest approach K q²/E", "m", strength / energy, closest, 1e-4),
        Row::relative("energy on the way back", "J", energy, back, 1e-4),
    ]
}

fn softening_bounds_the_force_between_close_charges() -> Vec<Row> {
    let force = |distance: f32| {
        let mut world = empty(1);
        world.forces.electric = Electric { softening: 0.1, ..Electric::default() };
        for x in [0.0, distance] {
            let seed = ParticleSeed::at(Vec3::X * x).with_charge(1e-6);
            world.particles.push(seed).expect("a sound particle");
        }
        world.ledger();
        f64::from(world.particles.acceleration(1).x)
    };
    let exact = |r: f64| 8.987_552e9 * 1e-12 * r / libm::pow(r * r + 0.01, 1.5);
    [0.0, 0.07, 2.0]
        .map(|r: f32| {
            let expected = exact(f64::from(r));
            let what = format!("force between 1 µC and 1 µC {r} m apart, ε = 0.1 m");
            // About ten roundings in the force of a pair.
            Row::absolute(what, "N", expected, force(r), 6e-7 * expected)
        })
        .into()
}
