//! Chains: hard rods one behind the other, of a rope or a string of beads, solved as the one tridiagonal system that they are (Baraff, *Linear-Time Dynamics
//! using Lagrange Multipliers*, 1996; Deul, Kugelstadt, Weiler, Bender, *Direct Position-Based Solver for Stiff Rods*, 2018).
//!
//! A sweep hands a pull on by some rods, and where a heavy thing hangs on light pieces each piece takes but its share of the way: a load of fifty pieces on a
//! rope of sixteen stretches it by a tenth after four sweeps, and a hundred would not do. The rods of a chain are few enough unknowns of a kind simple enough
//! to be found all at once, in time that grows with their number (`project` has the formula), whatever the masses are. What is solved to the end is the same.
//!
//! A chain goes from one particle to another by hard distances of equality, each particle within it having two of them; where three meet, chains end. A ring is
//! cut open at one rod. Two particles that a distance of no length ties are one. Cloth, boxes and bones have none within; a rope that a box hangs on is one up to the
//! particle of the box that it is tied to.
//!
//! Each sweep of an island begins with them. Then the rods have their turn as everywhere, and find next to nothing left to do; what they find is the error.

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

/// The next particle of a chain and the rod that leads to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Link {
    /// The row of the particle; of two that are one, of both.
    pub(super) rows: [u32; 2],
    /// The number of the rod that leads to the first of them, among the plan's distances, and of the one that ties them together.
    pub(super) rods: [u32; 2],
    /// Length of the rod that leads there, metres; to the first of a chain none does.
    pub(super) rest: f32,
}

impl Link {
    /// Whether it is two particles.
    fn is_double(&self) -> bool {
        self.rows[0] != self.rows[1]
    }

    /// Its particle, in columns of positions that begin with the row `first`; of two that are one, that of both.
    #[inline(always)]
    fn merged(&self, position: &[Vec4], first: u32) -> Vec4 {
        let [one, other] = self.places(first);
        if one == other {
            return position[one];
        }
        let (p, w) = merged(position[one].to_array(), position[other].to_array());
        Vec3::from(p).extend(w)
    }

    /// Where its particles are in columns that begin with the row `first`. No `array::map`, which is a call of several functions for each link.
    #[inline(always)]
    fn places(&self, first: u32) -> [usize; 2] {
        let [one, other] = self.rows;
        [(one - first) as usize, (other - first) as usize]
    }
}

/// What elimination leaves of a rod for the way back. Scratch.
pub(super) type Eliminated<N> = [N; 6];

/// What solving chains needs. Scratch.
#[derive(Clone, Debug, Default)]
pub(super) struct ChainScratch {
    eliminated: Vec<Eliminated<f32>>,
    segments: SegmentScratch,
}

impl Chains {
    /// Solves the chains of an island once, in columns of positions that begin with the row `first`. Returns the largest error found, metres.
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

    /// The same one rod after the other, and `pulled` is told which rod, by its number, has given how much to the particle in which row, kg·m; its other end
    /// got the opposite.
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

/// Solves one, one rod after the other.
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
            // The next rod pulls at the other one, which the knot takes along.
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
