//! Who of those that were found is close: so close that the two may touch or pass through each other in this substep.
//!
//! What was found lasts for a while, and is some thirty for each that touches. So they are asked eight at a time how near they are at the least
//! ([`least_distance`](super::least_distance)), which is no decision: who is close is asked again, in double precision, and a candidate more changes nothing.
//!
//! Eight that are far off are not even asked as long as nobody can have come near (conservative advancement, after Mirtich 1996): in a substep two come nearer by
//! twice what the fastest goes at the most, beside what all do in the mean.
//!
//! Contacts put members elsewhere, so that others become close. Who may by that is in the list, too, as long as nobody is put further than is allowed for, which
//! is some more than in the substep before; then the list is made again.

use glam::{DVec3, Vec3, Vec4};

use super::least_distance::{of_edges, to_triangle};
use super::neighbour_list::{TriangleCandidate, mean};
use super::participants::{TriangleParticipants, largest};
use crate::lanes::{InstructionSet, LANES, Lanes, Vector, Work, with};
use crate::particles::Particles;

/// Scratch; what is in it for longer than a substep saves asking, and changes no result.
#[derive(Clone, Debug, Default)]
pub(super) struct CloseList {
    /// Which instructions are used; all give the same bits.
    pub(super) instructions: InstructionSet,
    /// All candidates, those of corners first.
    blocks: Vec<CandidateBlock>,
    /// Where each member is, metres from the first one's origin, and how far that is from where it began in this substep, beside what all do in the mean;
    /// and that place.
    ends: Vec<Vec4>,
    began: Vec<Vec3>,
    /// How far rounding may have put them elsewhere, metres.
    rounding: f32,
    /// Where each was seen last, metres from its own origin.
    seen: Vec<Vec3>,
    /// How far the fastest of each substep has gone all in all, metres.
    gone: f32,
    /// Places of blocks of which some are close, ascending.
    close: Vec<u32>,
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
struct CandidateBlock {
    members: [[u32; LANES]; 4],
    /// The largest distance that they keep, metres.
    reach: [f32; LANES],
    /// Number of the first, and how many there are.
    first: u32,
    count: u32,
    edges: bool,
    /// How far the nearest are from touching at the least, metres, when so much was [`gone`](CloseList::gone).
    left: f32,
    gone: f32,
}

/// The next substep puts somebody further than the last by no more than this factor, mostly.
const MORE: f32 = 1.5;

/// Who was not put in the last substep is allowed this share of what surprised in an earlier one, less with each that passes.
const SURPRISE: f32 = 0.1;
const FORGOTTEN: f32 = 0.9;

impl CloseList {
    /// Takes candidates, those of corners first, and where members have been seen.
    pub(super) fn take(
        &mut self,
        candidates: &[TriangleCandidate],
        participants: &TriangleParticipants,
        particles: &Particles,
    ) {
        let Self { blocks, gone, .. } = self;
        *gone = 0.0;
        blocks.clear();
        for (number, candidate) in (0..).zip(candidates) {
            match blocks.last_mut() {
                Some(last) if last.edges == candidate.edges && last.count < LANES as u32 => {
                    last.put(candidate, participants);
                }
                _ => blocks.push(CandidateBlock::new(number, candidate, participants)),
            }
        }
        self.note_places(participants, particles);
    }

    /// Notes where members are.
    pub(super) fn note_places(
        &mut self,
        participants: &TriangleParticipants,
        particles: &Particles,
    ) {
        self.seen.clear();
        let rows = participants.rows.iter();
        self.seen.extend(rows.map(|&row| particles.position[row as usize].truncate()));
    }

    /// Lists who is close in a substep that has been predicted.
    pub(super) fn begin_substep(
        &mut self,
        candidates: &[TriangleCandidate],
        participants: &TriangleParticipants,
        particles: &Particles,
    ) {
        let Self { ends, began, seen, gone, rounding, put, .. } = self;
        let way = |row: usize| (particles.position[row] - particles.start[row]).truncate();
        let way_of = |i: usize| way(participants.rows[i] as usize).as_dvec3();
        let common = mean(participants, way_of).as_vec3();
        let zero =
            participants.rows.first().map_or(Vec3::ZERO, |&row| particles.origin[row as usize]);
        let (mut longest, mut far) = (0.0_f32, 0.0_f32);
        ends.clear();
        began.clear();
        for (&row, seen) in participants.rows.iter().zip(&*seen) {
            let row = row as usize;
            let at = (particles.origin[row] - zero) + particles.position[row].truncate();
            let own = way(row) - common;
            began.push(at - own);
            let own = own.length() * LONGER;
            let before = (particles.start[row].truncate() - *seen).length();
            // What is no number does not count: it touches nobody.
            longest = longest.max(own + before);
            far = far.max(at.abs().max_element());
            ends.push(at.extend(own));
        }
        // Of a place, and of some times that it is put elsewhere.
        *rounding = 2e-6 * far;
        *gone += longest + *put;
        self.puts.resize(self.ends.len(), 0.0);
        self.base *= FORGOTTEN;
        self.allowances.clear();
        self.allowances.extend(self.puts.iter().map(|put| self.base + MORE * put));
        self.puts.fill(0.0);
        (self.put, self.outrun) = (0.0, false);
        self.list(candidates);
    }

