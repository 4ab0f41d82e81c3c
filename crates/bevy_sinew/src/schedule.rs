//! When things happen: the system sets of a tick and of a substep, and the driver that runs the substeps.

use bevy::ecs::message::signal_message_update_system;
use bevy::ecs::schedule::{InternedScheduleLabel, ScheduleLabel, SingleThreadedExecutor};
use bevy::prelude::*;

use crate::world::SinewWorld;

/// The parts of a tick, in this order, in `FixedPostUpdate` (or wherever [`SinewPlugin`](crate::SinewPlugin) was told to run).
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
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

/// One substep. Run by the driver; add systems to it, but do not run it.
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

/// Sets up the sets, their order and the phases.
pub(crate) fn configure(app: &mut App, tick: InternedScheduleLabel) {
    app.configure_sets(
        tick,
        (
            SinewSystems::Build,
            SinewSystems::Gather,
            SinewSystems::Substeps,
            SinewSystems::Scatter,
            SinewSystems::Extract,
        )
            .chain()
            // Bevy's own system in `FixedPostUpdate`; the order does not matter, but an ambiguity would be an error.
            .before(signal_message_update_system),
    );
    // While time stands still, bodies are built, gathered and extracted all the same: what is spawned or moved meanwhile is seen. The
    // condition stands on a set around the rest, so that it is asked once a tick and not once a part.
    app.configure_sets(tick, (SinewSystems::Substeps, SinewSystems::Scatter).in_set(TimePasses));
    app.configure_sets(tick, TimePasses.run_if(running));
    app.add_systems(tick, run_substeps.in_set(SinewSystems::Substeps));
    app.add_systems(
        tick,
        count_tick.in_set(TimePasses).after(SinewSystems::Scatter).before(SinewSystems::Extract),
    );

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
    let ran = world.try_schedule_scope(SubstepSchedule, |world, schedule| {
        for _ in 0..substeps {
            schedule.run(world);
        }
    });
    debug_assert!(ran.is_ok(), "the substep schedule was taken out from under its driver");
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
