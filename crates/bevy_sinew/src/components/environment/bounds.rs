//! What bounds the space in which things are: a ground and a room, which are colliders by name, and the plane of a world in 2D.

use bevy::prelude::*;

use crate::components::{Collider, CreationOrder};

/// An endless ground: the entity's local xz plane, solid below. It is a [`Collider`], [`Collider::HalfSpace`], by a shorter name: what it is made of
/// ([`SurfaceMaterial`](crate::SurfaceMaterial)), whom it touches ([`CollisionLayers`](crate::CollisionLayers)) and who is told
/// ([`ContactEvents`](crate::ContactEvents)) stands beside it, and it goes where the game moves its `Transform`.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// fn spawn(mut commands: Commands) {
///     commands.spawn((Ground, SurfaceMaterial::new(0.8), Transform::from_xyz(0.0, -1.0, 0.0)));
/// }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(Collider = Collider::HalfSpace, Transform, CreationOrder)]
pub struct Ground;

/// A room that nothing leaves: a box around the entity's origin, turned and scaled as the entity is, and solid all around. It is a [`Collider`],
/// [`Collider::InsideBox`], which follows its size; what else holds for colliders holds for it.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// fn spawn(mut commands: Commands) {
///     let aquarium = BoundingBox { size: Vec3::new(4.0, 2.0, 2.0) };
///     commands.spawn((aquarium, SurfaceMaterial::new(0.1), Transform::from_xyz(0.0, 1.0, 0.0)));
/// }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(Collider = Self::default().collider(), Transform, CreationOrder)]
pub struct BoundingBox {
    /// Lengths of its edges, metres; positive. Default 10.
    pub size: Vec3,
}

impl Default for BoundingBox {
    fn default() -> Self {
        Self { size: Vec3::splat(10.0) }
    }
}

impl BoundingBox {
    /// The collider that it is.
    pub(crate) fn collider(self) -> Collider {
        Collider::InsideBox { size: self.size }
    }
}

/// Makes the world one of two dimensions: all particles stay in the entity's local xy plane, by default the one with z = 0. Only pinned ones are
/// where they are pinned.
///
/// There is one world, and so one plane: of several, the one that was created first and is sound.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::{Flatland};
/// # fn spawn(mut commands: Commands) {
/// commands.spawn(Flatland);
/// commands.spawn((RigidBox { flat: true, ..default() }, Transform::from_xyz(0.0, 2.0, 0.0)));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(Transform, CreationOrder)]
pub struct Flatland;
