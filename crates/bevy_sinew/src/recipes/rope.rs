//! Ropes: chains of particles, drawn as tubes.

use bevy::ecs::entity::MapEntities;
use bevy::ecs::relationship::RelationshipTarget;
use bevy::prelude::*;
use sinew::recipes::{Blueprint, RopeSpec, rope};

use super::bind::attach;
use super::build::{MeshShape, Recipe};
use crate::attach::{Anchor, AttachTo, AttachmentOf, BodyAttachments, RopeEnd, anchor_position};
use crate::components::{Bound, CreationOrder, ParticleBody, TubeMesh};
use crate::frames::{even_factor, in_world};
use crate::messages::Refusal;

/// A rope: a chain of particles, drawn as a tube. It collides by its segments, each a capsule between two particles
/// ([`ContactShape::Auto`](crate::ContactShape)).
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # fn spawn(mut commands: Commands) {
/// // A rope that hangs from its start, 10 % longer than the distance between its ends.
/// let rope = Rope { pin_start: true, ..Rope::between(Vec3::ZERO, Vec3::X * 2.0) };
/// commands.spawn((rope.with_slack(0.1), Transform::from_xyz(0.0, 3.0, 0.0)));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(ParticleBody, CreationOrder)]
pub struct Rope {
    /// The start, metres, in the body's own frame. Default the origin.
    pub from: Vec3,
    /// The end, metres. Default 1 m below the origin.
    pub to: Vec3,
    /// Number of segments, 1 or more. Default 20.
    pub segments: u32,
    /// Mass of the whole rope, kg. Default 0.1.
    pub mass: f32,
    /// Radius, metres. Default 0.01.
    pub radius: f32,
    /// Excess length over the distance between its ends, as a fraction of that distance. Default 0.
    pub slack: f32,
    /// In which direction each segment keeps its length. Default [`Bound::Equal`].
    pub bound: Bound,
    /// Compliance of each segment, m/N. Default 0: the rope does not stretch.
    pub compliance: f32,
    /// Whether its start is pinned. Default true.
    pub pin_start: bool,
    /// Whether its end is pinned. Default false.
    pub pin_end: bool,
    /// The entity to which its start is tied. The rope then starts there instead of at `from`, and its start is not pinned otherwise. Default none.
    #[entities]
    pub start: Option<RopeTie>,
    /// The entity to which its end is tied, instead of `to` and `pin_end`. Default none.
    #[entities]
    pub end: Option<RopeTie>,
}

/// What an end of a [`Rope`] is tied to. The rope is built as soon as that entity is, with an [`AttachTo`](crate::AttachTo) that holds the end.
#[derive(Reflect, MapEntities, Clone, Debug, PartialEq)]
#[reflect(Clone, PartialEq)]
pub struct RopeTie {
    /// The entity.
    #[entities]
    pub entity: Entity,
    /// The place on it. Default its origin; on cloth, ropes and soft bodies, the particle that is nearest to the origin of the rope's own frame.
    pub anchor: Anchor,
}

/// An end of a [`Rope`]: a position in its own frame, metres, or the entity to which it is tied.
#[derive(Clone, Debug, PartialEq)]
pub enum RopePoint {
    /// A position, metres.
    At(Vec3),
    /// An entity, and a place on it.
    Tied(RopeTie),
}

impl From<Vec3> for RopePoint {
    fn from(place: Vec3) -> Self {
        Self::At(place)
    }
}

impl From<Entity> for RopePoint {
    fn from(entity: Entity) -> Self {
        Self::Tied(RopeTie { entity, anchor: Anchor::Whole })
    }
}

impl From<(Entity, Anchor)> for RopePoint {
    fn from((entity, anchor): (Entity, Anchor)) -> Self {
        Self::Tied(RopeTie { entity, anchor })
    }
}

impl From<(Entity, Vec3)> for RopePoint {
    fn from((entity, point): (Entity, Vec3)) -> Self {
        Self::Tied(RopeTie { entity, anchor: Anchor::Point(point) })
    }
}

impl Default for Rope {
    fn default() -> Self {
        let spec = RopeSpec::default();
        Self {
            from: spec.from,
            to: spec.to,
            segments: spec.segments,
            mass: spec.mass,
            radius: spec.radius,
            slack: spec.slack,
            bound: spec.bound.into(),
            compliance: spec.compliance,
            pin_start: true,
            pin_end: false,
            start: None,
            end: None,
        }
    }
}

