//! The claims of physics.md on the solver: gradients, sweeps, substeps, softness, and conservation in a long run.

use sinew::glam::Vec3;
use sinew::recipes::{BoxSpec, ClothSpec, RopeSpec, box_3d, cloth_grid, rope};
use sinew::{Distance, GradientAt, Order, ParticleSeed, Simulation, Softness, Spring};

use crate::Row;
use crate::case::cases;
use crate::integrators::reverse;
use crate::measure::{
    G, TICK, at, converge, empty, largest, period, rises, spin, step, steps, whole,
};

cases! {
    "Gradient" current_gradients_lose_spin_by_the_formula_and_step_start_gradients_keep_it;
    "Gradient" spin_is_kept_over_ten_seconds;
    "Gradient" a_pendulum_from_the_level_loses_energy_with_current_gradients_alone;
    "Gradient" at_the_defaults_a_pendulum_keeps_its_energy_for_a_minute;
    "Gradient" constrained_motion_is_reversible_with_step_start_gradients_only;
    "Loop" every_order_of_a_sweep_ends_at_the_same_lengths;
    "Substeps" at_equal_work_many_substeps_stretch_less_than_many_sweeps;
    "Softness" a_soft_distance_swings_alike_at_any_number_of_sweeps_and_substeps;
    "Softness" a_share_is_applied_once_at_any_number_of_sweeps;
    "Ledger" an_isolated_world_keeps_its_momentum_for_ten_thousand_ticks;
}

/// A cube of 1 m and 1 kg, 8 particles and 28 rods, that spins about y at `omega` rad/s without gravity.
pub(crate) fn spinning_cube(
    omega: f32,
    gradient_at: GradientAt,
    substeps: u32,
    sweeps: u32,
) -> Simulation {
    let mut world = empty(substeps);
    converge(&mut world, gradient_at, sweeps);
    // The bare correction, without restoring the angular momentum.
    world.settings.keep_spin = false;
    let rows = box_3d(&BoxSpec::default()).expect("a sound box").build(&mut world).expect("room");
    // The recipe sets the gradients at the start of the step; this overrides it.
    world.bodies[0].gradient_at = Some(gradient_at);
    spin(&mut world, rows, Vec3::Y * omega);
    world
}

/// Spin of the cube, rad/s.
pub(crate) fn spin_of(world: &Simulation) -> f64 {
    f64::from(whole(world, 0..8).angular_velocity.length())
}

/// Spin after `t` seconds by the formula of physics.md: `ω0/√(1 + 2 ω0² h t)`.
pub(crate) fn bled(omega: f64, h: f64, t: f64) -> f64 {
    omega / libm::sqrt(1.0 + 2.0 * omega * omega * h * t)
}

/// The formula is of first order in `ωh`: the next term is of the order of `(ω0 h)²`, 0.7 % here.
fn current_gradients_lose_spin_by_the_formula_and_step_start_gradients_keep_it() -> Vec<Row> {
    let mut rows = Vec::new();
    let turn = 5.0 / 60.0;
    for sweeps in [4, 20] {
        let mut world = spinning_cube(5.0, GradientAt::Current, 1, sweeps);
        steps(&mut world, TICK, 120);
        let what = format!("5 rad/s after 2 s at 1/60 s, Current, {sweeps} sweeps: ω0/√(1+2ω0²ht)");
        rows.push(Row::relative(
            what,
            "rad/s",
            bled(5.0, 1.0 / 60.0, 2.0),
            spin_of(&world),
            turn * turn,
        ));
    }
    let mut world = spinning_cube(5.0, GradientAt::StepStart, 1, 20);
    steps(&mut world, TICK, 120);
    rows.push(Row::relative(
        "the same, StepStart, 20 sweeps",
        "rad/s",
        5.0,
        spin_of(&world),
        0.005,
    ));
    rows
}

