//! Lane storage: the particles of an instance batch while it is solved, particle by particle, each of eight bodies in a lane.

use glam::Vec4;

use super::convergence::ConvergenceMask;
use crate::lanes::{InstructionSet, LANES, Lanes, kernel};
use crate::solve::chains::Eliminated;
use crate::solve::lane_particles::LaneParticles;
use crate::solve::plan::instance_batches::InstanceBatch;

/// The particles of eight bodies. Scratch.
#[derive(Clone, Debug, Default)]
pub(crate) struct LaneStorage {
    /// Positions and inverse masses.
    pub(crate) now: Vec<LaneParticles>,
    /// Where the substep began.
    pub(crate) start: Vec<LaneParticles>,
    /// Velocities and lags.
    pub(super) velocity: Vec<LaneParticles>,
    pub(super) rounding: Vec<LaneParticles>,
    /// Bodies that have converged, as they were then.
    pub(super) kept: Vec<LaneParticles>,
    /// Rates at which velocity is lost, 1/s, and the share that goes in a substep.
    pub(super) rate: Vec<[f32; LANES]>,
    pub(super) lost: Vec<[f32; LANES]>,
    /// Metres.
    pub(super) radius: Vec<[f32; LANES]>,
    /// How high the origins of the bodies are above each plane, metres.
    pub(super) ground: Vec<[f32; LANES]>,
    /// Kilograms.
    pub(super) mass: Vec<[f64; LANES]>,
    /// Multipliers of soft constraints; empty where no sweep follows that would ask for them.
    pub(crate) multipliers: Vec<[f32; LANES]>,
    /// Where each was when it was looked for what it may touch, and the square of how far it may go from there, m²; empty where there are no surfaces.
    pub(super) last_seen: Vec<LaneParticles>,
    /// Of each particle where its two pins are and how long its tethers; empty where no body has any.
    pub(super) tethers: [Vec<LaneParticles>; 2],
    /// Of the chain at hand.
    pub(super) eliminated: Vec<Eliminated<[f32; LANES]>>,
    /// The numbers of the bodies' islands.
    pub(super) islands: [u32; LANES],
    /// How many bodies there are. The lanes that are left have the last one again.
    pub(super) bodies: usize,
    /// A bit for each body to which nothing outside gives momentum.
    pub(super) free: u32,
    /// A bit for each body that sleeps: it is neither swept nor reported, and stays as it is.
    pub(super) asleep: u32,
    pub(super) convergence: ConvergenceMask,
}

impl LaneStorage {
    /// Takes positions and starts from slices that begin with the row `begin`.
    pub(super) fn load(
        &mut self,
        batch: &InstanceBatch,
        begin: u32,
        position: &[Vec4],
        start: &[Vec4],
        instructions: InstructionSet,
    ) {
        gather(&mut self.now, batch, begin, position, instructions);
        gather(&mut self.start, batch, begin, start, instructions);
        self.bodies = batch.islands.len();
        self.kept.resize(self.now.len(), LaneParticles::ZERO);
    }

    /// A bit for each body.
    pub(super) fn mask(&self) -> u32 {
        (1 << self.bodies) - 1
    }

    /// A bit for each body to which nothing has given momentum in this substep.
    pub(super) fn left(&self) -> u32 {
        self.free & !self.convergence.touched
    }

    /// Makes room for eight bodies that are built as those of another lane storage, and has none.
    pub(super) fn clear_as(&mut self, other: &Self) {
        (self.bodies, self.asleep) = (LANES, 0);
        self.convergence = ConvergenceMask { going: 0, ..ConvergenceMask::default() };
        self.now.resize(other.now.len(), LaneParticles::ZERO);
        self.start.resize(other.start.len(), LaneParticles::ZERO);
        self.kept.resize(other.now.len(), LaneParticles::ZERO);
        self.radius.resize(other.radius.len(), [0.0; LANES]);
        self.ground.resize(other.ground.len(), [0.0; LANES]);
        self.last_seen.resize(other.last_seen.len(), LaneParticles::ZERO);
        for (own, other) in self.tethers.iter_mut().zip(&other.tethers) {
            own.resize(other.len(), LaneParticles::ZERO);
        }
        self.multipliers.resize(other.multipliers.len(), [0.0; LANES]);
    }

