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
use super::neighbour_list::{LONGER, mean};
use super::participants::{TriangleParticipants, largest};
use super::search::TriangleCandidate;
use crate::lanes::{InstructionSet, LANES, Lanes, SetLanes, Vector, Work, with};
use crate::particles::Particles;
use crate::threads::{ExecutionContext, Workers, each_chunk};

/// Scratch. What outlives a substep only saves tests and changes no result.
#[derive(Clone, Debug, Default)]
pub(super) struct CloseList {
    /// Instruction set of this substep; all give the same bits.
    instructions: InstructionSet,
    /// The candidates of the neighbour list, in order: those of corners first.
    blocks: Vec<CandidateBlock>,
    /// `ends`: position of each member, metres from the first member's origin, and in `w` its displacement in this substep relative to the mean displacement of
    /// all members. `starts`: that position less that displacement.
    ends: Vec<Vec4>,
    starts: Vec<Vec3>,
    /// Greatest rounding error of these positions, metres.
    rounding: f32,
    /// The close candidates, in order: of all blocks, and those of each chunk of them.
    close: Vec<CandidateBlock>,
    of_chunks: Vec<Vec<CandidateBlock>>,
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

/// Up to eight candidates. Empty lanes have members, too.
#[derive(Clone, Copy, Debug)]
pub(super) struct WideCandidate {
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

/// Number of blocks that are worth a task: it takes some 50 µs.
const CHUNK: usize = 1024;

impl CloseList {
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
        execution: ExecutionContext<'_>,
    ) {
        self.instructions = execution.instructions;
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
        self.list(execution.workers);
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
            // Few candidates are left to test when this happens, one after the other.
            self.list(None);
        }
        exceeded
    }

    fn list(&mut self, workers: Option<&dyn Workers>) {
        let Self { blocks, ends, close, of_chunks, allowances, listed, instructions, .. } = self;
        listed.clear();
        let each = ends.iter().zip(&*allowances);
        listed.extend(each.map(|(end, allowance)| end.truncate().extend(end.w + 2.0 * allowance)));
        let (listed, slack) = (&listed[..], 2.0 * self.rounding);
        let of_chunks = each_chunk(workers, blocks, CHUNK, of_chunks, |_, blocks, close| {
            close.clear();
            with(*instructions, ListClose { blocks, listed, slack, close });
        });
        close.clear();
        of_chunks.iter().for_each(|of_chunk| close.extend_from_slice(of_chunk));
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
pub(super) fn place(particles: &Particles, row: u32, zero: Vec3) -> Vec3 {
    let row = row as usize;
    (particles.origin[row] - zero) + particles.position[row].truncate()
}

/// Origin of the first member, metres.
pub(super) fn first_origin(participants: &TriangleParticipants, particles: &Particles) -> Vec3 {
    participants.rows.first().map_or(Vec3::ZERO, |&row| particles.origin[row as usize])
}

/// Greatest rounding error of a position, as a share of its largest coordinate: of the position itself and of several displacements.
pub(super) const ROUNDING: f32 = 2e-6;

/// Greatest contact distance of a candidate, metres.
fn reach_of(candidate: &TriangleCandidate, participants: &TriangleParticipants) -> f32 {
    largest(&participants.radius, candidate.four, candidate.edges).min(candidate.most)
}

impl WideCandidate {
    /// An empty block, for candidates of a kind.
    pub(super) fn new(edges: bool) -> Self {
        Self { members: [[0; LANES]; 4], reach: [0.0; LANES], count: 0, edges }
    }

    /// A block with one candidate.
    fn of(four: [u32; 4], reach: f32, edges: bool) -> Self {
        let [i, j, k, l] = four;
        let members = [[i; LANES], [j; LANES], [k; LANES], [l; LANES]];
        let mut wide = Self { members, ..Self::new(edges) };
        wide.put(four, reach);
        wide
    }

    pub(super) fn count(&self) -> usize {
        self.count as usize
    }

    pub(super) fn edges(&self) -> bool {
        self.edges
    }

    /// Removes all candidates.
    pub(super) fn clear(&mut self) {
        self.count = 0;
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
    pub(super) fn put(&mut self, four: [u32; 4], reach: f32) {
        let place = self.count as usize;
        for (members, member) in self.members.iter_mut().zip(four) {
            members[place] = member;
        }
        self.reach[place] = reach;
        self.count += 1;
    }

    /// The candidate in a lane, and its contact distance.
    #[inline(always)]
    pub(super) fn lane(&self, lane: usize) -> ([u32; 4], f32) {
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
pub(super) struct CloseTest<'a> {
    pub(super) wide: &'a WideCandidate,
    pub(super) ends: &'a [Vec4],
    pub(super) slack: f32,
    pub(super) both: bool,
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
    use super::super::search::distance;
    use super::*;
    use crate::particles::ParticleSeed;
    use crate::test_random::Random;

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
        let execution = ExecutionContext { instructions: InstructionSet::best(), workers: None };
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
            list.begin_substep(&participants, &particles, execution);
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
                    let touches = distance(to, candidate.edges) < f64::from(reach);
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
}
