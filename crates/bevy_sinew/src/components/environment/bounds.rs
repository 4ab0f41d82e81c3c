//! What bounds space: the ground and a closed room, which are colliders, and the plane of a 2D world.

use bevy::prelude::*;

use crate::components::{Collider, CreationOrder};

/// An infinite ground: the entity's local xz plane, solid below. It is a shorthand for the [`Collider`] [`Collider::HalfSpace`]:
/// [`SurfaceMaterial`](crate::SurfaceMaterial), [`CollisionLayers`](crate::CollisionLayers) and [`ContactEvents`](crate::ContactEvents) on the same entity
/// configure it, and it moves with the entity's `Transform`.
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

/// A closed room: the inside of a box around the entity's origin, turned and scaled as the entity is. It is a shorthand for the [`Collider`]
/// [`Collider::InsideBox`], which follows its size; everything else applies as to any collider.
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
    /// Edge lengths, metres; positive. Default 10.
    pub size: Vec3,
}

impl Default for BoundingBox {
    fn default() -> Self {
        Self { size: Vec3::splat(10.0) }
    }
}

impl BoundingBox {
    /// The collider of this size.
    pub(crate) fn collider(self) -> Collider {
        Collider::InsideBox { size: self.size }
    }
}

/// Makes the world two-dimensional: all particles stay in the entity's local xy plane, by default the plane z = 0. Only pinned particles may be outside of it.
/// Its rigid bodies must be flat (`RigidBox { flat: true, .. }`), since the rods of any other one contradict the plane: a body that is not is refused when it is
/// to be built ([`Refusal::NotFlat`](crate::Refusal::NotFlat)). Ropes, cloth, soft bodies and loose particles are flattened. Spawn the `Flatland` before or with
/// the first bodies: one that is built already stays, and flies away if it is not flat.
///
/// There is one world, and so one plane: of several entities, the valid one that was created first.
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