    /// Takes a body of another lane storage, with all that it is solved by.
    pub(super) fn admit(&mut self, lane: usize, other: &Self, from: usize) {
        // Loops of their own, which the compiler unrolls; those of a chain it does not.
        for (spot, other) in self.start.iter_mut().zip(&other.start) {
            spot.take(lane, other, from);
        }
        for (spot, other) in self.last_seen.iter_mut().zip(&other.last_seen) {
            spot.take(lane, other, from);
        }
        // Tethers hold in the first sweep alone.
        if other.convergence.sweeps[from] == 0.0 {
            for (own, other) in self.tethers.iter_mut().zip(&other.tethers) {
                for (spot, other) in own.iter_mut().zip(other) {
                    spot.take(lane, other, from);
                }
            }
        }
        self.islands[lane] = other.islands[from];
        let columns = self.radius.iter_mut().zip(&other.radius);
        for (column, other) in columns.chain(self.ground.iter_mut().zip(&other.ground)) {
            column[lane] = other[from];
        }
        self.take(lane, other, from);
    }

    /// Takes a body back that has been solved elsewhere.
    pub(super) fn take_back(&mut self, lane: usize, other: &Self, from: usize) {
        let end = if lane + 1 == self.bodies { LANES } else { lane + 1 };
        for lane in lane..end {
            self.take(lane, other, from);
        }
    }

    /// Takes what solving changes.
    fn take(&mut self, lane: usize, other: &Self, from: usize) {
        for (spot, other) in self.now.iter_mut().zip(&other.now) {
            spot.take(lane, other, from);
        }
        for (sum, other) in self.multipliers.iter_mut().zip(&other.multipliers) {
            sum[lane] = other[from];
        }
        self.convergence.take(lane, &other.convergence, from);
    }

    /// Keeps the bodies of a mask as they are now.
    pub(super) fn keep(&mut self, which: u32) {
        for lane in lanes(which) {
            for (kept, now) in self.kept.iter_mut().zip(&self.now) {
                kept.set_lane(lane, now.lane(lane).truncate());
            }
        }
    }

    /// Puts the bodies of a mask back to how they were kept.
    pub(super) fn put_back(&mut self, which: u32) {
        for lane in lanes(which) {
            for (kept, now) in self.kept.iter().zip(&mut self.now) {
                now.set_lane(lane, kept.lane(lane).truncate());
            }
        }
    }
}

/// The lanes of a mask.
fn lanes(which: u32) -> impl Iterator<Item = usize> {
    (0..LANES).filter(move |lane| which >> lane & 1 != 0)
}

kernel!(
    /// Takes the rows of an instance batch from a slice that begins with the row `begin`.
    pub(super) fn gather<L: Lanes>(
        to: &mut Vec<LaneParticles>,
        batch: &InstanceBatch,
        begin: u32,
        from: &[Vec4],
    ) {
        to.resize(batch.members as usize, LaneParticles::ZERO);
        let mut places = batch.places(begin, 0);
        for spot in to {
            spot.set(L::rows(from, &places));
            next(&mut places);
        }
    }
);

kernel!(
    /// Gives them back.
    pub(super) fn scatter<L: Lanes>(
        from: &[LaneParticles],
        batch: &InstanceBatch,
        begin: u32,
        to: &mut [Vec4],
    ) {
        let mut places = batch.places(begin, 0);
        for spot in from {
            L::put_rows(to, &places, spot.load());
            next(&mut places);
        }
    }
);

/// The next particle of each body. Numbers made one by one would have to be waited for before they are read as one register.
#[inline(always)]
pub(super) fn next(places: &mut [u32; LANES]) {
    places.iter_mut().for_each(|place| *place += 1);
}
