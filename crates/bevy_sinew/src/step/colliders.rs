//! Gathers colliders: the components of each become a collider of the solver, in the order of creation. A warm tick only compares and copies placements; shapes
//! are made when they or their scale change, and the list is sorted when a collider is added, removed or set aside.

use std::collections::BTreeSet;

use bevy::prelude::*;
use sinew::{Frame, Material};

use super::pins::check_once;
use crate::components::{
    BoundingBox, Collider, ColliderFault, ColliderMotion, CollisionLayers, ContactEvents,
    ContactsDisabled, CreationOrder, Particle, ParticleBody, PlacedCollider, RigidPose, Sensor,
    SurfaceMaterial, fill_sorted,
};
use crate::frames::Frames;
use crate::messages::{Refusal, Refused};
use crate::schedule::{FixedTick, SinewClock};
use crate::world::SinewWorld;

/// Static and kinematic colliders: on a body and its parts, a collider is the shape of the body.
type StaticOrKinematic =
    (Without<RigidPose>, Without<ParticleBody>, Without<Particle>, Without<ContactsDisabled>);

/// The components of a collider.
type ColliderData = (
    Entity,
    &'static CreationOrder,
    Ref<'static, Collider>,
    &'static Transform,
    Has<ChildOf>,
    Option<&'static ColliderMotion>,
    Option<&'static SurfaceMaterial>,
    Option<&'static CollisionLayers>,
    Has<Sensor>,
    Has<ContactEvents>,
    &'static mut PlacedCollider,
);

/// What is kept from tick to tick.
#[derive(Default)]
pub(crate) struct ColliderScratch {
    /// Colliders with an error, so that each is reported once.
    broken: BTreeSet<Entity>,
    gathering: u64,
    listing: u64,
    /// Kept for its memory.
    ordered: Vec<(CreationOrder, Entity)>,
}

/// Updates the colliders of bounding boxes that were resized.
pub(crate) fn resize_bounding_boxes(
    mut bounding_boxes: Query<(&BoundingBox, &mut Collider), Changed<BoundingBox>>,
) {
    for (bounding_box, mut collider) in &mut bounding_boxes {
        collider.set_if_neq(bounding_box.collider());
    }
}

/// Updates the solver's list of colliders; one with an error is left out, and reported once.
pub(crate) fn gather_colliders(
    mut world: ResMut<SinewWorld>,
    mut messages: MessageWriter<Refused>,
    mut colliders: Query<ColliderData, StaticOrKinematic>,
    frames: Frames,
    fixed_tick: Res<FixedTick>,
    mut scratch: Local<ColliderScratch>,
) {
    let SinewWorld { simulation, tables } = &mut *world;
    let ColliderScratch { broken, gathering, listing, ordered } = &mut *scratch;
    let list = &mut simulation.colliders;
    broken.retain(|&entity| colliders.contains(entity));
    *gathering += 1;
    let (mut count, mut relist) = (0, false);
    for components in &mut colliders {
        let (
            entity,
            order,
            collider,
            transform,
            parented,
            motion,
            material,
            layers,
            sensor,
            events,
            placed,
        ) = components;
        let placed = placed.into_inner();
        let at = if parented { frames.of(entity) } else { Ok(*transform) };
        let misplaced = at.err().map(Refusal::from);
        // A sheared collider stays where it was, and is set aside.
        let at = at.unwrap_or(placed.at);
        // A collider that was not gathered in the last tick may have changed in the meantime.
        let was_absent = core::mem::replace(&mut placed.last_gather, *gathering) + 1 != *gathering;
        let reshaped = was_absent || collider.is_changed() || placed.at.scale != at.scale;
        place(placed, &collider, at, reshaped);
        limit_motion(placed, motion, fixed_tick.remaining);
        if let Some(made) = placed.made.as_deref_mut() {
            made.start =
                motion.map_or(made.end, |motion| start_frame(motion, &placed.at, made.end));
            made.material = material.map_or(default(), |&material| Material::from(material));
            made.layers = layers.copied().unwrap_or_default().layers();
            (made.sensor, made.events, made.id) = (sensor, events, order.0);
            placed.fault = fault(made);
        }
        let reason = misplaced.or_else(|| placed.fault.clone().map(Refusal::Collider));
        placed.misplaced = matches!(reason, Some(Refusal::Sheared));
        if !check_once(broken, &mut messages, entity, reason) {
            continue;
        }
        count += 1;
        if placed.listing != *listing || placed.order != *order {
            relist = true;
        }
        if let (Some(made), Some(slot), false) =
            (placed.made.as_deref(), list.get_mut(placed.number), relist)
        {
            (slot.start, slot.end) = (made.start, made.end);
            (slot.sensor, slot.events) = (made.sensor, made.events);
            (slot.material, slot.layers) = (made.material, made.layers);
            if reshaped {
                slot.shape.clone_from(&made.shape);
            }
        }
    }
    if !relist && count == list.len() {
        return;
    }

    *listing += 1;
    let valid = colliders.iter().filter(|components| components.10.valid().is_some());
    fill_sorted(ordered, valid.map(|components| (*components.1, components.0)));
    list.clear();
    tables.colliders.clear();
    for &(order, entity) in &*ordered {
        let Ok((.., placed)) = colliders.get_mut(entity) else { continue };
        let placed = placed.into_inner();
        (placed.listing, placed.number, placed.order) = (*listing, list.len(), order);
        list.extend(placed.made.as_deref().cloned());
        tables.colliders.push(entity);
    }
}

