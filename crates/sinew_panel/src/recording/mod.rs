//! Recording: snapshots of the last ticks, and restoring any of them.

#[cfg(test)]
mod tests;

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use bevy::ecs::entity::EntityHashMap;
use bevy::prelude::*;
use bevy_sinew::{SinewClock, SinewControl, SinewSnapshot};

use crate::history::PlotHistory;
use crate::state::PanelState;

/// When ticks are recorded, and the limits of that. A resource that may be changed at any time.
///
/// A snapshot holds the whole state of the simulation: some hundred bytes for each particle and each constraint. Taking one costs about as long as a few ticks:
/// 1.4 ms for a cape of 24 × 24 particles, 12 ms for a thousand boxes. So of a large scene only every few ticks are recorded.
#[derive(Resource, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Resource, Default, Clone, PartialEq)]
pub struct RecordingConfig {
    /// When ticks are recorded. Default [`RecordWhen::Shown`].
    pub when: RecordWhen,
    /// The most time that recording may take of a tick on average, microseconds: after a snapshot that took longer, as many ticks are skipped as make up for
    /// it. Single steps of a paused simulation are always recorded. `u32::MAX` records every tick. Default 1000.
    pub max_microseconds: u32,
    /// The most ticks that are kept, at least 1; the oldest are dropped first. Default 600: 9.4 s at 64 ticks a second, if each is recorded.
    pub max_ticks: usize,
    /// The most memory that the snapshots take, bytes; the oldest are dropped first. A single snapshot that is larger is not kept. Default 512 MiB.
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
    /// While the panel is drawn; a hidden panel records nothing. The default.
    #[default]
    Shown,
    /// Always.
    Always,
}

/// A recorded tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RecordedTick {
    /// Its number, [`SinewClock::tick`].
    pub tick: u64,
    /// Its end, seconds of simulated time.
    pub seconds: f64,
}

/// Result of simulating recorded ticks again.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Replay {
    /// No recorded tick was simulated since the simulation last went back.
    #[default]
    None,
    /// This many ticks were, and each is the same to the last bit.
    Same(u64),
    /// This tick differs from the recorded one: the recorded ticks from it on were dropped.
    Differs(u64),
}

/// Snapshots of the last ticks, oldest first, and the tick among them that the simulation is at.
///
/// Going back pauses the simulation and restores a snapshot in place: everything in [`StateTypes`](bevy_sinew::StateTypes), settings and gravity included,
/// except for the pause and the speed. From there the simulation goes on bit for bit as it did. Each tick that is simulated again is compared with the recorded
/// one. While they are the same, the later ticks are kept; at the first tick that differs, because a setting was changed, a body was dragged or a game acted,
/// they are dropped.
///
/// A game's own state does not go back unless it is registered ([`RegisterState`](bevy_sinew::RegisterState)), and input is not recorded; [`WentBack`] is
/// triggered when the simulation went back. A jump of the clock, as where another scene begins, empties the recording; where the clock does not jump, call
/// [`clear`](Self::clear).
#[derive(Resource, Default)]
pub struct Recording {
    snapshots: VecDeque<Recorded>,
    bytes: usize,
    /// By how much recording has exceeded its time up to now; ticks are skipped until it is zero.
    time_debt: Duration,
    at: Option<RecordedTick>,
    requested: Option<u64>,
    replay: Replay,
    problem: Option<String>,
}

struct Recorded {
    at: RecordedTick,
    snapshot: SinewSnapshot,
    bytes: usize,
}

/// Event: the simulation went back, or forward, to a tick of the [`Recording`]. For a game that restores its own state along, or that keeps the ids of bodies.
#[derive(Event, Clone, Debug)]
pub struct WentBack {
    /// The tick that the simulation is at now.
    pub to: RecordedTick,
    /// New ids of entities that had been despawned and were spawned again, by the ids that they had.
    pub entities: EntityHashMap<Entity>,
}

impl Recording {
    /// A jump of the clock longer than this, in seconds, is taken for another scene.
    const GAP: f64 = 1.0;

