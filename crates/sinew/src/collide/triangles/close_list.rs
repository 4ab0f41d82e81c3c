//! Who of those that were found is close: so close that the two may touch or pass through each other in this substep.
//!
//! What was found lasts for some steps, and is some hundred for each that touches. Most of those can come to touch only if members go far within their margins along
//! the diagonal of a box; who could not, however all go within them, is left out as soon as it is found. Of the others it is asked in each substep, eight at a time, how
//! near they are at the least ([`least_distance`](super::least_distance)), and those that are close are put together, eight by eight again, for the sweeps. None of it is a
//! decision: who is close is asked again, in double precision, and a candidate more changes nothing.
//!
//! Contacts put members elsewhere, so that others become close. Who may by that is in the list, too, as long as nobody is put further than is allowed for, which
//! is some more than in the substep before; then the list is made again.

use glam::{DVec3, Vec3, Vec4};

use super::least_distance::{of_edges, to_triangle};
use super::neighbour_list::{LONGER, TriangleCandidate, mean};
use super::participants::{TriangleParticipants, largest};
use crate::lanes::{InstructionSet, LANES, Lanes, SetLanes, Vector, Work, with};
use crate::particles::Particles;

/// Scratch; what is in it for longer than a substep saves asking, and changes no result.
#[derive(Clone, Debug, Default)]
pub(super) struct CloseList {
    /// Which instructions are used; all give the same bits.
    pub(super) instructions: InstructionSet,
    /// Those that were picked, in their order: those of corners first.
    blocks: Vec<CandidateBlock>,
    /// Where each member is, metres from the first one's origin, and how far that is from where it began in this substep, beside what all do in the mean;
    /// and that place.
    ends: Vec<Vec4>,
    began: Vec<Vec3>,
    /// How far rounding may have put them elsewhere, metres.
    rounding: f32,
    /// Those that are close, in their order.
    close: Vec<CandidateBlock>,
    /// Where each was when they were listed; and how far it may go in this substep and be put, and be put again.
    listed: Vec<Vec4>,
    /// How far each may be put until others are close, metres; and how far it has been put.
    allowances: Vec<f32>,
    puts: Vec<f32>,
    /// What all are allowed.
    base: f32,
    /// How far one has been put at the most, and whether one was further than is allowed for.
    put: f32,
    outrun: bool,
}

/// Eight candidates. Where there are fewer, the first one stands in the places that are left.
#[derive(Clone, Copy, Debug)]
struct WideCandidate {
    members: [[u32; LANES]; 4],
    /// The largest distance that they keep, metres.
    reach: [f32; LANES],
    count: u32,
    edges: bool,
}

/// Eight candidates, ascending, by their numbers.
#[derive(Clone, Copy, Debug)]
struct CandidateBlock {
    wide: WideCandidate,
    numbers: [u32; LANES],
}

/// The next substep puts somebody further than the last by no more than this factor, mostly.
const MORE: f32 = 1.5;

/// Who was not put in the last substep is allowed this share of what surprised in an earlier one, less with each that passes.
const SURPRISE: f32 = 0.1;
const FORGOTTEN: f32 = 0.9;

impl CloseList {
    /// Picks candidates, those of corners first: those of whom some can come near as long as each member is no further from where it is than its `range`, metres.
    pub(super) fn pick(
        &mut self,
        candidates: &[TriangleCandidate],
        participants: &TriangleParticipants,
        particles: &Particles,
        ranges: &[f32],
    ) {
        let Self { blocks, ends, instructions, .. } = self;
        blocks.clear();
        let (zero, mut far) = (first_origin(participants, particles), 0.0_f32);
        ends.clear();
        ends.extend(participants.rows.iter().zip(ranges).map(|(&row, range)| {
            let at = place(particles, row, zero);
            far = far.max(at.abs().max_element());
            at.extend(*range)
        }));
        let slack = 2.0 * ROUNDING * far;
        let mut number = 0;
        while let Some(first) = candidates.get(number) {
            let mut wide = WideCandidate::new(first, participants);
            let others = candidates[number + 1..].iter().take(LANES - 1);
            for other in others.take_while(|other| other.edges == first.edges) {
                wide.put(other.four, reach_of(other, participants));
            }
            let ask = AskBlock { wide: &wide, ends, slack, both: true };
            push_lanes(blocks, &wide, with(*instructions, ask), |lane| (number + lane) as u32);
            number += wide.count as usize;
        }
    }

