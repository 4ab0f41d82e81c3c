//! Every claim of the physics, run and measured: one case for each, shared by the tests and by `cargo run --example physics_report`.
//!
//! A [`Case`] builds a simulation, runs it and returns [`Row`]s: the value by a formula, the value by the solver, and the tolerance. The tolerance is derived
//! from the order of the method at the step that is used, and the derivation is beside the number; it is never loosened to make a row pass. Each case is also a
//! test of this crate, named after what it shows.
//!
//! | module | content |
//! |---|---|
//! | `integrators` | I1 to I9: parabola, damping, variable steps, orders, reversal |
//! | `forces`, `air`, `media` | F1 to F9: springs, charges; wind; fluids, friction, statics |
//! | `constraints`, `shapes` | C1 to C11: distances, limits and boundaries; planes, lines, areas, volumes and bending |
//! | `solver` | gradients, sweeps, substeps, softness, conservation in a long run |
//! | `compounds`, `readback`, `bodies` | B1 to B3: boxes and pendulums; E1 to E3: pose, motion, inertia; B2', M1, M2: rigid shapes and rigid bodies |
//! | `rolling` | K1 to K3: rolling, slipping and spinning of round shapes |
//! | `impacts` | K5 and K6: momentum and energy in collisions |
//! | `loads` | K7, K8 and K10: stacks, bodies at rest, and slopes |
//! | `far` | the same results 5 km from the origin |
//! | `plots` | the plots |
//! | `table` | the page as text, and as JSON |

mod air;
mod bodies;
mod case;
mod compounds;
mod constraints;
mod far;
mod forces;
mod impacts;
mod integrators;
mod loads;
mod measure;
mod media;
pub mod plots;
mod readback;
mod rolling;
mod row;
mod shapes;
mod solver;
mod table;

pub use case::{Case, Chapter};
pub use row::{Allowed, Row};
pub use table::{json, table};

/// The chapters of the report, in the order of `physics.md`.
pub const CHAPTERS: &[Chapter] = &[
    Chapter { title: "State and integration", groups: &[integrators::CASES] },
    Chapter { title: "Forces", groups: &[forces::CASES, air::CASES, media::CASES] },
    Chapter { title: "Positional constraints", groups: &[constraints::CASES, shapes::CASES] },
    Chapter { title: "The solver", groups: &[solver::CASES] },
    Chapter {
        title: "Compounds and their poses",
        groups: &[compounds::CASES, readback::CASES, bodies::CASES],
    },
    Chapter {
        title: "Contacts, verified",
        groups: &[rolling::CASES, impacts::CASES, loads::CASES],
    },
    Chapter { title: "Far from the origin", groups: &[far::CASES] },
];

/// All cases, in the order of the page.
pub fn cases() -> impl Iterator<Item = &'static Case> {
    CHAPTERS.iter().flat_map(Chapter::cases)
}
