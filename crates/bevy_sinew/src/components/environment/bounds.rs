//! The surfaces that bound the space in which particles are.

use bevy::prelude::*;

use crate::components::CreationOrder;

/// An endless plane that no particle sinks under: the entity's local xz plane, solid below.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(Transform, CreationOrder)]
pub struct Ground {
    /// Coulomb's coefficient of friction μ, 0 and up. Default 0.5.
    pub friction: f32,
    /// Which part of its speed of approach a thing bounces back with, 0 to 1. Default 0.
    pub restitution: f32,
}

impl Default for Ground {
    fn default() -> Self {
        Self { friction: 0.5, restitution: 0.0 }
    }
}

/// The lectures' friction, beside a [`Ground`] on the same entity: a drag of its own along the ground and across it, for what touches it.
///
/// Coulomb's friction, [`Ground::friction`], acts besides: set that to 0 to have this alone.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct GroundDrag {
    /// Share of the velocity along the ground that is lost per second, 0 to 1. Default 0.
    pub along: f32,
    /// Share of the velocity towards it or away that is lost per second, 0 to 1. Default 0.
    pub across: f32,
}

/// A room that no particle leaves: a box around the entity's position, its walls along the world's axes, scaled as the entity is.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(Transform, CreationOrder)]
pub struct BoundingBox {
    /// Lengths of its edges, metres. Default 10.
    pub size: Vec3,
    /// Coulomb's coefficient of friction μ on its walls, 0 and up. Default 0.5.
    pub friction: f32,
    /// Which part of its speed of approach a thing bounces back from a wall with, 0 to 1. Default 0.
    pub restitution: f32,
}

impl Default for BoundingBox {
    fn default() -> Self {
        Self { size: Vec3::splat(10.0), friction: 0.5, restitution: 0.0 }
    }
}

/// Makes the world one of two dimensions: all particles stay in the entity's local xy plane, by default the one with z = 0. Only pinned ones are
/// where they are pinned.
///
/// There is one world, and so one plane: of several, the one that was created first and is sound.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(Transform, CreationOrder)]
pub struct Flatland;
