//! Ropes by their segments: a capsule between each two neighbours, so that nothing that is thinner than their gap passes between them.

use std::sync::Arc;

use glam::Vec3;

use super::super::shape::Kind;
use super::super::triangles::of_segments;
use super::super::{Shape, ShapeFault};
use super::BodyCollider;
use crate::particles::Particles;

/// By how much two must be clear of each other in the rest shape to touch at all, as a share of how thick they are: those that just touch there would
/// press for nothing.
const CLEAR: f64 = 0.01;

impl BodyCollider {
    /// One segment of a rope: a capsule along the line of two particles, as thick as `radius` and as long as `length` between the centres of its
    /// caps, both in metres. Segments that have a particle in common make a rope without gaps. See [`BodyCollider::id`] for `id`.
    ///
    /// Segments of one body touch each other, where the body touches itself, unless they overlap in its rest shape ([`Particles::set_rest`]): a rope
    /// that is thicker than its segments are long does not press itself apart.
    ///
    /// # Errors
    /// If the radius or the length is not between 1e-6 and 1e6 metres.
    pub fn segment(rows: [u32; 2], length: f32, radius: f32, id: u64) -> Result<Self, ShapeFault> {
        let half = 0.5 * length;
        let shape = Shape::capsule(radius, length)?;
        let rest = Arc::new([Vec3::Y * half, Vec3::Y * -half]);
        Ok(Self { rows: rows.to_vec(), rest, shape, id })
    }

    /// Whether two segments overlap in the rest shape of their body. Anything else does not, and neither do those whose particles have no place
    /// there.
    pub(super) fn overlaps_at_rest(&self, other: &Self, particles: &Particles) -> bool {
        let axis = |solid: &Self| {
            let (&[a, b], Kind::Capsule { radius, .. }) = (&*solid.rows, solid.shape.kind()) else {
                return None;
            };
            let place = |row: u32| particles.rest.get(row as usize).filter(|at| at.is_finite());
            Some(([place(a)?.as_dvec3(), place(b)?.as_dvec3()], f64::from(radius)))
        };
        let (Some((one, radius)), Some((other, thick))) = (axis(self), axis(other)) else {
            return false;
        };
        of_segments(one, other) < (radius + thick) * (1.0 + CLEAR)
    }
}
