//! Candidate search: the features (a corner and a triangle, an edge and an edge) of two overlapping boxes that can touch within their margins.
//!
//! Two triangles have up to fifteen pairs of features, and most of those cannot come near each other wherever their members move within their margins. They are
//! dropped as soon as there are eight, by the lower bounds of their distances, so that only the others are written.

use glam::{DVec3, Vec3, Vec4};

use super::super::distance::{of_segments, to_triangle};
use super::close_list::{CloseTest, WideCandidate};
use super::participants::{EDGES, TriangleParticipants, largest};
use crate::collide::filter::ContactFilter;
use crate::collide::manifold::{Aabb, EightBoxes};
use crate::lanes::{LANES, Lanes, SetLanes, Work};

/// A particle and a triangle, or two edges, that may touch.
#[derive(Clone, Copy, Debug)]
pub(super) struct TriangleCandidate {
    /// Members: the particle and the corners, or the ends of one edge and of the other.
    pub(super) four: [u32; 4],
    /// Upper limit of the contact distance, metres: their distance in the rest shape; infinite for two bodies.
    pub(super) most: f32,
    pub(super) edges: bool,
    /// The two overlapping boxes that it was found for, by which candidates of a kind are sorted.
    pub(super) pair: [u32; 2],
}

/// The candidates of corners, and those of edges, each sorted by the pair of boxes.
#[derive(Clone, Debug, Default)]
pub(super) struct FoundCandidates {
    pub(super) corners: Vec<TriangleCandidate>,
    pub(super) edges: Vec<TriangleCandidate>,
}

/// Lanes of a triangle's boxes: its [`EDGES`], a bit each; the whole triangle; and the first of its corners.
const ALL_EDGES: u32 = 7;
const WHOLE: usize = 3;
const CORNERS: usize = 4;

/// The boxes of the features that a triangle owns, and of the whole triangle, from those of the members; and the latter by itself. Corners without thickness
/// have none.
pub(super) fn boxes_of(
    participants: &TriangleParticipants,
    triangle: usize,
    own: &[Aabb],
) -> (EightBoxes, (Vec3, Vec3)) {
    let (members, owned) = (participants.triangles[triangle], participants.own[triangle]);
    let corners = members.map(|corner| own[corner as usize]);
    let edges = EDGES.map(|[i, j]| corners[i].and(&corners[j]));
    let whole = edges[0].and(&edges[1]).corners();
    let mut boxes = EightBoxes::EMPTY;
    boxes.set(WHOLE, &whole);
    for place in 0..3 {
        if owned & (8 << place) != 0 {
            boxes.set(place, &edges[place].corners());
        }
        if owned & (1 << place) != 0 && participants.radius[members[place] as usize] > 0.0 {
            boxes.set(CORNERS + place, &corners[place].corners());
        }
    }
    (boxes, whole)
}

/// What is searched.
#[derive(Clone, Copy)]
pub(super) struct CandidateSearch<'a> {
    pub(super) participants: &'a TriangleParticipants,
    pub(super) filter: &'a ContactFilter,
    /// Whether each member is pinned.
    pub(super) pinned: &'a [bool],
    /// Boxes of members; and those of the features of each triangle.
    pub(super) own: &'a [Aabb],
    pub(super) of_triangles: &'a [EightBoxes],
    /// Position of each member, metres from the first member's origin, and in `w` how far it can be from there. Greatest rounding error of a distance, metres.
    pub(super) ends: &'a [Vec4],
    pub(super) slack: f32,
}

/// Finds the candidates of pairs of overlapping boxes: of two triangles, or of a triangle and a particle.
pub(super) struct FindCandidates<'a> {
    pub(super) search: CandidateSearch<'a>,
    pub(super) pairs: &'a [[u32; 2]],
    pub(super) found: &'a mut FoundCandidates,
}

