//! What is left to correct in eight bodies side by side: a body has too few rods of a colour for eight lanes here, too.

use glam::Vec4;

use super::pen::{Spot, gather};
use super::{Flocks, Part};
use crate::lanes::{InstructionSet, Lanes, Work, with};
use crate::solve::IslandReport;
use crate::solve::rods::worse;

impl Flocks {
    /// Measures the bodies of all flocks but of those that were measured on their way, and notes that: the largest error of the hard constraints of
    /// each, metres, and the largest strain of its rods. `spots` is scratch.
    pub(crate) fn measure(
        &self,
        position: &[Vec4],
        spots: &mut Vec<Spot>,
        reports: &mut [IslandReport],
        instructions: InstructionSet,
    ) {
        with(instructions, Measure { flocks: self, position, spots, reports });
    }
}

/// As [`Flocks::measure`] has it.
struct Measure<'a> {
    flocks: &'a Flocks,
    position: &'a [Vec4],
    spots: &'a mut Vec<Spot>,
    reports: &'a mut [IslandReport],
}

impl Work for Measure<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { flocks, position, spots, reports } = self;
        for flock in &flocks.all {
            let reports = &mut reports[flock.islands.clone()];
            if reports.iter().all(|report| report.measured) {
                continue;
            }
            gather::<L>(spots, flock, 0, position);
            let mut worst = (L::zero(), L::zero());
            for part in &flocks.parts[flock.parts.clone()] {
                match part {
                    Part::Rods(range) => {
                        for rod in &flocks.rods[range.clone()] {
                            let (one, other) = (&spots[rod.a as usize], &spots[rod.b as usize]);
                            worst = worse(worst, one.load(), other.load(), L::load(&rod.rest));
                        }
                    }
                    Part::Laws(part) => {
                        let (left, share) = flocks.alike.measure::<L>(part, spots);
                        worst = (left.max(worst.0), share.max(worst.1));
                    }
                }
            }
            let (errors, strains) = (worst.0.array(), worst.1.array());
            for ((report, error), strain) in reports.iter_mut().zip(errors).zip(strains) {
                (report.error, report.strain) = (error.max(0.0), strain.max(0.0));
                report.measured = true;
            }
        }
    }
}