/// 0.5 % is the required accuracy for 20 substeps.
fn spin_is_kept_over_ten_seconds() -> Vec<Row> {
    let kept = |gradient_at, substeps| {
        let mut world = spinning_cube(10.0, gradient_at, substeps, 20);
        let before = world.ledger().angular_momentum.length();
        steps(&mut world, TICK, 600);
        world.ledger().angular_momentum.length() / before
    };
    let mut rows = Vec::new();
    for substeps in [1, 8, 20] {
        let h = 1.0 / (60.0 * f64::from(substeps));
        let turn = 10.0 * h;
        let what = format!("angular momentum kept, 10 rad/s, 10 s, {substeps} substeps, Current");
        let exact = bled(1.0, 100.0 * h, 10.0);
        rows.push(Row::relative(
            what,
            "",
            exact,
            kept(GradientAt::Current, substeps),
            turn * turn + 0.005,
        ));
    }
    for substeps in [1, 8, 20] {
        let what = format!("the same, {substeps} substeps, StepStart");
        rows.push(Row::relative(what, "", 1.0, kept(GradientAt::StepStart, substeps), 0.005));
    }
    let mut world = spinning_cube(10.0, GradientAt::Current, 20, 20);
    world.settings.keep_spin = true;
    let before = world.ledger();
    steps(&mut world, TICK, 600);
    let after = world.ledger();
    let share = after.angular_momentum.length() / before.angular_momentum.length();
    let what = "the same, 20 substeps, Current with the angular momentum restored";
    rows.push(Row::relative(what, "", 1.0, share, 0.005));
    let what = "its energy kept (physics.md B2': 98.8–100 %)";
    rows.push(Row::relative(what, "", 1.0, after.kinetic / before.kinetic, 0.012));
    rows
}

/// A rod of 1 m with 1 kg at its end, released at rest at `angle` (radians from hanging down).
pub(crate) fn pendulum(angle: f64, gradient_at: GradientAt) -> Simulation {
    let mut world = Simulation::default();
    world.settings.substeps = 1;
    converge(&mut world, gradient_at, 20);
    // The bare correction, without restoring the angular momentum.
    world.settings.keep_spin = false;
    world.particles.push(ParticleSeed::at(Vec3::ZERO).pinned()).expect("a sound particle");
    let bob = Vec3::new(-libm::sin(angle) as f32, -libm::cos(angle) as f32, 0.0);
    world.particles.push(ParticleSeed::at(bob)).expect("a sound particle");
    world.distances_mut().push(Distance::new(0, 1, 1.0));
    world
}

/// The values of physics.md, to the digits given there. With the velocity taken as the chord of a step, the energy of a constrained particle oscillates by
/// `(ωh)²` of it; means over one swing (142 steps) remove that. The height that the bob returns to requires no velocity: at most half a step from the top of
/// the swing it has fallen by `½ g (h/2)²` = 0.3 mm, which is 0.0033 J/kg.
fn a_pendulum_from_the_level_loses_energy_with_current_gradients_alone() -> Vec<Row> {
    let start = |gradient_at| pendulum(core::f64::consts::FRAC_PI_2, gradient_at);
    let mut world = start(GradientAt::Current);
    let before = world.ledger().energy();
    steps(&mut world, TICK, 600);
    let bled = before - world.ledger().energy();
    let lost_in_means = |world: &mut Simulation| {
        let energy = |_| {
            step(world, TICK);
            world.ledger().energy()
        };
        let energies: Vec<f64> = (0..600).map(energy).collect();
        let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
        mean(&energies[..142]) - mean(&energies[600 - 142..])
    };
    let mut world = start(GradientAt::Current);
    world.settings.keep_spin = true;
    let restored = lost_in_means(&mut world);
    let mut world = start(GradientAt::StepStart);
    let lost = lost_in_means(&mut world);
    let mut top = f64::NEG_INFINITY;
    for _ in 0..142 {
        step(&mut world, TICK);
        top = top.max(at(&world, 1).y);
    }
    vec![
        Row::absolute("energy lost of 9.81 J in 10 s at 1/60 s, Current", "J", 8.78, bled, 0.005),
        Row::absolute("the same, StepStart, means over a swing", "J", 0.0, lost, 0.0105),
        Row::absolute("the same, Current with keep_spin, the default", "J", 0.0, restored, 0.1),
        Row::absolute(
            "its highest point in the swing after, StepStart",
            "m",
            0.0,
            top,
            (0.0105 + 0.0033) / 9.81,
        ),
    ]
}

/// A pendulum of 1 m that is let go at one radian, with default settings but for the substeps: energy above the lowest point, as a share of that at the start.
/// Without `keep_spin` a share `½ (ωh)²` of the speed goes in each substep: 0.06, 0.28 and 0.70 are left.
fn at_the_defaults_a_pendulum_keeps_its_energy_for_a_minute() -> Vec<Row> {
    let row = |substeps: u32| {
        let mut world = Simulation::default();
        world.settings.substeps = substeps;
        world.particles.push(ParticleSeed::at(Vec3::ZERO).pinned()).expect("a sound particle");
        let bob = Vec3::new(libm::sinf(1.0), -libm::cosf(1.0), 0.0);
        world.particles.push(ParticleSeed::at(bob)).expect("a sound particle");
        world.distances_mut().push(Distance::new(0, 1, 1.0));
        let energy = |world: &mut Simulation| world.ledger().energy() + G;
        let before = energy(&mut world);
        steps(&mut world, TICK, 3600);
        let what = format!("energy that a pendulum keeps for a minute, {substeps} substeps");
        Row::relative(what, "", 1.0, energy(&mut world) / before, 3e-3)
    };
    [4, 10, 40].map(row).into()
}

