//! Links: springs, constraints and surfaces refer to entities, while the solver uses rows. They are compiled when any of them changes; if few were added or
//! removed, as when cloth is torn, the solver's lists are updated incrementally.

mod change_detection;
mod entry;
mod kinds;

pub use kinds::RegisterParticleConstraint;
pub(crate) use kinds::{Kinds, register_ours};

use bevy::ecs::lifecycle::RemovedComponentMessages;
use bevy::prelude::*;
use sinew::Simulation;

use crate::changes::count_and_changed;
use crate::components::{CreationOrder, DistanceConstraint, Spring, WindSurface};
use crate::messages::Refused;
use crate::rows::ResolvedRows;
use crate::world::{CompiledSurfaces, LinkKey, SinewWorld, Tables};
use change_detection::ChangeDetector;
use entry::{LinkEntry, LinkValidator, recompile_tail, unchanged_prefix, update_incrementally};
use kinds::Collected;

/// In each frame, records which distances and constraints were removed, for the next tick.
pub(crate) fn note_gone(
    mut kinds: ResMut<Kinds>,
    distances: RemovedComponents<DistanceConstraint>,
    removed: &RemovedComponentMessages,
) {
    kinds.distances.note_gone(distances.messages());
    kinds.note_gone(removed);
}

/// Detects whether distances, springs or surfaces were added, removed or changed; a few distances are updated at once. Not by hooks: a body is spawned and
/// despawned with tens of thousands of them.
pub(crate) fn notice_links(
    mut world: ResMut<SinewWorld>,
    mut kinds: ResMut<Kinds>,
    distances: Query<(Entity, Ref<DistanceConstraint>)>,
    numbered: Query<(Entity, &CreationOrder, &DistanceConstraint)>,
    springs: Query<Ref<Spring>>,
    surfaces: Query<Ref<WindSurface>>,
    removed: RemovedComponents<DistanceConstraint>,
    mut counts: Local<[usize; 2]>,
) {
    // A component that replaces a removed one is detected as a change, so the counts are sufficient.
    let found = [count_and_changed(&springs), count_and_changed(&surfaces)];
    let now = found.map(|(count, _)| count);
    let count_changed = core::mem::replace(&mut *counts, now) != now;
    let detector = &mut kinds.distances;
    detector.note_gone(removed.messages());
    detector.detect(&distances);
    let SinewWorld { simulation, tables } = &mut *world;
    tables.distances_changed = detector.is_any();
    tables.links_stale |= count_changed || found.iter().any(|&(_, changed)| changed);
    if !detector.is_any() || tables.links_stale {
        return;
    }
    tables.links_stale = !tables.links.complete || !detector.is_few();
    if !tables.links_stale {
        let added = detector.added.iter().filter_map(|&entity| numbered.get(entity).ok());
        let entries: Vec<_> = added.map(|one| entry(tables, one)).collect();
        let keys = &mut tables.links.distances;
        tables.links_stale =
            !update_incrementally(simulation, keys, entries, (kinds::DISTANCES, detector));
        tables.links.version += 1;
    }
}

/// Detects changes of the registered constraints, and, if anything is to be compiled, collects their entries.
pub(crate) fn collect_constraints(world: &mut World) {
    world.resource_scope(|world, mut kinds: Mut<Kinds>| {
        world.resource_scope(|world, mut sinew: Mut<SinewWorld>| {
            kinds.collect(world, &mut sinew);
        });
    });
}

