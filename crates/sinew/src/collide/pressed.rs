//! What contacts ask of large cloth that body colliders press on: which particles go along with one that is pushed, and to be held by its constraints.
//!
//! Contacts know of no constraints, and constraints are solved elsewhere; so this is an interface, and [`solve`](crate::solve) has the other side of it.

use glam::{Mat3, Vec3};

use super::particle_contact::{NormalImpulse, ParticleContacts};
use crate::particles::Particles;

/// Cloth that body colliders press on, as contacts see it.
pub(crate) trait PressedCloth {
    /// The particles that go along with that of a row when it is pushed; `None` if that goes alone.
    fn aggregate(&mut self, particles: &Particles, row: u32, push: Push) -> Option<Aggregate<'_>>;

    /// Moves particles of such rows, in any order and some more than once, as their constraints have it, and others with them; those then leave the colliders
    /// that they touch by themselves. Returns whether it moved any. The list is its own from then on.
    fn hold(
        &mut self,
        particles: &mut Particles,
        beside: (&ParticleContacts, &mut [NormalImpulse]),
        rows: &mut Vec<u32>,
    ) -> bool;
}

/// How a particle is pushed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Push {
    /// How far it is pushed in a substep, or would be if it went alone, metres.
    pub(crate) distance: f32,
    /// How much those that go along may weigh, kg.
    pub(crate) mass: f32,
}

/// Particles that are pushed together, as if they were a rigid body of which each has a share: an impulse moves the body, and each of them by its share of what it would go
/// along. So momentum is kept, and so are moments about where the substep began, which is what Verlet keeps.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Aggregate<'a> {
    /// 1/kg: one by the sum of their masses, each as often as its share is.
    pub(crate) inverse_mass: f32,
    /// Of the same, 1/(kg m²); zero of what has no width, which does not turn.
    pub(crate) inverse_inertia: Mat3,
    /// From the barycentre of the same to the particle in their middle, metres.
    pub(crate) lever: Vec3,
    /// Rows, with the numbers of their rings about the middle.
    pub(crate) members: &'a [(u32, u32)],
    /// How many rings there are: the share of ring `i` of `n` is `1 - i/n`.
    pub(crate) rings: u32,
}

impl Aggregate<'_> {
    /// How far an impulse on the particle in the middle moves it along the direction of both, a unit vector, for each kg m, 1/kg.
    #[inline]
    pub(crate) fn compliance(&self, along: Vec3) -> f32 {
        let moment = self.lever.cross(along);
        self.inverse_mass + moment.dot(self.inverse_inertia * moment)
    }

    /// Moves the particles by an impulse on the one in their middle, whose row is `middle`: kg m, a mass times how far it is moved in the substep.
    pub(crate) fn apply_impulse(&self, particles: &mut Particles, middle: u32, impulse: Vec3) {
        let shift = impulse * self.inverse_mass;
        let turn = self.inverse_inertia * self.lever.cross(impulse);
        let barycentre = particles.start[middle as usize].truncate() - self.lever;
        for &(row, ring) in self.members {
            let share = ring_share(ring, self.rings);
            let lever = particles.start[row as usize].truncate() - barycentre;
            let position = &mut particles.position[row as usize];
            if position.w > 0.0 {
                *position += ((shift + turn.cross(lever)) * share).extend(0.0);
            }
        }
    }
}

/// The share of what is in a ring of so many.
#[inline]
pub(crate) fn ring_share(ring: u32, rings: u32) -> f32 {
    1.0 - ring as f32 / rings as f32
}

/// No cloth.
#[cfg(test)]
impl PressedCloth for () {
    fn aggregate(&mut self, _: &Particles, _: u32, _: Push) -> Option<Aggregate<'_>> {
        None
    }

    fn hold(
        &mut self,
        _: &mut Particles,
        _: (&ParticleContacts, &mut [NormalImpulse]),
        _: &mut Vec<u32>,
    ) -> bool {
        false
    }
}
