//! Inertia in its principal axes: diagonal, so that axes without inertia are recognised; and the spin of a body.

use glam::{DMat3, DQuat, DVec3};

use crate::pose::symmetric;

/// Moments below this fraction of the greatest count as zero. An `f32` matrix has no information on smaller ones: its elements are rounded to 6e-8 of
/// themselves, and so the least eigenvalue to about 1e-7 of the greatest.
const NEGLIGIBLE: f64 = 1e-6;

/// Principal moments and axes of a body.
#[derive(Clone, Copy, Debug)]
pub(super) struct Principal {
    /// Principal moments, kg·m², all positive. A zero moment is replaced by the greatest (1 if all are zero). That has no effect, because [`rate`](Self::rate)
    /// gives no angular velocity about that axis.
    pub(super) moments: DVec3,
    /// Turns angular momentum into angular velocity: `1/moment`, or 0 for a zero moment.
    inverse: DVec3,
    /// Principal axes in the body's frame, one per column, right-handed.
    pub(super) axes: DMat3,
}

impl Principal {
    /// `None` if the matrix is not finite, not symmetric or has a negative moment.
    pub(super) fn new(m: DMat3) -> Option<Self> {
        let across = m - m.transpose();
        let size = m.to_cols_array().into_iter().fold(0.0, |size: f64, x| size.max(x.abs()));
        let skew = across.to_cols_array().into_iter().fold(0.0, |skew: f64, x| skew.max(x.abs()));
        if !m.is_finite() || skew > NEGLIGIBLE * size {
            return None;
        }
        let even = (m + m.transpose()) * 0.5;
        let (values, vectors) = symmetric::eigen(even.to_cols_array_2d());
        let top = values.iter().fold(0.0_f64, |top, &value| top.max(value));
        if values.iter().any(|&value| value < -NEGLIGIBLE * size) {
            return None;
        }
        let stand_in = if top > 0.0 { top } else { 1.0 };
        let there = |value: &f64| *value > NEGLIGIBLE * top;
        let axes = DMat3::from_cols_array_2d(&vectors);
        let handed = if axes.determinant() < 0.0 { -1.0 } else { 1.0 };
        Some(Self {
            moments: DVec3::from(values.map(|v| if there(&v) { v } else { stand_in })),
            inverse: DVec3::from(values.map(|v| if there(&v) { 1.0 / v } else { 0.0 })),
            axes: axes * handed,
        })
    }

    /// `I⁻¹ L`, rad/s, both in the body's frame: the pseudo-inverse, without components about axes that have no inertia.
    pub(super) fn rate(&self, momentum: DVec3) -> DVec3 {
        self.axes * (self.inverse * (self.axes.transpose() * momentum))
    }

    /// Whether there is inertia about every axis.
    pub(super) fn is_full(&self) -> bool {
        self.inverse.min_element() > 0.0
    }

    /// `I ω`, kg·m²/s, both in the body's frame, without components about axes that have no inertia.
    pub(super) fn momentum(&self, rate: DVec3) -> DVec3 {
        let there = |x: f64| if x > 0.0 { 1.0 } else { 0.0 };
        let there = DVec3::new(there(self.inverse.x), there(self.inverse.y), there(self.inverse.z));
        self.axes * (self.moments * there * (self.axes.transpose() * rate))
    }
}

/// State of the integrators: rotation, and angular momentum about the barycentre, kg·m²/s, in the axes of the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Spin {
    pub(super) rotation: DQuat,
    pub(super) momentum: DVec3,
}

impl Spin {
    /// The angular momentum in the body's frame.
    pub(super) fn body_momentum(&self) -> DVec3 {
        self.rotation.conjugate() * self.momentum
    }

    /// Angular velocity in the axes of the world, rad/s.
    pub(super) fn rate(&self, principal: &Principal) -> DVec3 {
        self.rotation * principal.rate(self.body_momentum())
    }

    /// The rotation followed by `turn`, which is in the body's frame.
    pub(super) fn turned(self, turn: DQuat) -> Self {
        Self { rotation: (self.rotation * turn).normalize(), ..self }
    }

    /// Without the components of angular momentum about axes that have no inertia, which a torque may have added.
    pub(super) fn projected(self, principal: &Principal) -> Self {
        if principal.is_full() {
            return self;
        }
        let inside = principal.momentum(principal.rate(self.body_momentum()));
        Self { momentum: self.rotation * inside, ..self }
    }
}

/// The rotation about the direction of `vector` by its length, rad.
pub(super) fn by_vector(vector: DVec3) -> DQuat {
    let angle = vector.length();
    if angle < 1e-8 {
        // There sin(½θ)/θ is ½ to the last bit, and the quaternion's length 1.
        let half = vector * 0.5;
        return DQuat::from_xyzw(half.x, half.y, half.z, 1.0);
    }
    let (sin, cos) = libm::sincos(0.5 * angle);
    let axis = vector * (sin / angle);
    DQuat::from_xyzw(axis.x, axis.y, axis.z, cos)
}