/// Compiles links if particles or surfaces were added, removed or changed, or many links were: those from the first one on that differs, or all.
///
/// An invalid link is left out, so that the others are solved bit for bit as if it did not exist, and reported once. A link that waits for a particle that is
/// set aside is not reported, since the particle was; neither is one that waits for a disabled particle.
pub(crate) fn compile_links(
    mut world: ResMut<SinewWorld>,
    mut kinds: ResMut<Kinds>,
    mut messages: MessageWriter<Refused>,
    distances: Query<(Entity, &CreationOrder, &DistanceConstraint)>,
    springs: Query<(Entity, &CreationOrder, &Spring)>,
    mut surfaces: Query<(Ref<WindSurface>, &mut ResolvedRows<WindSurface>)>,
) {
    let SinewWorld { simulation, tables } = &mut *world;
    tables.links_compiled = core::mem::take(&mut tables.links_stale);
    if !tables.links_compiled {
        return;
    }

    let before = core::mem::take(&mut tables.reported_errors);
    let mut links = core::mem::take(&mut tables.links);
    let all_valid = links.complete && tables.set_aside == 0;
    let mut validator = LinkValidator::new(before, &mut messages);
    let same_rows = tables.layout.same_since(links.layout);
    let lists = (&*tables, &mut links.distances);
    if !(all_valid
        && recompile_distances(simulation, lists, (&kinds.distances, same_rows), &distances))
    {
        let entries = distances.iter().map(|one| entry(tables, one)).collect();
        let mut list = Vec::with_capacity(simulation.distances().len());
        validator.fill(&mut list, &mut links.distances, entries);
        simulation.replace_distances_from(0, list);
    }
    let entries = springs.iter().map(|(entity, &order, spring)| {
        let key = LinkKey { order, entity, kind: kinds::SPRINGS };
        LinkEntry::new(tables, key, &[spring.a, spring.b], |rows| {
            Ok(sinew::Spring {
                a: rows[0],
                b: rows[1],
                rest: spring.rest,
                stiffness: spring.stiffness,
                damping: spring.damping,
            })
        })
    });
    validator.fill(&mut simulation.forces.springs, &mut links.springs, entries.collect());
    match kinds.take() {
        Collected::From(kept, list) => simulation.replace_constraints_from(kept, list),
        Collected::All(entries) => {
            let mut list = Vec::with_capacity(entries.len());
            validator.fill(&mut list, &mut links.constraints, entries);
            simulation.replace_constraints_from(0, list);
        }
    }
    links.complete = validator.passed_all();
    links.layout = tables.layout.number;
    links.version += 1;
    tables.reported_errors = validator.reported_errors();

    tables.links = links;
    compile_surfaces(simulation, tables, &mut surfaces);
}

/// Lists the triangles, unless all of them are the same.
///
/// They are sorted by their particles' rows, which follow creation; triangles with a missing corner are left out.
fn compile_surfaces(
    simulation: &mut Simulation,
    tables: &mut Tables,
    surfaces: &mut Query<(Ref<WindSurface>, &mut ResolvedRows<WindSurface>)>,
) {
    let (known, count) = (tables.links.surfaces, surfaces.iter().len());
    let all_valid = tables.set_aside == 0;
    let unmoved = known.end <= tables.layout.same_since(known.layout);
    tables.links.surfaces.layout = tables.layout.number;
    let is_same = known.all_valid && all_valid && known.count == count && unmoved;
    if is_same && !surfaces.iter().any(|(surface, _)| surface.is_changed()) {
        return;
    }
    let list = &mut simulation.forces.surfaces;
    list.clear();
    let mut end = 0;
    for (surface, mut rows) in surfaces {
        let corners = surface.triangles.iter().flatten().copied();
        let rows = rows.resolve(&tables.layout, surface.is_changed(), corners);
        let valid = |corners: &&[u32; 3]| corners.iter().all(|&row| tables.is_valid(row as usize));
        list.extend(rows.as_chunks().0.iter().filter(valid));
        end = rows.iter().fold(end, |end, &row| end.max((row as usize).saturating_add(1)));
    }
    list.sort_unstable();
    let layout = tables.layout.number;
    tables.links.surfaces = CompiledSurfaces { count, all_valid, layout, end };
}

/// Compiles the distances from the first one on that differs; returns false if all must be compiled.
fn recompile_distances(
    simulation: &mut Simulation,
    (tables, keys): (&Tables, &mut Vec<LinkKey>),
    (detector, same_rows): (&ChangeDetector, usize),
    all: &Query<(Entity, &CreationOrder, &DistanceConstraint)>,
) -> bool {
    let changed = detector.added.len() + detector.gone.len();
    let unchanged = unchanged_prefix(simulation.distances(), same_rows, changed);
    let Some(unchanged) = unchanged else { return false };
    let entry = |entity: Entity| all.get(entity).ok().map(|one| entry(tables, one));
    let added = detector.added.iter().filter_map(|&entity| entry(entity)).collect();
    let recompiled = recompile_tail(
        keys,
        (unchanged, detector.count()),
        (added, &detector.gone),
        |tail, entries| {
            entries.extend(tail.iter().filter_map(|key| entry(key.entity)));
        },
    );
    let Some((kept, list)) = recompiled else { return false };
    simulation.replace_distances_from(kept, list);
    true
}

/// The entry of a distance.
fn entry(
    tables: &Tables,
    (entity, &order, distance): (Entity, &CreationOrder, &DistanceConstraint),
) -> LinkEntry<sinew::Distance> {
    let key = LinkKey { order, entity, kind: kinds::DISTANCES };
    LinkEntry::new(tables, key, &[distance.a, distance.b], |rows| {
        Ok(sinew::Distance {
            a: rows[0],
            b: rows[1],
            rest: distance.rest,
            softness: distance.softness.into(),
            bound: distance.bound.into(),
        })
    })
}
