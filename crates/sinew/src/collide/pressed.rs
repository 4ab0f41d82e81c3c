//! Interface from contacts to large cloth that body colliders press on: which particles move along with a pushed one, and how moved particles are held by their
//! constraints.
//!
//! Contacts do not depend on constraints, which are solved elsewhere; [`solve`](crate::solve) implements this interface.

use glam::{Mat3, Vec3};

use super::particle_contact::{NormalImpulse, ParticleContacts};
use crate::particles::Particles;

/// Cloth under the pressure of body colliders, as contacts use it.
pub(crate) trait PressedCloth {
    /// The particles that move along with that of a row when it is pushed; `None` if it moves alone.
    fn aggregate(&mut self, particles: &Particles, row: u32, push: Push) -> Option<Aggregate<'_>>;

    /// Projects the constraints of the particles of some rows, in any order and with duplicates, moving others too; all of them are then projected out of the
    /// particle contacts in `beside`. Returns whether any particle was moved. The list may be reordered and shortened.
    fn project(
        &mut self,
        particles: &mut Particles,
        beside: (&ParticleContacts, &mut [NormalImpulse]),
        rows: &mut Vec<u32>,
    ) -> bool;
}

/// Size of a push.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Push {
    /// Displacement of the particle in a substep if it moved alone, metres.
    pub(crate) distance: f32,
    /// Upper bound for the mass of the particles that move along, kg.
    pub(crate) mass: f32,
}

/// Particles that are pushed together as a weighted rigid body. An impulse moves the body, and each particle by its share of the body's motion there. This
/// conserves momentum, and angular momentum about the start of the substep, which is what Verlet conserves.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Aggregate<'a> {
    /// Inverse of the sum of their masses, each weighted by its share, 1/kg.
    pub(crate) inverse_mass: f32,
    /// Inverse inertia with the same weights, 1/(kg m²); zero for an aggregate without extent, which does not turn.
    pub(crate) inverse_inertia: Mat3,
    /// From the barycentre with the same weights to the particle in the middle, metres.
    pub(crate) lever: Vec3,
    /// Rows and their ring numbers about the middle.
    pub(crate) members: &'a [(u32, u32)],
    /// Number of rings: the share of ring `i` of `n` is `1 - i/n`.
    pub(crate) rings: u32,
}

impl Aggregate<'_> {
    /// Inverse effective mass of the particle in the middle along a unit vector, 1/kg: its displacement per impulse in kg m.
    #[inline]
    pub(crate) fn compliance(&self, along: Vec3) -> f32 {
        let moment = self.lever.cross(along);
        self.inverse_mass + moment.dot(self.inverse_inertia * moment)
    }

    /// Its displacement in the substep along a unit vector, metres: that of the particle in the middle if all of it has moved as a rigid body, and otherwise the
    /// mean to which an impulse of size `J` there adds the energy `J` times.
    pub(crate) fn displacement(&self, particles: &Particles, middle: u32, along: Vec3) -> f32 {
        let turn = self.inverse_inertia * self.lever.cross(along);
        let barycentre = particles.start[middle as usize].truncate() - self.lever;
        let each = self.members.iter().filter_map(|&(row, ring)| {
            let (position, start) =
                (particles.position[row as usize], particles.start[row as usize]);
            let moved = (position - start).truncate();
            let lever = start.truncate() - barycentre;
            let own = along * self.inverse_mass + turn.cross(lever);
            let mass = ring_share(ring, self.rings) / position.w;
            (position.w > 0.0).then(|| mass * own.dot(moved))
        });
        each.sum()
    }

    /// Applies an impulse to the particle in the middle, whose row is `middle`, and moves all particles of the aggregate. The impulse is in kg m: a mass times
    /// its displacement in the substep.
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

/// The share of a particle in a ring.
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

    fn project(
        &mut self,
        _: &mut Particles,
        _: (&ParticleContacts, &mut [NormalImpulse]),
        _: &mut Vec<u32>,
    ) -> bool {
        false
    }
}
