//! Attachments: what ties particles of a body to something else, by what both are and not by numbers that a game would have to guess.
//!
//! | file | what it holds |
//! |---|---|
//! | `anchor` | where on a body something is tied: [`Anchor`] |
//! | `carrier` | which particles that is, and how they carry a point |
//! | `constraint` | the constraint that ties two points: [`AnchorConstraint`] |
//! | `resolve` | once a tick: from [`AttachTo`] to pins and constraints, as soon as both bodies are built |

mod anchor;
mod carrier;
mod constraint;
pub(crate) mod resolve;

pub use anchor::{Anchor, RopeEnd};
pub(crate) use carrier::place_of;
pub use constraint::AnchorConstraint;

use bevy::ecs::entity::MapEntities;
use bevy::ecs::lifecycle::HookContext;
use bevy::ecs::world::DeferredWorld;
use bevy::prelude::*;

use crate::components::{CreationOrder, PinnedTo, Softness};

/// Ties a body, or some of its particles, to another entity: a cape to a back, a rope's end to a hook, a lamp to a bone.
///
/// It stands on the body itself (or on a particle, or on a rigid part); so that a body may have several, it may stand on an entity of its own with
/// [`AttachmentOf`] the body. It may be spawned before either is built: it takes hold in the first tick in which both are, and again when either is built
/// anew. What the other entity is decides what happens:
///
/// - **one that stands, or that the game moves** by its `Transform` (a collider, a camera, a bone of an animation): what is tied is led along, over the
///   substeps of each tick, as by [`PinnedTo`]. Nothing pulls at the entity;
/// - **one that is simulated** (a body, a rigid part of one, a particle): both pull, and momentum is kept. A rigid body is pulled at the point as the rigid
///   body that it is, at any point in its frame.
///
/// What is tied keeps the place that it has in the other's frame when it is attached, unless it is to [snap](Self::snapped). Cloth, ropes and soft bodies
/// have no frame: there it keeps its place among the particles that the `anchor` chooses, or its distance where these cannot say that. What is joined does
/// not collide.
///
/// It goes with its body. Where the other entity goes, it lets go, with one [`Refused`](crate::Refused) message: this component is removed, and so is the
/// entity if it is one of its own. To let go, remove the component. A rigid part of a body that is built anew is another entity then; an
/// [`Anchor::Bone`] of the body finds it again.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// fn dress(mut commands: Commands) {
///     let hero = commands.spawn(Transform::from_xyz(0.0, 1.0, 0.0)).id();
///     // A cape, held by its upper edge where that is, 1.4 m up.
///     let edge = Anchor::InBox { center: Vec3::new(0.0, 0.5, 0.0), half_size: Vec3::new(1.0, 0.01, 0.1) };
///     commands.spawn((Cloth::grid(0.6, 1.0, 12, 20), AttachTo::new(hero).part(edge), Transform::from_xyz(0.0, 1.9, -0.2)));
///     // A lantern of 2 kg that hangs by a corner at the hero's hand.
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
#[component(on_remove = let_go)]
pub struct AttachTo {
    /// To whom.
    #[entities]
    pub entity: Entity,
    /// What of the body is tied. Default all of its particles, one by one.
    pub part: Anchor,
    /// Where on the other entity. Default wherever the body is when it is attached; of cloth, ropes and soft bodies, by the nearest particle.
    pub anchor: Anchor,
    /// Whether what is tied goes to the anchor instead of keeping its place: its middle does, where it is several particles. Default not.
    pub snap: bool,
    /// How hard it is. Default hard.
    pub softness: Softness,
}

impl AttachTo {
    /// All of a body to an entity, hard, where it is.
    pub fn new(entity: Entity) -> Self {
        Self { entity, part: default(), anchor: default(), snap: false, softness: default() }
    }

    /// The same with some of the body.
    pub fn part(self, part: Anchor) -> Self {
        Self { part, ..self }
    }

    /// The same at an anchor of the other entity.
    pub fn at(self, anchor: Anchor) -> Self {
        Self { anchor, ..self }
    }

    /// The same, but what is tied goes to the anchor.
    pub fn snapped(self) -> Self {
        Self { snap: true, ..self }
    }

    /// The same, as hard as that.
    pub fn with_softness(self, softness: Softness) -> Self {
        Self { softness, ..self }
    }

    /// The same with a compliance, m/N.
    pub fn with_compliance(self, compliance: f32) -> Self {
        self.with_softness(Softness::compliant(compliance))
    }
}

/// Says whose attachment an [`AttachTo`] on an entity of its own is: the body, rigid part or particle that it ties. It goes when that goes.
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

/// The attachments of a body that are entities of their own.
#[derive(Component, Reflect, Clone, Debug, Default)]
#[reflect(Component, Default)]
#[relationship_target(relationship = AttachmentOf, linked_spawn)]
pub struct BodyAttachments(Vec<Entity>);

/// Says to which [`AttachTo`] a constraint, or a particle that a hand leads, belongs: it goes with it.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Component, Clone, PartialEq)]
#[relationship(relationship_target = AttachmentJoints)]
pub struct JointOf(#[entities] pub Entity);

/// The constraints by which an [`AttachTo`] holds what it ties, and the particles that it leads; none where it holds particles by [`PinnedTo`].
#[derive(Component, Reflect, Clone, Debug, Default)]
#[reflect(Component, Default)]
#[relationship_target(relationship = JointOf, linked_spawn)]
pub struct AttachmentJoints(Vec<Entity>);

/// An [`AttachTo`] that has taken hold, and how. Kept by the plugin; part of the state.
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, Clone, PartialEq)]
pub struct Attached {
    /// The body.
    #[entities]
    pub body: Entity,
    /// What it was when it took hold.
    #[entities]
    pub to: AttachTo,
    /// How often the body and the other entity had been built ([`BuiltBody`](crate::BuiltBody)); 0 of one that is no body.
    pub builds: [u32; 2],
    /// Where each tied point is kept, in the frame of the other entity if it has one.
    pub offsets: Vec<Vec3>,
    /// The particles that it holds by [`PinnedTo`].
    #[entities]
    pub pinned: Vec<Entity>,
}

impl Attached {
    /// Whether it took hold as this one.
    fn is_of(&self, body: Entity, to: &AttachTo) -> bool {
        self.body == body && self.to == *to
    }
}

/// Lets go of what is tied when the component goes.
fn let_go(mut world: DeferredWorld, context: HookContext) {
    let attachment = context.entity;
    let Some(attached) = world.get::<Attached>(attachment).cloned() else { return };
    let joints = world.get::<AttachmentJoints>(attachment);
    let joints: Vec<Entity> = joints.map(|all| all.iter().collect()).unwrap_or_default();
    world.commands().queue(move |world: &mut World| {
        release(world, &attached, joints);
        // Another one may have come in its place meanwhile.
        if let Ok(mut entity) = world.get_entity_mut(attachment)
            && !entity.contains::<AttachTo>()
        {
            entity.remove::<Attached>();
        }
    });
}

/// Takes away what an attachment made: its joints, and its pins.
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
