//! Naive reference of bending: one struct with everything that a fold needs, the same formulas as Sinew's, solved one after the other.

use core::f32::consts::{PI, TAU};

use sinew::Softness;
use sinew::constraints::{Bend, Hinge};
use sinew::glam::Vec3;

use super::Particle;

/// A bending constraint between two triangles with a common edge. Made for one sweep a substep, so that no multiplier is kept.
#[derive(Clone, Copy, Debug)]
pub struct Fold {
    rows: [u32; 4],
    kind: Kind,
    /// Compliance in rad²/J for an angle, m/N for a length.
    compliance: f32,
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    /// The dihedral angle of the particles `[a, h0, h1, c]` about the edge `h0 h1`; rest angle in radians.
    Dihedral { rest: f32 },
    /// The length of a weighted sum of positions; rest length in metres.
    Isometric { weights: [f32; 4], rest: f32 },
}

impl Fold {
    /// Made from a [`Hinge`] that keeps one angle.
    pub fn dihedral(rows: [u32; 4], law: &Hinge) -> Self {
        let rest = 0.5 * (law.min + law.max);
        Self { rows, kind: Kind::Dihedral { rest }, compliance: compliance(law.softness) }
    }

    /// Made from a [`Bend`].
    pub fn isometric(rows: [u32; 4], law: &Bend) -> Self {
        let kind = Kind::Isometric { weights: law.weights, rest: law.rest };
        Self { rows, kind, compliance: compliance(law.softness) }
    }

    /// One XPBD projection in a substep of `h` seconds.
    #[inline]
    pub(super) fn project(&self, particles: &mut [Particle], h: f32) {
        let rows = self.rows.map(|row| row as usize);
        let now = rows.map(|row| particles[row]);
        let places = now.map(|p| p.position);
        let found = match self.kind {
            Kind::Dihedral { rest } => dihedral(places, rest),
            Kind::Isometric { weights, rest } => isometric(places, weights, rest),
        };
        let Some((value, gradients)) = found else { return };
        let mut sum = 0.0;
        for (p, gradient) in now.iter().zip(&gradients) {
            sum += p.inverse_mass * gradient.length_squared();
        }
        let divisor = sum + self.compliance / (h * h);
        if divisor > 0.0 {
            let lambda = value / divisor;
            for i in 0..4 {
                particles[rows[i]].position =
                    now[i].position - gradients[i] * (now[i].inverse_mass * lambda);
            }
        }
    }
}

/// Difference between the angle about the axis and `rest`, radians, and its gradients.
#[inline]
fn dihedral([a, h0, h1, c]: [Vec3; 4], rest: f32) -> Option<(f32, [Vec3; 4])> {
    let edge = h1 - h0;
    let axis = edge.try_normalize()?;
    let (n, m) = (axis.cross(a - h0), axis.cross(c - h0));
    let (nn, mm) = (n.length_squared(), m.length_squared());
    if nn == 0.0 || mm == 0.0 {
        return None;
    }
    let angle = axis.dot(n.cross(m)).atan2(n.dot(m));
    let mut value = angle - rest;
    if value > PI {
        value -= TAU;
    } else if value < -PI {
        value += TAU;
    }
    let (by_a, by_c) = (-n / nn, m / mm);
    let share = 1.0 / edge.length_squared();
    let (s, t) = ((a - h0).dot(edge) * share, (c - h0).dot(edge) * share);
    let by_h0 = -(by_a * (1.0 - s) + by_c * (1.0 - t));
    let by_h1 = -(by_a * s + by_c * t);
    Some((value, [by_a, by_h0, by_h1, by_c]))
}

/// Difference between the length of the weighted sum and `rest`, metres, and its gradients.
#[inline]
fn isometric(places: [Vec3; 4], weights: [f32; 4], rest: f32) -> Option<(f32, [Vec3; 4])> {
    let mut sum = Vec3::ZERO;
    for i in 1..4 {
        sum += (places[i] - places[0]) * weights[i];
    }
    let length = sum.length();
    let along = (length > 0.0).then(|| sum / length)?;
    Some((length - rest, weights.map(|weight| along * weight)))
}

fn compliance(softness: Softness) -> f32 {
    match softness {
        Softness::Compliant { compliance, .. } => compliance,
        _ => 0.0,
    }
}
