//! Contacts between particles: ropes, cloth and soft bodies against each other and against themselves.
//!
//! | file | what it is |
//! |---|---|
//! | `participants` | the particles that take part, their positions when the neighbour list was built, and their margins |
//! | `skin` | whether a particle has moved further than its margin |
//! | `grid` | broad phase: uniform cells by counting sort |
//! | `candidates` | the pairs that the grid found, kept while no pair can be missing |
//! | `neighbour_list` | the pairs within their margins, graph coloured, eight to a block |
//! | `solve` | position solve of the blocks, eight pairs at a time |
//! | `swept` | scalar path: coincident and fast pairs |
//! | `restitution` | restitution, and contact events |
//!
//! # Algorithm
//!
//! [`broad_phase`](Pairs::broad_phase) runs once a step. It lists every pair of particles that are closer than the sum of their radii and margins; a margin is
//! a fraction of the radius. In each substep [`project`](Pairs::project) first checks whether any particle has moved further than its margin, relative to the
//! common displacement of all particles or of its body, and if so rebuilds the list. Then each pair that overlaps is pushed apart once, like a constraint
//! (physics.md C10), with Coulomb friction.
//!
//! # Order and determinism
//!
//! Pairs are sorted by their rows and coloured in that order, so that no two of a colour share a particle; colours are solved one after the other. That makes
//! the result a function of positions and of the order of the rows alone, not of the grid, the threads or the instruction set. Particles that do not touch a
//! heap change no bit of its result, as long as they do not trigger a rebuild.
//!
//! # What is guaranteed, and what is not
//!
//! Two particles that were apart at the start of a substep do not pass through each other in it, however fast they are: where one moves by more than a quarter
//! of its radius in a substep (relative to the common displacement), the pair is stopped at its time of impact, along the normal there. Pairs stopped in this
//! way are solved twice more after all others.
//!
//! A layer of cloth lets no particle through as long as the gaps between its particles are narrower than the particle: in a square lattice of spacing `s` that
//! requires a radius above `s/√8 = 0.354 s`, in one of equilateral triangles above `s/√12 = 0.289 s`. A crossing then passes through some pair of particles,
//! and is stopped with that pair. Particles do *not* determine on which side of the cloth a particle belongs: one that starts on the wrong side, or is pressed
//! so hard that the overlap at the start of a substep exceeds what the gap leaves (a quarter of the distance in a square lattice), stays on the side that it
//! reached. Coarser meshes need [`triangles`](super::triangles).

mod candidates;
mod grid;
mod neighbour_list;
mod participants;
mod restitution;
mod skin;
mod solve;
mod swept;
#[cfg(test)]
mod tests;

use glam::Vec3;

use super::filter::ContactFilter;
use super::impact::Impacts;
use super::nearby::Nearby;
use super::restitution::ImpactRound;
use crate::lanes::{InstructionSet, with};
use crate::particles::Particles;

use candidates::Candidates;
use grid::PairGrid;
use neighbour_list::NeighbourList;
use participants::Participants;
use restitution::{PairHit, Touched, bounce_pairs};
use skin::SkinCheck;
use solve::PairSweep;
use swept::TimeOfImpact;

/// Contacts between particles: scratch. What outlives the next [`broad_phase`](Self::broad_phase) only saves work and changes no result.
#[derive(Clone, Debug, Default)]
pub(crate) struct Pairs {
    /// Instruction set of the kernels; all give the same bits.
    pub(crate) instructions: InstructionSet,
    participants: Participants,
    skin_check: SkinCheck,
    grid: PairGrid,
    candidates: Candidates,
    neighbours: NeighbourList,
    /// Blocks of this substep with a contact.
    touched: Vec<Touched>,
    /// Contacts of this substep that were solved one by one or are reported.
    hits: Vec<PairHit>,
    /// Fast pairs of this substep that were stopped at their time of impact.
    times_of_impact: Vec<TimeOfImpact>,
    /// Contacts of this step to be reported.
    reported: Vec<PairHit>,
    /// Neighbour list builds in this step.
    rebuilds: u32,
}

