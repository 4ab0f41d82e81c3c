//! Eight bodies, swept until each holds or its sweeps are spent: as [`solve`](crate::solve::island) does with one.

use super::convergence::ConvergenceMask;
use super::lane_storage::LaneStorage;
use super::surfaces::{SurfaceContext, project_planes};
use super::{chains, rods};
use crate::collide::NormalImpulses;
use crate::constraints::{GradientAt, Plane, SubstepContext};
use crate::lanes::{InstructionSet, LANES, with};
use crate::settings::SolverSettings;
use crate::solve::plan::instance_batches::{InstanceBatch, InstanceBatches, InstancePart};

/// What solving needs to know beside the lane storage.
#[derive(Clone, Copy)]
pub(super) struct BatchContext<'a> {
    pub(super) instance_batches: &'a InstanceBatches,
    /// One whose constraints those in the lane storage have.
    pub(super) batch: &'a InstanceBatch,
    pub(super) settings: &'a SolverSettings,
    pub(super) planes: &'a [Plane],
    /// How much of an overlap is recovered in a substep, metres.
    pub(super) recover: f32,
    /// The most that is recovered of what constraints are violated by, metres.
    pub(super) violation: f32,
    /// `None` where there are none to touch.
    pub(super) surfaces: Option<SurfaceContext<'a>>,
    /// Whether its chains are solved at once.
    pub(super) chained: bool,
    /// Length of the substep, seconds.
    pub(super) h: f32,
    pub(super) instructions: InstructionSet,
}

impl BatchContext<'_> {
    /// Begins a substep: none has been swept.
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

    /// A bit for each body of a lane storage whose corrections keep its angular momentum, or have to.
    pub(super) fn keeps_spin(&self, storage: &LaneStorage) -> u32 {
        if self.settings.keep_spin { u32::MAX } else { self.along_start(storage) }
    }

    /// A bit for each body of a lane storage that is corrected along the start of the substep.
    fn along_start(&self, storage: &LaneStorage) -> u32 {
        if self.settings.gradient_at == GradientAt::StepStart {
            !storage.convergence.fell_back
        } else {
            0
        }
    }

    /// Sweeps until no more bodies than `few` go on.
    pub(super) fn sweep(
        &self,
        storage: &mut LaneStorage,
        normal_impulses: &mut NormalImpulses,
        few: u32,
    ) {
        let Self { settings, planes, recover, violation, .. } = *self;
        let most = settings.max_sweeps as f32;
        // A sleeper's particles count as pinned, and kernels move nobody who is; whatever they do, it is put back.
        let (mut kept, mut over) = (0, storage.asleep);
        while (storage.convergence.going & storage.mask()).count_ones() > few {
            if over != 0 {
                storage.keep(over);
                kept |= over;
            }
            let mut worst = self.once(storage);
            let going = storage.convergence.going;
            let unswept = bits(storage.convergence.sweeps, |sweeps| sweeps == 0.0);
            storage.convergence.violated |=
                going & unswept & bits(worst, |worst| worst > violation);
            let mut put_out = |storage: &mut LaneStorage, depth: [f32; LANES]| {
                storage.convergence.touched |= going & bits(depth, |depth| 0.0 < depth);
                for (worst, depth) in worst.iter_mut().zip(depth) {
                    *worst = if *worst < depth { depth } else { *worst };
                }
            };
            if !planes.is_empty() {
                let depth = project_planes(planes, recover, storage, going, self.instructions);
                put_out(storage, depth);
            }
            if let Some(surfaces) = &self.surfaces {
                let depth = surfaces.project(storage, normal_impulses, going);
                put_out(storage, depth);
            }
            let convergence = &mut storage.convergence;
            let good = going & bits(worst, |worst| worst <= settings.tolerance);
            for (lane, sweeps) in convergence.sweeps.iter_mut().enumerate() {
                *sweeps += (going >> lane & 1) as f32;
            }
            over = good | going & bits(convergence.sweeps, |sweeps| most <= sweeps);
            convergence.converged |= good;
            convergence.going &= !over;
        }
        if kept != 0 {
            storage.put_back(kept);
        }
    }

    /// Projects all constraints once; returns the largest error found in each body, metres.
    fn once(&self, storage: &mut LaneStorage) -> [f32; LANES] {
        let Self { instance_batches, batch, settings, h, violation, chained, instructions, .. } =
            *self;
        let substep_context = SubstepContext { h, sweeps: settings.max_sweeps };
        let (may, aside) = (self.along_start(storage), !storage.convergence.going);
        let mut worst = [0.0; LANES];
        let LaneStorage { now, tethers, eliminated, .. } = storage;
        if tethers.iter().any(|tethers| !tethers.is_empty()) {
            let first = bits(storage.convergence.sweeps, |sweeps| sweeps == 0.0);
            let going = first & !(aside | may);
            if going != 0 {
                worst = rods::hold_tethers(now, tethers, going, instructions);
            }
        }
        if chained && aside | may != u32::MAX {
            let (chains, links) =
                (&instance_batches.chains[batch.chains.clone()], &instance_batches.links[..]);
            let work = chains::ProjectInstancedChains {
                chains,
                links,
                now,
                eliminated,
                aside: aside | may,
            };
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
                    let sweep =
                        if may == 0 { rods::sweep_rods::<false> } else { rods::sweep_rods::<true> };
                    sweep(rods, now, start, may, aside, worst, instructions)
                }
                InstancePart::Constraints(part) => instance_batches.instanced.sweep(
                    part,
                    (&mut storage.now, &storage.start, &mut storage.multipliers),
                    substep_context,
                    (aside, worst),
                    instructions,
                ),
            };
        }
        worst
    }
}

/// A bit for each number of which something holds.
fn bits(numbers: [f32; LANES], holds: impl Fn(f32) -> bool) -> u32 {
    numbers.iter().enumerate().fold(0, |bits, (lane, &x)| bits | u32::from(holds(x)) << lane)
}
