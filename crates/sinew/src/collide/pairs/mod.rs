//! Particles against particles: ropes, cloth and soft bodies against each other and against themselves.
//!
//! | file | what it is |
//! |---|---|
//! | `participants` | who takes part, where each was when it was looked at, and how far it may go before it must be looked at again |
//! | `skin` | whether somebody went further |
//! | `grid` | which two are near each other: cells, by counting sort |
//! | `candidates` | the pairs that it found, kept while nobody can have come near anybody else |
//! | `neighbour_list` | those that may come to touch, in colours, eight to a block |
//! | `solve` | the blocks, eight pairs at a time |
//! | `swept` | the pairs that eight at a time are not for: coincident ones, and fast ones |
//! | `restitution` | restitution, and what is reported |
//!
//! # How it goes
//!
//! [`broad_phase`](Pairs::broad_phase) runs once a step. It lists every two particles that are nearer than their radii and two margins; a margin is a
//! share of the radius. In each substep [`project`](Pairs::project) first asks whether any particle has gone further than its margin, after taking
//! off what all (or all of its body) did alike, and if so looks again. Then each pair that overlaps is pushed apart once, as a constraint is
//! (physics.md C10), with Coulomb friction.
//!
//! # The order, and what it depends on
//!
//! Pairs are sorted by their rows and coloured in that order, so that no two of a colour share a particle; colours follow each other. That makes the
//! result a function of positions and of the order of the rows alone, not of the grid, the threads or the instructions. Particles that touch nothing
//! of a heap change no bit of it as long as they do not make it look again.
//!
//! # What cannot happen, and what can
//!
//! Two particles that were apart when a substep began do not pass through each other in it, however fast they are: where one moves by more than a
//! quarter of its radius in a substep (beside what all do), the pair is stopped where it first touches, against the direction in which it does. A
//! pair stopped so is looked at twice more when all others have been solved.
//!
//! A layer of cloth lets no particle through as long as the gaps between its particles are narrower than they are: in a square lattice of spacing `s`
//! that is a radius above `s/√8 = 0.354 s`, in one of equal triangles above `s/√12 = 0.289 s`. A crossing is then a way through some pair of
//! particles, and is stopped with that. What is *not* known from particles is on which side a particle belongs: one that starts on the wrong side, or
//! that is pressed so hard that the overlap at the start of a substep is more than the gap leaves (a quarter of the distance in a square lattice),
//! stays where it got to. Wider meshes need their [`triangles`](super::triangles).

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
use super::restitution::threshold;
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

/// Contacts between particles: scratch. Nothing of it outlives the next [`broad_phase`](Self::broad_phase) but what saves looking, and changes no result.
#[derive(Clone, Debug, Default)]
pub(crate) struct Pairs {
    /// Which instructions are used; all give the same bits.
    pub(crate) instructions: InstructionSet,
    participants: Participants,
    skin_check: SkinCheck,
    grid: PairGrid,
    candidates: Candidates,
    neighbours: NeighbourList,
    /// Of this substep: blocks in which some touched.
    touched: Vec<Touched>,
    /// The same: those that were treated one by one, and those that are reported.
    hits: Vec<PairHit>,
    /// Of this substep: fast pairs, and where they were stopped.
    times_of_impact: Vec<TimeOfImpact>,
    /// Of this step: what is reported.
    reported: Vec<PairHit>,
    /// How often it looked in this step.
    rebuilds: u32,
}

impl Pairs {
    /// Lists what may come to touch in a step of `dt` seconds.
    ///
    /// Bodies that are near no other take no part, nor do particles of none. `rest` has where each particle is in
    /// the rest shape of its body, metres; it may be empty, and NaN says that it has no such place. Rows that are marked in `solid` take no part; it
    /// may be empty, too. Neither do particles without a radius, nor any that is not finite or is more than 1e15 m away from the first.
    pub(crate) fn broad_phase(
        &mut self,
        particles: &Particles,
        (filter, nearby): (&ContactFilter, &Nearby),
        rest: &[Vec3],
        solid: &[bool],
        dt: f32,
    ) {
        self.reported.clear();
        self.hits.clear();
        self.touched.clear();
        self.rebuilds = 0;
        self.participants.take(particles, nearby, rest, solid, dt);
        if self.is_empty() {
            self.neighbours.clear();
            return;
        }
        self.rebuild(particles, filter, false);
    }

    /// Whether nobody takes part.
    pub(crate) fn is_empty(&self) -> bool {
        self.participants.rows.len() < 2
    }

    /// Pushes apart what overlaps or would have passed through each other, in a substep of `h` seconds whose start is in the particles. Returns the
    /// greatest overlap that it met, metres.
    pub(crate) fn project(
        &mut self,
        particles: &mut Particles,
        filter: &ContactFilter,
        h: f32,
    ) -> f32 {
        self.hits.clear();
        self.touched.clear();
        self.times_of_impact.clear();
        // Rows that came or went since would make the lists name others.
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
                stop.hold(particles);
            }
        }
        worst
    }

    /// Gives those that met in the substep of `h` seconds the velocity that they bounce off with, where their materials ask for it. To be called when
    /// velocities have been derived; `gravity` is its size, m/s².
    pub(crate) fn bounce(&mut self, particles: &mut Particles, h: f32, gravity: f32) {
        let least = threshold(gravity, h);
        let (touched, blocks) = (&mut self.touched[..], &self.neighbours.blocks[..]);
        let velocity = &mut particles.velocity[..];
        bounce_pairs(touched, blocks, velocity, least, h, self.instructions);
        for hit in &mut self.hits {
            hit.bounce(particles, &self.touched, least);
        }
        self.reported.extend(self.hits.iter().filter(|hit| hit.reported));
    }

    /// Tells what has touched what in the step, where a body asked for it.
    pub(crate) fn report(&self, impacts: &mut Impacts) {
        for hit in &self.reported {
            hit.report(impacts);
        }
    }

    /// Looks where everybody is, and who is near whom; at the beginning of a step, or within a substep that has been predicted.
    fn rebuild(&mut self, particles: &Particles, filter: &ContactFilter, within: bool) {
        let Self { participants, skin_check, grid, candidates, neighbours, .. } = self;
        participants.place(particles, within);
        skin_check.begin(participants);
        candidates.update(participants, grid, filter, self.instructions);
        neighbours.clear();
        neighbours.take(&candidates.pairs, participants, filter);
        neighbours.colour(participants, filter);
        self.rebuilds += 1;
    }
}

/// How often pairs that were stopped are looked at again: what pushed one of the two back meanwhile is mostly its neighbour, and that one's
/// neighbour.
const RECHECKS: usize = 2;
