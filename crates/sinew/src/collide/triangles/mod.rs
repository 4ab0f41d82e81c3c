//! Contacts of triangles with particles and with each other: the finer tier of contacts, for meshes whose particles are further apart than they are thick.
//!
//! | file | contents |
//! |---|---|
//! | `participants` | triangles, their corners and edges, and particles that take part |
//! | `neighbour_list` | candidate pairs with a margin, and whether a margin was exceeded |
//! | `search` | the candidates of overlapping boxes |
//! | `close_list` | the candidates that are close in this substep |
//! | `least_distance` | lower bounds of distances, eight at a time |
//! | `distance` | nearest points of a particle and a triangle, and of two edges |
//! | `crossing` | continuous collision detection |
//! | `solve` | the kernel: a distance constraint of four points, and friction |
//! | `zone` | impact zones, where contacts do not converge |
//! | `restitution` | restitution and contact events |
//!
//! # What touches what
//!
//! The triangles are those of [`Forces::surfaces`](crate::forces::Forces::surfaces) whose three particles belong to one body with
//! [`BodyContacts::surface`](crate::BodyContacts::surface). Every particle with a radius that collides with the body according to [`pairs`](super::pairs)
//! (another body's, or its own if the body collides with itself) collides with its triangles, at the sum of both thicknesses ([`solve`]), from either side.
//! Where both bodies have surfaces, edges collide with edges too: two meshes can pass through each other without a corner ever passing through a triangle. A
//! particle does not collide with the triangles that it is a corner of, nor an edge with one that it shares an end with. Corners of listed triangles take no
//! part in [`pairs`](super::pairs), unless their body collides with itself: what touches a corner touches its triangles there.
//!
//! # Stages
//!
//! [`broad_phase`](Triangles::broad_phase) runs once a step and builds the neighbour list, unless that of an earlier step is still valid. In each substep
//! [`project`](Triangles::project) refreshes the part of the list whose members exceed their margins (all of it if they are many), selects the close
//! candidates, eight at a time (`close_list`), and sweeps over these up to [`SWEEPS`] times: candidates that overlap or have passed through each other are
//! corrected at once. A later sweep tests only candidates with a member that moved since the last one, and a further round of sweeps only those with a member
//! that contacts displaced by more than its reserve. Candidates that still pass through each other after that move together for the rest of the substep
//! (`zone`). Searches use all workers. All decisions are made in double precision and one after the other: this tier is for tens of thousands of triangles, not
//! for millions.
//!
//! # Order and determinism
//!
//! The neighbour list is in the order of the rows, and candidates without contact change nothing. So the result is a function of positions and of the order of
//! the rows alone, and does not depend on the order of the triangles or of their corners, on threads or on instruction sets. Objects without contact change no
//! bit of a heap, nor do margins, nor the time of the last rebuild: the reserve, beyond which the neighbours of a displaced member are tested again, follows
//! from its radius and its speed at the start of the step, and not from the list.
//!
//! # Guarantees and limits
//!
//! Nothing passes through a triangle, and no edge through an edge, however fast it is and however coarse the mesh: each is at the end of a substep on the side
//! where it began. This is the last stage that changes positions in a substep, and the next one begins with its result. There is no global notion of inside,
//! though: a particle that the game places in or through a surface, or that is built there, stays there. And the guarantee does not hold for pinned particles
//! that are moved through each other, nor for particles of an explicit rigid body ([`Compound`](crate::Compound)), which are restored to its shape afterwards.
//! Colliders and body colliders meet triangles elsewhere ([`features`](super::features)).
//!
//! The thickness is weaker than that: under pressure it may shrink for a while, but never to nothing.

mod close_list;
mod crossing;
mod least_distance;
mod neighbour_list;
mod participants;
mod restitution;
mod search;
mod solve;
#[cfg(test)]
mod tests;
mod zone;

use super::filter::ContactFilter;
use super::impact::Impacts;
use super::nearby::Nearby;
use super::restitution::ImpactRound;
use crate::particles::Particles;
use crate::threads::ExecutionContext;

use neighbour_list::TriangleNeighbours;
use participants::TriangleParticipants;
use restitution::TriangleHit;
use solve::SubstepState;
use zone::Zones;

/// Contacts of triangles: scratch. What outlives the next [`broad_phase`](Self::broad_phase) only saves tests and changes no result.
#[derive(Clone, Debug, Default)]
pub(crate) struct Triangles {
    participants: TriangleParticipants,
    /// The participants of the step before.
    former: TriangleParticipants,
    neighbours: TriangleNeighbours,
    state: SubstepState,
    zones: Zones,
    /// Contacts of this substep.
    hits: Vec<TriangleHit>,
    /// Index of each candidate's contact, or [`NONE`]; and the candidates that have one.
    hit_of: Vec<u32>,
    hit_candidates: Vec<u32>,
    /// Members and index of each contact found in this substep before the last rebuild within it; sorted.
    earlier: Vec<(([u32; 4], bool), u32)>,
    /// Reported contacts of this step.
    reported: Vec<TriangleHit>,
    /// Length of the step, seconds.
    dt: f32,
    /// Rebuilds of the neighbour list, refreshes of a part of it, and rounds of zones in this step.
    rebuilds: u32,
    refreshes: u32,
    rounds: u32,
}

