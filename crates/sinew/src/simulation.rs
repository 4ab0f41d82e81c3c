//! The simulation: particles, forces and constraints, and one method for each phase of a step.

use glam::{Vec3, Vec4};

use crate::constraints::{Constraints, Contacts, Distance};
use crate::forces::{self, Forces};
use crate::particles::Particles;
use crate::solve::{self, Plan, SolverReport, SolverSettings};
use crate::{integrate, ledger};

/// A world of particles.
///
/// [`step`](Self::step) does it all. An engine that lets a game put its own systems between the phases calls
/// [`begin_step`](Self::begin_step), then for each substep [`begin_substep`](Self::begin_substep) and the phases in their order, then [`end_step`](Self::end_step).
#[derive(Clone, Debug, Default)]
pub struct Simulation {
    /// Configuration of the solver.
    pub settings: SolverSettings,
    /// The particles: live state.
    pub particles: Particles,
    /// What accelerates them.
    pub forces: Forces,
    /// What holds single particles.
    pub constraints: Constraints,
    /// Simulated time in seconds at the start of the current substep; gusts of wind depend on it.
    pub time: f64,
    distances: Vec<Distance>,
    scratch: Scratch,
    report: SolverReport,
}

/// What a step needs and nobody saves.
#[derive(Clone, Debug, Default)]
struct Scratch {
    plan: Plan,
    stale: bool,
    substep: Substep,
    charged: Vec<u32>,
    contacts: Contacts,
    /// The pressure of each wind on each triangle, looked up when the step began.
    pressures: Vec<Vec3>,
    /// Where the step began, with the inverse mass: what went non-finite took that with it.
    checkpoint: Vec<Vec4>,
}

/// Where in a step the simulation is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Substep {
    /// Length of a substep, seconds.
    pub length: f32,
    /// Substeps to go, the current one included.
    pub remaining: u32,
}

/// Why a step was not taken.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "a step of {0} s cannot be taken: it must be positive and finite, and not too short to halve"
)]
pub struct StepFault(pub f32);

impl Simulation {
    /// Advances by `dt` seconds and reports how it went.
    ///
    /// # Errors
    /// A `dt` that is not positive and finite is refused and nothing changes.
    pub fn step(&mut self, dt: f32) -> Result<&SolverReport, StepFault> {
        let substeps = self.begin_step(dt)?;
        for _ in 0..substeps {
            self.begin_substep();
            self.accumulate_forces();
            self.apply_wind();
            self.apply_buoyancy();
            self.apply_electric();
            self.integrate();
            self.solve_constraints();
        }
        self.end_step();
        Ok(&self.report)
    }

    /// Begins a step of `dt` seconds: compiles the plan if distances changed, and returns the number of substeps to take.
    ///
    /// # Errors
    /// A `dt` that is not positive and finite is refused and nothing changes.
    pub fn begin_step(&mut self, dt: f32) -> Result<u32, StepFault> {
        // What froze in the last step did not freeze in this one, taken or not.
        self.report.frozen.clear();
        let settings = self.settings.clamped();
        let h = dt / settings.substeps as f32;
        // 1/h² must be a number: compliances are scaled by it.
        if !(dt.is_finite() && h > 0.0 && (1.0 / (h * h)).is_finite()) {
            return Err(StepFault(dt));
        }
        if self.scratch.stale || self.scratch.plan.rows != self.particles.len() {
            self.scratch.plan.compile(&self.distances, self.particles.len());
            self.scratch.stale = false;
        }
        self.scratch.substep = Substep { length: h, remaining: settings.substeps };
        self.scratch.checkpoint.resize(self.particles.len(), Vec4::ZERO);
        for (good, q) in self.scratch.checkpoint.iter_mut().zip(&self.particles.position) {
            // A row that a caller set to no position at all goes back to the last one it had.
            *good = if q.is_finite() { *q } else { good.truncate().extend(q.w) };
        }
        self.scratch.contacts.take(&self.constraints.planes, &self.constraints.boxes);
        self.feel_winds();
        self.report.substeps = settings.substeps;
        self.report.sweeps = 0;
        self.report.most_sweeps = 0;
        self.report.converged = true;
        Ok(settings.substeps)
    }

    /// Looks up the gusts on every triangle.
    fn feel_winds(&mut self) {
        let Self { particles, forces, scratch, .. } = self;
        scratch.pressures.clear();
        for wind in &forces.winds {
            forces::sample_wind(
                particles,
                &forces.surfaces,
                wind,
                self.time,
                &mut scratch.pressures,
            );
        }
    }

    /// Where in the step the simulation is: the length of a substep and how many are left.
    pub fn substep(&self) -> Substep {
        self.scratch.substep
    }

    /// Begins a substep: the sums of forces and of damping start afresh. From here to `integrate`, forces add up in any order.
    pub fn begin_substep(&mut self) {
        forces::reset(&mut self.particles, &self.forces);
    }

