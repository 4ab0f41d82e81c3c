//! Positions borrowed for correction: everything that solving may write, so that several threads can each have the particles of an island.

use glam::{Vec3, Vec4};

use super::Particles;

/// The positions of consecutive rows, and the columns that correcting them reads.
pub(crate) struct Places<'a> {
    /// The first row.
    pub(crate) first: u32,
    /// `[x y z w]` of each, written by the kernels.
    pub(crate) position: &'a mut [Vec4],
    /// `[x y z w]` of each at the start of the substep.
    pub(crate) start: &'a mut [Vec4],
    /// Origin that both are relative to, metres.
    pub(crate) origin: &'a [Vec3],
    /// Radius, metres.
    pub(crate) radius: &'a [f32],
    /// `[x y z l]` of each, derived after all corrections.
    pub(crate) velocity: &'a mut [Vec4],
}

impl<'a> Places<'a> {
    /// The columns of all particles.
    pub(crate) fn all(particles: &'a mut Particles) -> Self {
        let Particles { position, start, origin, radius, velocity, .. } = particles;
        Self { first: 0, position, start, origin, radius, velocity }
    }

    /// Splits into the rows before `row` and the others.
    pub(crate) fn split_at(self, row: u32) -> (Self, Self) {
        let count = self.at(row);
        let (position, positions) = self.position.split_at_mut(count);
        let (start, starts) = self.start.split_at_mut(count);
        let (origin, origins) = self.origin.split_at(count);
        let (radius, radii) = self.radius.split_at(count);
        let (velocity, velocities) = self.velocity.split_at_mut(count);
        let rest = Places {
            first: self.first + count as u32,
            position: positions,
            start: starts,
            origin: origins,
            radius: radii,
            velocity: velocities,
        };
        (Places { first: self.first, position, start, origin, radius, velocity }, rest)
    }

    /// Borrows the same rows again.
    pub(crate) fn reborrow(&mut self) -> Places<'_> {
        Places {
            first: self.first,
            position: self.position,
            start: self.start,
            origin: self.origin,
            radius: self.radius,
            velocity: self.velocity,
        }
    }

    /// Index of a row in the slices.
    #[inline(always)]
    pub(crate) fn at(&self, row: u32) -> usize {
        row.wrapping_sub(self.first) as usize
    }

    /// Moves a row by `by`, metres.
    #[inline(always)]
    pub(crate) fn displace(&mut self, row: u32, by: Vec3) {
        let i = self.at(row);
        self.position[i] += by.extend(0.0);
    }

    /// `normal · p - offset`, metres: height of a row above a plane in world coordinates.
    #[inline]
    pub(crate) fn height(&self, row: u32, normal: Vec3, offset: f32) -> f32 {
        let i = self.at(row);
        height(self.origin[i], self.position[i], normal, offset)
    }
}

/// Height of a point above a plane in world coordinates, metres; in two parts, so that it has the local position's precision far out, too.
#[inline]
pub(super) fn height(origin: Vec3, position: Vec4, normal: Vec3, offset: f32) -> f32 {
    normal.dot(position.truncate()) + ground(origin, normal, offset)
}

/// Height of an origin above a plane in world coordinates, metres.
#[inline]
pub(crate) fn ground(origin: Vec3, normal: Vec3, offset: f32) -> f32 {
    (normal.as_dvec3().dot(origin.as_dvec3()) - f64::from(offset)) as f32
}
