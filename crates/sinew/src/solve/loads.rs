//! Loads: with what force single distances and constraints held in a step, for whoever wants something to break.
//!
//! The force is the sum of what a constraint did, `f = Σ m Δx / h²` over the sweeps of a substep, in the mean over the substeps of a step. Where what hangs
//! on it is at rest it is the weight, however few sweeps there are and however far they are from done: what moves nothing balances. In the first substep after
//! a position or a velocity was set it is half of that, for so far Verlet falls there.
//!
//! [Tethers](super::tethers) carry what rods would have to hand on, and a rod beside one feels nothing. So an island with loads to be measured has what its
//! tethers did counted as well, and each rod on the way of a tether is given the force of it: that is what the rods would hand on. Such an island has
//! tethers however small it is. Without them, ten sweeps through a rope of a hundred pieces let it sag and swing back, and the first pull would be nearly
//! twice its weight.
//!
//! Islands with loads to be measured are solved constraint by constraint, before the others, on one thread: what is done is done in the order of a sweep.

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
use crate::constraints::GradientAt;
use crate::islands::Island;
use crate::particles::{Particles, Places};

/// Stands where a number has no place.
const NONE: u32 = u32::MAX;

/// Whose loads are measured, and what they have been in the last step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Loads {
    distances: Wanted,
    constraints: Wanted,
    /// Whether the plan may have changed since its places were looked up.
    stale: bool,
    /// Numbers of the islands that have any, ascending.
    islands: Vec<u32>,
    /// What the tethers of the members of those islands did, each island after the one before, kg·m.
    tethers: Vec<[f64; 2]>,
    constraint_refs: Vec<ConstraintRef>,
    local: Local,
    eliminated: Vec<Eliminated<f32>>,
    /// Of reading off: what the tethers of each member of an island pull with.
    carried: Vec<f64>,
}

/// Some constraints of one list.
#[derive(Clone, Debug, Default)]
struct Wanted {
    /// Their numbers in the list of the simulation, ascending.
    numbers: Vec<u32>,
    /// Their places in the plan.
    places: Vec<u32>,
    /// Of each constraint of the plan, which of these it is.
    slots: Vec<u32>,
    /// What each did to the first of its sides, kg·m.
    pulls: Vec<DVec3>,
    /// What tethers on the way of which it is did, kg·m.
    along: Vec<f64>,
}

impl Wanted {
    /// Whether others are wanted than before.
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

    /// Looks up the places in the plan, of which the constraints have these numbers.
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
    /// Wants the loads of distances and constraints with these numbers, and of no others.
    pub(crate) fn want(
        &mut self,
        distances: impl Iterator<Item = usize> + Clone,
        constraints: impl Iterator<Item = usize> + Clone,
    ) {
        let changed = self.distances.set(distances);
        self.stale |= self.constraints.set(constraints) | changed;
    }

    /// Whether none is wanted.
    pub(crate) fn is_empty(&self) -> bool {
        self.distances.numbers.is_empty() && self.constraints.numbers.is_empty()
    }

    /// The plan has been compiled.
    pub(crate) fn expire(&mut self) {
        self.stale = true;
    }

    /// Whether the plan has to be looked at again.
    pub(crate) fn is_stale(&self) -> bool {
        self.stale
    }

    /// Looks up what is wanted in a plan whose distances and constraints have these numbers, and marks its islands.
    pub(crate) fn find(&mut self, plan: &mut Plan, distances: &[u32], constraints: &[u32]) {
        self.stale = false;
        self.distances.find(distances);
        self.constraints.find(constraints);
        plan.islands.list.iter_mut().for_each(|island| island.measured = false);
        let sound = |&&place: &&u32| place != NONE;
        for &place in self.distances.places.iter().filter(sound) {
            let row = plan.distances[place as usize].a;
            plan.islands.list[plan.islands.of[row as usize] as usize].measured = true;
        }
        for &place in self.constraints.places.iter().filter(sound) {
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

    /// Solves the islands that are measured, as [`solve_all`](super::solve_all) does others; what their corrections gave them and should not have is
    /// added to a list, with the number of the island.
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

    /// Ends a step: hands what tethers did on to the rods on their way.
    pub(crate) fn end(&mut self, plan: &Plan) {
        let Self { distances, islands, tethers, carried, .. } = self;
        let mut first = 0;
        for &number in &*islands {
            let island = &plan.islands.list[number as usize];
            let own = &tethers[first..first + island.members.len()];
            first += own.len();
            let Some(made) = plan.tethers.of(island) else { continue };
            made.hand_on(own, carried, |rod, force| {
                let slot = distances.slots[rod as usize];
                if slot != NONE {
                    distances.along[slot as usize] += force;
                }
            });
        }
    }

    /// The tension of the distance with a number in the list of the simulation, N, in the mean over a step of so many substeps of `h` seconds; negative
    /// under pressure. `None` if it was not measured.
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
        // One of no length, a joint, has no direction, and pulls wherever it pulls.
        let own = if d.rest > 0.0 { size.copysign(pull.dot(apart)) } else { size };
        Some(((own + along) * per_square(h, substeps)) as f32)
    }

    /// The force of another constraint on the first of its sides, N; `None` if it was not measured.
    pub(crate) fn constraint(&self, number: usize, (h, substeps): (f32, u32)) -> Option<f32> {
        let slot = self.constraints.slot(number)? as usize;
        Some((self.constraints.pulls.get(slot)?.length() * per_square(h, substeps)) as f32)
    }
}

/// From what was summed up over the substeps of a step, kg·m, to newtons.
fn per_square(h: f32, substeps: u32) -> f64 {
    let h = f64::from(h);
    1.0 / (h * h * f64::from(substeps.max(1)))
}

impl Loads {
    /// Sweeps an island, whose tethers begin with number `first`, one constraint after the other, and notes what those do that are measured.
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
        // As for others: not where corrections are to keep energy.
        if mode.tethers
            && mode.gradient_at == GradientAt::Current
            && let Some(made) = plan.tethers.of(island)
        {
            let members = &plan.islands.members[island.members.clone()];
            let pins: Vec<_> = made.pins(places.position, places.first).collect();
            worst = made.project_noting(places, members, &pins, tethers);
        }
        if mode.gradient_at == GradientAt::Current && island.has_chains() {
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
            let wanted = match one.kind {
                GroupKind::Constraints => &mut *constraints,
                _ => &mut *distances,
            };
            let slot = wanted.slots[one.number as usize];
            if slot == NONE {
                worst = worst.max(one.project(places, plan, multipliers, mode, local));
                continue;
            }
            let mut pair = [0; 2];
            let rows = one.rows(plan, &mut pair);
            let side = match one.kind {
                GroupKind::Constraints => plan.constraints[one.number as usize].kind.first_side(),
                _ => 1,
            };
            // What nothing moves says nothing: then the other side does, with the other sign.
            let held = |row: &u32| places.position[places.at(*row)].w == 0.0;
            let (rows, sign) = match rows.split_at(side.min(rows.len())) {
                (first, others) if first.iter().all(held) => (others, -1.0),
                (first, _) => (first, 1.0),
            };
            let before = weighted(places, rows);
            worst = worst.max(one.project(places, plan, multipliers, mode, local));
            wanted.pulls[slot as usize] += (weighted(places, rows) - before) * sign;
        }
        worst
    }
}

/// `Σ m x` of some particles that are not pinned, kg·m.
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
