//! Once a tick, before rows are assigned: makes attachments whose bodies are built, makes those again whose bodies were rebuilt, and releases those whose other
//! entity is gone.

use std::collections::BTreeMap;

use bevy::prelude::*;
use sinew::pose::pose;

use super::point_source::{Point, PointSource, locate};
use super::{
    Anchor, AnchorConstraint, AttachTo, Attached, AttachmentOf, JointOf, joints_of, release,
};
use crate::components::{
    BreakAt, BuiltBody, CreationOrder, DistanceConstraint, Mass, PartOf, Particle, PinnedTo, Sleep,
    Softness, fill_sorted,
};
use crate::frames::in_world;
use crate::messages::{AttachFault, Refusal, refuse_in};

/// All attachments, with their order of creation.
type All = QueryState<(Entity, &'static CreationOrder), With<AttachTo>>;

/// The result of trying to make an attachment.
enum AttachOutcome {
    /// The attachment itself no longer exists.
    Gone,
    Made(Attached),
    Waiting,
    /// The other entity is gone.
    Released,
}

/// Makes and releases attachments.
pub(crate) fn resolve_attachments(
    world: &mut World,
    all: &mut All,
    mut order: Local<Vec<(CreationOrder, Entity)>>,
    mut reported: Local<BTreeMap<Entity, AttachFault>>,
) {
    fill_sorted(&mut order, all.iter(world).map(|(entity, order)| (*order, entity)));
    reported.retain(|&entity, _| world.get::<AttachTo>(entity).is_some());
    for &(_, attachment) in &*order {
        let Some(to) = world.get::<AttachTo>(attachment) else { continue };
        let body = world.get::<AttachmentOf>(attachment).map_or(attachment, |of| of.0);
        if in_effect(world, attachment, body, to) {
            continue;
        }
        let to = to.clone();
        let outcome = attach(world, attachment, body, &to);
        match outcome {
            Ok(AttachOutcome::Gone | AttachOutcome::Waiting) => {}
            Ok(AttachOutcome::Made(attached)) => {
                if let Ok(mut entity) = world.get_entity_mut(attachment) {
                    entity.insert(attached);
                }
            }
            Ok(AttachOutcome::Released) => {
                refuse_in(world, attachment, Refusal::AttachTarget(to.entity));
                if body == attachment {
                    world.entity_mut(attachment).remove::<AttachTo>();
                } else {
                    world.try_despawn(attachment).ok();
                }
                // Applies the commands that the component's hook queued.
                world.flush();
            }
            Err(fault) => {
                if reported.insert(attachment, fault) != Some(fault) {
                    refuse_in(world, attachment, Refusal::Attach(fault));
                }
                continue;
            }
        }
        reported.remove(&attachment);
    }
}

/// Whether an attachment is in effect as specified: the only check that most attachments need in a tick.
fn in_effect(world: &World, attachment: Entity, body: Entity, to: &AttachTo) -> bool {
    let Some(attached) = world.get::<Attached>(attachment) else { return false };
    // The load of a pin cannot be measured, so an attachment that may break needs constraints.
    let measurable = attached.pinned.is_empty() || world.get::<BreakAt>(attachment).is_none();
    measurable
        && world.get_entity(to.entity).is_ok()
        && attached.builds == [builds(world, body), builds(world, to.entity)]
        && attached.is_of(body, to)
}

/// How often a body has been built; for a part, how often its body has.
fn builds(world: &World, entity: Entity) -> u32 {
    let body = world.get::<PartOf>(entity).map_or(entity, |of| of.0);
    world.get::<BuiltBody>(body).map_or(0, |built| built.builds)
}

/// Makes an attachment; a previous one is released first.
fn attach(
    world: &mut World,
    attachment: Entity,
    body: Entity,
    to: &AttachTo,
) -> Result<AttachOutcome, AttachFault> {
    if world.get_entity(to.entity).is_err() {
        return Ok(AttachOutcome::Released);
    }
    let softness = sinew::Softness::from(to.softness);
    if !(to.part.is_finite() && to.anchor.is_finite() && softness.is_valid()) {
        return Err(AttachFault::Number);
    }
    let part = locate(world, body, &to.part).map_err(|()| AttachFault::NoSuchPart)?;
    let on_target = locate(world, to.entity, &to.anchor).map_err(|()| AttachFault::NoSuchAnchor)?;
    let (Some((tied, part)), Some((target_entity, anchor))) = (part, on_target) else {
        return Ok(AttachOutcome::Waiting);
    };
    let source = PointSource::of(world, tied).map_err(|()| AttachFault::NoParticles)?;
    let target_source = PointSource::of(world, target_entity).map_err(|()| AttachFault::NoPlace)?;
    let (Some(source), Some(target_source)) = (source, target_source) else {
        return Ok(AttachOutcome::Waiting);
    };
    if matches!(source, PointSource::Frame) {
        return Err(AttachFault::NoParticles);
    }
    let points = source.points(world, tied, &part);
    if points.is_empty() {
        return Err(AttachFault::NoSuchPart);
    }
    let before = world.get::<Attached>(attachment).cloned();
    let kept = before.as_ref().filter(|before| before.is_of(body, to));
    let target = Target { world, target_entity, source: &target_source, anchor: &anchor };
    let offsets = target.offsets(&points, to.snap, kept.map(|kept| kept.offsets.as_slice()))?;
    let others = target.points(&points, &offsets, to.snap)?;
    let itself = |point: &Point, other: &Option<Point>| {
        let shares = |one: &Point, other: &Point| {
            one.particles.iter().any(|particle| other.particles.contains(particle))
        };
        other.as_ref().is_some_and(|other| shares(point, other))
    };
    if points.iter().zip(&others).any(|(point, other)| itself(point, other)) {
        return Err(AttachFault::Itself);
    }
    // All checks passed: the world is modified from here on.
    let joints = joints_of(world, attachment);
    match &before {
        Some(before) => release(world, before, joints),
        // It was cloned with its joints.
        None => joints.into_iter().for_each(|joint| {
            world.try_despawn(joint).ok();
        }),
    }
    let mut pinned = Vec::new();
    let pins = to.softness == Softness::Hard && world.get::<BreakAt>(attachment).is_none();
    for ((point, other), &offset) in points.iter().zip(others).zip(&offsets) {
        let pin = PinnedTo { entity: target_entity, offset };
        match other {
            Some(other) => join(world, attachment, point, &other, (to.snap, to.softness)),
            None if point.particles.len() == 1 && pins => {
                if let Ok(mut particle) = world.get_entity_mut(point.particles[0]) {
                    particle.insert(pin);
                    pinned.push(point.particles[0]);
                }
            }
            None => {
                let helper = (Particle::at(point.place), pin, JointOf(attachment));
                let helper = world.spawn(helper).id();
                let helper = Point {
                    particles: vec![helper],
                    weights: vec![1.0],
                    rigid: false,
                    place: point.place,
                };
                join(world, attachment, point, &helper, (true, to.softness));
            }
        }
    }
    for entity in [body, tied, to.entity, target_entity] {
        let owner = world.get::<PartOf>(entity).map_or(entity, |of| of.0);
        if let Some(mut sleep) = world.get_mut::<Sleep>(owner) {
            sleep.wake();
        }
    }
    if world.get_entity(attachment).is_err() {
        return Ok(AttachOutcome::Gone);
    }
    Ok(AttachOutcome::Made(Attached {
        body,
        to: to.clone(),
        builds: [builds(world, body), builds(world, to.entity)],
        offsets,
        pinned,
    }))
}

/// The other entity, and the place on it that the body is attached to.
struct Target<'a> {
    world: &'a World,
    target_entity: Entity,
    source: &'a PointSource,
    anchor: &'a Anchor,
}

