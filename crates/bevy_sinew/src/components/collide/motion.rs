//! What is stored of a collider from tick to tick: its last placement, which is state, and the solver's collider, which is scratch.

use bevy::prelude::*;

use super::ColliderFault;
use crate::components::CreationOrder;

/// World placement of a [`Collider`](super::Collider) at the end of the last tick. In the next tick the collider moves from there to its `Transform`, and
/// carries along what rests on it. Part of the state: save and restore it with the rest.
///
/// For a jump that carries nothing along, set it to `None` (or remove it) when you move the `Transform`. It is `None` until the first tick.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
// A clone starts where it is put, not where its original was.
#[component(clone_behavior = Ignore)]
pub struct ColliderMotion(pub Option<Isometry3d>);

/// The solver's collider for the current tick. Scratch: computed again where something has changed.
#[derive(Component, Default)]
pub(crate) struct PlacedCollider {
    /// World placement, on top of the parents.
    pub(crate) at: Transform,
    /// The solver's collider. Boxed, because the colliders of body parts have none.
    pub(crate) made: Option<Box<sinew::Collider>>,
    /// Why it is set aside, if it is.
    pub(crate) fault: Option<ColliderFault>,
    /// Whether it is set aside because a parent shears it.
    pub(crate) misplaced: bool,
    /// The last gather in which it took part, counted from 1.
    pub(crate) last_gather: u64,
    /// Its index in the solver's list, the listing in which it was assigned, counted from 1, and the creation order by which it was sorted.
    pub(crate) number: usize,
    pub(crate) listing: u64,
    pub(crate) order: CreationOrder,
}

impl PlacedCollider {
    /// The solver's collider, if it has no fault.
    pub(crate) fn valid(&self) -> Option<&sinew::Collider> {
        self.made.as_deref().filter(|_| self.fault.is_none() && !self.misplaced)
    }
}
