//! When things happen: the schedules and the system sets of a tick and of a substep, and what drives them.

mod phases;

pub(crate) use phases::is_shown;
pub use phases::{PhaseStep, PhaseSteps};

use core::time::Duration;
use std::time::Instant;

use bevy::ecs::message::signal_message_update_system;
use bevy::ecs::schedule::{InternedScheduleLabel, ScheduleLabel, SingleThreadedExecutor};
use bevy::prelude::*;

use crate::world::{PhaseWatch, SinewWorld, load_deferred};

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

/// Pauses the simulation, lets it run tick by tick (and phase by phase: [`PhaseSteps`]), or at a speed of its own. The game's clocks (`Time<Virtual>`, `Time<Fixed>`) are left alone, so
/// that menus, cameras and animations go on as they do.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// fn slow_motion(mut control: ResMut<SinewControl>) {
///     control.relative_speed = 0.25;
/// }
///
/// fn frame_by_frame(mut control: ResMut<SinewControl>) {
///     control.pause();
///     control.step();
/// }
/// # let mut app = App::new();
/// # app.add_plugins((MinimalPlugins, SinewPlugins));
/// # app.add_systems(Startup, (slow_motion, frame_by_frame));
/// # app.finish();
/// # app.update();
/// # assert!(app.world().resource::<SinewControl>().paused);
/// ```
///
/// A tick is as long at any speed: at half of it every other fixed tick of the game has one of the simulation, at twice of it each has two. So what is
/// stable stays stable, and what was simulated is the same, bit for bit, at any speed. [Interpolated](crate::Interpolate) bodies glide at all of
/// them. What a game moves by its own clock (a kinematic [`Collider`](crate::Collider), what something is [`PinnedTo`](crate::PinnedTo)) is that much
/// faster or slower to the simulation: multiply its speed by [`relative_speed`](Self::relative_speed) to have it slow down too.
#[derive(Resource, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Resource, Default, Clone, PartialEq)]
pub struct SinewControl {
    /// Whether time stands still. Bodies that are spawned meanwhile are built all the same. Default not.
    pub paused: bool,
    /// Ticks to run although it is paused; each takes one off. Default 0.
    pub single_steps: u32,
    /// Simulated seconds for each second of the schedule that runs the tick, 0 (as paused) to [`MAX_SPEED`](Self::MAX_SPEED). More counts as that, less
    /// and NaN as 0. Default 1. How many ticks a frame may take is bounded as ever, by `Time<Virtual>::max_delta` (0.25 s), times this.
    #[doc(alias = "time_scale")]
    #[doc(alias = "slow_motion")]
    pub relative_speed: f32,
}

impl Default for SinewControl {
    fn default() -> Self {
        Self { paused: false, single_steps: 0, relative_speed: 1.0 }
    }
}

impl SinewControl {
    /// The greatest [`relative_speed`](Self::relative_speed).
    pub const MAX_SPEED: f32 = 16.0;

    /// Whether the simulation goes on: it is not paused, at a speed that is not 0, or has single steps to take.
    pub fn running(&self) -> bool {
        (!self.paused && self.speed() > 0.0) || self.single_steps > 0
    }

    /// Stops the simulation.
    pub fn pause(&mut self) {
        self.paused = true;
    }

    /// Lets it go on; single steps that were not taken are dropped.
    pub fn unpause(&mut self) {
        (self.paused, self.single_steps) = (false, 0);
    }

    /// Lets a paused simulation take one tick more.
    pub fn step(&mut self) {
        self.single_steps = self.single_steps.saturating_add(1);
    }

    /// The speed that counts: in its range.
    fn speed(&self) -> f32 {
        // In this order, NaN is 0.
        if self.relative_speed.is_nan() {
            0.0
        } else {
            self.relative_speed.clamp(0.0, Self::MAX_SPEED)
        }
    }
}

/// Simulated time. Part of the state: save and restore it with the components.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::SinewClock;
/// fn after_a_minute(clock: Res<SinewClock>, mut exit: MessageWriter<AppExit>) {
///     if clock.seconds > 60.0 {
///         exit.write(AppExit::Success);
///     }
/// }
/// ```
#[derive(Resource, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Resource, Default, Clone)]
pub struct SinewClock {
    /// Ticks taken.
    pub tick: u64,
    /// Seconds simulated; gusts of wind depend on it.
    pub seconds: f64,
    /// Which part of the last tick is yet to be played, 0 to 1: at a [speed](SinewControl::relative_speed) that is no whole number, a tick is simulated when
    /// the first part of it is due. Default 0, and 0 while time stands still.
    pub ahead: f64,
}

