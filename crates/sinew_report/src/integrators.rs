//! Rows I1 to I9: a single particle, thrown, damped or on a spring, against the formula of its motion.

use sinew::glam::Vec3;
use sinew::{Integrator, ParticleSeed, Simulation, Spring};

use crate::Row;
use crate::case::cases;
use crate::measure::{Dice, G, at, empty, gap, largest, order, period, rises, step, steps};

cases! {
    "I1" a_thrown_particle_stays_on_the_parabola;
    "I1" a_long_fall_in_short_substeps_stays_on_the_parabola;
    "I1" the_naive_start_of_verlet_errs_by_half_a_h_t;
    "I2" damping_removes_its_fraction_of_the_velocity_each_second_at_any_step;
    "I2" a_falling_body_reaches_the_terminal_speed_of_its_drag;
    "I3" steps_may_change_at_random_under_constant_gravity;
    "I4" leapfrog_runs_along_the_trajectory_of_verlet;
    "I5" both_eulers_are_of_first_order_and_the_explicit_one_gains_energy;
    "I6" swapping_the_two_positions_runs_the_motion_backwards;
    "I7" an_impulse_changes_momentum_by_itself;
    "I8" a_teleport_does_not_change_the_velocity;
    "I9" verlet_and_leapfrog_are_of_second_order;
    "I9" an_oscillator_swings_at_the_frequency_of_the_method;
    "I9" an_oscillator_neither_drifts_nor_leaves_its_bounds;
    "I9" beyond_two_steps_a_radian_an_oscillator_blows_up;
}

/// Position after `t` seconds of a particle thrown with (3, 4) m/s.
fn parabola(t: f64) -> [f64; 2] {
    [3.0 * t, 4.0 * t - 0.5 * G * t * t]
}

fn thrown(integrator: Integrator) -> Simulation {
    let mut world = Simulation::default();
    world.settings.substeps = 1;
    world.settings.integrator = integrator;
    let seed = ParticleSeed::at(Vec3::ZERO).with_velocity(Vec3::new(3.0, 4.0, 0.0));
    world.particles.push(seed).expect("a sound particle");
    world
}

/// 1e-5 relative is the required accuracy: 100 roundings of `f32`, where 120 steps make 120 of either sign.
fn a_thrown_particle_stays_on_the_parabola() -> Vec<Row> {
    let mut world = thrown(Integrator::Verlet);
    let mut worst = 0.0;
    for n in 1..=120 {
        step(&mut world, 1.0 / 60.0);
        let [x, y] = parabola(f64::from(n) * f64::from(1.0_f32 / 60.0));
        let off = at(&world, 0) - sinew::glam::DVec3::new(x, y, 0.0);
        worst = largest([worst, off.length()]);
    }
    let [x, y] = parabola(120.0 * f64::from(1.0_f32 / 60.0));
    let scale = (x * x + y * y).sqrt();
    vec![
        Row::relative("height after 2 s at 1/60 s", "m", y, at(&world, 0).y, 1e-5),
        Row::relative("horizontal distance after 2 s", "m", x, at(&world, 0).x, 1e-5),
        Row::absolute("largest distance from the parabola in 2 s", "m", 0.0, worst, 1e-5 * scale),
    ]
}

/// The same accuracy in the hardest case: 12 000 substeps up to 98 m/s, each adding 8 mm/s to a velocity whose neighbouring `f32` are up to 8 µm/s apart.
fn a_long_fall_in_short_substeps_stays_on_the_parabola() -> Vec<Row> {
    let row = |substeps| {
        let mut world = Simulation::default();
        world.settings.substeps = substeps;
        world.particles.push(ParticleSeed::at(Vec3::ZERO)).expect("a sound particle");
        steps(&mut world, 1.0 / 60.0, 600);
        let t = 600.0 * f64::from(1.0_f32 / 60.0);
        let what = format!("fall in 10 s, {substeps} substeps of 1/60 s");
        Row::relative(what, "m", -0.5 * G * t * t, at(&world, 0).y, 1e-5)
    };
    [1, 4, 10, 20].map(row).into()
}

/// The start that physics.md warns of and the crate does not use: `p_old = p - v h`, where `v` is taken as half a step old.
fn the_naive_start_of_verlet_errs_by_half_a_h_t() -> Vec<Row> {
    let h = 1.0_f32 / 60.0;
    let mut world = thrown(Integrator::Verlet);
    let naive = ParticleSeed { lag: h, ..world.particles.seed(0) };
    world.particles.set(0, naive).expect("a sound particle");
    steps(&mut world, h, 120);
    let t = 120.0 * f64::from(h);
    let off = parabola(t)[1] - at(&world, 0).y;
    // The difference of two heights that are accurate to 1e-5 of 12 m.
    vec![Row::absolute(
        "its error after 2 s at 1/60 s: ½·a·h·t",
        "m",
        0.5 * G * f64::from(h) * t,
        off,
        1.2e-4,
    )]
}

