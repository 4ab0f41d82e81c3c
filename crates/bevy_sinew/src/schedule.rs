//! The schedules and the system sets of a tick and of a substep, and the systems that drive them.

mod phases;

pub(crate) use phases::is_shown;
pub use phases::{PhaseStep, PhaseSteps};

use core::time::Duration;
use std::time::Instant;

use bevy::ecs::message::signal_message_update_system;
use bevy::ecs::schedule::{InternedScheduleLabel, ScheduleLabel, SingleThreadedExecutor};
use bevy::prelude::*;

use crate::world::{PhaseWatch, SinewWorld, load_deferred};

/// The parts of a tick, in this order, in [`SinewTick`]. A custom system that belongs between two of them is added to that schedule.
///
/// In `FixedPostUpdate` (or the schedule that was passed to [`SinewPlugin`](crate::SinewPlugin)) one system runs the whole tick. That system is in all of these
/// sets: there, `.before(SinewSystems::Build)` is before the tick and `.after(SinewSystems::Extract)` is after it. A place between two sets is possible only in
/// [`SinewTick`]; in the outer schedule it would be a cycle, which Bevy refuses.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum SinewSystems {
    /// New and changed recipes are built: they become particles and constraints.
    Build,
    /// Components are copied into the solver's columns; invalid ones are set aside.
    Gather,
    /// [`SubstepSchedule`] runs, once for each substep.
    Substeps,
    /// The columns are copied back into the components.
    Scatter,
    /// Transforms and velocities of bodies are computed from their particles.
    Extract,
}

/// The phases of a substep, in this order, in [`SubstepSchedule`].
///
/// A game adds a custom force to [`AccumulateForces`](Self::AccumulateForces) with `.in_set(...)`, or puts a system between two sets; it works on the columns
/// of [`SinewWorld`].
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum PhaseSystems {
    /// Gravity, external forces and springs are summed up; custom forces are added to this set, in any order.
    AccumulateForces,
    /// The pressure of winds is added.
    Wind,
    /// The buoyancy of fluids is added.
    Buoyancy,
    /// The forces between charges are added.
    Electric,
    /// The integrator (by default Verlet) predicts the next positions.
    Integrate,
    /// Constraints and contacts correct the predicted positions.
    SolveConstraints,
}

/// The systems that run only while time passes.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct TimePasses;

/// One tick, on a single thread: its systems take microseconds each and depend on each other, and scheduling each on a thread would take microseconds, too.
/// (The solver uses [threads](crate::SinewWorkers) within them.) The plugin runs it; add systems to it, but do not run it.
#[derive(ScheduleLabel, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct SinewTick;

/// One substep, of a world that has particles. The plugin runs it; add systems to it, but do not run it.
#[derive(ScheduleLabel, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct SubstepSchedule;

/// Pauses the simulation, steps it tick by tick (or phase by phase: [`PhaseSteps`]), or runs it at another speed. The game's clocks (`Time<Virtual>`,
/// `Time<Fixed>`) are not affected, so menus, cameras and animations continue.
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
/// The length of a tick does not depend on the speed: at half speed every other fixed tick of the game has one tick of the simulation, at double speed each has
/// two. The simulation is therefore equally stable, and its results are the same bit for bit, at any speed. [Interpolated](crate::Interpolate) bodies move
/// smoothly at any speed. Entities that the game moves by its own clock (a kinematic [`Collider`](crate::Collider), the entity of a
/// [`PinnedTo`](crate::PinnedTo)) are faster or slower relative to the simulation: multiply their speed by [`relative_speed`](Self::relative_speed) to slow
/// them down, too.
#[derive(Resource, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Resource, Default, Clone, PartialEq)]
pub struct SinewControl {
    /// Whether time is paused. Bodies that are spawned meanwhile are built. Default false.
    pub paused: bool,
    /// Number of ticks to run while paused, or at the speed 0; each tick decrements it. Default 0.
    pub single_steps: u32,
    /// Simulated seconds per second of the schedule that runs the tick, 0 (as paused) to [`MAX_SPEED`](Self::MAX_SPEED), to which it is clamped; NaN counts as
    /// 0. Default 1. The number of ticks in a frame is bounded by `Time<Virtual>::max_delta` (0.25 s by default) times this.
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
    /// The maximum [`relative_speed`](Self::relative_speed).
    pub const MAX_SPEED: f32 = 16.0;

