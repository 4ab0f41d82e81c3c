//! Where a field acts, as a component beside it.

use bevy::prelude::*;
use sinew::Extent;

/// Where the [`Wind`](super::Wind), the [`AirFlow`](super::AirFlow), the [`Fluid`](super::Fluid) and the [`ElectricField`](super::ElectricField) on
/// the same entity act: in a shape about the entity's position, turned as the entity is. Without it they act everywhere.
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
pub enum RegionShape {
    /// A box.
    Box {
        /// Half of each edge, metres, along the entity's axes; positive.
        half_size: Vec3,
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
        /// Half its height, metres; positive.
        half_height: f32,
    },
    /// A cylinder with round ends, along the entity's y axis.
    Capsule {
        /// Its radius, metres; positive.
        radius: f32,
        /// Half the height of the cylinder without its ends, metres; 0 and up.
        half_height: f32,
    },
}

impl Default for RegionShape {
    fn default() -> Self {
        Self::Sphere { radius: 1.0 }
    }
}

impl Region {
    /// A box from half of each edge, metres.
    pub fn boxed(half_size: Vec3) -> Self {
        RegionShape::Box { half_size }.into()
    }

    /// A ball of the given radius, metres.
    pub fn sphere(radius: f32) -> Self {
        RegionShape::Sphere { radius }.into()
    }

    /// A cylinder with flat ends along the entity's y axis, from its radius and half its height, metres.
    pub fn cylinder(radius: f32, half_height: f32) -> Self {
        RegionShape::Cylinder { radius, half_height }.into()
    }

    /// A cylinder with round ends along the entity's y axis, from its radius and half its height without them, metres.
    pub fn capsule(radius: f32, half_height: f32) -> Self {
        RegionShape::Capsule { radius, half_height }.into()
    }

    /// The same growing to all of its field over `fade` metres from its surface inwards.
    pub fn with_fade(self, fade: f32) -> Self {
        Self { fade, ..self }
    }

    /// The same for the solver, where the entity is. It is invalid, as [`sinew::Region::is_valid`] tells, if a number of either is broken.
    pub(crate) fn at(&self, frame: &Transform) -> sinew::Region {
        let centre = frame.translation;
        let ends = |half_height: f32| {
            let axis = frame.rotation * Vec3::Y;
            // A rotation that is none, or a height that is none, must not look like a shorter one.
            let arm = axis.try_normalize().filter(|_| half_height >= 0.0).unwrap_or(Vec3::NAN);
            (centre - arm * half_height, centre + arm * half_height)
        };
        let extent = match self.shape {
            RegionShape::Box { half_size } => {
                Extent::Box { centre, half_size, rotation: frame.rotation }
            }
            RegionShape::Sphere { radius } => Extent::Sphere { centre, radius },
            RegionShape::Cylinder { radius, half_height } => {
                let (a, b) = ends(half_height);
                Extent::Cylinder { a, b, radius }
            }
            RegionShape::Capsule { radius, half_height } => {
                let (a, b) = ends(half_height);
                Extent::Capsule { a, b, radius }
            }
        };
        sinew::Region { extent, fade: self.fade }
    }
}

impl From<RegionShape> for Region {
    fn from(shape: RegionShape) -> Self {
        Self { shape, fade: 0.0 }
    }
}
