//! Where a field acts, as a component beside it.

use bevy::prelude::*;
use sinew::Extent;

use crate::frames::{Misplaced, even_factor};

/// Where the [`Wind`](super::Wind), the [`AirFlow`](super::AirFlow), the [`Fluid`](super::Fluid) and the [`ElectricField`](super::ElectricField) on
/// the same entity act: in a shape about the entity's position, turned and scaled as the entity and its parents are (what is round, by the same in
/// all directions). Without it they act everywhere.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::Region;
/// # use bevy_sinew::prelude::*;
/// # fn spawn(mut commands: Commands) {
/// // A pool of 4 m by 4 m that is 2 m deep.
/// let pool = Region::boxed(Vec3::new(4.0, 4.0, 4.0));
/// commands.spawn((Fluid::default(), pool));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(Transform)]
pub struct Region {
    /// The shape. Default a ball with a radius of 1 m.
    pub shape: RegionShape,
    /// Over how many metres, from the surface inwards, the field grows from nothing to all of itself. Default 0: it ends like a wall.
    pub fade: f32,
}

/// A shape about the origin of its entity, metres.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
#[non_exhaustive]
pub enum RegionShape {
    /// A box.
    Box {
        /// Lengths of its edges, metres, along the entity's axes; positive.
        size: Vec3,
    },
    /// A ball.
    Sphere {
        /// Its radius, metres; positive.
        radius: f32,
    },
    /// A cylinder with flat ends, along the entity's y axis.
    Cylinder {
        /// Its radius, metres; positive.
        radius: f32,
        /// Its height, metres; positive.
        height: f32,
    },
    /// A cylinder with round ends, along the entity's y axis.
    Capsule {
        /// Its radius, metres; positive.
        radius: f32,
        /// Length of the cylinder without its ends, metres; 0 and up.
        length: f32,
    },
}

impl Default for RegionShape {
    fn default() -> Self {
        Self::Sphere { radius: 1.0 }
    }
}

impl Region {
    /// A box from the lengths of its edges, metres.
    pub fn boxed(size: Vec3) -> Self {
        RegionShape::Box { size }.into()
    }

    /// A ball of the given radius, metres.
    pub fn sphere(radius: f32) -> Self {
        RegionShape::Sphere { radius }.into()
    }

    /// A cylinder with flat ends along the entity's y axis, from its radius and its height, metres.
    pub fn cylinder(radius: f32, height: f32) -> Self {
        RegionShape::Cylinder { radius, height }.into()
    }

    /// A cylinder with round ends along the entity's y axis, from its radius and its length without them, metres.
    pub fn capsule(radius: f32, length: f32) -> Self {
        RegionShape::Capsule { radius, length }.into()
    }

    /// The same growing to all of its field over `fade` metres from its surface inwards.
    pub fn with_fade(self, fade: f32) -> Self {
        Self { fade, ..self }
    }

    /// The same for the solver, where the entity is. It is invalid, as [`sinew::Region::is_valid`] tells, if a number of either is broken; what is round
    /// is refused where it is scaled unevenly.
    pub(crate) fn at(&self, frame: &Transform) -> Result<sinew::Region, Misplaced> {
        let (centre, scale) = (frame.translation, frame.scale.abs());
        let ends = |length: f32| {
            let axis = frame.rotation * Vec3::Y;
            // A rotation that is none, or a length that is none, must not look like a shorter one.
            let arm = axis.try_normalize().filter(|_| length >= 0.0).unwrap_or(Vec3::NAN);
            (centre - arm * (0.5 * length), centre + arm * (0.5 * length))
        };
        let extent = match self.shape {
            RegionShape::Box { size } => {
                Extent::Box { centre, size: size * scale, rotation: frame.rotation }
            }
            RegionShape::Sphere { radius } => {
                Extent::Sphere { centre, radius: radius * even_factor(scale)? }
            }
            RegionShape::Cylinder { radius, height } => {
                let (a, b) = ends(height * scale.y);
                let radius = radius * even_factor(scale.with_y(scale.x))?;
                Extent::Cylinder { a, b, radius }
            }
            RegionShape::Capsule { radius, length } => {
                let factor = even_factor(scale)?;
                let (a, b) = ends(length * factor);
                Extent::Capsule { a, b, radius: radius * factor }
            }
        };
        Ok(sinew::Region { extent, fade: self.fade * scale.min_element() })
    }
}

impl From<RegionShape> for Region {
    fn from(shape: RegionShape) -> Self {
        Self { shape, fade: 0.0 }
    }
}
