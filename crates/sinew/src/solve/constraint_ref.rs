//! A reference to one constraint of the plan, of any kind. The orders that pick constraints one by one work with it.

use glam::{Vec3, Vec4};

use super::multipliers::MultiplierSlice;
use super::plan::{ClusterBatch, GroupKind, Plan};
use super::rods::Relaxation;
use crate::constraints::{
    Constraint, Distance, Equation, GradientAt, Points, SubstepContext, equation_energy,
    equation_error, project, project_equation, project_rod, project_rod_from_start,
};
use crate::islands::Island;
use crate::lanes::InstructionSet;
use crate::particles::{Particles, Places};

/// A constraint of the plan: its kind, and its number in the list of that kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ConstraintRef {
    pub(crate) kind: GroupKind,
    pub(crate) number: u32,
}

/// How constraints are projected in this substep.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SolveMode {
    pub(crate) substep_context: SubstepContext,
    pub(crate) gradient_at: GradientAt,
    /// Whether tethers and spans are projected in this sweep.
    pub(crate) project_tethers: bool,
    /// In a sweep of rods alone, the share of their errors that rods correct: see [`relaxation`](super::relaxation). `None` in normal sweeps.
    pub(crate) relaxation: Option<Relaxation>,
    /// Whether this is the only sweep of the substep, so that no multiplier has to be accumulated.
    pub(crate) single_sweep: bool,
    /// An error above this counts as a violation, metres.
    pub(crate) violation: f32,
    /// The instruction set of the kernels.
    pub(crate) instructions: InstructionSet,
}

impl SolveMode {
    /// Whether a cluster batch takes part in the sweep.
    pub(super) fn takes(&self, cluster_batch: &ClusterBatch) -> bool {
        self.relaxation.is_none() || cluster_batch.kind == GroupKind::Rods
    }

    /// What the largest error found in chains, metres, counts as. A direct solve corrects it at once, so it counts only where it is a violation.
    pub(super) fn of_chains(&self, found: f32) -> f32 {
        if found > self.violation { found } else { 0.0 }
    }
}

/// The particles of one constraint, copied side by side in its own order. Scratch.
#[derive(Clone, Debug, Default)]
pub(crate) struct Local {
    pub(crate) now: Vec<Vec4>,
    pub(crate) starts: Vec<Vec4>,
    pub(crate) gradients: Vec<Vec3>,
}

impl Local {
    /// Copies the particles in some rows.
    #[inline]
    pub(crate) fn take(&mut self, places: &Places, rows: &[u32]) {
        self.now.clear();
        self.starts.clear();
        for &row in rows {
            let i = places.at(row);
            self.now.push(places.position[i]);
            self.starts.push(places.start[i]);
        }
        self.gradients.resize(rows.len(), Vec3::ZERO);
    }
}

/// Lists the constraints of an island in solving order.
pub(super) fn list_constraint_refs(
    plan: &Plan,
    island: &Island,
    constraint_refs: &mut Vec<ConstraintRef>,
) {
    constraint_refs.clear();
    for group in &plan.groups[island.groups.clone()] {
        constraint_refs.extend(
            group.range.clone().map(|n| ConstraintRef { kind: group.kind, number: n as u32 }),
        );
    }
}

impl ConstraintRef {
    /// The rows of its particles. A distance writes them into `pair`.
    pub(crate) fn rows<'a>(self, plan: &'a Plan, pair: &'a mut [u32; 2]) -> &'a [u32] {
        let number = self.number as usize;
        if self.kind == GroupKind::Constraints {
            &plan.constraints[number].rows
        } else {
            let distance = &plan.distances[number];
            *pair = [distance.a, distance.b];
            pair
        }
    }

    /// The constraint as an equation.
    pub(crate) fn equation(self, plan: &Plan) -> &dyn Equation {
        let number = self.number as usize;
        match self.kind {
            GroupKind::Rods | GroupKind::Distances => &plan.distances[number],
            GroupKind::Constraints => plan.constraints[number].kind.equation(),
        }
    }

    /// Whether it has to be satisfied, so that its error requires another sweep.
    pub(crate) fn is_hard(self, plan: &Plan) -> bool {
        self.equation(plan).softness().is_hard()
    }

    /// Projects the constraint once, on the particles themselves. Returns the error found, metres; for a compliant one the size of the correction.
    #[inline]
    pub(crate) fn project(
        self,
        places: &mut Places,
        plan: &Plan,
        multipliers: &mut MultiplierSlice,
        mode: SolveMode,
        local: &mut Local,
    ) -> f32 {
        let number = self.number as usize;
        match self.kind {
            GroupKind::Rods => {
                let d = plan.distances[number];
                let (a, b) = (places.at(d.a) as u32, places.at(d.b) as u32);
                match mode.gradient_at {
                    GradientAt::Current => project_rod(places.position, a, b, d.rest),
                    GradientAt::StepStart => {
                        project_rod_from_start(places.position, places.start, a, b, d.rest)
                    }
                }
            }
            GroupKind::Distances => {
                let (distance, lambda) = (&plan.distances[number], multipliers.distance(number));
                project_distance(places, distance, mode.substep_context, lambda)
            }
            GroupKind::Constraints => {
                let (constraint, lambda) =
                    (&plan.constraints[number], multipliers.constraint(number));
                project_constraint(places, constraint, mode, lambda, local)
            }
        }
    }

