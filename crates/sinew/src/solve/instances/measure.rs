//! Measures the remaining errors, eight bodies at a time: as in solving, a single body has too few rods of a colour to fill eight lanes.

use glam::Vec4;

use super::lane_storage::gather;
use crate::lanes::{InstructionSet, LANES, Lanes, kernel};
use crate::solve::lane_particles::LaneParticles;
use crate::solve::plan::instance_batches::{InstanceBatches, InstancePart, InstancedRod};
use crate::solve::report::IslandReport;
use crate::solve::rods::max_error;

impl InstanceBatches {
    /// Measures the bodies of all instance batches, except those measured already, and marks them as measured. Writes the largest error of each body's hard
    /// constraints, metres, and the largest strain of its hard distances. `lane_particles` is scratch.
    pub(crate) fn measure(
        &self,
        position: &[Vec4],
        lane_particles: &mut Vec<LaneParticles>,
        reports: &mut [IslandReport],
        instructions: InstructionSet,
    ) {
        for batch in &self.all {
            let reports = &mut reports[batch.islands.clone()];
            if reports.iter().all(|report| report.measured) {
                continue;
            }
            gather(lane_particles, batch, 0, position, instructions);
            let mut worst = [[0.0; LANES]; 2];
            for part in &self.parts[batch.parts.clone()] {
                let found = match part {
                    InstancePart::Rods(range) => {
                        measure_rods(&self.rods[range.clone()], lane_particles, instructions)
                    }
                    InstancePart::Constraints(part) => {
                        self.instanced.measure(part, lane_particles, instructions)
                    }
                };
                // All values are at least zero, and a maximum does not depend on the order.
                for (worst, found) in worst.as_flattened_mut().iter_mut().zip(found.as_flattened())
                {
                    *worst = if *worst < *found { *found } else { *worst };
                }
            }
            let [errors, strains] = worst;
            let each = reports.iter_mut().zip(errors).zip(strains);
            for ((report, error), strain) in each.filter(|((report, _), _)| !report.measured) {
                report.note_left((error, strain));
            }
        }
    }
}

kernel!(
    /// The largest error of the rods in each of eight bodies, metres, and the largest strain.
    fn measure_rods<L: Lanes>(
        rods: &[InstancedRod],
        lane_particles: &[LaneParticles],
    ) -> [[f32; LANES]; 2] {
        let mut worst = (L::zero(), L::zero());
        for rod in rods {
            let (one, other) = (&lane_particles[rod.a as usize], &lane_particles[rod.b as usize]);
            worst = max_error(worst, one.load(), other.load(), L::load(&rod.rest));
        }
        [worst.0.array(), worst.1.array()]
    }
);
