//! Steps that change nothing: where all sleep, and nothing has been touched since a step that left everything as it was, the next one leaves it, too, and
//! need not be taken. Only the time passes.
//!
//! A step is a function of the particles, of what acts on them and of its length. Of sleepers the time is no part of that: gusts that may move somebody keep
//! him awake. A step at rest leaves its particles as they are when the one before it has been at rest, too, for that has stopped them. So it takes two such
//! steps with the same inputs; from then on the inputs are compared, and that is all.

use super::sleep::Sleep;
use super::{Scratch, Simulation};
use crate::collide::{BodyContacts, Collider, ContactParticipant};
use crate::constraints::Boundaries;
use crate::forces::Forces;
use crate::kept::Kept;
use crate::settings::{BodySettings, SolverSettings};
use crate::tracked::Tracked;

/// What a step depends on, beside the columns of the particles, which number what is [written](crate::Particles::writes) to them, and the constraints, of which
/// changes are noted.
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

/// What is remembered of steps at rest.
#[derive(Debug, Default)]
pub(super) struct Rest {
    /// Those of the last step, if all slept in it.
    inputs: Option<Box<Inputs>>,
    /// Whether the step before had the same ones.
    settled: bool,
}

impl Simulation {
    /// Takes a whole step of `dt` seconds, if all that it would change is the time: all sleep, and nothing has changed since the last two steps, in which
    /// they slept, too. Says whether it has; otherwise nothing happened, and the step is yet to be taken.
    ///
    /// For who takes the step in [phases](Self::begin_step), and lets nobody else do something between them. [`step`](Self::step) does it by itself.
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
        let same = rest.settled && rest.inputs.as_ref().is_some_and(|inputs| self.has(inputs, dt));
        if !same {
            return false;
        }
        let substeps = self.settings.clamped().substeps;
        // As many small sums as otherwise, so that it comes out the same.
        (0..substeps).for_each(|_| self.time += f64::from(dt / substeps as f32));
        self.report.frozen.clear();
        self.report.too_fast.clear();
        true
    }

    /// Whether the last two steps were such: the next is one, too, if nothing changes until then. The particles and the constraints have not so far; what else a
    /// step depends on is not looked at.
    pub fn is_settled(&self) -> bool {
        let Scratch { rest: Kept(rest), changes, .. } = &self.scratch;
        let inputs = rest.inputs.as_ref().filter(|_| rest.settled && changes.is_empty());
        inputs.is_some_and(|inputs| inputs.writes == self.particles.writes())
    }

    /// Notes, when a step ends, whether it was one at rest, and of what.
    pub(super) fn note_rest(&mut self) {
        let scratch = &self.scratch;
        let slept = scratch.at_rest
            && scratch.loads.is_empty()
            && scratch.plan.islands.list.iter().all(|island| island.asleep)
            && !self.report.frozen.iter().chain(&self.report.too_fast).any(|_| true)
            && !self.hears_of_contacts();
        let dt = self.scratch.length;
        let before = self.scratch.rest.0.inputs.take();
        self.scratch.rest.0.settled = false;
        if !slept {
            return;
        }
        if let Some(inputs) = before.filter(|inputs| self.has(inputs, dt)) {
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

    /// Whether a step of `dt` seconds would have these.
    fn has(&self, inputs: &Inputs, dt: f32) -> bool {
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

    /// Whether somebody is to be told of contacts, those at rest included.
    pub(super) fn hears_of_contacts(&self) -> bool {
        self.colliders.iter().any(|collider| collider.events)
            || self.contacts.iter().any(|body| body.events)
    }
}
