//! Lane storage (AoSoA): the particles of an instance batch while it is solved. Entry `i` holds particle `i` of eight bodies, one body a lane.

use core::ops::Range;

use glam::Vec4;

use super::convergence::ConvergenceMask;
use crate::lanes::{InstructionSet, LANES, Lanes, SetLanes, advance, kernel};
use crate::solve::chains::Eliminated;
use crate::solve::lane_particles::LaneParticles;
use crate::solve::plan::instance_batches::InstanceBatch;

/// The particles of eight bodies, and what solving them needs. Scratch.
#[derive(Clone, Debug, Default)]
pub(crate) struct LaneStorage {
    /// Current positions and inverse masses.
    pub(crate) now: Vec<LaneParticles>,
    /// Positions and inverse masses at the start of the substep.
    pub(crate) start: Vec<LaneParticles>,
    /// Velocities, m/s, with their lags, seconds; and what their last sum rounded away, m/s.
    pub(super) velocity: Vec<LaneParticles>,
    pub(super) rounding: Vec<LaneParticles>,
    /// Snapshots of the bodies that have converged or sleep. Sweeps go on writing to their lanes; the snapshots are restored afterwards.
    pub(super) saved: Vec<LaneParticles>,
    /// Damping rates, 1/s, and the share of velocity that is lost in a substep.
    pub(super) rate: Vec<[f32; LANES]>,
    pub(super) lost: Vec<[f32; LANES]>,
    /// Metres; empty where there are no planes.
    pub(super) radius: Vec<[f32; LANES]>,
    /// For each plane, the height of each body's origin above it, metres.
    pub(super) ground: Vec<[f32; LANES]>,
    /// Kilograms.
    pub(super) mass: Vec<[f64; LANES]>,
    /// Multipliers of compliant constraints; empty with a single sweep a substep, where nothing reads them.
    pub(crate) multipliers: Vec<[f32; LANES]>,
    /// For each particle, the position at which its contacts were last searched for, and in `w` the square of the distance for which the result is valid, m².
    /// Empty where there are no surfaces.
    pub(super) reference: Vec<LaneParticles>,
    /// For each particle, the positions of its two pins and in `w` the tether lengths, metres; empty where no body has any.
    pub(super) tethers: [Vec<LaneParticles>; 2],
    /// Elimination scratch of the current chain.
    pub(super) eliminated: Vec<Eliminated<[f32; LANES]>>,
    /// Island numbers of the bodies.
    pub(super) islands: [u32; LANES],
    /// Number of bodies. Unused lanes repeat the last one.
    pub(super) bodies: usize,
    /// One bit for each body that gets no momentum from outside: all its constraints are internal, no particle is pinned, and it is awake.
    pub(super) free: u32,
    /// One bit for each body that is held by its pivot alone ([`Island::pivot`](crate::islands::Island::pivot)) and awake; and the two
    /// particles of each pivot.
    pub(super) pivoted: u32,
    pub(super) pivots: [[u32; 2]; LANES],
    /// One bit for each sleeping body. It is neither swept nor reported, and does not change.
    pub(super) asleep: u32,
    pub(super) convergence: ConvergenceMask,
}

impl LaneStorage {
    /// Gathers positions and substep starts from columns that begin with row `begin`. Without starts there is only room for them, which predicting fills.
    pub(super) fn load(
        &mut self,
        batch: &InstanceBatch,
        begin: u32,
        position: &[Vec4],
        start: Option<&[Vec4]>,
        instructions: InstructionSet,
    ) {
        gather(&mut self.now, batch, begin, position, instructions);
        match start {
            Some(start) => gather(&mut self.start, batch, begin, start, instructions),
            None => self.start.resize(self.now.len(), LaneParticles::ZERO),
        }
        self.bodies = batch.islands.len();
        self.saved.resize(self.now.len(), LaneParticles::ZERO);
    }

    /// One bit for each body.
    pub(super) fn mask(&self) -> u32 {
        (1 << self.bodies) - 1
    }

    /// The lanes that hold the body of `lane`: unused lanes repeat the last body.
    pub(super) fn copies(&self, lane: usize) -> Range<usize> {
        lane..if lane + 1 == self.bodies { LANES } else { lane + 1 }
    }

