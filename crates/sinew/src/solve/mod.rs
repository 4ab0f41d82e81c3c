//! Solving: in which order the kernels of the [constraints](crate::constraints) run, and how often.
//!
//! - `plan` compiles the constraints into islands, and each island into groups of one kind and colour, and mends them where few constraints came or
//!   went;
//! - `world` deals islands out to threads, `alone` for whole steps; `island` solves one: until the largest error in it is small enough or the sweeps
//!   are spent;
//! - `flock` takes islands that are built alike side by side;
//! - `wave` takes the substeps of a step through a large island of rods one behind the other, and several threads one behind the other, too;
//! - `rods` takes hard rods eight by eight;
//! - `wide` takes most other constraints eight by eight;
//! - `cascade`, `worst_first` and `jacobi` are the orders of a sweep;
//! - `item` is one constraint of the plan, whatever its kind;
//! - `rest` is what flocks and waves leave of a task;
//! - `momentum` keeps round-off out of what constraints cannot change; `damping` is friction inside a body;
//! - `sums` are the multipliers of soft constraints; `measure` looks at what is left to correct;
//! - `report` says how it went, `settings` how hard to try.

mod alone;
mod cascade;
mod damping;
mod flock;
mod island;
mod item;
mod jacobi;
mod measure;
mod momentum;
mod plan;
mod report;
mod rest;
mod rods;
mod settings;
mod sums;
mod wave;
mod wide;
mod world;
mod worst_first;

pub use report::{IslandReport, SolverReport};
pub use settings::{BodySettings, Order, SolverSettings};

pub(crate) use alone::advance_all;
pub(crate) use damping::Damping;
pub(crate) use island::{Common, Room};
pub(crate) use item::soft_energy;
pub(crate) use measure::measure;
pub(crate) use momentum::is_free;
pub(crate) use plan::{Change, Changes, Given, List, Plan};
pub(crate) use world::{Machine, Scratch, settle_all, solve_all};
