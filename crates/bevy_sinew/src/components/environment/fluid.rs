//! Fluids, and bodies that float in them by their own shape.

use bevy::prelude::*;

use crate::components::CreationOrder;
use crate::same::same_fields;

/// A fluid that fills the half-space below the entity's local xz plane, or the part of it that is in the [`Region`](super::Region) on the same entity.
///
/// Particles with a [`Radius`](crate::Radius) float in it as balls, and bodies with [`Floats`] by their shape. For a pool, add a
/// [`Region::boxed`](super::Region::boxed) twice as high as the pool is deep: the part above the surface is not filled.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # fn spawn(mut commands: Commands) {
/// // A river: its surface is at the height of the entity.
/// commands.spawn((Fluid::flowing(Vec3::X * 2.0), Transform::from_xyz(0.0, 1.0, 0.0)));
/// commands.spawn((RigidBox::default(), Floats::default(), Transform::from_xyz(0.0, 2.0, 0.0)));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(Transform, CreationOrder)]
pub struct Fluid {
    /// Density, kg/m³. Default 1000, water.
    pub density: f32,
    /// Fraction of its velocity relative to the current that a submerged particle loses per second, 0 to 1. Default 0.8.
    pub drag: f32,
    /// Velocity of the fluid in the world, m/s; the drag is relative to it. Default zero.
    pub current: Vec3,
}

impl Default for Fluid {
    fn default() -> Self {
        sinew::Fluid::water(0.0).into()
    }
}

impl Fluid {
    /// Water that flows at `current`, m/s.
    pub fn flowing(current: Vec3) -> Self {
        Self { current, ..default() }
    }
}

same_fields!(Fluid, sinew::Fluid { density, drag, current } other {
    up: Vec3::Y, level: 0.0, region: sinew::Region::EVERYWHERE
});

/// Makes a body float by its own shape, instead of as the balls of its particles: a crate, a raft, a boat.
///
/// Put it on the body. Buoyancy is the pressure on the hull below the surface, so that the body floats as deep as its mass requires, and rights itself or
/// capsizes as its shape does. A hull that is open, like that of a boat, keeps the water out, and counts as closed by a deck when its rim is submerged.
///
/// A body without a hull, or without particles that carry it, is refused ([`Refusal::Hull`](crate::Refusal::Hull)), and its particles float as balls. Particles
/// that are gone or set aside do not carry; a body that is not built yet waits.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # fn spawn(mut commands: Commands) {
/// // A raft of 40 kg, which carries a load.
/// let raft = RigidBox::new(Vec3::new(2.0, 0.2, 2.0)).with_mass(40.0);
/// commands.spawn((raft, Floats::default(), Transform::from_xyz(0.0, 0.2, 0.0)));
/// commands.spawn(Fluid::default());
/// # }
/// ```
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(CreationOrder)]
pub struct Floats {
    /// The shape of the hull. Default [`HullShape::Own`].
    pub shape: HullShape,
}

/// The hull by which a body floats. All variants but surfaces need a [`RigidPose`](crate::RigidPose) on the same entity, and are in its frame, metres.
#[derive(Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
#[non_exhaustive]
pub enum HullShape {
    /// The body's own shape. If it has a [`BodyPart`](crate::BodyPart), a solid box of its size, as for a [`RigidBox`](crate::RigidBox), wherever the particles
    /// are in it (a flat one is as thick as its `size.z`); otherwise its [`WindSurface`](crate::WindSurface). The default.
    #[default]
    Own,
    /// The triangles of its [`WindSurface`](crate::WindSurface), which move with its particles: cloth and soft bodies. The corners of a triangle are
    /// counter-clockwise seen from outside.
    Surface,
    /// A solid box about the body's origin.
    Box {
        /// Edge lengths, metres.
        size: Vec3,
    },
    /// Triangles in the body's frame: a ship's hull, a barrel.
    Mesh {
        /// The corners, metres. Corners at exactly the same position count as one.
        vertices: Vec<Vec3>,
        /// The triangles, as indices into `vertices`, counter-clockwise seen from outside.
        triangles: Vec<[u32; 3]>,
    },
}

impl Floats {
    /// By the body's own shape.
    pub const OWN: Self = Self { shape: HullShape::Own };

    /// As a solid box about the body's origin, from its edge lengths, metres.
    pub fn boxed(size: Vec3) -> Self {
        Self { shape: HullShape::Box { size } }
    }

    /// By triangles in the body's frame, metres.
    pub fn mesh(vertices: impl Into<Vec<Vec3>>, triangles: impl Into<Vec<[u32; 3]>>) -> Self {
        Self { shape: HullShape::Mesh { vertices: vertices.into(), triangles: triangles.into() } }
    }
}
