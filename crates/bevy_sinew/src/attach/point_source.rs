//! Point sources: which particles an anchor selects, and how they define a point.

use bevy::ecs::relationship::RelationshipTarget;
use bevy::prelude::*;
use sinew::constraints::affine_weights;

use super::{Anchor, RopeEnd};
use crate::components::{
    BodyPart, BodyParticles, BodyParts, MeshFollow, Particle, ParticleBody, RestPlace, RigidPose,
    TubeMesh,
};
use crate::frames::in_world;
use crate::messages::AttachFault;

/// What determines the points of an entity.
pub(super) enum PointSource {
    /// Only its `Transform`, which the game writes.
    Frame,
    /// The particles of a rigid body or part, and their positions in its frame.
    Rigid { particles: Vec<Entity>, rest: Vec<Vec3> },
    /// Particles that move independently of each other.
    Loose { particles: Vec<Entity> },
}

/// A point as an affine combination of particles.
#[derive(Clone, Debug)]
pub(super) struct Point {
    pub(super) particles: Vec<Entity>,
    pub(super) weights: Vec<f32>,
    pub(super) rigid: bool,
    /// Its current position in the world, metres.
    pub(super) place: Vec3,
}

/// The entity that carries an anchor, and the anchor on it: a bone is an entity of its own. `None` while its body is not built; an error if there is no such
/// bone.
pub(super) fn locate(
    world: &World,
    entity: Entity,
    anchor: &Anchor,
) -> Result<Option<(Entity, Anchor)>, ()> {
    let Anchor::Bone { name, point } = anchor else { return Ok(Some((entity, anchor.clone()))) };
    let Some(parts) = world.get::<BodyParts>(entity) else {
        return if is_yet_to_be_built(world, entity) { Ok(None) } else { Err(()) };
    };
    let named = |part: &Entity| world.get::<Name>(*part).is_some_and(|own| own.as_str() == name);
    let part = parts.iter().find(named).ok_or(())?;
    Ok(Some((part, Anchor::Point(*point))))
}

/// The position of an anchor in the world, metres; `None` while the entity is not built. On independent particles it is the one nearest to `near`, unless the
/// anchor selects particles.
pub(crate) fn anchor_position(
    world: &World,
    entity: Entity,
    anchor: &Anchor,
    near: Vec3,
) -> Result<Option<Vec3>, AttachFault> {
    let missing = |()| AttachFault::NoSuchAnchor;
    let Some((entity, anchor)) = locate(world, entity, anchor).map_err(missing)? else {
        return Ok(None);
    };
    let source = PointSource::of(world, entity).map_err(|()| AttachFault::NoPlace)?;
    let Some(source) = source else { return Ok(None) };
    let place = match &source {
        PointSource::Loose { .. } => {
            source.loose_point(world, entity, &anchor, (near, true)).map(|point| point.place)
        }
        framed => match (framed, framed.local(world, entity, &anchor)) {
            (_, None) => None,
            (PointSource::Frame, Some(local)) => {
                let frame = in_world(world, entity).map_err(|_| AttachFault::NoPlace)?;
                Some(frame.transform_point(local))
            }
            (rigid, Some(local)) => rigid.rigid_point(world, local).map(|point| point.place),
        },
    };
    place.map(Some).ok_or(AttachFault::NoSuchAnchor)
}

/// Whether an entity is a body that has no particles yet.
fn is_yet_to_be_built(world: &World, entity: Entity) -> bool {
    let members = world.get::<BodyParticles>(entity);
    world.get::<ParticleBody>(entity).is_some() && members.is_none_or(RelationshipTarget::is_empty)
}

impl PointSource {
    /// The source of an entity; `None` for a body that is not built yet, and an error for an entity with neither particles nor a transform.
    pub(super) fn of(world: &World, entity: Entity) -> Result<Option<Self>, ()> {
        if world.get::<Particle>(entity).is_some() {
            return Ok(Some(Self::Loose { particles: vec![entity] }));
        }
        if is_yet_to_be_built(world, entity) {
            return Ok(None);
        }
        if let Some(pose) = world.get::<RigidPose>(entity)
            && !pose.particles.is_empty()
            && pose.particles.len() == pose.rest.len()
        {
            let (particles, rest) = (pose.particles.clone(), pose.rest.clone());
            return Ok(Some(Self::Rigid { particles, rest }));
        }
        if let Some(members) = world.get::<BodyParticles>(entity) {
            return Ok(Some(Self::Loose { particles: members.iter().collect() }));
        }
        world.get::<Transform>(entity).map(|_| Some(Self::Frame)).ok_or(())
    }

    /// The points of a body that an anchor selects; empty if the body has no such part.
    pub(super) fn points(&self, world: &World, body: Entity, anchor: &Anchor) -> Vec<Point> {
        match (self, local_point(world, body, anchor)) {
            (Self::Rigid { particles, rest }, Some(point)) => {
                Point::rigid(world, particles, rest, point).into_iter().collect()
            }
            _ => {
                let chosen = self.chosen(world, body, anchor).into_iter();
                chosen.filter_map(|particle| Point::single(world, particle)).collect()
            }
        }
    }

