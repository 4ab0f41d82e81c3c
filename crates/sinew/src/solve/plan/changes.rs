//! Changes: constraints added to and removed from the input lists since a plan was compiled, and the renumbering that results.

use super::PlanInput;
use super::keys::{DISTANCES, Fields, Key, RODS, rank_of, rank_of_kind};
use crate::constraints::Rows;

/// Most changes that are recorded one by one. Beyond this an incremental update hardly pays, since each change costs a search through all keys.
pub(super) const MAX_CHANGES: usize = 16;

/// The input lists of constraints.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum List {
    Distances,
    Constraints,
}

/// An addition to a list or a removal from it. Indices are those at that moment: an addition shifts all later indices up by one, a removal down by one.
#[derive(Clone, Debug)]
pub(crate) enum Change {
    Added(List, usize),
    /// With the particles that the constraint connected.
    Removed(List, usize, Rows),
}

/// Changes of the input lists since the plan was compiled.
#[derive(Clone, Debug)]
pub(crate) struct Changes {
    /// How many entries at the beginning of each list are unchanged.
    same: [usize; 2],
    /// The changes one by one, unless there are too many.
    few: Vec<Change>,
    many: bool,
}

/// No changes.
impl Default for Changes {
    fn default() -> Self {
        Self { same: [usize::MAX; 2], few: Vec::new(), many: false }
    }
}

impl Changes {
    /// Marks everything as possibly changed.
    pub(crate) fn note_all(&mut self) {
        self.note_from(List::Distances, 0);
        self.note_from(List::Constraints, 0);
    }

    /// Marks a list as possibly changed, except for its first `same` entries.
    pub(crate) fn note_from(&mut self, list: List, same: usize) {
        self.many = true;
        let own = &mut self.same[list as usize];
        *own = same.min(*own);
    }

    /// Records that the compounds with a collision shape changed. The constraints did not.
    pub(crate) fn note_colliders(&mut self) {
        self.many = true;
    }

    pub(crate) fn note(&mut self, change: Change) {
        let (&Change::Added(list, at) | &Change::Removed(list, at, _)) = &change;
        let own = &mut self.same[list as usize];
        *own = at.min(*own);
        self.many |= self.few.len() == MAX_CHANGES;
        if !self.many {
            self.few.push(change);
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        !self.many && self.few.is_empty()
    }

    /// Whether the changes are few enough to be recorded one by one.
    pub(crate) fn are_few(&self) -> bool {
        !self.many
    }

    /// How many distances and how many constraints at the beginning of their lists are unchanged.
    pub(crate) fn same(&self) -> [usize; 2] {
        self.same
    }

    /// Whether one of the recorded changes connected, or may connect, two particles, consecutive in the constraint, for which the predicate is true.
    pub(crate) fn any_between(&self, given: PlanInput, holds: impl Fn(u32, u32) -> bool) -> bool {
        let between = |rows: &[u32]| rows.windows(2).any(|pair| holds(pair[0], pair[1]));
        // Each later change may have shifted an added entry by one.
        let around = |at: usize| at.saturating_sub(MAX_CHANGES)..=at + MAX_CHANGES;
        self.few.iter().any(|change| match change {
            Change::Removed(.., rows) => between(rows),
            &Change::Added(List::Distances, at) => {
                let mut near = around(at).filter_map(|i| given.distances.get(i));
                near.any(|d| between(&[d.a, d.b]))
            }
            &Change::Added(List::Constraints, at) => {
                let mut near = around(at).filter_map(|i| given.constraints.get(i));
                near.any(|c| between(&c.rows))
            }
        })
    }

    pub(crate) fn clear(&mut self) {
        self.same = [usize::MAX; 2];
        self.few.clear();
        self.many = false;
    }

    /// Removes the keys of removed constraints and renumbers the others. Returns the removed keys and the valid additions.
    pub(super) fn renumber(
        &self,
        keys: &mut Vec<Key>,
        given: &PlanInput,
    ) -> (Vec<Removed>, Vec<Added>) {
        let (mut removed, mut added) = (Vec::new(), Vec::<Added>::new());
        for change in &self.few {
            let (&Change::Added(list, number) | &Change::Removed(list, number, _)) = change;
            let (number, mut step) = (number as u32, 1);
            if let Change::Removed(.., rows) = change {
                let own = |key: &Key| list_of(key) == list && key.number == number;
                if let Some(place) = keys.iter().position(own) {
                    removed.push((keys.remove(place), rows.clone()));
                }
                added.retain(|&one| one != (list, number));
                step = -1;
            }
            let old = keys.iter_mut().filter(|key| list_of(key) == list).map(|key| &mut key.number);
            let new = added.iter_mut().filter(|(of, _)| *of == list).map(|(_, number)| number);
            for later in old.chain(new).filter(|later| **later >= number) {
                *later = later.wrapping_add_signed(step);
            }
            if let Change::Added(..) = change {
                added.push((list, number));
            }
        }
        added.retain(|&(list, number)| given.is_valid(list, number as usize));
        (removed, added)
    }
}

/// A removed constraint: its key, and the particles that it connected.
pub(super) type Removed = (Key, Rows);

/// An added constraint: its list and its index there.
pub(super) type Added = (List, u32);

/// The list that the constraint of a key is in.
pub(super) fn list_of(key: &Key) -> List {
    match Fields::of(key.group).rank {
        RODS | DISTANCES => List::Distances,
        _ => List::Constraints,
    }
}

impl PlanInput<'_> {
    /// The valid distances and constraints after the first `same` entries of each list.
    pub(super) fn valid_from(&self, same: [usize; 2]) -> Vec<Added> {
        let [distances, constraints] = same;
        let each = (distances..self.distances.len()).map(|number| (List::Distances, number));
        let others = (constraints..self.constraints.len()).map(|n| (List::Constraints, n));
        let valid = each.chain(others).filter(|&(list, number)| self.is_valid(list, number));
        valid.map(|(list, number)| (list, number as u32)).collect()
    }

    /// Calls `act` with the particles of a constraint.
    pub(super) fn on_rows<T>(&self, list: List, number: u32, act: impl FnOnce(&[u32]) -> T) -> T {
        match list {
            List::Distances => {
                let d = &self.distances[number as usize];
                act(&[d.a, d.b])
            }
            List::Constraints => act(&self.constraints[number as usize].rows),
        }
    }

    pub(super) fn is_valid(&self, list: List, number: usize) -> bool {
        match list {
            List::Distances => self.distances[number].fault(self.particles).is_none(),
            List::Constraints => self.constraints[number].fault(self.particles).is_none(),
        }
    }

    /// The particles of a constraint, and the rank of its kind in a sweep.
    pub(super) fn rows_and_rank(&self, list: List, number: usize) -> (Rows, u32) {
        let rank = match list {
            List::Distances => rank_of(&self.distances[number]),
            List::Constraints => rank_of_kind(&self.constraints[number].kind),
        };
        (self.on_rows(list, number as u32, Rows::from_slice), rank)
    }
}