/// What the tick at hand is one of, and what is drawn after it. Scratch.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub(crate) struct Pace {
    /// Ticks that are left to be taken in this fixed tick, this one included; 0 if time stands still in it.
    pub(crate) left: u32,
    /// Whether the last fixed tick played anything but one whole tick or none: then what is drawn lies between other places than where the last tick began and
    /// ended.
    pub(crate) uneven: bool,
    /// Whether a game has set a condition on one of the phases.
    conditional: bool,
    /// When the tick at hand began, on the wall.
    began: Option<Instant>,
}

/// How long the last tick took, for whoever shows it. Wall-clock time: never part of the state.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub struct TickTime {
    /// Duration of building bodies and of gathering.
    pub gather: Duration,
    /// Duration of all substeps.
    pub substeps: Duration,
    /// Duration of scattering and of extracting.
    pub scatter: Duration,
    /// Duration of each phase, in the order of [`PhaseSystems`], summed over the substeps, with what a game's systems did since the phase before; zero
    /// unless [`by_phase`](Self::by_phase).
    pub phases: [Duration; 6],
    /// Whether phases are measured: ask for it here. No substeps are taken at once then, which gives the same bits and takes longer. Default not.
    pub by_phase: bool,
}

/// The parts of a tick in their order.
const PARTS: [SinewSystems; 5] = [
    SinewSystems::Build,
    SinewSystems::Gather,
    SinewSystems::Substeps,
    SinewSystems::Scatter,
    SinewSystems::Extract,
];

/// The phases of a substep in their order.
const PHASE_ORDER: [PhaseSystems; 6] = [
    PhaseSystems::AccumulateForces,
    PhaseSystems::Wind,
    PhaseSystems::Buoyancy,
    PhaseSystems::Electric,
    PhaseSystems::Integrate,
    PhaseSystems::SolveConstraints,
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
        schedule.configure_sets(TimePasses.run_if(time_passes));
        schedule.add_systems((
            run_substeps.in_set(substeps),
            count_tick.in_set(TimePasses).after(scatter).before(extract),
        ));
    });

    app.init_schedule(SubstepSchedule);
    app.edit_schedule(SubstepSchedule, |schedule| {
        // A phase takes microseconds and needs the phase before it: there is nothing for a second thread to do between them.
        schedule.set_executor(SingleThreadedExecutor::new());
        let [forces, wind, buoyancy, electric, integration, constraints] = PHASE_ORDER;
        let order = (forces, wind, buoyancy, electric, integration, constraints);
        schedule.configure_sets(order.chain());
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
pub(crate) fn time_passes(pace: Res<Pace>) -> bool {
    pace.left > 0
}

/// Whether what is drawn lies elsewhere than between the ends of the last tick.
#[cfg(feature = "interpolation")]
pub(crate) fn is_uneven(pace: Res<Pace>) -> bool {
    pace.uneven
}

/// Runs the ticks that are due: one at full speed. Where none is, what is spawned or moved is built, gathered and extracted all the same.
fn run_tick(world: &mut World) {
    phases::choose(world);
    let due = ticks_due(world);
    for taken in 0..due.max(1) {
        let began = Instant::now();
        let mut pace = world.resource_mut::<Pace>();
        (pace.left, pace.began) = (due.saturating_sub(taken), Some(began));
        let ran = world.try_run_schedule(SinewTick);
        debug_assert!(ran.is_ok(), "the schedule of a tick was taken out from under its driver");
        if due > 0 {
            let mut took = world.resource_mut::<TickTime>();
            took.scatter = began.elapsed().saturating_sub(took.gather + took.substeps);
        }
    }
    let (ahead, uneven) = (world.resource::<SinewClock>().ahead, world.resource::<Pace>().uneven);
    if uneven {
        world.resource_mut::<SinewWorld>().play(ahead as f32, due > 0);
    }
    phases::show(world);
}

/// How many ticks are due in this fixed tick; counts the time that was played.
fn ticks_due(world: &mut World) -> u32 {
    let control = *world.resource::<SinewControl>();
    let mut clock = world.resource_mut::<SinewClock>();
    let before = clock.ahead;
    let due = if control.paused || control.speed() == 0.0 {
        // What is simulated is shown.
        clock.ahead = 0.0;
        control.single_steps.min(1)
    } else {
        let mut ahead = before - f64::from(control.speed());
        let mut due = 0;
        // No more than the greatest speed asks for, whatever somebody may have written there.
        while ahead < 0.0 && due < SinewControl::MAX_SPEED as u32 {
            ahead += 1.0;
            due += 1;
        }
        clock.ahead = if (0.0..1.0).contains(&ahead) { ahead } else { 0.0 };
        due
    };
    let even = before == 0.0 && clock.ahead == 0.0 && due <= 1;
    let was_uneven = core::mem::replace(&mut world.resource_mut::<Pace>().uneven, !even);
    if !even && !was_uneven {
        world.resource_mut::<SinewWorld>().play(0.0, false);
    }
    due
}

/// The systems of ours in a substep.
const PHASES: usize = 7;

/// Runs the substeps of a tick. The schedule is taken out of the world once, not once a substep.
fn run_substeps(world: &mut World) {
    let dt = world.resource::<Time>().delta_secs();
    let began = Instant::now();
    let by_phase = world.resource::<TickTime>().by_phase;
    let shown = world.resource::<PhaseSteps>().begins;
    let watched = by_phase || shown || world.resource::<SinewWorld>().tables.forces.is_some();
    let alone = !watched && runs_our_phases_alone(world);
    if alone && world.resource_mut::<SinewWorld>().step_at_rest(dt) {
        note_times(world, began, None);
        return;
    }
    load_deferred(world);
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
            // Where nobody stands between the phases, and they do the same to all, nothing is lost by taking them at once.
            if watched {
                let mut watch = PhaseWatch::default();
                watch.frames = shown.then(Vec::new);
                world.resource_mut::<SinewWorld>().tables.watch = Some(Box::new(watch));
            } else if alone {
                world.resource_mut::<SinewWorld>().simulation.take_substeps();
            }
            for _ in 0..world.resource::<SinewWorld>().substep().remaining {
                schedule.run(world);
            }
        });
        debug_assert!(ran.is_ok(), "the substep schedule was taken out from under its driver");
    }
    let mut sinew = world.resource_mut::<SinewWorld>();
    sinew.simulation.end_step();
    sinew.tables.stepped = true;
    let mut watch = sinew.tables.watch.take();
    let layout = sinew.tables.layout.number;
    if shown {
        world.resource_mut::<PhaseSteps>().take(watch.as_deref_mut(), substeps, layout);
    }
    note_times(world, began, watch.filter(|_| by_phase));
}

