//! The contact cache of rigid parts.

use bevy::prelude::*;
use sinew::CachedManifold;

/// The contact manifolds of a rigid part from the last tick: contact points, and friction anchors, so that a stack on a slope does not creep. Part of the
/// state: save and restore it with the rest.
///
/// Every [`Collider`](super::Collider) has one. It is empty except on the parts of bodies; the rods of a body that collides by its segments
/// ([`ContactShape::Segments`](super::ContactShape)) are given one. Manifolds are identified by the [`CreationOrder`](crate::CreationOrder) of the other
/// participant. Without the cache (a scene file does not contain it) friction starts anew.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct ContactCache(#[reflect(ignore)] pub(crate) Vec<CachedManifold>);

impl ContactCache {
    /// The number of manifolds that are stored here. Of two parts in contact, the older one stores the manifold.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether no manifold is stored here.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}