    /// Whether the simulation advances: it is not paused and its speed is not 0, or it has single steps to run.
    pub fn running(&self) -> bool {
        !self.stands() || self.single_steps > 0
    }

    /// Whether only single steps advance the simulation: it is paused, or its speed is 0.
    pub(crate) fn stands(&self) -> bool {
        self.paused || self.speed() == 0.0
    }

    /// Pauses the simulation.
    pub fn pause(&mut self) {
        self.paused = true;
    }

    /// Resumes the simulation; single steps that were not run are dropped.
    pub fn unpause(&mut self) {
        (self.paused, self.single_steps) = (false, 0);
    }

    /// Runs one more tick of a paused simulation.
    pub fn step(&mut self) {
        self.single_steps = self.single_steps.saturating_add(1);
    }

    /// The clamped speed.
    fn speed(&self) -> f32 {
        // `clamp` would keep NaN.
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
    /// Number of ticks that were run.
    pub tick: u64,
    /// Simulated time, seconds; gusts of wind depend on it.
    pub seconds: f64,
    /// The fraction of the last tick that is still to be played, 0 to 1: at a [speed](SinewControl::relative_speed) that is not an integer, a tick is simulated
    /// when its first part is due. Default 0, and 0 while time is paused.
    pub ahead: f64,
}

impl SinewClock {
    /// Whether the solver has taken a tick since the clock was last set; with a time step of zero, none is.
    pub(crate) fn is_behind(&self, world: &SinewWorld) -> bool {
        self.seconds != world.simulation.time
    }
}

/// Which of several ticks is being run, and how the result is drawn. Scratch.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub(crate) struct FixedTick {
    /// Number of ticks that remain in this fixed tick, including this one; 0 if time does not pass in it.
    pub(crate) remaining: u32,
    /// Whether the last fixed tick played anything but one whole tick or none: what is drawn is then not an interpolation between the start and the end of the
    /// last tick.
    pub(crate) time_scaled: bool,
    /// Whether a game has added a run condition to one of the phases.
    conditional: bool,
    /// Wall-clock time at which the tick began.
    began: Option<Instant>,
}

/// How long the last tick took, for display. Wall-clock time: never part of the state.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub struct TickTime {
    /// Duration of building bodies and of gathering.
    pub gather: Duration,
    /// Duration of all substeps.
    pub substeps: Duration,
    /// Duration of scattering and of extracting.
    pub scatter: Duration,
    /// Duration of each phase, in the order of [`PhaseSystems`], summed over the substeps, including custom systems since the previous phase; zero unless
    /// [`by_phase`](Self::by_phase).
    pub phases: [Duration; 6],
    /// Whether phases are measured; set by the game. The substeps are then run one by one, which gives the same bits and takes longer. Default false.
    pub by_phase: bool,
}

/// The parts of a tick, in order.
const PARTS: [SinewSystems; 5] = [
    SinewSystems::Build,
    SinewSystems::Gather,
    SinewSystems::Substeps,
    SinewSystems::Scatter,
    SinewSystems::Extract,
];

/// The phases of a substep, in order.
const PHASE_ORDER: [PhaseSystems; 6] = [
    PhaseSystems::AccumulateForces,
    PhaseSystems::Wind,
    PhaseSystems::Buoyancy,
    PhaseSystems::Electric,
    PhaseSystems::Integrate,
    PhaseSystems::SolveConstraints,
];

