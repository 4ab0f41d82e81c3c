//! Statics: the state that everything comes to rest in, without waiting for it (physics.md F9).
//!
//! With all drag there is, a step forgets its velocity: each particle falls by `½ h² a` from rest, constraints correct it, and that is all. So the
//! state walks down the slope of its energy, under its constraints, until it finds no lower place nearby: a local minimum, the chain that hangs as
//! a catenary.

use super::{Simulation, StepFault};

/// How far [`Simulation::relax`] came.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Relaxed {
    /// Steps that it took.
    pub steps: u32,
    /// How far the particle that moved most went in the last of them, metres.
    pub moved: f32,
    /// Whether that was within the tolerance.
    pub settled: bool,
}

impl Simulation {
    /// Walks to rest by steps of `dt` seconds, until no particle moves by more than `tolerance` metres in one, or `most` steps are taken. Afterwards
    /// everything stands still, and time has not passed: what depends on it, such as gusts, has blown as it did at the start.
    ///
    /// A longer `dt` walks faster, as its square. Strong springs need a short one: `ω h < 2`, as ever.
    ///
    /// ```
    /// use sinew::{Simulation, glam::Vec3, recipes::{RopeSpec, rope}};
    ///
    /// // A rope of 1.5 m between two nails 1 m apart: it sags by 0.5026 m, as a catenary does.
    /// let mut world = Simulation::default();
    /// world.settings.max_sweeps = 50;
    /// let spec = RopeSpec { to: Vec3::X, segments: 20, slack: 0.5, pin_start: true, pin_end: true, ..Default::default() };
    /// rope(&spec)?.build(&mut world)?;
    /// let found = world.relax(0.2, 1e-5, 2000)?;
    /// let sag = -world.particles.position(10).y;
    /// assert!(found.settled && (sag / 0.50345 - 1.0).abs() < 5e-3, "{found:?} {sag}");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// A `dt` that is not positive and finite is refused and nothing changes.
    pub fn relax(&mut self, dt: f32, tolerance: f32, most: u32) -> Result<Relaxed, StepFault> {
        let (time, statics) = (self.time, core::mem::replace(&mut self.settings.statics, true));
        let mut found = Relaxed { steps: 0, moved: f32::INFINITY, settled: false };
        let mut outcome = Ok(());
        while found.steps < most && !found.settled && outcome.is_ok() {
            outcome = self.step(dt).map(|_| ());
            self.time = time;
            found.steps += 1;
            found.moved =
                (0..self.particles.len()).map(|i| self.moved_in_step(i)).fold(0.0, f32::max);
            found.settled = found.moved <= tolerance;
        }
        self.settings.statics = statics;
        outcome?;
        for i in 0..self.particles.len() {
            self.particles.set_velocity(i, glam::Vec3::ZERO);
        }
        Ok(found)
    }

    /// How far particle `i` went in the last step, metres.
    fn moved_in_step(&self, i: usize) -> f32 {
        let began = self.scratch.checkpoint[i].truncate();
        (self.particles.position[i].truncate() - began).length()
    }
}
