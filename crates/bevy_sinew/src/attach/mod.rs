//! Attachments: they tie a body, or particles of it, to another entity, without the game having to know particle indices.
//!
//! | file | contents |
//! |---|---|
//! | `anchor` | a place on a body where something is attached: [`Anchor`] |
//! | `point_source` | which particles that is, and how they define a point |
//! | `constraint` | the constraint that ties two points: [`AnchorConstraint`] |
//! | `resolve` | once a tick: turns [`AttachTo`] into pins and constraints, as soon as both bodies are built |

mod anchor;
mod constraint;
mod point_source;
pub(crate) mod resolve;

pub use anchor::{Anchor, RopeEnd};
pub use constraint::AnchorConstraint;
pub(crate) use point_source::anchor_position;

use bevy::ecs::entity::MapEntities;
use bevy::ecs::lifecycle::HookContext;
use bevy::ecs::world::DeferredWorld;
use bevy::prelude::*;

use crate::components::{CreationOrder, PinnedTo, Softness};

/// Ties a body, or some of its particles, to another entity: a cape to a back, a rope's end to a hook, a lamp to a bone.
///
/// Put it on the body itself (or on a particle, or on a rigid part). For several attachments of one body, put each on an entity of its own with
/// [`AttachmentOf`] the body. It may be spawned before either side is built: the attachment is made in the first tick in which both are, and again whenever
/// either is rebuilt. It depends on the other entity:
///
/// - **static or kinematic**, moved only by its `Transform` (a collider, a camera, a bone of an animation): the attached particles follow it over the substeps
///   of each tick, as with [`PinnedTo`]. Nothing pulls at the entity;
/// - **simulated** (a body, a rigid part of one, a particle): both sides pull at each other, and momentum is conserved. A rigid body is pulled at the point as
///   a rigid body, at any point in its frame.
///
/// The attached particles keep the position that they have in the other entity's frame when the attachment is made, unless it [snaps](Self::snapped). Cloth,
/// ropes and soft bodies have no frame: there the position is kept relative to the particles that `anchor` selects, or, where these do not determine it, only
/// the distance is kept. Attached entities do not collide with each other.
///
/// The attachment is despawned with its body. If the other entity is despawned, the attachment is released, with one [`Refused`](crate::Refused) message: this
/// component is removed, or the whole entity if the attachment has one of its own. To release it yourself, remove the component. A rigid part of a body is
/// another entity after a rebuild; an [`Anchor::Bone`] of the body finds it again.
///
/// Errors are reported by [`Refused`](crate::Refused) messages with an [`AttachFault`](crate::AttachFault); nothing is attached until they are corrected.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// fn dress(mut commands: Commands) {
///     let hero = commands.spawn(Transform::from_xyz(0.0, 1.0, 0.0)).id();
///     // A cape, held by its upper edge, which stays where it is relative to the hero.
///     let edge = Anchor::InBox { center: Vec3::new(0.0, 0.5, 0.0), half_size: Vec3::new(1.0, 0.01, 0.1) };
///     commands.spawn((Cloth::grid(0.6, 1.0, 12, 20), AttachTo::new(hero).part(edge), Transform::from_xyz(0.0, 1.9, -0.2)));
///     // A lantern of 2 kg that hangs by a corner from the hero's hand.
///     let corner = Anchor::Corner(Vec3::new(1.0, 1.0, 1.0));
///     let hand = Anchor::Point(Vec3::new(0.4, 0.0, 0.2));
///     commands.spawn((RigidBox::new(Vec3::splat(0.2)).with_mass(2.0), AttachTo::new(hero).part(corner).at(hand).snapped()));
/// }
/// # let mut app = App::new();
/// # app.add_plugins((MinimalPlugins, SinewPlugins)).add_systems(Startup, dress);
/// # app.finish();
/// # (0..3).for_each(|_| { std::thread::sleep(core::time::Duration::from_millis(20)); app.update() });
/// # let world = app.world_mut();
/// # assert_eq!(world.query::<&bevy_sinew::Attached>().iter(world).count(), 2);
/// ```
#[derive(Component, MapEntities, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, Clone, PartialEq)]
#[require(CreationOrder)]
#[component(on_remove = on_remove)]
pub struct AttachTo {
    /// The other entity.
    #[entities]
    pub entity: Entity,
    /// Which part of the body is attached. Default all of its particles, one by one.
    pub part: Anchor,
    /// Where on the other entity. Default where the body is when it is attached; on cloth, ropes and soft bodies, the nearest particle.
    pub anchor: Anchor,
    /// Whether the attached part moves to the anchor instead of keeping its position; of several particles, their middle does. Default false.
    pub snap: bool,
    /// How hard the attachment is. Default hard.
    pub softness: Softness,
}

impl AttachTo {
    /// Attaches all of a body to an entity, hard, at its current position.
    pub fn new(entity: Entity) -> Self {
        Self { entity, part: default(), anchor: default(), snap: false, softness: default() }
    }

