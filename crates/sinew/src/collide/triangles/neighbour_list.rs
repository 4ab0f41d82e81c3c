//! Neighbour list: candidate pairs found by their boxes, with a margin for each particle within which the list stays valid.
//!
//! Each particle's box encloses its path, from the start of the substep (if one has been predicted) to its position, enlarged by its radius and its margin. As
//! long as no particle exceeds its margin relative to the mean displacement of all, the list contains every pair that touches. A triangle's box is the union of
//! those of its corners. The list is in the order of the triangles that own its features, and so in that of the rows, whatever the margins are.

use glam::{DVec3, Vec3, Vec4};

use super::close_list::{ROUNDING, first_origin, place};
use super::participants::{EDGES, TriangleParticipants};
use super::search::{
    CandidateSearch, FindCandidates, FoundCandidates, TriangleCandidate, boxes_of,
};
use crate::collide::filter::ContactFilter;
use crate::collide::manifold::{Aabb, BlockSearch, EightBoxes, NO_GROUP};
use crate::lanes::with;
use crate::particles::{NO_BODY, Particles};
use crate::threads::{ExecutionContext, each_chunk};

/// The neighbour list, and the state from which it was built. Scratch.
#[derive(Clone, Debug, Default)]
pub(super) struct TriangleNeighbours {
    /// Candidates of particles and triangles, then those of edges; each kind sorted by the pair of boxes.
    pub(super) candidates: Vec<TriangleCandidate>,
    /// Candidates found by the last search, by chunk of the pairs, and all likewise; and the list with some of them replaced.
    of_chunks: Vec<FoundCandidates>,
    found: Vec<TriangleCandidate>,
    merged: Vec<TriangleCandidate>,
    /// Position of each member when the list was built, metres from its own origin, and its margin, metres.
    home: Vec<Vec3>,
    margin: Vec<f32>,
    /// By which share margins are reduced because members are crowded.
    reduction: f32,
    /// Length of the shortest edge of each member, metres.
    shortest: Vec<f32>,
    /// Displacement of all members since then, metres: each was within its margin about it when margins were last tested, and when this substep began.
    common: Vec3,
    common_at_start: Vec3,
    /// Members that have exceeded their margins, ascending; the boxes that depend on them, a mark for each box, and the list of those marked.
    exceeded: Vec<u32>,
    is_affected: Vec<bool>,
    affected: Vec<u32>,
    /// How far contacts may displace each member from its predicted position in a substep of this step before the list is tested again, metres: part of its
    /// margin.
    pub(super) reserve: Vec<f32>,
    /// How far each member can be from its position: its displacement in this substep plus its margin, metres.
    ranges: Vec<f32>,
    /// Position of each member, metres from the first member's origin, and in `w` its range.
    ends: Vec<Vec4>,
    /// Whether each member is pinned, and its origin, metres, when the list was built.
    pinned: Vec<bool>,
    origin: Vec<Vec3>,
    /// What boxes are relative to, metres.
    zero: Vec3,
    /// Version of the contact filter's [rules](ContactFilter::changes) for which the list was built; `None` if there is no list.
    rules: Option<u64>,
    /// The boxes of members; those of the [features](super::search) of each triangle; and those of triangles and loose particles.
    own: Vec<Aabb>,
    of_triangles: Vec<EightBoxes>,
    boxes: Vec<(Vec3, Vec3)>,
    pairs: Vec<[u32; 2]>,
    search: BlockSearch,
}

/// Where members are crowded, margins are reduced: with more than `CROWDED` candidates for each member the next list has smaller ones, down to `LEAST_SHARE` of
/// them; with less than `SPARSE` they grow by `GROWTH` again. In a crumpled corner the number of candidates grows with the volume of the margins, and most of
/// them last for a substep only. A sheet of 64 × 64 that falls on another one, on a ball, has 67 candidates for each member while it lands, and 7 at rest: the
/// longest frame takes 250, 202 and 175 ms without this and with 24 and 16, and what follows the same. Of a figure that runs through four sheets, where there
/// are 170, the longest takes 4.9 and 1.8 s without and with 16.
const CROWDED: f32 = 16.0;
const SPARSE: f32 = 0.8 * CROWDED;
const LEAST_SHARE: f32 = 0.1;
const GROWTH: f32 = 1.5;

