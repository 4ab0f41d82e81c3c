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
    /// Magnitude of gravity, m/s².
    #[inline]
    pub(crate) fn g(&self) -> f32 {
        self.gravity.length()
    }
}
