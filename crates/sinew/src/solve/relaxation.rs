//! Relaxation: at the end of a step, large cloth distributes the errors of rods that cannot all be satisfied.
//!
//! Where cloth is folded to a point, or hangs on a corner, its rods contradict each other: no positions give each its length. Gauss–Seidel then runs in a
//! cycle, in which each rod has its length when it has just been projected, and at the end of a sweep the rods that came first bear what all others were given;
//! more sweeps make it worse (the worst strain of a flag was 7 %, and 10 % after eight more). If each rod corrects only a part of its error, the cycle
//! shrinks with that part around the positions of least squared error (Censor, Eggermont and Gordon, *Strong underrelaxation in Kaczmarz's method for
//! inconsistent systems*, 1983).
//!
//! So a large island that takes [microsteps](super::microsteps) ends the step with one sweep in which each rod corrects half of its error, and two sweeps that
//! correct only errors beyond a fiftieth of the length, so that rods within that bound give way to the others. These sweeps come after the velocities have been
//! derived, and move the start positions along with the end positions, so they change no velocity: they affect what is seen and not the dynamics.
//!
//! Islands without a pin or a contact are left alone: they bear no load, and moving them without changing their velocity would take some of their spin. So are
//! islands that may touch particles of another body, and islands with a tie: the others would be pushed, and gain velocity, by a displacement that has none.
//! Where the collider of another body has pressed on the island in this step, the particles near it are treated as pinned meanwhile, and the rest is relaxed.
//!
//! The next sweep returns to its cycle. This motion is too small to be seen, but it remains in the velocities. So relaxation is reduced for slow islands, and
//! resting cloth stays as it is.

use core::ops::Range;

use glam::Vec4;

use super::constraint_ref::SolveMode;
use super::context::SolveContext;
use super::island::project_contacts;
use super::multipliers::MultiplierSlice;
use super::plan::Plan;
use super::rods::Relaxation;
use super::strain_limit::StrainScratch;
use super::task_slice::IslandSlice;
use crate::constraints::{GradientAt, SubstepContext};
use crate::islands::Island;
use crate::particles::Places;

/// The sweeps. Worst strains of capes, flags and sheets, as means of four to six starts each: 2.8 to 9.9 % without, 2.2 to 6.5 % with two sweeps of a half and
/// a third, 2.0 to 4.9 % with these. A fourth sweep gains nothing.
const SWEEPS: [Relaxation; 3] = [
    Relaxation { share: 0.5, tolerance: 0.0 },
    Relaxation { share: 0.7, tolerance: 0.02 },
    Relaxation { share: 0.5, tolerance: 0.02 },
];

/// Islands with a root mean square speed below this, m/s, are relaxed in proportion to their speed, and their strain is not limited. With full relaxation, a
/// sheet on a table at 240 × 3 substeps a second keeps a speed of 3 mm/s.
const FULL_SPEED: f32 = 0.02;

/// Whether an island may be relaxed in this step.
pub(super) fn may_relax(plan: &Plan, island: &Island) -> bool {
    let Island { may_touch_others, strain_measured, .. } = *island;
    !(may_touch_others || strain_measured) && plan.tethers.tie_rods_of(island).is_none()
}

/// Performs the relaxed sweeps of island `number`, whose places in `own` are `range`, after the last microstep of a step, whose context is `context`. Stores
/// the displacement of each particle in `moved`, metres.
pub(super) fn relax(
    context: SolveContext,
    number: usize,
    own: IslandSlice,
    range: Range<usize>,
    mut sweep: impl FnMut(&mut Places, &mut MultiplierSlice, SolveMode) -> f32,
    (moved, strain, masses): (&mut Vec<Vec4>, &mut StrainScratch, &mut Vec<f32>),
) {
    let IslandSlice { mut places, mut multipliers, mut normal_impulses, .. } = own;
    let island = &context.plan.islands.list[number];
    let held = rows_held(context.plan, island);
    masses.clear();
    masses.extend(held.iter().map(|&row| core::mem::take(inverse_mass(&mut places, row))));
    moved.clear();
    moved.extend_from_slice(&places.position[range.clone()]);
    let motion = (rms_speed(&places.velocity[range.clone()]) / FULL_SPEED).min(1.0);
    for (nth, Relaxation { share, tolerance }) in SWEEPS.into_iter().enumerate() {
        // Particles that the last sweep does not move are within its tolerance.
        if nth + 1 == SWEEPS.len() {
            strain.before.clear();
            strain.before.extend_from_slice(&places.position[range.clone()]);
        }
        let mode = SolveMode {
            substep_context: SubstepContext { h: context.substep.h, sweeps: SWEEPS.len() as u32 },
            gradient_at: GradientAt::Current,
            project_tethers: false,
            relaxation: Some(Relaxation { share: share * motion, tolerance }),
            single_sweep: true,
            violation: f32::INFINITY,
            instructions: context.execution.instructions,
        };
        sweep(&mut places, &mut multipliers, mode);
    }
    // A position correction of an island in contact with itself would be pushed back.
    if let Some(graph) = context.plan.tethers.graph_of(island)
        && !island.may_touch_any
        && motion >= 1.0
    {
        strain.limit(graph, &mut places.position[range.clone()]);
    }
    let island = (number, context.plan.members(number));
    project_contacts(context, &mut places, &mut normal_impulses, island);
    held.iter().zip(masses).for_each(|(&row, w)| *inverse_mass(&mut places, row) = *w);
    for (i, moved) in range.zip(moved) {
        *moved = (places.position[i] - *moved).with_w(0.0);
        places.start[i] += *moved;
    }
}

/// The rows of an island that body colliders may touch, if one has pressed on any.
fn rows_held<'a>(plan: &'a Plan, island: &Island) -> &'a [u32] {
    let rows = plan.stretch(island).filter(|_| island.pressed).unwrap_or_default();
    let near = &plan.islands.rows_near_colliders;
    let place = |row: usize| near.partition_point(|&one| (one as usize) < row);
    &near[place(rows.start)..place(rows.end)]
}

fn inverse_mass<'a>(places: &'a mut Places, row: u32) -> &'a mut f32 {
    let at = places.at(row);
    &mut places.position[at].w
}

/// Root mean square speed, m/s.
fn rms_speed(velocities: &[Vec4]) -> f32 {
    let squares = velocities.iter().map(|v| v.truncate().length_squared());
    libm::sqrtf(squares.sum::<f32>() / velocities.len() as f32)
}
