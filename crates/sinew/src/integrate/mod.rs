//! Integration: from positions and accelerations to the next positions, and from corrected positions back to velocities.
//!
//! # Verlet, the default
//!
//! The lectures' Verlet step is `q = p + c (p - p_old) + h² a` with the damping `c = (1 - drag)^h`. With `v = (p - p_old)/l`, the mean velocity over the last
//! step of length `l` (see [`particles`](crate::particles)), and a step length that may change, it becomes
//!
//! ```text
//! τ = (l + h)/2             the time between the middles of the last step and of this one
//! u = e^(-λτ) v + τ a       the mean velocity of this step; λ = -ln(1 - drag)
//! q = p + h u
//! ```
//!
//! - For `l = h` it is exactly the lectures' formula (physics.md I1, I2).
//! - Under constant acceleration the mean velocity of a step is the velocity at its middle, so `u = v + τ a` is exact for any step sizes: time-corrected Verlet
//!   (I3). The lectures' rescaling of `p_old` keeps `v`, but ignores that it is `l/2` old.
//! - For `l = 0`, a velocity that is true now, it is the exact start `q = p + h v + ½ h² a` (I1); the naive `p_old = p - h v` errs by ½ a h t.
//! - Without acceleration `v(t) = v₀ (1 - drag)^t` holds at the middle of every step, for any `h` (I2). `1 - e^(-λτ)` is computed as such, so that small drags
//!   are not lost in the round-off of a factor close to 1.
//! - An oscillator of frequency ω swings at `(2/h) asin(ωh/2)`: order 2 in `h`, bounded energy, unstable beyond `ωh > 2` (I9).
//!
//! In a moving medium (a current in a fluid) the velocity decays towards that of the medium instead of towards zero.
//!
//! # The other integrators
//!
//! All of them consist of kicks, `kick(τ): v ← e^(-λτ) v + τ a`, before and after the drift `q = p + h v`, and differ in when these happen:
//!
//! ```text
//! Verlet               kick((l + h)/2)           drift               velocity kept at the middle of the step
//! leapfrog             kick(l/2)  kick(h/2)      drift               the same, re-centred: v is true now in between (I4)
//! semi-implicit Euler  kick(h)                   drift               velocity kept at the end of the step (I5)
//! explicit Euler                                 drift   kick(h)     the same; gains energy on anything that swings
//! ```
//!
//! Leapfrog and Verlet give the same trajectory, except for round-off and the order in which drag and force alternate. The Euler methods are of order 1: they
//! exist for comparison, and for users who must reproduce another engine.
//!
//! # After the constraints
//!
//! Constraints move the particles from `q` to `q'`, and the velocity follows: `v = u + (q' - q)/h`. With this form, rather than `(q' - p)/h`, a particle that
//! no constraint touched keeps every bit of `u`, however far from its origin it is.

mod columns;
mod kicks;
mod wide;

use core::iter::Peekable;
use core::ops::Range;

use crate::lanes::with;
use crate::particles::{Particles, Places};
use crate::threads::{ExecutionContext, TASKS, each};

pub(crate) use columns::{
    MovingColumns, StepConstants, advance_columns, derive_columns, predict_columns,
};
pub(crate) use wide::{Derive, MotionColumns, Predict, loss};

/// How a world steps through time. The module docs of [`integrate`](crate::integrate) compare the methods. Default [`Verlet`](Self::Verlet).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Integrator {
    /// Time-corrected position Verlet: order 2, keeps energy, and the step may change at any time. The default.
    #[default]
    Verlet,
    /// Kick, drift, kick: order 2, the same trajectory as Verlet.
    Leapfrog,
    /// Velocity first, then position: order 1, bounded energy.
    SemiImplicitEuler,
    /// Position and velocity both from the old ones: order 1, gains energy on an oscillator. For comparison.
    ExplicitEuler,
}

impl Integrator {
    /// The lag of a particle after a substep of `h` seconds: its velocity is true half this time before the end of the substep.
    pub(crate) fn lag(self, h: f32) -> f32 {
        match self {
            Self::Verlet | Self::Leapfrog => h,
            Self::SemiImplicitEuler | Self::ExplicitEuler => 0.0,
        }
    }
}

/// Consecutive rows with the same number of microsteps.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct StepRows {
    pub(crate) rows: Range<usize>,
    /// Microsteps in a substep, 1 or more.
    pub(crate) microsteps: u32,
}