/// Configures the sets, their order and the phases, and adds the system that runs the tick to a schedule.
pub(crate) fn configure(app: &mut App, within: InternedScheduleLabel) {
    let whole = PARTS.into_iter().fold(run_tick.into_configs(), |tick, part| tick.in_set(part));
    // Bevy's own system in `FixedPostUpdate`. The order does not matter, but an ambiguity would be an error.
    app.add_systems(within, whole.before(signal_message_update_system));

    app.init_schedule(SinewTick);
    app.edit_schedule(SinewTick, |schedule| {
        schedule.set_executor(SingleThreadedExecutor::new());
        let [build, gather, substeps, scatter, extract] = PARTS;
        schedule.configure_sets((build, gather, substeps, scatter, extract).chain());
        // While time is paused, bodies are still built, gathered and extracted, so that what is spawned or moved is drawn. The condition is on a set around the
        // other parts, so that it is evaluated once a tick.
        schedule.configure_sets((substeps, scatter).in_set(TimePasses));
        schedule.configure_sets(TimePasses.run_if(time_passes));
        schedule.add_systems((
            run_substeps.in_set(substeps),
            count_tick.in_set(TimePasses).after(scatter).before(extract),
        ));
    });

    app.init_schedule(SubstepSchedule);
    app.edit_schedule(SubstepSchedule, |schedule| {
        // A phase takes microseconds and depends on the previous one, so a second thread would have nothing to do.
        schedule.set_executor(SingleThreadedExecutor::new());
        let [forces, wind, buoyancy, electric, integration, constraints] = PHASE_ORDER;
        let order = (forces, wind, buoyancy, electric, integration, constraints);
        schedule.configure_sets(order.chain());
        // The sums are cleared before the first set, so that forces add up in any order of the systems of a set.
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

/// Run condition: whether this tick is to be simulated.
pub(crate) fn time_passes(fixed_tick: Res<FixedTick>) -> bool {
    fixed_tick.remaining > 0
}

/// Run condition: whether what is drawn is not an interpolation between the start and the end of the last tick.
#[cfg(feature = "interpolation")]
pub(crate) fn is_time_scaled(fixed_tick: Res<FixedTick>) -> bool {
    fixed_tick.time_scaled
}

/// Runs the ticks that are due: one at normal speed. If none is due, what was spawned or moved is still built, gathered and extracted.
fn run_tick(world: &mut World) {
    phases::choose(world);
    let change_tick = world.change_tick();
    let due = ticks_due(world);
    for taken in 0..due.max(1) {
        let began = Instant::now();
        let mut fixed_tick = world.resource_mut::<FixedTick>();
        (fixed_tick.remaining, fixed_tick.began) = (due.saturating_sub(taken), Some(began));
        let ran = world.try_run_schedule(SinewTick);
        debug_assert!(ran.is_ok(), "the schedule of a tick was removed while it is in use");
        if due > 0 {
            let mut took = world.resource_mut::<TickTime>();
            took.scatter = began.elapsed().saturating_sub(took.gather + took.substeps);
        }
    }
    // Until now it was that of the tick before.
    world.resource_mut::<SinewWorld>().tables.began = Some(change_tick);
    let (ahead, time_scaled) =
        (world.resource::<SinewClock>().ahead, world.resource::<FixedTick>().time_scaled);
    if time_scaled {
        world.resource_mut::<SinewWorld>().record_played(ahead as f32, due > 0);
    }
    phases::show(world);
}

/// Computes how many ticks are due in this fixed tick, and advances the played time.
fn ticks_due(world: &mut World) -> u32 {
    let control = *world.resource::<SinewControl>();
    let mut clock = world.resource_mut::<SinewClock>();
    let before = clock.ahead;
    let due = if control.stands() {
        // The simulated state is drawn.
        clock.ahead = 0.0;
        control.single_steps.min(1)
    } else {
        let mut ahead = before - f64::from(control.speed());
        let mut due = 0;
        // At most as many as at the maximum speed, whatever the clock contains.
        while ahead < 0.0 && due < SinewControl::MAX_SPEED as u32 {
            ahead += 1.0;
            due += 1;
        }
        clock.ahead = if (0.0..1.0).contains(&ahead) { ahead } else { 0.0 };
        due
    };
    let even = before == 0.0 && clock.ahead == 0.0 && due <= 1;
    let was_time_scaled =
        core::mem::replace(&mut world.resource_mut::<FixedTick>().time_scaled, !even);
    if !even && !was_time_scaled {
        world.resource_mut::<SinewWorld>().record_played(0.0, false);
    }
    due
}

/// The number of this crate's systems in a substep.
const PHASES: usize = 7;

/// Runs the substeps of a tick. The schedule is taken out of the world once, not once per substep.
fn run_substeps(world: &mut World) {
    let dt = world.resource::<Time>().delta_secs();
    let began = Instant::now();
    let by_phase = world.resource::<TickTime>().by_phase;
    let shown = world.resource::<PhaseSteps>().records_next;
    let watched = by_phase || shown || world.resource::<SinewWorld>().tables.forces.is_some();
    let alone = !watched && runs_our_phases_alone(world);
    if alone && world.resource_mut::<SinewWorld>().step_at_rest(dt) {
        note_times(world, began, None);
        return;
    }
    load_deferred(world);
    if alone {
        // Nothing of the game runs between the phases.
        let mut sinew = world.resource_mut::<SinewWorld>();
        // A time step of zero is no error: nothing happens.
        if sinew.simulation.step(dt).is_ok() {
            sinew.tables.stepped = true;
            note_times(world, began, None);
        }
        return;
    }
    let substeps = {
        let mut sinew = world.resource_mut::<SinewWorld>();
        match sinew.simulation.begin_step(dt) {
            Ok(substeps) => substeps,
            // A time step of zero is no error: nothing happens.
            Err(_) => return,
        }
    };
    let mut sinew = world.resource_mut::<SinewWorld>();
    if sinew.simulation.particles.is_empty() {
        // Without particles only time advances, by the same small additions as otherwise, so that the sum has the same bits.
        let length = f64::from(sinew.simulation.substep().length);
        (0..substeps).for_each(|_| sinew.simulation.time += length);
    } else {
        let ran = world.try_schedule_scope(SubstepSchedule, |world, schedule| {
            if watched {
                let mut watch = PhaseWatch::default();
                watch.frames = shown.then(Vec::new);
                world.resource_mut::<SinewWorld>().tables.watch = Some(Box::new(watch));
            }
            for _ in 0..world.resource::<SinewWorld>().substep().remaining {
                schedule.run(world);
            }
        });
        debug_assert!(ran.is_ok(), "the substep schedule was removed while it is in use");
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

/// Whether no system and no run condition of the game is between the phases.
fn runs_our_phases_alone(world: &mut World) -> bool {
    let mut schedules = world.resource_mut::<Schedules>();
    let Some(schedule) = schedules.get_mut(SubstepSchedule) else { return false };
    // Conditions of sets are visible until the schedule is built with them, which happens when it runs.
    let sets = &schedule.graph().system_sets;
    let conditional = sets.iter().any(|(_, _, conditions)| !conditions.is_empty());
    // Systems that were added since are counted when the schedule is built again, which happens when it runs.
    let counted = !schedule.is_changed() && schedule.systems_len() == PHASES;
    let mut fixed_tick = world.resource_mut::<FixedTick>();
    fixed_tick.conditional |= conditional;
    counted && !fixed_tick.conditional
}

/// Stores how long the parts of a tick took; `began` is the start of the substeps.
fn note_times(world: &mut World, began: Instant, watch: Option<Box<PhaseWatch>>) {
    let whole = world.resource::<FixedTick>().began.unwrap_or(began);
    let mut took = world.resource_mut::<TickTime>();
    took.substeps = began.elapsed();
    took.gather = began.duration_since(whole);
    took.phases = watch.map_or_else(Default::default, |watch| watch.took);
}

/// Advances the clock and decrements the single steps.
fn count_tick(
    mut clock: ResMut<SinewClock>,
    mut control: ResMut<SinewControl>,
    world: Res<SinewWorld>,
) {
    if !clock.is_behind(&world) {
        return;
    }
    clock.tick += 1;
    clock.seconds = world.simulation.time;
    if control.stands() {
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
