//! What solving needs to know of a substep, the same for all islands.

use core::ops::Range;

use super::plan::Plan;
use crate::collide::{InstantInterval, NormalImpulses, ParticleContacts};
use crate::particles::Places;
use crate::threads::ExecutionContext;

/// Which of several microsteps of a substep it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Microstep {
    /// From 0.
    pub(crate) number: u32,
    pub(crate) of: u32,
}

impl Microstep {
    /// A substep that is not divided.
    pub(crate) const WHOLE: Self = Self { number: 0, of: 1 };
}

/// A substep, whatever is solved in it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SubstepParameters {
    /// Length, seconds.
    pub(crate) h: f32,
    /// How much of it a derived velocity is the mean of, seconds.
    pub(crate) lag: f32,
    /// Magnitude of gravity, m/s².
    pub(crate) gravity: f32,
    /// Which of the step it is, counted from 0, and of how many.
    pub(crate) number: u32,
    pub(crate) of: u32,
}

/// What solving needs to know, the same for all islands.
#[derive(Clone, Copy)]
pub(crate) struct SolveContext<'a> {
    pub(crate) plan: &'a Plan,
    pub(crate) contacts: &'a ParticleContacts,
    pub(crate) substep: SubstepParameters,
    /// Which part of it.
    pub(crate) microstep: Microstep,
    pub(crate) execution: ExecutionContext<'a>,
}

impl<'a> SolveContext<'a> {
    /// That of a whole substep.
    pub(crate) fn new(
        plan: &'a Plan,
        contacts: &'a ParticleContacts,
        substep: SubstepParameters,
        execution: ExecutionContext<'a>,
    ) -> Self {
        Self { plan, contacts, substep, microstep: Microstep::WHOLE, execution }
    }

    /// The same in a part of `h` seconds of the substep.
    pub(super) fn divided(self, microstep: Microstep, h: f32) -> Self {
        let substep = SubstepParameters { h, lag: h, ..self.substep };
        Self { substep, microstep, ..self }
    }

    /// The same in a later substep of the step, by so many.
    pub(super) fn later(self, by: u32) -> Self {
        let number = self.substep.number + by;
        Self { substep: SubstepParameters { number, ..self.substep }, ..self }
    }

    /// From when to when surfaces move in it.
    pub(super) fn interval(&self) -> InstantInterval {
        let Microstep { number, of } = self.microstep;
        self.contacts.interval(self.substep.number, number, of)
    }

    /// The same, for one worker alone.
    pub(super) fn by_one(self) -> Self {
        Self { execution: ExecutionContext { workers: None, ..self.execution }, ..self }
    }

    /// Bounces rows off what they touched, when their velocities have been derived.
    pub(super) fn bounce(
        &self,
        places: &mut Places,
        normal_impulses: &mut NormalImpulses,
        rows: Range<u32>,
    ) {
        if self.contacts.bounces() {
            self.contacts.bounce(
                places,
                normal_impulses,
                rows,
                (self.substep.h, self.substep.gravity),
            );
        }
    }
}