impl Target<'_> {
    /// The entity's frame in the world, in metres for a rigid body, in its own units for a transform. `None` if it has no frame.
    fn frame(&self) -> Result<Option<Transform>, AttachFault> {
        let at = in_world(self.world, self.target_entity).map_err(|_| AttachFault::NoPlace)?;
        let frame = match self.source {
            PointSource::Loose { .. } => return Ok(None),
            PointSource::Frame => at,
            // The transform of a part that was just built has not been extracted yet.
            PointSource::Rigid { particles, rest } => {
                let points = particles.iter().zip(rest).filter_map(|(&particle, &rest)| {
                    let at = self.world.get::<Particle>(particle)?.position;
                    Some((at, rest, self.world.get::<Mass>(particle)?.0))
                });
                let found = pose(points, at.rotation).ok_or(AttachFault::NoPlace)?;
                Transform::from_translation(found.translation).with_rotation(found.rotation)
            }
        };
        let valid = frame.is_finite() && frame.scale.abs().min_element() > 0.0;
        if valid { Ok(Some(frame)) } else { Err(AttachFault::NoPlace) }
    }

    /// The position in the frame at which each point is kept. Previous positions (`before`) are kept; if the number of points has changed, only their middle
    /// is.
    fn offsets(
        &self,
        points: &[Point],
        snap: bool,
        before: Option<&[Vec3]>,
    ) -> Result<Vec<Vec3>, AttachFault> {
        let Some(frame) = self.frame()? else { return Ok(vec![Vec3::ZERO; points.len()]) };
        let back = frame.compute_affine().inverse();
        let now: Vec<Vec3> = points.iter().map(|p| back.transform_point3(p.place)).collect();
        let middle = |all: &[Vec3]| all.iter().sum::<Vec3>() / all.len().max(1) as f32;
        // Evaluated even if the points keep their position, so that a missing anchor is refused.
        let anchor = self.source.local(self.world, self.target_entity, self.anchor);
        let anchor = anchor.ok_or(AttachFault::NoSuchAnchor)?;
        let to = match before {
            _ if snap => anchor,
            Some(before) if before.len() == now.len() => return Ok(before.to_vec()),
            Some(before) if !before.is_empty() => middle(before),
            _ => return Ok(now),
        };
        let from = middle(&now);
        Ok(now.into_iter().map(|place| to + (place - from)).collect())
    }

    /// The points of the other entity to which the given points are attached; `None` for each where its transform moves them.
    fn points(
        &self,
        points: &[Point],
        offsets: &[Vec3],
        snap: bool,
    ) -> Result<Vec<Option<Point>>, AttachFault> {
        let Self { world, target_entity, source, anchor } = self;
        let other = |(point, &offset): (&Point, &Vec3)| match source {
            PointSource::Frame => Ok(None),
            PointSource::Rigid { .. } => {
                source.rigid_point(world, offset).map(Some).ok_or(AttachFault::NoSuchAnchor)
            }
            PointSource::Loose { .. } => source
                .loose_point(world, *target_entity, anchor, (point.place, snap))
                .map(Some)
                .ok_or(AttachFault::NoSuchAnchor),
        };
        points.iter().zip(offsets).map(other).collect()
    }
}

