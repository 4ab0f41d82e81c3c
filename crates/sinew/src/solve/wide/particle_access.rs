//! Access to the particles of eight constraints: gathered from memory, or in the lanes of an instance batch.

use glam::Vec4;

use crate::lanes::{LANES, Lanes};

/// Reads and writes the particles of eight constraints of `N` particles each. Implementations must be `#[inline(always)]`.
pub(in crate::solve) trait ParticleAccess<const N: usize> {
    /// `x y z w` of particle `i` of each of the eight constraints.
    fn now<L: Lanes>(&self, i: usize) -> [L; 4];
    /// The same at the start of the substep.
    fn start<L: Lanes>(&self, i: usize) -> [L; 4];
    /// Writes the current positions.
    fn put<L: Lanes>(&mut self, i: usize, eight: [L; 4]);
}

/// Particles gathered from and scattered to memory.
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