impl StepRows {
    /// Calls `each` with the stretches of some rows. All take whole substeps, except those in `exceptions` (ascending): these are passed on as they are, or
    /// left out if their number of microsteps is zero.
    pub(crate) fn split(
        mut rows: Range<usize>,
        exceptions: &mut Peekable<impl Iterator<Item = Self>>,
        mut each: impl FnMut(Self),
    ) {
        let mut emit = |rows: Range<usize>, microsteps| {
            if !rows.is_empty() && microsteps > 0 {
                each(Self { rows, microsteps });
            }
        };
        while let Some(own) = exceptions.next_if(|own| own.rows.start < rows.end) {
            emit(rows.start..own.rows.start, 1);
            rows.start = own.rows.end;
            emit(own.rows, own.microsteps);
        }
        emit(rows, 1);
    }
}

/// Predicts the next position of every particle in some rows that can move, from its acceleration, over a substep of `h` seconds.
///
/// Afterwards [`Particles::start`] is the position at the start of the substep, and the velocity is the one that leads from there to the prediction. A particle
/// of infinite mass stays where it is. Rows with several microsteps go through the first of them. Other rows may be changed too: a caller that leaves rows out
/// has to write them itself.
pub(crate) fn predict(
    particles: &mut Particles,
    integrator: Integrator,
    h: f32,
    rows: &[StepRows],
    execution: ExecutionContext,
) {
    // The other integrators are rare.
    if integrator == Integrator::Verlet {
        let (places, mut motion) = MotionColumns::all(particles);
        let Places { position, start, velocity, .. } = places;
        for StepRows { rows, microsteps } in rows.iter().cloned() {
            let columns = [&mut *position, &mut *start, &mut *velocity];
            predict_all(motion.predict(columns, rows, h / microsteps as f32), execution);
        }
    } else {
        kicks::predict(particles, integrator, h);
    }
}

/// The Verlet prediction of some particles, in parallel.
pub(crate) fn predict_all(all: Predict, execution: ExecutionContext) {
    let size = chunk_size(all.position.len());
    each(execution.workers, all.chunks(size), |chunk| with(execution.instructions, chunk));
}

/// Derives the velocities from the positions that the constraints left, at the end of a substep.
pub(crate) fn derive(all: Derive, execution: ExecutionContext) {
    let size = chunk_size(all.position.len());
    each(execution.workers, all.chunks(size), |chunk| with(execution.instructions, chunk));
}

/// What an integrator adds after the constraints, over a substep of `h` seconds.
pub(crate) fn finish(particles: &mut Particles, integrator: Integrator, h: f32) {
    if integrator == Integrator::ExplicitEuler {
        kicks::kick_all(particles, h);
    }
}

