//! Compliant distances between particles in columns that follow no regular stride: gathered from the columns, eight of one colour, for the general distance
//! kernel. Those with a regular stride are solved as [compliant rods](crate::solve::rods).

use core::ops::Range;

use glam::Vec4;

use super::compliance::{PackedCompliance, Shares};
use super::particle_access::ParticleAccess;
use super::wide_distance::WideDistance;
use super::{Batch, WideKernel};
use crate::constraints::{Distance, SubstepContext};
use crate::lanes::{Columns, LANES, Lanes, kernel};

/// The loose distances of a plan.
#[derive(Clone, Debug, Default)]
pub(crate) struct LooseDistances {
    compliances: Vec<PackedCompliance>,
    blocks: Vec<Batch<BlockRows, WideDistance>>,
}

/// The rows of up to eight distances, counted from the first row of their cluster batch. Unused lanes repeat the first distance: they compute and write the
/// same values.
#[derive(Clone, Copy, Debug)]
struct BlockRows {
    rows: [[u32; LANES]; 2],
    count: usize,
}

/// Lengths of the lists: compliances, blocks.
pub(crate) type LooseCounts = [usize; 2];

impl LooseDistances {
    pub(in crate::solve) fn counts(&self) -> LooseCounts {
        [self.compliances.len(), self.blocks.len()]
    }

    /// Drops everything that was added after the lists had these lengths, and keeps the memory.
    pub(in crate::solve) fn truncate(&mut self, &[compliances, blocks]: &LooseCounts) {
        self.compliances.truncate(compliances);
        self.blocks.truncate(blocks);
    }

    /// Adds distances of one colour, in a cluster batch that begins with row `first`. Returns their blocks. With `shared` the distances share particles, and
    /// each gets a block to itself.
    pub(crate) fn add(&mut self, distances: &[Distance], shared: bool, first: u32) -> Range<usize> {
        let begin = self.blocks.len();
        for some in distances.chunks(if shared { 1 } else { LANES }) {
            let mut eight = [&some[0]; LANES];
            some.iter().zip(&mut eight).for_each(|(d, lane)| *lane = d);
            let rows = [eight.map(|d| d.a - first), eight.map(|d| d.b - first)];
            let rows = BlockRows { rows, count: some.len() };
            self.blocks.push(Batch::new(rows, WideDistance::of(eight), &mut self.compliances));
        }
        begin..self.blocks.len()
    }
}

kernel!(
    /// Projects some blocks once, in order, on particles in columns. The cluster batch of the blocks begins `from` rows after the first row of the columns;
    /// `sums` are the multipliers of the distances. Returns the largest correction, metres.
    pub(in crate::solve) fn sweep_loose<L: Lanes>(
        loose: &LooseDistances,
        columns: &mut Columns,
        blocks: Range<usize>,
        from: u32,
        sums: &mut [f32],
        substep_context: SubstepContext,
    ) -> f32 {
        let SubstepContext { h, sweeps } = substep_context;
        let (mut shares, mut worst, mut sums) = (Shares::new(sweeps), L::zero(), sums);
        for block in &loose.blocks[blocks] {
            let BlockRows { rows, count } = block.particles;
            let packed = &loose.compliances[block.packed_compliance as usize];
            let context = (packed, shares.of(block.packed_compliance, packed), h, L::zero());
            let own;
            (own, sums) = core::mem::take(&mut sums).split_at_mut(count);
            let mut particles = CopiedParticles([[Vec4::ZERO; LANES]; 2]);
            for (eight, rows) in particles.0.iter_mut().zip(&rows) {
                for (to, row) in eight.iter_mut().zip(rows) {
                    *to = columns.get(columns.at(from + row));
                }
            }
            worst = block.eight.project::<L>(context, &mut particles, Some(own)).0.max(worst);
            for (eight, rows) in particles.0.iter().zip(&rows) {
                for (moved, row) in eight.iter().zip(rows) {
                    columns.set(columns.at(from + row), *moved);
                }
            }
        }
        worst.largest(0.0)
    }
);

/// Copies of the particles of eight distances.
struct CopiedParticles([[Vec4; LANES]; 2]);

impl ParticleAccess<2> for CopiedParticles {
    #[inline(always)]
    fn now<L: Lanes>(&self, i: usize) -> [L; 4] {
        L::run(&self.0[i], 0)
    }

    /// Columns do not store the start of the substep, so damped distances are not swept in them.
    #[inline(always)]
    fn start<L: Lanes>(&self, i: usize) -> [L; 4] {
        self.now(i)
    }

    #[inline(always)]
    fn put<L: Lanes>(&mut self, i: usize, eight: [L; 4]) {
        L::put_run(&mut self.0[i], 0, eight);
    }
}