    /// Lists who is close in a substep that has been predicted.
    pub(super) fn begin_substep(
        &mut self,
        participants: &TriangleParticipants,
        particles: &Particles,
    ) {
        let Self { ends, began, rounding, .. } = self;
        let way = |row: usize| (particles.position[row] - particles.start[row]).truncate();
        let common = mean(participants.rows.iter().map(|&row| way(row as usize)));
        let zero = first_origin(participants, particles);
        let mut far = 0.0_f32;
        ends.clear();
        began.clear();
        for &row in &participants.rows {
            let at = place(particles, row, zero);
            let row = row as usize;
            let own = way(row) - common;
            began.push(at - own);
            let own = own.length() * LONGER;
            // What is no number does not count: it touches nobody.
            far = far.max(at.abs().max_element());
            ends.push(at.extend(own));
        }
        *rounding = ROUNDING * far;
        self.puts.resize(self.ends.len(), 0.0);
        self.base *= FORGOTTEN;
        self.allowances.clear();
        self.allowances.extend(self.puts.iter().map(|put| self.base + MORE * put));
        self.puts.fill(0.0);
        (self.put, self.outrun) = (0.0, false);
        self.list();
    }

    /// Lists them again if somebody was put further than was allowed for. Returns whether it was so.
    pub(super) fn keep_up(&mut self) -> bool {
        let outrun = core::mem::take(&mut self.outrun);
        if outrun {
            self.base = (2.0 * self.base).max(SURPRISE * self.put);
            for (allowance, &put) in self.allowances.iter_mut().zip(&self.puts) {
                let wanted = if put > *allowance { 2.0 * put } else { self.base };
                *allowance = allowance.max(wanted);
            }
            self.list();
        }
        outrun
    }

    fn list(&mut self) {
        let Self { blocks, ends, rounding, close, allowances, listed, instructions, .. } = self;
        listed.clear();
        let each = ends.iter().zip(&*allowances);
        listed.extend(each.map(|(end, put)| end.truncate().extend(end.w + 2.0 * put)));
        close.clear();
        with(*instructions, ListClose { blocks, listed, slack: 2.0 * *rounding, close });
    }

    /// Which candidates of a block of those that are listed are close where members are now, a bit each, of those from a number on; `None` where there is no such block.
    pub(super) fn ask(&self, place: usize, from: u32) -> Option<u32> {
        let CandidateBlock { wide, numbers } = self.close.get(place)?;
        let slack = 2.0 * self.rounding;
        let before = numbers[..wide.count as usize].partition_point(|number| *number < from);
        let ask = AskBlock { wide, ends: &self.ends, slack, both: false };
        Some(with(self.instructions, ask) & (u32::MAX << before))
    }

    /// The number of one of a block.
    pub(super) fn number(&self, place: usize, lane: u32) -> u32 {
        self.close[place].numbers[lane as usize]
    }

    /// The first block that has a candidate of a number or of a higher one.
    pub(super) fn place_of(&self, number: u32) -> usize {
        let last = |block: &CandidateBlock| block.numbers[block.wide.count as usize - 1];
        self.close.partition_point(|block| last(block) < number)
    }

    /// Notes that a member was put elsewhere, by so many metres.
    pub(super) fn note_put(&mut self, i: usize, by: DVec3) {
        let end = self.ends[i].truncate() + by.as_vec3();
        self.ends[i] = end.extend((end - self.began[i]).length() * LONGER);
        let put = (end - self.listed[i].truncate()).length() * LONGER;
        self.puts[i] = self.puts[i].max(put);
        self.put = self.put.max(put);
        self.outrun |= put > self.allowances[i];
    }
}

/// Where members are, metres from the first one's origin.
fn place(particles: &Particles, row: u32, zero: Vec3) -> Vec3 {
    let row = row as usize;
    (particles.origin[row] - zero) + particles.position[row].truncate()
}

