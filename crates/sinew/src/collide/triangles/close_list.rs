//! Selects the candidates that are close: the two may touch or pass through each other in this substep.
//!
//! The neighbour list lasts for some steps and has some hundred candidates for each contact. Most could only touch if their members moved far within their
//! margins along the diagonal of a box; those that cannot, wherever their members move within the margins, are dropped when the list is built. For the others a
//! lower bound of the distance is computed in each substep, eight at a time ([`least_distance`](super::least_distance)), and the close ones are packed into
//! blocks of eight again for the sweeps. None of this decides a contact: close candidates are tested again in double precision, and an additional candidate
//! changes no result.
//!
//! Contacts displace members, so that other candidates become close. The list includes those too, as long as no member is displaced by more than its allowance,
//! which is somewhat more than its displacement in the substep before; beyond that the list is rebuilt.

use glam::{DVec3, Vec3, Vec4};

use super::least_distance::{of_edges, to_triangle};
use super::neighbour_list::{LONGER, TriangleCandidate, mean};
use super::participants::{TriangleParticipants, largest};
use crate::lanes::{InstructionSet, LANES, Lanes, SetLanes, Vector, Work, with};
use crate::particles::Particles;

/// Scratch. What outlives a substep only saves tests and changes no result.
#[derive(Clone, Debug, Default)]
pub(super) struct CloseList {
    /// Instruction set of the kernels; all give the same bits.
    pub(super) instructions: InstructionSet,
    /// The candidates of the neighbour list, in order: those of corners first.
    blocks: Vec<CandidateBlock>,
    /// `ends`: position of each member, metres from the first member's origin, and in `w` its displacement in this substep relative to the mean displacement of
    /// all members. `starts`: that position less that displacement.
    ends: Vec<Vec4>,
    starts: Vec<Vec3>,
    /// Greatest rounding error of these positions, metres.
    rounding: f32,
    /// The close candidates, in order.
    close: Vec<CandidateBlock>,
    /// `ends` at the time of listing; `w` is the displacement in the substep plus twice the allowance.
    listed: Vec<Vec4>,
    /// Distance by which contacts may displace each member before other candidates become close, metres; and the distance by which they have displaced it.
    allowances: Vec<f32>,
    displacements: Vec<f32>,
    /// Allowance of every member, metres.
    base: f32,
    /// Greatest displacement by contacts in this substep, metres, and whether one exceeded its allowance.
    max_displacement: f32,
    allowance_exceeded: bool,
}

/// Up to eight candidates. Empty lanes repeat the first one.
#[derive(Clone, Copy, Debug)]
struct WideCandidate {
    members: [[u32; LANES]; 4],
    /// Greatest contact distance of each candidate, metres.
    reach: [f32; LANES],
    count: u32,
    edges: bool,
}

/// Up to eight candidates and their numbers, ascending.
#[derive(Clone, Copy, Debug)]
struct CandidateBlock {
    wide: WideCandidate,
    numbers: [u32; LANES],
}

/// Factor from a member's displacement by contacts in the last substep to its allowance: in most cases the next one is not larger.
const ALLOWANCE_FACTOR: f32 = 1.5;

/// Share of the greatest displacement beyond an allowance that becomes the allowance of members that contacts did not displace in the last substep, and the
/// factor by which it decays in each substep.
const EXCESS_SHARE: f32 = 0.1;
const ALLOWANCE_DECAY: f32 = 0.9;

impl CloseList {
    /// Drops the candidates that cannot come into contact as long as each member moves no further from its position than its `range`, metres.
    pub(super) fn prune(
        &mut self,
        candidates: &mut Vec<TriangleCandidate>,
        participants: &TriangleParticipants,
        particles: &Particles,
        ranges: &[f32],
    ) {
        let Self { ends, instructions, .. } = self;
        let (zero, mut far) = (first_origin(participants, particles), 0.0_f32);
        ends.clear();
        ends.extend(participants.rows.iter().zip(ranges).map(|(&row, range)| {
            let at = place(particles, row, zero);
            far = far.max(at.abs().max_element());
            at.extend(*range)
        }));
        let slack = 2.0 * ROUNDING * far;
        let (mut number, mut count) = (0, 0);
        while number < candidates.len() {
            let wide = WideCandidate::of_some(&candidates[number..], participants);
            let test = CloseTest { wide: &wide, ends, slack, both: true };
            for lane in SetLanes(with(*instructions, test)) {
                candidates[count] = candidates[number + lane];
                count += 1;
            }
            number += wide.count as usize;
        }
        candidates.truncate(count);
    }

