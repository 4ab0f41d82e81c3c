//! Moving air. [`Wind`] is a pressure that depends only on direction and silhouette. [`AirFlow`] is a velocity, so things slow down, lift and fall in it as in
//! real air. Both act on the triangles of [`Forces::surfaces`](super::Forces::surfaces), everywhere or in a [`Region`](super::Region), steadily or in gusts.

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
