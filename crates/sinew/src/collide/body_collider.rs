//! What a body collider is made of, and why it may not be.

use std::sync::Arc;

use glam::Vec3;

use super::distance::of_segments;
use super::shape::{Kind, Shape, ShapeFault};
use crate::particles::Particles;

/// By how much two segments must be clear of each other in the rest shape to touch at all, as a share of how thick they are: those that just touch there would
/// press for nothing.
const CLEAR: f64 = 0.01;

/// Particles that collide as one, by a shape.
///
/// Where it is and how it is turned follows from where its particles are; they must be held together by constraints. Two particles do not say how it
/// is turned about their line; give such a body collider a shape that is round about it.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyCollider {
    /// Rows of its particles. Several body colliders may share some; those never touch each other if they are of one body.
    pub rows: Vec<u32>,
    /// Where each of them is in the body collider's own frame, metres; as many as `rows`. Shared by body colliders of the same shape.
    pub rest: Arc<[Vec3]>,
    /// Its shape, in its own frame: anything without dents.
    pub shape: Shape,
    /// Its name in the contact cache ([`ContactCache`](super::ContactCache)): ascending in the list of body colliders, whatever comes and goes.
    pub id: u64,
}

/// Why a body collider takes part in no contacts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BodyColliderFault {
    /// It has no rows, or another number of rest positions.
    #[error("it has no particles, or not as many rest positions")]
    Count,
    /// One of its rows is no particle.
    #[error("one of its particles does not exist")]
    MissingParticle,
    /// One of its rows is there twice.
    #[error("one of its particles is there twice")]
    SameParticle,
    /// A rest position is not finite.
    #[error("a rest position is not finite")]
    Number,
    /// A half-space, a mesh or a heightfield: those are for static geometry.
    #[error("a half-space, a mesh or a heightfield cannot move")]
    Shape,
}

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

    /// Why it cannot collide among so many particles, or `None` if it can.
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

    /// Whether two segments overlap in the rest shape of their body. Anything else does not, and neither do those whose particles have no place
    /// there.
    pub(in crate::collide) fn overlaps_at_rest(&self, other: &Self, particles: &Particles) -> bool {
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
