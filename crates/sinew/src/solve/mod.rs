//! Solving: in which order the kernels of the [constraints](crate::constraints) run, and how often.
//!
//! - `plan` compiles the constraints island by island into groups of one kind and colour, and updates them incrementally where few
//!   constraints were added or removed;
//! - `world` deals islands out to threads, `island_step` for whole steps; `island` solves one: until the largest error in it is small enough or the
//!   sweeps are spent;
//! - `context` is what all of them need to know of a substep, `task_slice` what a task or an island has to itself, `sweep_scratch` what a thread keeps the memory of to sweep it;
//! - `microsteps` takes a large soft island through a substep in smaller steps of its own; when a step ends `relaxation` shares out what is left of its errors, and
//!   `strain_limit` brings within 3 % those of its rods that are off by more;
//! - `pressed_cloth` is large cloth that shapes of other bodies press on: which particles go along with one that is pushed, and how rods and tethers hold them in between;
//! - `rod_graph` says which rods end at a particle;
//! - `instances` takes islands that are built alike side by side, as `lane_particles`;
//! - `wavefront` takes the substeps of a step through a large island of rods one behind the other, and several threads one behind the other, too;
//! - `rods` takes hard rods eight by eight; `chains` solves those of a rope at once; `tethers` hold what hangs on a pin through many of them;
//! - `wide` takes most other constraints eight by eight;
//! - `gauss_seidel`, `most_violated_first` and `jacobi` are the orders of a sweep; `column_sweep` is the first of them for large cloth; `parts` are what is tied to it,
//!   and `tie_rods` its rods about that, which are swept more often, on `turned_places`;
//! - `constraint_ref` is one constraint of the plan, whatever its kind;
//! - `remaining` is what instance batches and wavefronts leave of a task;
//! - `momentum` keeps round-off out of what constraints cannot change; `damping` is friction inside a body;
//! - `recovery` bounds the speed at which violations are recovered;
//! - `multipliers` are the multipliers of soft constraints; `measure` looks at what is left to correct;
//! - `loads` measures with what force single constraints hold;
//! - `report` says how it went.

mod chains;
mod column_sweep;
mod constraint_ref;
mod context;
mod damping;
mod gauss_seidel;
mod instances;
mod island;
mod island_step;
mod jacobi;
mod lane_particles;
mod loads;
mod measure;
mod microsteps;
mod momentum;
mod most_violated_first;
mod multipliers;
mod parts;
mod plan;
mod pressed_cloth;
mod recovery;
mod relaxation;
mod remaining;
mod report;
mod rod_graph;
mod rods;
mod strain_limit;
mod sweep_scratch;
mod task_slice;
mod tethers;
mod tie_rods;
mod turned_places;
mod wavefront;
mod wide;
mod world;

pub use report::{IslandReport, SolverReport};

pub(crate) use constraint_ref::soft_energy;
pub(crate) use context::{SolveContext, SubstepParameters};
pub(crate) use damping::Damping;
pub(crate) use island_step::advance_all;
pub(crate) use lane_particles::LaneParticles;
pub(crate) use loads::Loads;
pub(crate) use measure::{measure, measure_overlaps};
pub(crate) use microsteps::divide;
pub(crate) use momentum::is_free;
pub(crate) use plan::{Change, Changes, Given, GroupKind, List, Plan};
pub(crate) use recovery::limit_all_recoveries;
pub(crate) use sweep_scratch::SweepScratch;
pub(crate) use world::{SolveScratch, propagate_impacts, settle_all, solve_all};
