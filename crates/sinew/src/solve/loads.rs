//! Loads: the forces that selected distances and constraints exerted in a step, for example to decide whether they break.
//!
//! The force is the sum of a constraint's corrections, `f = Σ m Δx / h²` over the sweeps of a substep, averaged over the substeps of a step. If what hangs on
//! the constraint is at rest, the force is its weight, however few sweeps there are and however far they are from convergence, since the forces on a body at
//! rest balance. What [recovery](super::recovery) takes off a correction counts against it, so that a weight is also read where a rest length changes from step
//! to step, as on a winch. In the first substep after a position or a velocity was set it is half of that, because Verlet falls by `½ g h²` there.
//!
//! [Tethers](super::tethers) carry loads that rods would otherwise transmit, and a rod beside a tether carries nothing. So in an island with measured loads the
//! work of the tethers is recorded as well, and each rod on the path of a tether is given the tether's force, which is what the rods would transmit. Such an
//! island has tethers however small it is. Without them, ten sweeps through a rope of a hundred pieces let it sag and swing back, and the first pull would be
//! nearly twice its weight.
//!
//! Islands with measured loads are solved constraint by constraint, before the others, on one thread, in the order of a sweep.

use core::ops::Range;

use glam::{DVec3, Vec3};

use super::chains::Eliminated;
use super::constraint_ref::{ConstraintRef, Local, SolveMode, list_constraint_refs};
use super::context::SolveContext;
use super::island::solve;
use super::momentum::MomentumDrift;
use super::multipliers::{MultiplierSlice, Multipliers};
use super::plan::{GroupKind, Plan};
use super::report::IslandReport;
use super::task_slice::IslandSlice;
use crate::collide::{NormalImpulse, NormalImpulses};
use crate::islands::Island;
use crate::particles::{Particles, Places};

/// No index.
const NONE: u32 = u32::MAX;

/// The constraints whose loads are measured, and the loads of the last step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Loads {
    distances: Measured,
    constraints: Measured,
    /// Whether the plan may have changed since its indices were looked up.
    stale: bool,
    /// Indices of the islands with measured loads, ascending.
    islands: Vec<u32>,
    /// What both tethers of each member of those islands did, island after island, kg·m.
    tethers: Vec<[f64; 2]>,
    constraint_refs: Vec<ConstraintRef>,
    local: Local,
    eliminated: Vec<Eliminated<f32>>,
    /// Scratch for reading: the pull of the tethers of each member of an island.
    carried: Vec<f64>,
}

/// Measured constraints of one list.
#[derive(Clone, Debug, Default)]
struct Measured {
    /// Their indices in the simulation's list, ascending.
    numbers: Vec<u32>,
    /// Their indices in the plan.
    places: Vec<u32>,
    /// For each constraint of the plan its index among these.
    slots: Vec<u32>,
    /// Accumulated correction of the first of its sides, kg·m.
    pulls: Vec<DVec3>,
    /// Accumulated correction by the tethers whose paths it lies on, kg·m.
    along: Vec<f64>,
}

impl Measured {
    /// Sets the constraints to measure; returns whether they changed.
    fn set(&mut self, numbers: impl Iterator<Item = usize> + Clone) -> bool {
        if numbers.clone().eq(self.numbers.iter().map(|&number| number as usize)) {
            return false;
        }
        self.numbers.clear();
        self.numbers.extend(numbers.map(|number| number as u32));
        self.numbers.sort_unstable();
        self.numbers.dedup();
        true
    }

    /// Looks up their indices in the plan, given the simulation's index of each constraint of the plan.
    fn find(&mut self, planned: &[u32]) {
        let Self { numbers, places, slots, .. } = self;
        places.clear();
        places.resize(numbers.len(), NONE);
        slots.clear();
        slots.resize(planned.len(), NONE);
        for (place, number) in planned.iter().enumerate() {
            if let Ok(slot) = numbers.binary_search(number) {
                places[slot] = place as u32;
                slots[place] = slot as u32;
            }
        }
    }

    fn begin(&mut self) {
        self.pulls.clear();
        self.pulls.resize(self.numbers.len(), DVec3::ZERO);
        self.along.clear();
        self.along.resize(self.numbers.len(), 0.0);
    }

    fn slot(&self, number: usize) -> Option<u32> {
        let slot = self.numbers.binary_search(&(number as u32)).ok()?;
        (*self.places.get(slot)? != NONE).then_some(slot as u32)
    }
}

impl Loads {
    /// Selects the distances and constraints whose loads are measured, in place of the previous ones.
    pub(crate) fn select(
        &mut self,
        distances: impl Iterator<Item = usize> + Clone,
        constraints: impl Iterator<Item = usize> + Clone,
    ) {
        let changed = self.distances.set(distances);
        self.stale |= self.constraints.set(constraints) | changed;
    }