fn damping_removes_its_fraction_of_the_velocity_each_second_at_any_step() -> Vec<Row> {
    let row = |(name, h): (&str, f32)| {
        let mut world = empty(1);
        let seed = ParticleSeed::at(Vec3::ZERO).with_velocity(Vec3::X * 10.0).with_drag(0.3);
        world.particles.push(seed).expect("a sound particle");
        let count = (3.0 / h).round() as u32;
        steps(&mut world, h, count);
        // The velocity is the mean over the last step, so it belongs to half a step ago.
        let t = (f64::from(count) - 0.5) * f64::from(h);
        let exact = 10.0 * libm::pow(f64::from(1.0 - 0.3_f32), t);
        let measured = f64::from(world.particles.velocity(0).x);
        Row::relative(format!("10 m/s after 3 s at drag 0.3, {name}"), "m/s", exact, measured, 1e-5)
    };
    [("h = 1/30", 1.0 / 30.0), ("h = 1/240", 1.0 / 240.0), ("h = 1/1200", 1.0 / 1200.0)]
        .map(row)
        .into()
}

/// `v = c v + h a` has the fixed point `a h/(1 - c)`. That is the continuous `a/λ` times `1 + λh/2 + …`: the force is not damped within its own step, so the
/// terminal speed is of first order in `h`, and the second row may be off by just that.
fn a_falling_body_reaches_the_terminal_speed_of_its_drag() -> Vec<Row> {
    let h = 1.0_f32 / 240.0;
    let mut world = Simulation::default();
    world.settings.substeps = 1;
    let seed = ParticleSeed::at(Vec3::ZERO).with_drag(0.8);
    world.particles.push(seed).expect("a sound particle");
    steps(&mut world, h, 240 * 20);
    let measured = -f64::from(world.particles.velocity(0).y);
    let rate = -libm::log(1.0 - f64::from(0.8_f32));
    let (lambda_h, fall) = (rate * f64::from(h), G / rate);
    let own = G * f64::from(h) / -libm::expm1(-lambda_h);
    vec![
        Row::relative("terminal speed g·h/(1-c), drag 0.8, 1/240 s", "m/s", own, measured, 1e-5),
        Row::relative("the same compared with g/λ", "m/s", fall, measured, 0.5 * lambda_h * 1.01),
    ]
}

fn steps_may_change_at_random_under_constant_gravity() -> Vec<Row> {
    let row = |integrator: Integrator| {
        let mut world = thrown(integrator);
        let (mut dice, mut t) = (Dice(7), 0.0);
        while t < 2.0 {
            let h = [1.0 / 30.0, 1.0 / 60.0, 1.0 / 144.0][dice.roll(3) as usize];
            step(&mut world, h);
            t += f64::from(h);
        }
        let what = format!("height after 2 s, h at random of 1/30, 1/60, 1/144, {integrator:?}");
        Row::relative(what, "m", parabola(t)[1], at(&world, 0).y, 1e-5)
    };
    [Integrator::Verlet, Integrator::Leapfrog].map(row).into()
}

/// A particle of 1 kg on a spring of 1 N/m to the origin, 1 m from it at rest: `x = cos t`.
pub(crate) fn oscillator(integrator: Integrator) -> Simulation {
    let mut world = empty(1);
    world.settings.integrator = integrator;
    world.particles.push(ParticleSeed::at(Vec3::ZERO).pinned()).expect("a sound particle");
    world.particles.push(ParticleSeed::at(Vec3::X)).expect("a sound particle");
    world.forces.springs.push(Spring { a: 0, b: 1, rest: 0.0, stiffness: 1.0, damping: 0.0 });
    world
}

fn x(world: &Simulation) -> f64 {
    at(world, 1).x
}

