//! Air that moves: the lectures' [`Wind`], a pressure that only direction and silhouette matter to, and an [`AirFlow`], which is a velocity, so that
//! things slow down, lift and fall in it as they do in air. Both blow on the triangles of
//! [`Forces::surfaces`](super::Forces::surfaces), everywhere or in a [`Region`](super::Region), steadily or in gusts.

mod air;
#[cfg(test)]
mod air_tests;
mod gusts;
mod pressure;
mod surfaces;

pub use air::AirFlow;
pub use pressure::Wind;

pub(crate) use air::{Air, apply as apply_air, sample as sample_air};
pub(crate) use pressure::{Pressures, apply as apply_wind};
pub(crate) use surfaces::PackedSurfaces;
