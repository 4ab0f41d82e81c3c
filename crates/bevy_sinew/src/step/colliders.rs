//! Colliders at gather: what the game says of each becomes one of the solver's, in the order of creation. A warm tick compares where each is with
//! where it was, and writes that down: shapes are made when they or their scale changed, and the list is put in order when one came, went or broke.

use std::collections::BTreeSet;

use bevy::prelude::*;
use sinew::{Frame, Material};

use super::pins::sound;
use crate::components::{
    BoundingBox, Collider, ColliderFault, ColliderMotion, CollisionLayers, ContactEvents,
    ContactsDisabled, CreationOrder, Particle, ParticleBody, PlacedCollider, RigidPose, Sensor,
    SurfaceMaterial,
};
use crate::frames::Frames;
use crate::messages::{Refusal, Refused};
use crate::schedule::{Pace, SinewClock};
use crate::world::SinewWorld;

/// What stands by itself: on a body and its parts, a collider is what that collides by.
type StandsAlone =
    (Without<RigidPose>, Without<ParticleBody>, Without<Particle>, Without<ContactsDisabled>);

/// All that is said of one.
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

/// What is known from the last tick.
#[derive(Default)]
pub(crate) struct Known {
    /// Those with something wrong, so that each is reported once.
    broken: BTreeSet<Entity>,
    gathering: u64,
    listing: u64,
    /// Kept for its memory.
    ordered: Vec<(CreationOrder, Entity)>,
}

/// Has rooms be as large as they are said to be.
pub(crate) fn size_rooms(mut rooms: Query<(&BoundingBox, &mut Collider), Changed<BoundingBox>>) {
    for (room, mut collider) in &mut rooms {
        collider.set_if_neq(room.collider());
    }
}

/// Tells the solver of all colliders; one with something wrong is left out, and reported when that is news.
pub(crate) fn gather_colliders(
    mut world: ResMut<SinewWorld>,
    mut messages: MessageWriter<Refused>,
    mut colliders: Query<ColliderData, StandsAlone>,
    frames: Frames,
    pace: Res<Pace>,
    mut known: Local<Known>,
) {
    let SinewWorld { simulation, tables } = &mut *world;
    let Known { broken, gathering, listing, ordered } = &mut *known;
    let list = &mut simulation.colliders;
    broken.retain(|&entity| colliders.contains(entity));
    *gathering += 1;
    let (mut count, mut relist) = (0, false);
    for told in &mut colliders {
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
        ) = told;
        let placed = placed.into_inner();
        let at = if parented { frames.of(entity) } else { Ok(*transform) };
        let misplaced = at.err().map(Refusal::from);
        // What is sheared stays where it was, and is set aside.
        let at = at.unwrap_or(placed.at);
        // One that was no collider of its own in the last tick may have changed while nobody looked.
        let unseen = core::mem::replace(&mut placed.seen, *gathering) + 1 != *gathering;
        let reshaped = unseen || collider.is_changed() || placed.at.scale != at.scale;
        place(placed, &collider, at, reshaped);
        limit_motion(placed, motion, pace.left);
        if let Some(made) = placed.made.as_deref_mut() {
            made.start = motion.map_or(made.end, |motion| began(motion, &placed.at, made.end));
            made.material = material.map_or(default(), |&material| Material::from(material));
            made.layers = layers.copied().unwrap_or_default().layers();
            (made.sensor, made.events, made.id) = (sensor, events, order.0);
            placed.fault = fault(made);
        }
        let reason = misplaced.or_else(|| placed.fault.clone().map(Refusal::Collider));
        placed.misplaced = matches!(reason, Some(Refusal::Sheared));
        if !sound(broken, &mut messages, entity, reason) {
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
    ordered.clear();
    let sound = colliders.iter().filter(|told| told.10.sound().is_some());
    ordered.extend(sound.map(|told| (*told.1, told.0)));
    ordered.sort_unstable();
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

/// Puts one where it is, and makes its shape if that changed.
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

/// Where several ticks are taken in a row, each goes its part of the way: stops one short of where it is to be.
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
    // The shorter way round.
    let q = if p.dot(q) < 0.0 { -q } else { q };
    placed.at.translation = a + (b - a) * share;
    placed.at.rotation = (p * (1.0 - share) + q * share).normalize();
    made.end = Frame::new(placed.at.translation, placed.at.rotation);
}

/// Where one that is at a place now was when the last tick ended; where it is if that is nowhere.
fn began(motion: &ColliderMotion, at: &Transform, now: Frame) -> Frame {
    let Some(was) = motion.0.filter(|was| *was != isometry(at)) else { return now };
    let start = Frame::new(was.translation.into(), was.rotation);
    if start.is_valid() { start } else { now }
}

fn isometry(at: &Transform) -> Isometry3d {
    Isometry3d::new(at.translation, at.rotation)
}

/// What is wrong with one whose shape is sound.
fn fault(collider: &sinew::Collider) -> Option<ColliderFault> {
    if !collider.end.is_valid() {
        Some(ColliderFault::Transform)
    } else if !collider.material.is_valid() {
        Some(ColliderFault::Material)
    } else {
        None
    }
}

/// Notes where each collider was in the tick that ends. Not of one that was set aside: where it is mended is where it begins.
pub(crate) fn keep_places(
    mut commands: Commands,
    world: Res<SinewWorld>,
    clock: Res<SinewClock>,
    mut colliders: Query<
        (Entity, &PlacedCollider, Option<&mut ColliderMotion>),
        (With<Collider>, StandsAlone),
    >,
) {
    // A fixed clock that stood still took no tick.
    if clock.seconds == world.simulation.time {
        return;
    }
    for (entity, placed, motion) in &mut colliders {
        let now = ColliderMotion(placed.sound().map(|_| isometry(&placed.at)));
        match motion {
            Some(mut motion) => drop(motion.set_if_neq(now)),
            None => drop(commands.entity(entity).try_insert(now)),
        }
    }
}
