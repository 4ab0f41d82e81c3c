//! The environment of the particles: fields that fill space, and surfaces that bound it. A resource where there can be only one, an entity each where there may
//! be several.
//!
//! | file | contents |
//! |---|---|
//! | `gravity` | [`Gravity`], [`Attractor`] |
//! | `wind` | air: [`AirDrag`], [`Wind`], [`AirFlow`] |
//! | `fluid` | [`Fluid`], and [`Floats`] for bodies that float by their shape |
//! | `electric` | [`Electric`], [`ElectricField`] |
//! | `region` | where a field acts: [`Region`] |
//! | `bounds` | [`Ground`], [`BoundingBox`], [`Flatland`] |
//!
//! All of these may be edited at any time; a change takes effect in the next tick. One with an invalid number has no effect, with one
//! [`Refused`](crate::Refused) message, until it is corrected. Each is placed where its entity is, on top of its parents, and turned and scaled with them, so
//! that a fan may be mounted on a cart; forces, pressures and velocities are those of the world, whatever the scale.

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
