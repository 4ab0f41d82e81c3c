//! Flocks: bodies that are built alike, eight side by side, each in a lane of its own.
//!
//! A box of eight particles has too few constraints of a colour to fill eight lanes, and particles gathered for each of them and put back cost more
//! than the formula. Eight boxes have eight of everything. So their particles are turned into lanes once ([`Pen`]), particle `i` of all of them side
//! by side, and each constraint of the body is then one operation in lanes: no colours needed, nothing gathered. Where a whole step is taken at once
//! they stay there for all its substeps.
//!
//! **What is beside a body must not matter**, nor whether it is in a flock at all: a lane has the bits that its body has alone. So the constraints of
//! a body are enforced in the order of its own plan, in which those of one colour may come in any order; formulas are those of eights of one body;
//! and a body that has converged is kept as it is while others go on. Which bodies make a flock may therefore depend on anything; that it depends on
//! the plan alone is for the sake of those who measure.
//!
//! - `find` finds them when a plan is compiled;
//! - `pen` is where their particles are meanwhile;
//! - `solve` sweeps them until each holds, `rods` and the plan's [laws](super::wide) are what it does, `touch` puts them out of planes, `course` is
//!   how it goes;
//! - `herd` lets those that take longer than the others of their flock go on together;
//! - `motion` predicts and derives, `excess` keeps round-off out of their momenta;
//! - `drive` does all that, flock by flock;
//! - `measure` looks at what is left in the end.

mod course;
mod drive;
mod excess;
mod find;
mod herd;
mod measure;
mod motion;
mod pen;
mod rods;
mod solve;
#[cfg(test)]
mod tests;
mod touch;

use core::ops::Range;

use super::wide::{Alike, Part as LawPart};
use crate::lanes::LANES;

use course::Course;
pub(crate) use drive::{Drive, Motion, Whole};
pub(super) use excess::Excesses;
pub(crate) use find::MOST;
pub(crate) use herd::Herd;
pub(crate) use pen::{Pen, Spot};
use solve::How;

/// The flocks of a plan.
#[derive(Clone, Debug, Default)]
pub(crate) struct Flocks {
    all: Vec<Flock>,
    parts: Vec<Part>,
    rods: Vec<Rod>,
    alike: Alike,
}

/// Three to eight consecutive islands that are built alike, whose rows follow each other.
#[derive(Clone, Debug)]
struct Flock {
    islands: Range<usize>,
    /// The first row of the first island, and how many each has.
    first: u32,
    members: u32,
    /// What a sweep consists of, in its order.
    parts: Range<usize>,
    /// How many constraints may have sums.
    sums: usize,
    /// All bodies of flocks of the same kin are the same in every number. `None` if those of this one are not.
    kin: Option<usize>,
}

/// Constraints of one kind that a sweep takes one after the other.
#[derive(Clone, Debug)]
enum Part {
    /// Which of the flocks' rods.
    Rods(Range<usize>),
    Laws(LawPart),
}

/// A hard rod of each of eight bodies, between particles of the same numbers.
#[derive(Clone, Copy, Debug)]
struct Rod {
    a: u32,
    b: u32,
    rest: [f32; LANES],
}

impl Flocks {
    /// Whether the last of some flocks and the first of others are of the same bodies.
    pub(crate) fn are_kin(&self, some: Range<usize>, others: Range<usize>) -> bool {
        match (self.all[some].last(), self.all[others].first()) {
            (Some(last), Some(first)) => last.is_kin(first),
            _ => false,
        }
    }
}

impl Flock {
    /// All rows of its bodies.
    fn rows(&self) -> Range<u32> {
        self.first..self.first + self.islands.len() as u32 * self.members
    }

    /// Whether the bodies of both are the same in every number.
    fn is_kin(&self, other: &Self) -> bool {
        self.kin.is_some() && self.kin == other.kin
    }

    /// In which place, from that of row `begin` on, particle `i` of each body is. Lanes that are left have the last body again: it computes the same
    /// and writes the same.
    #[inline(always)]
    fn places(&self, begin: u32, i: u32) -> [u32; LANES] {
        let last = self.islands.len() as u32 - 1;
        core::array::from_fn(|lane| self.first - begin + last.min(lane as u32) * self.members + i)
    }
}