    /// Takes the candidates of the list, those of corners first.
    pub(super) fn pack(
        &mut self,
        candidates: &[TriangleCandidate],
        participants: &TriangleParticipants,
    ) {
        self.blocks.clear();
        let mut number = 0;
        while number < candidates.len() {
            let wide = WideCandidate::of_some(&candidates[number..], participants);
            let numbers = core::array::from_fn(|lane| (number + lane) as u32);
            number += wide.count as usize;
            self.blocks.push(CandidateBlock { wide, numbers });
        }
    }

    /// Lists the close candidates of a predicted substep.
    pub(super) fn begin_substep(
        &mut self,
        participants: &TriangleParticipants,
        particles: &Particles,
    ) {
        let Self { ends, starts, rounding, .. } = self;
        let way = |row: usize| (particles.position[row] - particles.start[row]).truncate();
        let common = mean(participants.rows.iter().map(|&row| way(row as usize)));
        let zero = first_origin(participants, particles);
        let mut far = 0.0_f32;
        ends.clear();
        starts.clear();
        for &row in &participants.rows {
            let at = place(particles, row, zero);
            let row = row as usize;
            let own = way(row) - common;
            starts.push(at - own);
            let own = own.length() * LONGER;
            // NaN is ignored: such a member touches nothing.
            far = far.max(at.abs().max_element());
            ends.push(at.extend(own));
        }
        *rounding = ROUNDING * far;
        self.displacements.resize(self.ends.len(), 0.0);
        self.base *= ALLOWANCE_DECAY;
        self.allowances.clear();
        self.allowances
            .extend(self.displacements.iter().map(|by| self.base + ALLOWANCE_FACTOR * by));
        self.displacements.fill(0.0);
        (self.max_displacement, self.allowance_exceeded) = (0.0, false);
        self.list();
    }

    /// Lists the close candidates again if a member was displaced by more than its allowance. Returns whether it was so.
    pub(super) fn update(&mut self) -> bool {
        let exceeded = core::mem::take(&mut self.allowance_exceeded);
        if exceeded {
            self.base = (2.0 * self.base).max(EXCESS_SHARE * self.max_displacement);
            for (allowance, &by) in self.allowances.iter_mut().zip(&self.displacements) {
                let wanted = if by > *allowance { 2.0 * by } else { self.base };
                *allowance = allowance.max(wanted);
            }
            self.list();
        }
        exceeded
    }

    fn list(&mut self) {
        let Self { blocks, ends, rounding, close, allowances, listed, instructions, .. } = self;
        listed.clear();
        let each = ends.iter().zip(&*allowances);
        listed.extend(each.map(|(end, allowance)| end.truncate().extend(end.w + 2.0 * allowance)));
        close.clear();
        with(*instructions, ListClose { blocks, listed, slack: 2.0 * *rounding, close });
    }

    /// The candidates of a listed block that are close at the members' current positions, a bit each, and whose number is at least `from`; `None` beyond the
    /// last block.
    pub(super) fn close_lanes(&self, place: usize, from: u32) -> Option<u32> {
        let CandidateBlock { wide, numbers } = self.close.get(place)?;
        let slack = 2.0 * self.rounding;
        let before = numbers[..wide.count as usize].partition_point(|number| *number < from);
        let test = CloseTest { wide, ends: &self.ends, slack, both: false };
        Some(with(self.instructions, test) & (u32::MAX << before))
    }

    /// The number of the candidate in a lane of a block.
    pub(super) fn number(&self, place: usize, lane: u32) -> u32 {
        self.close[place].numbers[lane as usize]
    }

    /// The first block with a candidate of at least this number.
    pub(super) fn place_of(&self, number: u32) -> usize {
        let last = |block: &CandidateBlock| block.numbers[block.wide.count as usize - 1];
        self.close.partition_point(|block| last(block) < number)
    }