/// A member's margin is its reserve plus the path over `MARGIN_STEPS` steps relative to the mean motion, at its own speed or the mean speed, whichever is
/// greater (a faster member may hit it). The path is clamped to the bounds below, which are shares of its shortest edge and of its radius.
///
/// A wider margin finds more candidates that are never close, a narrower one is exceeded sooner. Two sheets of 64 × 64, one of which falls on the other, on a
/// ball: contacts of triangles take 101, 60 and 52 ms a tick with one step, a half and a quarter while they land (ticks 30 to 60), 32, 33 and 42 after that, and
/// 17 to 20 at rest with any of them.
const MARGIN_STEPS: f32 = 0.5;
const MIN_MARGIN: [f32; 2] = [0.02, 0.25];
const MAX_MARGIN: [f32; 2] = [0.5, 1.0];

/// Reserve: a share of the member's radius (of the mean radius, if it has none) plus its path in a share of a step. More reserve causes fewer repeated tests,
/// but wider margins: the two sheets, in which some members are displaced further than that in each substep, take 43.6, 39.3 and 37.8 ms with a quarter, an
/// eighth and this share of the radius.
const RESERVE: [f32; 2] = [0.06, 0.03];

/// Upper bound of the rounding error of an `f32` length, as a factor.
pub(super) const LONGER: f32 = 1.0 + 1e-5;

/// Further out, squares overflow in `f32`, metres.
const FAR: f64 = 1e15;

/// When a member exceeds its margin, members that have used up this share of theirs are refreshed with it, because they would be next: at rest the two sheets
/// are refreshed 11, 3 and 1 times a tick with 1, 0.75 and 0.5, the last of which has the whole list rebuilt more often.
const NEARLY: f32 = 0.75;

/// The whole list is rebuilt when the mean displacement is greater, metres.
const MAX_DRIFT: f32 = 10.0;

/// The whole list is rebuilt if more than one in this many members has exceeded its margin; otherwise only their part of it.
const REBUILD_DIVISOR: usize = 16;

/// Number of pairs of boxes that are worth a task: it takes some 100 µs.
const CHUNK: usize = 1024;

impl TriangleNeighbours {
    pub(super) fn clear(&mut self) {
        self.candidates.clear();
        self.rules = None;
    }

    /// Begins a step of `dt` seconds: computes the reserves.
    pub(super) fn begin_step(
        &mut self,
        participants: &TriangleParticipants,
        particles: &Particles,
        dt: f32,
    ) {
        let (mut sum, mut count) = (0.0, 0.0);
        for radius in participants.radius.iter().filter(|radius| **radius > 0.0) {
            sum += f64::from(*radius);
            count += 1.0;
        }
        let usual = if count > 0.0 { (sum / count) as f32 } else { 0.0 };
        let [of_radius, of_step] = RESERVE;
        self.reserve.clear();
        self.reserve.extend(participants.rows.iter().zip(&participants.radius).map(
            |(&row, &radius)| {
                let speed = particles.velocity[row as usize].truncate().length();
                let radius = if radius > 0.0 { radius } else { usual };
                // NaN counts as zero.
                of_radius * radius + (of_step * dt * speed).max(0.0)
            },
        ));
    }

    /// Whether the list of an earlier step, with the same participants, can serve the step that begins, apart from members that exceed their margins.
    pub(super) fn is_valid(
        &self,
        participants: &TriangleParticipants,
        particles: &Particles,
        filter: &ContactFilter,
    ) -> bool {
        let rows = participants.rows.iter().map(|&row| row as usize);
        // A member that was not finite has no candidates.
        self.rules == Some(filter.changes())
            && self.home.iter().all(|home| home.is_finite())
            && rows.zip(self.pinned.iter().zip(&self.origin)).all(|(row, (&pinned, &origin))| {
                (particles.position[row].w == 0.0) == pinned && particles.origin[row] == origin
            })
    }

    /// A substep begins where the last one ended.
    pub(super) fn begin_substep(&mut self) {
        self.common_at_start = self.common;
    }

    /// Finds the members that have moved further than their margins relative to the mean displacement; with `keeps_reserve`, further than their margins less
    /// their reserves, so that contacts may still displace them. Returns whether there are any.
    pub(super) fn exceeds_margins(
        &mut self,
        participants: &TriangleParticipants,
        particles: &Particles,
        keeps_reserve: bool,
    ) -> bool {
        let Self { home, margin, reserve, exceeded, .. } = self;
        let rows = participants.rows.iter().map(|&row| row as usize);
        let moved = |(row, home): (usize, &Vec3)| particles.position[row].truncate() - *home;
        let displacements = rows.zip(&*home).map(moved);
        let common = mean(displacements.clone());
        let limits = margin.iter().zip(&*reserve);
        let limits = limits.map(|(all, kept)| if keeps_reserve { all - kept } else { *all });
        exceeded.clear();
        let mut any = false;
        for ((own, limit), number) in displacements.zip(limits).zip(0..) {
            // NaN is ignored.
            let displacement = (own - common).length() * LONGER;
            any |= displacement > limit;
            if displacement > NEARLY * limit {
                exceeded.push(number);
            }
        }
        self.common = common;
        any || self.is_far_from_list()
    }

