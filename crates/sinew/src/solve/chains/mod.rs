//! Chains: consecutive hard rods, of a rope or a string of beads, solved as one tridiagonal system (Baraff, *Linear-Time Dynamics using Lagrange Multipliers*,
//! 1996; Deul, Kugelstadt, Weiler, Bender, *Direct Position-Based Solver for Stiff Rods*, 2018).
//!
//! A sweep propagates a pull by a few rods, and where a heavy body hangs on light pieces each piece takes only its mass share of the correction: a load of
//! fifty pieces on a rope of sixteen stretches it by a tenth after four sweeps, and a hundred sweeps would not be enough. The rods of a chain are few unknowns
//! with a simple structure, so they are solved directly, in time proportional to their number (`project` has the formula), whatever the masses are. The
//! converged solution is the same.
//!
//! A chain leads from one particle to another by hard equality distances, and each particle within it has exactly two of them; chains end where three meet. A
//! ring is cut open at one rod. Two particles connected by a distance of zero length count as one. Cloth, boxes and bones contain no chains; a rope with a box
//! on it is a chain up to the particle of the box that it is tied to.
//!
//! Each sweep of an island begins with its chains. The rods are then swept as everywhere and have almost nothing left to do; what they correct is the error.

mod find;
mod project;
mod segments;
#[cfg(test)]
mod tests;

pub(super) use find::{Chains, LONG};
pub(super) use project::{Links, project_chain};

use glam::{Vec3, Vec4};

use crate::islands::Island;
use crate::lanes::{InstructionSet, Vector};
use project::merged;
use segments::SegmentScratch;

/// A particle of a chain and the rod that leads to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Link {
    /// The row of the particle; the rows of both where two particles count as one, or else the same row twice.
    pub(super) rows: [u32; 2],
    /// Plan indices of the rod that leads to the first of them, and of the one that ties them together.
    pub(super) rods: [u32; 2],
    /// Length of the rod that leads there, metres; 0 for the first particle of a chain.
    pub(super) rest: f32,
}

impl Link {
    /// Whether it consists of two particles.
    fn is_double(&self) -> bool {
        self.rows[0] != self.rows[1]
    }

    /// Its position and inverse mass, in positions that begin with row `first`; those of the merged particle if there are two.
    #[inline(always)]
    fn merged(&self, position: &[Vec4], first: u32) -> Vec4 {
        let [one, other] = self.places(first);
        if one == other {
            return position[one];
        }
        let (p, w) = merged(position[one].to_array(), position[other].to_array());
        Vec3::from(p).extend(w)
    }

    /// Indices of its particles in positions that begin with row `first`. Not `array::map`, which compiled to several calls for each link.
    #[inline(always)]
    fn places(&self, first: u32) -> [usize; 2] {
        let [one, other] = self.rows;
        [(one - first) as usize, (other - first) as usize]
    }
}

/// What elimination keeps of a rod for back substitution. Scratch.
pub(super) type Eliminated<N> = [N; 6];

/// Scratch for solving chains.
#[derive(Clone, Debug, Default)]
pub(super) struct ChainScratch {
    eliminated: Vec<Eliminated<f32>>,
    segments: SegmentScratch,
}

impl Chains {
    /// Solves the chains of an island once, in positions that begin with row `first`. Returns the largest error found, metres.
    pub(super) fn project(
        &self,
        island: &Island,
        (position, first): (&mut [Vec4], u32),
        scratch: &mut ChainScratch,
        instructions: InstructionSet,
    ) -> f32 {
        let ChainScratch { eliminated, segments } = scratch;
        let mut worst = 0.0_f32;
        for number in island.chains.clone() {
            let (links, rests) = (self.links(number), self.rests(number));
            let columns = (&mut *position, first);
            worst = worst.max(if rests.is_empty() {
                project_one(links, columns, eliminated, &mut |_, _, _| {})
            } else {
                segments.project((links, rests), columns, instructions)
            });
        }
        worst
    }

    /// The same, one rod after the other. `pulled` is called with the plan index of a rod, the row of a particle, and the impulse times the substep on that
    /// particle, kg·m; the rod's other end received the opposite.
    pub(super) fn project_noting(
        &self,
        island: &Island,
        (position, first): (&mut [Vec4], u32),
        eliminated: &mut Vec<Eliminated<f32>>,
        mut pulled: impl FnMut(u32, u32, Vec3),
    ) -> f32 {
        let mut worst = 0.0_f32;
        for number in island.chains.clone() {
            let columns = (&mut *position, first);
            worst = worst.max(project_one(self.links(number), columns, eliminated, &mut pulled));
        }
        worst
    }
}

/// Solves one chain, one rod after the other.
fn project_one(
    links: &[Link],
    (position, first): (&mut [Vec4], u32),
    eliminated: &mut Vec<Eliminated<f32>>,
    pulled: &mut impl FnMut(u32, u32, Vec3),
) -> f32 {
    eliminated.resize(links.len().max(eliminated.len()), [0.0; _]);
    project_chain(&mut OfIsland { links, position, first, eliminated, pulled })
}

/// A chain of one island.
struct OfIsland<'a, P> {
    links: &'a [Link],
    position: &'a mut [Vec4],
    first: u32,
    eliminated: &'a mut [Eliminated<f32>],
    pulled: P,
}

impl<P: FnMut(u32, u32, Vec3)> Links<f32> for OfIsland<'_, P> {
    fn count(&self) -> usize {
        self.links.len()
    }

    #[inline(always)]
    fn ends(&self, link: usize) -> [[f32; 4]; 2] {
        let [one, other] = self.links[link].places(self.first);
        [self.position[one].to_array(), self.position[other].to_array()]
    }

    #[inline(always)]
    fn is_double(&self, link: usize) -> bool {
        self.links[link].is_double()
    }

    #[inline(always)]
    fn rest(&self, link: usize) -> f32 {
        self.links[link].rest
    }

    #[inline(always)]
    fn shift(&mut self, link: usize, by: Vector<f32>, [pull, next]: [Vector<f32>; 2]) {
        let Link { rows, rods, .. } = self.links[link];
        let [one, other] = self.links[link].places(self.first);
        let (pull, next, by) = (Vec3::from(pull), Vec3::from(next), Vec3::from(by));
        if link > 0 {
            (self.pulled)(rods[0], rows[0], pull);
        }
        if one != other {
            // The next rod pulls at the other particle, and the zero-length rod between the two transmits it.
            let (w, other_w) = (self.position[one].w, self.position[other].w);
            let knot = match () {
                () if other_w > 0.0 => by / other_w + next,
                () if w > 0.0 => pull - by / w,
                () => Vec3::ZERO,
            };
            (self.pulled)(rods[1], rows[1], knot);
            self.position[other] += by.extend(0.0);
        }
        self.position[one] += by.extend(0.0);
    }

    #[inline(always)]
    fn keep(&mut self, link: usize, eliminated: Eliminated<f32>) {
        self.eliminated[link] = eliminated;
    }

    #[inline(always)]
    fn kept(&self, link: usize) -> Eliminated<f32> {
        self.eliminated[link]
    }
}
