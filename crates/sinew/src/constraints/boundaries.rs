//! What holds particles by themselves, as a world has it: planes and boxes (physics.md C4), pins (C3), and the plane that a world in 2D lies in. How
//! particles touch them is in [`collide`](crate::collide).

use glam::Vec3;

use super::pin::Pin;
use super::planar_drag::PlanarDrag;
use crate::particles::Places;

/// What is enforced on single particles. [`Constraint`](super::Constraint)s and distances are kept apart, in the
/// [`Simulation`](crate::Simulation), because they are compiled into a plan when they change; these may change at any step for free.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Boundaries {
    /// Half-spaces that every particle stays in, such as the ground.
    pub planes: Vec<Plane>,
    /// Boxes that every particle stays inside.
    pub boxes: Vec<InsideBox>,
    /// Particles that are held at a point, or led along a path.
    pub pins: Vec<Pin>,
    /// For a world in 2D: the plane in which every particle stays, on both its sides. Its friction does not matter.
    pub plane_constraint: Option<Plane>,
}

/// "Every particle stays on the side of this plane to which the normal points": the ground, a wall, a ramp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Unit vector that points to the allowed side. [`Plane::new`] normalises it.
    pub normal: Vec3,
    /// `normal · x` of the points on the plane, metres: its signed distance from the origin.
    pub offset: f32,
    /// Coulomb's coefficient of friction μ, 0 (ice) and up. Default 0.5.
    pub friction: f32,
    /// Which part of its speed of approach a thing bounces back with, 0 to 1. Default 0.
    pub restitution: f32,
    /// The lectures' friction: a drag along the plane and one across it, for what touches it. Default none.
    pub drag: PlanarDrag,
}

impl Plane {
    /// The level ground at y = `height` metres.
    pub fn ground(height: f32) -> Self {
        Self {
            normal: Vec3::Y,
            offset: height,
            friction: 0.5,
            restitution: 0.0,
            drag: PlanarDrag::default(),
        }
    }

    /// The plane through `point` with the given normal, of any length but zero; `None` if it has no direction or is not finite.
    pub fn new(point: Vec3, normal: Vec3) -> Option<Self> {
        let normal = normal.try_normalize()?;
        let plane = Self { normal, offset: normal.dot(point), ..Self::ground(0.0) };
        plane.is_valid().then_some(plane)
    }

    /// The same with another coefficient of friction.
    pub fn with_friction(self, friction: f32) -> Self {
        Self { friction, ..self }
    }

    /// The same with another coefficient of restitution.
    pub fn with_restitution(self, restitution: f32) -> Self {
        Self { restitution, ..self }
    }

    /// Whether the normal is a unit vector and all numbers are finite and in range. An invalid plane is skipped.
    pub fn is_valid(&self) -> bool {
        (self.normal.length_squared() - 1.0).abs() < 1e-3
            && self.offset.is_finite()
            && self.friction.is_finite()
            && self.friction >= 0.0
            && (0.0..=1.0).contains(&self.restitution)
            && self.drag.is_valid()
    }
}

/// "Every particle stays inside this box", whose edges lie along the axes: the lectures' clamp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InsideBox {
    /// Corner with the smallest coordinates, metres.
    pub min: Vec3,
    /// Corner with the largest coordinates, metres.
    pub max: Vec3,
    /// Coulomb's coefficient of friction μ on its walls, 0 and up. Default 0.5.
    pub friction: f32,
    /// Which part of its speed of approach a thing bounces back with, 0 to 1. Default 0.
    pub restitution: f32,
}

impl InsideBox {
    /// The box between two corners, metres.
    pub fn new(min: Vec3, max: Vec3) -> Self {
        Self { min, max, friction: 0.5, restitution: 0.0 }
    }

    /// Whether `min ≤ max` and all numbers are finite and in range. An invalid box is skipped.
    pub fn is_valid(&self) -> bool {
        self.min.is_finite()
            && self.max.is_finite()
            && self.min.cmple(self.max).all()
            && self.friction.is_finite()
            && self.friction >= 0.0
            && (0.0..=1.0).contains(&self.restitution)
    }
}

impl Plane {
    /// The displacement that brings a row, a sphere of its radius, just inside, metres; zero if it is inside already. It goes to the
    /// nearest point of the half-space: along the normal, for one particle whatever its mass.
    #[inline]
    pub(crate) fn correction(&self, places: &Places, row: u32) -> Vec3 {
        let radius = places.radius[places.at(row)];
        let height = places.height(row, self.normal, self.offset) - radius;
        if height < 0.0 { self.normal * -height } else { Vec3::ZERO }
    }
}

impl InsideBox {
    /// The same: the clamp, coordinate by coordinate. Where the box is thinner than the sphere, the sphere is held in the middle.
    #[inline]
    pub(crate) fn correction(&self, places: &Places, row: u32) -> Vec3 {
        let i = places.at(row);
        let (radius, origin) = (places.radius[i], places.origin[i]);
        let (min, max) = (self.min - origin, self.max - origin);
        let middle = (min + max) * 0.5;
        let low = (min + radius).min(middle);
        let high = (max - radius).max(middle);
        let position = places.position[i].truncate();
        position.max(low).min(high) - position
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invalid_planes_and_boxes_say_so() {
        assert!(Plane::new(Vec3::ZERO, Vec3::ZERO).is_none());
        assert!(Plane::new(Vec3::NAN, Vec3::Y).is_none());
        assert!(Plane::new(Vec3::ZERO, Vec3::Y * 7.0).is_some_and(|p| p.normal == Vec3::Y));
        assert!(!Plane::ground(0.0).with_friction(-1.0).is_valid());
        assert!(!InsideBox::new(Vec3::ONE, Vec3::ZERO).is_valid());
    }
}