    /// Records that a contact displaced a member, by metres.
    pub(super) fn record_displacement(&mut self, i: usize, by: DVec3) {
        let end = self.ends[i].truncate() + by.as_vec3();
        self.ends[i] = end.extend((end - self.starts[i]).length() * LONGER);
        let displacement = (end - self.listed[i].truncate()).length() * LONGER;
        self.displacements[i] = self.displacements[i].max(displacement);
        self.max_displacement = self.max_displacement.max(displacement);
        self.allowance_exceeded |= displacement > self.allowances[i];
    }
}

/// Position of a row, metres from `zero`.
fn place(particles: &Particles, row: u32, zero: Vec3) -> Vec3 {
    let row = row as usize;
    (particles.origin[row] - zero) + particles.position[row].truncate()
}

fn first_origin(participants: &TriangleParticipants, particles: &Particles) -> Vec3 {
    participants.rows.first().map_or(Vec3::ZERO, |&row| particles.origin[row as usize])
}

/// Greatest rounding error of a position, as a share of its largest coordinate: of the position itself and of several displacements.
const ROUNDING: f32 = 2e-6;

/// Greatest contact distance of a candidate, metres.
fn reach_of(candidate: &TriangleCandidate, participants: &TriangleParticipants) -> f32 {
    largest(&participants.radius, candidate.four, candidate.edges).min(candidate.most)
}

impl WideCandidate {
    /// A block with one candidate.
    fn of(four: [u32; 4], reach: f32, edges: bool) -> Self {
        let members = four.map(|member| [member; LANES]);
        let mut wide = Self { members, reach: [0.0; LANES], count: 0, edges };
        wide.put(four, reach);
        wide
    }

    /// The first of some candidates, and those of its kind that follow it.
    #[inline(always)]
    fn of_some(candidates: &[TriangleCandidate], participants: &TriangleParticipants) -> Self {
        let first = &candidates[0];
        let mut wide = Self::of(first.four, reach_of(first, participants), first.edges);
        for other in candidates[1..].iter().take(LANES - 1) {
            if other.edges != first.edges {
                break;
            }
            wide.put(other.four, reach_of(other, participants));
        }
        wide
    }

    /// Whether there is a free lane for another candidate of this kind.
    #[inline(always)]
    fn takes(&self, edges: bool) -> bool {
        self.edges == edges && self.count < LANES as u32
    }

    /// Adds a candidate.
    #[inline(always)]
    fn put(&mut self, four: [u32; 4], reach: f32) {
        let place = self.count as usize;
        for (members, member) in self.members.iter_mut().zip(four) {
            members[place] = member;
        }
        self.reach[place] = reach;
        self.count += 1;
    }

    /// The candidate in a lane, and its contact distance.
    #[inline(always)]
    fn lane(&self, lane: usize) -> ([u32; 4], f32) {
        let [i, j, k, l] = &self.members;
        ([i[lane], j[lane], k[lane], l[lane]], self.reach[lane])
    }

    /// The occupied lanes, a bit each.
    fn filled(&self) -> u32 {
        (1 << self.count) - 1
    }

    /// Lower bounds of the distances, and the greatest distance that the two can have approached in the substep: the sum of their displacements.
    #[inline(always)]
    fn least<L: Lanes>(&self, ends: &[Vec4]) -> [L; 2] {
        let [p, a, b, c] = &self.members;
        let (p, of_p) = Vector::of(L::rows(ends, p));
        let (a, of_a) = Vector::of(L::rows(ends, a));
        let (b, of_b) = Vector::of(L::rows(ends, b));
        let (c, of_c) = Vector::of(L::rows(ends, c));
        if self.edges {
            [of_edges([p, a, b, c]), of_p.max(of_a) + of_b.max(of_c)]
        } else {
            [to_triangle([p, a, b, c]), of_p + of_a.max(of_b).max(of_c)]
        }
    }
}

/// Lists close candidates: those nearer than their contact distance plus their displacements in the substep and the allowances.
struct ListClose<'a> {
    blocks: &'a [CandidateBlock],
    listed: &'a [Vec4],
    slack: f32,
    close: &'a mut Vec<CandidateBlock>,
}

