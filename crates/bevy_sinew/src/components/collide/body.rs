//! How bodies take part in contacts.

use bevy::prelude::*;

/// How a body takes part in contacts, where that is not as by default: a loose particle is a body of its own.
///
/// Without it a body touches all colliders and all other bodies, by what holds for it
/// ([`ContactShape::Auto`]), and not itself; a [`Ragdoll`](crate::Ragdoll) and an [`Articulated`](crate::Articulated) body have
/// [`BodyContacts::ALL`], because their limbs touch each other, unless they are spawned with another one. Two bodies that a constraint joins do not touch
/// each other; neither do a body and what it is [pinned to](crate::PinnedTo), or a collider that is a child of it; nor a single particle and what it is
/// tied to, directly or through others.
///
/// [`SurfaceMaterial`](super::SurfaceMaterial) and [`CollisionLayers`](super::CollisionLayers) on the body say what it is made of and what it may touch;
/// [`ContactsDisabled`] takes it out of all contacts. Particles collide as balls of their [`Radius`](crate::Radius); those without one touch colliders as
/// points, and no other body.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::BodyContacts;
/// # use bevy_sinew::prelude::*;
/// # fn spawn(mut commands: Commands) {
/// // Folds onto itself.
/// commands.spawn((Cloth::grid(1.0, 1.0, 20, 20), BodyContacts::ALL));
/// // Meets what stands, and no other body.
/// let ghost = BodyContacts { with_bodies: false, ..default() };
/// commands.spawn((RigidBox::default(), ghost));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct BodyContacts {
    /// Whether it touches other bodies, if those touch others, too. Default so.
    pub with_bodies: bool,
    /// Whether it touches itself, so that cloth does not pass through itself: particles keep as far apart as their radii ask for, or as they are in the
    /// rest shape ([`RestPlace`]) if that is less; rigid parts touch unless a joint connects them or they overlap in the rest shape. Default not.
    pub with_itself: bool,
    /// What of it touches others. Default [`ContactShape::Auto`].
    pub shape: ContactShape,
}

/// Takes a body, a loose particle or a [`Collider`](super::Collider) out of all contacts: it passes through everything, and everything through it, rays too.
/// To have it pass through some things alone there are [`CollisionLayers`](super::CollisionLayers), and through other bodies alone
/// [`BodyContacts::with_bodies`].
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::ContactsDisabled;
/// # use bevy_sinew::prelude::*;
/// fn open(mut commands: Commands, doors: Query<Entity, With<Collider>>) {
///     for door in &doors {
///         commands.entity(door).insert(ContactsDisabled);
///     }
/// }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct ContactsDisabled;

/// What of a body touches others.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
#[non_exhaustive]
pub enum ContactShape {
    /// What lets nothing through at the least cost. The default:
    ///
    /// - its rigid parts if it has any with a [`Collider`](super::Collider): a box, a solid, the limbs of a ragdoll;
    /// - otherwise its particles, if those are large enough to close its surface or its chain;
    /// - otherwise its [triangles](Self::Triangles) if it has some, such as cloth and soft bodies;
    /// - otherwise its [segments](Self::Segments) if it is a chain of rods, such as a rope.
    ///
    /// Particles close a surface where no place of a triangle is farther from its nearest corner than twice their [`Radius`](crate::Radius) in the rest
    /// shape: from 0.29 of the edges of equilateral triangles on, and from 0.354 of the spacing of a square grid. They close a chain where it is half of the
    /// longest rod. (For a surface that is known by [`RestPlace`]s, which recipes put on every particle.)
    #[default]
    Auto,
    /// Its particles, each a ball of its [`Radius`](crate::Radius).
    Particles,
    /// Its rigid parts, by their [`Collider`](super::Collider)s; the particles of those touch nothing by themselves. A body that has none is refused
    /// ([`Refusal::NotSolid`](crate::Refusal::NotSolid)) and collides by its particles.
    Solid,
    /// The triangles of its [`WindSurface`](crate::WindSurface) (which `Cloth` and `SoftBody` bring along) besides its particles: nothing passes
    /// through its mesh, from either side, however coarse that is and however fast it comes. Particles of others touch them, and its own if it
    /// touches itself; edges touch the edges of bodies that ask for the same. They are as thick as the particles' [`Radius`](crate::Radius), and may
    /// be without. It is the finer tier, and some ten times as dear. [`Collider`](super::Collider)s and solids touch the particles alone. A body that
    /// has none is refused ([`Refusal::NoTriangles`](crate::Refusal::NoTriangles)) and collides by its particles.
    Triangles,
    /// Its segments: each [`DistanceConstraint`](crate::DistanceConstraint) between two of its particles that is a rod or a tether
    /// ([`Bound::Equal`](crate::Bound), [`Bound::AtMost`](crate::Bound)) is a capsule from one to the other, as thick as the
    /// [`Radius`](crate::Radius) of the thinner end, and the particles at its ends touch nothing by themselves. For ropes whose particles are further
    /// apart than they are thick, where posts, rails, edges of boxes or other ropes would pass between two of them. It costs half as much again as
    /// particles do for ropes side by side, and some five times as much in a tangle, touches all that solids touch, and friction holds without
    /// creeping. A constraint that is despawned takes its capsule along. Where the body touches itself, those do not touch that overlap in its rest
    /// shape ([`RestPlace`]), so that a rope may be thicker than its segments are long. What hangs on an end is to be tied by more than both are
    /// thick there, or kept from touching the rope by [`CollisionLayers`](super::CollisionLayers); how much a light rope bears is a matter of
    /// substeps ([`sinew::recipes::Blueprint::with_segments`]). A body without any segment is refused
    /// ([`Refusal::NoSegments`](crate::Refusal::NoSegments)) and collides by its particles.
    Segments,
}

impl Default for BodyContacts {
    fn default() -> Self {
        Self { with_bodies: true, with_itself: false, shape: ContactShape::Auto }
    }
}

impl BodyContacts {
    /// With other bodies and with itself: for cloth and ropes.
    pub const ALL: Self = Self { with_bodies: true, with_itself: true, shape: ContactShape::Auto };

    /// The same touching itself, too.
    pub fn and_itself(self) -> Self {
        Self { with_itself: true, ..self }
    }

    /// The same touching by another shape.
    pub fn shaped(self, shape: ContactShape) -> Self {
        Self { shape, ..self }
    }
}

/// Where a particle is in the rest shape of its body, metres, in any coordinates that are the same for all of the body: particles of one body that
/// touch each other ([`BodyContacts::with_itself`]) may come as near as they are there. Recipes put it on every particle; without it a particle keeps
/// off by its radius.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct RestPlace(pub Vec3);

/// What [`ContactShape::Auto`] comes to for a body. Scratch: found again where what it follows from has changed.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
#[component(clone_behavior = Ignore)]
pub(crate) struct ResolvedShape {
    /// Particles, triangles or segments. Rigid parts come first, and are asked for elsewhere.
    pub(crate) shape: ContactShape,
    /// The layout, and the least radius of its particles, that it was found for.
    pub(crate) layout: u64,
    pub(crate) radius: f32,
}
