//! Time backwards: snapshots of the last ticks, and the way back to any of them.

#[cfg(test)]
mod tests;

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use bevy::ecs::entity::EntityHashMap;
use bevy::prelude::*;
use bevy_sinew::{SinewClock, SinewControl, SinewSnapshot};

use crate::history::PlotHistory;
use crate::state::PanelState;

/// When and how much the panel records. A resource that may be changed at any time.
///
/// A snapshot of a tick holds the whole state of the simulation: some hundred bytes for each particle and each constraint. To take one costs about as long as some
/// ticks: 1.4 ms of a cape of 24 × 24 particles, 12 ms of a thousand boxes. So of what is large only every few ticks are kept.
#[derive(Resource, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Resource, Default, Clone, PartialEq)]
pub struct RecordingConfig {
    /// When ticks are recorded. Default [`RecordWhen::Shown`].
    pub when: RecordWhen,
    /// The most time that recording takes of a tick in the long run, microseconds: after a snapshot that took longer, so many ticks are left out. Single steps
    /// of a simulation that is paused are recorded all the same. `u32::MAX` records every tick. Default 1000.
    pub max_microseconds: u32,
    /// The most ticks that are kept, 1 and up; the oldest go first. Default 600: 9.4 s at 64 ticks a second, if each is recorded.
    pub max_ticks: usize,
    /// The most memory that they take, bytes; the oldest go first. A single snapshot that is larger is not kept. Default 512 MiB.
    pub max_bytes: usize,
}

impl Default for RecordingConfig {
    fn default() -> Self {
        Self {
            when: RecordWhen::Shown,
            max_microseconds: 1000,
            max_ticks: 600,
            max_bytes: 512 << 20,
        }
    }
}

/// When ticks are recorded.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum RecordWhen {
    /// Never, at no cost.
    Never,
    /// While the panel is drawn. Hidden, it costs nothing. The default.
    #[default]
    Shown,
    /// Always.
    Always,
}

/// A tick of the recording.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RecordedTick {
    /// Its number, [`SinewClock::tick`].
    pub tick: u64,
    /// When it ended, in seconds of simulated time.
    pub seconds: f64,
}

/// What came of simulating ticks again that the recording holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Replay {
    /// None was simulated since the simulation last went back.
    #[default]
    None,
    /// So many were, and each is the same to the last bit.
    Same(u64),
    /// This tick is another one than was recorded: it and what came after it was dropped from the recording.
    Differs(u64),
}

/// The last ticks, oldest first, and where in them the simulation stands.
///
/// Going back pauses the simulation and restores a snapshot in place: everything in [`StateTypes`](bevy_sinew::StateTypes), settings and gravity included,
/// except for the pause and the speed. From there the simulation goes on bit for bit as it did. What it simulates
/// again is compared with the recording: as long as it is the same, the later ticks stay; with the first tick that differs, because a setting was
/// changed, a body was dragged or a game pressed on, they are dropped.
///
/// A game's own state does not go back, unless it is registered ([`RegisterState`](bevy_sinew::RegisterState)), and input is not recorded; [`WentBack`] says
/// that it happened. A clock that jumps, as where another scene begins, empties the recording; where it may not jump, call [`clear`](Self::clear).
#[derive(Resource, Default)]
pub struct Recording {
    snapshots: VecDeque<Recorded>,
    bytes: usize,
    /// How much longer recording took than it may, of the ticks up to now.
    overtime: Duration,
    at: Option<RecordedTick>,
    wanted: Option<u64>,
    replay: Replay,
    problem: Option<String>,
}

struct Recorded {
    at: RecordedTick,
    snapshot: SinewSnapshot,
    bytes: usize,
}

/// The simulation went back, or forth, to a tick of the [`Recording`]: an event for a game that takes its own state along, or that keeps the ids of bodies.
#[derive(Event, Clone, Debug)]
pub struct WentBack {
    /// Where it stands now.
    pub to: RecordedTick,
    /// What entities of the simulation that had been despawned are called now that they are there again, by the ids that they had.
    pub entities: EntityHashMap<Entity>,
}

