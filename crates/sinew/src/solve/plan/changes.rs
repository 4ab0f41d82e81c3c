//! Changes: what was added to the lists and removed from them since a plan was compiled, and what numbers that leaves to the rest.

use super::Given;
use super::keys::{DISTANCES, Fields, Key, RODS, rank_of, rank_of_kind};
use crate::constraints::Rows;

/// With more changes than these it is hardly worth it: each is looked for among all.
pub(super) const MOST: usize = 16;

/// The lists that constraints are given in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum List {
    Distances,
    Constraints,
}

/// Something that was added to a list or removed from it. Numbers are those at that moment: what was added moved all behind it one up, what was
/// removed one down.
#[derive(Clone, Debug)]
pub(crate) enum Change {
    Added(List, usize),
    /// With the particles that it bound.
    Removed(List, usize, Rows),
}

/// What changed in the lists since the plan was compiled.
#[derive(Clone, Debug)]
pub(crate) struct Changes {
    /// How many of each list, from the first on, are what they were.
    same: [usize; 2],
    /// The changes one by one, unless there are too many.
    few: Vec<Change>,
    many: bool,
}

/// None.
impl Default for Changes {
    fn default() -> Self {
        Self { same: [usize::MAX; 2], few: Vec::new(), many: false }
    }
}

impl Changes {
    /// Anything may have changed.
    pub(crate) fn note_all(&mut self) {
        self.note_from(List::Distances, 0);
        self.note_from(List::Constraints, 0);
    }

    /// Anything may have changed in a list but for so many, from the first on.
    pub(crate) fn note_from(&mut self, list: List, same: usize) {
        self.many = true;
        let own = &mut self.same[list as usize];
        *own = same.min(*own);
    }

    /// Other compounds collide by their shape. Constraints are what they were.
    pub(crate) fn note_colliders(&mut self) {
        self.many = true;
    }

    pub(crate) fn note(&mut self, change: Change) {
        let (&Change::Added(list, at) | &Change::Removed(list, at, _)) = &change;
        let own = &mut self.same[list as usize];
        *own = at.min(*own);
        self.many |= self.few.len() == MOST;
        if !self.many {
            self.few.push(change);
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        !self.many && self.few.is_empty()
    }

    /// Whether there are only few of them.
    pub(crate) fn are_few(&self) -> bool {
        !self.many
    }

    /// How many of the distances and how many of the constraints, from the first on, are what they were.
    pub(crate) fn same(&self) -> [usize; 2] {
        self.same
    }

    /// Whether one of the few may have bound, or may bind, two particles of which something holds.
    pub(crate) fn any_between(&self, given: Given, holds: impl Fn(u32, u32) -> bool) -> bool {
        let between = |rows: &[u32]| rows.windows(2).any(|pair| holds(pair[0], pair[1]));
        // Each change behind it may have moved what was added by one.
        let around = |at: usize| at.saturating_sub(MOST)..=at + MOST;
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

    /// Takes out the keys of what was removed, and lets the others have their new numbers. Returns what was taken out, and what valid was added.
    pub(super) fn renumber(
        &self,
        keys: &mut Vec<Key>,
        given: &Given,
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
        added.retain(|&(list, number)| given.is_sound(list, number as usize));
        (removed, added)
    }
}

/// A constraint that was removed: its key, and what it bound.
pub(super) type Removed = (Key, Rows);

/// One that was added: where it is listed.
pub(super) type Added = (List, u32);

/// Which list the constraint of a key is in.
pub(super) fn list_of(key: &Key) -> List {
    match Fields::of(key.group).rank {
        RODS | DISTANCES => List::Distances,
        _ => List::Constraints,
    }
}

impl Given<'_> {
    /// What is in order among all but so many of each list, from the first on.
    pub(super) fn sound_from(&self, same: [usize; 2]) -> Vec<Added> {
        let [distances, constraints] = same;
        let each = (distances..self.distances.len()).map(|number| (List::Distances, number));
        let others = (constraints..self.constraints.len()).map(|n| (List::Constraints, n));
        let sound = each.chain(others).filter(|&(list, number)| self.is_sound(list, number));
        sound.map(|(list, number)| (list, number as u32)).collect()
    }

    /// Does something with the particles of a constraint.
    pub(super) fn on_rows<T>(&self, list: List, number: u32, act: impl FnOnce(&[u32]) -> T) -> T {
        match list {
            List::Distances => {
                let d = &self.distances[number as usize];
                act(&[d.a, d.b])
            }
            List::Constraints => act(&self.constraints[number as usize].rows),
        }
    }

    pub(super) fn is_sound(&self, list: List, number: usize) -> bool {
        match list {
            List::Distances => self.distances[number].fault(self.particles).is_none(),
            List::Constraints => self.constraints[number].fault(self.particles).is_none(),
        }
    }

    /// The particles of a constraint, and where its kind stands in a sweep.
    pub(super) fn rows_and_rank(&self, list: List, number: usize) -> (Rows, u32) {
        let rank = match list {
            List::Distances => rank_of(&self.distances[number]),
            List::Constraints => rank_of_kind(&self.constraints[number].kind),
        };
        (self.on_rows(list, number as u32, Rows::from_slice), rank)
    }
}
