//! The rival: rapier3d, the fastest physics engine in Rust that has soft bodies, on the same scenes in the same run; beside it Avian, Bevy's own, in the rigid
//! scenes of a user.
//!
//! It is told the same masses, lengths, substeps and sweeps where it can be; what it does otherwise is said in the files of this folder and
//! in the notes of the rows. Without the feature `peers` there is none, and every figure is missing.

#[cfg(feature = "avian")]
mod avian;
#[cfg(feature = "peers")]
mod figures;
#[cfg(feature = "peers")]
mod limbs;
#[cfg(feature = "peers")]
mod strings;

use sinew::Simulation;

use crate::measure::{Effort, World};

/// Substeps that it takes by default; it calls them iterations of its solver.
pub const SUBSTEPS: u32 = 4;

/// Sets a scene up in each rival of this build, if rivals are asked for.
macro_rules! rivals {
    ($effort:expr, $scene:ident($which:expr)) => {{
        #[allow(unused_mut)]
        let mut rivals = Rivals::default();
        #[cfg(feature = "peers")]
        if $effort.peers {
            rivals.rapier = Some(Box::new(figures::$scene($which)));
        }
        #[cfg(feature = "avian")]
        if $effort.peers {
            rivals.avian = Some(Box::new(avian::$scene($which)));
        }
        #[cfg(not(feature = "peers"))]
        let _ = ($effort, $which);
        rivals
    }};
}

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

/// A scene of a user in rapier, and in Avian in a build with the feature `avian`.
#[derive(Default)]
pub struct Rivals {
    /// By itself, not in an app.
    pub rapier: Option<Box<dyn World>>,
    /// In an app.
    pub avian: Option<Box<dyn World>>,
}

/// A thousand boxes that lie side by side, and may sleep or not.
pub fn lying(effort: &Effort, sleep: bool) -> Rivals {
    rivals!(effort, lying(sleep))
}

/// A thousand boxes that fall and may sleep, in rows or poured between four walls.
pub fn pile(effort: &Effort, poured: bool) -> Rivals {
    rivals!(effort, pile(poured))
}

/// A hundred ragdolls that may sleep, above stairs of so high steps, or a floor.
pub fn figures(effort: &Effort, rise: f32) -> Rivals {
    rivals!(effort, figures(rise))
}

#[cfg(not(feature = "peers"))]
fn none<T>(_: &Effort, _: T) -> Option<Box<dyn World>> {
    None
}
