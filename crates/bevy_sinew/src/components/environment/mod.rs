//! What surrounds the particles: fields that fill space, and the surfaces that bound it. A resource where there is one of a kind, an entity each
//! where there may be several.
//!
//! | file | what it holds |
//! |---|---|
//! | `gravity` | what pulls at everything: [`Gravity`], [`Attractor`] |
//! | `wind` | air: [`AirDrag`], [`Wind`], [`AirFlow`] |
//! | `fluid` | [`Fluid`], and what [`Floats`] in it by its shape |
//! | `electric` | [`Electric`], [`ElectricField`] |
//! | `region` | where a field acts: [`Region`] |
//! | `bounds` | [`Ground`], [`BoundingBox`], [`Flatland`] |
//!
//! All of it may be edited at any time, and acts from the next tick on. What has a broken number does nothing, with one
//! [`Refused`](crate::Refused) message, until it is mended. Each is where its entity is on top of its parents, turned and scaled as they are, so that a
//! fan may ride on a cart; forces, pressures and velocities are those of the world, whatever the scale.

mod bounds;
mod electric;
mod fluid;
mod gravity;
mod region;
mod wind;

pub use bounds::{BoundingBox, Flatland, Ground};
pub use electric::{Electric, ElectricField};
pub use fluid::{Floats, Fluid, HullShape};
pub use gravity::{Attractor, Gravity};
pub use region::{Region, RegionShape};
pub use wind::{AirDrag, AirFlow, Wind};