    /// Whether none is selected.
    pub(crate) fn is_empty(&self) -> bool {
        self.distances.numbers.is_empty() && self.constraints.numbers.is_empty()
    }

    /// Marks the plan's indices as out of date, after it was compiled.
    pub(crate) fn mark_stale(&mut self) {
        self.stale = true;
    }

    /// Whether the plan's indices are out of date.
    pub(crate) fn is_stale(&self) -> bool {
        self.stale
    }

    /// Looks up the selected constraints in a plan, given the simulation's indices of its distances and constraints, and marks their islands as measured.
    pub(crate) fn find(&mut self, plan: &mut Plan, distances: &[u32], constraints: &[u32]) {
        self.stale = false;
        self.distances.find(distances);
        self.constraints.find(constraints);
        plan.islands.list.iter_mut().for_each(|island| island.measured = false);
        let is_planned = |&&place: &&u32| place != NONE;
        for &place in self.distances.places.iter().filter(is_planned) {
            let row = plan.distances[place as usize].a;
            plan.islands.list[plan.islands.of[row as usize] as usize].measured = true;
        }
        for &place in self.constraints.places.iter().filter(is_planned) {
            let row = plan.constraints[place as usize].rows[0];
            plan.islands.list[plan.islands.of[row as usize] as usize].measured = true;
        }
        let numbered = plan.islands.list.iter().zip(0..);
        self.islands.clear();
        self.islands.extend(numbered.filter(|(island, _)| island.measured).map(|(_, n)| n));
    }

    /// Begins a step.
    pub(crate) fn begin(&mut self, plan: &Plan) {
        self.distances.begin();
        self.constraints.begin();
        let members = self.islands.iter().map(|&n| plan.islands.list[n as usize].members.len());
        self.tethers.clear();
        self.tethers.resize(members.sum(), [0.0; 2]);
    }

    /// Solves the islands with measured loads, as [`solve_all`](super::solve_all) does the others. The momentum drift of their corrections is appended to a
    /// list, with the index of the island.
    pub(super) fn solve(
        &mut self,
        context: SolveContext,
        particles: &mut Particles,
        normal_impulses: &mut [NormalImpulse],
        all_multipliers: &mut Multipliers,
        reports: &mut [IslandReport],
        momentum_drifts: &mut Vec<(u32, MomentumDrift)>,
    ) {
        let plan = context.plan;
        let mut first = 0;
        for at in 0..self.islands.len() {
            let number = self.islands[at];
            let island = &plan.islands.list[number as usize];
            let own = (plan, island, first);
            first += island.members.len();
            if island.asleep {
                continue;
            }
            list_constraint_refs(plan, island, &mut self.constraint_refs);
            let momentum_drift = solve(
                context,
                number as usize,
                IslandSlice {
                    places: Places::all(particles),
                    multipliers: all_multipliers.all(),
                    normal_impulses: NormalImpulses::all(normal_impulses),
                    report: &mut reports[number as usize],
                },
                |places, multipliers, mode| self.sweep(own, places, multipliers, mode),
            );
            momentum_drifts.extend(momentum_drift.map(|drift| (number, drift)));
        }
    }

    /// Ends a step: adds the work of tethers to the rods on their paths.
    pub(crate) fn end(&mut self, plan: &Plan) {
        let Self { distances, islands, tethers, carried, .. } = self;
        let mut first = 0;
        for &number in &*islands {
            let island = &plan.islands.list[number as usize];
            let own = &tethers[first..first + island.members.len()];
            first += own.len();
            let Some(made) = plan.tethers.of(island) else { continue };
            made.distribute(own, carried, |rod, force| {
                let slot = distances.slots[rod as usize];
                if slot != NONE {
                    distances.along[slot as usize] += force;
                }
            });
        }
    }

    /// The tension of a distance, given by its index in the simulation's list, N, averaged over a step of `substeps` substeps of `h` seconds; negative under
    /// compression. `None` if it was not measured.
    pub(crate) fn distance(
        &self,
        number: usize,
        (particles, plan): (&Particles, &Plan),
        (h, substeps): (f32, u32),
    ) -> Option<f32> {
        let slot = self.distances.slot(number)? as usize;
        let (pull, along) = (*self.distances.pulls.get(slot)?, self.distances.along[slot]);
        let d = plan.distances.get(self.distances.places[slot] as usize)?;
        let apart = particles.separation(d.b as usize, d.a as usize).as_dvec3();
        let size = pull.length();
        // A distance of zero length, a joint, has no direction, so its tension is the magnitude of the force.
        let own = if d.rest > 0.0 { size.copysign(pull.dot(apart)) } else { size };
        Some(((own + along) * force_scale(h, substeps)) as f32)
    }

