//! Links: springs, constraints and surfaces name entities; the solver wants rows. Compiled when any of them changed; where few came or went, as when
//! cloth is torn, the solver's lists are mended.

mod entry;
mod kinds;
mod news;

pub use kinds::RegisterParticleConstraint;
pub(crate) use kinds::{Kinds, register_ours};

use bevy::prelude::*;

use super::changes::census;
use crate::components::{CreationOrder, DistanceConstraint, Spring, WindSurface};
use crate::messages::Refused;
use crate::world::{SinewWorld, Tables};
use entry::{Entry, Judge, Place, mend};
use news::Watch;

/// Whose links stand in the solver's lists, place by place.
#[derive(Default)]
pub(crate) struct Links {
    distances: Vec<Place>,
    constraints: Vec<Place>,
    springs: Vec<Place>,
    /// Whether all links there are do.
    sound: bool,
}

/// Notes whether distances, springs or surfaces came, went or changed; few distances are taken into account at once. No hook does: a body comes and
/// goes with tens of thousands of them.
pub(crate) fn notice_links(
    mut world: ResMut<SinewWorld>,
    distances: Query<(Entity, Ref<DistanceConstraint>)>,
    numbered: Query<(Entity, &CreationOrder, &DistanceConstraint)>,
    springs: Query<Ref<Spring>>,
    surfaces: Query<Ref<WindSurface>>,
    mut removed: RemovedComponents<DistanceConstraint>,
    mut watch: Local<Watch>,
    mut counts: Local<[usize; 2]>,
) {
    // Of what was removed Bevy tells for two frames, and a tick may be farther away. Who replaces it has changed, so their numbers say it all.
    let found = [census(&springs), census(&surfaces)];
    let now = found.map(|(count, _)| count);
    let went = core::mem::replace(&mut *counts, now) != now;
    watch.look(&distances, removed.read());
    let SinewWorld { simulation, tables } = &mut *world;
    tables.retied = watch.is_any();
    tables.stale |= went || found.iter().any(|&(_, changed)| changed);
    if !watch.is_any() || tables.stale {
        return;
    }
    tables.stale = !tables.links.sound || !watch.is_few();
    if !tables.stale {
        let came = watch.came.iter().filter_map(|&entity| numbered.get(entity).ok());
        let entries: Vec<_> = came.map(|one| entry(tables, one)).collect();
        let places = &mut tables.links.distances;
        tables.stale = !mend(simulation, places, entries, (kinds::DISTANCES, &watch));
    }
}

/// Looks at the registered constraints: whether any came, went or changed, and, if anything is to be compiled, what they all are among rows.
pub(crate) fn collect_laws(world: &mut World) {
    world.resource_scope(|world, mut kinds: Mut<Kinds>| {
        world.resource_scope(|world, mut sinew: Mut<SinewWorld>| {
            kinds.collect(world, &mut sinew);
        });
    });
}

/// Compiles all links afresh if particles or surfaces came, went or changed, or many links did.
///
/// A link that cannot act is left out, so that the others run bit for bit as if it were not there, and reported once. One that
/// waits for a particle that is set aside is not reported: the particle was.
pub(crate) fn compile_links(
    mut world: ResMut<SinewWorld>,
    mut kinds: ResMut<Kinds>,
    mut messages: MessageWriter<Refused>,
    distances: Query<(Entity, &CreationOrder, &DistanceConstraint)>,
    springs: Query<(Entity, &CreationOrder, &Spring)>,
    surfaces: Query<&WindSurface>,
) {
    let SinewWorld { simulation, tables } = &mut *world;
    if !tables.stale {
        return;
    }
    tables.stale = false;

    let before = core::mem::take(&mut tables.complaints);
    let mut links = core::mem::take(&mut tables.links);
    let mut judge = Judge::new(before, &mut messages);
    let entries = distances.iter().map(|one| entry(tables, one)).collect();
    judge.fill(simulation.distances_mut(), &mut links.distances, entries);
    let entries = springs.iter().map(|(entity, &order, spring)| {
        let place = Place { order, entity, kind: kinds::SPRINGS };
        Entry::new(tables, place, &[spring.a, spring.b], |rows| {
            Ok(sinew::Spring {
                a: rows[0],
                b: rows[1],
                rest: spring.rest,
                stiffness: spring.stiffness,
                damping: spring.damping,
            })
        })
    });
    judge.fill(&mut simulation.forces.springs, &mut links.springs, entries.collect());
    judge.fill(simulation.constraints_mut(), &mut links.constraints, kinds.take());
    links.sound = judge.passed_all();
    tables.complaints = judge.complaints();
    tables.links = links;

    // Triangles are ordered by their particles' rows, which follow creation; a torn corner just leaves its triangles out.
    let list = &mut simulation.forces.surfaces;
    list.clear();
    for surface in &surfaces {
        let rows = |corners: &[Entity; 3]| {
            let [a, b, c] = corners.map(|corner| tables.sound_row(corner));
            Some([a?, b?, c?])
        };
        list.extend(surface.triangles.iter().filter_map(rows));
    }
    list.sort_unstable();
}

/// A distance on its way to the solver.
fn entry(
    tables: &Tables,
    (entity, &order, distance): (Entity, &CreationOrder, &DistanceConstraint),
) -> Entry<sinew::Distance> {
    let place = Place { order, entity, kind: kinds::DISTANCES };
    Entry::new(tables, place, &[distance.a, distance.b], |rows| {
        Ok(sinew::Distance {
            a: rows[0],
            b: rows[1],
            rest: distance.rest,
            softness: distance.softness.into(),
            bound: distance.bound.into(),
        })
    })
}