/// Round-off of two ways to the same numbers: 1000 roundings of 6e-8 m, all of the same sign, are 6e-5 m.
fn leapfrog_runs_along_the_trajectory_of_verlet() -> Vec<Row> {
    let worst = |pick: fn(&mut Dice) -> f32| {
        let [mut one, mut other] = [Integrator::Verlet, Integrator::Leapfrog].map(oscillator);
        let (mut dice, mut apart) = (Dice(3), 0.0);
        for _ in 0..1000 {
            let h = pick(&mut dice);
            step(&mut one, h);
            step(&mut other, h);
            apart = largest([apart, gap(at(&one, 1), at(&other, 1), 1.0)]);
        }
        apart
    };
    let even = worst(|_| 0.05);
    let uneven = worst(|dice| [0.02, 0.05, 0.1][dice.roll(3) as usize]);
    vec![
        Row::absolute(
            "largest difference on an oscillator, 1000 steps of 0.05 s",
            "m",
            0.0,
            even,
            6e-5,
        ),
        Row::absolute("the same with steps of 0.02 to 0.1 s at random", "m", 0.0, uneven, 6e-5),
    ]
}

/// Largest distance from `cos t` over `seconds`, at steps of `h`.
fn oscillator_error(integrator: Integrator, h: f32, seconds: f32) -> f64 {
    let mut world = oscillator(integrator);
    let mut worst = 0.0;
    for n in 1..=(seconds / h).round() as u32 {
        step(&mut world, h);
        let exact = libm::cos(f64::from(n) * f64::from(h));
        worst = largest([worst, (x(&world) - exact).abs()]);
    }
    worst
}

/// The order over four step sizes; ± 0.1 is the required accuracy.
fn order_row(integrator: Integrator, expected: f64, first: f32, seconds: f32) -> Row {
    let sizes = [first, first / 2.0, first / 4.0, first / 8.0];
    let errors = sizes.map(|h| (f64::from(h), oscillator_error(integrator, h, seconds)));
    let what = format!("order of {integrator:?} over h = {first} to {} s", sizes[3]);
    Row::absolute(what, "", expected, order(&errors), 0.1)
}

fn both_eulers_are_of_first_order_and_the_explicit_one_gains_energy() -> Vec<Row> {
    let mut gaining = oscillator(Integrator::ExplicitEuler);
    let before = gaining.ledger().energy();
    steps(&mut gaining, 0.05, 1000);
    let gained = gaining.ledger().energy() / before;
    let each = 1.0 + f64::from(0.05_f32) * f64::from(0.05_f32);
    vec![
        order_row(Integrator::SemiImplicitEuler, 1.0, 0.02, 2.0),
        order_row(Integrator::ExplicitEuler, 1.0, 0.02, 2.0),
        // Exactly (1 + ω²h²) a step; a thousand roundings are 1e-4 of it.
        Row::relative(
            "energy of ExplicitEuler after 1000 steps of ωh = 0.05: (1+ω²h²)ⁿ",
            "",
            libm::pow(each, 1000.0),
            gained,
            1e-4,
        ),
    ]
}

/// Swaps `p` and `p_old` of all particles.
pub(crate) fn reverse(world: &mut Simulation) {
    let all: Vec<u32> = (0..world.particles.len() as u32).collect();
    world.particles.reverse(&all);
}

/// Round-off at worst: one rounding a step (6e-8 of the largest coordinate), all of the same sign, there and back.
fn swapping_the_two_positions_runs_the_motion_backwards() -> Vec<Row> {
    let row = |name: &str, mut world: Simulation, i: usize, h: f32, count: u32, scale: f64| {
        let start = at(&world, i);
        steps(&mut world, h, count);
        reverse(&mut world);
        steps(&mut world, h, count - 1);
        let most = 6e-8 * scale * 2.0 * f64::from(count);
        Row::absolute(name, "m", 0.0, (at(&world, i) - start).length(), most)
    };
    vec![
        row("a throw of 2 s, there and back", thrown(Integrator::Verlet), 0, 1.0 / 60.0, 120, 12.0),
        row(
            "10 swings of a spring, there and back",
            oscillator(Integrator::Verlet),
            1,
            0.05,
            1257,
            1.0,
        ),
    ]
}

/// Three roundings, 6e-8 each: `1/m`, `w·i`, and `m` again when it is measured.
fn an_impulse_changes_momentum_by_itself() -> Vec<Row> {
    let mut world = thrown(Integrator::Verlet);
    let heavy = ParticleSeed { mass: 3.0, ..world.particles.seed(0) };
    world.particles.set(0, heavy).expect("a sound particle");
    let before = world.ledger().momentum;
    world.particles.add_impulse(0, Vec3::new(-1.5, 0.25, 7.0));
    let change = world.ledger().momentum - before;
    let row = |axis, expected, measured| {
        Row::absolute(
            format!("change of 3 kg's momentum along {axis}"),
            "N·s",
            expected,
            measured,
            2e-6,
        )
    };
    vec![row("x", -1.5, change.x), row("y", 0.25, change.y), row("z", 7.0, change.z)]
}