impl Recording {
    /// A longer jump of the clock, in seconds, is another world.
    const GAP: f64 = 1.0;

    /// The ticks that it holds, oldest first.
    pub fn ticks(&self) -> impl DoubleEndedIterator<Item = RecordedTick> + ExactSizeIterator {
        self.snapshots.iter().map(|one| one.at)
    }

    /// Number of ticks that it holds.
    pub fn len(&self) -> usize {
        self.snapshots.len()
    }

    /// Whether it holds none.
    pub fn is_empty(&self) -> bool {
        self.snapshots.is_empty()
    }

    /// Memory that it takes, bytes.
    pub fn bytes(&self) -> usize {
        self.bytes
    }

    /// The state at the end of a tick, if that is held. The pause and the speed in it are the defaults.
    pub fn snapshot(&self, tick: u64) -> Option<&SinewSnapshot> {
        let one = self.snapshots.get(self.first_from(tick))?;
        (one.at.tick == tick).then_some(&one.snapshot)
    }

    /// What came of simulating recorded ticks again.
    pub fn replay(&self) -> Replay {
        self.replay
    }

    /// Why it could not record, or not go back, in the last attempt.
    pub fn problem(&self) -> Option<&str> {
        self.problem.as_deref()
    }

    /// Has the simulation pause and stand at a recorded tick at the end of this frame: the last one up to `tick`, or the oldest there is. Nothing happens
    /// where none is recorded, or the simulation stands there.
    pub fn go_to(&mut self, tick: u64) {
        let place = self.first_from(tick.saturating_add(1)).saturating_sub(1);
        let here = self.at.map(|at| at.tick);
        self.wanted = self.snapshots.get(place).map(|one| one.at.tick);
        if self.wanted == here {
            self.wanted = None;
        }
    }

    /// The same for the last recorded tick before the one at which the simulation stands.
    pub fn go_back(&mut self) {
        if let Some(before) = self.before() {
            self.go_to(before);
        }
    }

    /// Whether there is a tick to go back to.
    pub fn can_go_back(&self) -> bool {
        self.before().is_some()
    }

    /// Drops all of it.
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    fn before(&self) -> Option<u64> {
        let place = self.first_from(self.at?.tick).checked_sub(1)?;
        Some(self.snapshots[place].at.tick)
    }

    /// The place of the first one that is not before a tick.
    fn first_from(&self, tick: u64) -> usize {
        self.snapshots.partition_point(|one| one.at.tick < tick)
    }

    /// Keeps those before a place.
    fn truncate(&mut self, place: usize) {
        self.bytes -= self.snapshots.drain(place..).map(|one| one.bytes).sum::<usize>();
    }

    fn push(&mut self, at: RecordedTick, snapshot: SinewSnapshot, config: &RecordingConfig) {
        let bytes = snapshot.memory_bytes();
        self.snapshots.push_back(Recorded { at, snapshot, bytes });
        self.bytes += bytes;
        self.problem = (bytes > config.max_bytes).then(|| {
            let megabytes = |bytes: usize| bytes as f64 * 1e-6;
            let (one, most) = (megabytes(bytes), megabytes(config.max_bytes));
            format!("one tick takes {one:.0} MB, and the recording may take {most:.0} MB")
        });
        let too_many = |own: &Self| own.snapshots.len() > config.max_ticks.max(1);
        while too_many(self) || self.bytes > config.max_bytes {
            let Some(oldest) = self.snapshots.pop_front() else { break };
            self.bytes -= oldest.bytes;
        }
    }
}

/// Whether ticks are recorded now.
pub(crate) fn is_on(config: Res<RecordingConfig>, state: Res<PanelState>) -> bool {
    match config.when {
        RecordWhen::Never => false,
        RecordWhen::Shown => state.shown,
        RecordWhen::Always => true,
    }
}

