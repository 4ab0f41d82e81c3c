//! When things happen: the schedules and the system sets of a tick and of a substep, and what drives them.

use bevy::ecs::message::signal_message_update_system;
use bevy::ecs::schedule::{InternedScheduleLabel, ScheduleLabel, SingleThreadedExecutor};
use bevy::prelude::*;

use crate::world::SinewWorld;

/// The parts of a tick, in this order, in [`SinewTick`]: a system of a game's own that belongs between two of them is added there.
///
/// In `FixedPostUpdate` (or wherever [`SinewPlugin`](crate::SinewPlugin) was told to run) one system runs the whole tick, and it is in all of these
/// sets: `.before(SinewSystems::Build)` there is before the tick, `.after(SinewSystems::Extract)` after it, and a place between two of them is a
/// cycle, which Bevy refuses.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum SinewSystems {
    /// Recipes of new bodies become particles and constraints.
    Build,
    /// Components are copied into the solver's columns; what is wrong is set aside.
    Gather,
    /// [`SubstepSchedule`] runs, once for each substep.
    Substeps,
    /// The columns are copied back into the components.
    Scatter,
    /// Transforms and velocities of bodies are read off their particles.
    Extract,
}

/// The phases of a substep, in this order, in [`SubstepSchedule`].
///
/// A game adds a force of its own to [`AccumulateForces`](Self::AccumulateForces) with `.in_set(...)`, or puts a system between two sets; it works on
/// the columns of [`SinewWorld`].
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum PhaseSystems {
    /// Gravity, the game's own forces and springs are summed up; so is what a game adds to this set, in any order.
    AccumulateForces,
    /// The pressure of winds is added.
    Wind,
    /// The buoyancy of fluids is added.
    Buoyancy,
    /// The forces between charges are added.
    Electric,
    /// Verlet predicts the next positions.
    Integrate,
    /// The constraints correct them.
    SolveConstraints,
}

/// What happens only while time passes.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct TimePasses;

/// One tick, all of it on one thread: its systems take microseconds each and wait for each other, while spreading them over threads takes
/// microseconds for each, too. (The solver has [threads](crate::SinewWorkers) of its own.) Run by the plugin; add systems to it, but do not run it.
#[derive(ScheduleLabel, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct SinewTick;

/// One substep, of a world that has particles. Run by the driver; add systems to it, but do not run it.
#[derive(ScheduleLabel, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct SubstepSchedule;

/// Pauses the simulation, or lets it run tick by tick.
#[derive(Resource, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[reflect(Resource, Default, Clone)]
pub struct SinewControl {
    /// Whether time stands still. Bodies that are spawned meanwhile are built all the same.
    pub paused: bool,
    /// Ticks to run although it is paused; each takes one off.
    pub single_steps: u32,
}

impl SinewControl {
    /// Whether the next tick is to be simulated.
    pub fn running(&self) -> bool {
        !self.paused || self.single_steps > 0
    }
}

/// Simulated time. Part of the state: save and restore it with the components.
#[derive(Resource, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Resource, Default, Clone)]
pub struct SinewClock {
    /// Ticks taken.
    pub tick: u64,
    /// Seconds simulated; gusts of wind depend on it.
    pub seconds: f64,
}

/// How long a tick took, for whoever shows it. Wall-clock time: never part of the state.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub struct TickTime {
    /// Duration of all substeps of the last tick.
    pub substeps: core::time::Duration,
}

/// The parts of a tick in their order.
const PARTS: [SinewSystems; 5] = [
    SinewSystems::Build,
    SinewSystems::Gather,
    SinewSystems::Substeps,
    SinewSystems::Scatter,
    SinewSystems::Extract,
];