fn a_teleport_does_not_change_the_velocity() -> Vec<Row> {
    let mut world = thrown(Integrator::Verlet);
    let seed = world.particles.seed(0);
    world.particles.push(seed).expect("a sound particle");
    steps(&mut world, 1.0 / 60.0, 30);
    world.particles.displace(1, Vec3::new(0.0, 16.0, 8.0));
    steps(&mut world, 1.0 / 60.0, 30);
    let velocity = (world.particles.velocity(1) - world.particles.velocity(0)).as_dvec3().length();
    let apart = at(&world, 1) - at(&world, 0);
    vec![
        Row::absolute("change of velocity", "m/s", 0.0, velocity, 0.0),
        // Two positions of some metres, each rounded 30 times.
        Row::absolute("height gained by a teleport of 16 m, 0.5 s later", "m", 16.0, apart.y, 3e-5),
    ]
}

fn verlet_and_leapfrog_are_of_second_order() -> Vec<Row> {
    [Integrator::Verlet, Integrator::Leapfrog].map(|i| order_row(i, 2.0, 0.2, 10.0)).into()
}

/// `ω_num = (2/h) asin(ωh/2)`. Interpolating the first and the last of 100 crossings errs by less than `h/10` each: 5e-5 of 100 periods.
fn an_oscillator_swings_at_the_frequency_of_the_method() -> Vec<Row> {
    let row = |h: f32| {
        let mut world = oscillator(Integrator::Verlet);
        let measured = period(&rises(&mut world, h, 640.0, x));
        let h = f64::from(h);
        let exact = core::f64::consts::TAU * h / (2.0 * libm::asin(h / 2.0));
        let what = format!("period at ωh = {h:.1}: 2π/ω_num, T = 2π without steps");
        Row::relative(what, "s", exact, measured, 5e-5)
    };
    [0.1, 0.5].map(row).into()
}

/// Energy of an oscillator after each step, relative to its initial energy.
pub(crate) fn energies(integrator: Integrator, h: f32, count: u32) -> Vec<f64> {
    let mut world = oscillator(integrator);
    let before = world.ledger().energy();
    let energy = |_| {
        step(&mut world, h);
        world.ledger().energy() / before
    };
    (0..count).map(energy).collect()
}

/// With `x = cos kθ` and `v = -sin kθ · sin θ/h` the energy is `1 - (ωh)²/4 · sin² kθ` of the initial one. One rounding a step, of either sign, makes
/// 6e-8·√20000 = 1e-5 in 20 000 steps; twice that, as it affects position and velocity.
fn an_oscillator_neither_drifts_nor_leaves_its_bounds() -> Vec<Row> {
    let h = 0.5_f32;
    let energies = energies(Integrator::Verlet, h, 20_000);
    let least = energies.iter().copied().fold(f64::INFINITY, f64::min);
    let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
    let drift = mean(&energies[19_000..]) / mean(&energies[..1000]) - 1.0;
    vec![
        Row::absolute(
            "smallest energy in 1600 periods, ωh = 0.5: 1-(ωh)²/4",
            "",
            0.9375,
            least,
            3e-5,
        ),
        Row::absolute("largest energy in 1600 periods", "", 1.0, largest(energies), 3e-5),
        // 1000 steps are about 80 periods and a fraction of one, which shifts the mean by up to 1 % of the amplitude of the energy.
        Row::absolute("drift of the mean energy", "", 0.0, drift, 3e-4),
    ]
}

/// `x_k = cos kθ` with `cos θ = 1 - (ωh)²/2`: bounded up to `ωh = 2`, and `cosh kμ` with `cosh μ = (ωh)²/2 - 1` beyond.
fn beyond_two_steps_a_radian_an_oscillator_blows_up() -> Vec<Row> {
    let farthest = |h: f32, count| {
        let mut world = oscillator(Integrator::Verlet);
        world.settings.max_speed = 0.0;
        largest((0..count).map(|_| {
            step(&mut world, h);
            x(&world).abs()
        }))
    };
    let mu = libm::acosh(0.5 * f64::from(2.01_f32) * f64::from(2.01_f32) - 1.0);
    vec![
        Row::absolute(
            "largest swing in 1000 steps at ωh = 1.99",
            "m",
            1.0,
            farthest(1.99, 1000),
            1e-3,
        ),
        // One rounding of ωh, 1e-7, shifts μ by 1e-6: 4e-5 of the growth over 40 steps. Rounding in each step does as much.
        Row::relative(
            "the same in 40 steps at ωh = 2.01: cosh 40μ",
            "m",
            libm::cosh(40.0 * mu),
            farthest(2.01, 40),
            2e-4,
        ),
    ]
}
