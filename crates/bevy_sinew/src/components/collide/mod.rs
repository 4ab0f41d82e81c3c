//! What may not pass through what: colliders, what surfaces are made of, and how bodies take part in contacts.
//!
//! | file | what it holds |
//! |---|---|
//! | `collider` | [`Collider`]: a shape that stands still or that the game moves; on a rigid part, the shape by which it collides |
//! | `mesh` | colliders from meshes |
//! | `motion` | [`ColliderMotion`]: where a collider was a tick ago |
//! | `contact_cache` | [`ContactCache`]: the cached manifolds of a rigid part |
//! | `surface` | [`SurfaceMaterial`], [`CollisionLayers`]: on colliders and on bodies; [`Sensor`]: on colliders |
//! | `events` | [`ContactEvents`]: what a game hears of contacts |
//! | `weight` | [`Weighs`]: the weight of what the game moves |
//! | `body` | [`BodyContacts`]: what of a body touches what; [`ContactsDisabled`]; [`RestPlace`] |
//!
//! All of it may be added, edited and removed at any time, and acts from the next tick on.

mod body;
mod collider;
mod contact_cache;
mod events;
mod fault;
mod mesh;
mod motion;
mod surface;
mod weight;

pub(crate) use body::ResolvedShape;
pub use body::{BodyContacts, ContactShape, ContactsDisabled, RestPlace};
pub use collider::{Collider, ColliderShape};
pub use contact_cache::ContactCache;
pub use events::{
    ContactEnded, ContactEvents, ContactImpulse, ContactStarted, Touching, WatchedContacts,
};
pub use fault::ColliderFault;
pub use motion::ColliderMotion;
pub use surface::{CollisionLayer, CollisionLayers, Combine, GroundDrag, Sensor, SurfaceMaterial};
pub use weight::Weighs;

pub(crate) use events::Orphans;
pub(crate) use motion::PlacedCollider;
