//! Rounds: intervals of simulated time after which a scene repeats something, such as turning back or starting again.

use bevy::prelude::*;
use bevy_sinew::{Particle, SinewClock};

/// Rounds of equal length in simulated time. Multiples of a quarter of a second ([`quarters`]) end with a tick, whether ticks are 1/60 or 1/64 s long.
#[derive(Component, Clone, Copy, Debug)]
pub(crate) struct Rounds {
    /// Length of a round, seconds.
    period: f64,
    /// Rounds that have ended.
    ended: u32,
}

impl Rounds {
    /// Rounds of `period` seconds, which is more than 0.
    pub(crate) fn of(period: f64) -> Self {
        Self { period, ended: 0 }
    }

    /// The number of rounds that have ended, returned once for each end.
    pub(crate) fn ended(&mut self, clock: &SinewClock) -> Option<u32> {
        let ended = (clock.seconds / self.period + ROUND_OFF) as u32;
        (ended > self.ended).then(|| {
            self.ended = ended;
            ended
        })
    }
}

/// A loose particle that is reset to its start when a round ends.
#[derive(Component, Clone, Debug)]
pub(crate) struct Restart {
    rounds: Rounds,
    start: Particle,
}

impl Restart {
    /// Resets the particle to `start` every `period` seconds.
    pub(crate) fn every(period: f64, start: Particle) -> Self {
        Self { rounds: Rounds::of(period), start }
    }
}

/// Resets the particles whose round has ended.
pub(crate) fn restart(clock: Res<SinewClock>, mut loose: Query<(&mut Restart, &mut Particle)>) {
    for (mut restart, mut particle) in &mut loose {
        if restart.rounds.ended(&clock).is_some() {
            *particle = restart.start;
        }
    }
}

/// Round-off allowed in the sum of the ticks, as a fraction of a round.
const ROUND_OFF: f64 = 1e-5;

/// The nearest multiple of a quarter of a second, at least one quarter.
pub(crate) fn quarters(seconds: f32) -> f64 {
    (f64::from(seconds) * 4.0).round().max(1.0) / 4.0
}

/// Time since the start of its round of `period` seconds: 0 only at the very beginning, and the whole period where a round ends.
pub(crate) fn into_round(seconds: f64, period: f64) -> f64 {
    let ended = (seconds / period - ROUND_OFF).floor().max(0.0);
    seconds - ended * period
}
