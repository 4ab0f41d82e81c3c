//! Contact filter: which pairs may touch, by the settings of each body, by layers, and by the constraints between bodies.
//! | two things | touch |
//! |---|---|
//! | of one body | if the body collides with itself |
//! | of two bodies | if both collide with other bodies, their layers match, and no constraint joins a particle of one with a particle of the other |
//! | a body of one particle and what it is tied to, directly or through others | never |
//! | two bodies whose pair is [ignored](crate::Simulation::ignored) | never |
//! | a body and a collider | if their layers match and the pair is not [ignored](crate::Simulation::ignored) |
//!
//! Bodies that a joint connects do not touch each other, as in most engines, because the anchors of a joint mostly lie inside both.

use super::impact::ContactParticipant;
use super::material::BodyContacts;
use crate::constraints::{Constraint, Distance};
use crate::islands::Islands;
use crate::particles::{NO_BODY, Particles};
use crate::tracked::Tracked;

/// Which pairs may touch in a step. Scratch, except `joined`, which is recomputed only when constraints or particles have changed.
#[derive(Clone, Debug, Default)]
pub(crate) struct ContactFilter {
    /// Contact settings of each body, in the order of [`Simulation::contacts`](crate::Simulation::contacts). Empty if no body collides.
    bodies: Vec<BodyContacts>,
    /// The [revision](Tracked::revision) of the list that `bodies` was copied from.
    revision: u64,
    /// How many particles each body has, saturating at 2.
    counts: Vec<u8>,
    /// The island of each row.
    islands: Vec<u32>,
    /// Pairs of bodies joined by a constraint, the lower index first; sorted.
    joined: Vec<[u32; 2]>,
    /// Pairs of bodies to be ignored by request of the game, in the same form, of this step and of the one before; then pairs of a body and a collider.
    ignored_bodies: Vec<[u32; 2]>,
    ignored_bodies_before: Vec<[u32; 2]>,
    ignored_colliders: Vec<[u32; 2]>,
    /// [Edits](Particles::edits) of the particles when `joined` was computed; `None` once constraints have changed since.
    joined_at: Option<u64>,
    /// How many updates found a change.
    changes: u64,
}

impl ContactFilter {
    /// A filter with the settings of the bodies alone: no constraints join them.
    #[cfg(test)]
    pub(crate) fn untied(contacts: &[BodyContacts]) -> Self {
        Self { bodies: contacts.to_vec(), ..Self::default() }
    }

    /// Makes the next [`update`](Self::update) recompute the joined bodies: constraints between bodies were added or removed.
    pub(crate) fn invalidate_joints(&mut self) {
        self.joined_at = None;
    }

    /// Takes the settings, ignored pairs, islands and constraints of a step.
    pub(crate) fn update(
        &mut self,
        particles: &Particles,
        contacts: &Tracked<Vec<BodyContacts>>,
        ignored: &[[ContactParticipant; 2]],
        islands: &Islands,
        (distances, constraints): (&[Distance], &[Constraint]),
    ) {
        let mut changed = copy_if_changed(&mut self.bodies, contacts);
        self.revision = contacts.revision();
        changed |= copy_if_changed(&mut self.islands, &islands.of);
        if self.joined_at != Some(particles.edits()) || self.counts.len() != self.bodies.len() {
            changed = true;
            self.joined_at = Some(particles.edits());
            self.count_particles(particles);
            self.find_joints(particles, distances, constraints);
        }
        changed |= self.take_ignored(ignored);
        self.changes += u64::from(changed);
    }

    /// A counter that increases whenever the set of pairs that may touch may have changed.
    pub(crate) fn changes(&self) -> u64 {
        self.changes
    }

    /// Contact settings of a body; the default for one that is not listed, and for [`NO_BODY`].
    #[inline(always)]
    pub(crate) fn body(&self, body: u32) -> &BodyContacts {
        const DEFAULT: &BodyContacts = &BodyContacts::DEFAULT;
        self.bodies.get(body as usize).unwrap_or(DEFAULT)
    }

    /// The revision of the contact settings: it differs when the settings of a body, or the list of bodies, have changed.
    pub(crate) fn revision(&self) -> u64 {
        self.revision
    }

    /// The contact settings of all bodies.
    pub(crate) fn bodies(&self) -> &[BodyContacts] {
        &self.bodies
    }