fn first_origin(participants: &TriangleParticipants, particles: &Particles) -> Vec3 {
    participants.rows.first().map_or(Vec3::ZERO, |&row| particles.origin[row as usize])
}

/// How far rounding may have put a place elsewhere, as a share of its largest coordinate: that of itself, and of some times that it is put.
const ROUNDING: f32 = 2e-6;

/// The largest distance that the two of a candidate keep, metres.
fn reach_of(candidate: &TriangleCandidate, participants: &TriangleParticipants) -> f32 {
    largest(&participants.radius, candidate.four, candidate.edges).min(candidate.most)
}

impl WideCandidate {
    /// A first one.
    fn of(four: [u32; 4], reach: f32, edges: bool) -> Self {
        let members = four.map(|member| [member; LANES]);
        let mut wide = Self { members, reach: [0.0; LANES], count: 0, edges };
        wide.put(four, reach);
        wide
    }

    fn new(candidate: &TriangleCandidate, participants: &TriangleParticipants) -> Self {
        Self::of(candidate.four, reach_of(candidate, participants), candidate.edges)
    }

    /// Whether there is room for one more of a kind.
    #[inline(always)]
    fn takes(&self, edges: bool) -> bool {
        self.edges == edges && self.count < LANES as u32
    }

    /// Adds one.
    #[inline(always)]
    fn put(&mut self, four: [u32; 4], reach: f32) {
        let place = self.count as usize;
        for (members, member) in self.members.iter_mut().zip(four) {
            members[place] = member;
        }
        self.reach[place] = reach;
        self.count += 1;
    }

    /// One of them, and its distance.
    #[inline(always)]
    fn lane(&self, lane: usize) -> ([u32; 4], f32) {
        let [i, j, k, l] = &self.members;
        ([i[lane], j[lane], k[lane], l[lane]], self.reach[lane])
    }

    /// The places that are filled, a bit each.
    fn filled(&self) -> u32 {
        (1 << self.count) - 1
    }

    /// How near they are at the least, and how far the two may come nearer within the substep: what each has gone.
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

/// Lists who is close: nearer than its distance and what the two may go in the substep, and be put.
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
            let near = AskBlock { wide, ends: listed, slack, both: true }.run::<L>();
            push_lanes(close, wide, near, |lane| numbers[lane]);
        }
    }
}

/// Adds some of eight candidates to blocks, by their numbers.
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

/// Which of eight are close, a bit each: nearer than their distance, or than what the two have gone (so that they may have passed); or than `both` together.
struct AskBlock<'a> {
    wide: &'a WideCandidate,
    ends: &'a [Vec4],
    slack: f32,
    both: bool,
}

