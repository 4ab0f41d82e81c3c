//! Solving: in which order the kernels of the [constraints](crate::constraints) run, and how often.
//!
//! - `plan` compiles the constraints into islands, and each island into groups of one kind and colour;
//! - `island` solves one island: until the largest error in it is small enough or the sweeps are spent;
//! - `rods` takes hard rods eight by eight;
//! - `cascade`, `worst_first` and `jacobi` are the orders of a sweep;
//! - `item` is one constraint of the plan, whatever its kind;
//! - `momentum` keeps round-off out of what constraints cannot change;
//! - `report` says how it went, `settings` how hard to try.

mod cascade;
mod island;
mod item;
mod jacobi;
mod momentum;
mod plan;
mod report;
mod rods;
mod settings;
mod worst_first;

pub use report::{IslandReport, SolverReport};
pub use settings::{BodySettings, Order, SolverSettings};

pub(crate) use island::{Scratch, keep_momentum, measure, solve};
pub(crate) use item::soft_energy;
pub(crate) use momentum::is_free;
pub(crate) use plan::Plan;
