//! What rigid parts remember of what they touch.

use bevy::prelude::*;
use sinew::CachedManifold;

/// What a rigid part remembers of those that it touches: where they touch, and from where friction holds them, so that a stack on a slope stays where
/// it is. Part of the state: save and restore it with the rest.
///
/// Every [`Collider`](super::Collider) has one, and it is empty but on the parts of bodies with [`BodyContacts`](super::BodyContacts). The rods of a
/// body that collides by its segments ([`ContactShape::Segments`](super::ContactShape)) are given one. What is remembered goes by the
/// [`CreationOrder`](crate::CreationOrder) of those who touch. Without it (a scene file does not hold it) friction begins anew.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct ContactCache(#[reflect(ignore)] pub(crate) Vec<CachedManifold>);

impl ContactCache {
    /// How many contacts it holds, of those that it keeps: of two parts that touch, the older one does.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether it holds none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}