/// The number of particles in a task: even, since two are stepped at once, and large enough, some 50 µs, to be worth waking a thread.
fn chunk_size(particles: usize) -> usize {
    const LEAST: usize = 16_384;
    particles.div_ceil(TASKS).next_multiple_of(2).max(LEAST)
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::lanes::InstructionSet;
    use crate::particles::{ParticleSeed, drag_of_rate, rate_of_drag};
    use crate::test_random::Random;

    const MACHINE: ExecutionContext =
        ExecutionContext { instructions: InstructionSet::Simd128, workers: None };

    fn all(rows: usize) -> [StepRows; 1] {
        [StepRows { rows: 0..rows, microsteps: 1 }]
    }

    /// When a current flowed anywhere in a world, all of its particles used to be stepped one by one.
    #[test]
    fn what_a_current_drags_along_is_stepped_in_lanes_to_the_bits_of_one_by_one() {
        let mut world = Particles::default();
        for i in 0..31_u8 {
            let n = f32::from(i);
            let seed = ParticleSeed::at(Vec3::new(n, 2.0 * n, -n))
                .with_velocity(Vec3::new(0.3 * n, -1.0, 0.1 * n))
                .with_drag(0.01 * n);
            world.push(if i % 9 == 8 { seed.pinned() } else { seed }).unwrap();
        }
        world.clear_sums(0.1);
        world.add_acceleration(3, Vec3::Y * 4.0);
        for i in [0, 1, 4, 7, 8, 30] {
            world.drag_towards(i, 1.5 + i as f32, Vec3::new(1.0, 0.0, 2.0));
        }
        for sets in InstructionSet::ALL {
            let (mut one, mut other) = (world.clone(), world.clone());
            let execution = ExecutionContext { instructions: sets, workers: None };
            for _ in 0..3 {
                predict(&mut one, Integrator::Verlet, 0.01, &all(31), execution);
                kicks::predict(&mut other, Integrator::Verlet, 0.01);
            }
            for i in 0..31 {
                let bits = |p: &Particles| {
                    [p.position[i], p.velocity[i], p.rounding[i]]
                        .map(|v| v.to_array().map(f32::to_bits))
                };
                assert_eq!(bits(&one), bits(&other), "{sets:?}, particle {i}");
            }
        }
    }

    fn derive_all(particles: &mut Particles, integrator: Integrator, h: f32) {
        derive(Derive::all(particles, h, integrator.lag(h)), MACHINE);
        finish(particles, integrator, h);
    }

    const G: Vec3 = Vec3::new(0.0, -9.81, 0.0);

    fn thrown(velocity: Vec3, drag: f32) -> Particles {
        let mut particles = Particles::default();
        let seed = ParticleSeed::at(Vec3::ZERO).with_velocity(velocity).with_drag(drag);
        particles.push(seed).unwrap();
        particles
    }

    fn advance(particles: &mut Particles, h: f32, acceleration: Vec3) {
        particles.clear_sums(0.0);
        particles.accelerate_all(acceleration);
        step(particles, h);
    }

    fn step(particles: &mut Particles, h: f32) {
        predict(particles, Integrator::Verlet, h, &all(1), MACHINE);
        derive_all(particles, Integrator::Verlet, h);
    }

    #[test]
    fn a_thrown_particle_stays_on_the_exact_parabola_with_any_steps() {
        let v0 = Vec3::new(3.0, 4.0, 0.0);
        let steps = [1.0 / 30.0, 1.0 / 60.0, 1.0 / 144.0];
        let mut particles = thrown(v0, 0.0);
        let (mut t, mut random) = (0.0_f64, Random::new(7));
        while t < 2.0 {
            let h = steps[random.below(3)];
            advance(&mut particles, h, G);
            t += f64::from(h);
        }
        let exact = v0.as_dvec3() * t + G.as_dvec3() * (0.5 * t * t);
        let error = (particles.position(0).as_dvec3() - exact).length();
        assert!(error < 1e-5 * exact.length(), "{error} of {exact}");
    }

    #[test]
    fn the_lectures_formula_is_this_one_at_a_constant_step() {
        let (h, drag) = (1.0_f64 / 60.0, 0.3_f64);
        let c = (1.0 - drag).powf(h);
        // Started with p_old = p - v h, like the state (v, l = h).
        let (mut p, mut p_old) = (0.0_f64, -2.0 * h);
        let mut particles = thrown(Vec3::Y * 2.0, drag as f32);
        particles.velocity[0].w = h as f32;
        for _ in 0..60 {
            let q = (1.0 + c) * p - c * p_old + h * h * f64::from(G.y);
            (p_old, p) = (p, q);
            advance(&mut particles, h as f32, G);
        }
        assert!((f64::from(particles.position(0).y) - p).abs() < 1e-5 * p.abs());
    }

    #[test]
    fn damping_loses_its_share_per_second_to_round_off_at_any_step() {
        for h in [1.0 / 30.0, 1.0 / 240.0, 1.0 / 1200.0] {
            for drag in [0.015_f32, 0.5, 0.98] {
                let mut particles = thrown(Vec3::X * 10.0, drag);
                let steps = (2.0 / h) as u32;
                for _ in 0..steps {
                    advance(&mut particles, h, Vec3::ZERO);
                }
                let t = (f64::from(steps) - 0.5) * f64::from(h);
                let exact = 10.0 * (1.0 - f64::from(drag)).powf(t);
                let error = (f64::from(particles.velocity(0).x) - exact).abs() / exact;
                assert!(error < 1e-5, "h {h} drag {drag}: {error}");
            }
        }
    }

    #[test]
    fn terminal_speed_is_the_one_at_which_damping_takes_what_gravity_gives() {
        let (h, drag) = (1.0 / 240.0, 0.8);
        let mut particles = thrown(Vec3::ZERO, drag);
        for _ in 0..240 * 20 {
            advance(&mut particles, h, G);
        }
        let lost = drag_of_rate(rate_of_drag(drag) * h);
        let exact = G.y * h / lost;
        assert!((particles.velocity(0).y / exact - 1.0).abs() < 1e-4);
    }

    /// Energy of an oscillator of 1 rad/s after `seconds` at steps of `h`, relative to its start, and its phase error in radians.
    fn oscillator(integrator: Integrator, h: f32, seconds: f32) -> (f64, f64) {
        let mut particles = Particles::default();
        particles.push(ParticleSeed::at(Vec3::X)).unwrap();
        let steps = (seconds / h).round() as u32;
        for _ in 0..steps {
            particles.clear_sums(0.0);
            let pull = -particles.position(0);
            particles.add_acceleration(0, pull);
            predict(&mut particles, integrator, h, &all(1), MACHINE);
            derive_all(&mut particles, integrator, h);
        }
        let x = particles.position(0);
        let v = particles.velocity(0) - x * (0.5 * particles.lag(0));
        let energy = f64::from(x.x * x.x + v.x * v.x);
        let phase = libm::atan2(f64::from(-v.x), f64::from(x.x));
        let exact = f64::from(steps) * f64::from(h);
        let whole = core::f64::consts::TAU;
        let error = (phase - exact).rem_euclid(whole);
        (energy, error.min(whole - error))
    }

    #[test]
    fn each_integrator_has_its_order_on_an_oscillator() {
        use Integrator::{ExplicitEuler, Leapfrog, SemiImplicitEuler, Verlet};
        for integrator in [Verlet, Leapfrog] {
            let errors = [0.2, 0.1, 0.05].map(|h| oscillator(integrator, h, 20.0).1);
            for pair in errors.windows(2) {
                assert!((pair[0] / pair[1] - 4.0).abs() < 0.3, "{integrator:?}: {errors:?}");
            }
        }
        for integrator in [SemiImplicitEuler, ExplicitEuler] {
            let errors = [0.02, 0.01, 0.005].map(|h| {
                let (energy, phase) = oscillator(integrator, h, 2.0);
                (energy - 1.0).abs() + phase
            });
            for pair in errors.windows(2) {
                assert!((pair[0] / pair[1] - 2.0).abs() < 0.2, "{integrator:?}: {errors:?}");
            }
        }
        assert!(oscillator(ExplicitEuler, 0.05, 50.0).0 > 5.0);
        for integrator in [Verlet, Leapfrog, SemiImplicitEuler] {
            assert!((oscillator(integrator, 0.05, 500.0).0 - 1.0).abs() < 0.06, "{integrator:?}");
        }
    }

    #[test]
    fn an_integrator_may_be_changed_on_the_way_without_losing_the_parabola() {
        let mut particles = thrown(Vec3::Y * 4.0, 0.0);
        let h = 1.0 / 60.0;
        for step in 0..90 {
            let integrator = if step % 20 < 10 { Integrator::Verlet } else { Integrator::Leapfrog };
            particles.clear_sums(0.0);
            particles.accelerate_all(G);
            predict(&mut particles, integrator, h, &all(1), MACHINE);
            derive_all(&mut particles, integrator, h);
        }
        let exact = 4.0 * 1.5 - 0.5 * 9.81 * 1.5 * 1.5;
        assert!((particles.position(0).y - exact).abs() < 1e-4, "{}", particles.position(0));
    }

    #[test]
    fn a_medium_that_moves_carries_the_particle_to_its_own_speed() {
        let mut particles = thrown(Vec3::ZERO, 0.0);
        for _ in 0..600 {
            particles.clear_sums(0.0);
            particles.drag_towards(0, 2.0, Vec3::X * 3.0);
            step(&mut particles, 1.0 / 60.0);
        }
        assert!((particles.velocity(0).x - 3.0).abs() < 1e-4);
    }

    #[test]
    fn swapping_the_two_positions_runs_the_motion_backwards() {
        let mut particles = thrown(Vec3::new(1.0, 5.0, 0.0), 0.0);
        let h = 1.0 / 60.0;
        for _ in 0..120 {
            advance(&mut particles, h, G);
        }
        let previous = particles.position(0) - particles.velocity(0) * h;
        particles.set_position(0, previous);
        particles.velocity[0] = (-particles.velocity(0)).extend(h);
        for _ in 0..119 {
            advance(&mut particles, h, G);
        }
        assert!(particles.position(0).length() < 1e-4, "{}", particles.position(0));
    }

    #[test]
    fn gravity_is_not_lost_far_from_the_origin() {
        // 1200 substeps a second add 6.8e-6 m each: less than the spacing of f32 at 200 m, so they were lost in `p - p_old`.
        let mut particles = Particles::default();
        particles.push(ParticleSeed::at(Vec3::Y * 200.0)).unwrap();
        for _ in 0..1200 {
            advance(&mut particles, 1.0 / 1200.0, G);
        }
        assert!((particles.velocity(0).y + 9.81 * (1.0 - 0.5 / 1200.0)).abs() < 1e-3);
        assert!((particles.position(0).y - 195.095).abs() < 0.01);
    }
}
