//! One link on its way from a component to the solver's list: its particles resolved, checked, put in order, and reported if it cannot act.

use bevy::prelude::*;
use sinew::constraints::Rows;
use sinew::{DistanceFault, LawFault, SpringFault};

use crate::components::CreationOrder;
use crate::messages::{Complaints, Refusal, Refused, refuse};
use crate::world::Tables;

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
    const MISSING: Refusal = Refusal::Constraint(LawFault::MissingParticle);

    fn refusal(&self, particles: usize) -> Option<Refusal> {
        self.fault(particles).map(Refusal::Constraint)
    }
}

/// Whose link it is, and where it stands in its list: by creation, and for several on one entity by their kind.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Place {
    pub(super) order: CreationOrder,
    pub(super) entity: Entity,
    pub(super) kind: usize,
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

/// Lets the sound ones pass, and complains about the others, once for each time that one broke.
pub(super) struct Judge<'a, 'w> {
    before: Complaints,
    now: Complaints,
    messages: &'a mut MessageWriter<'w, Refused>,
}

impl<'a, 'w> Judge<'a, 'w> {
    pub(super) fn new(before: Complaints, messages: &'a mut MessageWriter<'w, Refused>) -> Self {
        Self { before, now: Complaints::new(), messages }
    }

    /// Fills a list of the solver with the sound links, in their order, whatever the order of the entries.
    pub(super) fn fill<L>(&mut self, list: &mut Vec<L>, mut entries: Vec<Entry<L>>) {
        entries.sort_unstable_by_key(|entry| entry.place);
        list.clear();
        for Entry { place: Place { entity, kind, .. }, outcome } in entries {
            match outcome {
                Outcome::Sound(link) => list.push(link),
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

    /// The complaints that stand. Those about links that are gone, or that are in order now, are forgotten: they may be raised again.
    pub(super) fn complaints(self) -> Complaints {
        self.now
    }
}
