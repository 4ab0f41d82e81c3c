//! A link (a distance, a spring or a constraint) on its way from a component to the solver's list: its particles are resolved, it is validated, sorted, and
//! reported if it is invalid.

use bevy::prelude::*;
use sinew::constraints::Rows;
use sinew::{ConstraintFault, DistanceFault, Simulation, SpringFault};

use super::change_detection::ChangeDetector;
use crate::messages::{Refusal, Refused, ReportedErrors, refuse};
use crate::world::{LinkKey, Tables};

/// An element of one of the solver's lists, which refers to rows.
pub(super) trait Link: Sized {
    /// The error if one of its particles is gone.
    const MISSING: Refusal;

    /// Its error, for this number of particles, or `None` if it is valid.
    fn refusal(&self, particles: usize) -> Option<Refusal>;
}

impl Link for sinew::Distance {
    const MISSING: Refusal = Refusal::Distance(DistanceFault::MissingParticle);

    fn refusal(&self, particles: usize) -> Option<Refusal> {
        self.fault(particles).map(Refusal::Distance)
    }
}

impl Link for sinew::Spring {
    const MISSING: Refusal = Refusal::Spring(SpringFault::MissingParticle);

    fn refusal(&self, particles: usize) -> Option<Refusal> {
        self.fault(particles).map(Refusal::Spring)
    }
}

impl Link for sinew::Constraint {
    const MISSING: Refusal = Refusal::Constraint(ConstraintFault::MissingParticle);

    fn refusal(&self, particles: usize) -> Option<Refusal> {
        self.fault(particles).map(Refusal::Constraint)
    }
}

/// A link that can be inserted and removed individually: the solver's plan is updated incrementally.
pub(super) trait Incremental: Link {
    fn insert(self, simulation: &mut Simulation, at: usize);
    fn remove(simulation: &mut Simulation, at: usize);

    /// The rows of its particles.
    fn rows(&self) -> impl Iterator<Item = u32>;
}

impl Incremental for sinew::Distance {
    fn insert(self, simulation: &mut Simulation, at: usize) {
        simulation.insert_distance(at, self);
    }

    fn remove(simulation: &mut Simulation, at: usize) {
        simulation.remove_distance(at);
    }

    fn rows(&self) -> impl Iterator<Item = u32> {
        [self.a, self.b].into_iter()
    }
}

impl Incremental for sinew::Constraint {
    fn insert(self, simulation: &mut Simulation, at: usize) {
        simulation.insert_constraint(at, self);
    }

    fn remove(simulation: &mut Simulation, at: usize) {
        simulation.remove_constraint(at);
    }

    fn rows(&self) -> impl Iterator<Item = u32> {
        self.rows.iter().copied()
    }
}

/// A link with its key, and the result of its validation.
pub(super) struct LinkEntry<L> {
    key: LinkKey,
    outcome: LinkOutcome<L>,
}

enum LinkOutcome<L> {
    Valid(L),
    Invalid(Refusal),
    /// One of its particles is set aside, or disabled.
    Waiting,
}

impl<L: Link> LinkEntry<L> {
    /// Resolves the particles to rows; if all exist and none is set aside, makes the link and validates it.
    pub(super) fn new(
        tables: &Tables,
        key: LinkKey,
        particles: &[Entity],
        link: impl FnOnce(Rows) -> Result<L, Refusal>,
    ) -> Self {
        let outcome = if particles.iter().any(|&particle| tables.is_absent(particle)) {
            LinkOutcome::Waiting
        } else {
            let rows = particles.iter().map(|&particle| tables.valid_row(particle)).collect();
            let link = Option::<Rows>::ok_or(rows, L::MISSING).and_then(link);
            match link {
                Ok(link) => match link.refusal(tables.entities.len()) {
                    None => LinkOutcome::Valid(link),
                    Some(reason) => LinkOutcome::Invalid(reason),
                },
                Err(reason) => LinkOutcome::Invalid(reason),
            }
        };
        Self { key, outcome }
    }
}

/// Updates one of the solver's lists, whose links have these keys, incrementally by what was added, changed or removed of one kind. Returns false if the
/// counts do not match, or a new link is invalid: the lists must then be filled again.
pub(super) fn update_incrementally<L: Incremental>(
    simulation: &mut Simulation,
    keys: &mut Vec<LinkKey>,
    entries: impl IntoIterator<Item = LinkEntry<L>>,
    (kind, detector): (usize, &ChangeDetector),
) -> bool {
    let mut growth = 0;
    for &entity in &detector.gone {
        let own = |key: &LinkKey| key.entity == entity && key.kind == kind;
        if let Some(at) = keys.iter().position(own) {
            keys.remove(at);
            L::remove(simulation, at);
            growth -= 1;
        }
    }
    for LinkEntry { key, outcome } in entries {
        let LinkOutcome::Valid(link) = outcome else { return false };
        let at = match keys.binary_search(&key) {
            Ok(at) => {
                L::remove(simulation, at);
                at
            }
            Err(at) => {
                keys.insert(at, key);
                growth += 1;
                at
            }
        };
        link.insert(simulation, at);
    }
    growth == detector.grown
}

