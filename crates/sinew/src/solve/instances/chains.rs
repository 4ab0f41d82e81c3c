//! Chains (ropes solved directly) of eight bodies at once.

use core::ops::Range;

use crate::lanes::{LANES, Lanes, Vector, Work};
use crate::solve::chains::{Eliminated, Links, project_chain};
use crate::solve::lane_particles::LaneParticles;
use crate::solve::plan::instance_batches::InstancedLink;

/// Solves each chain once. Bodies in the mask `inactive` are not moved. Returns the largest error found in each body, metres.
pub(super) struct ProjectInstancedChains<'a> {
    pub(super) chains: &'a [Range<usize>],
    pub(super) links: &'a [InstancedLink],
    pub(super) now: &'a mut [LaneParticles],
    pub(super) eliminated: &'a mut Vec<Eliminated<[f32; LANES]>>,
    pub(super) inactive: u32,
}

impl Work for ProjectInstancedChains<'_> {
    type Output = [f32; LANES];

    #[inline(always)]
    fn run<L: Lanes>(self) -> [f32; LANES] {
        let Self { chains, links, now, eliminated, inactive } = self;
        let (moves, mut worst) = (L::mask(!inactive), L::zero());
        for chain in chains {
            let links = &links[chain.clone()];
            eliminated.resize(links.len().max(eliminated.len()), [[0.0; LANES]; _]);
            let mut instanced = InstancedChain { links, now, eliminated, moves };
            worst = project_chain::<L>(&mut instanced).max(worst);
        }
        worst.and(moves).array()
    }
}

/// The same chain in eight bodies.
struct InstancedChain<'a, L> {
    links: &'a [InstancedLink],
    now: &'a mut [LaneParticles],
    eliminated: &'a mut [Eliminated<[f32; LANES]>],
    /// Mask of the bodies that may move.
    moves: L,
}

impl<L: Lanes> Links<L> for InstancedChain<'_, L> {
    #[inline(always)]
    fn count(&self) -> usize {
        self.links.len()
    }

    #[inline(always)]
    fn ends(&self, link: usize) -> [[L; 4]; 2] {
        let [one, other] = self.links[link].at;
        let [x, y, z, w] = self.now[one as usize].load::<L>();
        let [u, v, t, s] = self.now[other as usize].load::<L>();
        [[x, y, z, self.moves.and(w)], [u, v, t, self.moves.and(s)]]
    }

    #[inline(always)]
    fn is_double(&self, link: usize) -> bool {
        let [one, other] = self.links[link].at;
        one != other
    }

    #[inline(always)]
    fn rest(&self, link: usize) -> L {
        L::load(&self.links[link].rest)
    }

    #[inline(always)]
    fn shift(&mut self, link: usize, by: Vector<L>, _: [Vector<L>; 2]) {
        let [one, other] = self.links[link].at;
        let entry = &mut self.now[one as usize];
        let (p, w) = Vector::of(entry.load::<L>());
        entry.put((p + by).with(w));
        if one != other {
            let entry = &mut self.now[other as usize];
            let (p, w) = Vector::of(entry.load::<L>());
            entry.put((p + by).with(w));
        }
    }

    #[inline(always)]
    fn keep(&mut self, link: usize, [a, b, c, d, e, f]: Eliminated<L>) {
        let [to_a, to_b, to_c, to_d, to_e, to_f] = &mut self.eliminated[link];
        a.store(to_a);
        b.store(to_b);
        c.store(to_c);
        d.store(to_d);
        e.store(to_e);
        f.store(to_f);
    }

    #[inline(always)]
    fn kept(&self, link: usize) -> Eliminated<L> {
        let [a, b, c, d, e, f] = &self.eliminated[link];
        [L::load(a), L::load(b), L::load(c), L::load(d), L::load(e), L::load(f)]
    }
}
