//! Skips steps that change nothing: if all bodies sleep, and nothing was changed since a step that left everything as it was, the next step would do so too.
//! Only the time advances.
//!
//! A step is a function of the particles, of what acts on them and of its length. For sleepers the time is not an input: bodies that gusts could move are kept
//! awake. A step with everything asleep leaves the particles unchanged if the step before it was one too, because that one set their velocities to zero. So it
//! takes two such steps with the same inputs; from then on only the inputs are compared.

use super::sleep::Sleep;
use super::{Scratch, Simulation};
use crate::collide::{BodyContacts, Collider, ContactParticipant};
use crate::constraints::Boundaries;
use crate::forces::Forces;
use crate::not_cloned::NotCloned;
use crate::settings::{BodySettings, SolverSettings};
use crate::tracked::Tracked;

/// Inputs of a step, except the columns of the particles, whose writes are [counted](crate::Particles::writes), and the constraints, whose changes are recorded.
#[derive(Clone, Debug, PartialEq)]
struct Inputs {
    /// Seconds.
    dt: f32,
    writes: [u64; 2],
    settings: SolverSettings,
    forces: Forces,
    boundaries: Boundaries,
    colliders: Vec<Collider>,
    bodies: Tracked<Vec<BodySettings>>,
    contacts: Tracked<Vec<BodyContacts>>,
    ignored: Vec<[ContactParticipant; 2]>,
    sleep: Tracked<Vec<Sleep>>,
}

/// Record of the last steps with everything asleep.
#[derive(Debug, Default)]
pub(super) struct Rest {
    /// Inputs of the last step, if everything slept in it.
    inputs: Option<Box<Inputs>>,
    /// Whether the step before had the same inputs.
    settled: bool,
}

impl Simulation {
    /// Skips a step of `dt` seconds if the time is all that it would change: everything sleeps, and nothing has changed since the last two steps, in which
    /// everything slept too. Returns whether it did; if not, nothing happened, and the step must still be taken.
    ///
    /// For callers that run the step in [phases](Self::begin_step) and let nothing else act between them. [`step`](Self::step) does it by itself.
    ///
    /// ```
    /// use sinew::{ParticleSeed, Simulation, Sleep, constraints::Plane, glam::Vec3};
    ///
    /// let mut world = Simulation::default();
    /// world.boundaries.planes.push(Plane::ground(0.0));
    /// let pebble = world.particles.push(ParticleSeed::at(Vec3::Y).with_radius(0.1))?;
    /// world.particles.set_body(0, Some(0));
    /// world.sleep.push(Sleep::allowed());
    /// assert!(!world.step_at_rest(1.0 / 60.0), "it falls");
    /// for _ in 0..300 {
    ///     world.step(1.0 / 60.0)?;
    /// }
    /// assert!(world.step_at_rest(1.0 / 60.0), "it lies on the ground");
    /// world.particles.add_impulse(pebble as usize, Vec3::Y);
    /// assert!(!world.step_at_rest(1.0 / 60.0), "it was kicked");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn step_at_rest(&mut self, dt: f32) -> bool {
        let rest = &self.scratch.rest.0;
        let same =
            rest.settled && rest.inputs.as_ref().is_some_and(|inputs| self.has_inputs(inputs, dt));
        if !same {
            return false;
        }
        let substeps = self.settings.clamped().substeps;
        // Summed substep by substep, so that the time has the same bits as otherwise.
        (0..substeps).for_each(|_| self.time += f64::from(dt / substeps as f32));
        self.report.frozen.clear();
        self.report.too_fast.clear();
        true
    }

    /// Whether the last two steps were at rest, so that the next is one too if nothing changes until then. Compares only the particles and the constraints, not
    /// the other inputs of a step.
    pub fn is_settled(&self) -> bool {
        let Scratch { rest: NotCloned(rest), changes, .. } = &self.scratch;
        let inputs = rest.inputs.as_ref().filter(|_| rest.settled && changes.is_empty());
        inputs.is_some_and(|inputs| inputs.writes == self.particles.writes())
    }

    /// Records, when a step ends, whether everything slept in it, and its inputs.
    pub(super) fn record_rest(&mut self) {
        let scratch = &self.scratch;
        let slept = scratch.at_rest
            && scratch.loads.is_empty()
            && scratch.plan.islands.list.iter().all(|island| island.asleep)
            && !self.report.frozen.iter().chain(&self.report.too_fast).any(|_| true)
            && !self.reports_contacts();
        let dt = self.scratch.length;
        let before = self.scratch.rest.0.inputs.take();
        self.scratch.rest.0.settled = false;
        if !slept {
            return;
        }
        if let Some(inputs) = before.filter(|inputs| self.has_inputs(inputs, dt)) {
            self.scratch.rest.0 = Rest { inputs: Some(inputs), settled: true };
            return;
        }
        let inputs = Inputs {
            dt,
            writes: self.particles.writes(),
            settings: self.settings,
            forces: self.forces.clone(),
            boundaries: self.boundaries.clone(),
            colliders: self.colliders.clone(),
            bodies: self.bodies.clone(),
            contacts: self.contacts.clone(),
            ignored: self.ignored.clone(),
            sleep: self.sleep.clone(),
        };
        self.scratch.rest.0.inputs = Some(Box::new(inputs));
    }

    /// Whether these are the inputs of a step of `dt` seconds now.
    fn has_inputs(&self, inputs: &Inputs, dt: f32) -> bool {
        let Inputs { writes, settings, forces, boundaries, colliders, .. } = inputs;
        let Inputs { bodies, contacts, ignored, sleep, .. } = inputs;
        self.scratch.changes.is_empty()
            && inputs.dt == dt
            && *writes == self.particles.writes()
            && *settings == self.settings
            && *sleep == self.sleep
            && *colliders == self.colliders
            && *boundaries == self.boundaries
            && *forces == self.forces
            && *bodies == self.bodies
            && *contacts == self.contacts
            && *ignored == self.ignored
    }

    /// Whether contact events are reported anywhere, contacts at rest included.
    pub(super) fn reports_contacts(&self) -> bool {
        self.colliders.iter().any(|collider| collider.events)
            || self.contacts.iter().any(|body| body.events)
    }
}
