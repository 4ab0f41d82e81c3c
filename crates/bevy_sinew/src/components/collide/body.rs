//! How bodies take part in contacts.

use bevy::prelude::*;

/// Overrides how a body takes part in contacts. A loose particle counts as a body of its own.
///
/// Without it a body collides with all colliders and all other bodies, by the shape that [`ContactShape::Auto`] selects, and not with itself. A
/// [`Ragdoll`](crate::Ragdoll) and an [`Articulated`](crate::Articulated) body are given [`BodyContacts::ALL`], because their limbs collide with each other,
/// unless they are spawned with another one. The following pairs never collide: two bodies that a constraint joins; a body and what it is [pinned
/// to](crate::PinnedTo); a body and a collider that is a child of it; a single particle and what it is tied to, directly or through others.
///
/// [`SurfaceMaterial`](super::SurfaceMaterial) and [`CollisionLayers`](super::CollisionLayers) on the body define its friction and restitution, and what it
/// collides with; [`ContactsDisabled`] switches its contacts off. Particles collide as balls of their [`Radius`](crate::Radius); particles without a radius
/// collide with colliders as points, and with no other body.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::BodyContacts;
/// # use bevy_sinew::prelude::*;
/// # fn spawn(mut commands: Commands) {
/// // Cloth that does not pass through itself.
/// commands.spawn((Cloth::grid(1.0, 1.0, 20, 20), BodyContacts::ALL));
/// // A box that collides with colliders only, not with other bodies.
/// let ghost = BodyContacts { with_bodies: false, ..default() };
/// commands.spawn((RigidBox::default(), ghost));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct BodyContacts {
    /// Whether it collides with other bodies, if those collide with others, too. Default true.
    pub with_bodies: bool,
    /// Whether it collides with itself, so that cloth does not pass through itself. Particles keep the distance of their radii, or that of the rest shape
    /// ([`RestPlace`]) if it is less; rigid parts collide unless a joint connects them or they overlap in the rest shape. Default false.
    pub with_itself: bool,
    /// The shape by which it collides. Default [`ContactShape::Auto`].
    pub shape: ContactShape,
}

/// Switches off all contacts of a body, a loose particle or a [`Collider`](super::Collider): it passes through everything, and queries do not hit it. To ignore
/// only some entities use [`CollisionLayers`](super::CollisionLayers); to ignore only other bodies, [`BodyContacts::with_bodies`].
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

/// The representation of a body by which it collides.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
#[non_exhaustive]
pub enum ContactShape {
    /// The cheapest representation that has no holes. The default. It is the first of these that applies:
    ///
    /// - the body's rigid parts, if any of them has a [`Collider`](super::Collider): a box, a solid, the limbs of a ragdoll;
    /// - its particles, if they are large enough to close its surface or its chain;
    /// - its [triangles](Self::Triangles), if it has any, as cloth and soft bodies do;
    /// - its [segments](Self::Segments), if it is a chain of rods, such as a rope;
    /// - its particles.
    ///
    /// Particles close a surface if no point of a triangle is farther from the nearest corner than twice their [`Radius`](crate::Radius) in the rest shape: the
    /// radius must be at least 0.29 of the edges of equilateral triangles, or 0.354 of the spacing of a square grid. They close a chain if the radius is half
    /// of the longest rod. (This needs a surface whose particles have a [`RestPlace`], which recipes add to every particle.)
    #[default]
    Auto,
    /// The body's particles, each a ball of its [`Radius`](crate::Radius).
    Particles,
    /// The body's rigid parts, by their [`Collider`](super::Collider)s; their particles do not collide by themselves. A body without such a part is refused
    /// ([`Refusal::NotSolid`](crate::Refusal::NotSolid)) and collides by its particles.
    Solid,
    /// The triangles of the body's [`WindSurface`](crate::WindSurface), which `Cloth` and `SoftBody` have, in addition to its particles: nothing passes through
    /// its mesh, from either side, however coarse the mesh and however fast the motion. Triangles collide with particles of other bodies, and with its own if
    /// the body collides with itself; edges collide with the edges of bodies that use triangles, too. Posts, corners, edges and small bodies that fit in
    /// between its particles, those of meshes and heightfields included, collide with what is there. The surface is as thick as the particles'
    /// [`Radius`](crate::Radius), which may be zero (rigid bodies then pass through it); what is sharp comes somewhat closer. Among particles it costs about
    /// ten times as much as particles. A body without triangles is refused ([`Refusal::NoTriangles`](crate::Refusal::NoTriangles)) and collides by its particles.
    Triangles,
    /// The body's segments: each [`DistanceConstraint`](crate::DistanceConstraint) between two of its particles that is a rod or a tether
    /// ([`Bound::Equal`](crate::Bound), [`Bound::AtMost`](crate::Bound)) is a capsule between them, as thick as the [`Radius`](crate::Radius) of the thinner
    /// end; the particles at its ends do not collide by themselves.
    ///
    /// For ropes whose particles are farther apart than they are thick, where posts, rails, edges of boxes or other ropes would pass between two of them.
    /// Segments collide with everything that rigid bodies collide with, and friction holds them without creep. They cost half as much again as particles for
    /// ropes side by side, and about five times as much in a tangle. Despawning a constraint removes its capsule.
    ///
    /// If the body collides with itself, segments that overlap in its rest shape ([`RestPlace`]) do not collide, so that a rope may be thicker than its
    /// segments are long. A body that hangs on an end should be attached at a distance greater than the thickness of both there, or be kept from colliding with
    /// the rope by [`CollisionLayers`](super::CollisionLayers). How much load a light rope carries depends on the number of substeps
    /// ([`sinew::recipes::Blueprint::with_segments`]). A body without any segment is refused ([`Refusal::NoSegments`](crate::Refusal::NoSegments)) and collides
    /// by its particles.
    Segments,
}

impl Default for BodyContacts {
    fn default() -> Self {
        Self { with_bodies: true, with_itself: false, shape: ContactShape::Auto }
    }
}

impl BodyContacts {
    /// Collides with other bodies and with itself: for cloth and ropes.
    pub const ALL: Self = Self { with_bodies: true, with_itself: true, shape: ContactShape::Auto };

    /// Returns the same settings with collisions with itself.
    pub fn and_itself(self) -> Self {
        Self { with_itself: true, ..self }
    }

    /// Returns the same settings with another shape.
    pub fn shaped(self, shape: ContactShape) -> Self {
        Self { shape, ..self }
    }
}

/// A particle's position in the rest shape of its body, metres, in any coordinate system that is common to the body. If the body collides with itself
/// ([`BodyContacts::with_itself`]), two of its particles may come as close as they are in the rest shape. Recipes add it to every particle; without it, a
/// particle keeps the distance of its radius.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct RestPlace(pub Vec3);

/// The shape that [`ContactShape::Auto`] selects for a body. Scratch: computed again when what it depends on has changed.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
#[component(clone_behavior = Ignore)]
pub(crate) struct ResolvedShape {
    /// Particles, triangles or segments. Rigid parts take precedence, and are determined elsewhere.
    pub(crate) shape: ContactShape,
    /// The layout and the smallest radius of the body's particles for which it was computed.
    pub(crate) layout: u64,
    pub(crate) radius: f32,
}
