//! Colliders: static and kinematic shapes, and the shapes of rigid bodies.

use bevy::prelude::*;
use sinew::{Shape, ShapeFault};

use super::{ColliderFault, ColliderMotion, ContactCache, PlacedCollider};
use crate::components::CreationOrder;

/// A shape that particles and bodies cannot enter: a floor, a wall, a hill, a lift. [`Ground`](crate::Ground) and [`BoundingBox`](crate::BoundingBox) are
/// shorthands for two shapes.
///
/// It is placed where the entity is, on top of its parents, and turned and scaled with them (a round shape with a non-uniform scale becomes a hull of 24
/// sides). It is static, or *kinematic* where the game moves its `Transform`: over the tick it then moves evenly from where it was to where it is
/// ([`ColliderMotion`]), pushes bodies in its way and carries those that rest on it. Nothing but the game moves it.
/// [`SurfaceMaterial`](super::SurfaceMaterial), [`CollisionLayers`](super::CollisionLayers) and [`Sensor`](super::Sensor) on the same entity configure it.
///
/// On a rigid body or a part of one (an entity with a [`RigidPose`](crate::RigidPose)) it is the shape by which that collides
/// ([`BodyContacts`](super::BodyContacts)), in metres in its own frame, whatever its scale; it must be convex. The recipes of rigid bodies add it, unless the
/// game has. On a particle, and on a body that is not rigid, it has no effect.
///
/// A collider with an invalid number (of its own, of its transform, of its material; a scale of zero) is set aside with one [`Refused`](crate::Refused)
/// message, until it is corrected.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// fn spawn(mut commands: Commands) {
///     commands.spawn(Collider::plane());
///     commands.spawn((Collider::cuboid(Vec3::new(4.0, 0.2, 4.0)), Transform::from_xyz(0.0, 1.0, 0.0)));
///     let ramp = Collider::hull(&[Vec3::ZERO, Vec3::X, Vec3::Z, Vec3::new(1.0, 0.5, 0.0), Vec3::new(1.0, 0.0, 1.0)]);
///     if let Ok(ramp) = ramp {
///         commands.spawn((ramp, Transform::from_xyz(3.0, 0.0, 0.0)));
///     }
/// }
/// ```
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(Transform, CreationOrder, ColliderMotion, ContactCache, PlacedCollider)]
pub enum Collider {
    /// The half-space below the entity's local xz plane.
    HalfSpace,
    /// Everything outside of a box: a closed room. [`BoundingBox`](crate::BoundingBox) is a shorthand for it.
    InsideBox {
        /// Edge lengths of the box, metres, along the entity's axes; positive.
        size: Vec3,
    },
    /// A ball.
    Sphere {
        /// Radius, metres; positive.
        radius: f32,
    },
    /// A cylinder with hemispherical ends, along the entity's y axis.
    Capsule {
        /// Radius, metres; positive.
        radius: f32,
        /// Length of the cylinder without its ends, metres; 0 or more.
        length: f32,
    },
    /// A box.
    Box {
        /// Edge lengths, metres, along the entity's axes; positive.
        size: Vec3,
    },
    /// A cylinder with flat ends, along the entity's y axis.
    Cylinder {
        /// Radius, metres; positive.
        radius: f32,
        /// Height, metres; positive.
        height: f32,
    },
    /// A hull, a mesh, a heightfield, or any other shape of the solver.
    Shape(ColliderShape),
}

/// A shape of the solver: a hull, a mesh, a heightfield. Cheap to clone, and opaque to reflection.
#[derive(Reflect, Clone, Debug, PartialEq)]
#[reflect(opaque)]
#[reflect(Clone, PartialEq)]
pub struct ColliderShape(pub Shape);

impl Default for Collider {
    /// A cube with edges of 1 m.
    fn default() -> Self {
        Self::cuboid(Vec3::ONE)
    }
}

impl From<Shape> for Collider {
    fn from(shape: Shape) -> Self {
        Self::Shape(ColliderShape(shape))
    }
}

impl Collider {
    /// The half-space below the entity's local xz plane.
    pub fn plane() -> Self {
        Self::HalfSpace
    }

    /// Everything outside of a box, from its edge lengths, metres.
    pub fn inside_box(size: Vec3) -> Self {
        Self::InsideBox { size }
    }

    /// A ball of the given radius, metres.
    pub fn sphere(radius: f32) -> Self {
        Self::Sphere { radius }
    }

    /// A cylinder with hemispherical ends along the entity's y axis, from its radius and its length without the ends, metres.
    pub fn capsule(radius: f32, length: f32) -> Self {
        Self::Capsule { radius, length }
    }

    /// A box from its edge lengths, metres.
    pub fn cuboid(size: Vec3) -> Self {
        Self::Box { size }
    }

    /// A cylinder with flat ends along the entity's y axis, from its radius and its height, metres.
    pub fn cylinder(radius: f32, height: f32) -> Self {
        Self::Cylinder { radius, height }
    }

    /// The convex hull of points, metres.
    ///
    /// # Errors
    /// Points that enclose no volume, more than 65 536 points, or points that are not finite.
    pub fn hull(points: &[Vec3]) -> Result<Self, ColliderFault> {
        Ok(Shape::hull(points)?.into())
    }

    /// A triangle mesh from vertices, metres, and indices: a two-sided sheet, or a solid if it is closed and its triangles are counter-clockwise seen from
    /// outside.
    ///
    /// # Errors
    /// No triangle with an area; indices out of range; vertices that are not finite.
    pub fn mesh(
        vertices: impl Into<Vec<Vec3>>,
        triangles: impl Into<Vec<[u32; 3]>>,
    ) -> Result<Self, ColliderFault> {
        Ok(Shape::mesh(vertices.into(), triangles.into())?.into())
    }

    /// A heightfield about the entity's origin: `columns` heights along x in each of `rows` rows along z, row by row, over `size.x` × `size.z` metres; the
    /// heights are multiplied by `size.y` metres. It is solid below.
    ///
    /// # Errors
    /// Fewer than two rows or columns, a wrong number of heights, or a number that is not finite or out of range.
    pub fn height_field(
        columns: usize,
        rows: usize,
        heights: &[f32],
        size: Vec3,
    ) -> Result<Self, ColliderFault> {
        Ok(Shape::height_field(columns, rows, heights, size)?.into())
    }

    /// The solver's shape, unscaled.
    ///
    /// # Errors
    /// A number that is not finite or out of range.
    pub fn shape(&self) -> Result<Shape, ShapeFault> {
        match *self {
            Self::HalfSpace => Ok(Shape::half_space()),
            Self::InsideBox { size } => Shape::inside_box(size),
            Self::Sphere { radius } => Shape::sphere(radius),
            // Without its cylinder a capsule is a sphere.
            Self::Capsule { radius, length: 0.0 } => Shape::sphere(radius),
            Self::Capsule { radius, length } => Shape::capsule(radius, length),
            Self::Box { size } => Shape::cuboid(size),
            Self::Cylinder { radius, height } => Shape::cylinder(radius, height),
            Self::Shape(ColliderShape(ref shape)) => Ok(shape.clone()),
        }
    }

    /// The solver's shape, scaled along its own axes.
    pub(crate) fn scaled(&self, scale: Vec3) -> Result<Shape, ShapeFault> {
        let shape = self.shape()?;
        // All shapes but those with vertices are symmetric, so a mirroring scale counts as its absolute value.
        let scale = if matches!(self, Self::Shape(_)) { scale } else { scale.abs() };
        if scale == Vec3::ONE { Ok(shape) } else { shape.scaled(scale) }
    }
}