impl Work for ListClose<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { blocks, listed, slack, close } = self;
        for CandidateBlock { wide, numbers } in blocks {
            let near = CloseTest { wide, ends: listed, slack, both: true }.run::<L>();
            push_lanes(close, wide, near, |lane| numbers[lane]);
        }
    }
}

/// Appends the candidates of some lanes to blocks, with their numbers.
#[inline(always)]
fn push_lanes(
    blocks: &mut Vec<CandidateBlock>,
    wide: &WideCandidate,
    lanes: u32,
    number: impl Fn(usize) -> u32,
) {
    for lane in SetLanes(lanes) {
        let ((four, reach), number) = (wide.lane(lane), number(lane));
        match blocks.last_mut() {
            Some(last) if last.wide.takes(wide.edges) => {
                last.numbers[last.wide.count as usize] = number;
                last.wide.put(four, reach);
            }
            _ => blocks.push(CandidateBlock {
                wide: WideCandidate::of(four, reach, wide.edges),
                numbers: [number; LANES],
            }),
        }
    }
}

/// Which of eight candidates are close, a bit each: nearer than their contact distance, or than their displacements (so that they may have passed through each
/// other); with `both`, nearer than the sum of the two.
struct CloseTest<'a> {
    wide: &'a WideCandidate,
    ends: &'a [Vec4],
    slack: f32,
    both: bool,
}

impl Work for CloseTest<'_> {
    type Output = u32;

    #[inline(always)]
    fn run<L: Lanes>(self) -> u32 {
        let [least, ways] = self.wide.least::<L>(self.ends);
        let reach = L::load(&self.wide.reach);
        let near = if self.both { reach + ways } else { reach.max(ways) };
        let far = (near + L::splat(self.slack)).lt(least);
        !far.bits() & self.wide.filled()
    }
}

#[cfg(test)]
mod tests {
    use super::super::crossing::Four;
    use super::*;
    use crate::collide::distance;
    use crate::particles::ParticleSeed;
    use crate::test_random::Random;

    /// The exact distance of the two at their current positions.
    fn exact(four: &Four) -> f64 {
        let [p, a, b, c] = four.to;
        if four.edges {
            return distance::of_segments([p, a], [b, c]);
        }
        let [i, j, k] = distance::to_triangle(p, [a, b, c]);
        (p - (a * i + b * j + c * k)).length()
    }

    #[test]
    fn no_contact_or_crossing_is_left_out_however_members_are_displaced() {
        none_is_left_out(None);
    }

    /// The maxima of displacement and extent up to a NaN used to be lost at it.
    #[test]
    fn nor_beside_a_member_that_is_nan() {
        none_is_left_out(Some(198));
    }