    /// Lists them again if somebody was put further than was allowed for. Returns whether it was so.
    pub(super) fn keep_up(&mut self, candidates: &[TriangleCandidate]) -> bool {
        let outrun = core::mem::take(&mut self.outrun);
        if outrun {
            // Of blocks that are passed over it is not known how far theirs have been put.
            self.gone += self.put;
            self.base = (2.0 * self.base).max(SURPRISE * self.put);
            for (allowance, &put) in self.allowances.iter_mut().zip(&self.puts) {
                let wanted = if put > *allowance { 2.0 * put } else { self.base };
                *allowance = allowance.max(wanted);
            }
            self.list(candidates);
        }
        outrun
    }

    fn list(&mut self, candidates: &[TriangleCandidate]) {
        let Self { blocks, ends, rounding, gone, close, allowances, listed, instructions, .. } =
            self;
        debug_assert!(
            blocks.last().is_none_or(|last| (last.first + last.count) as usize == candidates.len())
        );
        let most = allowances.iter().copied().fold(0.0, f32::max);
        listed.clear();
        let each = ends.iter().zip(&*allowances);
        listed.extend(each.map(|(end, put)| end.truncate().extend(end.w + 2.0 * put)));
        close.clear();
        let [rounding, most] = [2.0 * *rounding, 4.0 * most];
        with(*instructions, ListClose { blocks, listed, rounding, most, gone: *gone, close });
    }

    /// Of one block of which some are close the number of its first candidate, and which are close where members are now, a bit each; `None` where there is no such.
    pub(super) fn ask(&self, place: usize) -> Option<(u32, u32)> {
        let block = &self.blocks[*self.close.get(place)? as usize];
        let ask = AskBlock { block, ends: &self.ends, slack: 2.0 * self.rounding };
        Some((block.first, with(self.instructions, ask)))
    }

    /// The place of that which has a candidate of some number, or of the first one after it.
    pub(super) fn place_of(&self, number: u32) -> usize {
        let ends = |place: &u32| {
            let block = &self.blocks[*place as usize];
            block.first + block.count
        };
        self.close.partition_point(|place| ends(place) <= number)
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

/// What a length of `f32`s may be longer by than it comes to.
const LONGER: f32 = 1.0 + 1e-5;

impl CandidateBlock {
    fn new(first: u32, candidate: &TriangleCandidate, participants: &TriangleParticipants) -> Self {
        let mut block = Self {
            members: candidate.four.map(|member| [member; LANES]),
            reach: [0.0; LANES],
            first,
            count: 0,
            edges: candidate.edges,
            left: f32::NEG_INFINITY,
            gone: 0.0,
        };
        block.put(candidate, participants);
        block
    }

    /// Adds one.
    #[inline]
    fn put(&mut self, candidate: &TriangleCandidate, participants: &TriangleParticipants) {
        let place = self.count as usize;
        for (members, member) in self.members.iter_mut().zip(candidate.four) {
            members[place] = member;
        }
        let reach = largest(&participants.radius, candidate.four, candidate.edges);
        self.reach[place] = reach.min(candidate.most);
        self.count += 1;
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
    blocks: &'a mut [CandidateBlock],
    listed: &'a [Vec4],
    rounding: f32,
    /// What two may be put, and be put again, at the most, metres.
    most: f32,
    gone: f32,
    close: &'a mut Vec<u32>,
}

impl Work for ListClose<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { blocks, listed, rounding, most, gone, close } = self;
        for (place, block) in (0..).zip(blocks) {
            // Two are nearer each other by what both have gone, which may be as much as their way in this substep.
            if block.left > 4.0 * (gone - block.gone) + most + rounding {
                continue;
            }
            let [least, ways] = block.least::<L>(listed);
            let left = least - (L::load(&block.reach) + ways);
            let far = L::splat(rounding).lt(left);
            if !far.bits() & block.filled() != 0 {
                close.push(place);
            }
            let nearest = left.array().into_iter().fold(f32::INFINITY, |nearest, left| {
                // What is no number is asked again.
                if left >= nearest { nearest } else { left }
            });
            (block.left, block.gone) = (nearest, gone);
        }
    }
}

/// Which of eight are close, a bit each.
struct AskBlock<'a> {
    block: &'a CandidateBlock,
    ends: &'a [Vec4],
    slack: f32,
}

impl Work for AskBlock<'_> {
    type Output = u32;

    #[inline(always)]
    fn run<L: Lanes>(self) -> u32 {
        let [least, ways] = self.block.least::<L>(self.ends);
        let far = (L::load(&self.block.reach).max(ways) + L::splat(self.slack)).lt(least);
        !far.bits() & self.block.filled()
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
        list.take(&candidates, &participants, &particles);
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
            list.begin_substep(&candidates, &participants, &particles);
            for _ in 0..6 {
                list.keep_up(&candidates);
                let mut asked = vec![false; candidates.len()];
                let places = (0..).map_while(|place| list.ask(place));
                for (first, close) in places {
                    (0..8).for_each(|bit| {
                        if close >> bit & 1 == 1 {
                            asked[(first + bit) as usize] = true;
                        }
                    });
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
            list.note_places(&participants, &particles);
        }
        assert!(touching > 1000 && passing > 1000, "{touching}, {passing}");
        assert!(passed_over > 200 * 6 * 1501 / 3, "{passed_over}");
    }
}
