//! What a scene does again and again as time goes by: turn back, begin anew, push the other way.

use bevy::prelude::*;
use bevy_sinew::{Particle, SinewClock};

/// Rounds of equal length in simulated time. Whole quarters of a second ([`quarters`]) end with a tick, be it of 1/60 or of 1/64 s.
#[derive(Component, Clone, Copy, Debug)]
pub(crate) struct Rounds {
    /// Length of a round, seconds.
    period: f64,
    /// Rounds that have ended.
    ended: u32,
}

impl Rounds {
    /// Rounds of so many seconds, more than 0.
    pub(crate) fn of(period: f64) -> Self {
        Self { period, ended: 0 }
    }

    /// How many rounds have ended by now, once for each end.
    pub(crate) fn ended(&mut self, clock: &SinewClock) -> Option<u32> {
        let ended = (clock.seconds / self.period + SLACK) as u32;
        (ended > self.ended).then(|| {
            self.ended = ended;
            ended
        })
    }
}

/// A loose particle that begins anew when a round ends.
#[derive(Component, Clone, Debug)]
pub(crate) struct Again {
    rounds: Rounds,
    start: Particle,
}

impl Again {
    /// Begins anew as it is, after each of so many seconds.
    pub(crate) fn after(period: f64, start: Particle) -> Self {
        Self { rounds: Rounds::of(period), start }
    }
}

/// Lets what is due begin anew.
pub(crate) fn begin_anew(clock: Res<SinewClock>, mut again: Query<(&mut Again, &mut Particle)>) {
    for (mut again, mut particle) in &mut again {
        if again.rounds.ended(&clock).is_some() {
            *particle = again.start;
        }
    }
}

/// What the sum of the ticks may be off by, as a share of a round.
const SLACK: f64 = 1e-5;

/// The nearest time of whole quarters of a second, and at least one.
pub(crate) fn quarters(seconds: f32) -> f64 {
    (f64::from(seconds) * 4.0).round().max(1.0) / 4.0
}

/// How far into its round of `period` seconds a time is: 0 only at the very beginning, and all of it where a round ends.
pub(crate) fn into_round(seconds: f64, period: f64) -> f64 {
    let ended = (seconds / period - SLACK).floor().max(0.0);
    seconds - ended * period
}