impl Pairs {
    /// Lists the pairs that may touch in a step of `dt` seconds.
    ///
    /// Bodies that are near no other take no part, nor do particles without a body. `rest` holds the position of each particle in the rest shape of its body,
    /// metres; it may be empty, and NaN means no rest position. Rows that are marked in `excluded` take no part; it may be empty, too. Particles without a
    /// radius take no part, nor do those that are not finite or more than 1e15 m away from the first.
    pub(crate) fn broad_phase(
        &mut self,
        particles: &Particles,
        (filter, nearby): (&ContactFilter, &Nearby),
        rest: &[Vec3],
        excluded: &[bool],
        dt: f32,
    ) {
        self.reported.clear();
        self.hits.clear();
        self.touched.clear();
        self.rebuilds = 0;
        self.participants.collect(particles, nearby, rest, excluded, dt);
        if self.is_empty() {
            self.neighbours.clear();
            return;
        }
        self.rebuild(particles, filter, false);
    }

    /// Whether fewer than two particles take part.
    pub(crate) fn is_empty(&self) -> bool {
        self.participants.rows.len() < 2
    }

    /// Pushes apart pairs that overlap or would have passed through each other, in a substep of `h` seconds whose start positions are in the particles. Returns
    /// the greatest overlap found, metres.
    pub(crate) fn project(
        &mut self,
        particles: &mut Particles,
        filter: &ContactFilter,
        h: f32,
    ) -> f32 {
        self.hits.clear();
        self.touched.clear();
        self.times_of_impact.clear();
        // Rows added or removed since would invalidate the rows in the lists.
        if self.is_empty() || self.participants.last() >= particles.len() {
            return 0.0;
        }
        let [exceeded, fast] =
            self.skin_check.check(&self.participants, particles, self.instructions);
        if exceeded || self.participants.expired {
            self.rebuild(particles, filter, true);
        }
        let Self { neighbours, touched, hits, times_of_impact, .. } = self;
        let sweep =
            PairSweep { neighbours, filter, particles, fast, h, touched, hits, times_of_impact };
        let worst = with(self.instructions, sweep);
        for _ in 0..RECHECKS {
            for stop in &self.times_of_impact {
                stop.enforce(particles);
            }
        }
        worst
    }

    /// Whether any pair touched in this substep.
    pub(super) fn any_touched(&self) -> bool {
        !(self.touched.is_empty() && self.hits.is_empty())
    }

    /// Applies restitution to the pairs that touched in the substep. To be called after velocities have been derived.
    pub(super) fn bounce(&mut self, particles: &mut Particles, round: &mut ImpactRound) {
        let Self { touched, neighbours, hits, instructions, .. } = self;
        let (velocity, blocks) = (&mut particles.velocity[..], &neighbours.blocks[..]);
        bounce_pairs(touched, blocks, velocity, round, *instructions);
        hits.iter_mut().for_each(|hit| hit.bounce(particles, round));
    }

    /// Records the contacts to be reported, after the last round of a substep.
    pub(super) fn end_substep(&mut self) {
        let Self { touched, hits, reported, .. } = self;
        hits.iter_mut().for_each(|hit| hit.note_impulse(touched));
        reported.extend(hits.iter().filter(|hit| hit.reported));
    }

    /// Reports the contacts of the step that involve a body with events enabled.
    pub(crate) fn report(&self, impacts: &mut Impacts) {
        for hit in &self.reported {
            hit.report(impacts);
        }
    }

    /// Rebuilds the neighbour list: at the beginning of a step, or `within` a substep whose positions have been predicted.
    fn rebuild(&mut self, particles: &Particles, filter: &ContactFilter, within: bool) {
        let Self { participants, skin_check, grid, candidates, neighbours, .. } = self;
        participants.place(particles, within);
        skin_check.begin(participants);
        candidates.update(participants, grid, filter, self.instructions);
        neighbours.clear();
        neighbours.select(&candidates.pairs, participants, filter);
        neighbours.colour(participants, filter);
        self.rebuilds += 1;
    }
}

/// Number of extra solves of pairs stopped at their time of impact: what pushes one of the two back in the meantime is mostly its neighbour, and that one's
/// neighbour.
const RECHECKS: usize = 2;
