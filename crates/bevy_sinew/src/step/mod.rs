//! The systems around the substeps: they copy components into the solver's columns, and columns back into components.

pub(crate) mod bodies;
pub(crate) mod body_colliders;
pub(crate) mod colliders;
pub(crate) mod contact_cache;
pub(crate) mod contact_shape;
pub(crate) mod controls;
pub(crate) mod environment;
pub(crate) mod extract;
pub(crate) mod gather;
pub(crate) mod hulls;
pub(crate) mod ignored;
pub(crate) mod layout;
pub(crate) mod links;
pub(crate) mod motion;
pub(crate) mod pins;
pub(crate) mod representation;
pub(crate) mod scatter;
pub(crate) mod segments;
pub(crate) mod shares;
pub(crate) mod sleep;
pub(crate) mod teleports;
pub(crate) mod touching;
pub(crate) mod weights;

pub use links::RegisterParticleConstraint;
