//! Recording of the phases of a tick, for tools. It is off in a usual tick, and each phase checks it once.

use core::time::Duration;
use std::time::Instant;

use bevy::math::Vec3;
use sinew::Particles;

use super::SinewWorld;

/// Maximum memory of the recorded particles, bytes: enough for 60 phases of 28 000 particles.
const MAX_RECORDED_BYTES: usize = 256 << 20;
/// Memory of one recorded row, bytes.
const ROW_BYTES: usize = 160;

/// The record of the phases.
#[derive(Debug, Default)]
pub(crate) struct PhaseWatch {
    /// Wall-clock time at which the last phase ended.
    since: Option<Instant>,
    /// Duration of each phase, summed over the substeps.
    pub(crate) took: [Duration; 6],
    /// The particles at the end of each phase, from the first phase of the tick on; `None` if they are not recorded.
    pub(crate) frames: Option<Vec<Particles>>,
}

impl SinewWorld {
    /// Records the start of a substep.
    pub(crate) fn begin_phases(&mut self) {
        if let Some(watch) = &mut self.tables.watch {
            watch.since = Some(Instant::now());
        }
    }

    /// Records the end of a phase.
    pub(crate) fn end_phase(&mut self, phase: usize) {
        let Some(watch) = &mut self.tables.watch else { return };
        let now = Instant::now();
        watch.took[phase] += watch.since.map_or(Duration::ZERO, |since| now - since);
        watch.since = Some(now);
        let remaining = self.simulation.substep().remaining;
        if let Some(forces) = self.tables.forces.as_mut().filter(|_| remaining == 1 && phase < 4) {
            let particles = &self.simulation.particles;
            let (before, now) = forces.split_at_mut(phase);
            now[0].clear();
            now[0].extend((0..particles.len()).map(|i| {
                let earlier = before.iter().map(|of| of.get(i).copied().unwrap_or_default());
                particles.acceleration(i) - earlier.sum::<Vec3>()
            }));
            watch.since = Some(Instant::now());
        }
        if let Some(frames) = &mut watch.frames {
            let particles = &self.simulation.particles;
            // Without gaps: the first copy that does not fit ends the recording.
            if (frames.len() + 1) * particles.len() * ROW_BYTES <= MAX_RECORDED_BYTES {
                frames.push(particles.clone());
            }
            watch.since = Some(Instant::now());
        }
    }
}