/// The number of leading links whose particles are all among the first `same_rows` rows; `None` if no more links stay than have moved or are `changed`, so that
/// filling the list again is as fast.
pub(super) fn unchanged_prefix<L: Incremental>(
    list: &[L],
    same_rows: usize,
    changed: usize,
) -> Option<usize> {
    let moved = |link: &L| link.rows().any(|row| row as usize >= same_rows);
    let unchanged = list.iter().position(moved).unwrap_or(list.len());
    (list.len() - unchanged + changed < unchanged).then_some(unchanged)
}

/// The contents of one of the solver's lists from the first link on that differs: its index, and the links from there on; updates the keys. `None` if one of
/// the links is invalid, or the counts do not match: the list must then be filled again.
///
/// A link is the same as before if it is among the leading [`unchanged_prefix`] ones, was neither added nor changed nor removed, and all links before it are
/// the same. `entries_of` makes the entries for links that still exist, from their keys; `count` is the total number.
pub(super) fn recompile_tail<L>(
    keys: &mut Vec<LinkKey>,
    (unchanged, count): (usize, usize),
    (mut entries, gone): (Vec<LinkEntry<L>>, &[Entity]),
    entries_of: impl Fn(&[LinkKey], &mut Vec<LinkEntry<L>>),
) -> Option<(usize, Vec<L>)> {
    let first = entries.iter().map(|entry| entry.key).min();
    let before = |first: LinkKey| keys.partition_point(|&own| own < first);
    let mut kept = first.map_or(unchanged, |first| unchanged.min(before(first)));
    let mut gone = gone.to_vec();
    gone.sort_unstable();
    let was_removed = |key: &&LinkKey| gone.binary_search(&key.entity).is_ok();
    // Usually they are removed together with their particles, so that no earlier link needs to be checked.
    if keys[kept..].iter().filter(was_removed).count() < gone.len() {
        kept = keys[..kept].iter().position(|key| was_removed(&key)).unwrap_or(kept);
    }
    entries_of(&keys[kept..], &mut entries);
    entries.sort_unstable_by_key(|entry| entry.key);
    entries.dedup_by_key(|entry| entry.key);
    if kept + entries.len() != count {
        return None;
    }
    keys.truncate(kept);
    let links = entries.into_iter().map(|LinkEntry { key, outcome }| {
        keys.push(key);
        if let LinkOutcome::Valid(link) = outcome { Some(link) } else { None }
    });
    Some((kept, links.collect::<Option<_>>()?))
}

/// Passes valid links, and reports the others, each once until it is corrected.
pub(super) struct LinkValidator<'a, 'w> {
    before: ReportedErrors,
    now: ReportedErrors,
    /// Whether all links so far were valid.
    all: bool,
    messages: &'a mut MessageWriter<'w, Refused>,
}

impl<'a, 'w> LinkValidator<'a, 'w> {
    pub(super) fn new(
        before: ReportedErrors,
        messages: &'a mut MessageWriter<'w, Refused>,
    ) -> Self {
        Self { before, now: ReportedErrors::new(), all: true, messages }
    }

    /// Fills one of the solver's lists with the valid links, sorted by key, and stores their keys.
    pub(super) fn fill<L>(
        &mut self,
        list: &mut Vec<L>,
        keys: &mut Vec<LinkKey>,
        mut entries: Vec<LinkEntry<L>>,
    ) {
        entries.sort_unstable_by_key(|entry| entry.key);
        list.clear();
        keys.clear();
        for LinkEntry { key, outcome } in entries {
            let LinkKey { entity, kind, .. } = key;
            self.all &= matches!(outcome, LinkOutcome::Valid(_));
            match outcome {
                LinkOutcome::Valid(link) => {
                    list.push(link);
                    keys.push(key);
                }
                LinkOutcome::Invalid(reason) => {
                    if self.before.get(&(entity, kind)) != Some(&reason) {
                        refuse(self.messages, entity, reason.clone());
                    }
                    self.now.insert((entity, kind), reason);
                }
                // An earlier error may persist, so it stays recorded.
                LinkOutcome::Waiting => {
                    let old = self.before.remove(&(entity, kind));
                    self.now.extend(old.map(|reason| ((entity, kind), reason)));
                }
            }
        }
    }

    /// Whether all links were valid.
    pub(super) fn passed_all(&self) -> bool {
        self.all
    }

    /// The errors that persist. Errors of links that are gone, or are valid now, are dropped, so they are reported again if they recur.
    pub(super) fn reported_errors(self) -> ReportedErrors {
        self.now
    }
}
