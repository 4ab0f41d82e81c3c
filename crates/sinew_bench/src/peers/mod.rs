//! The rival: rapier3d, the fastest physics engine in Rust that has soft bodies, on the same scenes in the same run.
//!
//! It is told the same masses, lengths, substeps and sweeps where it can be; what it does otherwise is said in the files of this folder and
//! in the notes of the rows. Without the feature `peers` there is none, and every figure is missing.

#[cfg(feature = "peers")]
mod figures;
#[cfg(feature = "peers")]
mod strings;

use sinew::Simulation;

use crate::measure::{Effort, World};

/// Substeps that it takes by default; it calls them iterations of its solver.
pub const SUBSTEPS: u32 = 4;

/// Whether there is a rival in this build.
pub const THERE: bool = cfg!(feature = "peers");

/// A world of hard distances as one soft body.
pub fn soft(effort: &Effort, world: &Simulation) -> Option<Box<dyn World>> {
    #[cfg(feature = "peers")]
    return effort.peers.then(|| Box::new(strings::soft(world)) as _);
    #[cfg(not(feature = "peers"))]
    none(effort, world)
}

/// `side × side` boxes at rest on the ground.
pub fn boxes(effort: &Effort, side: u32) -> Option<Box<dyn World>> {
    #[cfg(feature = "peers")]
    return effort.peers.then(|| Box::new(figures::boxes(side)) as _);
    #[cfg(not(feature = "peers"))]
    none(effort, side)
}

/// `edge³` boxes that fall into a heap, with so many substeps.
pub fn heap(effort: &Effort, edge: u32, substeps: u32) -> Option<Box<dyn World>> {
    #[cfg(feature = "peers")]
    return effort.peers.then(|| Box::new(figures::heap(edge).with(substeps)) as _);
    #[cfg(not(feature = "peers"))]
    none(effort, (edge, substeps))
}

/// `side × side` ragdolls that fall on a floor.
pub fn ragdolls(effort: &Effort, side: u32) -> Option<Box<dyn World>> {
    #[cfg(feature = "peers")]
    return effort.peers.then(|| Box::new(figures::ragdolls(side)) as _);
    #[cfg(not(feature = "peers"))]
    none(effort, side)
}

/// The same on stairs, with so many substeps.
pub fn on_stairs(effort: &Effort, side: u32, substeps: u32) -> Option<Box<dyn World>> {
    #[cfg(feature = "peers")]
    return effort.peers.then(|| Box::new(figures::on_stairs(side).with(substeps)) as _);
    #[cfg(not(feature = "peers"))]
    none(effort, (side, substeps))
}

#[cfg(not(feature = "peers"))]
fn none<T>(_: &Effort, _: T) -> Option<Box<dyn World>> {
    None
}
