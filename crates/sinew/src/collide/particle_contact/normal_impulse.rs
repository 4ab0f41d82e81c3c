//! Accumulated result of a contact, for restitution and contact events.

use glam::Vec3;

use super::ParticleContact;
use crate::particles::Places;

/// Accumulated contact of one candidate.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct NormalImpulse {
    /// Unit vector to the allowed side, of the last projection.
    pub(super) normal: Vec3,
    /// Accumulated depth in this substep, metres; 0 where it did not touch.
    pub(super) depth: f32,
    /// Displacement of the surface at the contact in this substep, metres; divided by the length of the substep, its velocity.
    pub(super) carried: Vec3,
    /// Velocity of the row along the normal at the start of this substep, m/s; negative when approaching.
    pub(super) approach: f32,
    /// Normal velocity that the contact has added in this substep, m/s, in positions and by restitution; 0 where it did not touch.
    pub(super) pressed: f32,
    /// Accumulated impulse in the step, N·s: in each substep mass times depth / h.
    pub(super) sum: f32,
}

/// Contacts of consecutive candidates, to be written while their rows are solved.
pub(crate) struct NormalImpulses<'a> {
    first: u32,
    all: &'a mut [NormalImpulse],
}

impl<'a> NormalImpulses<'a> {
    /// All contacts of a world.
    pub(crate) fn all(all: &'a mut [NormalImpulse]) -> Self {
        Self { first: 0, all }
    }

    /// Splits off the contacts before a candidate.
    pub(super) fn split_at(self, number: u32) -> (Self, Self) {
        let count = (number.saturating_sub(self.first) as usize).min(self.all.len());
        let (own, rest) = self.all.split_at_mut(count);
        (
            NormalImpulses { first: self.first, all: own },
            NormalImpulses { first: self.first + count as u32, all: rest },
        )
    }

    /// Reborrows.
    pub(crate) fn reborrow(&mut self) -> NormalImpulses<'_> {
        NormalImpulses { first: self.first, all: self.all }
    }

    /// The contact of a candidate.
    #[inline]
    pub(super) fn at(&mut self, number: u32) -> &mut NormalImpulse {
        &mut self.all[(number - self.first) as usize]
    }
}

impl NormalImpulse {
    /// Records a contact that is about to be resolved.
    #[inline(always)]
    pub(super) fn record(&mut self, places: &Places, row: u32, contact: &ParticleContact) {
        let i = places.at(row);
        let normal = Vec3::from(contact.normal);
        if self.depth == 0.0 {
            // Until velocities are derived, the column holds those that led into the prediction of the substep.
            self.approach = places.velocity[i].truncate().dot(normal);
        }
        self.normal = normal;
        self.carried = contact.carried.into();
        self.depth += contact.depth;
    }
}