impl Work for FindCandidates<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { search, pairs, found: FoundCandidates { corners, edges } } = self;
        corners.clear();
        edges.clear();
        let (mut of_corners, mut of_edges) = (Untested::new(false), Untested::new(true));
        // Whether the last two bodies of triangles may touch.
        let mut cached = None;
        for &pair in pairs {
            let (count, [i, j]) = (search.of_triangles.len(), [pair[0] as usize, pair[1] as usize]);
            let Some(&one) = search.participants.triangles.get(i) else { continue };
            let of_one = &search.of_triangles[i];
            if j >= count {
                let particle = search.participants.loose[j - count];
                let (least, most) = search.own[particle as usize].corners();
                let near = of_one.overlapping::<L>([least.to_array(), most.to_array()]);
                if near & (1 << WHOLE) != 0
                    && !one.contains(&particle)
                    && search.participants.may_touch(search.filter, particle, one[0])
                {
                    of_corners.push::<L>(corner_four(particle, one), pair, &search, corners);
                }
                continue;
            }
            let other = search.participants.triangles[j];
            if !search.may_touch([one[0], other[0]], &mut cached) {
                continue;
            }
            let of_other = &search.of_triangles[j];
            let near_one = of_one.overlapping::<L>(of_other.lane(WHOLE));
            let near_other = of_other.overlapping::<L>(of_one.lane(WHOLE));
            for (near, of, against) in [(near_one, one, other), (near_other, other, one)] {
                for place in SetLanes(near >> CORNERS) {
                    if !against.contains(&of[place]) {
                        of_corners.push::<L>(
                            corner_four(of[place], against),
                            pair,
                            &search,
                            corners,
                        );
                    }
                }
            }
            let (near_one, near_other) = (near_one & ALL_EDGES, near_other & ALL_EDGES);
            if near_other == 0 {
                continue;
            }
            for place in SetLanes(near_one) {
                let [from, to] = EDGES[place];
                let (a, b) = (one[from], one[to]);
                let near = of_other.overlapping::<L>(of_one.lane(place)) & near_other;
                for place in SetLanes(near) {
                    let [from, to] = EDGES[place];
                    let (c, d) = (other[from], other[to]);
                    if a != c && a != d && b != c && b != d {
                        // The edge of lower numbers first, whichever triangle owns it.
                        let four = if [a, b] < [c, d] { [a, b, c, d] } else { [c, d, a, b] };
                        of_edges.push::<L>(four, pair, &search, edges);
                    }
                }
            }
        }
        of_corners.test::<L>(&search, corners);
        of_edges.test::<L>(&search, edges);
    }
}

impl CandidateSearch<'_> {
    /// Whether two bodies may touch, each given by a corner. Rows matter only for bodies of a single particle, which have no triangles.
    #[inline(always)]
    fn may_touch(&self, [a, b]: [u32; 2], cached: &mut Option<([u32; 2], bool)>) -> bool {
        let of_corner = &self.participants.body;
        let bodies = [of_corner[a as usize], of_corner[b as usize]];
        let may = match *cached {
            Some((last, may)) if last == bodies => may,
            _ => self.participants.may_touch(self.filter, a, b),
        };
        *cached = Some((bodies, may));
        may
    }

    /// Whether all members are pinned, so that there is nothing to correct.
    #[inline(always)]
    fn stays(&self, four: [u32; 4]) -> bool {
        let [i, j, k, l] = four;
        let pinned = |i: u32| self.pinned[i as usize];
        pinned(i) && pinned(j) && pinned(k) && pinned(l)
    }
}

#[inline(always)]
fn corner_four(particle: u32, [a, b, c]: [u32; 3]) -> [u32; 4] {
    [particle, a, b, c]
}

/// Up to eight pairs of features of a kind that have not been tested, and the pairs of boxes that they were found for.
struct Untested {
    wide: WideCandidate,
    pairs: [[u32; 2]; LANES],
}

impl Untested {
    fn new(edges: bool) -> Self {
        Self { wide: WideCandidate::new(edges), pairs: [[0; 2]; LANES] }
    }

    /// Adds a pair of features, and tests all when there are eight.
    #[inline(always)]
    fn push<L: Lanes>(
        &mut self,
        four: [u32; 4],
        pair: [u32; 2],
        search: &CandidateSearch<'_>,
        found: &mut Vec<TriangleCandidate>,
    ) {
        self.pairs[self.wide.count()] = pair;
        self.wide.put(four, largest(&search.participants.radius, four, self.wide.edges()));
        if self.wide.count() == LANES {
            self.test::<L>(search, found);
        }
    }