    /// Whether all have come so far since the list was built that rounding would count: positions of `f32` are off by a micrometre there.
    fn is_far_from_list(&self) -> bool {
        self.common.length_squared() > MAX_DRIFT * MAX_DRIFT
    }

    /// Whether so few members exceed their margins that [`refresh`](Self::refresh) does.
    pub(super) fn few_exceed(&self) -> bool {
        self.exceeded.len() * REBUILD_DIVISOR <= self.home.len() && !self.is_far_from_list()
    }

    /// Replaces the candidates of the members that exceed their margins, and takes the present positions as theirs; otherwise as
    /// [`rebuild`](Self::rebuild).
    ///
    /// All boxes are of one frame, which moves along with the mean displacement: what has not exceeded its margin is in its box there, both when the substep
    /// began and as it ends, and so is what is put in anew.
    pub(super) fn refresh(
        &mut self,
        (participants, filter): (&TriangleParticipants, &ContactFilter),
        particles: &Particles,
        (dt, within): (f32, bool),
        execution: ExecutionContext<'_>,
    ) {
        let speeds = Speeds::of(participants, particles);
        for place in 0..self.exceeded.len() {
            let i = self.exceeded[place] as usize;
            let row = participants.rows[i] as usize;
            self.margin[i] = self.margin_of(participants, i, speeds.of_row(particles, row) * dt);
            self.home[i] = particles.position[row].truncate() - self.common;
        }
        self.reach_of_all(participants, particles, within);
        let count = participants.triangles.len();
        let Self { exceeded, is_affected, affected, .. } = &mut *self;
        is_affected.clear();
        is_affected.resize(count + participants.loose.len(), false);
        affected.clear();
        for &member in &*exceeded {
            let loose =
                participants.loose.binary_search(&member).map(|place| (count + place) as u32);
            for &item in participants.triangles_of(member).iter().chain(&loose) {
                if !core::mem::replace(&mut is_affected[item as usize], true) {
                    affected.push(item);
                }
            }
        }
        for place in 0..self.exceeded.len() {
            self.enclose_member(participants, particles, self.exceeded[place] as usize, within);
        }
        let Self { affected, is_affected, own, of_triangles, boxes, search, pairs, .. } = self;
        for &item in &*affected {
            let item = item as usize;
            if item < count {
                (of_triangles[item], boxes[item]) = boxes_of(participants, item, own);
            } else {
                boxes[item] = own[participants.loose[item - count] as usize].corners();
            }
            search.put(item, &boxes[item]);
        }
        affected.sort_unstable();
        search.around((affected, is_affected), boxes, count, execution, pairs);
        self.find_candidates((participants, filter), particles, execution);
        self.merge();
    }

    /// Replaces the candidates of affected boxes by those found.
    fn merge(&mut self) {
        let Self { candidates, found, merged, is_affected, .. } = self;
        let is_affected = |candidate: &&TriangleCandidate| {
            candidate.pair.iter().any(|&item| is_affected[item as usize])
        };
        let order = |candidate: &TriangleCandidate| (candidate.edges, candidate.pair);
        merged.clear();
        let mut found = found.iter().peekable();
        for &kept in candidates.iter().filter(|candidate| !is_affected(candidate)) {
            while let Some(&one) = found.next_if(|one| order(one) < order(&kept)) {
                merged.push(one);
            }
            merged.push(kept);
        }
        merged.extend(found);
        core::mem::swap(candidates, merged);
    }

