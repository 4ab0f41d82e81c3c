//! Triangles against particles, and against each other: the finer tier of contacts, for meshes whose particles are further apart than they are thick.
//!
//! | file | what it is |
//! |---|---|
//! | `participants` | who takes part: triangles, their corners and edges, particles |
//! | `neighbour_list` | who may come to touch whom, and whether somebody went further than was looked |
//! | `block_search` | which boxes about triangles overlap |
//! | `close_list` | who of those is close in this substep |
//! | `least_distance` | how near two may be at the least, eight at a time |
//! | `distance` | the nearest points of a particle and a triangle, and of two edges |
//! | `crossing` | whether they passed through each other |
//! | `solve` | the kernel: four points that keep a distance, and friction |
//! | `zone` | what is done where contacts do not agree |
//! | `restitution` | restitution, and what is reported |
//!
//! # Who touches whom
//!
//! The triangles are those of [`Forces::surfaces`](crate::forces::Forces::surfaces) whose three particles are of one body that asks for them
//! ([`BodyContacts::surface`]). Every particle with a radius that touches the body as [`pairs`](super::pairs) have it (another body's, or its own if
//! it touches itself) touches its triangles, with its radius and theirs ([`solve`]), from either side; and where both bodies ask, edges touch edges:
//! two meshes can pass through each other without a corner ever passing a triangle. A particle touches neither the triangles that it is a corner of,
//! nor an edge one that it shares an end with. Corners of listed triangles take no part in [`pairs`](super::pairs), unless their body touches itself: what touches a
//! corner touches its triangles there.
//!
//! # How it goes
//!
//! [`broad_phase`](Triangles::broad_phase) runs once a step, and lists who may come to touch whom, unless what was listed in an earlier one still holds. In each substep
//! [`project`](Triangles::project) looks again if somebody has gone further than was reckoned with, finds who of those is close, eight at a time (`close_list`), and
//! sweeps over these, up to [`SWEEPS`] times: whoever overlaps or has passed is put back, at once. A later sweep asks only those of whom somebody has moved since, and so
//! does another round of sweeps for those whom contacts have put further than was reckoned with. Who still passes through somebody after that goes with it for the rest of the substep (`zone`). What decides is done in double
//! precision, and one after the other: a tier for tens of thousands of triangles, not for millions.
//!
//! # The order, and what it depends on
//!
//! What is listed is in the order of the rows, and who does not touch changes nothing. That makes the result a function of positions and of the order
//! of the rows alone: not of the order of the triangles or of their corners, nor of threads or instructions. Those that touch nothing of a heap change no bit
//! of it, nor do margins, nor when it was looked last: how far contacts may put somebody before those around it are asked again follows from its radius and its speed when the
//! step begins, and not from what was found.
//!
//! # What cannot happen, and what can
//!
//! Nothing passes through a triangle, nor an edge through an edge, however fast it is and however coarse the mesh: who was on one side when a substep
//! began is there when it ends. That is the last word on positions in a substep, and what the next one begins with. It is not known, though, on which
//! side somebody *belongs*: who is put into or through a surface by the game, or is built there, stays where it is. And it does not hold where pinned
//! particles are led through each other; through particles of an explicit rigid body ([`Compound`](crate::Compound)), which are put back into its
//! shape afterwards; nor for solids, which touch the particles of a surface and not its triangles, as colliders do.
//!
//! The thickness is softer than that: in a squeeze it may be less for a while, never nothing.

mod block_search;
mod close_list;
mod crossing;
mod least_distance;
mod neighbour_list;
mod participants;
mod restitution;
mod solve;
#[cfg(test)]
mod tests;
mod zone;

use super::filter::ContactFilter;
use super::impact::Impacts;
use super::nearby::Nearby;
use super::restitution::threshold;
use crate::lanes::InstructionSet;
use crate::particles::Particles;

use neighbour_list::TriangleNeighbours;
use participants::TriangleParticipants;
use restitution::TriangleHit;
use solve::SubstepState;
use zone::Zones;

/// Contacts of triangles: scratch. Nothing of it outlives the next [`broad_phase`](Self::broad_phase) but what saves asking, and changes no result.
#[derive(Clone, Debug, Default)]
pub(crate) struct Triangles {
    participants: TriangleParticipants,
    /// Those of the step before.
    former: TriangleParticipants,
    neighbours: TriangleNeighbours,
    state: SubstepState,
    zones: Zones,
    /// Of this substep: who touched.
    hits: Vec<TriangleHit>,
    /// Of each candidate its place among those, or [`NONE`]; and of each of those its candidate.
    hit_of: Vec<u32>,
    hit_candidates: Vec<u32>,
    /// Of this step: what is reported.
    reported: Vec<TriangleHit>,
    /// Length of the step, seconds.
    dt: f32,
    /// How often it looked in this step, and how many rounds of zones there were.
    rebuilds: u32,
    rounds: u32,
}