    /// Projects the constraint once on the copies in `local`, which may have other inverse masses.
    pub(crate) fn project_local(
        self,
        plan: &Plan,
        multipliers: &mut MultiplierSlice,
        mode: SolveMode,
        origin: Vec3,
        local: &mut Local,
    ) -> f32 {
        let number = self.number as usize;
        let Local { now, starts, gradients } = local;
        if self.kind == GroupKind::Constraints {
            let equation = plan.constraints[number].kind.equation();
            let before = now.clone();
            let points = Points { now: &before, starts, origin, gradient_at: mode.gradient_at };
            let lambda = multipliers.constraint(number);
            return project_equation(
                equation,
                &points,
                gradients,
                mode.substep_context,
                lambda,
                |i, step| {
                    now[i] += step.extend(0.0);
                },
            );
        }
        let distance = Distance { a: 0, b: 1, ..plan.distances[number] };
        if self.kind == GroupKind::Rods && mode.gradient_at == GradientAt::StepStart {
            return project_rod_from_start(now, starts, 0, 1, distance.rest);
        }
        project(now, starts, &distance, mode.substep_context, multipliers.distance(number))
    }

    /// The error, metres, without moving anything; zero for a compliant constraint.
    pub(crate) fn error(self, places: &Places, plan: &Plan, local: &mut Local) -> f32 {
        let number = self.number as usize;
        if self.kind == GroupKind::Constraints {
            return constraint_error(places, &plan.constraints[number], local);
        }
        distance_error(places, &plan.distances[number])
    }
}

/// The error of a hard distance, metres; zero for a compliant one, and between pinned particles.
#[inline]
pub(crate) fn distance_error(places: &Places, distance: &Distance) -> f32 {
    let at = |row: u32| places.position[places.at(row)];
    let (a, b) = (at(distance.a), at(distance.b));
    if !distance.softness.is_hard() || a.w + b.w == 0.0 {
        return 0.0;
    }
    distance.error(a.truncate(), b.truncate())
}

/// Energy that the compliant distances and constraints of a plan store, J.
pub(crate) fn soft_energy(particles: &mut Particles, plan: &Plan) -> f64 {
    let places = &Places::all(particles);
    let mut local = Local::default();
    let soft = plan.distances.iter().filter(|d| !d.softness.is_hard());
    let distances = soft.map(|d| {
        let (a, b) = (places.position[d.a as usize], places.position[d.b as usize]);
        let value = (a - b).truncate().length() - d.rest;
        let held = d.bound.holds(value);
        if held { 0.0 } else { f64::from(d.softness.energy(value, a.w + b.w)) }
    });
    let mut sum: f64 = distances.sum();
    for constraint in &plan.constraints {
        let equation = constraint.kind.equation();
        if !equation.softness().is_hard() {
            let rows = constraint.rows.as_slice();
            local.take(places, rows);
            let (origin, gradient_at) = (places.origin[rows[0] as usize], GradientAt::Current);
            let points = Points { now: &local.now, starts: &local.starts, origin, gradient_at };
            sum += f64::from(equation_energy(equation, &points, &mut local.gradients));
        }
    }
    sum
}

/// Projects a distance by the general kernel.
#[inline]
pub(crate) fn project_distance(
    places: &mut Places,
    distance: &Distance,
    substep_context: SubstepContext,
    lambda: &mut f32,
) -> f32 {
    let (a, b) = (places.at(distance.a) as u32, places.at(distance.b) as u32);
    let local = Distance { a, b, ..*distance };
    project(places.position, places.start, &local, substep_context, lambda)
}

/// Projects a constraint by its equation.
#[inline]
pub(crate) fn project_constraint(
    places: &mut Places,
    constraint: &Constraint,
    mode: SolveMode,
    lambda: &mut f32,
    local: &mut Local,
) -> f32 {
    let rows = constraint.rows.as_slice();
    local.take(places, rows);
    let origin = places.origin[places.at(rows[0])];
    let gradient_at = mode.gradient_at;
    let points = Points { now: &local.now, starts: &local.starts, origin, gradient_at };
    let equation = constraint.kind.equation();
    project_equation(
        equation,
        &points,
        &mut local.gradients,
        mode.substep_context,
        lambda,
        |i, step| {
            places.displace(rows[i], step);
        },
    )
}

/// The error of a constraint, metres.
pub(crate) fn constraint_error(places: &Places, constraint: &Constraint, local: &mut Local) -> f32 {
    let rows = constraint.rows.as_slice();
    local.take(places, rows);
    let origin = places.origin[places.at(rows[0])];
    let gradient_at = GradientAt::Current;
    let points = Points { now: &local.now, starts: &local.starts, origin, gradient_at };
    equation_error(constraint.kind.equation(), &points, &mut local.gradients)
}