    /// Phase 1: adds gravity, the game's own forces and springs.
    pub fn accumulate_forces(&mut self) {
        forces::apply_gravity_and_external(&mut self.particles, &self.forces);
        forces::apply_springs(&mut self.particles, &self.forces.springs);
    }

    /// Phase 2: adds the pressure of the winds on the surfaces.
    pub fn apply_wind(&mut self) {
        let pressures = &self.scratch.pressures;
        forces::apply_wind(&mut self.particles, &self.forces.surfaces, pressures);
    }

    /// Phase 3: adds the buoyancy and the drag of the fluids.
    pub fn apply_buoyancy(&mut self) {
        let (fluids, gravity) = (&self.forces.fluids, self.forces.gravity);
        forces::apply_buoyancy(&mut self.particles, fluids, gravity);
    }

    /// Phase 4: adds the forces between charges.
    pub fn apply_electric(&mut self) {
        let charged = &mut self.scratch.charged;
        forces::apply_electric(&mut self.particles, &self.forces.electric, charged);
    }

    /// Phase 5: predicts the next positions by Verlet integration, and leads the pinned particles towards their targets.
    pub fn integrate(&mut self) {
        let Substep { length, remaining } = self.scratch.substep;
        integrate::predict(&mut self.particles, length);
        for pin in &self.constraints.pins {
            let i = pin.particle as usize;
            if i < self.particles.len() && pin.target.is_finite() {
                let led = pin.lead(self.particles.position(i), remaining);
                self.particles.set_position(i, led);
            }
        }
    }

    /// Phase 6: enforces the constraints, derives the velocities from where the particles ended, and closes the substep.
    pub fn solve_constraints(&mut self) {
        let settings = self.settings.clamped();
        let h = self.scratch.substep.length;
        solve::cascade(
            &mut self.particles,
            &self.scratch.contacts,
            &mut self.scratch.plan,
            &settings,
            h,
            &mut self.report,
        );
        integrate::derive_velocities(&mut self.particles, h);
        self.time += f64::from(h);
        self.scratch.substep.remaining = self.scratch.substep.remaining.saturating_sub(1);
    }

    /// Ends a step: puts rows that turned non-finite back to where the step began, at rest, and measures the errors left.
    pub fn end_step(&mut self) {
        for i in 0..self.particles.len() {
            if !self.particles.is_finite(i) {
                let good = self.scratch.checkpoint.get(i).copied().unwrap_or_default();
                self.particles.position[i] = good;
                self.particles.start[i] = good.truncate();
                self.particles.set_velocity(i, Vec3::ZERO);
                self.report.frozen.push(i as u32);
            }
        }
        solve::measure(
            &self.particles,
            &self.scratch.contacts,
            &self.scratch.plan,
            &mut self.report,
        );
    }

    /// Where particle `i` was when the last step began, metres: for drawing what lies between two steps.
    pub fn step_start(&self, i: usize) -> Vec3 {
        let began = self.scratch.checkpoint.get(i);
        began.map_or_else(|| self.particles.position(i), |q| q.truncate())
    }

    /// Forgets where the particles were when the last step began, because rows now hold other particles.
    pub fn forget_step_start(&mut self) {
        self.scratch.checkpoint.clear();
    }

    /// How the last step went.
    pub fn report(&self) -> &SolverReport {
        &self.report
    }

    /// The distances, in the order in which they were added.
    pub fn distances(&self) -> &[Distance] {
        &self.distances
    }

    /// The distances, to add to, change or remove from. The plan is compiled afresh at the next step; a faulty distance is left out of it.
    pub fn distances_mut(&mut self) -> &mut Vec<Distance> {
        self.scratch.stale = true;
        &mut self.distances
    }

    /// The most groups that an island has in the plan: distances of one kind and one colour, which share no particle.
    pub fn colours(&self) -> usize {
        self.scratch.plan.islands.iter().map(|island| island.groups.len()).max().unwrap_or(0)
    }

    /// Number of islands: sets of particles that distances connect, a loose particle being one by itself.
    pub fn islands(&self) -> usize {
        self.scratch.plan.islands.len()
    }

    /// Velocity of particle `i` at the instant of its position, m/s: the mean velocity of the last substep, carried half a substep
    /// further by the acceleration that [`accumulate_forces`](Self::accumulate_forces) and its followers last summed up.
    pub fn velocity_now(&self, i: usize) -> Vec3 {
        self.particles.velocity(i) + self.particles.acceleration(i) * (0.5 * self.particles.lag(i))
    }

    /// Energy and momentum of the whole world. It sums up the forces afresh, so that velocities and positions are of one instant.
    pub fn ledger(&mut self) -> ledger::Ledger {
        self.feel_winds();
        self.begin_substep();
        self.accumulate_forces();
        self.apply_wind();
        self.apply_buoyancy();
        self.apply_electric();
        ledger::take(self)
    }
}
