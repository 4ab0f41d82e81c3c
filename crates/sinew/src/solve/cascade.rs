//! The cascade: constraints enforced one after the other, colour by colour (Gauss–Seidel). The order never changes from substep to substep, because
//! alternating it pumps energy.

use super::item::{Local, Manner, project_constraint};
use super::plan::{Island, Kind, Plan};
use crate::constraints::{Direction, project, project_rod, project_rod_from_start};
use crate::particles::Particles;

/// Projects every constraint of an island once and returns the largest error found, metres; of soft ones, how far they moved.
pub(super) fn sweep(
    particles: &mut Particles,
    plan: &mut Plan,
    island: &Island,
    manner: Manner,
    local: &mut Local,
) -> f32 {
    let mut worst = 0.0_f32;
    for group in &plan.groups[island.groups.clone()] {
        let range = group.range.clone();
        if group.kind == Kind::Constraints {
            let multipliers = &mut plan.multipliers[range.clone()];
            for (constraint, lambda) in plan.constraints[range].iter().zip(multipliers) {
                worst = worst.max(project_constraint(particles, constraint, manner, lambda, local));
            }
            continue;
        }
        let positions = particles.position.as_mut_slice();
        let (starts, distances) = (particles.start.as_slice(), &plan.distances[range.clone()]);
        match (group.kind, manner.direction) {
            (Kind::Rods, Direction::Nearest) => {
                for d in distances {
                    worst = worst.max(project_rod(positions, d.a, d.b, d.rest));
                }
            }
            (Kind::Rods, Direction::StepStart) => {
                for d in distances {
                    worst = worst.max(project_rod_from_start(positions, starts, d.a, d.b, d.rest));
                }
            }
            _ => {
                for (d, lambda) in distances.iter().zip(&mut plan.lambdas[range]) {
                    worst = worst.max(project(positions, starts, d, manner.pace, lambda));
                }
            }
        }
    }
    worst
}
