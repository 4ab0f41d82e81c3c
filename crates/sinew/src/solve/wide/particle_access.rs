//! Where the particles of eight constraints are: as they lie in memory, or in the lanes of an instance batch.

use glam::Vec4;

use crate::lanes::{LANES, Lanes};

/// The particles of eight constraints of `N` particles each. What it does is to be inlined always.
pub(in crate::solve) trait ParticleAccess<const N: usize> {
    /// `x y z w` of the eight at place `i` of their constraints.
    fn now<L: Lanes>(&self, i: usize) -> [L; 4];
    /// The same where the substep began.
    fn start<L: Lanes>(&self, i: usize) -> [L; 4];
    /// Writes those of now.
    fn put<L: Lanes>(&mut self, i: usize, eight: [L; 4]);
}

/// As they lie in memory.
pub(super) struct GatheredParticles<'a, const N: usize> {
    pub(super) rows: &'a [[u32; LANES]; N],
    pub(super) position: &'a mut [Vec4],
    pub(super) start: &'a [Vec4],
}

impl<const N: usize> ParticleAccess<N> for GatheredParticles<'_, N> {
    #[inline(always)]
    fn now<L: Lanes>(&self, i: usize) -> [L; 4] {
        L::rows(self.position, &self.rows[i])
    }

    #[inline(always)]
    fn start<L: Lanes>(&self, i: usize) -> [L; 4] {
        L::rows(self.start, &self.rows[i])
    }

    #[inline(always)]
    fn put<L: Lanes>(&mut self, i: usize, eight: [L; 4]) {
        L::put_rows(self.position, &self.rows[i], eight);
    }
}