    /// Builds the list, at the beginning of a step of `dt` seconds, or `within` a substep that has been predicted.
    pub(super) fn rebuild(
        &mut self,
        (participants, filter): (&TriangleParticipants, &ContactFilter),
        particles: &Particles,
        (dt, within): (f32, bool),
        execution: ExecutionContext<'_>,
    ) {
        self.rules = Some(filter.changes());
        (self.common, self.common_at_start) = (Vec3::ZERO, Vec3::ZERO);
        self.measure(participants, particles, dt);
        self.enclose(participants, particles, within);
        let Self { boxes, pairs, search, .. } = self;
        // Most boxes near a triangle are of the same cloth: if that does not collide with itself, the search skips them as a group.
        let group = |of: u32| {
            let body = participants.body[of as usize];
            let alone = body != NO_BODY && !filter.body(body).with_itself;
            if alone { body } else { NO_GROUP }
        };
        let count = participants.triangles.len();
        let member = |i: usize| match participants.triangles.get(i) {
            Some(&[corner, ..]) => corner,
            None => participants.loose[i - count],
        };
        search.pairs(boxes, |i| group(member(i)), count, execution, pairs);
        self.find_candidates((participants, filter), particles, execution);
        core::mem::swap(&mut self.candidates, &mut self.found);
        self.adapt_margins();
    }

    /// Reduces the margins of the next list where members are crowded.
    fn adapt_margins(&mut self) {
        let crowding = self.candidates.len() as f32 / self.home.len() as f32;
        let share = 1.0 - self.reduction;
        let next = if crowding > CROWDED {
            // By half at the most: the volume, and not the width, decides.
            (share * (CROWDED / crowding).max(0.5)).max(LEAST_SHARE)
        } else if crowding < SPARSE {
            (share * GROWTH).min(1.0)
        } else {
            share
        };
        self.reduction = 1.0 - next;
    }

    /// Finds the candidates of all pairs of boxes.
    fn find_candidates(
        &mut self,
        (participants, filter): (&TriangleParticipants, &ContactFilter),
        particles: &Particles,
        execution: ExecutionContext<'_>,
    ) {
        let Self { of_chunks, found, ranges, ends, pinned, own, of_triangles, pairs, .. } = self;
        let (zero, mut far) = (first_origin(participants, particles), 0.0_f32);
        ends.clear();
        ends.extend(participants.rows.iter().zip(&*ranges).map(|(&row, range)| {
            let at = place(particles, row, zero);
            far = far.max(at.abs().max_element());
            at.extend(*range)
        }));
        let slack = 2.0 * ROUNDING * far;
        let search =
            CandidateSearch { participants, filter, pinned, own, of_triangles, ends, slack };
        let of_chunks =
            each_chunk(execution.workers, pairs, CHUNK, of_chunks, |_, pairs, found| {
                with(execution.instructions, FindCandidates { search, pairs, found });
            });
        found.clear();
        of_chunks.iter().for_each(|of_chunk| found.extend_from_slice(&of_chunk.corners));
        of_chunks.iter().for_each(|of_chunk| found.extend_from_slice(&of_chunk.edges));
    }

    /// Computes the margins.
    fn measure(&mut self, participants: &TriangleParticipants, particles: &Particles, dt: f32) {
        let Self { home, shortest, pinned, origin, .. } = self;
        home.clear();
        home.extend(
            participants.rows.iter().map(|&row| particles.position[row as usize].truncate()),
        );
        pinned.clear();
        pinned
            .extend(participants.rows.iter().map(|&row| particles.position[row as usize].w == 0.0));
        origin.clear();
        origin.extend(participants.rows.iter().map(|&row| particles.origin[row as usize]));
        // For members without edges, the mean over all edges of triangles. Squares at first.
        shortest.clear();
        shortest.resize(participants.rows.len(), f32::INFINITY);
        let (mut sum, mut count) = (0.0, 0.0);
        for (triangle, own) in participants.triangles.iter().zip(&participants.own) {
            for (place, [i, j]) in EDGES.into_iter().enumerate() {
                let ends = [triangle[i] as usize, triangle[j] as usize];
                let [a, b] = ends.map(|end| participants.rows[end] as usize);
                let square = particles.separation(a, b).length_squared();
                if own & (8 << place) != 0 && square.is_finite() {
                    sum += f64::from(square);
                    count += 1.0;
                    for end in ends {
                        shortest[end] = shortest[end].min(square);
                    }
                }
            }
        }
        let typical = if count > 0.0 { (sum / count) as f32 } else { 0.0 };
        for square in shortest {
            *square = if *square < f32::INFINITY { *square } else { typical }.sqrt();
        }
        let speeds = Speeds::of(participants, particles);
        let rows = participants.rows.iter().map(|&row| row as usize);
        let mut margin = core::mem::take(&mut self.margin);
        margin.clear();
        margin.extend(
            rows.enumerate().map(|(i, row)| {
                self.margin_of(participants, i, speeds.of_row(particles, row) * dt)
            }),
        );
        self.margin = margin;
    }