/// With gradients at the current positions the bob misses its start by 5 to 12 cm after a second or two (physics.md). With those at the start of the step only
/// round-off is left: 1e-9 m in the `f64` of that measurement, and `2⁻²⁴/2⁻⁵³` = 5e8 times more here but for a few steps: a rounding of 6e-8 m in each of 240
/// steps, growing with time.
fn constrained_motion_is_reversible_with_step_start_gradients_only() -> Vec<Row> {
    let missed = |gradient_at| {
        let mut world = pendulum(core::f64::consts::FRAC_PI_2, gradient_at);
        let start = at(&world, 1);
        steps(&mut world, TICK, 120);
        reverse(&mut world);
        steps(&mut world, TICK, 119);
        (at(&world, 1) - start).length()
    };
    vec![
        Row::at_least(
            "a pendulum from 90° misses its start after 2 s and back, Current",
            "m",
            0.05,
            missed(GradientAt::Current),
        ),
        Row::absolute(
            "the same, StepStart",
            "m",
            0.0,
            missed(GradientAt::StepStart),
            240.0 * 120.0 * 6e-8,
        ),
    ]
}

fn every_order_of_a_sweep_ends_at_the_same_lengths() -> Vec<Row> {
    let mut rows = Vec::new();
    for order in [Order::GaussSeidel, Order::MostViolatedFirst, Order::Jacobi] {
        let mut world = Simulation::default();
        world.settings.order = order;
        world.settings.max_sweeps = 1000;
        world.settings.tolerance = 1e-5;
        let spec =
            RopeSpec { to: Vec3::X * 2.0, segments: 10, pin_start: true, ..Default::default() };
        rope(&spec).expect("a sound rope").build(&mut world).expect("room");
        steps(&mut world, TICK, 60);
        let length = |n| (at(&world, n) - at(&world, n + 1)).length();
        let worst = largest((0..10).map(|n| (length(n) - 0.2).abs()));
        let said = f64::from(world.report().error);
        rows.push(Row::absolute(
            format!("worst rod of a falling rope of 10, {order:?}, tolerance 1e-5 m"),
            "m",
            0.0,
            worst,
            1.1e-5,
        ));
        rows.push(Row::absolute("the reported error", "m", worst, said, 2e-7));
    }
    rows
}

/// Mean stretch after 4 s, per cent, of a cloth of 40 × 40 particles 10 cm apart, held at its two upper corners. physics.md does not state the size of its
/// cloth; with this size the value for one substep of 20 sweeps is the same.
fn cloth_stretch(substeps: u32, sweeps: u32, long_range: bool) -> f64 {
    let mut world = Simulation::default();
    world.settings.long_range = long_range;
    // Microsteps would replace the sweeps that are measured here.
    world.settings.microsteps = false;
    world.settings.substeps = substeps;
    world.settings.max_sweeps = sweeps;
    world.settings.tolerance = 0.0;
    let mut spec =
        ClothSpec { width: 3.9, height: 3.9, columns: 39, rows: 39, ..ClothSpec::default() };
    spec.material.bend_compliance = None;
    let mut sheet = cloth_grid(&spec).expect("a sound cloth");
    for corner in [spec.index(0, 0), spec.index(39, 0)] {
        sheet.pin(corner).expect("a corner");
    }
    sheet.build(&mut world).expect("room");
    steps(&mut world, TICK, 240);
    let distances = world.distances();
    let stretch = distances.iter().map(|d| {
        let length = (at(&world, d.a as usize) - at(&world, d.b as usize)).length();
        (length / f64::from(d.rest) - 1.0).abs()
    });
    100.0 * stretch.sum::<f64>() / distances.len() as f64
}

/// The values of physics.md for 20 projections of each constraint in a frame.
fn at_equal_work_many_substeps_stretch_less_than_many_sweeps() -> Vec<Row> {
    let (many, few) = (cloth_stretch(20, 1, false), cloth_stretch(1, 20, false));
    let tethered = cloth_stretch(20, 1, true);
    vec![
        Row::relative("mean stretch of a 40×40 cloth, 1 substep of 20 sweeps", "%", 1.65, few, 0.1),
        Row::at_most("the same, 20 substeps of 1 sweep", "%", 0.21, many),
        Row::at_most("the same with tethers to the pins", "%", 0.1, tethered),
    ]
}

