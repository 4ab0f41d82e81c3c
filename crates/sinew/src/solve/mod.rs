//! Solving: in which order the kernels of the [constraints](crate::constraints) run, and how often.
//!
//! - `plan` compiles the constraints, island by island, into groups of one kind and colour, and updates them incrementally where few constraints were added or
//!   removed.
//! - `world` distributes islands to threads for one substep, `island_step` for a whole step. `island` solves one, until its largest error is small enough or
//!   its sweeps are used up.
//! - `context` is the context of a substep, `task_slice` the columns of one task or island, `sweep_scratch` the scratch of a thread's sweeps.
//! - `microsteps` takes a large soft island through a substep in smaller steps. When a step ends, `relaxation` spreads out the errors that remain, and
//!   `strain_limit` brings rods that are off by more than 3 % within that.
//! - `pressed_cloth` is large cloth in contact with other bodies' shapes: which particles move along with one that is pushed, and how rods and tethers are
//!   projected between turns of the contacts.
//! - `rod_graph` lists the rods at each particle.
//! - `instances` solves islands of the same topology side by side, stored as `lane_particles`.
//! - `wavefront` pipelines all substeps of a step through a large island of rods (temporal blocking), on one or several threads.
//! - `rods` projects hard rods eight at a time, `chains` solves those of a rope directly, and `tethers` bound the distances of particles from their pins.
//! - `wide` projects most other constraints eight at a time.
//! - `gauss_seidel`, `most_violated_first` and `jacobi` are the orders of a sweep. `column_sweep` is Gauss–Seidel for large cloth. `parts` are the bodies tied
//!   to that, and `tie_rods` the cloth's rods near the ties, which are swept more often; both work on `mixed_places`.
//! - `constraint_ref` refers to one constraint of the plan, of any kind.
//! - `remaining` is what instance batches and wavefronts leave of a task.
//! - `momentum` removes momentum that corrections must not add; `damping` is internal friction of a body.
//! - `recovery` bounds the speed at which violations are recovered.
//! - `multipliers` are the multipliers of compliant constraints; `measure` measures the remaining errors.
//! - `loads` measures the forces of single constraints.
//! - `report` is the solver's report.

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
mod mixed_places;
mod momentum;
mod most_violated_first;
mod multipliers;
mod parts;
mod pivot;
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
pub(crate) use momentum::keeps_momenta;
pub(crate) use pivot::Pins;
pub(crate) use plan::{Change, Changes, GroupKind, List, Plan, PlanInput};
pub(crate) use recovery::limit_all_recoveries;
pub(crate) use sweep_scratch::SweepScratch;
pub(crate) use world::{SolveScratch, derive_all, propagate_impacts, solve_all};
