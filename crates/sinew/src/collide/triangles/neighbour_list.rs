//! Who may come to touch whom, found by boxes; and how far each may go until it must be looked for again.
//!
//! Each particle has a margin, and a box about it: from where it was to where it is (if a substep has been predicted), and its radius and its margin
//! around that. As long as everybody is within its margin, beside what all do alike, whoever touches was found. A triangle's box is that about those
//! of its corners. What is found is in the order of the triangles that stand for it, and so in that of the rows, whatever the margins are.

use glam::{DVec3, Vec3};

use super::super::distance::{of_segments, to_triangle};
use super::participants::{EDGES, TriangleParticipants, largest};
use crate::collide::filter::ContactFilter;
use crate::collide::manifold::{Broad, NO_GROUP};
use crate::kept::Kept;
use crate::particles::{NO_BODY, Particles};

/// A particle and a triangle, or two edges, that may come to touch.
#[derive(Clone, Copy, Debug)]
pub(super) struct TriangleCandidate {
    /// Members: the particle and the corners, or the ends of the one and of the other edge.
    pub(super) four: [u32; 4],
    /// The distance that they may have in any case, metres: what they have in the rest shape, infinite where they are of two bodies.
    pub(super) most: f32,
    pub(super) edges: bool,
}

/// What was found, and where everybody was. Scratch.
#[derive(Clone, Debug, Default)]
pub(super) struct TriangleNeighbours {
    /// Particles and triangles first.
    pub(super) candidates: Vec<TriangleCandidate>,
    /// Those of edges, before they are put behind the others.
    edges: Vec<TriangleCandidate>,
    /// Where each was, metres from its own origin.
    home: Vec<Vec3>,
    /// How far from there along each axis it stays within what was found, metres.
    margin: Vec<f32>,
    /// Whether nothing moves it.
    pinned: Vec<bool>,
    /// The box about each; about triangles and loose particles.
    own: Vec<(Vec3, Vec3)>,
    boxes: Vec<(Vec3, Vec3)>,
    /// Of each box the body that it is of, if that does not touch itself.
    groups: Vec<u32>,
    pairs: Vec<[u32; 2]>,
    broad: Kept<Broad>,
}

/// The margin is what a particle covers in half a step, beside what all do, at the speed that it has or that all have in the mean (because they may hit
/// it), within these bounds: shares of its shortest edge and of its radius.
///
/// A wider one finds more that is never close, a narrower one is outrun sooner. Two sheets of 64 × 64 that fall on each other took 75, 74 and 82 ms a tick with a
/// quarter, half and all of a step.
const SHARE: f32 = 0.5;
const LEAST: [f32; 2] = [0.02, 0.25];
const MOST: [f32; 2] = [0.5, 1.0];

/// Further out, squares are no `f32`, metres.
const FAR: f64 = 1e15;

impl TriangleNeighbours {
    pub(super) fn clear(&mut self) {
        self.candidates.clear();
    }

    /// Looks where everybody is, and who is near whom; at the beginning of a step of `dt` seconds, or `within` a substep that has been predicted.
    pub(super) fn rebuild(
        &mut self,
        (participants, filter): (&TriangleParticipants, &ContactFilter),
        particles: &Particles,
        dt: f32,
        within: bool,
    ) {
        self.measure(participants, particles, dt);
        self.enclose(participants, particles, within);
        let Self { boxes, groups, pairs, broad, .. } = self;
        // Most that are near a triangle are of the cloth that it is of.
        let group = |of: u32| {
            let body = participants.body[of as usize];
            let alone = body != NO_BODY && !filter.body(body).with_itself;
            if alone { body } else { NO_GROUP }
        };
        groups.clear();
        groups.extend(participants.triangles.iter().map(|&[corner, ..]| group(corner)));
        groups.extend(participants.loose.iter().map(|&one| group(one)));
        broad.0.pairs_of_groups(boxes, groups, pairs);
        let pairs = core::mem::take(&mut self.pairs);
        self.candidates.clear();
        self.edges.clear();
        for &[i, j] in &pairs {
            self.consider((participants, filter), i as usize, j as usize);
        }
        self.pairs = pairs;
        self.candidates.append(&mut self.edges);
    }

