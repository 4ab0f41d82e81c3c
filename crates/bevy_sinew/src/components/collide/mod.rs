//! Collision: colliders, surfaces, and how bodies take part in contacts.
//!
//! | file | contents |
//! |---|---|
//! | `collider` | [`Collider`]: a static or kinematic shape; on a rigid part, the shape by which it collides |
//! | `mesh` | colliders from meshes |
//! | `motion` | [`ColliderMotion`]: where a collider was a tick ago |
//! | `contact_cache` | [`ContactCache`]: the cached manifolds of a rigid part |
//! | `surface` | [`SurfaceMaterial`], [`CollisionLayers`]: on colliders and on bodies; [`Sensor`]: on colliders |
//! | `events` | [`ContactEvents`] and the events that it enables |
//! | `weight` | [`Weighs`]: the weight of a kinematic collider |
//! | `body` | [`BodyContacts`]: by which shape a body collides, and with what; [`ContactsDisabled`]; [`RestPlace`] |
//!
//! All of these may be added, edited and removed at any time; a change takes effect in the next tick.

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

pub(crate) use events::{Orphans, end_contacts};
pub(crate) use motion::PlacedCollider;