/// Whether no system and no condition of a game stands between the phases.
fn runs_our_phases_alone(world: &mut World) -> bool {
    let mut schedules = world.resource_mut::<Schedules>();
    let Some(schedule) = schedules.get_mut(SubstepSchedule) else { return false };
    // Conditions of sets are seen until the schedule is built with them, which it is when it runs.
    let sets = &schedule.graph().system_sets;
    let conditional = sets.iter().any(|(_, _, conditions)| !conditions.is_empty());
    // What came since it was built is counted when it is built again, by running.
    let counted = !schedule.is_changed() && schedule.systems_len() == PHASES;
    let mut pace = world.resource_mut::<Pace>();
    pace.conditional |= conditional;
    counted && !pace.conditional
}

/// Notes how long the parts of a tick took of which the substeps began then.
fn note_times(world: &mut World, began: Instant, watch: Option<Box<PhaseWatch>>) {
    let whole = world.resource::<Pace>().began.unwrap_or(began);
    let mut took = world.resource_mut::<TickTime>();
    took.substeps = began.elapsed();
    took.gather = began.duration_since(whole);
    took.phases = watch.map_or_else(Default::default, |watch| watch.took);
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
    world.begin_phases();
}

fn accumulate_forces(mut world: ResMut<SinewWorld>) {
    world.simulation.accumulate_forces();
    world.end_phase(0);
}

fn apply_wind(mut world: ResMut<SinewWorld>) {
    world.simulation.apply_wind();
    world.end_phase(1);
}

fn apply_buoyancy(mut world: ResMut<SinewWorld>) {
    world.simulation.apply_buoyancy();
    world.end_phase(2);
}

fn apply_electric(mut world: ResMut<SinewWorld>) {
    world.simulation.apply_electric();
    world.end_phase(3);
}

fn integrate(mut world: ResMut<SinewWorld>) {
    world.simulation.integrate();
    world.end_phase(4);
}

fn solve_constraints(mut world: ResMut<SinewWorld>) {
    world.simulation.solve_constraints();
    world.end_phase(5);
}
