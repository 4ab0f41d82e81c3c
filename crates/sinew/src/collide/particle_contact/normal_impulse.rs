//! What a contact has done so far: what bouncing and the report need to know of it.

use glam::Vec3;

use super::ParticleContact;
use crate::particles::Places;

/// One candidate's contact.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct NormalImpulse {
    /// Unit vector to the allowed side, of the last projection.
    pub(super) normal: Vec3,
    /// How far it was put out in this substep, metres; 0 where it did not touch.
    pub(super) depth: f32,
    /// Velocity of the surface there, m/s; times the length of a substep until that is known.
    pub(super) carried: Vec3,
    /// Speed towards the allowed side that the row came with into this substep, less that of the surface, m/s.
    pub(super) approach: f32,
    /// The impulse so far in the step, N·s: mass times how far it was put out, by the length of the substep.
    pub(super) sum: f32,
}

/// Those of consecutive candidates, to be written by whoever solves their rows.
pub(crate) struct NormalImpulses<'a> {
    first: u32,
    all: &'a mut [NormalImpulse],
}

impl<'a> NormalImpulses<'a> {
    /// All of a world.
    pub(crate) fn all(all: &'a mut [NormalImpulse]) -> Self {
        Self { first: 0, all }
    }

    /// Those before the candidate of a number, and the others.
    pub(super) fn split_at(self, number: u32) -> (Self, Self) {
        let count = (number.saturating_sub(self.first) as usize).min(self.all.len());
        let (own, rest) = self.all.split_at_mut(count);
        (
            NormalImpulses { first: self.first, all: own },
            NormalImpulses { first: self.first + count as u32, all: rest },
        )
    }

    /// The same, lent on.
    pub(crate) fn lend(&mut self) -> NormalImpulses<'_> {
        NormalImpulses { first: self.first, all: self.all }
    }

    /// That of a candidate.
    #[inline]
    pub(super) fn at(&mut self, number: u32) -> &mut NormalImpulse {
        &mut self.all[(number - self.first) as usize]
    }
}

impl NormalImpulse {
    /// Takes note of a contact that is about to be resolved.
    #[inline]
    pub(super) fn take(&mut self, places: &Places, row: u32, contact: &ParticleContact) {
        let i = places.at(row);
        if self.depth == 0.0 {
            // Before velocities are derived, the column holds what led into the substep's prediction.
            self.approach = places.velocity[i].truncate().dot(contact.normal);
        }
        self.normal = contact.normal;
        self.carried = contact.carried;
        self.depth += contact.depth;
    }
}