    /// Adds those that can come into contact within the ranges of their members to the list.
    #[inline(always)]
    fn test<L: Lanes>(&mut self, search: &CandidateSearch<'_>, found: &mut Vec<TriangleCandidate>) {
        let Self { wide, pairs } = self;
        let edges = wide.edges();
        let test = CloseTest { wide, ends: search.ends, slack: search.slack, both: true };
        for lane in SetLanes(test.run::<L>()) {
            let (four, largest) = wide.lane(lane);
            if search.stays(four) {
                continue;
            }
            let mut most = f32::INFINITY;
            if let Some(places) = search.participants.rest_of(four) {
                most = distance(places, edges) as f32;
            }
            // Features at the same place in the rest shape (a seam) never touch, nor do those without thickness.
            if largest.min(most) > 0.0 {
                found.push(TriangleCandidate { four, most, edges, pair: pairs[lane] });
            }
        }
        wide.clear();
    }
}

/// The distance of the two features, metres.
#[inline(always)]
pub(super) fn distance([p, a, b, c]: [DVec3; 4], edges: bool) -> f64 {
    if edges {
        return of_segments([p, a], [b, c]);
    }
    let [i, j, k] = to_triangle(p, [a, b, c]);
    (p - (a * i + b * j + c * k)).length()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collide::filter::ContactFilter;
    use crate::lanes::{InstructionSet, with};
    use crate::particles::NO_BODY;
    use crate::test_random::Random;

    /// Tests some candidates, as those of pairs of boxes are.
    struct TestAll<'a>(
        CandidateSearch<'a>,
        &'a [TriangleCandidate],
        &'a mut Vec<TriangleCandidate>,
    );

    impl Work for TestAll<'_> {
        type Output = ();

        #[inline(always)]
        fn run<L: Lanes>(self) {
            let Self(search, all, kept) = self;
            let mut untested = Untested::new(all[0].edges);
            for one in all {
                untested.push::<L>(one.four, one.pair, &search, kept);
            }
            untested.test::<L>(&search, kept);
        }
    }

    #[test]
    fn candidates_that_are_not_kept_cannot_come_near() {
        const COUNT: usize = 60;
        let mut random = Random::new(5);
        let mut participants = TriangleParticipants::default();
        let mut ends = Vec::new();
        for row in 0..COUNT as u32 {
            ends.push((random.vector() * 0.4).extend(0.0));
            participants.rows.push(row);
            participants.body.push(NO_BODY);
            participants.radius.push(0.02 + 0.01 * random.number());
        }
        ends.iter_mut().for_each(|end| end.w = 0.03 + 0.03 * random.number());
        let all: Vec<_> = (0..4000)
            .map(|number| TriangleCandidate {
                four: [0; 4].map(|_| random.below(COUNT) as u32),
                most: f32::INFINITY,
                edges: number >= 1900,
                pair: [number, 0],
            })
            .collect();
        let search = CandidateSearch {
            participants: &participants,
            filter: &ContactFilter::default(),
            pinned: &[false; COUNT],
            own: &[],
            of_triangles: &[],
            ends: &ends,
            slack: 1e-6,
        };
        let mut kept = Vec::new();
        let (corners, edges) = all.split_at(1900);
        for these in [corners, edges] {
            with(InstructionSet::best(), TestAll(search, these, &mut kept));
        }
        let taken: Vec<u32> = kept.iter().map(|candidate| candidate.pair[0]).collect();
        let (mut left, mut near) = (taken.iter().peekable(), 0);
        for (number, candidate) in (0..).zip(&all) {
            if left.next_if(|next| **next == number).is_some() {
                continue;
            }
            let reach = largest(&participants.radius, candidate.four, candidate.edges);
            for _ in 0..20 {
                let to = candidate.four.map(|i| {
                    let end = ends[i as usize];
                    let by = random.vector().normalize_or_zero() * end.w;
                    (end.truncate() + by).as_dvec3()
                });
                let least = distance(to, candidate.edges);
                assert!(least >= f64::from(reach), "{candidate:?}");
                near += u32::from(least < 3.0 * f64::from(reach));
            }
        }
        assert!(left.next().is_none(), "in their order");
        assert!((200..3800).contains(&taken.len()) && near > 10, "{} taken, {near}", taken.len());
    }
}
