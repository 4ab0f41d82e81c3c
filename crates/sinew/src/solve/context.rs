//! The context of a substep, the same for all islands.

use core::ops::Range;

use super::plan::Plan;
use crate::collide::{InstantInterval, NormalImpulses, ParticleContacts};
use crate::particles::Places;
use crate::threads::ExecutionContext;

/// One of the microsteps into which a substep is divided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Microstep {
    /// Counted from 0.
    pub(crate) number: u32,
    pub(crate) of: u32,
}

impl Microstep {
    /// A substep that is not divided.
    pub(crate) const WHOLE: Self = Self { number: 0, of: 1 };
}

/// The parameters of a substep.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SubstepParameters {
    /// Length, seconds.
    pub(crate) h: f32,
    /// The lag of derived velocities, seconds: each is the mean velocity over this time.
    pub(crate) lag: f32,
    /// Magnitude of gravity, m/s².
    pub(crate) gravity: f32,
    /// The number of the substep in its step, counted from 0, and the number of substeps.
    pub(crate) number: u32,
    pub(crate) of: u32,
}

/// What solving reads, the same for all islands.
#[derive(Clone, Copy)]
pub(crate) struct SolveContext<'a> {
    pub(crate) plan: &'a Plan,
    pub(crate) contacts: &'a ParticleContacts,
    pub(crate) substep: SubstepParameters,
    /// Which part of the substep it is.
    pub(crate) microstep: Microstep,
    pub(crate) execution: ExecutionContext<'a>,
}

impl<'a> SolveContext<'a> {
    /// The context of a whole substep.
    pub(crate) fn new(
        plan: &'a Plan,
        contacts: &'a ParticleContacts,
        substep: SubstepParameters,
        execution: ExecutionContext<'a>,
    ) -> Self {
        Self { plan, contacts, substep, microstep: Microstep::WHOLE, execution }
    }

    /// The context of a microstep of `h` seconds.
    pub(super) fn divided(self, microstep: Microstep, h: f32) -> Self {
        let substep = SubstepParameters { h, lag: h, ..self.substep };
        Self { substep, microstep, ..self }
    }

    /// The context of the substep that comes `by` substeps later in the step.
    pub(super) fn later(self, by: u32) -> Self {
        let number = self.substep.number + by;
        Self { substep: SubstepParameters { number, ..self.substep }, ..self }
    }

    /// The times between which surfaces move in it.
    pub(super) fn interval(&self) -> InstantInterval {
        let Microstep { number, of } = self.microstep;
        self.contacts.interval(self.substep.number, number, of)
    }

    /// The same context for a single worker.
    pub(super) fn by_one(self) -> Self {
        Self { execution: ExecutionContext { workers: None, ..self.execution }, ..self }
    }

    /// Applies restitution to rows that touched something, after their velocities have been derived.
    pub(super) fn bounce(
        &self,
        places: &mut Places,
        normal_impulses: &mut NormalImpulses,
        rows: Range<u32>,
    ) {
        if self.contacts.bounces() {
            self.contacts.bounce(places, normal_impulses, rows, self.substep.h);
        }
    }
}