/// XPBD is one step of implicit Euler a substep: the period is longer by `(ωh)²·11/24` of it, and crossings are accurate to 1e-4 of a period.
fn a_soft_distance_swings_alike_at_any_number_of_sweeps_and_substeps() -> Vec<Row> {
    let omega = core::f64::consts::TAU * 4.0;
    let mut rows = Vec::new();
    for (name, softness) in [
        ("compliance", Softness::spring((0.5 * omega * omega) as f32, 0.0)),
        ("frequency", Softness::frequency(4.0, 0.0)),
    ] {
        for (substeps, sweeps) in [(5, 1), (5, 4), (5, 16), (20, 1), (20, 4), (20, 16)] {
            let mut world = empty(substeps);
            world.settings.max_sweeps = sweeps;
            world.settings.tolerance = 0.0;
            for x in [0.0, 1.2] {
                world.particles.push(ParticleSeed::at(Vec3::X * x)).expect("a sound particle");
            }
            world.distances_mut().push(Distance::new(0, 1, 1.0).with_softness(softness));
            let stretch = |w: &Simulation| f64::from(w.particles.separation(1, 0).x) - 1.0;
            let measured = period(&rises(&mut world, 1.0 / 240.0, 1.1, stretch));
            let turn = omega / (240.0 * f64::from(substeps));
            let what = format!(
                "period of 4 Hz as a {name}, {substeps} substeps of 1/240 s, {sweeps} sweeps"
            );
            rows.push(Row::relative(what, "s", 0.25, measured, turn * turn * 11.0 / 24.0 + 1e-4));
        }
    }
    rows
}

fn a_share_is_applied_once_at_any_number_of_sweeps() -> Vec<Row> {
    [1, 4, 16]
        .map(|sweeps| {
            let mut world = empty(1);
            world.settings.max_sweeps = sweeps;
            world.settings.tolerance = 0.0;
            for x in [0.0, 2.0] {
                world.particles.push(ParticleSeed::at(Vec3::X * x)).expect("a sound particle");
            }
            world
                .distances_mut()
                .push(Distance::new(0, 1, 1.0).with_softness(Softness::Share(0.7)));
            step(&mut world, TICK);
            let left = f64::from(world.particles.separation(1, 0).x) - 1.0;
            Row::absolute(
                format!("remaining error of 1 m with Softness::Share(0.7), {sweeps} sweeps"),
                "m",
                0.3,
                left,
                2e-6,
            )
        })
        .into()
}

/// Two spinning cubes of different mass, tied by a spring and with charges of the same sign, without gravity.
fn isolated() -> Simulation {
    let mut world = empty(10);
    for (x, mass, spin_of) in
        [(0.0, 1.0, Vec3::new(0.5, 2.0, 0.3)), (2.5, 3.0, Vec3::new(-1.0, 0.2, 1.5))]
    {
        let spec = BoxSpec { mass, ..BoxSpec::default() };
        let rows = box_3d(&spec).expect("a sound box").build(&mut world).expect("room");
        spin(&mut world, rows.clone(), spin_of);
        for i in rows {
            let seed = world.particles.seed(i);
            let moved = ParticleSeed {
                position: seed.position + Vec3::X * x,
                velocity: seed.velocity + Vec3::new(0.3, 0.1, if x > 0.0 { -0.4 } else { 0.2 }),
                charge: 2e-6,
                ..seed
            };
            let body = world.particles.body(i);
            world.particles.set(i, moved).expect("a sound particle");
            world.particles.set_body(i, body);
        }
    }
    world.forces.springs.push(Spring { a: 7, b: 8, rest: 1.5, stiffness: 30.0, damping: 0.0 });
    world
}

/// 1e-4 relative is the required accuracy: 100 000 substeps round a velocity by 6e-8 each, which is 2e-5 if of either sign.
fn an_isolated_world_keeps_its_momentum_for_ten_thousand_ticks() -> Vec<Row> {
    let mut world = isolated();
    let before = world.ledger();
    let mut most = before.energy();
    for tick in 0..10_000 {
        step(&mut world, TICK);
        if tick % 100 == 99 {
            most = most.max(world.ledger().energy());
        }
    }
    let after = world.ledger();
    let moved = (after.momentum - before.momentum).length() / before.momentum.length();
    vec![
        Row::absolute("relative change of momentum", "", 0.0, moved, 1e-4),
        Row::at_most(
            "largest energy, relative to the initial one",
            "",
            1.01,
            most / before.energy(),
        ),
    ]
}
