//! Tools of the cases: initial simulations, runs, zero crossings, slopes. All measurements are in `f64`, and mathematical functions come from `libm`, so that
//! the results are the same on every machine.

use sinew::glam::{DQuat, DVec3, Vec3};
use sinew::pose::{Motion, motion};
use sinew::{GradientAt, Simulation, SolverReport};

/// Default gravity of a simulation, m/s².
pub(crate) const G: f64 = 9.81;

/// Duration of a tick, seconds.
pub(crate) const TICK: f32 = 1.0 / 60.0;

/// A simulation without gravity, with a number of substeps.
pub(crate) fn empty(substeps: u32) -> Simulation {
    let mut world = Simulation::default();
    world.forces.gravity = Vec3::ZERO;
    world.settings.substeps = substeps;
    world
}

/// Makes the solver converge as far as `f32` allows: for claims about the direction of a correction rather than about convergence.
pub(crate) fn converge(world: &mut Simulation, gradient_at: GradientAt, sweeps: u32) {
    world.settings.gradient_at = gradient_at;
    world.settings.max_sweeps = sweeps;
    world.settings.tolerance = 0.0;
}

/// Simulates one step. The cases only choose valid steps.
pub(crate) fn step(world: &mut Simulation, dt: f32) -> &SolverReport {
    world.step(dt).expect("a positive step")
}

/// Simulates `count` steps of `dt` seconds.
pub(crate) fn steps(world: &mut Simulation, dt: f32, count: u32) {
    for _ in 0..count {
        step(world, dt);
    }
}

/// Times, in seconds from now, at which `value` rises through zero, interpolated; runs for `seconds` at steps of `dt`.
///
/// At a zero of an oscillation its second derivative is zero too, so linear interpolation between two samples errs by `dt³` only.
pub(crate) fn rises(
    world: &mut Simulation,
    dt: f32,
    seconds: f64,
    value: impl Fn(&Simulation) -> f64,
) -> Vec<f64> {
    let (mut count, mut last, mut times) = (0.0, value(world), Vec::new());
    let dt64 = f64::from(dt);
    while count * dt64 < seconds {
        step(world, dt);
        count += 1.0;
        let now = value(world);
        if last < 0.0 && now >= 0.0 {
            times.push((count - now / (now - last)) * dt64);
        }
        last = now;
    }
    times
}

/// Mean time between events, seconds; NaN for fewer than two.
pub(crate) fn period(times: &[f64]) -> f64 {
    match times {
        [first, .., last] => (last - first) / (times.len() - 1) as f64,
        _ => f64::NAN,
    }
}

/// The order of a method: the slope of `log error` over `log h`, by least squares.
pub(crate) fn order(errors: &[(f64, f64)]) -> f64 {
    let points: Vec<_> = errors.iter().map(|&(h, e)| (libm::log(h), libm::log(e))).collect();
    let n = points.len() as f64;
    let mean = |pick: fn(&(f64, f64)) -> f64| points.iter().map(pick).sum::<f64>() / n;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let (mut xy, mut xx) = (0.0, 0.0);
    for p in &points {
        xy += (p.0 - x) * (p.1 - y);
        xx += (p.0 - x) * (p.0 - x);
    }
    xy / xx
}

/// The largest of some numbers that are not negative; NaN if one of them is NaN.
pub(crate) fn largest(numbers: impl IntoIterator<Item = f64>) -> f64 {
    numbers.into_iter().fold(0.0, |a, b| if b > a || b.is_nan() { b } else { a })
}

/// Position of particle `i`, metres.
pub(crate) fn at(world: &Simulation, i: usize) -> DVec3 {
    world.particles.position(i).as_dvec3() + world.particles.remainder(i).as_dvec3()
}

/// Distance between two points, relative to `scale`.
pub(crate) fn gap(a: DVec3, b: DVec3, scale: f64) -> f64 {
    (a - b).length() / scale
}

/// Mass, centre of mass and motion of some particles as a whole, with velocities at the instant of the positions.
pub(crate) fn whole(world: &Simulation, rows: core::ops::Range<usize>) -> Motion {
    let particles = &world.particles;
    let point = |i| (particles.position(i), world.velocity_now(i), particles.mass(i));
    motion(rows.map(point)).expect("a compound of finite particles")
}

/// Adds a rotation about the origin to the velocities of some particles; angular velocity `spin`, rad/s.
pub(crate) fn spin(world: &mut Simulation, rows: core::ops::Range<usize>, spin: Vec3) {
    for i in rows {
        let arm = world.particles.position(i);
        let velocity = world.particles.velocity(i) + spin.cross(arm);
        world.particles.set_velocity(i, velocity);
    }
}

/// Sum of the forces on all free particles at their present positions, N.
pub(crate) fn force(world: &mut Simulation) -> DVec3 {
    world.ledger();
    let particles = &world.particles;
    let moving = (0..particles.len()).filter(|&i| particles.inverse_mass(i) > 0.0);
    moving.map(|i| particles.acceleration(i).as_dvec3() * f64::from(particles.mass(i))).sum()
}

/// A vector with components of -1 to 1.
pub(crate) fn vector(dice: &mut Dice) -> DVec3 {
    DVec3::new(dice.signed(), dice.signed(), dice.signed())
}

/// A rotation, uniformly distributed.
pub(crate) fn rotation(dice: &mut Dice) -> DQuat {
    loop {
        let q = DQuat::from_xyzw(dice.signed(), dice.signed(), dice.signed(), dice.signed());
        if (0.1..1.0).contains(&q.length_squared()) {
            return q.normalize();
        }
    }
}

/// Pseudo-random numbers that are the same in every run (Knuth's linear congruential generator).
pub(crate) struct Dice(pub(crate) u32);

impl Dice {
    /// The next number, 0 to `below - 1`.
    pub(crate) fn roll(&mut self, below: u32) -> u32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.0 >> 16) % below
    }

    /// The next number, -1 to 1.
    pub(crate) fn signed(&mut self) -> f64 {
        f64::from(self.roll(65_536)) / 32_767.5 - 1.0
    }
}