/// Greatest number of sweeps in a substep. A heap on a sheet takes two or three.
const SWEEPS: u32 = 4;

/// After the first sweep, an overlap of less than this share of the contact distance is left to the next substep.
const NEGLIGIBLE: f64 = 0.01;

/// Further rounds of sweeps in a substep for members that contacts displaced by more than their reserve.
const MAX_REPEATS: u32 = 2;

/// A candidate without contact.
const NONE: u32 = u32::MAX;

impl Triangles {
    /// Builds the neighbour list for a step of `dt` seconds, unless the last one is still valid.
    ///
    /// Ignored are bodies near no other body, and triangles with rows out of range, of several bodies or none, or marked in `excluded`, which may be shorter
    /// than the rows. Particles that are not finite, or are more than 1e15 m from the first one, have no candidates.
    pub(crate) fn broad_phase(
        &mut self,
        particles: &Particles,
        surfaces: &[[u32; 3]],
        (filter, nearby): (&ContactFilter, &Nearby),
        excluded: &[bool],
        dt: f32,
        execution: ExecutionContext<'_>,
    ) {
        self.reported.clear();
        self.hits.clear();
        (self.rebuilds, self.refreshes, self.rounds, self.dt) = (0, 0, 0, dt);
        core::mem::swap(&mut self.participants, &mut self.former);
        self.participants.collect(particles, surfaces, (filter, nearby), excluded);
        if self.is_empty() {
            self.neighbours.clear();
            return;
        }
        let Self { participants, former, neighbours, .. } = self;
        neighbours.begin_step(participants, particles, dt);
        let is_valid =
            participants.is_same_as(former) && neighbours.is_valid(participants, particles, filter);
        if !is_valid {
            self.update((particles, filter), (true, false), execution);
        } else if neighbours.exceeds_margins(participants, particles, true) {
            self.update((particles, filter), (false, false), execution);
        }
    }

    /// Marks the rows whose particle pairs would add nothing: corners of listed triangles. A particle that touches a corner touches its triangles there, at the
    /// same distance. Corners of a body that collides with itself are not marked: corners of one triangle do not collide with it.
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

    /// Whether there are no participants.
    pub(crate) fn is_empty(&self) -> bool {
        self.participants.rows.len() < 4
    }

    /// Corrects overlaps and crossings of a substep whose start is in the particles. Returns the greatest overlap found, metres.
    pub(crate) fn project(
        &mut self,
        particles: &mut Particles,
        filter: &ContactFilter,
        execution: ExecutionContext<'_>,
    ) -> f64 {
        self.hits.clear();
        // If rows were removed since, the list would refer to others.
        let last = self.participants.rows.last().map_or(0, |&row| row as usize);
        if self.is_empty() || last >= particles.len() {
            return 0.0;
        }
        self.neighbours.begin_substep();
        if self.neighbours.exceeds_margins(&self.participants, particles, true) {
            self.update((particles, filter), (false, true), execution);
        }
        if self.neighbours.candidates.is_empty() {
            return 0.0;
        }
        self.state.load(&self.participants, particles);
        self.earlier.clear();
        let (mut worst, mut sweep) = (0.0_f64, 0);
        let mut fresh = true;
        for repeat in 0..=MAX_REPEATS {
            self.hit_of.resize(self.neighbours.candidates.len(), NONE);
            let Self { participants, state, .. } = self;
            if fresh {
                state.close.begin_substep(participants, particles, execution);
            }
            let (before, mut agree) = (sweep, false);
            for number in 0..SWEEPS {
                sweep += 1;
                // All candidates first; then those of which a member moved in the last sweep or in this one, or was displaced by more than its reserve.
                let since = if number == 0 && repeat == 0 { 0 } else { sweep - 1 };
                // Zero in the very first sweep only: a repeat must not change a result with which all contacts already agreed.
                let least = if sweep == 1 { 0.0 } else { NEGLIGIBLE };
                worst = worst.max(self.sweep((particles, filter), sweep, since, least));
                agree = !self.state.moved.contains(&sweep);
                if agree {
                    break;
                }
            }
            // If the last sweep corrected nothing, nothing passes through anything.
            if !agree {
                let Self { neighbours, state, zones, .. } = self;
                let rounds = zones.resolve(&neighbours.candidates, state, sweep + 1);
                (sweep, self.rounds) = (sweep + rounds, self.rounds + rounds);
            }
            let moved = self.state.moved.iter().any(|&moved| moved > before);
            if !moved {
                break;
            }
            let Self { participants, neighbours, state, .. } = self;
            let far = state.store(participants, particles, &neighbours.reserve, sweep);
            if !far || repeat == MAX_REPEATS {
                break;
            }
            fresh = neighbours.exceeds_margins(participants, particles, false);
            if fresh {
                // Candidates are renumbered: contacts of this substep are found by their members from now on.
                self.reset_hit_indices();
                let numbered = (0..).zip(&self.hits);
                self.earlier.clear();
                self.earlier.extend(numbered.map(|(index, hit)| (hit.members, index)));
                self.earlier.sort_unstable();
                self.update((particles, filter), (false, true), execution);
            }
        }
        self.reset_hit_indices();
        worst
    }

