//! The view of a world that the contact passes read.

use glam::Vec3;

use super::body_collider::BodyCollider;
use super::collider::Collider;
use super::filter::ContactFilter;
use crate::constraints::Boundaries;
use crate::forces::RowGravity;
use crate::islands::Islands;

/// Everything in a world that contacts depend on.
#[derive(Clone, Copy)]
pub(crate) struct World<'a> {
    pub(crate) boundaries: &'a Boundaries,
    pub(crate) colliders: &'a [Collider],
    pub(crate) body_colliders: &'a [BodyCollider],
    pub(crate) filter: &'a ContactFilter,
    pub(crate) islands: &'a Islands,
    /// Length of the step, seconds, and its number of substeps.
    pub(crate) dt: f32,
    pub(crate) substeps: u32,
    /// Gravity, m/s².
    pub(crate) gravity: Vec3,
    /// That on each row, with its own scale and attractors.
    pub(crate) row_gravity: &'a RowGravity,
    /// Whether neither particles nor colliders move in this step, and no contact events are requested.
    pub(crate) at_rest: bool,
}

impl World<'_> {
    /// Whether anything bounces.
    pub(crate) fn any_restitution(&self) -> bool {
        let Boundaries { planes, boxes, .. } = self.boundaries;
        let bodies = self.filter.bodies().iter().map(|body| body.material.restitution);
        let colliders = self.colliders.iter().map(|collider| collider.material.restitution);
        let planes = planes.iter().map(|plane| plane.restitution);
        let boxes = boxes.iter().map(|inside| inside.restitution);
        let all = bodies.chain(colliders).chain(planes).chain(boxes);
        all.into_iter().any(|restitution| restitution > 0.0)
    }

    /// Magnitude of gravity, m/s².
    #[inline]
    pub(crate) fn g(&self) -> f32 {
        self.gravity.length()
    }
}