/// How often all are asked at most in a substep, whose neighbours have moved. A heap on a sheet calls for two or three.
const SWEEPS: u32 = 4;

/// After the first sweep, what is missing of a distance is left to the next substep if it is less than this share of it.
const NEGLIGIBLE: f64 = 0.01;

/// So often those are asked again in a substep whom contacts have put further than was reckoned with.
const REPEATS: u32 = 2;

/// A candidate that did not touch.
const NONE: u32 = u32::MAX;

impl Triangles {
    /// Chooses the instructions of the wide kernels. They never change a result.
    pub(crate) fn use_instructions(&mut self, instructions: InstructionSet) {
        self.state.close.instructions = instructions;
        self.neighbours.instructions = instructions;
    }

    /// Lists what may come to touch in a step of `dt` seconds.
    ///
    /// Bodies that are near no other take no part, nor do triangles of rows that are not there, that are of several bodies or of none, or that are
    /// marked in `solid`; it may be empty. Neither does anything that is not finite, or is more than 1e15 m away from the first.
    pub(crate) fn broad_phase(
        &mut self,
        particles: &Particles,
        surfaces: &[[u32; 3]],
        (filter, nearby): (&ContactFilter, &Nearby),
        solid: &[bool],
        dt: f32,
    ) {
        self.reported.clear();
        self.hits.clear();
        (self.rebuilds, self.rounds, self.dt) = (0, 0, dt);
        core::mem::swap(&mut self.participants, &mut self.former);
        self.participants.take(particles, surfaces, (filter, nearby), solid);
        if self.is_empty() {
            self.neighbours.clear();
            return;
        }
        let Self { participants, former, neighbours, .. } = self;
        neighbours.begin_step(participants, particles, dt);
        if !participants.is_same_as(former) || !neighbours.is_valid(participants, particles, filter)
        {
            self.rebuild(particles, filter, false);
        }
    }

    /// Marks the rows of which particle pairs would do nothing that is not done here: corners of listed triangles. A particle that touches a corner touches
    /// its triangles there, at the same distance. Those of a body that touches itself are not marked: corners of one triangle do not touch it.
    pub(crate) fn mark_corners(&self, filter: &ContactFilter, rows: usize, marks: &mut Vec<bool>) {
        let TriangleParticipants { rows: members, body, triangles, .. } = &self.participants;
        if triangles.is_empty() {
            return;
        }
        marks.resize(rows, false);
        for corner in triangles.iter().flatten().map(|&corner| corner as usize) {
            if !filter.body(body[corner]).with_itself {
                marks[members[corner] as usize] = true;
            }
        }
    }

    /// Whether nobody takes part.
    pub(crate) fn is_empty(&self) -> bool {
        self.participants.rows.len() < 4
    }

    /// Puts back what overlaps or has passed through each other in a substep of which the start is in the particles. Returns the greatest overlap
    /// that it met, metres.
    pub(crate) fn project(&mut self, particles: &mut Particles, filter: &ContactFilter) -> f64 {
        self.hits.clear();
        // Rows that came or went since would make the lists name others.
        let last = self.participants.rows.last().map_or(0, |&row| row as usize);
        if self.is_empty() || last >= particles.len() {
            return 0.0;
        }
        if self.neighbours.is_outrun(&self.participants, particles, true) {
            self.rebuild(particles, filter, true);
        }
        if self.neighbours.candidates.is_empty() {
            return 0.0;
        }
        self.state.load(&self.participants, particles);
        let (mut worst, mut sweep) = (0.0_f64, 0);
        let mut fresh = true;
        for repeat in 0..=REPEATS {
            self.hit_of.resize(self.neighbours.candidates.len(), NONE);
            let Self { participants, state, .. } = self;
            if fresh {
                state.close.begin_substep(participants, particles);
            }
            let (before, mut agree) = (sweep, false);
            for number in 0..SWEEPS {
                sweep += 1;
                // All; after that those of whom one was put further than was reckoned with, or has moved in the last sweep or in this one.
                let since = if number == 0 && repeat == 0 { 0 } else { sweep - 1 };
                // That it has looked again changes nothing where all agreed.
                let least = if sweep == 1 { 0.0 } else { NEGLIGIBLE };
                worst = worst.max(self.sweep((particles, filter), sweep, since, least));
                agree = !self.state.moved.contains(&sweep);
                if agree {
                    break;
                }
            }
            // What no contact had to be put back in passes through nobody.
            if !agree {
                let Self { neighbours, state, zones, .. } = self;
                let rounds = zones.settle(&neighbours.candidates, state, sweep + 1);
                (sweep, self.rounds) = (sweep + rounds, self.rounds + rounds);
            }
            for candidate in self.hit_candidates.drain(..) {
                self.hit_of[candidate as usize] = NONE;
            }
            let moved = self.state.moved.iter().any(|&moved| moved > before);
            if !moved {
                break;
            }
            let Self { participants, neighbours, state, .. } = self;
            let far = state.store(participants, particles, &neighbours.reserve, sweep);
            if !far || repeat == REPEATS {
                break;
            }
            fresh = neighbours.is_outrun(participants, particles, false);
            if fresh {
                self.rebuild(particles, filter, true);
            }
        }
        worst
    }

