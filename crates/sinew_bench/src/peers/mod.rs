//! The same scenes in other engines, in the same run: rapier3d, the fastest physics engine in Rust with soft bodies, and Avian, a physics engine for Bevy, in
//! the rigid-body scenes of a user.
//!
//! Masses, lengths, substeps and sweeps are the same where possible; differences are noted in the files of this module and in the notes of the rows. Without
//! the feature `peers` no other engine is built, and its figures are missing.

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

/// Default number of substeps of rapier, which it calls solver iterations.
pub const SUBSTEPS: u32 = 4;

/// Sets a scene up in each engine of this build, if other engines are requested.
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

/// Whether this build includes another engine.
pub const THERE: bool = cfg!(feature = "peers");

/// A simulation of hard distances as one soft body.
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

/// `edge³` boxes that fall into a heap, with a number of substeps.
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

/// Ragdolls that fall on stairs, with a number of substeps.
pub fn on_stairs(effort: &Effort, side: u32, substeps: u32) -> Option<Box<dyn World>> {
    #[cfg(feature = "peers")]
    return effort.peers.then(|| Box::new(figures::on_stairs(side).with(substeps)) as _);
    #[cfg(not(feature = "peers"))]
    none(effort, (side, substeps))
}

/// A user scene in rapier, and in Avian in a build with the feature `avian`.
#[derive(Default)]
pub struct Rivals {
    /// rapier by itself, without an app.
    pub rapier: Option<Box<dyn World>>,
    /// Avian in an app.
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

/// A hundred ragdolls that may sleep, above stairs with steps of height `rise`, metres, and a floor; without stairs if it is 0.
pub fn figures(effort: &Effort, rise: f32) -> Rivals {
    rivals!(effort, figures(rise))
}

#[cfg(not(feature = "peers"))]
fn none<T>(_: &Effort, _: T) -> Option<Box<dyn World>> {
    None
}