    /// The magnitude of the force of another constraint on the first of its sides, N; `None` if it was not measured.
    pub(crate) fn constraint(&self, number: usize, (h, substeps): (f32, u32)) -> Option<f32> {
        let slot = self.constraints.slot(number)? as usize;
        Some((self.constraints.pulls.get(slot)?.length() * force_scale(h, substeps)) as f32)
    }
}

/// Conversion factor from the sum over the substeps of a step, kg·m, to newtons.
fn force_scale(h: f32, substeps: u32) -> f64 {
    let h = f64::from(h);
    1.0 / (h * h * f64::from(substeps.max(1)))
}

impl Loads {
    /// Sweeps an island, whose tethers begin at index `first`, one constraint after the other, and records the corrections of the measured ones.
    fn sweep(
        &mut self,
        (plan, island, first): (&Plan, &Island, usize),
        places: &mut Places,
        multipliers: &mut MultiplierSlice,
        mode: SolveMode,
    ) -> f32 {
        let Self { constraint_refs, local, eliminated, distances, constraints, tethers, .. } = self;
        let tethers = &mut tethers[first..first + island.members.len()];
        let mut worst = 0.0_f32;
        if mode.project_tethers
            && let Some(made) = plan.tethers.of(island)
        {
            let members = &plan.islands.members[island.members.clone()];
            let pins: Vec<_> = made.pins(places.position, places.first).collect();
            worst = made.project_noting(places, members, &pins, tethers);
        }
        if island.has_chains() {
            let columns = (&mut *places.position, places.first);
            let found =
                plan.chains.project_noting(island, columns, eliminated, |rod, row, pull| {
                    let slot = distances.slots[rod as usize];
                    if slot != NONE {
                        let pull = pull.as_dvec3();
                        let is_first = plan.distances[rod as usize].a == row;
                        distances.pulls[slot as usize] += if is_first { pull } else { -pull };
                    }
                });
            worst = worst.max(mode.of_chains(found));
        }
        for &one in &*constraint_refs {
            let list = match one.kind {
                GroupKind::Constraints => &mut *constraints,
                _ => &mut *distances,
            };
            let slot = list.slots[one.number as usize];
            if slot == NONE {
                worst = worst.max(one.project(places, plan, multipliers, mode, local));
                continue;
            }
            let mut pair = [0; 2];
            let rows = one.rows(plan, &mut pair);
            let (side, sign) = recorded(one, (plan, places), rows);
            let rows = &rows[side];
            let before = weighted(places, rows);
            worst = worst.max(one.project(places, plan, multipliers, mode, local));
            list.pulls[slot as usize] += (weighted(places, rows) - before) * sign;
        }
        worst
    }

    /// Adds an impulse times the substep, kg·m, along the gradients of a constraint, if that is measured.
    pub(super) fn add_impulse(
        &mut self,
        (plan, places): (&Plan, &Places),
        one: ConstraintRef,
        gradients: &[Vec3],
        impulse: f32,
    ) {
        let list = match one.kind {
            GroupKind::Constraints => &mut self.constraints,
            _ => &mut self.distances,
        };
        let slot = list.slots[one.number as usize];
        if slot == NONE {
            return;
        }
        let mut pair = [0; 2];
        let rows = one.rows(plan, &mut pair);
        let (side, sign) = recorded(one, (plan, places), rows);
        let each = rows[side.clone()].iter().zip(&gradients[side]);
        let moved = each.filter(|(row, _)| places.position[places.at(**row)].w > 0.0);
        let sum: DVec3 = moved.map(|(_, by)| by.as_dvec3()).sum();
        list.pulls[slot as usize] += sum * (sign * f64::from(impulse));
    }
}

/// Which of the rows of a constraint show its force, and the sign: those of its first side, or, if all of these are pinned and so not moved, the others with the
/// opposite sign.
fn recorded(
    one: ConstraintRef,
    (plan, places): (&Plan, &Places),
    rows: &[u32],
) -> (Range<usize>, f64) {
    let side = match one.kind {
        GroupKind::Constraints => plan.constraints[one.number as usize].kind.first_side(),
        _ => 1,
    };
    let side = side.min(rows.len());
    let held = |row: &u32| places.position[places.at(*row)].w == 0.0;
    if rows[..side].iter().all(held) { (side..rows.len(), -1.0) } else { (0..side, 1.0) }
}

/// `Σ m x` of those of some particles that are not pinned, kg·m.
fn weighted(places: &Places, rows: &[u32]) -> DVec3 {
    let mut sum = DVec3::ZERO;
    for &row in rows {
        let q = places.position[places.at(row)];
        if q.w > 0.0 {
            sum += Vec3::new(q.x, q.y, q.z).as_dvec3() / f64::from(q.w);
        }
    }
    sum
}

#[cfg(test)]
mod tests;
