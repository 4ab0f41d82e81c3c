//! Links: springs, constraints and surfaces name entities; the solver wants rows. Compiled when any of them changed.

mod entry;
mod kinds;

pub use kinds::RegisterParticleConstraint;
pub(crate) use kinds::{Kinds, register_ours};

use bevy::prelude::*;

use super::changes::census;
use crate::components::{CreationOrder, DistanceConstraint, Spring, WindSurface};
use crate::messages::Refused;
use crate::world::SinewWorld;
use entry::{Entry, Judge, Place};

/// Notes whether distances, springs or surfaces came, went or changed. No hook does: a body comes and goes with tens of thousands of them.
pub(crate) fn notice_links(
    mut world: ResMut<SinewWorld>,
    distances: Query<Ref<DistanceConstraint>>,
    springs: Query<Ref<Spring>>,
    surfaces: Query<Ref<WindSurface>>,
    mut counts: Local<[usize; 3]>,
) {
    // Of what was removed Bevy tells for two frames, and a tick may be farther away. Who replaces it has changed, so their numbers say it all.
    let found = [census(&distances), census(&springs), census(&surfaces)];
    let now = found.map(|(count, _)| count);
    let went = core::mem::replace(&mut *counts, now) != now;
    if went || found.iter().any(|&(_, changed)| changed) {
        world.tables.stale = true;
    }
}

/// Looks at the registered constraints: whether any came, went or changed, and, if anything is to be compiled, what they all are among rows.
pub(crate) fn collect_laws(world: &mut World) {
    world.resource_scope(|world, mut kinds: Mut<Kinds>| {
        world.resource_scope(|world, mut sinew: Mut<SinewWorld>| {
            kinds.collect(world, &mut sinew.tables);
        });
    });
}

/// Compiles all links afresh if particles, links or surfaces came, went or changed.
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
    let mut judge = Judge::new(before, &mut messages);
    let entries = distances.iter().map(|(entity, &order, distance)| {
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
    });
    judge.fill(simulation.distances_mut(), entries.collect());
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
    judge.fill(&mut simulation.forces.springs, entries.collect());
    judge.fill(simulation.constraints_mut(), kinds.take());
    tables.complaints = judge.complaints();

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
