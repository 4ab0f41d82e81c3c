//! Regions: where a field acts.

use bevy::prelude::*;
use sinew::Extent;

use crate::frames::{Misplaced, even_factor};

/// Limits the [`Wind`](super::Wind), the [`AirFlow`](super::AirFlow), the [`Fluid`](super::Fluid) and the [`ElectricField`](super::ElectricField) on the same
/// entity to a shape about the entity's position, turned and scaled as the entity and its parents are (round shapes only uniformly). Without it they act
/// everywhere.
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
    /// The distance, metres, from the surface inwards over which the field grows from zero to its full strength. Default 0: a sharp boundary.
    pub fade: f32,
}

/// A shape about the origin of its entity, metres.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
#[non_exhaustive]
pub enum RegionShape {
    /// A box.
    Box {
        /// Edge lengths, metres, along the entity's axes; positive.
        size: Vec3,
    },
    /// A ball.
    Sphere {
        /// Radius, metres; positive.
        radius: f32,
    },
    /// A cylinder with flat ends, along the entity's y axis.
    Cylinder {
        /// Radius, metres; positive.
        radius: f32,
        /// Height, metres; positive.
        height: f32,
    },
    /// A cylinder with hemispherical ends, along the entity's y axis.
    Capsule {
        /// Radius, metres; positive.
        radius: f32,
        /// Length of the cylinder without its ends, metres; 0 or more.
        length: f32,
    },
}

impl Default for RegionShape {
    fn default() -> Self {
        Self::Sphere { radius: 1.0 }
    }
}

impl Region {
    /// A box from its edge lengths, metres.
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

    /// A cylinder with hemispherical ends along the entity's y axis, from its radius and its length without the ends, metres.
    pub fn capsule(radius: f32, length: f32) -> Self {
        RegionShape::Capsule { radius, length }.into()
    }

    /// Returns the same region, whose field grows to its full strength over `fade` metres from the surface inwards.
    pub fn with_fade(self, fade: f32) -> Self {
        Self { fade, ..self }
    }

    /// The solver's region, in the frame of the entity. If a number is invalid, so is the result ([`sinew::Region::is_valid`]); a round shape with a
    /// non-uniform scale is an error.
    pub(crate) fn at(&self, frame: &Transform) -> Result<sinew::Region, Misplaced> {
        let (centre, scale) = (frame.translation, frame.scale.abs());
        let ends = |length: f32| {
            let axis = frame.rotation * Vec3::Y;
            // An invalid rotation or length must give an invalid result, not a shorter shape.
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
