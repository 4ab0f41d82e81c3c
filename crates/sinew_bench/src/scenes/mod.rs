//! The scenes of the table of goals, each a function from the effort to rows; one file for each family.

mod allocations;
#[cfg(feature = "plugin")]
mod app;
pub mod bending;
pub mod bodies;
mod calm;
pub mod charges;
pub mod cloth;
mod quality;
pub mod ropes;
mod threads;
#[cfg(feature = "plugin")]
mod user;

use sinew::{Simulation, SolverSettings};

use crate::measure::Effort;
use crate::row::Row;

/// A line of the table of goals.
#[derive(Clone, Copy, Debug)]
pub struct Scene {
    /// Its number: "P1".
    pub id: &'static str,
    /// Measures the scene.
    pub run: fn(&Effort) -> Vec<Row>,
}

const fn scene(id: &'static str, run: fn(&Effort) -> Vec<Row>) -> Scene {
    Scene { id, run }
}

/// An empty simulation.
pub fn empty(settings: SolverSettings) -> Simulation {
    let mut world = Simulation::default();
    world.settings = settings;
    world
}

/// All scenes, in the order of the table.
pub const SCENES: &[Scene] = &[
    scene("P1", cloth::grid),
    scene("P2", cloth::mesh),
    scene("P3", ropes::run),
    scene("P4", bending::run),
    scene("P5", bodies::side_by_side),
    scene("P6", bodies::ragdolls),
    scene("P7", threads::million),
    scene("P8", threads::many),
    scene("P9", charges::run),
    #[cfg(feature = "plugin")]
    scene("P10", app::come_and_go),
    #[cfg(feature = "plugin")]
    scene("P11", app::ticks),
    #[cfg(feature = "plugin")]
    scene("P12", app::mesh_out),
    scene("P13", allocations::run),
    #[cfg(feature = "plugin")]
    scene("P13", app::allocations),
    scene("P14", quality::run),
    #[cfg(feature = "plugin")]
    scene("U1", user::u1),
    #[cfg(feature = "plugin")]
    scene("U2", user::u2),
    #[cfg(feature = "plugin")]
    scene("U3", user::u3),
    #[cfg(feature = "plugin")]
    scene("U4", user::u4),
    #[cfg(feature = "plugin")]
    scene("U5", user::u5),
    #[cfg(feature = "plugin")]
    scene("U6", user::u6),
    #[cfg(feature = "plugin")]
    scene("U7", user::u7),
    #[cfg(feature = "plugin")]
    scene("U8", user::u8),
    #[cfg(feature = "plugin")]
    scene("U9", user::u9),
    #[cfg(feature = "plugin")]
    scene("U10", user::u10),
    #[cfg(feature = "plugin")]
    scene("U11", user::u11),
    #[cfg(feature = "plugin")]
    scene("U12", user::u12),
    #[cfg(feature = "plugin")]
    scene("U13", user::u13),
];
