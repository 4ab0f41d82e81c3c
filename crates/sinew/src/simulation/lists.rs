//! The lists of a simulation: what is bound, what is rigid and what collides, to be read and changed. Whatever changes one is noted for the plan.

use smallvec::smallvec;

use super::Simulation;
use crate::collide::BodyCollider;
use crate::constraints::{Constraint, Distance};
use crate::rigid::Compound;
use crate::solve::{Change, List};

impl Simulation {
    /// The distances, in the order in which they were added.
    pub fn distances(&self) -> &[Distance] {
        &self.distances
    }

    /// The distances, to add to, change or remove from. The plan is compiled afresh at the next step; a faulty distance is left out of it.
    ///
    /// For one or a few there are [`insert_distance`](Self::insert_distance), [`remove_distance`](Self::remove_distance) and
    /// [`replace_distance`](Self::replace_distance): a plan that knows what changed is updated incrementally, which takes a fraction of the time. For
    /// bodies that are added there is [`extend_distances`](Self::extend_distances), and for another list
    /// [`replace_distances_from`](Self::replace_distances_from).
    pub fn distances_mut(&mut self) -> &mut Vec<Distance> {
        self.scratch.changes.note_all();
        &mut self.distances
    }

    /// Puts distances behind those that there are. Bodies that they do not tie to something stay compiled.
    pub fn extend_distances(&mut self, distances: impl IntoIterator<Item = Distance>) {
        self.scratch.changes.note_from(List::Distances, self.distances.len());
        self.distances.extend(distances);
    }

    /// Puts other distances in the place of those from number `from` on; of all that there are, from 0 on. Bodies stay compiled before the first of which a
    /// distance has changed, in the order of their first particles.
    ///
    /// # Panics
    /// If there are fewer than `from` distances.
    pub fn replace_distances_from(&mut self, from: usize, distances: Vec<Distance>) {
        if let Some(same) = replace_from(&mut self.distances, from, distances) {
            self.scratch.changes.note_from(List::Distances, same);
        }
    }

    /// Puts a distance into the list, before the one that has been number `at`. It acts from the next step on.
    ///
    /// # Panics
    /// If there are fewer than `at` distances.
    pub fn insert_distance(&mut self, at: usize, distance: Distance) {
        self.distances.insert(at, distance);
        self.scratch.changes.note(Change::Added(List::Distances, at));
    }

    /// Takes distance number `at` out of the list: a tear.
    ///
    /// # Panics
    /// If there is none.
    pub fn remove_distance(&mut self, at: usize) -> Distance {
        let gone = self.distances.remove(at);
        let rows = smallvec![gone.a, gone.b];
        self.scratch.changes.note(Change::Removed(List::Distances, at, rows));
        gone
    }

    /// Puts a distance in the place of number `at`, and returns that one.
    ///
    /// # Panics
    /// If there is none.
    pub fn replace_distance(&mut self, at: usize, distance: Distance) -> Distance {
        let gone = self.remove_distance(at);
        self.insert_distance(at, distance);
        gone
    }

    /// The constraints other than distances, in the order in which they were added.
    pub fn constraints(&self) -> &[Constraint] {
        &self.constraints
    }

    /// The constraints other than distances, to add to, change or remove from. The plan is compiled afresh at the next step; a faulty constraint is
    /// left out of it. For one or a few there are [`insert_constraint`](Self::insert_constraint) and its like.
    pub fn constraints_mut(&mut self) -> &mut Vec<Constraint> {
        self.scratch.changes.note_all();
        &mut self.constraints
    }

    /// Puts constraints behind those that there are, as [`extend_distances`](Self::extend_distances) does.
    pub fn extend_constraints(&mut self, constraints: impl IntoIterator<Item = Constraint>) {
        self.scratch.changes.note_from(List::Constraints, self.constraints.len());
        self.constraints.extend(constraints);
    }

    /// Puts other constraints in the place of those from number `from` on, as [`replace_distances_from`](Self::replace_distances_from) does.
    ///
    /// # Panics
    /// If there are fewer than `from` constraints.
    pub fn replace_constraints_from(&mut self, from: usize, constraints: Vec<Constraint>) {
        if let Some(same) = replace_from(&mut self.constraints, from, constraints) {
            self.scratch.changes.note_from(List::Constraints, same);
        }
    }

    /// Puts a constraint into the list, as [`insert_distance`](Self::insert_distance) does.
    ///
    /// # Panics
    /// If there are fewer than `at` constraints.
    pub fn insert_constraint(&mut self, at: usize, constraint: Constraint) {
        self.constraints.insert(at, constraint);
        self.scratch.changes.note(Change::Added(List::Constraints, at));
    }

    /// Takes constraint number `at` out of the list.
    ///
    /// # Panics
    /// If there is none.
    pub fn remove_constraint(&mut self, at: usize) -> Constraint {
        let gone = self.constraints.remove(at);
        let rows = gone.rows.clone();
        self.scratch.changes.note(Change::Removed(List::Constraints, at, rows));
        gone
    }

    /// Puts a constraint in the place of number `at`, and returns that one.
    ///
    /// # Panics
    /// If there is none.
    pub fn replace_constraint(&mut self, at: usize, constraint: Constraint) -> Constraint {
        let gone = self.remove_constraint(at);
        self.insert_constraint(at, constraint);
        gone
    }

    /// The compounds that move as explicit rigid bodies.
    pub fn compounds(&self) -> &[Compound] {
        &self.compounds
    }

    /// The compounds that move as explicit rigid bodies, to add to, change or remove from: that swaps their representation, and nothing jumps.
    /// Distances and constraints among the particles of one compound alone rest meanwhile.
    pub fn compounds_mut(&mut self) -> &mut Vec<Compound> {
        self.scratch.changes.note_all();
        &mut self.compounds
    }

    /// The compounds that collide by their shape.
    pub fn body_colliders(&self) -> &[BodyCollider] {
        &self.body_colliders
    }

    /// The compounds that collide by their shape, to add to, change or remove from. Their particles then touch nothing by themselves.
    pub fn body_colliders_mut(&mut self) -> &mut Vec<BodyCollider> {
        self.scratch.changes.note_colliders();
        &mut self.body_colliders
    }
}

/// Puts others in the place of all from number `from` on. How many are what they were, if not all.
fn replace_from<T: PartialEq>(list: &mut Vec<T>, from: usize, others: Vec<T>) -> Option<usize> {
    let both = list[from..].iter().zip(&others);
    let same = from + both.take_while(|(one, other)| one == other).count();
    let all = list.len().max(from + others.len());
    list.truncate(from);
    list.extend(others);
    (same < all).then_some(same)
}