    /// Returns the same attachment of this part of the body.
    pub fn part(self, part: Anchor) -> Self {
        Self { part, ..self }
    }

    /// Returns the same attachment at an anchor of the other entity.
    pub fn at(self, anchor: Anchor) -> Self {
        Self { anchor, ..self }
    }

    /// Returns the same attachment with [`snap`](Self::snap): the attached part moves to the anchor.
    pub fn snapped(self) -> Self {
        Self { snap: true, ..self }
    }

    /// Returns the same attachment with this softness.
    pub fn with_softness(self, softness: Softness) -> Self {
        Self { softness, ..self }
    }

    /// Returns the same attachment with a compliance, m/N.
    pub fn with_compliance(self, compliance: f32) -> Self {
        self.with_softness(Softness::compliant(compliance))
    }
}

/// Relationship from an [`AttachTo`] on an entity of its own to the body, rigid part or particle that it attaches. The entity is despawned with the body.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::{BodyAttachments, RopeEnd};
/// # use bevy_sinew::prelude::*;
/// # fn spawn(mut commands: Commands, left: Entity, right: Entity) {
/// let first = AttachTo::new(left).part(Anchor::RopeEnd(RopeEnd::First));
/// let last = AttachTo::new(right).part(Anchor::RopeEnd(RopeEnd::Last));
/// commands.spawn((Rope { pin_start: false, ..default() }, related!(BodyAttachments[first, last])));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Component, Clone, PartialEq)]
#[relationship(relationship_target = BodyAttachments)]
pub struct AttachmentOf(#[entities] pub Entity);

/// The attachments of a body that are entities of their own. Kept by Bevy, from [`AttachmentOf`].
#[derive(Component, Reflect, Clone, Debug, Default)]
#[reflect(Component, Default)]
#[relationship_target(relationship = AttachmentOf, linked_spawn)]
pub struct BodyAttachments(Vec<Entity>);

/// Relationship from a constraint, or from a helper particle that follows the other entity, to the [`AttachTo`] that spawned it. It is despawned with the
/// attachment.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Component, Clone, PartialEq)]
#[relationship(relationship_target = AttachmentJoints)]
pub struct JointOf(#[entities] pub Entity);

/// The constraints by which an [`AttachTo`] holds its body, and their helper particles. Empty where it holds particles by [`PinnedTo`].
#[derive(Component, Reflect, Clone, Debug, Default)]
#[reflect(Component, Default)]
#[relationship_target(relationship = JointOf, linked_spawn)]
pub struct AttachmentJoints(Vec<Entity>);

/// Marks an [`AttachTo`] that is in effect, and how it was made. Kept by the plugin; part of the state.
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, Clone, PartialEq)]
// A clone is attached by itself. With a copy of this it would take what its original holds for its own, and release it.
#[component(clone_behavior = Ignore)]
pub struct Attached {
    /// The attached body.
    #[entities]
    pub body: Entity,
    /// The [`AttachTo`] from which the attachment was made.
    #[entities]
    pub to: AttachTo,
    /// How often the body and the other entity had been built ([`BuiltBody`](crate::BuiltBody)); 0 for an entity that is not a body.
    pub builds: [u32; 2],
    /// The position at which each attached point is kept, in the frame of the other entity if it has one.
    pub offsets: Vec<Vec3>,
    /// The particles that it holds by [`PinnedTo`].
    #[entities]
    pub pinned: Vec<Entity>,
}

impl Attached {
    /// Whether the attachment was made from this body and this component.
    fn is_of(&self, body: Entity, to: &AttachTo) -> bool {
        self.body == body && self.to == *to
    }
}

/// Hook: releases what is attached when the component is removed.
fn on_remove(mut world: DeferredWorld, context: HookContext) {
    let attachment = context.entity;
    let Some(attached) = world.get::<Attached>(attachment).cloned() else { return };
    let joints = joints_of(&world, attachment);
    world.commands().queue(move |world: &mut World| {
        release(world, &attached, joints);
        // The component may have been inserted again in the meantime.
        if let Ok(mut entity) = world.get_entity_mut(attachment)
            && !entity.contains::<AttachTo>()
        {
            entity.remove::<Attached>();
        }
    });
}

fn joints_of(world: &World, attachment: Entity) -> Vec<Entity> {
    let joints = world.get::<AttachmentJoints>(attachment).into_iter();
    joints.flat_map(RelationshipTarget::iter).collect()
}

/// Removes what an attachment created: its constraints and its pins.
fn release(world: &mut World, attached: &Attached, joints: Vec<Entity>) {
    for &particle in &attached.pinned {
        if let Ok(mut particle) = world.get_entity_mut(particle)
            && particle.get::<PinnedTo>().is_some_and(|pin| pin.entity == attached.to.entity)
        {
            particle.remove::<PinnedTo>();
        }
    }
    for joint in joints {
        world.try_despawn(joint).ok();
    }
}