impl Work for AskBlock<'_> {
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

    /// Numbers from -1 to 1, the same in every run.
    struct Dice(u64);

    impl Dice {
        fn next(&mut self) -> f32 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            ((self.0 >> 33) as f64 / (1_u64 << 30) as f64 - 1.0) as f32
        }

        fn vector(&mut self) -> Vec3 {
            Vec3::new(self.next(), self.next(), self.next())
        }

        fn below(&mut self, count: usize) -> u32 {
            ((self.next() * 0.5 + 0.5) * count as f32) as u32 % count as u32
        }
    }

    /// How far two are apart where they are.
    fn exact(four: &Four) -> f64 {
        let [p, a, b, c] = four.to;
        if four.edges {
            return distance::of_segments([p, a], [b, c]);
        }
        let [i, j, k] = distance::to_triangle(p, [a, b, c]);
        (p - (a * i + b * j + c * k)).length()
    }

    #[test]
    fn nobody_who_touches_or_passes_is_left_out_however_members_go_and_are_put() {
        nobody_is_left_out(None);
    }

    /// How far the fastest and the furthest before it went was forgotten with it.
    #[test]
    fn nor_beside_one_who_is_no_number() {
        nobody_is_left_out(Some(198));
    }

    fn nobody_is_left_out(poisoned: Option<usize>) {
        const COUNT: usize = 200;
        let mut dice = Dice(11);
        let mut particles = Particles::default();
        let mut participants = TriangleParticipants::default();
        for row in 0..COUNT as u32 {
            particles.push(ParticleSeed::at(dice.vector())).unwrap();
            participants.rows.push(row);
            participants.radius.push(0.02 + 0.01 * dice.next());
        }
        let candidate = |edges: bool, dice: &mut Dice| loop {
            let four = [0; 4].map(|_| dice.below(COUNT));
            let mut sorted = four;
            sorted.sort_unstable();
            if sorted.windows(2).all(|pair| pair[0] != pair[1]) {
                return TriangleCandidate { four, most: f32::INFINITY, edges };
            }
        };
        let candidates: Vec<_> =
            (0..1501).map(|number| candidate(number >= 700, &mut dice)).collect();
        let mut list = CloseList::default();
        let anywhere = [f32::INFINITY; COUNT];
        list.pick(&candidates, &participants, &particles, &anywhere);
        let (mut touching, mut passing, mut passed_over) = (0, 0, 0);
        for substep in 0..200 {
            // All are carried along; each goes its own way, some fast.
            let common = Vec3::new(0.03, -0.02, 0.01);
            for row in 0..COUNT {
                particles.start[row] = particles.position[row];
                let fast = if row % 17 == substep % 68 { 0.4 } else { 0.0005 };
                particles.position[row] += (common + fast * dice.vector()).extend(0.0);
            }
            if let Some(poisoned) = poisoned {
                particles.position[poisoned] *= Vec4::new(f32::NAN, 1.0, 1.0, 1.0);
            }
            list.begin_substep(&participants, &particles);
            for _ in 0..6 {
                list.keep_up();
                let mut asked = vec![false; candidates.len()];
                for (place, close) in (0..).map_while(|place| Some((place, list.ask(place, 0)?))) {
                    for lane in SetLanes(close) {
                        asked[list.number(place, lane as u32) as usize] = true;
                    }
                }
                passed_over += asked.iter().filter(|&&asked| !asked).count();
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
                    assert!(asked[number] || !touches && !passes, "{substep}: {number}");
                }
                for _ in 0..5 {
                    let i = dice.below(COUNT) as usize;
                    let far = substep.is_multiple_of(9) && i.is_multiple_of(3);
                    let by = dice.vector() * if far { 0.1 } else { 0.0005 };
                    particles.position[i] += by.extend(0.0);
                    list.note_put(i, by.as_dvec3());
                }
            }
        }
        assert!(touching > 1000 && passing > 1000, "{touching}, {passing}");
        assert!(passed_over > 200 * 6 * 1501 / 3, "{passed_over}");
    }

    #[test]
    fn who_is_not_taken_cannot_come_near() {
        const COUNT: usize = 60;
        let mut dice = Dice(5);
        let mut particles = Particles::default();
        let mut participants = TriangleParticipants::default();
        for row in 0..COUNT as u32 {
            particles.push(ParticleSeed::at(dice.vector() * 0.4)).unwrap();
            participants.rows.push(row);
            participants.radius.push(0.02 + 0.01 * dice.next());
        }
        let ranges: Vec<f32> = (0..COUNT).map(|_| 0.03 + 0.03 * dice.next()).collect();
        let all: Vec<_> = (0..4000)
            .map(|number| TriangleCandidate {
                four: [0; 4].map(|_| dice.below(COUNT)),
                most: f32::INFINITY,
                edges: number >= 1900,
            })
            .collect();
        let mut list = CloseList::default();
        list.pick(&all, &participants, &particles, &ranges);
        let taken: Vec<u32> = list
            .blocks
            .iter()
            .flat_map(|block| block.numbers[..block.wide.count as usize].iter().copied())
            .collect();
        let (mut left, mut near) = (taken.iter().peekable(), 0);
        for (number, candidate) in (0..).zip(&all) {
            if left.next_if(|next| **next == number).is_some() {
                continue;
            }
            let reach = largest(&participants.radius, candidate.four, candidate.edges);
            for _ in 0..20 {
                let to = candidate.four.map(|i| {
                    let by = dice.vector().normalize_or_zero() * ranges[i as usize];
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