    fn none_is_left_out(poisoned: Option<usize>) {
        const COUNT: usize = 200;
        let mut random = Random::new(11);
        let mut particles = Particles::default();
        let mut participants = TriangleParticipants::default();
        for row in 0..COUNT as u32 {
            particles.push(ParticleSeed::at(random.vector())).unwrap();
            participants.rows.push(row);
            participants.radius.push(0.02 + 0.01 * random.number());
        }
        let candidate = |edges: bool, random: &mut Random| loop {
            let four = [0; 4].map(|_| random.below(COUNT) as u32);
            let mut sorted = four;
            sorted.sort_unstable();
            if sorted.windows(2).all(|pair| pair[0] != pair[1]) {
                return TriangleCandidate { four, most: f32::INFINITY, edges, pair: [0; 2] };
            }
        };
        let candidates: Vec<_> =
            (0..1501).map(|number| candidate(number >= 700, &mut random)).collect();
        let mut list = CloseList::default();
        let anywhere = [f32::INFINITY; COUNT];
        let mut kept = candidates.clone();
        list.prune(&mut kept, &participants, &particles, &anywhere);
        assert_eq!(kept.len(), candidates.len());
        list.pack(&candidates, &participants);
        let (mut touching, mut passing, mut passed_over) = (0, 0, 0);
        for substep in 0..200 {
            // All share a motion; each has one of its own, some of them fast.
            let common = Vec3::new(0.03, -0.02, 0.01);
            for row in 0..COUNT {
                particles.start[row] = particles.position[row];
                let fast = if row % 17 == substep % 68 { 0.4 } else { 0.0005 };
                particles.position[row] += (common + fast * random.vector()).extend(0.0);
            }
            if let Some(poisoned) = poisoned {
                particles.position[poisoned] *= Vec4::new(f32::NAN, 1.0, 1.0, 1.0);
            }
            list.begin_substep(&participants, &particles);
            for _ in 0..6 {
                list.update();
                let mut listed = vec![false; candidates.len()];
                for (place, close) in
                    (0..).map_while(|place| Some((place, list.close_lanes(place, 0)?)))
                {
                    for lane in SetLanes(close) {
                        listed[list.number(place, lane as u32) as usize] = true;
                    }
                }
                passed_over += listed.iter().filter(|&&listed| !listed).count();
                for (number, candidate) in candidates.iter().enumerate() {
                    let place = |of: &[Vec4], i: usize| particles.origin[i] + of[i].truncate();
                    let at = |of: &[Vec4]| candidate.four.map(|i| place(of, i as usize).as_dvec3());
                    let (from, to) = (at(&particles.start), at(&particles.position));
                    let four = Four { from, to, edges: candidate.edges };
                    let reach = largest(&participants.radius, candidate.four, candidate.edges);
                    let touches = exact(&four) < f64::from(reach);
                    let passes = four.crossing().is_some();
                    touching += u32::from(touches);
                    passing += u32::from(passes);
                    assert!(listed[number] || !touches && !passes, "{substep}: {number}");
                }
                for _ in 0..5 {
                    let i = random.below(COUNT);
                    let far = substep.is_multiple_of(9) && i.is_multiple_of(3);
                    let by = random.vector() * if far { 0.1 } else { 0.0005 };
                    particles.position[i] += by.extend(0.0);
                    list.record_displacement(i, by.as_dvec3());
                }
            }
        }
        assert!(touching > 1000 && passing > 1000, "{touching}, {passing}");
        assert!(passed_over > 200 * 6 * 1501 / 3, "{passed_over}");
    }

    #[test]
    fn candidates_that_are_not_kept_cannot_come_near() {
        const COUNT: usize = 60;
        let mut random = Random::new(5);
        let mut particles = Particles::default();
        let mut participants = TriangleParticipants::default();
        for row in 0..COUNT as u32 {
            particles.push(ParticleSeed::at(random.vector() * 0.4)).unwrap();
            participants.rows.push(row);
            participants.radius.push(0.02 + 0.01 * random.number());
        }
        let ranges: Vec<f32> = (0..COUNT).map(|_| 0.03 + 0.03 * random.number()).collect();
        let all: Vec<_> = (0..4000)
            .map(|number| TriangleCandidate {
                four: [0; 4].map(|_| random.below(COUNT) as u32),
                most: f32::INFINITY,
                edges: number >= 1900,
                pair: [number, 0],
            })
            .collect();
        let mut list = CloseList::default();
        let mut kept = all.clone();
        list.prune(&mut kept, &participants, &particles, &ranges);
        let taken: Vec<u32> = kept.iter().map(|candidate| candidate.pair[0]).collect();
        let (mut left, mut near) = (taken.iter().peekable(), 0);
        for (number, candidate) in (0..).zip(&all) {
            if left.next_if(|next| **next == number).is_some() {
                continue;
            }
            let reach = largest(&participants.radius, candidate.four, candidate.edges);
            for _ in 0..20 {
                let to = candidate.four.map(|i| {
                    let by = random.vector().normalize_or_zero() * ranges[i as usize];
                    (particles.position(i as usize) + by).as_dvec3()
                });
                let least = exact(&Four { from: to, to, edges: candidate.edges });
                assert!(least >= f64::from(reach), "{candidate:?}");
                near += u32::from(least < 3.0 * f64::from(reach));
            }
        }
        assert!(left.next().is_none(), "in their order");
        assert!((200..3800).contains(&taken.len()) && near > 10, "{} taken, {near}", taken.len());
    }
}
