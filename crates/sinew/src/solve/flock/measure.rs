//! What is left to correct in eight bodies side by side: a body has too few rods of a colour for eight lanes here, too.

use glam::Vec4;

use super::pen::{Spot, gather};
use super::{Flocks, Part};
use crate::lanes::Lanes;
use crate::solve::IslandReport;
use crate::solve::rods::worse;

impl Flocks {
    /// Measures the bodies of all flocks but of those that were measured on their way, and notes that: the largest error of the hard constraints of
    /// each, metres, and the largest strain of its rods. `spots` is scratch.
    #[inline(always)]
    pub(crate) fn measure<L: Lanes>(
        &self,
        position: &[Vec4],
        spots: &mut Vec<Spot>,
        reports: &mut [IslandReport],
    ) {
        for flock in &self.all {
            let reports = &mut reports[flock.islands.clone()];
            if reports.iter().all(|report| report.measured) {
                continue;
            }
            gather::<L>(spots, flock, 0, position);
            let mut worst = (L::zero(), L::zero());
            for part in &self.parts[flock.parts.clone()] {
                match part {
                    Part::Rods(range) => {
                        for rod in &self.rods[range.clone()] {
                            let (one, other) = (&spots[rod.a as usize], &spots[rod.b as usize]);
                            worst = worse(worst, one.load(), other.load(), L::load(&rod.rest));
                        }
                    }
                    Part::Laws(part) => {
                        let (left, share) = self.alike.measure::<L>(part, spots);
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
