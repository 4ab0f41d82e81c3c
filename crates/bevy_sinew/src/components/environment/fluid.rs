//! Fluids, and the bodies that float in them by their own shape.

use bevy::prelude::*;

use crate::components::CreationOrder;
use crate::same::same_fields;

/// A fluid that fills the half-space below the entity's local xz plane, or of that the [`Region`](super::Region) on the same entity.
///
/// Particles with a [`Radius`](crate::Radius) float in it as balls, and bodies that have [`Floats`] by their shape. For a pool, add a
/// [`Region::boxed`](super::Region::boxed) twice as high as the pool is deep: the part above the surface stays empty.
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
    /// Share of its velocity relative to the current that a submerged particle loses per second, 0 to 1. Default 0.8.
    pub drag: f32,
    /// Velocity in the world, m/s: the drag pulls everything in it towards this. Default zero.
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

/// A body that floats by its own shape, and not as the balls of its particles: a crate, a raft, a boat.
///
/// Put it on the body. Buoyancy is that of the pressure on the skin below the surface, so that it floats as deep as its mass asks for, and rights
/// itself or turns over as its shape does. A skin that is open like a boat's keeps the water out, and is decked over when its rim goes under.
///
/// Without a skin or without particles that carry it, it is refused ([`Refusal::Hull`](crate::Refusal::Hull)), and its particles float as balls. A
/// particle that is gone or set aside does not carry; a body that is yet to be built waits.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # fn spawn(mut commands: Commands) {
/// // A raft of 40 kg that carries what lies on it.
/// let raft = RigidBox::new(Vec3::new(2.0, 0.2, 2.0)).with_mass(40.0);
/// commands.spawn((raft, Floats::default(), Transform::from_xyz(0.0, 0.2, 0.0)));
/// commands.spawn(Fluid::default());
/// # }
/// ```
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(CreationOrder)]
pub struct Floats {
    /// What is wetted. Default [`HullShape::Own`].
    pub shape: HullShape,
}

/// The shape by which a body floats. All but surfaces need a [`RigidPose`](crate::RigidPose) on the same entity, and are in its frame, metres.
#[derive(Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
#[non_exhaustive]
pub enum HullShape {
    /// Its own: where a [`BodyPart`](crate::BodyPart) tells its size, a solid box of that size, as for a [`RigidBox`](crate::RigidBox),
    /// wherever in it the particles are (a flat one is as thick as its `size.z`); of anything else the [`WindSurface`](crate::WindSurface). The
    /// default.
    #[default]
    Own,
    /// The triangles of its [`WindSurface`](crate::WindSurface), which move as its particles do: cloth and soft bodies. The corners of a triangle go
    /// counter-clockwise seen from outside.
    Surface,
    /// A solid box about the body's origin.
    Box {
        /// Lengths of its edges, metres.
        size: Vec3,
    },
    /// Triangles of the game's own: a ship's hull, a barrel.
    Mesh {
        /// The corners, metres. Those at exactly the same place count as one.
        vertices: Vec<Vec3>,
        /// Three numbers of vertices each, counter-clockwise seen from outside.
        triangles: Vec<[u32; 3]>,
    },
}

impl Floats {
    /// By its own shape.
    pub const OWN: Self = Self { shape: HullShape::Own };

    /// As a solid box about the body's origin, from the lengths of its edges in metres.
    pub fn boxed(size: Vec3) -> Self {
        Self { shape: HullShape::Box { size } }
    }

    /// By triangles in the body's frame, metres.
    pub fn mesh(vertices: impl Into<Vec<Vec3>>, triangles: impl Into<Vec<[u32; 3]>>) -> Self {
        Self { shape: HullShape::Mesh { vertices: vertices.into(), triangles: triangles.into() } }
    }
}
