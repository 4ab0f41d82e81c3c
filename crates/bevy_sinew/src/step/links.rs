//! Links: springs, constraints and surfaces name entities; the solver wants rows. Compiled when any of them changed.

use bevy::prelude::*;

use crate::components::{CreationOrder, DistanceConstraint, Spring, WindSurface};
use crate::messages::{Refusal, Refused, refuse};
use crate::world::{SinewWorld, Tables};

/// Compiles all links afresh if particles, links or surfaces came, went or changed.
///
/// A link that cannot act is left out, so that the others run bit for bit as if it were not there, and reported once. One that
/// waits for a particle that is set aside is not reported: the particle was.
pub(crate) fn compile_links(
    mut world: ResMut<SinewWorld>,
    mut messages: MessageWriter<Refused>,
    changed: Query<(), Or<(Changed<DistanceConstraint>, Changed<Spring>, Changed<WindSurface>)>>,
    distances: Query<(Entity, &CreationOrder, &DistanceConstraint)>,
    springs: Query<(Entity, &CreationOrder, &Spring)>,
    surfaces: Query<(Entity, &WindSurface)>,
    mut removed_surfaces: RemovedComponents<WindSurface>,
) {
    let SinewWorld { simulation, tables } = &mut *world;
    if removed_surfaces.read().count() > 0 || !changed.is_empty() {
        tables.stale = true;
    }
    if !tables.stale {
        return;
    }
    tables.stale = false;
    let rows = simulation.particles.len();
    // Complaints about links that are gone, or that are now in order, are forgotten: they may be raised again.
    let mut complaints = core::mem::take(&mut tables.complaints);
    complaints.retain(|entity, _| distances.contains(*entity) || springs.contains(*entity));

    let mut verdict = |entity: Entity, fault: Option<Refusal>| match fault {
        None => {
            complaints.remove(&entity);
            true
        }
        Some(reason) => {
            if complaints.get(&entity) != Some(&reason) {
                refuse(&mut messages, entity, reason.clone());
                complaints.insert(entity, reason);
            }
            false
        }
    };

    let mut ordered: Vec<_> = distances.iter().collect();
    ordered.sort_unstable_by_key(|(_, order, _)| **order);
    let list = simulation.distances_mut();
    list.clear();
    for (entity, _, constraint) in ordered {
        if tables.is_set_aside(constraint.a) || tables.is_set_aside(constraint.b) {
            continue;
        }
        let distance = sinew::Distance {
            a: row_or_none(tables, constraint.a),
            b: row_or_none(tables, constraint.b),
            rest: constraint.rest,
            compliance: constraint.compliance,
            bound: constraint.bound.into(),
        };
        let fault = if constraint.a == constraint.b {
            Some(sinew::DistanceFault::SameParticle)
        } else if tables.is_missing(constraint.a) || tables.is_missing(constraint.b) {
            Some(sinew::DistanceFault::MissingParticle)
        } else {
            distance.fault(rows)
        };
        if verdict(entity, fault.map(Refusal::Distance)) {
            list.push(distance);
        }
    }

    let mut ordered: Vec<_> = springs.iter().collect();
    ordered.sort_unstable_by_key(|(_, order, _)| **order);
    let list = &mut simulation.forces.springs;
    list.clear();
    for (entity, _, spring) in ordered {
        if tables.is_set_aside(spring.a) || tables.is_set_aside(spring.b) {
            continue;
        }
        let compiled = sinew::Spring {
            a: row_or_none(tables, spring.a),
            b: row_or_none(tables, spring.b),
            rest: spring.rest,
            stiffness: spring.stiffness,
            damping: spring.damping,
        };
        let fault = if spring.a == spring.b {
            Some(sinew::SpringFault::SameParticle)
        } else if tables.is_missing(spring.a) || tables.is_missing(spring.b) {
            Some(sinew::SpringFault::MissingParticle)
        } else {
            compiled.fault(rows)
        };
        if verdict(entity, fault.map(Refusal::Spring)) {
            list.push(compiled);
        }
    }
    tables.complaints = complaints;

    // Triangles are ordered by their particles' rows, which follow creation; a torn corner just leaves its triangles out.
    let list = &mut simulation.forces.surfaces;
    list.clear();
    for (_, surface) in &surfaces {
        let rows = |corners: &[Entity; 3]| {
            let [a, b, c] = corners.map(|corner| tables.sound_row(corner));
            Some([a?, b?, c?])
        };
        list.extend(surface.triangles.iter().filter_map(rows));
    }
    list.sort_unstable();
}

/// The row of a sound particle, or a row that does not exist: the fault check then says that the particle is missing.
fn row_or_none(tables: &Tables, entity: Entity) -> u32 {
    tables.sound_row(entity).unwrap_or(u32::MAX)
}
