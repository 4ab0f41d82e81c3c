//! Body colliders: rigid parts that collide by their shape, and the segments of ropes, passed to the solver when they change.

use std::collections::BTreeSet;

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use sinew::BodyCollider;

use super::pins::check_once;
use super::segments::Segments;
use crate::changes::count_and_changed;
use crate::components::{
    BodyContacts, BodyParticles, Collider, ContactShape, ContactsDisabled, CreationOrder, PartOf,
    ParticleBody, ResolvedShape, RigidPose, WindSurface,
};
use crate::messages::{Refusal, Refused};
use crate::rows::ResolvedRows;
use crate::world::{SinewWorld, Tables};

/// Detects changes of the shape of a part, or of the body that it belongs to.
#[derive(SystemParam)]
pub(crate) struct Reshaped<'w, 's> {
    shapes: Query<'w, 's, Ref<'static, Collider>, With<RigidPose>>,
    poses: Query<'w, 's, Ref<'static, RigidPose>, With<Collider>>,
    owners: Query<'w, 's, Ref<'static, PartOf>, (With<RigidPose>, With<Collider>)>,
}

impl Reshaped<'_, '_> {
    fn any(&self) -> bool {
        count_and_changed(&self.shapes).1
            || count_and_changed(&self.poses).1
            || count_and_changed(&self.owners).1
    }
}

/// Bodies with explicit contact settings, whether they are built, and their triangles.
type ExplicitContacts = (
    Entity,
    &'static BodyContacts,
    Has<ParticleBody>,
    Has<BodyParticles>,
    Option<&'static WindSurface>,
);

/// The components that determine the shape by which an entity with a pose collides.
type Shaped = (
    Option<Ref<'static, BodyContacts>>,
    Option<Ref<'static, ResolvedShape>>,
    Has<ContactsDisabled>,
);

/// Which entities have errors, so that each is reported once; and the counts of components.
#[derive(Default)]
pub(crate) struct BodyColliderScratch {
    shapes: BTreeSet<Entity>,
    bodies: BTreeSet<Entity>,
    counts: [usize; 4],
    /// Whether any body collides by its segments, as of the last check.
    any_segments: bool,
}

