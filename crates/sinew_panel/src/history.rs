//! Ring buffer of what is plotted: one sample a tick, taken only while the plots are shown.

use std::collections::VecDeque;

use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_sinew::TickTime;
use bevy_sinew::sinew::{Ledger, SolverReport};

/// The plotted values of one tick, as of its end.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlotSample {
    /// End of the tick, seconds of simulated time.
    pub seconds: f64,
    /// Kinetic energy, J.
    pub kinetic: f64,
    /// Gravitational potential energy, J, zero at the world's origin.
    pub gravitational: f64,
    /// Potential energy of springs and between charges, J.
    pub stored: f64,
    /// Momentum of all free particles, kg·m/s.
    pub momentum: DVec3,
    /// Angular momentum of all free particles about the world's origin, kg·m²/s.
    pub angular_momentum: DVec3,
    /// Largest residual of a hard constraint, metres.
    pub error: f32,
    /// Largest residual of a hard distance constraint, relative to its length.
    pub strain: f32,
    /// Sweeps over all constraints, summed over the substeps.
    pub sweeps: u32,
    /// Duration of the gather, of the substeps and of the scatter, seconds of wall-clock time.
    pub parts: [f32; 3],
    /// Duration of each phase, seconds of wall-clock time; zero where phases are not measured.
    pub phases: [f32; 6],
}

impl PlotSample {
    /// Collects the values of the last tick. `seconds` is the clock at its end.
    pub fn new(seconds: f64, ledger: &Ledger, report: &SolverReport, took: &TickTime) -> Self {
        Self {
            seconds,
            kinetic: ledger.kinetic,
            gravitational: ledger.gravitational,
            stored: ledger.elastic + ledger.electric,
            momentum: ledger.momentum,
            angular_momentum: ledger.angular_momentum,
            error: report.error,
            strain: report.strain,
            sweeps: report.sweeps,
            parts: [took.gather, took.substeps, took.scatter].map(|part| part.as_secs_f32()),
            phases: took.phases.map(|phase| phase.as_secs_f32()),
        }
    }

    /// Sum of all energies, J.
    pub fn total(&self) -> f64 {
        self.kinetic + self.gravitational + self.stored
    }

    fn is_finite(&self) -> bool {
        let momenta = self.momentum.is_finite() && self.angular_momentum.is_finite();
        let errors = self.error.is_finite() && self.strain.is_finite();
        self.seconds.is_finite() && self.total().is_finite() && momenta && errors
    }
}

/// The samples of the last [`SPAN`](Self::SPAN) seconds, oldest first.
///
/// It is cleared when the clock goes back, as after a reset or a rollback, because the samples then belong to ticks that never happened.
#[derive(Resource, Clone, Debug, Default)]
pub struct PlotHistory {
    samples: VecDeque<(u64, PlotSample)>,
}

impl PlotHistory {
    /// How far back the samples reach, seconds of simulated time.
    pub const SPAN: f64 = 10.0;
    /// The most samples that are kept, whatever the tick rate.
    pub const CAPACITY: usize = 4096;
    /// A gap longer than this, in seconds, is not drawn as a curve: the history is cleared after it.
    const GAP: f64 = 1.0;

    /// Appends the sample of a tick. A second sample of the latest tick, or one that is not finite, is left out.
    pub fn push(&mut self, tick: u64, sample: PlotSample) {
        self.rewind(tick);
        if !sample.is_finite() {
            return;
        }
        if let Some(&(last_tick, last)) = self.samples.back() {
            if last_tick == tick {
                return;
            }
            if !(0.0..=Self::GAP).contains(&(sample.seconds - last.seconds)) {
                self.samples.clear();
            }
        }
        while self.samples.front().is_some_and(|(_, s)| s.seconds < sample.seconds - Self::SPAN) {
            self.samples.pop_front();
        }
        if self.samples.len() == Self::CAPACITY {
            self.samples.pop_front();
        }
        self.samples.push_back((tick, sample));
    }

    /// Clears the history if the clock is before the last sample.
    pub fn rewind(&mut self, tick: u64) {
        if self.samples.back().is_some_and(|&(last, _)| tick < last) {
            self.samples.clear();
        }
    }

    /// Drops the samples after a tick.
    pub fn truncate(&mut self, tick: u64) {
        self.samples.truncate(self.samples.partition_point(|&(known, _)| known <= tick));
    }

