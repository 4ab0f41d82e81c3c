//! Constraints on single particles that a world defines: planes and boxes (physics.md C4), pins (C3), and the plane of a 2D world. Contacts between particles
//! and the planes and boxes are handled in [`collide`](crate::collide).

use glam::Vec3;

use super::pin::Pin;
use super::planar_drag::PlanarDrag;
use crate::lanes::{Number, Vector};

/// The constraints on single particles. [`Constraint`](super::Constraint)s and distances are kept separately, in the [`Simulation`](crate::Simulation), because
/// a change to them recompiles the plan; these may change at any step at no cost.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Boundaries {
    /// Half-spaces that every particle stays in, such as the ground.
    pub planes: Vec<Plane>,
    /// Boxes that every particle stays inside.
    pub boxes: Vec<InsideBox>,
    /// Particles that are held at a point or moved along a path.
    pub pins: Vec<Pin>,
    /// For a 2D world: the plane in which every particle stays, on both sides. Its friction is ignored.
    pub plane_constraint: Option<Plane>,
}

/// A half-space that every particle stays in, such as the ground, a wall or a ramp. Particles stay on the side to which the normal points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Unit vector towards the allowed side. [`Plane::new`] normalises it.
    pub normal: Vec3,
    /// `normal · x` of the points on the plane, metres: its signed distance from the origin.
    pub offset: f32,
    /// Coulomb friction coefficient μ, 0 (ice) or more. Default 0.5.
    pub friction: f32,
    /// Coefficient of restitution: the share of the approach speed with which a body bounces back, 0 to 1. Default 0.
    pub restitution: f32,
    /// Velocity drag along and across the plane for particles that touch it, see [`PlanarDrag`]. Default none.
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

    /// The plane through `point` with the given normal, which may have any length but zero; `None` if the normal has no direction or an argument is not finite.
    pub fn new(point: Vec3, normal: Vec3) -> Option<Self> {
        let normal = normal.try_normalize()?;
        let plane = Self { normal, offset: normal.dot(point), ..Self::ground(0.0) };
        plane.is_valid().then_some(plane)
    }

    /// The same plane with another friction coefficient.
    pub fn with_friction(self, friction: f32) -> Self {
        Self { friction, ..self }
    }

    /// The same plane with another coefficient of restitution.
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

/// An axis-aligned box that every particle stays inside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InsideBox {
    /// Corner with the smallest coordinates, metres.
    pub min: Vec3,
    /// Corner with the largest coordinates, metres.
    pub max: Vec3,
    /// Coulomb friction coefficient μ of its walls, 0 or more. Default 0.5.
    pub friction: f32,
    /// Coefficient of restitution: the share of the approach speed with which a body bounces back, 0 to 1. Default 0.
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
    /// The displacement that brings a sphere of `radius` at `p` just inside, metres; zero if it is inside already. It leads to the nearest point of the half-space:
    /// along the normal, whatever the mass. `ground` is the height of the origin of `p` above the plane.
    #[inline(always)]
    pub(crate) fn correction<N: Number>(&self, p: Vector<N>, radius: N, ground: N) -> Vector<N> {
        let normal = Vector::<N>::splat(self.normal);
        let height = normal.dot(p) + ground - radius;
        (normal * -height).or_else(height.lt(N::zero()), Vector::zero())
    }
}

impl InsideBox {
    /// The displacement that brings a sphere of `radius` at `p` inside, metres: a clamp of each coordinate. Where the box is thinner than the sphere, the sphere is
    /// held in the middle. `origin` is that of `p`, metres.
    #[inline(always)]
    pub(crate) fn correction<N: Number>(&self, p: Vector<N>, radius: N, origin: Vec3) -> Vector<N> {
        let (min, max) = (self.min - origin, self.max - origin);
        let middle = Vector::<N>::splat((min + max) * 0.5);
        let radius = Vector::new(radius, radius, radius);
        let low = (Vector::splat(min) + radius).min(middle);
        let high = (Vector::splat(max) - radius).max(middle);
        p.max(low).min(high) - p
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
