//! Where the particles of eight constraints are: as they lie in memory, or in the lanes of an instance batch.

use glam::Vec4;

use crate::lanes::{LANES, Lanes};

/// The particles of eight constraints of `N` particles each, to be looked at.
pub(in crate::solve) trait ParticleRead<const N: usize> {
    /// `x y z w` of the eight at place `i` of their constraints. To be inlined always, as are those below.
    fn now<L: Lanes>(&self, i: usize) -> [L; 4];
}

/// The same, to be moved.
pub(in crate::solve) trait ParticleAccess<const N: usize>:
    ParticleRead<N>
{
    /// `x y z w` where the substep began.
    fn start<L: Lanes>(&self, i: usize) -> [L; 4];
    /// Writes those of now.
    fn put<L: Lanes>(&mut self, i: usize, eight: [L; 4]);
}

/// As they lie in memory.
pub(super) struct GatheredParticles<'a, P, const N: usize> {
    pub(super) rows: &'a [[u32; LANES]; N],
    pub(super) position: P,
    pub(super) start: &'a [Vec4],
}

impl<const N: usize> ParticleRead<N> for GatheredParticles<'_, &[Vec4], N> {
    #[inline(always)]
    fn now<L: Lanes>(&self, i: usize) -> [L; 4] {
        L::rows(self.position, &self.rows[i])
    }
}

impl<const N: usize> ParticleRead<N> for GatheredParticles<'_, &mut [Vec4], N> {
    #[inline(always)]
    fn now<L: Lanes>(&self, i: usize) -> [L; 4] {
        L::rows(self.position, &self.rows[i])
    }
}

impl<const N: usize> ParticleAccess<N> for GatheredParticles<'_, &mut [Vec4], N> {
    #[inline(always)]
    fn start<L: Lanes>(&self, i: usize) -> [L; 4] {
        L::rows(self.start, &self.rows[i])
    }

    #[inline(always)]
    fn put<L: Lanes>(&mut self, i: usize, eight: [L; 4]) {
        L::put_rows(self.position, &self.rows[i], eight);
    }
}