/// Lists the body colliders again if particles were added, removed or set aside, if the contact settings of a body or the shape of a part changed, or, where a
/// body collides by its segments, if a rod or a particle changed.
///
/// A part with an invalid shape, or one of a kind that cannot move, is left out and reported; a part with a particle that is gone or set aside is left out.
/// Their particles then collide by themselves.
pub(crate) fn compile_body_colliders(
    mut world: ResMut<SinewWorld>,
    mut messages: MessageWriter<Refused>,
    contacts: Query<Ref<BodyContacts>>,
    resolved: Query<Ref<ResolvedShape>>,
    disabled: Query<Ref<ContactsDisabled>>,
    shaped: Query<Shaped>,
    explicit_contacts: Query<ExplicitContacts>,
    reshaped: Reshaped,
    mut parts: Query<(
        Entity,
        &CreationOrder,
        &Collider,
        Ref<RigidPose>,
        Option<&PartOf>,
        &mut ResolvedRows<RigidPose>,
    )>,
    mut segments: Segments,
    mut scratch: Local<BodyColliderScratch>,
) {
    let SinewWorld { simulation, tables } = &mut *world;
    let BodyColliderScratch { shapes, bodies, counts, any_segments } = &mut *scratch;
    let all =
        [count_and_changed(&contacts), count_and_changed(&resolved), count_and_changed(&disabled)];
    let changed = all.iter().any(|&(_, changed)| changed);
    // Change detection finds additions; a removal changes the count.
    let now = [all[0].0, all[1].0, all[2].0, parts.iter().len()];
    let count_changed = core::mem::replace(counts, now) != now;
    let rods_changed = || {
        tables.distances_changed
            || tables.properties_gathered
            || tables.bodies_changed
            || segments.are_off()
    };
    let anew = tables.links_compiled || count_changed || changed || reshaped.any();
    // The representation by which an entity collides; `None` if it does not.
    let shape = |owner: Entity| match shaped.get(owner) {
        Ok((_, _, true)) => None,
        Ok((Some(own), _, _)) if own.shape != ContactShape::Auto => Some(own.shape),
        Ok((_, Some(resolved), _)) if resolved.shape != ContactShape::Particles => {
            Some(resolved.shape)
        }
        _ => Some(ContactShape::Auto),
    };
    let uses_segments = |owner: Entity| shape(owner) == Some(ContactShape::Segments);
    if anew {
        let explicit = contacts.iter().any(|own| own.shape == ContactShape::Segments);
        *any_segments = explicit || resolved.iter().any(|own| own.shape == ContactShape::Segments);
    }
    if !(anew || *any_segments && rods_changed()) {
        return;
    }
    tables.cache_kept = None;
    shapes.retain(|&entity| parts.contains(entity));
    bodies.retain(|&entity| contacts.contains(entity));

    let mut body_colliders: Vec<(CreationOrder, Entity, BodyCollider)> = Vec::new();
    let mut owners: Vec<Entity> = Vec::new();
    for (part, order, collider, pose, of, mut rows) in &mut parts {
        rows.collider = None;
        let owner = of.map_or(part, |of| of.0);
        let explicit = contacts.get(owner).map_or(ContactShape::Auto, |own| own.shape);
        let by_parts = matches!(explicit, ContactShape::Auto | ContactShape::Solid);
        if !by_parts || disabled.contains(owner) {
            continue;
        }
        let rows = rows.resolve(&tables.layout, pose.is_changed(), pose.particles.iter().copied());
        let (body_collider, reason) = match body_collider(tables, collider, (&pose, *order), rows) {
            Ok(body_collider) => (body_collider, None),
            Err(reason) => (None, Some(reason)),
        };
        owners.push(owner);
        check_once(shapes, &mut messages, part, reason);
        body_colliders.extend(body_collider.map(|body_collider| (*order, part, body_collider)));
    }
    // A body with rigid parts collides by those, unless it explicitly uses segments.
    owners.sort_unstable();
    let with_parts = owners.clone();
    let by_segments = |body: Entity| {
        let explicit = contacts.get(body).is_ok_and(|own| own.shape == ContactShape::Segments);
        uses_segments(body) && (explicit || with_parts.binary_search(&body).is_err())
    };
    let by_segments = (*any_segments, by_segments);
    segments.list((simulation, tables), by_segments, &mut owners, &mut body_colliders);
    body_colliders.sort_unstable_by_key(|&(order, part, _)| (order, part));
    owners.sort_unstable();
    for (body, own, is_body, is_built, surface) in &explicit_contacts {
        // A body that is not built yet is no error.
        let waits = is_body && !is_built;
        let lacks = match own.shape {
            ContactShape::Solid | ContactShape::Segments => owners.binary_search(&body).is_err(),
            ContactShape::Triangles => surface.is_none_or(|own| own.triangles.is_empty()),
            ContactShape::Auto | ContactShape::Particles => false,
        };
        let what = match own.shape {
            ContactShape::Triangles => Refusal::NoTriangles,
            ContactShape::Segments => Refusal::NoSegments,
            _ => Refusal::NotSolid,
        };
        let reason = (lacks && !waits).then_some(what);
        check_once(bodies, &mut messages, body, reason);
    }
    tables.parts.clear();
    tables.parts.extend(body_colliders.iter().map(|&(_, part, _)| part));
    for (&part, number) in tables.parts.iter().zip(0..) {
        if let Ok((.., mut rows)) = parts.get_mut(part) {
            rows.collider = Some(number);
        }
    }
    // Rods may have changed without an effect on the segments; the solver's list is then not marked as changed.
    let same = || {
        simulation
            .body_colliders()
            .iter()
            .eq(body_colliders.iter().map(|(_, _, body_collider)| body_collider))
    };
    if anew || !same() {
        let list = simulation.body_colliders_mut();
        list.clear();
        list.extend(body_colliders.into_iter().map(|(_, _, body_collider)| body_collider));
    }
}

/// The collider of a part; `None` while one of its particles is gone or set aside.
fn body_collider(
    tables: &Tables,
    collider: &Collider,
    (pose, order): (&RigidPose, CreationOrder),
    rows: &[u32],
) -> Result<Option<BodyCollider>, Refusal> {
    let shape = collider.shape().map_err(|fault| Refusal::Collider(fault.into()))?;
    let rest = pose.rest.as_slice().into();
    let body_collider = BodyCollider { rows: rows.to_vec(), rest, shape, id: order.0 };
    if !rows.iter().all(|&row| tables.is_valid(row as usize)) {
        return Ok(None);
    }
    match body_collider.fault(tables.entities.len()) {
        None => Ok(Some(body_collider)),
        Some(fault) => Err(Refusal::Part(fault)),
    }
}
