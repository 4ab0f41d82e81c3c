//! Relaxation: large cloth shares out, when a step ends, what its rods cannot all have.
//!
//! Where cloth is folded to a point, or hangs on a corner, its rods contradict each other: no place of the particles gives each its length. Gauss and Seidel's
//! way then goes round in a circle, in which each rod has its length when it has just been projected, and those that are first in a sweep bear at its end what
//! all others were given; more sweeps make it worse (a flag was off by 7 % at the worst, and by 10 % after eight more). If each takes a part of its error only,
//! the circle shrinks with that part about the place where the squares of the errors have the least sum (Censor, Eggermont and Gordon, *Strong underrelaxation
//! in Kaczmarz's method for inconsistent systems*, 1983).
//!
//! So a large island that takes [microsteps](super::microsteps) ends the step with a sweep of its rods in which each takes half of its error, and with two that
//! are about what is off by more than a fiftieth of its length: what is within that gives the others room. They come after the velocities have been derived, and
//! move where the substep began along with its end, so that nothing is thrown: it is a matter of what is seen, and not of what goes on.
//!
//! What nothing holds, no pin and no surface, is left as it is: it bears no load, and to move it without its velocity would take some of its spin. So is what
//! may touch particles of another body, and what something is tied to: those would be pushed, and thus be given the speed, by what has none. Where a shape of another body has
//! pressed on the island in this step, what that may come to touch is held meanwhile as if it were pinned, and the rest is relaxed.
//!
//! The next sweep goes back into its circle, which is a motion, if one that nobody sees, and is left in the velocities. So the less the slower the island is,
//! and what lies still stays as it lies.

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

/// The sweeps. Of capes, flags and sheets over four to six starts each, worst strains in the mean: none 2.8 to 9.9 %, two by a half and a third 2.2 to 6.5, these
/// 2.0 to 4.9; a fourth gains nothing.
const SWEEPS: [Relaxation; 3] = [
    Relaxation { share: 0.5, tolerance: 0.0 },
    Relaxation { share: 0.7, tolerance: 0.02 },
    Relaxation { share: 0.5, tolerance: 0.02 },
];

/// Islands that are slower than this, m/s, root mean square, are relaxed by as much less, and their strain is not limited. A sheet on a table at 240 × 3 substeps a
/// second is left with 3 mm/s by the whole of it.
const CALM: f32 = 0.02;

/// Whether an island may be relaxed in this step.
pub(super) fn may_relax(plan: &Plan, island: &Island) -> bool {
    let Island { meets_others, strain_measured, .. } = *island;
    !(meets_others || strain_measured) && plan.tethers.tie_rods_of(island).is_none()
}

/// Takes the island of a number, whose places are in such a range of its own, through the relaxed sweeps after the last microstep of a step, which `context` is of.
/// Leaves in `moved` how far each particle went, metres.
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
    let motion = (rms_speed(&places.velocity[range.clone()]) / CALM).min(1.0);
    for (nth, Relaxation { share, tolerance }) in SWEEPS.into_iter().enumerate() {
        // What the last one leaves where it was is within its tolerance.
        if nth + 1 == SWEEPS.len() {
            strain.before.clear();
            strain.before.extend_from_slice(&places.position[range.clone()]);
        }
        let mode = SolveMode {
            substep_context: SubstepContext { h: context.substep.h, sweeps: SWEEPS.len() as u32 },
            gradient_at: GradientAt::Current,
            tethers: false,
            relaxed: Some(Relaxation { share: share * motion, tolerance }),
            single_sweep: true,
            violation: f32::INFINITY,
            instructions: context.execution.instructions,
        };
        sweep(&mut places, &mut multipliers, mode);
    }
    // What touches itself would be pushed back.
    if let Some(graph) = context.plan.tethers.graph_of(island)
        && !island.meets_any
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

/// The rows of an island that shapes of other bodies may come to touch, where one has pressed on any.
fn rows_held<'a>(plan: &'a Plan, island: &Island) -> &'a [u32] {
    let rows = plan.stretch(island).filter(|_| island.pressed).unwrap_or_default();
    let near = &plan.islands.near_shapes;
    let place = |row: usize| near.partition_point(|&one| (one as usize) < row);
    &near[place(rows.start)..place(rows.end)]
}

fn inverse_mass<'a>(places: &'a mut Places, row: u32) -> &'a mut f32 {
    let at = places.at(row);
    &mut places.position[at].w
}

/// Root mean square, m/s.
fn rms_speed(velocities: &[Vec4]) -> f32 {
    let squares = velocities.iter().map(|v| v.truncate().length_squared());
    libm::sqrtf(squares.sum::<f32>() / velocities.len() as f32)
}