    /// The margin of a member that moves by `path` in a step, metres.
    fn margin_of(&self, participants: &TriangleParticipants, i: usize, path: f32) -> f32 {
        let (edge, radius) = (self.shortest[i], participants.radius[i]);
        let of = |share: [f32; 2]| share[0] * edge + share[1] * radius;
        let margin = (MARGIN_STEPS * path).max(of(MIN_MARGIN)).min(of(MAX_MARGIN));
        (1.0 - self.reduction) * margin + self.reserve[i]
    }

    /// Computes the boxes.
    fn enclose(
        &mut self,
        participants: &TriangleParticipants,
        particles: &Particles,
        within: bool,
    ) {
        let is_there = |row: &u32| particles.position[*row as usize].is_finite();
        let first =
            participants.rows.iter().copied().find(is_there).unwrap_or(participants.rows[0]);
        self.zero = particles.origin[first as usize];
        self.own.clear();
        self.own.resize(participants.rows.len(), Aabb::NOWHERE);
        for i in 0..participants.rows.len() {
            self.enclose_member(participants, particles, i, within);
        }
        self.reach_of_all(participants, particles, within);
        let Self { own, of_triangles, boxes, .. } = self;
        of_triangles.clear();
        boxes.clear();
        for triangle in 0..participants.triangles.len() {
            let (features, whole) = boxes_of(participants, triangle, own);
            of_triangles.push(features);
            boxes.push(whole);
        }
        boxes.extend(participants.loose.iter().map(|&i| own[i as usize].corners()));
    }

    /// Computes the box of a member, from where it was when the substep began to where it is.
    fn enclose_member(
        &mut self,
        participants: &TriangleParticipants,
        particles: &Particles,
        i: usize,
        within: bool,
    ) {
        let row = participants.rows[i] as usize;
        let shift = (particles.origin[row] - self.zero).as_dvec3();
        let place = |at: Vec3, common: Vec3| shift + at.as_dvec3() - common.as_dvec3();
        let to = place(particles.position[row].truncate(), self.common);
        let from =
            if within { place(particles.start[row].truncate(), self.common_at_start) } else { to };
        // A coordinate is rounded by at most 2⁻²⁴ of itself, and so is its sum with the rest.
        let rounding = to.abs().max(from.abs()).max_element() * 2e-7;
        let about = f64::from(self.margin[i] + participants.radius[i]) + rounding;
        let (low, high) = (from.min(to) - about, from.max(to) + about);
        // A member that is not finite has no box, and no candidates.
        let extent = low.abs().max(high.abs()).max_element();
        let good = from.is_finite() && to.is_finite() && extent < FAR;
        let corners = (low.as_vec3(), high.as_vec3());
        self.own[i] = if good { Aabb::new(corners) } else { Aabb::NOWHERE };
    }

    /// Computes how far each member can be from its position in the moving frame: at any time within its margin about its home, and `within` a substep at its
    /// start.
    fn reach_of_all(
        &mut self,
        participants: &TriangleParticipants,
        particles: &Particles,
        within: bool,
    ) {
        let Self { home, margin, ranges, common, common_at_start, .. } = self;
        ranges.clear();
        for ((&row, home), margin) in participants.rows.iter().zip(home).zip(&*margin) {
            let row = row as usize;
            let at = particles.position[row].truncate() - *common;
            let start = particles.start[row].truncate() - *common_at_start;
            let path = if within { (at - start).length() } else { 0.0 };
            ranges.push(((at - *home).length() + margin).max(path + margin) * LONGER);
        }
    }
}

/// Speeds relative to the mean motion.
struct Speeds {
    common: Vec3,
    mean: f32,
}

impl Speeds {
    fn of(participants: &TriangleParticipants, particles: &Particles) -> Self {
        let velocities = participants.rows.iter();
        let velocities = velocities.map(|&row| particles.velocity[row as usize].truncate());
        let common = mean(velocities.clone());
        let mean = mean(velocities.map(|own| Vec3::splat((own - common).length()))).x;
        Self { common, mean }
    }

    /// The speed of a row, or the mean speed if that is greater, m/s.
    fn of_row(&self, particles: &Particles, row: usize) -> f32 {
        (particles.velocity[row].truncate() - self.common).length().max(self.mean)
    }
}

/// The mean of some vectors, ignoring those that are not finite.
pub(super) fn mean(all: impl Iterator<Item = Vec3>) -> Vec3 {
    let (mut sum, mut count) = (DVec3::ZERO, 0.0);
    for one in all.filter(|one| one.is_finite()) {
        sum += one.as_dvec3();
        count += 1.0;
    }
    (sum / f64::max(count, 1.0)).as_vec3()
}
