//! What the parts of contacts are told of a world.

use glam::Vec3;

use super::body_collider::BodyCollider;
use super::collider::Collider;
use super::filter::ContactFilter;
use crate::constraints::Boundaries;
use crate::islands::Islands;

/// What a world has that contacts depend on.
#[derive(Clone, Copy)]
pub(crate) struct World<'a> {
    pub(crate) boundaries: &'a Boundaries,
    pub(crate) colliders: &'a [Collider],
    pub(crate) body_colliders: &'a [BodyCollider],
    pub(crate) filter: &'a ContactFilter,
    pub(crate) islands: &'a Islands,
    /// Length of the step, seconds, and its substeps.
    pub(crate) dt: f32,
    pub(crate) substeps: u32,
    /// Gravity, m/s².
    pub(crate) gravity: Vec3,
    /// Whether nothing moves in this step, neither particles nor colliders, and nobody listens to contacts.
    pub(crate) at_rest: bool,
}

impl World<'_> {
    /// Magnitude of gravity, m/s².
    #[inline]
    pub(crate) fn g(&self) -> f32 {
        self.gravity.length()
    }
}
