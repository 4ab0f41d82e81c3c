//! Pairs that do not collide although no constraint connects them: a body and what it is pinned or attached to, and a body and the colliders that are its
//! children.

use bevy::prelude::*;
use sinew::ContactParticipant;

use crate::attach::Attached;
use crate::components::{
    BodyParticles, PartOf, ParticleBody, ParticleRow, PinnedTo, PlacedCollider,
};
use crate::rows::{GONE, ResolvedRows};
use crate::world::SinewWorld;

/// Lists these pairs for the solver.
pub(crate) fn gather_ignored(
    mut world: ResMut<SinewWorld>,
    pins: Query<(&PinnedTo, &ParticleRow)>,
    attached: Query<&Attached>,
    rows: Query<&ParticleRow>,
    children: Query<(Entity, &PlacedCollider), With<ChildOf>>,
    placed: Query<&PlacedCollider>,
    bodies: Query<&ResolvedRows<BodyParticles>, With<ParticleBody>>,
    parts: Query<&PartOf>,
    parents: Query<&ChildOf>,
) {
    let SinewWorld { simulation, tables } = &mut *world;
    let particles = &simulation.particles;
    let list = &mut simulation.ignored;
    list.clear();
    let body_of_row = |row: usize| particles.body(row).map(ContactParticipant::Body);
    let body = |entity: Entity| {
        let owner = parts.get(entity).map_or(entity, |of| of.0);
        let rows = bodies.get(owner).ok()?.get();
        body_of_row(*rows.iter().find(|&&row| row != GONE)? as usize)
    };
    // A collider's index is that of the last listing in which it was valid.
    let collider = |entity: Entity, placed: &PlacedCollider| {
        let listed = tables.colliders.get(placed.number) == Some(&entity);
        listed.then_some(ContactParticipant::Collider(placed.number as u32))
    };
    for (pin, row) in &pins {
        let Some(row) = row.within(particles) else { continue };
        let held = body_of_row(row);
        let by = placed.get(pin.entity).ok().and_then(|placed| collider(pin.entity, placed));
        if let (Some(held), Some(by)) = (held, by.or_else(|| body(pin.entity))) {
            list.push([held, by]);
        }
    }
    for attached in &attached {
        // Pinned particles are already in the list.
        if !attached.pinned.is_empty() {
            continue;
        }
        let Ok(by) = placed.get(attached.to.entity) else { continue };
        let particle = || body_of_row(rows.get(attached.body).ok()?.within(particles)?);
        let held = body(attached.body).or_else(particle);
        if let (Some(held), Some(by)) = (held, collider(attached.to.entity, by)) {
            list.push([held, by]);
        }
    }
    for (child, placed) in &children {
        let Some(collider) = collider(child, placed) else { continue };
        list.extend(parents.iter_ancestors(child).find_map(body).map(|body| [body, collider]));
    }
}
