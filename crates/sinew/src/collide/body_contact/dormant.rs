//! Body colliders of dormant islands: asleep as in the last step, with nothing done to them. The poses, swept bounds and carried-over manifolds that the step
//! before has found of them are kept instead of being computed again.
//!
//! The first step of a set of dormant islands computes all of it with them asleep; the following ones keep it. Rows of a dormant body collider in a contact
//! with an awake one are written to: then the next step computes everything again, with the same result.

use super::super::world::World;
use super::groups::BodyGroups;
use crate::lanes::LANES;

/// The dormant body colliders. Scratch.
#[derive(Debug, Default)]
pub(super) struct DormantColliders {
    /// Number of the set of dormant islands that this is about; 0 for none.
    number: u64,
    /// Whether this step keeps what the step before has found of them.
    pub(super) is_kept: bool,
    /// For each group a bit for each dormant body collider.
    lanes: Vec<u32>,
    /// All body colliders that are not dormant, and all; ascending.
    others: Vec<u32>,
    all: Vec<u32>,
}

impl DormantColliders {
    /// Makes the next step compute everything again.
    pub(super) fn invalidate(&mut self) {
        (self.number, self.is_kept) = (0, false);
    }

    /// Begins a step. `in_contact` has for each group a bit for each body collider with a contact in the step before. Returns whether the set of dormant
    /// islands has changed.
    pub(super) fn begin(&mut self, world: &World, groups: &BodyGroups, in_contact: &[u32]) -> bool {
        let islands = world.islands;
        // Sensors report overlaps with sleeping bodies in each step.
        let has_sensors = world.colliders.iter().any(|collider| collider.sensor);
        let number = if has_sensors { 0 } else { islands.dormant_number };
        let is_new = self.number != number;
        if is_new || self.all.len() != groups.parts.len() {
            self.number = number;
            self.classify(world, groups);
        }
        let touched = self.lanes.iter().zip(in_contact).any(|(own, bits)| own & bits != 0);
        self.is_kept = number != 0 && !is_new && !touched;
        is_new
    }

    fn classify(&mut self, world: &World, groups: &BodyGroups) {
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

    /// Numbers of the body colliders that this step computes, ascending.
    pub(super) fn active(&self) -> &[u32] {
        if self.is_kept { &self.others } else { &self.all }
    }

    /// For each group a bit for each body collider that is as it was in the step before.
    pub(super) fn kept(&self) -> &[u32] {
        if self.is_kept { &self.lanes } else { &[] }
    }

    /// Those of one group.
    pub(super) fn kept_of(&self, group: usize) -> u32 {
        self.kept().get(group).copied().unwrap_or(0)
    }

    /// Whether a body collider is dormant, kept or not.
    pub(super) fn is_dormant(&self, groups: &BodyGroups, number: usize) -> bool {
        let place = groups.place(number);
        self.number != 0 && self.lanes[place / LANES] >> (place % LANES) & 1 == 1
    }

    /// Whether both of a pair are dormant, or the second is static or kinematic geometry, which has numbers after those of body colliders.
    pub(super) fn are_both_dormant(&self, groups: &BodyGroups, [a, b]: [u32; 2]) -> bool {
        let is_geometry = b as usize >= groups.parts.len();
        self.is_dormant(groups, a as usize) && (is_geometry || self.is_dormant(groups, b as usize))
    }
}