impl Rope {
    /// A rope between two ends. Each is a position in the rope's own frame, metres, or an entity, or an entity with a point or an [`Anchor`] of it. The start
    /// is pinned if it is a position, the end is not; an end at an entity is tied to it.
    ///
    /// ```
    /// # use bevy::prelude::*;
    /// # use bevy_sinew::prelude::*;
    /// # fn spawn(mut commands: Commands) {
    /// let hook = commands.spawn(Transform::from_xyz(0.0, 3.0, 0.0)).id();
    /// let crate_ = commands.spawn((RigidBox::new(Vec3::splat(0.4)), Transform::from_xyz(0.0, 1.5, 0.0))).id();
    /// // From the hook to the middle of the crate's lid, 5 % longer than that distance.
    /// let lid = Anchor::Corner(Vec3::Y);
    /// commands.spawn(Rope::between(hook, (crate_, lid)).with_slack(0.05));
    /// # }
    /// ```
    pub fn between(from: impl Into<RopePoint>, to: impl Into<RopePoint>) -> Self {
        let mut rope = Self::default();
        match from.into() {
            RopePoint::At(place) => rope.from = place,
            RopePoint::Tied(tie) => rope.start = Some(tie),
        }
        match to.into() {
            RopePoint::At(place) => rope.to = place,
            RopePoint::Tied(tie) => rope.end = Some(tie),
        }
        rope
    }

    /// Returns the same rope with slack, as a fraction of the distance between its ends.
    pub fn with_slack(self, slack: f32) -> Self {
        Self { slack, ..self }
    }

    /// Ties or unties an end: updates or removes the attachment of an earlier build, or spawns one.
    fn tie(world: &mut World, body: Entity, tie: Option<&RopeTie>, end: RopeEnd) {
        let all = world.get::<BodyAttachments>(body);
        let known = all.into_iter().flat_map(RelationshipTarget::iter).find_map(|attachment| {
            let tied = world.get::<TiedEnd>(attachment).is_some_and(|tied| tied.0 == end);
            world.get::<AttachTo>(attachment).filter(|_| tied).map(|own| (attachment, own.clone()))
        });
        let wanted = tie.cloned().map(|RopeTie { entity, anchor }| {
            AttachTo::new(entity).part(Anchor::RopeEnd(end)).at(anchor).snapped()
        });
        match (known, wanted) {
            // The game's softness is kept.
            (Some((attachment, own)), Some(wanted)) => {
                let wanted = AttachTo { softness: own.softness, ..wanted };
                if own != wanted {
                    attach(world, attachment, wanted);
                }
            }
            (None, Some(wanted)) => drop(world.spawn((wanted, TiedEnd(end), AttachmentOf(body)))),
            // An attachment to an entity that is gone is released later in the tick, with a message.
            (Some((attachment, own)), None) if world.get_entity(own.entity).is_ok() => {
                world.despawn(attachment);
            }
            _ => {}
        }
    }
}

/// Marks an attachment that a [`Rope`] spawned for one of its ends, which a rebuild updates; any other attachment of the end belongs to the game. Part of the
/// state.
#[derive(Component, Reflect, Clone, Copy, Debug)]
#[reflect(Component, Clone)]
pub(crate) struct TiedEnd(RopeEnd);

impl Recipe for Rope {
    fn located(&self, world: &World, body: Entity) -> Result<Option<Self>, Refusal> {
        let mut rope = self.clone();
        if self.start.is_none() && self.end.is_none() {
            return Ok(Some(rope));
        }
        let frame = in_world(world, body)?;
        let back = frame.compute_affine().inverse();
        let ends = [(&mut rope.start, &mut rope.from), (&mut rope.end, &mut rope.to)];
        for (tie, place) in ends {
            // A tie to an entity that is gone is dropped; the rope is built without it.
            tie.take_if(|tie| world.get_entity(tie.entity).is_err());
            let Some(RopeTie { entity, anchor }) = tie else { continue };
            let found = anchor_position(world, *entity, anchor, frame.translation);
            match found.map_err(Refusal::Attach)? {
                Some(found) => *place = back.transform_point3(found),
                None => return Ok(None),
            }
        }
        rope.pin_start &= rope.start.is_none();
        rope.pin_end &= rope.end.is_none();
        Ok(Some(rope))
    }

    fn blueprint(&self, _: Option<&MeshShape>, scale: Vec3) -> Result<Blueprint, Refusal> {
        let spec = RopeSpec {
            from: self.from * scale,
            to: self.to * scale,
            segments: self.segments,
            mass: self.mass,
            radius: self.radius * even_factor(scale)?,
            slack: self.slack,
            bound: self.bound.into(),
            compliance: self.compliance,
            pin_start: self.pin_start,
            pin_end: self.pin_end,
            ..default()
        };
        Ok(rope(&spec)?)
    }

    fn finish(&self, world: &mut World, body: Entity, _: &Blueprint, particles: &[Entity]) {
        let tube = TubeMesh { particles: particles.to_vec(), radius: self.radius, ..default() };
        attach(world, body, tube);
        Self::tie(world, body, self.start.as_ref(), RopeEnd::First);
        Self::tie(world, body, self.end.as_ref(), RopeEnd::Last);
    }
}