    /// Whether two rows, each given as (body, row), may touch. They may belong to one body or to two.
    #[inline(always)]
    pub(crate) fn rows_may_touch(&self, a: (u32, u32), b: (u32, u32)) -> bool {
        let (body, other_body) = (a.0, b.0);
        if body == other_body && body != NO_BODY {
            return self.body(body).with_itself;
        }
        self.body(body).collides_with(self.body(other_body)) && !self.are_tied(a, b)
    }

    /// Whether constraints between two rows of different bodies keep them from touching.
    #[inline(always)]
    fn are_tied(&self, (body, row): (u32, u32), (other_body, other_row): (u32, u32)) -> bool {
        if self.is_ignored(body, other_body) {
            return true;
        }
        let single = |body: u32| self.counts.get(body as usize) == Some(&1);
        if single(body) || single(other_body) {
            let island = |row: u32| self.islands.get(row as usize);
            return island(row) == island(other_row);
        }
        is_among(&self.joined, body, other_body)
    }

    /// Whether a body may touch a collider, apart from layers.
    #[inline]
    pub(crate) fn may_touch_collider(&self, body: u32, collider: u32) -> bool {
        self.ignored_colliders.is_empty()
            || self.ignored_colliders.binary_search(&[body, collider]).is_err()
    }

    /// Whether a collider is ignored by some body, whatever its layers.
    pub(crate) fn ignores_collider(&self, collider: u32) -> bool {
        self.ignored_colliders.iter().any(|pair| pair[1] == collider)
    }

    /// Whether the game ignores a pair of bodies.
    #[inline(always)]
    fn is_ignored(&self, a: u32, b: u32) -> bool {
        is_among(&self.ignored_bodies, a, b)
    }

    /// Takes the ignored pairs. Returns whether those of two bodies differ from the ones before.
    fn take_ignored(&mut self, ignored: &[[ContactParticipant; 2]]) -> bool {
        let Self { ignored_bodies, ignored_bodies_before, ignored_colliders, .. } = self;
        core::mem::swap(ignored_bodies, ignored_bodies_before);
        ignored_bodies.clear();
        ignored_colliders.clear();
        for &pair in ignored {
            match pair {
                [ContactParticipant::Body(a), ContactParticipant::Body(b)] => {
                    ignored_bodies.push([a.min(b), a.max(b)]);
                }
                [ContactParticipant::Body(body), ContactParticipant::Collider(collider)]
                | [ContactParticipant::Collider(collider), ContactParticipant::Body(body)] => {
                    ignored_colliders.push([body, collider]);
                }
                _ => {}
            }
        }
        ignored_bodies.sort_unstable();
        ignored_colliders.sort_unstable();
        ignored_bodies != ignored_bodies_before
    }

    fn count_particles(&mut self, particles: &Particles) {
        self.counts.clear();
        self.counts.resize(self.bodies.len(), 0);
        for &body in &particles.body {
            if let Some(count) = self.counts.get_mut(body as usize) {
                *count = (*count + 1).min(2);
            }
        }
    }

    fn find_joints(
        &mut self,
        particles: &Particles,
        distances: &[Distance],
        constraints: &[Constraint],
    ) {
        let joined = &mut self.joined;
        joined.clear();
        let body = |row: u32| particles.body.get(row as usize).copied().unwrap_or(NO_BODY);
        let mut join = |a: u32, b: u32| {
            if a != b && a != NO_BODY && b != NO_BODY {
                joined.push([a.min(b), a.max(b)]);
            }
        };
        for distance in distances {
            join(body(distance.a), body(distance.b));
        }
        for constraint in constraints {
            for (i, &row) in constraint.rows.iter().enumerate().skip(1) {
                // A constraint joins every two of its rows; most constraints lie within one body.
                let own = body(row);
                if own != body(constraint.rows[i - 1]) {
                    constraint.rows.iter().for_each(|&other| join(own, body(other)));
                }
            }
        }
        joined.sort_unstable();
        joined.dedup();
    }
}

/// Whether a sorted list has a pair, in either order.
#[inline]
fn is_among(list: &[[u32; 2]], a: u32, b: u32) -> bool {
    !list.is_empty() && list.binary_search(&[a.min(b), a.max(b)]).is_ok()
}

/// Copies a list and returns whether it differed.
fn copy_if_changed<T: Clone + PartialEq>(to: &mut Vec<T>, from: &[T]) -> bool {
    let differs = to[..] != *from;
    if differs {
        to.clear();
        to.extend_from_slice(from);
    }
    differs
}