    /// Whether somebody has gone further than its margin, beside what all do alike: no displacement is within all margins of each one's.
    pub(super) fn is_skin_exceeded(
        &self,
        participants: &TriangleParticipants,
        particles: &Particles,
    ) -> bool {
        let (mut low, mut high) = (Vec3::NEG_INFINITY, Vec3::INFINITY);
        let greater = |a: f32, b: f32| if b > a { b } else { a };
        let less = |a: f32, b: f32| if b < a { b } else { a };
        for ((&row, home), &margin) in participants.rows.iter().zip(&self.home).zip(&self.margin) {
            let way = particles.position[row as usize].truncate() - *home;
            let (least, most) = (way - margin, way + margin);
            // What is no number does not count.
            low = Vec3::new(
                greater(low.x, least.x),
                greater(low.y, least.y),
                greater(low.z, least.z),
            );
            high = Vec3::new(less(high.x, most.x), less(high.y, most.y), less(high.z, most.z));
        }
        !low.cmple(high).all()
    }

    /// Finds the margins.
    fn measure(&mut self, participants: &TriangleParticipants, particles: &Particles, dt: f32) {
        let Self { home, margin, pinned, .. } = self;
        home.clear();
        pinned.clear();
        pinned
            .extend(participants.rows.iter().map(|&row| particles.position[row as usize].w == 0.0));
        let place = |&row: &u32| particles.position[row as usize].truncate();
        home.extend(participants.rows.iter().map(place));
        // The square of the shortest edge of each; of particles that have none, the mean of all edges of triangles.
        margin.clear();
        margin.resize(participants.rows.len(), f32::INFINITY);
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
                        margin[end] = margin[end].min(square);
                    }
                }
            }
        }
        let typical = if count > 0.0 { (sum / count) as f32 } else { 0.0 };
        let velocity =
            |i: usize| particles.velocity[participants.rows[i] as usize].truncate().as_dvec3();
        let all = mean(participants, velocity);
        let speed = |i: usize| (velocity(i) - all).length();
        let usual = mean(participants, |i| DVec3::splat(speed(i))).x;
        for (i, margin) in margin.iter_mut().enumerate() {
            let edge = if *margin < f32::INFINITY { *margin } else { typical }.sqrt();
            let of = |share: [f32; 2]| share[0] * edge + share[1] * participants.radius[i];
            *margin = (SHARE * speed(i).max(usual) as f32 * dt).max(of(LEAST)).min(of(MOST));
        }
    }

    /// Makes the boxes.
    fn enclose(
        &mut self,
        participants: &TriangleParticipants,
        particles: &Particles,
        within: bool,
    ) {
        let Self { margin, own, boxes, .. } = self;
        let is_there = |row: &u32| particles.position[*row as usize].is_finite();
        let first =
            participants.rows.iter().copied().find(is_there).unwrap_or(participants.rows[0]);
        let zero = particles.origin[first as usize];
        let path = |i: usize| {
            let row = participants.rows[i] as usize;
            (particles.position[row] - particles.start[row]).truncate().as_dvec3()
        };
        own.clear();
        for (i, &row) in participants.rows.iter().enumerate() {
            let row = row as usize;
            let shift = (particles.origin[row] - zero).as_dvec3();
            let to = shift + particles.position[row].truncate().as_dvec3();
            let back = if within { path(i) } else { DVec3::ZERO };
            let from = to - back;
            // A coordinate is rounded by 2⁻²⁴ of itself at most, and then its sum with the rest.
            let rounding = to.abs().max(from.abs()).max_element() * 2e-7;
            let about = f64::from(margin[i] + participants.radius[i]) + rounding;
            let (low, high) = (from.min(to) - about, from.max(to) + about);
            // One that is nowhere is in no box, and not near anybody.
            let extent = low.abs().max(high.abs()).max_element();
            let good = from.is_finite() && to.is_finite() && extent < FAR;
            let nowhere = (Vec3::NAN, Vec3::NAN);
            own.push(if good { (low.as_vec3(), high.as_vec3()) } else { nowhere });
        }
        boxes.clear();
        boxes.extend(participants.triangles.iter().map(|corners| {
            let [a, b, c] = corners.map(|corner| own[corner as usize]);
            both(both(a, b), c)
        }));
        boxes.extend(participants.loose.iter().map(|&i| own[i as usize]));
    }

    /// Takes what two boxes stand for: two triangles, or a triangle and a particle.
    fn consider(
        &mut self,
        (participants, filter): (&TriangleParticipants, &ContactFilter),
        i: usize,
        j: usize,
    ) {
        let count = participants.triangles.len();
        let Some(&one) = participants.triangles.get(i) else { return };
        if j >= count {
            let particle = participants.loose[j - count];
            if participants.may_touch(filter, particle, one[0]) {
                self.consider_corner(participants, particle, i);
            }
            return;
        }
        let other = participants.triangles[j];
        if !participants.may_touch(filter, one[0], other[0]) {
            return;
        }
        for (corners, which, against) in [(one, i, j), (other, j, i)] {
            for (place, &corner) in corners.iter().enumerate() {
                let owned = participants.own[which] & (1 << place) != 0;
                if owned && participants.radius[corner as usize] > 0.0 {
                    self.consider_corner(participants, corner, against);
                }
            }
        }
        for (place, [a, b]) in EDGES.into_iter().enumerate() {
            if participants.own[i] & (8 << place) == 0 {
                continue;
            }
            for (place, [c, d]) in EDGES.into_iter().enumerate() {
                if participants.own[j] & (8 << place) != 0 {
                    self.consider_edges(participants, [one[a], one[b], other[c], other[d]]);
                }
            }
        }
    }

    fn consider_corner(
        &mut self,
        participants: &TriangleParticipants,
        particle: u32,
        triangle: usize,
    ) {
        let corners = participants.triangles[triangle];
        let [a, b, c] = corners;
        if corners.contains(&particle)
            || !overlap(self.own[particle as usize], self.boxes[triangle])
        {
            return;
        }
        let candidate = self.candidate(participants, [particle, a, b, c], false);
        self.candidates.extend(candidate);
    }

    fn consider_edges(&mut self, participants: &TriangleParticipants, four: [u32; 4]) {
        let [a, b, c, d] = four;
        if a == c || a == d || b == c || b == d {
            return;
        }
        let [one, end, other, last] = four.map(|i| self.own[i as usize]);
        if !overlap(both(one, end), both(other, last)) {
            return;
        }
        // The lower one first, whichever triangle stands for it.
        let four = if [a, b] < [c, d] { four } else { [c, d, a, b] };
        let candidate = self.candidate(participants, four, true);
        self.edges.extend(candidate);
    }

    /// The candidate, if the two may touch.
    #[inline(always)]
    fn candidate(
        &self,
        participants: &TriangleParticipants,
        four: [u32; 4],
        edges: bool,
    ) -> Option<TriangleCandidate> {
        let mut most = f64::INFINITY;
        if let Some(places) = participants.rest_of(four) {
            most = distance(places, edges);
        }
        let pinned = |i: u32| self.pinned[i as usize];
        let [i, j, k, l] = four;
        // Two that are at one place in the rest shape (a seam) never touch, and neither do any without thickness; nor is anything to be done where
        // nothing moves.
        let reach = f64::from(largest(&participants.radius, four, edges)).min(most);
        let stays = pinned(i) && pinned(j) && pinned(k) && pinned(l);
        (reach > 0.0 && !stays).then_some(TriangleCandidate { four, most: most as f32, edges })
    }
}