/// Whether somebody wants to be elsewhere.
pub(crate) fn is_wanted(recording: Res<Recording>) -> bool {
    recording.wanted.is_some()
}

/// Records the tick that was simulated last, once.
pub(crate) fn record(world: &mut World) {
    let SinewClock { tick, seconds, .. } = *world.resource::<SinewClock>();
    let now = RecordedTick { tick, seconds };
    let config = *world.resource::<RecordingConfig>();
    world.resource_scope(|world, mut recording: Mut<Recording>| {
        let then = recording.at;
        if then == Some(now) {
            return;
        }
        let jumped = then.is_some_and(|then| {
            !(then.tick < now.tick && (0.0..=Recording::GAP).contains(&(seconds - then.seconds)))
        });
        if jumped {
            recording.clear();
        }
        recording.at = Some(now);
        if tick == 0 {
            return;
        }
        let allowed = Duration::from_micros(config.max_microseconds.into());
        recording.overtime = match config.max_microseconds {
            u32::MAX => Duration::ZERO,
            _ => recording.overtime.saturating_sub(allowed),
        };
        let begun = Instant::now();
        let place = recording.first_from(tick);
        match recording.snapshots.get(place) {
            // Between two that were recorded.
            Some(known) if known.at.tick > tick => (),
            Some(known) => {
                let snapshot = capture(world);
                if known.snapshot.hash() == snapshot.hash() {
                    let before = if let Replay::Same(ticks) = recording.replay { ticks } else { 0 };
                    recording.replay = Replay::Same(before + 1);
                } else {
                    recording.replay = Replay::Differs(tick);
                    recording.truncate(place);
                    recording.push(now, snapshot, &config);
                }
            }
            None if recording.overtime.is_zero() || world.resource::<SinewControl>().paused => {
                let snapshot = capture(world);
                recording.push(now, snapshot, &config);
            }
            None => (),
        }
        recording.overtime += begun.elapsed();
    });
}

/// The state with the pause and the speed of nobody: these are the user's, and are not compared.
fn capture(world: &mut World) -> SinewSnapshot {
    let control = core::mem::take(world.resource_mut::<SinewControl>().bypass_change_detection());
    let mut clock = world.resource_mut::<SinewClock>();
    let ahead = core::mem::take(&mut clock.bypass_change_detection().ahead);
    let snapshot = SinewSnapshot::capture(world);
    *world.resource_mut::<SinewControl>().bypass_change_detection() = control;
    world.resource_mut::<SinewClock>().bypass_change_detection().ahead = ahead;
    snapshot
}

/// Puts the simulation where somebody wants it, paused.
pub(crate) fn travel(world: &mut World) {
    let went = world.resource_scope(|world, mut recording: Mut<Recording>| {
        let wanted = recording.wanted.take()?;
        let place = recording.first_from(wanted);
        let one = recording.snapshots.get(place)?;
        let (to, snapshot) = (one.at, one.snapshot.clone());
        let speed = world.resource::<SinewControl>().relative_speed;
        let moved: EntityHashMap<Entity> = match snapshot.restore(world) {
            Ok(moved) => moved.into_iter().filter(|(old, new)| old != new).collect(),
            Err(fault) => {
                recording.problem = Some(fault.to_string());
                return None;
            }
        };
        world.insert_resource(SinewControl {
            paused: true,
            single_steps: 0,
            relative_speed: speed,
        });
        if !moved.is_empty() {
            recording.snapshots.iter_mut().for_each(|one| one.snapshot.rename(&moved));
        }
        recording.at = Some(to);
        recording.replay = Replay::None;
        recording.problem = None;
        world.resource_mut::<PlotHistory>().truncate(to.tick);
        Some(WentBack { to, entities: moved })
    });
    if let Some(went) = went {
        world.trigger(went);
    }
}