/// Updates the placement of a collider, and its shape if that changed.
fn place(placed: &mut PlacedCollider, collider: &Collider, at: Transform, reshaped: bool) {
    let moved = placed.at != at;
    if reshaped {
        placed.made = None;
        match collider.scaled(at.scale) {
            Ok(shape) => {
                placed.made = Some(Box::new(sinew::Collider::fixed(shape, Frame::IDENTITY)));
            }
            Err(fault) => placed.fault = Some(fault.into()),
        }
    }
    placed.at = at;
    if let Some(made) = placed.made.as_deref_mut().filter(|_| reshaped || moved) {
        made.end = Frame::new(at.translation, at.rotation);
    }
}

/// If several ticks are run in a row, each moves the collider by its share of the remaining motion.
fn limit_motion(placed: &mut PlacedCollider, motion: Option<&ColliderMotion>, left: u32) {
    let Some(was) = motion.and_then(|motion| motion.0).filter(|_| left > 1) else { return };
    let Some(made) = placed.made.as_deref_mut() else { return };
    let to = isometry(&placed.at);
    if was == to || !Frame::new(was.translation.into(), was.rotation).is_valid() {
        return;
    }
    let share = 1.0 / left as f32;
    let (a, b) = (Vec3::from(was.translation), placed.at.translation);
    let (p, q) = (was.rotation, placed.at.rotation);
    // The shorter rotation.
    let q = if p.dot(q) < 0.0 { -q } else { q };
    placed.at.translation = a + (b - a) * share;
    placed.at.rotation = (p * (1.0 - share) + q * share).normalize();
    made.end = Frame::new(placed.at.translation, placed.at.rotation);
}

/// The placement of a collider at the end of the last tick; the current one if that is not valid.
fn start_frame(motion: &ColliderMotion, at: &Transform, now: Frame) -> Frame {
    let Some(was) = motion.0.filter(|was| *was != isometry(at)) else { return now };
    let start = Frame::new(was.translation.into(), was.rotation);
    if start.is_valid() { start } else { now }
}

fn isometry(at: &Transform) -> Isometry3d {
    Isometry3d::new(at.translation, at.rotation)
}

/// The error of a collider with a valid shape.
fn fault(collider: &sinew::Collider) -> Option<ColliderFault> {
    if !collider.end.is_valid() {
        Some(ColliderFault::Transform)
    } else if !collider.material.is_valid() {
        Some(ColliderFault::Material)
    } else {
        None
    }
}

/// What was a collider: its component was removed, or its contacts are switched off.
type NoCollider = Or<(Without<Collider>, With<ContactsDisabled>)>;

/// Stores where each collider was in this tick. A collider that took no part, because it is set aside, switched off or removed, has no stored placement: when
/// it takes part again, it starts where it then is, and sweeps nothing along on the way there.
pub(crate) fn store_motion(
    mut commands: Commands,
    world: Res<SinewWorld>,
    clock: Res<SinewClock>,
    mut colliders: Query<
        (Entity, &PlacedCollider, Option<&mut ColliderMotion>),
        (With<Collider>, StaticOrKinematic),
    >,
    mut others: Query<&mut ColliderMotion, NoCollider>,
) {
    if !clock.is_behind(&world) {
        return;
    }
    for mut motion in &mut others {
        motion.set_if_neq(ColliderMotion(None));
    }
    for (entity, placed, motion) in &mut colliders {
        let now = ColliderMotion(placed.valid().map(|_| isometry(&placed.at)));
        match motion {
            Some(mut motion) => drop(motion.set_if_neq(now)),
            None => drop(commands.entity(entity).try_insert(now)),
        }
    }
}