    fn reset_hit_indices(&mut self) {
        for candidate in self.hit_candidates.drain(..) {
            self.hit_of[candidate as usize] = NONE;
        }
    }

    /// Whether anything touched in this substep.
    pub(super) fn any_touched(&self) -> bool {
        !self.hits.is_empty()
    }

    /// Applies restitution and friction to the contacts of a substep. To be called after velocities are derived.
    pub(super) fn bounce(&mut self, particles: &mut Particles, round: &mut ImpactRound) {
        self.hits.iter_mut().for_each(|hit| hit.bounce(particles, round));
    }

    /// Records the contacts to be reported, after the last round of a substep.
    pub(super) fn end_substep(&mut self) {
        self.reported.extend(self.hits.iter().filter(|hit| hit.reported));
    }

    /// Reports the contacts of the step, for bodies with contact events.
    pub(crate) fn report(&self, impacts: &mut Impacts) {
        for hit in &self.reported {
            hit.report(impacts);
        }
    }

    /// Tests all candidates of which a member moved in sweep `since` or later, and corrects those that overlap by more than `least` of their contact distance;
    /// returns the greatest overlap, metres.
    fn sweep(
        &mut self,
        (particles, filter): (&Particles, &ContactFilter),
        sweep: u32,
        since: u32,
        least: f64,
    ) -> f64 {
        let Self { participants, neighbours, state, hits, hit_of, hit_candidates, earlier, .. } =
            self;
        let candidates = &neighbours.candidates[..];
        state.close.update();
        // The next block, and the close candidates of the block before it that are still to be tested.
        let (mut worst, mut next, mut close) = (0.0_f64, 0, 0_u32);
        loop {
            if close == 0 {
                let Some(these) = state.close.close_lanes(next, 0) else { break };
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
            // If all are pinned there is nothing to correct.
            if contact.overlap <= least || inverse <= 0.0 {
                continue;
            }
            worst = worst.max(contact.overlap);
            let of = &mut hit_of[number as usize];
            if *of == NONE {
                let members = (candidate.four, candidate.edges);
                let known = earlier.binary_search_by_key(&members, |&(members, _)| members);
                *of = known.map_or(hits.len() as u32, |place| earlier[place].1);
                hit_candidates.push(number);
                if known.is_err() {
                    hits.push(TriangleHit::new(participants, filter, candidate));
                }
            }
            let hit = &mut hits[*of as usize];
            hit.record(particles, state, candidate.four, &contact, inverse);
            let (four, shares, normal) = (candidate.four, contact.way.shares, contact.way.normal);
            state.separate(four, shares, normal * contact.overlap, inverse, sweep);
            let moved = state.moved(four, shares);
            let slid = moved - normal * normal.dot(moved);
            if slid.length() <= f64::from(hit.friction) * hit.overlap {
                state.separate(four, shares, -slid, inverse, sweep);
            }
            // The correction may have made other candidates close, in this block too.
            let relisted = state.close.update();
            let place = if relisted { state.close.place_of(number + 1) } else { next - 1 };
            let others = state.close.close_lanes(place, number + 1);
            (next, close) = (place + 1, others.unwrap_or(0));
        }
        worst
    }

    /// Brings the list up to date, `within` a substep or when a step begins: replaces the part of it whose members have exceeded their margins, if they are few,
    /// and otherwise, or if it `is_invalid`, builds it anew.
    fn update(
        &mut self,
        (particles, filter): (&Particles, &ContactFilter),
        (is_invalid, within): (bool, bool),
        execution: ExecutionContext<'_>,
    ) {
        let Self { participants, neighbours, state, .. } = self;
        let when = (self.dt, within);
        if is_invalid || !neighbours.few_exceed() {
            neighbours.rebuild((participants, filter), particles, when, execution);
            self.rebuilds += 1;
        } else {
            participants.index_triangles();
            neighbours.refresh((participants, filter), particles, when, execution);
            self.refreshes += 1;
        }
        state.close.pack(&neighbours.candidates, participants);
    }
}
