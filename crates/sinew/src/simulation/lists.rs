//! The lists of a simulation: distances, constraints, compounds and body colliders, with their accessors. Every change is noted for the next update of the
//! plan.

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

    /// The distances, mutable. The plan is compiled afresh at the next step; a faulty distance is left out of it.
    ///
    /// For one or a few changes use [`insert_distance`](Self::insert_distance), [`remove_distance`](Self::remove_distance) or
    /// [`replace_distance`](Self::replace_distance): the plan is then updated incrementally, in a fraction of the time. To add bodies use
    /// [`extend_distances`](Self::extend_distances), and to replace a part of the list [`replace_distances_from`](Self::replace_distances_from).
    pub fn distances_mut(&mut self) -> &mut Vec<Distance> {
        self.scratch.changes.note_all();
        &mut self.distances
    }

    /// Appends distances. Bodies that the new ones do not connect to anything stay compiled.
    pub fn extend_distances(&mut self, distances: impl IntoIterator<Item = Distance>) {
        self.scratch.changes.note_from(List::Distances, self.distances.len());
        self.distances.extend(distances);
    }

    /// Replaces all distances from index `from` on; from 0 the whole list. In the order of their first particles, bodies before the first one with a changed
    /// distance stay compiled.
    ///
    /// # Panics
    /// If there are fewer than `from` distances.
    pub fn replace_distances_from(&mut self, from: usize, distances: Vec<Distance>) {
        if let Some(same) = replace_from(&mut self.distances, from, distances) {
            self.scratch.changes.note_from(List::Distances, same);
        }
    }

    /// Inserts a distance before index `at`. It acts from the next step on.
    ///
    /// # Panics
    /// If there are fewer than `at` distances.
    pub fn insert_distance(&mut self, at: usize, distance: Distance) {
        self.distances.insert(at, distance);
        self.scratch.changes.note(Change::Added(List::Distances, at));
    }

    /// Removes the distance at index `at`, as when cloth tears, and returns it.
    ///
    /// # Panics
    /// If there is no such distance.
    pub fn remove_distance(&mut self, at: usize) -> Distance {
        let gone = self.distances.remove(at);
        let rows = smallvec![gone.a, gone.b];
        self.scratch.changes.note(Change::Removed(List::Distances, at, rows));
        gone
    }

    /// Replaces the distance at index `at`, and returns the old one.
    ///
    /// # Panics
    /// If there is no such distance.
    pub fn replace_distance(&mut self, at: usize, distance: Distance) -> Distance {
        let gone = self.remove_distance(at);
        self.insert_distance(at, distance);
        gone
    }

    /// The constraints other than distances, in the order in which they were added.
    pub fn constraints(&self) -> &[Constraint] {
        &self.constraints
    }

    /// The constraints other than distances, mutable. The plan is compiled afresh at the next step; a faulty constraint is left out of it. For one or a few
    /// changes use [`insert_constraint`](Self::insert_constraint), [`remove_constraint`](Self::remove_constraint) or
    /// [`replace_constraint`](Self::replace_constraint).
    pub fn constraints_mut(&mut self) -> &mut Vec<Constraint> {
        self.scratch.changes.note_all();
        &mut self.constraints
    }

    /// Appends constraints, as [`extend_distances`](Self::extend_distances) does.
    pub fn extend_constraints(&mut self, constraints: impl IntoIterator<Item = Constraint>) {
        self.scratch.changes.note_from(List::Constraints, self.constraints.len());
        self.constraints.extend(constraints);
    }

    /// Replaces all constraints from index `from` on, as [`replace_distances_from`](Self::replace_distances_from) does.
    ///
    /// # Panics
    /// If there are fewer than `from` constraints.
    pub fn replace_constraints_from(&mut self, from: usize, constraints: Vec<Constraint>) {
        if let Some(same) = replace_from(&mut self.constraints, from, constraints) {
            self.scratch.changes.note_from(List::Constraints, same);
        }
    }

    /// Inserts a constraint before index `at`, as [`insert_distance`](Self::insert_distance) does.
    ///
    /// # Panics
    /// If there are fewer than `at` constraints.
    pub fn insert_constraint(&mut self, at: usize, constraint: Constraint) {
        self.constraints.insert(at, constraint);
        self.scratch.changes.note(Change::Added(List::Constraints, at));
    }

    /// Removes the constraint at index `at`, and returns it.
    ///
    /// # Panics
    /// If there is no such constraint.
    pub fn remove_constraint(&mut self, at: usize) -> Constraint {
        let gone = self.constraints.remove(at);
        let rows = gone.rows.clone();
        self.scratch.changes.note(Change::Removed(List::Constraints, at, rows));
        gone
    }

    /// Replaces the constraint at index `at`, and returns the old one.
    ///
    /// # Panics
    /// If there is no such constraint.
    pub fn replace_constraint(&mut self, at: usize, constraint: Constraint) -> Constraint {
        let gone = self.remove_constraint(at);
        self.insert_constraint(at, constraint);
        gone
    }

    /// The compounds that move as explicit rigid bodies.
    pub fn compounds(&self) -> &[Compound] {
        &self.compounds
    }

    /// The compounds that move as explicit rigid bodies, mutable. Adding or removing one swaps the representation of its particles without a jump. Distances
    /// and constraints whose particles all belong to one compound have no effect meanwhile.
    pub fn compounds_mut(&mut self) -> &mut Vec<Compound> {
        self.scratch.changes.note_all();
        &mut self.compounds
    }

    /// The body colliders: sets of particles that collide by a shape.
    pub fn body_colliders(&self) -> &[BodyCollider] {
        &self.body_colliders
    }

    /// The body colliders, mutable. Their particles do not collide one by one.
    pub fn body_colliders_mut(&mut self) -> &mut Vec<BodyCollider> {
        self.scratch.changes.note_colliders();
        &mut self.body_colliders
    }
}

/// Replaces all items from index `from` on. Returns the index of the first item that differs, or `None` if the list is what it was.
fn replace_from<T: PartialEq>(list: &mut Vec<T>, from: usize, others: Vec<T>) -> Option<usize> {
    let both = list[from..].iter().zip(&others);
    let same = from + both.take_while(|(one, other)| one == other).count();
    let all = list.len().max(from + others.len());
    list.truncate(from);
    list.extend(others);
    (same < all).then_some(same)
}