    /// Gives those that met in the substep of `h` seconds the velocity that they part with. To be called when velocities have been derived; `gravity`
    /// is its size, m/s².
    pub(crate) fn bounce(&mut self, particles: &mut Particles, h: f32, gravity: f32) {
        for hit in &mut self.hits {
            hit.bounce(particles, h, threshold(gravity, h));
        }
        self.reported.extend(self.hits.iter().filter(|hit| hit.reported));
    }

    /// Tells what has touched what in the step, where a body asked for it.
    pub(crate) fn report(&self, impacts: &mut Impacts) {
        for hit in &self.reported {
            hit.report(impacts);
        }
    }

    /// Asks all candidates of whom one has moved since a sweep, and puts back who overlaps by more than `least` of the distance; returns the greatest overlap,
    /// metres.
    fn sweep(
        &mut self,
        (particles, filter): (&Particles, &ContactFilter),
        sweep: u32,
        since: u32,
        least: f64,
    ) -> f64 {
        let Self { participants, neighbours, state, hits, hit_of, hit_candidates, .. } = self;
        let candidates = &neighbours.candidates[..];
        state.close.keep_up();
        // The next eight, and which of those before them are close and still to be asked.
        let (mut worst, mut next, mut close) = (0.0_f64, 0, 0_u32);
        loop {
            if close == 0 {
                let Some(these) = state.close.ask(next, 0) else { break };
                (next, close) = (next + 1, these);
                continue;
            }
            let number = state.close.number(next - 1, close.trailing_zeros());
            close &= close - 1;
            let candidate = &candidates[number as usize];
            if !state.moved_since(candidate.four, since) {
                continue;
            }
            let Some(contact) = state.contact(participants, candidate) else { continue };
            let least = if contact.crossed { 0.0 } else { least * contact.reach };
            let inverse = state.inverse(candidate.four, contact.way.shares);
            // What nothing moves is no contact.
            if contact.overlap <= least || inverse <= 0.0 {
                continue;
            }
            worst = worst.max(contact.overlap);
            let of = &mut hit_of[number as usize];
            if *of == NONE {
                *of = hits.len() as u32;
                hit_candidates.push(number);
                hits.push(TriangleHit::new(participants, filter, candidate));
            }
            let hit = &mut hits[*of as usize];
            hit.note(particles, state, candidate.four, &contact, inverse);
            let (four, shares, normal) = (candidate.four, contact.way.shares, contact.way.normal);
            state.part(four, shares, normal * contact.overlap, inverse, sweep);
            let moved = state.moved(four, shares);
            let slid = moved - normal * normal.dot(moved);
            if slid.length() <= f64::from(hit.friction) * hit.overlap {
                state.part(four, shares, -slid, inverse, sweep);
            }
            // Others may be close now, of the same eight, too.
            let outrun = state.close.keep_up();
            let place = if outrun { state.close.place_of(number + 1) } else { next - 1 };
            let others = state.close.ask(place, number + 1);
            (next, close) = (place + 1, others.unwrap_or(0));
        }
        worst
    }

    fn rebuild(&mut self, particles: &Particles, filter: &ContactFilter, within: bool) {
        let Self { participants, neighbours, state, .. } = self;
        neighbours.rebuild((participants, filter), particles, self.dt, within);
        let TriangleNeighbours { candidates, ranges, .. } = neighbours;
        state.close.pick(candidates, participants, particles, ranges);
        self.rebuilds += 1;
    }
}
