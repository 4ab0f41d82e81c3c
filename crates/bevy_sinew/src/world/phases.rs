//! What is noted of the phases of a tick where somebody watches them. Nobody does in a usual tick, and each phase asks once.

use core::time::Duration;
use std::time::Instant;

use bevy::math::Vec3;
use sinew::Particles;

use super::SinewWorld;

/// The most memory that copies of particles take, bytes: for 60 phases of 28 000 particles.
const MOST: usize = 256 << 20;
/// What a row of them takes, bytes.
const ROW: usize = 160;

/// Phases that are watched.
#[derive(Debug, Default)]
pub(crate) struct PhaseWatch {
    /// When the last phase ended, on the wall.
    since: Option<Instant>,
    /// How long each phase took, summed over the substeps.
    pub(crate) took: [Duration; 6],
    /// The particles at the end of each phase, from the first one of the tick on; `None`: nobody wants them.
    pub(crate) frames: Option<Vec<Particles>>,
}

impl SinewWorld {
    /// Notes that a substep begins.
    pub(crate) fn begin_phases(&mut self) {
        if let Some(watch) = &mut self.tables.watch {
            watch.since = Some(Instant::now());
        }
    }

    /// Notes that a phase has ended.
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
            // Without gaps: what does not fit ends them.
            if (frames.len() + 1) * particles.len() * ROW <= MOST {
                frames.push(particles.clone());
            }
            watch.since = Some(Instant::now());
        }
    }
}
