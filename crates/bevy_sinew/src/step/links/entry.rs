//! One link on its way from a component to the solver's list: its particles resolved, checked, put in order, and reported if it cannot act.

use bevy::prelude::*;
use sinew::constraints::Rows;
use sinew::{ConstraintFault, DistanceFault, Simulation, SpringFault};

use super::change_detection::ChangeDetector;
use crate::messages::{Refusal, Refused, ReportedErrors, refuse};
use crate::world::{Place, Tables};

/// Something that the solver has a list of, among rows.
pub(super) trait Link: Sized {
    /// What to say when one of its particles is gone.
    const MISSING: Refusal;

    /// Why it cannot act among so many particles, or `None` if it can.
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

/// A link that can come and go by itself: the solver's plan keeps up with it.
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

/// A link with its place, and what became of it.
pub(super) struct Entry<L> {
    place: Place,
    outcome: Outcome<L>,
}

enum Outcome<L> {
    Sound(L),
    Faulty(Refusal),
    /// One of its particles is set aside.
    Waits,
}

impl<L: Link> Entry<L> {
    /// Resolves the particles into rows; if all are there and sound, makes the link of them and checks it.
    pub(super) fn new(
        tables: &Tables,
        place: Place,
        particles: &[Entity],
        link: impl FnOnce(Rows) -> Result<L, Refusal>,
    ) -> Self {
        let outcome = if particles.iter().any(|&particle| tables.is_set_aside(particle)) {
            Outcome::Waits
        } else {
            let rows = particles.iter().map(|&particle| tables.sound_row(particle)).collect();
            let link = Option::<Rows>::ok_or(rows, L::MISSING).and_then(link);
            match link {
                Ok(link) => match link.refusal(tables.entities.len()) {
                    None => Outcome::Sound(link),
                    Some(reason) => Outcome::Faulty(reason),
                },
                Err(reason) => Outcome::Faulty(reason),
            }
        };
        Self { place, outcome }
    }
}

/// Brings a list of the solver, in which links stand in these places, up to date with what came, changed or went of one kind. Whether that adds up to
/// what there is: if it does not, or one of the new ones cannot act, the lists have to be filled afresh.
pub(super) fn update_incrementally<L: Incremental>(
    simulation: &mut Simulation,
    places: &mut Vec<Place>,
    entries: impl IntoIterator<Item = Entry<L>>,
    (kind, detector): (usize, &ChangeDetector),
) -> bool {
    let mut grown = 0;
    for &entity in &detector.gone {
        let own = |place: &Place| place.entity == entity && place.kind == kind;
        if let Some(at) = places.iter().position(own) {
            places.remove(at);
            L::remove(simulation, at);
            grown -= 1;
        }
    }
    for Entry { place, outcome } in entries {
        let Outcome::Sound(link) = outcome else { return false };
        let at = match places.binary_search(&place) {
            Ok(at) => {
                L::remove(simulation, at);
                at
            }
            Err(at) => {
                places.insert(at, place);
                grown += 1;
                at
            }
        };
        link.insert(simulation, at);
    }
    grown == detector.grown
}

/// How many links of a list stand before the first of which a particle is not among the first `same_rows`; `None` if no more stay than have moved, or `changed`.
pub(super) fn unmoved<L: Incremental>(
    list: &[L],
    same_rows: usize,
    changed: usize,
) -> Option<usize> {
    let moved = |link: &L| link.rows().any(|row| row as usize >= same_rows);
    let unmoved = list.iter().position(moved).unwrap_or(list.len());
    (list.len() - unmoved + changed < unmoved).then_some(unmoved)
}

/// What a list of the solver holds from the first link on that is not what it was, its number and the links from there on; and their places. `None` if one of them
/// cannot act, or it does not add up to what there is: then the list has to be filled afresh.
///
/// A link is what it was if it is among the first [`unmoved`] ones, not among those that were added or changed, nor said to have gone, and none before it
/// is. `again` makes the entries of what stands in some places and is still there, and there are `count` in all.
pub(super) fn refill<L>(
    places: &mut Vec<Place>,
    (unmoved, count): (usize, usize),
    (mut entries, gone): (Vec<Entry<L>>, &[Entity]),
    again: impl Fn(&[Place], &mut Vec<Entry<L>>),
) -> Option<(usize, Vec<L>)> {
    let first = entries.iter().map(|entry| entry.place).min();
    let before = |first: Place| places.partition_point(|&own| own < first);
    let mut kept = first.map_or(unmoved, |first| unmoved.min(before(first)));
    let mut gone = gone.to_vec();
    gone.sort_unstable();
    let went = |place: &&Place| gone.binary_search(&place.entity).is_ok();
    // Mostly they went with their particles, and nobody else has to be asked.
    if places[kept..].iter().filter(went).count() < gone.len() {
        kept = places[..kept].iter().position(|place| went(&place)).unwrap_or(kept);
    }
    again(&places[kept..], &mut entries);
    entries.sort_unstable_by_key(|entry| entry.place);
    entries.dedup_by_key(|entry| entry.place);
    if kept + entries.len() != count {
        return None;
    }
    places.truncate(kept);
    let links = entries.into_iter().map(|Entry { place, outcome }| {
        places.push(place);
        if let Outcome::Sound(link) = outcome { Some(link) } else { None }
    });
    Some((kept, links.collect::<Option<_>>()?))
}

/// Lets the sound ones pass, and reports the others, once for each time that one broke.
pub(super) struct LinkValidator<'a, 'w> {
    before: ReportedErrors,
    now: ReportedErrors,
    /// Whether all passed so far.
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

    /// Fills a list of the solver with the sound links, in their order, whatever the order of the entries, and notes their places.
    pub(super) fn fill<L>(
        &mut self,
        list: &mut Vec<L>,
        places: &mut Vec<Place>,
        mut entries: Vec<Entry<L>>,
    ) {
        entries.sort_unstable_by_key(|entry| entry.place);
        list.clear();
        places.clear();
        for Entry { place, outcome } in entries {
            let Place { entity, kind, .. } = place;
            self.all &= matches!(outcome, Outcome::Sound(_));
            match outcome {
                Outcome::Sound(link) => {
                    list.push(link);
                    places.push(place);
                }
                Outcome::Faulty(reason) => {
                    if self.before.get(&(entity, kind)) != Some(&reason) {
                        refuse(self.messages, entity, reason.clone());
                    }
                    self.now.insert((entity, kind), reason);
                }
                // What was wrong with it before is not known to be mended.
                Outcome::Waits => {
                    let old = self.before.remove(&(entity, kind));
                    self.now.extend(old.map(|reason| ((entity, kind), reason)));
                }
            }
        }
    }

    /// Whether all links could pass.
    pub(super) fn passed_all(&self) -> bool {
        self.all
    }

    /// The errors that stand. Those about links that are gone, or that are in order now, are forgotten: they may be raised again.
    pub(super) fn reported_errors(self) -> ReportedErrors {
        self.now
    }
}
