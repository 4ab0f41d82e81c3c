//! Sweeps eight bodies until each has converged or used up its sweeps, as [`solve`](crate::solve::island) does for one island.

use super::convergence::ConvergenceMask;
use super::lane_storage::LaneStorage;
use super::momentum_drift::KeepsMomenta;
use super::surfaces::{SurfaceContext, project_planes};
use super::{chains, rods};
use crate::collide::NormalImpulses;
use crate::constraints::{GradientAt, Plane, SubstepContext};
use crate::lanes::{InstructionSet, LANES, with};
use crate::settings::SolverSettings;
use crate::solve::plan::instance_batches::{InstanceBatch, InstanceBatches, InstancePart};

/// What solving needs beside the lane storage.
#[derive(Clone, Copy)]
pub(super) struct BatchContext<'a> {
    pub(super) instance_batches: &'a InstanceBatches,
    /// A batch with the same constraints as the bodies in the lane storage.
    pub(super) batch: &'a InstanceBatch,
    pub(super) settings: &'a SolverSettings,
    pub(super) planes: &'a [Plane],
    /// How much of an overlap is recovered in a substep, metres.
    pub(super) recover: f32,
    /// How much of a constraint violation is recovered in a substep, metres.
    pub(super) violation: f32,
    /// `None` if there are no surfaces to touch.
    pub(super) surfaces: Option<SurfaceContext<'a>>,
    /// Whether the bodies have chains that are solved directly.
    pub(super) chained: bool,
    /// Length of the substep, seconds.
    pub(super) h: f32,
    pub(super) instructions: InstructionSet,
}

impl BatchContext<'_> {
    /// Begins a substep: resets the convergence masks and the multipliers.
    pub(super) fn begin(&self, storage: &mut LaneStorage) {
        storage.convergence = ConvergenceMask::all_but(storage.asleep);
        storage.multipliers.clear();
        if self.settings.max_sweeps > 1 {
            storage.multipliers.resize(self.batch.multipliers, [0.0; _]);
        }
        if self.settings.gradient_at == GradientAt::StepStart {
            let mut fell_back = 0;
            for part in &self.instance_batches.parts[self.batch.parts.clone()] {
                if let InstancePart::Rods(range) = part {
                    let rods = &self.instance_batches.rods[range.clone()];
                    let (now, start) = (&storage.now[..], &storage.start[..]);
                    fell_back |= rods::turn_too_fast(rods, now, start, self.instructions);
                }
            }
            storage.convergence.fell_back = fell_back;
        }
    }

    /// Which momenta the bodies of a storage are to keep when velocities are derived.
    pub(super) fn keeps_momenta(&self, storage: &LaneStorage) -> KeepsMomenta {
        let LaneStorage { free, pivoted, .. } = *storage;
        let untouched = !storage.convergence.touched;
        let spin = if self.settings.keep_spin { u32::MAX } else { self.along_start(storage) };
        let (free, held) = (free & untouched, pivoted & untouched & spin);
        KeepsMomenta { free, turning: free & spin, held }
    }

    /// One bit for each body that is corrected along the directions at the start of the substep.
    fn along_start(&self, storage: &LaneStorage) -> u32 {
        if self.settings.gradient_at == GradientAt::StepStart {
            !storage.convergence.fell_back
        } else {
            0
        }
    }

    /// Sweeps until at most `few` bodies have not converged.
    pub(super) fn sweep(
        &self,
        storage: &mut LaneStorage,
        normal_impulses: &mut NormalImpulses,
        few: u32,
    ) {
        let Self { settings, planes, recover, violation, .. } = *self;
        let most = settings.max_sweeps as f32;
        // Particles of sleeping bodies count as pinned and kernels do not move them; the snapshot makes that certain.
        let (mut saved, mut done) = (0, storage.asleep);
        while (storage.convergence.going & storage.mask()).count_ones() > few {
            if done != 0 {
                storage.save(done);
                saved |= done;
            }
            let mut worst = self.sweep_once(storage);
            let going = storage.convergence.going;
            let unswept = bits(storage.convergence.sweeps, |sweeps| sweeps == 0.0);
            storage.convergence.violated |=
                going & unswept & bits(worst, |worst| worst > violation);
            let mut note_depth = |storage: &mut LaneStorage, depth: [f32; LANES]| {
                storage.convergence.touched |= going & bits(depth, |depth| 0.0 < depth);
                for (worst, depth) in worst.iter_mut().zip(depth) {
                    *worst = if *worst < depth { depth } else { *worst };
                }
            };
            if !planes.is_empty() {
                let depth = project_planes(planes, recover, storage, going, self.instructions);
                note_depth(storage, depth);
            }
            if let Some(surfaces) = &self.surfaces {
                let depth = surfaces.project(storage, normal_impulses, going);
                note_depth(storage, depth);
            }
            let convergence = &mut storage.convergence;
            let good = going & bits(worst, |worst| worst <= settings.tolerance);
            for (lane, sweeps) in convergence.sweeps.iter_mut().enumerate() {
                *sweeps += (going >> lane & 1) as f32;
            }
            done = good | going & bits(convergence.sweeps, |sweeps| most <= sweeps);
            convergence.converged |= good;
            convergence.going &= !done;
        }
        if saved != 0 {
            storage.restore(saved);
        }
    }

    /// Projects all constraints once. Returns the largest error found in each body, metres.
    fn sweep_once(&self, storage: &mut LaneStorage) -> [f32; LANES] {
        let Self { instance_batches, batch, settings, h, violation, chained, instructions, .. } =
            *self;
        let substep_context = SubstepContext { h, sweeps: settings.max_sweeps };
        let (along_start, inactive) = (self.along_start(storage), !storage.convergence.going);
        let mut worst = [0.0; LANES];
        let LaneStorage { now, tethers, eliminated, .. } = storage;
        if tethers.iter().any(|tethers| !tethers.is_empty()) {
            let first = bits(storage.convergence.sweeps, |sweeps| sweeps == 0.0);
            let going = first & !inactive;
            if going != 0 {
                worst = rods::project_tethers(now, tethers, going, instructions);
            }
        }
        if chained && inactive != u32::MAX {
            let (chains, links) =
                (&instance_batches.chains[batch.chains.clone()], &instance_batches.links[..]);
            let work = chains::ProjectInstancedChains { chains, links, now, eliminated, inactive };
            let found = with(instructions, work);
            for (worst, found) in worst.iter_mut().zip(found) {
                *worst = if violation < found && *worst < found { found } else { *worst };
            }
        }
        for part in &instance_batches.parts[batch.parts.clone()] {
            worst = match part {
                InstancePart::Rods(range) => {
                    let rods = &instance_batches.rods[range.clone()];
                    let (now, start) = (&mut storage.now[..], &storage.start[..]);
                    let sweep = if along_start == 0 {
                        rods::sweep_rods::<false>
                    } else {
                        rods::sweep_rods::<true>
                    };
                    sweep(rods, now, start, along_start, inactive, worst, instructions)
                }
                InstancePart::Constraints(part) => instance_batches.instanced.sweep(
                    part,
                    (&mut storage.now, &storage.start, &mut storage.multipliers),
                    substep_context,
                    (inactive, worst),
                    instructions,
                ),
            };
        }
        worst
    }
}

/// One bit for each number that satisfies a condition.
fn bits(numbers: [f32; LANES], holds: impl Fn(f32) -> bool) -> u32 {
    numbers.iter().enumerate().fold(0, |bits, (lane, &x)| bits | u32::from(holds(x)) << lane)
}