    /// The particles that an anchor selects; empty if the entity has none, or no such part.
    fn chosen(&self, world: &World, entity: Entity, anchor: &Anchor) -> Vec<Entity> {
        let (particles, rest) = match self {
            Self::Frame => return Vec::new(),
            Self::Rigid { particles, rest } => (particles, Some(rest)),
            Self::Loose { particles } => (particles, None),
        };
        let built_at = |i: usize| match rest {
            Some(rest) => Some(rest[i]),
            None => world.get::<RestPlace>(particles[i]).map(|place| place.0),
        };
        let all = 0..particles.len();
        let one = match anchor {
            Anchor::Whole => return particles.clone(),
            Anchor::Vertex(number) => {
                let follow = world.get::<MeshFollow>(entity).map(|follow| &follow.vertices);
                follow.unwrap_or(particles).get(*number as usize)
            }
            Anchor::RopeEnd(end) => world.get::<TubeMesh>(entity).and_then(|rope| match end {
                RopeEnd::First => rope.particles.first(),
                RopeEnd::Last => rope.particles.last(),
            }),
            Anchor::Point(point) => {
                let far = |&i: &usize| built_at(i).map_or(f32::INFINITY, |at| at.distance(*point));
                all.min_by(|a, b| far(a).total_cmp(&far(b))).map(|i| &particles[i])
            }
            anchor => {
                let inside =
                    |&i: &usize| built_at(i).and_then(|at| anchor.contains(at)) == Some(true);
                return all.filter(inside).map(|i| particles[i]).collect();
            }
        };
        one.copied().into_iter().collect()
    }

    /// The position of an anchor in the frame of a rigid body or of a transform; `None` if there is no such anchor, or no frame.
    pub(super) fn local(&self, world: &World, entity: Entity, anchor: &Anchor) -> Option<Vec3> {
        if *anchor == Anchor::Whole {
            return Some(Vec3::ZERO);
        }
        if let Some(point) = local_point(world, entity, anchor) {
            return Some(point);
        }
        let Self::Rigid { particles, rest } = self else { return None };
        let numbers: Vec<Vec3> = self
            .chosen(world, entity, anchor)
            .iter()
            .filter_map(|one| particles.iter().position(|other| other == one))
            .map(|i| rest[i])
            .collect();
        let count = numbers.len() as f32;
        (count > 0.0).then(|| numbers.iter().sum::<Vec3>() / count)
    }

    /// The point of a rigid body at a position in its frame.
    pub(super) fn rigid_point(&self, world: &World, local: Vec3) -> Option<Point> {
        let Self::Rigid { particles, rest } = self else { return None };
        Point::rigid(world, particles, rest, local)
    }

    /// The point of independent particles to which something at `place` is attached: with `snap` the middle of the particles that the anchor selects, otherwise
    /// the same `place` expressed by them. `None` if there is no such anchor.
    pub(super) fn loose_point(
        &self,
        world: &World,
        entity: Entity,
        anchor: &Anchor,
        (place, snap): (Vec3, bool),
    ) -> Option<Point> {
        let Self::Loose { particles } = self else { return None };
        let at = |particle: &Entity| world.get::<Particle>(*particle).map(|p| p.position);
        let among = match anchor {
            // The nearest particle.
            Anchor::Whole => {
                let far = |one: &Entity| at(one).map_or(f32::INFINITY, |at| at.distance(place));
                let nearest = particles.iter().min_by(|a, b| far(a).total_cmp(&far(b)));
                nearest.copied().into_iter().collect()
            }
            anchor => self.chosen(world, entity, anchor),
        };
        let places: Vec<Vec3> = among.iter().map(at).collect::<Option<_>>()?;
        let count = places.len() as f32;
        let middle = places.iter().sum::<Vec3>() / count;
        let weights = affine_weights(&places, if snap { middle } else { place });
        Point::of(world, &among, weights, false)
    }
}

impl Point {
    fn single(world: &World, particle: Entity) -> Option<Self> {
        Self::of(world, &[particle], vec![1.0], false)
    }

    fn rigid(world: &World, particles: &[Entity], rest: &[Vec3], local: Vec3) -> Option<Self> {
        match particles {
            [alone] => Self::single(world, *alone),
            _ => Self::of(world, particles, affine_weights(rest, local), true),
        }
    }

    fn of(world: &World, particles: &[Entity], weights: Vec<f32>, rigid: bool) -> Option<Self> {
        if particles.is_empty() {
            return None;
        }
        let mut place = Vec3::ZERO;
        for (&particle, &weight) in particles.iter().zip(&weights) {
            place += world.get::<Particle>(particle)?.position * weight;
        }
        Some(Self { particles: particles.to_vec(), weights, rigid, place })
    }
}

/// The position that an anchor specifies in the entity's frame; `None` if it selects particles instead.
fn local_point(world: &World, entity: Entity, anchor: &Anchor) -> Option<Vec3> {
    match *anchor {
        Anchor::Point(point) => Some(point),
        Anchor::Corner(signs) => {
            let size = world.get::<BodyPart>(entity)?.size;
            Some(size * 0.5 * signs.map(|sign| if sign == 0.0 { 0.0 } else { sign.signum() }))
        }
        _ => None,
    }
}