    /// The samples, oldest first.
    pub fn iter(&self) -> impl DoubleEndedIterator<Item = &PlotSample> + ExactSizeIterator {
        self.samples.iter().map(|(_, sample)| sample)
    }

    /// The latest sample.
    pub fn last(&self) -> Option<&PlotSample> {
        self.samples.back().map(|(_, sample)| sample)
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.samples.len()
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.samples.is_empty()
    }

    /// A subset of about `most` samples, at worst twice as many, that always includes the last one.
    ///
    /// Which ticks are kept depends on their numbers alone, so a curve keeps its shape while it moves to the left.
    pub fn thinned(&self, most: usize) -> impl Iterator<Item = &PlotSample> {
        let stride = (self.samples.len() / most.max(1)).max(1).next_power_of_two() as u64;
        let last = self.samples.len().saturating_sub(1);
        self.samples
            .iter()
            .enumerate()
            .filter(move |&(i, &(tick, _))| tick % stride == 0 || i == last)
            .map(|(_, (_, sample))| sample)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DT: f64 = 1.0 / 64.0;

    fn at(seconds: f64) -> PlotSample {
        PlotSample { seconds, kinetic: seconds, ..default() }
    }

    fn filled(ticks: u64) -> PlotHistory {
        let mut history = PlotHistory::default();
        for tick in 1..=ticks {
            history.push(tick, at(tick as f64 * DT));
        }
        history
    }

    #[test]
    fn keeps_the_last_seconds_only() {
        let history = filled(64 * 25);
        let first = history.iter().next().unwrap().seconds;
        assert_eq!(first, 15.0);
        assert_eq!(history.last().unwrap().seconds, 25.0);
        assert_eq!(history.len(), 641);
    }

    #[test]
    fn never_exceeds_its_capacity() {
        let mut history = PlotHistory::default();
        for tick in 0..10_000 {
            history.push(tick, at(tick as f64 * 1e-4));
        }
        assert_eq!(history.len(), PlotHistory::CAPACITY);
        assert_eq!(history.last().unwrap().seconds, 9_999.0 * 1e-4);
    }

    #[test]
    fn a_tick_counts_once() {
        let mut history = filled(3);
        history.push(3, at(99.0));
        assert_eq!(history.len(), 3);
        assert_eq!(history.last().unwrap().seconds, 3.0 * DT);
    }

    #[test]
    fn a_clock_that_goes_back_clears_it() {
        let mut history = filled(100);
        history.rewind(100);
        assert_eq!(history.len(), 100);
        history.rewind(0);
        assert!(history.is_empty());

        let mut history = filled(100);
        history.push(1, at(DT));
        assert_eq!(history.len(), 1);
    }

    #[test]
    fn what_came_after_a_tick_is_forgotten() {
        let mut history = filled(100);
        history.truncate(40);
        assert_eq!(history.len(), 40);
        assert_eq!(history.last().unwrap().seconds, 40.0 * DT);
        history.rewind(40);
        assert_eq!(history.len(), 40);
        history.truncate(0);
        assert!(history.is_empty());
    }

    #[test]
    fn a_gap_starts_afresh() {
        let mut history = filled(100);
        history.push(500, at(500.0 * DT));
        assert_eq!(history.len(), 1);
    }

    #[test]
    fn what_is_not_finite_is_left_out() {
        let mut history = filled(2);
        history.push(3, PlotSample { seconds: 3.0 * DT, kinetic: f64::NAN, ..default() });
        assert_eq!(history.len(), 2);
    }

    #[test]
    fn thinning_keeps_the_same_ticks_as_time_goes_on() {
        let (earlier, later) = (filled(1000), filled(1001));
        let kept = |h: &PlotHistory| h.thinned(100).map(|s| s.seconds).collect::<Vec<_>>();
        let (a, b) = (kept(&earlier), kept(&later));
        assert!(a.len() <= 201);
        assert_eq!(a.last().copied(), earlier.last().map(|s| s.seconds));
        // Each sample of the first set is in the second as well, apart from its first and last.
        let inner = a[1..a.len() - 1].iter();
        assert_eq!(inner.filter(|s| !b.contains(s)).count(), 0);
        assert_eq!(PlotHistory::default().thinned(0).count(), 0);
    }
}
