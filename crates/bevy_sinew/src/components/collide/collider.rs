//! Colliders: shapes that nothing moves but the game, and by which rigid bodies collide.

use bevy::prelude::*;
use sinew::{Shape, ShapeFault};

use super::{ColliderFault, ColliderMotion, ContactCache, PlacedCollider};
use crate::components::CreationOrder;

/// A shape that particles and bodies cannot enter: a floor, a wall, a hill, a lift. [`Ground`](crate::Ground) and [`BoundingBox`](crate::BoundingBox)
/// are names for two of them.
///
/// It is where the entity is, on top of its parents, turned and scaled as they are (what is round and is not scaled alike in all directions becomes a
/// hull of 24 sides). It stands still, or goes where the game moves its `Transform` (a *kinematic* collider): over the tick it goes evenly from where
/// it was to where it is ([`ColliderMotion`]), pushes what is in its way and carries what lies on it. Nothing moves it but the game.
/// [`SurfaceMaterial`](super::SurfaceMaterial), [`CollisionLayers`](super::CollisionLayers) and [`Sensor`](super::Sensor) beside it say more.
///
/// On a rigid body or a part of one (what has a [`RigidPose`](crate::RigidPose)) it is the shape by which that collides where it does so as a solid
/// ([`BodyContacts`](super::BodyContacts)), in metres in its own frame, whatever its scale: anything without dents. The recipes of rigid bodies put
/// it there, unless the game has. On a particle, and on a body that is not rigid, it does nothing.
///
/// One with a broken number (of its own, of its transform, of its material; a scale of zero) is set aside with one [`Refused`](crate::Refused)
/// message, until it is mended.
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
    /// All that is below the entity's local xz plane.
    HalfSpace,
    /// All that is outside of a box: a room without a door. [`BoundingBox`](crate::BoundingBox) is a name for it.
    InsideBox {
        /// Lengths of the edges of the box, metres, along the entity's axes; positive.
        size: Vec3,
    },
    /// A ball.
    Sphere {
        /// Its radius, metres; positive.
        radius: f32,
    },
    /// A cylinder with round ends, along the entity's y axis.
    Capsule {
        /// Its radius, metres; positive.
        radius: f32,
        /// Length of the cylinder without its ends, metres; 0 and up.
        length: f32,
    },
    /// A box.
    Box {
        /// Lengths of its edges, metres, along the entity's axes; positive.
        size: Vec3,
    },
    /// A cylinder with flat ends, along the entity's y axis.
    Cylinder {
        /// Its radius, metres; positive.
        radius: f32,
        /// Its height, metres; positive.
        height: f32,
    },
    /// A shape of many corners, or any other of the solver's.
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
    /// All that is below the entity's local xz plane.
    pub fn plane() -> Self {
        Self::HalfSpace
    }

    /// All that is outside of a box, from the lengths of its edges, metres.
    pub fn inside_box(size: Vec3) -> Self {
        Self::InsideBox { size }
    }

    /// A ball of the given radius, metres.
    pub fn sphere(radius: f32) -> Self {
        Self::Sphere { radius }
    }

    /// A cylinder with round ends along the entity's y axis, from its radius and its length without them, metres.
    pub fn capsule(radius: f32, length: f32) -> Self {
        Self::Capsule { radius, length }
    }

    /// A box from the lengths of its edges, metres.
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
    /// Points that enclose no volume, are more than 65 536, or are not finite.
    pub fn hull(points: &[Vec3]) -> Result<Self, ColliderFault> {
        Ok(Shape::hull(points)?.into())
    }

    /// Triangles between vertices, metres: a sheet with two sides, or, if it is closed and its triangles go counter-clockwise seen from outside, a
    /// solid.
    ///
    /// # Errors
    /// No triangle with an area, corners that are not there or not finite.
    pub fn mesh(
        vertices: impl Into<Vec<Vec3>>,
        triangles: impl Into<Vec<[u32; 3]>>,
    ) -> Result<Self, ColliderFault> {
        Ok(Shape::mesh(vertices.into(), triangles.into())?.into())
    }

    /// A landscape about the entity's origin: `columns` heights along x in each of `rows` along z, row by row, over `size.x` × `size.z` metres; the
    /// heights are in units of `size.y` metres. It is solid below.
    ///
    /// # Errors
    /// Fewer than two rows or columns, another number of heights, or a number that is not finite or out of range.
    pub fn height_field(
        columns: usize,
        rows: usize,
        heights: &[f32],
        size: Vec3,
    ) -> Result<Self, ColliderFault> {
        Ok(Shape::height_field(columns, rows, heights, size)?.into())
    }

    /// The shape for the solver, unscaled.
    ///
    /// # Errors
    /// A number that is not finite or out of range.
    pub fn shape(&self) -> Result<Shape, ShapeFault> {
        match *self {
            Self::HalfSpace => Ok(Shape::half_space()),
            Self::InsideBox { size } => Shape::inside_box(size),
            Self::Sphere { radius } => Shape::sphere(radius),
            // Without a middle its ends are all of it.
            Self::Capsule { radius, length: 0.0 } => Shape::sphere(radius),
            Self::Capsule { radius, length } => Shape::capsule(radius, length),
            Self::Box { size } => Shape::cuboid(size),
            Self::Cylinder { radius, height } => Shape::cylinder(radius, height),
            Self::Shape(ColliderShape(ref shape)) => Ok(shape.clone()),
        }
    }

    /// The same, scaled along its own axes.
    pub(crate) fn scaled(&self, scale: Vec3) -> Result<Shape, ShapeFault> {
        let shape = self.shape()?;
        // All but those of many corners are the same in a mirror; and a plane is one at any scale but none.
        let scale = if matches!(self, Self::Shape(_)) { scale } else { scale.abs() };
        if scale == Vec3::ONE { Ok(shape) } else { shape.scaled(scale) }
    }
}
