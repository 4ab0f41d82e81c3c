//! What the cases measure with: worlds to start from, runs, crossings, slopes. Everything measured is `f64`, and mathematics comes from
//! `libm`, so that the page of results is the same on every machine.

use sinew::glam::{DQuat, DVec3, Vec3};
use sinew::pose::{Motion, motion};
use sinew::{GradientAt, Simulation, SolverReport};

/// Gravity of a world by default, m/s².
pub(crate) const G: f64 = 9.81;

/// A step of a game, seconds.
pub(crate) const TICK: f32 = 1.0 / 60.0;

/// A world without gravity and with as many substeps as asked for.
pub(crate) fn empty(substeps: u32) -> Simulation {
    let mut world = Simulation::default();
    world.forces.gravity = Vec3::ZERO;
    world.settings.substeps = substeps;
    world
}

/// Makes the loop converge as far as `f32` goes: for claims about the direction of a correction, and not about how far the loop went.
pub(crate) fn converge(world: &mut Simulation, gradient_at: GradientAt, sweeps: u32) {
    world.settings.gradient_at = gradient_at;
    world.settings.max_sweeps = sweeps;
    world.settings.tolerance = 0.0;
}

/// One step. The cases choose steps that can be taken.
pub(crate) fn step(world: &mut Simulation, dt: f32) -> &SolverReport {
    world.step(dt).expect("a positive step")
}

/// As many steps of `dt` seconds as are asked for.
pub(crate) fn steps(world: &mut Simulation, dt: f32, count: u32) {
    for _ in 0..count {
        step(world, dt);
    }
}

/// Times, in seconds from now, at which `value` rises through zero: interpolated, over `seconds` at steps of `dt`.
///
/// At a zero of an oscillation its second derivative is zero too, so the straight line between two samples errs by `dt³` only.
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

/// Mean time between the first and the last of some events, seconds; NaN if there are none to measure between.
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

/// The largest of some numbers; NaN if one of them is.
pub(crate) fn largest(numbers: impl IntoIterator<Item = f64>) -> f64 {
    numbers.into_iter().fold(0.0, |a, b| if b > a || b.is_nan() { b } else { a })
}

/// Position of particle `i`, metres.
pub(crate) fn at(world: &Simulation, i: usize) -> DVec3 {
    world.particles.position(i).as_dvec3() + world.particles.remainder(i).as_dvec3()
}

/// How far two points are from each other, as a share of `scale`.
pub(crate) fn gap(a: DVec3, b: DVec3, scale: f64) -> f64 {
    (a - b).length() / scale
}

/// What some particles do as a whole, with velocities at the instant of the positions.
pub(crate) fn whole(world: &Simulation, rows: core::ops::Range<usize>) -> Motion {
    let particles = &world.particles;
    let point = |i| (particles.position(i), world.velocity_now(i), particles.mass(i));
    motion(rows.map(point)).expect("a compound of finite particles")
}

/// Lets some particles turn about the origin with the angular velocity `spin`, rad/s.
pub(crate) fn spin(world: &mut Simulation, rows: core::ops::Range<usize>, spin: Vec3) {
    for i in rows {
        let arm = world.particles.position(i);
        let velocity = world.particles.velocity(i) + spin.cross(arm);
        world.particles.set_velocity(i, velocity);
    }
}

/// The sum of all forces on the particles where they are now, N.
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

/// A rotation, all of them as likely.
pub(crate) fn rotation(dice: &mut Dice) -> DQuat {
    loop {
        let q = DQuat::from_xyzw(dice.signed(), dice.signed(), dice.signed(), dice.signed());
        if (0.1..1.0).contains(&q.length_squared()) {
            return q.normalize();
        }
    }
}

/// Numbers that look like chance and are the same in every run (Knuth's linear congruence).
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
