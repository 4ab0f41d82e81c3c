//! Body colliders of dormant islands: asleep as in the last step, where nothing has been done to them. What is found of them when a step begins (poses, swept
//! bounds, manifolds that are carried over) is what was found in the step before, and is kept instead.
//!
//! The first step of a set of dormant islands finds all of it, with them asleep; from the next one on it is kept. Who is in a contact with somebody awake has its
//! rows written to: then all is found anew in the next step, which comes to the same.

use super::super::world::World;
use super::groups::BodyGroups;
use crate::lanes::LANES;

/// Which body colliders are dormant. Scratch.
#[derive(Debug, Default)]
pub(super) struct DormantColliders {
    /// The number of the dormant islands that it is about; 0 for none.
    number: u64,
    /// Whether what was found of them in the step before is kept in this one.
    pub(super) is_kept: bool,
    /// For each group a bit for each that is dormant.
    lanes: Vec<u32>,
    /// The other ones, and all, ascending.
    others: Vec<u32>,
    all: Vec<u32>,
}

impl DormantColliders {
    /// Has everything be found in the next step.
    pub(super) fn forget(&mut self) {
        (self.number, self.is_kept) = (0, false);
    }

    /// Begins a step, before which those of `met` were in a contact: a bit for each, by groups. Returns whether others are dormant than in the step before.
    pub(super) fn begin(&mut self, world: &World, groups: &BodyGroups, met: &[u32]) -> bool {
        let islands = world.islands;
        // Sensors hear of those that lie in them in each step.
        let waits = world.colliders.iter().any(|collider| collider.sensor);
        let number = if waits { 0 } else { islands.dormant_number };
        let is_new = self.number != number;
        if is_new || self.all.len() != groups.parts.len() {
            self.number = number;
            self.find(world, groups);
        }
        let met = self.lanes.iter().zip(met).any(|(own, met)| own & met != 0);
        self.is_kept = number != 0 && !is_new && !met;
        is_new
    }

    fn find(&mut self, world: &World, groups: &BodyGroups) {
        let Self { number, lanes, others, all, .. } = self;
        let islands = world.islands;
        lanes.clear();
        lanes.resize(groups.groups.len(), 0);
        others.clear();
        all.clear();
        all.extend(0..groups.parts.len() as u32);
        if *number == 0 {
            return;
        }
        let is_dormant = |row: &u32| {
            let island = islands.of.get(*row as usize);
            island.is_some_and(|&island| islands.dormant.get(island as usize) == Some(&true))
        };
        for (number, part) in groups.parts.iter().enumerate() {
            if part.sound && groups.rows[part.entries.clone()].iter().all(is_dormant) {
                let place = groups.place(number);
                lanes[place / LANES] |= 1 << (place % LANES);
            } else {
                others.push(number as u32);
            }
        }
    }

    /// Those that are looked at in this step, ascending.
    pub(super) fn looked(&self) -> &[u32] {
        if self.is_kept { &self.others } else { &self.all }
    }

    /// For each group a bit for each that is as it was in the step before.
    pub(super) fn kept(&self) -> &[u32] {
        if self.is_kept { &self.lanes } else { &[] }
    }

    /// The same of one group.
    pub(super) fn kept_of(&self, group: usize) -> u32 {
        self.kept().get(group).copied().unwrap_or(0)
    }

    /// Whether a body collider is dormant, whether or not anything of it is kept.
    pub(super) fn has(&self, groups: &BodyGroups, number: usize) -> bool {
        let place = groups.place(number);
        self.number != 0 && self.lanes[place / LANES] >> (place % LANES) & 1 == 1
    }

    /// Whether both of a pair are dormant, or the second one stands: those are all that have numbers behind body colliders.
    pub(super) fn have_both(&self, groups: &BodyGroups, [a, b]: [u32; 2]) -> bool {
        let stands = b as usize >= groups.parts.len();
        self.has(groups, a as usize) && (stands || self.has(groups, b as usize))
    }
}