    /// The recorded ticks, oldest first.
    pub fn ticks(&self) -> impl DoubleEndedIterator<Item = RecordedTick> + ExactSizeIterator {
        self.snapshots.iter().map(|one| one.at)
    }

    /// Number of recorded ticks.
    pub fn len(&self) -> usize {
        self.snapshots.len()
    }

    /// Whether no tick is recorded.
    pub fn is_empty(&self) -> bool {
        self.snapshots.is_empty()
    }

    /// Memory that the snapshots take, bytes.
    pub fn bytes(&self) -> usize {
        self.bytes
    }

    /// The state at the end of a tick, if it is recorded. The pause and the speed in it are the defaults.
    pub fn snapshot(&self, tick: u64) -> Option<&SinewSnapshot> {
        let one = self.snapshots.get(self.first_from(tick))?;
        (one.at.tick == tick).then_some(&one.snapshot)
    }

    /// Result of simulating recorded ticks again.
    pub fn replay(&self) -> Replay {
        self.replay
    }

    /// Why the last attempt to record or to go back failed, if it did.
    pub fn problem(&self) -> Option<&str> {
        self.problem.as_deref()
    }

    /// Requests that the simulation pause and be at a recorded tick at the end of this frame: the last one up to `tick`, or else the oldest. Does nothing if
    /// none is recorded, or if the simulation is at that tick.
    pub fn go_to(&mut self, tick: u64) {
        let place = self.first_from(tick.saturating_add(1)).saturating_sub(1);
        let here = self.at.map(|at| at.tick);
        self.requested = self.snapshots.get(place).map(|one| one.at.tick);
        if self.requested == here {
            self.requested = None;
        }
    }

    /// Like [`go_to`](Self::go_to) for the last recorded tick before the one that the simulation is at.
    pub fn go_back(&mut self) {
        if let Some(before) = self.before() {
            self.go_to(before);
        }
    }

    /// Whether there is an earlier recorded tick to go back to.
    pub fn can_go_back(&self) -> bool {
        self.before().is_some()
    }

    /// Drops the whole recording.
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    fn before(&self) -> Option<u64> {
        let place = self.first_from(self.at?.tick).checked_sub(1)?;
        Some(self.snapshots[place].at.tick)
    }

    /// Index of the first snapshot that is not before a tick.
    fn first_from(&self, tick: u64) -> usize {
        self.snapshots.partition_point(|one| one.at.tick < tick)
    }

    /// Drops the snapshots from an index on.
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
            format!("a snapshot takes {one:.0} MB, but the limit is {most:.0} MB")
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

/// Whether going to a tick was requested.
pub(crate) fn is_requested(recording: Res<Recording>) -> bool {
    recording.requested.is_some()
}

/// Records the last tick, once.
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
        recording.time_debt = match config.max_microseconds {
            u32::MAX => Duration::ZERO,
            _ => recording.time_debt.saturating_sub(allowed),
        };
        let begun = Instant::now();
        let place = recording.first_from(tick);
        match recording.snapshots.get(place) {
            // Between two recorded ticks: skipped at first, so there is nothing to compare with.
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
            None if recording.time_debt.is_zero() || world.resource::<SinewControl>().paused => {
                let snapshot = capture(world);
                recording.push(now, snapshot, &config);
            }
            None => (),
        }
        recording.time_debt += begun.elapsed();
    });
}

/// Takes a snapshot with the default pause and speed: these belong to the user and are not compared.
fn capture(world: &mut World) -> SinewSnapshot {
    let control = core::mem::take(world.resource_mut::<SinewControl>().bypass_change_detection());
    let mut clock = world.resource_mut::<SinewClock>();
    let ahead = core::mem::take(&mut clock.bypass_change_detection().ahead);
    let snapshot = SinewSnapshot::capture(world);
    *world.resource_mut::<SinewControl>().bypass_change_detection() = control;
    world.resource_mut::<SinewClock>().bypass_change_detection().ahead = ahead;
    snapshot
}

/// Goes to the requested tick, and pauses.
pub(crate) fn restore_requested(world: &mut World) {
    let went = world.resource_scope(|world, mut recording: Mut<Recording>| {
        let requested = recording.requested.take()?;
        let place = recording.first_from(requested);
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