    /// Makes room for eight bodies of the same topology as those in `other`, and marks all lanes as done.
    pub(super) fn clear_like(&mut self, other: &Self) {
        (self.bodies, self.asleep) = (LANES, 0);
        self.convergence = ConvergenceMask { going: 0, ..ConvergenceMask::default() };
        self.now.resize(other.now.len(), LaneParticles::ZERO);
        self.start.resize(other.start.len(), LaneParticles::ZERO);
        self.saved.resize(other.now.len(), LaneParticles::ZERO);
        self.radius.resize(other.radius.len(), [0.0; LANES]);
        self.ground.resize(other.ground.len(), [0.0; LANES]);
        self.reference.resize(other.reference.len(), LaneParticles::ZERO);
        for (own, other) in self.tethers.iter_mut().zip(&other.tethers) {
            own.resize(other.len(), LaneParticles::ZERO);
        }
        self.multipliers.resize(other.multipliers.len(), [0.0; LANES]);
    }

    /// Copies a body from lane `from` of another storage, with all data that a sweep reads.
    pub(super) fn copy_body(&mut self, lane: usize, other: &Self, from: usize) {
        // Separate loops: the compiler unrolls these, but not the loop over a chained iterator.
        for (entry, other) in self.start.iter_mut().zip(&other.start) {
            entry.copy_lane(lane, other, from);
        }
        for (entry, other) in self.reference.iter_mut().zip(&other.reference) {
            entry.copy_lane(lane, other, from);
        }
        // Tethers are only projected in the first sweep of a substep.
        if other.convergence.sweeps[from] == 0.0 {
            for (own, other) in self.tethers.iter_mut().zip(&other.tethers) {
                for (entry, other) in own.iter_mut().zip(other) {
                    entry.copy_lane(lane, other, from);
                }
            }
        }
        self.islands[lane] = other.islands[from];
        let columns = self.radius.iter_mut().zip(&other.radius);
        for (column, other) in columns.chain(self.ground.iter_mut().zip(&other.ground)) {
            column[lane] = other[from];
        }
        self.copy_results(lane, other, from);
    }

    /// Copies the results of a body back from another storage in which it was solved.
    pub(super) fn copy_back(&mut self, lane: usize, other: &Self, from: usize) {
        for lane in self.copies(lane) {
            self.copy_results(lane, other, from);
        }
    }

    /// Copies what a sweep changes.
    fn copy_results(&mut self, lane: usize, other: &Self, from: usize) {
        for (entry, other) in self.now.iter_mut().zip(&other.now) {
            entry.copy_lane(lane, other, from);
        }
        for (sum, other) in self.multipliers.iter_mut().zip(&other.multipliers) {
            sum[lane] = other[from];
        }
        self.convergence.copy_lane(lane, &other.convergence, from);
    }

    /// Takes a snapshot of the bodies in a mask.
    pub(super) fn save(&mut self, which: u32) {
        for lane in SetLanes(which) {
            for (saved, now) in self.saved.iter_mut().zip(&self.now) {
                saved.set_lane(lane, now.lane(lane).truncate());
            }
        }
    }

    /// Restores the bodies in a mask from their snapshots.
    pub(super) fn restore(&mut self, which: u32) {
        for lane in SetLanes(which) {
            for (saved, now) in self.saved.iter().zip(&mut self.now) {
                now.set_lane(lane, saved.lane(lane).truncate());
            }
        }
    }
}

kernel!(
    /// Gathers the rows of an instance batch from a column that begins with row `begin`.
    pub(super) fn gather<L: Lanes>(
        to: &mut Vec<LaneParticles>,
        batch: &InstanceBatch,
        begin: u32,
        from: &[Vec4],
    ) {
        to.resize(batch.members as usize, LaneParticles::ZERO);
        let mut places = batch.places(begin, 0);
        for entry in to {
            entry.set(L::rows(from, &places));
            advance(&mut places);
        }
    }
);

kernel!(
    /// Scatters them back.
    pub(super) fn scatter<L: Lanes>(
        from: &[LaneParticles],
        batch: &InstanceBatch,
        begin: u32,
        to: &mut [Vec4],
    ) {
        let mut places = batch.places(begin, 0);
        for entry in from {
            L::put_rows(to, &places, entry.load());
            advance(&mut places);
        }
    }
);
