//! Body colliders: what one consists of, and the faults that keep one out of the contacts.

use std::sync::Arc;

use glam::Vec3;

use super::distance::of_segments;
use super::shape::{Kind, Shape, ShapeFault};
use crate::particles::Particles;

/// Two segments of one body collide only if their distance in the rest shape exceeds the sum of their radii by this share of it: segments that only just
/// touch at rest would push each other apart for no reason.
const REST_CLEARANCE: f64 = 0.01;

/// A collision shape attached to a group of particles, which collide as one rigid shape.
///
/// Its pose is extracted from the positions of its particles, which constraints must hold together. Two particles do not determine the rotation about the line
/// between them; give such a body collider a shape that is round about that line.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyCollider {
    /// Rows of its particles. Body colliders may share particles; two of one body that do never touch each other.
    pub rows: Vec<u32>,
    /// Position of each particle in the frame of the body collider, metres; as many as `rows`. Shared by body colliders of the same shape.
    pub rest: Arc<[Vec3]>,
    /// Its shape, in its own frame: any convex shape.
    pub shape: Shape,
    /// Its identity in the contact cache ([`ContactCache`](super::ContactCache)). Must ascend in the list of body colliders, whichever are added or removed.
    pub id: u64,
}

/// Why a body collider takes part in no contacts. Returned by [`BodyCollider::fault`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BodyColliderFault {
    /// It has no rows, or the number of rest positions differs.
    #[error("it has no particles, or not as many rest positions")]
    Count,
    /// One of its rows does not exist.
    #[error("one of its particles does not exist")]
    MissingParticle,
    /// A row is listed twice.
    #[error("one of its particles is there twice")]
    SameParticle,
    /// A rest position is not finite.
    #[error("a rest position is not finite")]
    Number,
    /// Its shape is a half-space, an inside box, a mesh or a heightfield, which are for static geometry only.
    #[error("a half-space, an inside box, a mesh or a heightfield cannot move")]
    Shape,
}

impl BodyCollider {
    /// One segment of a rope: a capsule along the line through two particles. `radius` is that of the capsule and `length` the distance between the centres of
    /// its caps, both in metres. Segments that share a particle form a rope without gaps. `id` is [`BodyCollider::id`].
    ///
    /// Segments of one body that collides with itself touch each other unless they overlap in its rest shape ([`Particles::set_rest`]), so that a rope that is
    /// thicker than its segments are long does not push itself apart.
    ///
    /// # Errors
    /// If the radius or the length is not between 1e-6 and 1e6 metres.
    pub fn segment(rows: [u32; 2], length: f32, radius: f32, id: u64) -> Result<Self, ShapeFault> {
        let half = 0.5 * length;
        let shape = Shape::capsule(radius, length)?;
        let rest = Arc::new([Vec3::Y * half, Vec3::Y * -half]);
        Ok(Self { rows: rows.to_vec(), rest, shape, id })
    }

    /// Why it cannot collide in a world with `particles` particles, or `None` if it can.
    pub fn fault(&self, particles: usize) -> Option<BodyColliderFault> {
        if self.rows.is_empty() || self.rows.len() != self.rest.len() {
            Some(BodyColliderFault::Count)
        } else if self.rows.iter().any(|&row| row as usize >= particles) {
            Some(BodyColliderFault::MissingParticle)
        } else if self.rows.iter().enumerate().any(|(i, row)| self.rows[..i].contains(row)) {
            Some(BodyColliderFault::SameParticle)
        } else if self.rest.iter().any(|r| !r.is_finite()) {
            Some(BodyColliderFault::Number)
        } else if matches!(
            self.shape.kind(),
            Kind::HalfSpace | Kind::InsideBox | Kind::Mesh | Kind::HeightField
        ) {
            Some(BodyColliderFault::Shape)
        } else {
            None
        }
    }

    /// Whether two segments overlap in the rest shape of their body. False for body colliders that are not segments, and where a particle has no rest position.
    pub(in crate::collide) fn overlaps_at_rest(&self, other: &Self, particles: &Particles) -> bool {
        let axis = |collider: &Self| {
            let (&[a, b], Kind::Capsule { radius, .. }) = (&*collider.rows, collider.shape.kind())
            else {
                return None;
            };
            let place = |row: u32| particles.rest.get(row as usize).filter(|at| at.is_finite());
            Some(([place(a)?.as_dvec3(), place(b)?.as_dvec3()], f64::from(radius)))
        };
        let (Some((one, radius)), Some((other, thick))) = (axis(self), axis(other)) else {
            return false;
        };
        of_segments(one, other) < (radius + thick) * (1.0 + REST_CLEARANCE)
    }
}