/// The mean of something that all members have; what is no number does not count.
pub(super) fn mean(participants: &TriangleParticipants, of: impl Fn(usize) -> DVec3) -> DVec3 {
    let (mut sum, mut count) = (DVec3::ZERO, 0.0);
    for one in (0..participants.rows.len()).map(of).filter(|one| one.is_finite()) {
        sum += one;
        count += 1.0;
    }
    if count > 0.0 { sum / count } else { DVec3::ZERO }
}

/// How far the two are apart, metres.
#[inline(always)]
fn distance([p, a, b, c]: [DVec3; 4], edges: bool) -> f64 {
    if edges {
        return of_segments([p, a], [b, c]);
    }
    let [i, j, k] = to_triangle(p, [a, b, c]);
    (p - (a * i + b * j + c * k)).length()
}

#[inline(always)]
fn both(a: (Vec3, Vec3), b: (Vec3, Vec3)) -> (Vec3, Vec3) {
    // Not `min` and `max`, which pass over what is no number.
    let nowhere = a.0.is_nan() || b.0.is_nan();
    if nowhere { (Vec3::NAN, Vec3::NAN) } else { (a.0.min(b.0), a.1.max(b.1)) }
}

#[inline(always)]
fn overlap(a: (Vec3, Vec3), b: (Vec3, Vec3)) -> bool {
    a.0.cmple(b.1).all() && b.0.cmple(a.1).all()
}
