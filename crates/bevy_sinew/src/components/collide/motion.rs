//! What is kept of a collider from tick to tick: where it was, which is state, and what was made of it, which is scratch.

use bevy::prelude::*;

use super::ColliderFault;
use crate::components::CreationOrder;

/// Where a [`Collider`](super::Collider) was when the last tick ended, in the world: from there it goes to where its `Transform` is in the next one,
/// and takes along what lies on it. Part of the state: save and restore it with the rest.
///
/// To have it jump, taking nothing along, set it to `None` (or remove it) when you move the `Transform`. It is `None` until the first tick.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct ColliderMotion(pub Option<Isometry3d>);

/// What was made of a collider for the tick at hand. Scratch: made afresh where something has changed.
#[derive(Component, Default)]
pub(crate) struct PlacedCollider {
    /// Where it is, on top of its parents.
    pub(crate) at: Transform,
    /// The collider as the solver has it. Behind a pointer, because a part of a body has none.
    pub(crate) made: Option<Box<sinew::Collider>>,
    /// Why it is set aside, if it is.
    pub(crate) fault: Option<ColliderFault>,
    /// Whether it is set aside because a parent shears it.
    pub(crate) misplaced: bool,
    /// The gathering that it last took part in, counted from 1.
    pub(crate) seen: u64,
    /// Its number in the solver's list, the listing in which it got it, counted from 1, and what decided it.
    pub(crate) number: usize,
    pub(crate) listing: u64,
    pub(crate) order: CreationOrder,
}

impl PlacedCollider {
    /// What the solver is told, if nothing is wrong with it.
    pub(crate) fn sound(&self) -> Option<&sinew::Collider> {
        self.made.as_deref().filter(|_| self.fault.is_none() && !self.misplaced)
    }
}
