//! Positions lent out to be corrected: all that solving may touch, so that several threads can each have the particles of an island of their own.

use glam::{Vec3, Vec4};

use super::Particles;

/// The positions of consecutive rows, and what correcting them needs to know beside.
pub(crate) struct Places<'a> {
    /// The first of the rows.
    pub(crate) first: u32,
    /// `[x y z w]` of each, to be written.
    pub(crate) position: &'a mut [Vec4],
    /// Where each was when the substep began.
    pub(crate) start: &'a mut [Vec4],
    /// What both are relative to, metres.
    pub(crate) origin: &'a [Vec3],
    /// Metres.
    pub(crate) radius: &'a [f32],
    /// `[x y z l]` of each, to be derived when all is corrected.
    pub(crate) velocity: &'a mut [Vec4],
}

impl<'a> Places<'a> {
    /// Those of all particles.
    pub(crate) fn all(particles: &'a mut Particles) -> Self {
        let Particles { position, start, origin, radius, velocity, .. } = particles;
        Self { first: 0, position, start, origin, radius, velocity }
    }

    /// The rows before one, and the others.
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

    /// The same, lent on.
    pub(crate) fn lend(&mut self) -> Places<'_> {
        Places {
            first: self.first,
            position: self.position,
            start: self.start,
            origin: self.origin,
            radius: self.radius,
            velocity: self.velocity,
        }
    }

    /// Where a row is in the slices.
    #[inline(always)]
    pub(crate) fn at(&self, row: u32) -> usize {
        row.wrapping_sub(self.first) as usize
    }

    /// Adds to a position, metres.
    #[inline(always)]
    pub(crate) fn displace(&mut self, row: u32, by: Vec3) {
        let i = self.at(row);
        self.position[i] += by.extend(0.0);
    }

    /// `normal · p - offset`, metres: the height of a row over a plane of the world.
    #[inline]
    pub(crate) fn height(&self, row: u32, normal: Vec3, offset: f32) -> f32 {
        let i = self.at(row);
        height(self.origin[i], self.position[i], normal, offset)
    }
}

/// The height of a point over a plane of the world, metres; in two parts, so that far out too it has the point's own digits.
#[inline]
pub(super) fn height(origin: Vec3, position: Vec4, normal: Vec3, offset: f32) -> f32 {
    normal.dot(position.truncate()) + ground(origin, normal, offset)
}

/// The height of an origin over a plane of the world, metres.
#[inline]
pub(crate) fn ground(origin: Vec3, normal: Vec3, offset: f32) -> f32 {
    (normal.as_dvec3().dot(origin.as_dvec3()) - f64::from(offset)) as f32
}