/// Gaps up to this fraction of the largest coordinate (of 1 m at least) are round-off.
const GAP_ROUND_OFF: f32 = 1e-5;

/// Spawns the constraint that keeps two points together, or, unless they are to `close` up, at their current distance. A gap within round-off counts as none.
fn join(
    world: &mut World,
    attachment: Entity,
    one: &Point,
    other: &Point,
    (close, softness): (bool, Softness),
) {
    let gap = one.place.distance(other.place);
    let exact = gap <= GAP_ROUND_OFF * one.place.abs().max_element().max(1.0);
    // A rigid body defines a point at any position, so `other` is already the position to keep.
    let rest = if close || exact || other.rigid { 0.0 } else { gap };
    let of = JointOf(attachment);
    if let ([a], [b]) = (one.particles.as_slice(), other.particles.as_slice()) {
        let rod = DistanceConstraint::new(*a, *b, rest).with_softness(softness);
        world.spawn((rod, of));
        return;
    }
    let constraint = AnchorConstraint {
        particles: one.particles.iter().chain(&other.particles).copied().collect(),
        first: one.particles.len(),
        weights: one.weights.iter().chain(&other.weights).copied().collect(),
        rigid: [one.rigid, other.rigid],
        rest,
        softness,
    };
    world.spawn((constraint, of));
}