/// Sets up the sets, their order and the phases, and has a schedule run the tick.
pub(crate) fn configure(app: &mut App, within: InternedScheduleLabel) {
    let whole = PARTS.into_iter().fold(run_tick.into_configs(), |tick, part| tick.in_set(part));
    // Bevy's own system in `FixedPostUpdate`; the order does not matter, but an ambiguity would be an error.
    app.add_systems(within, whole.before(signal_message_update_system));

    app.init_schedule(SinewTick);
    app.edit_schedule(SinewTick, |schedule| {
        schedule.set_executor(SingleThreadedExecutor::new());
        let [build, gather, substeps, scatter, extract] = PARTS;
        schedule.configure_sets((build, gather, substeps, scatter, extract).chain());
        // While time stands still, bodies are built, gathered and extracted all the same: what is spawned or moved meanwhile is seen. The
        // condition stands on a set around the rest, so that it is asked once a tick and not once a part.
        schedule.configure_sets((substeps, scatter).in_set(TimePasses));
        schedule.configure_sets(TimePasses.run_if(running));
        schedule.add_systems((
            run_substeps.in_set(substeps),
            count_tick.in_set(TimePasses).after(scatter).before(extract),
        ));
    });

    app.init_schedule(SubstepSchedule);
    app.edit_schedule(SubstepSchedule, |schedule| {
        // A phase takes microseconds and needs the phase before it: there is nothing for a second thread to do between them.
        schedule.set_executor(SingleThreadedExecutor::new());
        schedule.configure_sets(
            (
                PhaseSystems::AccumulateForces,
                PhaseSystems::Wind,
                PhaseSystems::Buoyancy,
                PhaseSystems::Electric,
                PhaseSystems::Integrate,
                PhaseSystems::SolveConstraints,
            )
                .chain(),
        );
        // The sums are cleared before the first set, so that forces add up in whatever order the systems of a set run.
        schedule.add_systems((
            begin_substep.before(PhaseSystems::AccumulateForces),
            accumulate_forces
                .in_set(PhaseSystems::AccumulateForces)
                .ambiguous_with(PhaseSystems::AccumulateForces),
            apply_wind.in_set(PhaseSystems::Wind).ambiguous_with(PhaseSystems::Wind),
            apply_buoyancy.in_set(PhaseSystems::Buoyancy).ambiguous_with(PhaseSystems::Buoyancy),
            apply_electric.in_set(PhaseSystems::Electric).ambiguous_with(PhaseSystems::Electric),
            integrate.in_set(PhaseSystems::Integrate),
            solve_constraints.in_set(PhaseSystems::SolveConstraints),
        ));
    });
}

/// Whether this tick is to be simulated.
fn running(control: Res<SinewControl>) -> bool {
    control.running()
}

/// Runs a tick.
fn run_tick(world: &mut World) {
    let ran = world.try_run_schedule(SinewTick);
    debug_assert!(ran.is_ok(), "the schedule of a tick was taken out from under its driver");
}

/// The systems of ours in a substep.
const PHASES: usize = 7;

/// Runs the substeps of a tick. The schedule is taken out of the world once, not once a substep.
fn run_substeps(world: &mut World) {
    let dt = world.resource::<Time>().delta_secs();
    let began = std::time::Instant::now();
    let substeps = {
        let mut sinew = world.resource_mut::<SinewWorld>();
        match sinew.simulation.begin_step(dt) {
            Ok(substeps) => substeps,
            // A clock that stands still is no fault: nothing happens, and nothing changes.
            Err(_) => return,
        }
    };
    let mut sinew = world.resource_mut::<SinewWorld>();
    if sinew.simulation.particles.is_empty() {
        // Nothing is there to be moved: time passes, by as many small sums as otherwise, so that it comes out the same.
        let length = f64::from(sinew.simulation.substep().length);
        (0..substeps).for_each(|_| sinew.simulation.time += length);
    } else {
        let ran = world.try_schedule_scope(SubstepSchedule, |world, schedule| {
            // Where no system of a game works between the phases, and they do the same to all, nothing is lost by taking them at once.
            if schedule.systems_len() == PHASES {
                world.resource_mut::<SinewWorld>().simulation.take_substeps();
            }
            for _ in 0..world.resource::<SinewWorld>().substep().remaining {
                schedule.run(world);
            }
        });
        debug_assert!(ran.is_ok(), "the substep schedule was taken out from under its driver");
    }
    world.resource_mut::<SinewWorld>().simulation.end_step();
    world.resource_mut::<TickTime>().substeps = began.elapsed();
}

/// Advances the clock and takes a single step off.
fn count_tick(
    mut clock: ResMut<SinewClock>,
    mut control: ResMut<SinewControl>,
    world: Res<SinewWorld>,
) {
    // A fixed clock that stood still took no tick.
    if clock.seconds == world.simulation.time {
        return;
    }
    clock.tick += 1;
    clock.seconds = world.simulation.time;
    if control.paused {
        control.single_steps = control.single_steps.saturating_sub(1);
    }
}

fn begin_substep(mut world: ResMut<SinewWorld>) {
    world.simulation.begin_substep();
}

fn accumulate_forces(mut world: ResMut<SinewWorld>) {
    world.simulation.accumulate_forces();
}

fn apply_wind(mut world: ResMut<SinewWorld>) {
    world.simulation.apply_wind();
}

fn apply_buoyancy(mut world: ResMut<SinewWorld>) {
    world.simulation.apply_buoyancy();
}

fn apply_electric(mut world: ResMut<SinewWorld>) {
    world.simulation.apply_electric();
}

fn integrate(mut world: ResMut<SinewWorld>) {
    world.simulation.integrate();
}

fn solve_constraints(mut world: ResMut<SinewWorld>) {
    world.simulation.solve_constraints();
}
