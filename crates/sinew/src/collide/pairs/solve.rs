//! Position solve of the blocks, eight pairs at a time: each pair that overlaps is pushed apart, with static friction.
//!
//! With `d = p_a - p_b`, `n = d/‖d‖`, the least allowed distance `r` and inverse masses `w`, the overlap `δ = r - ‖d‖` is corrected like any distance
//! constraint (physics.md C1, C10):
//!
//! ```text
//! p_a += w_a/(w_a + w_b) δ n        p_b -= w_b/(w_a + w_b) δ n
//! ```
//!
//! which keeps the barycentre and causes no rotation about it. Since the start of the substep the two have slipped by `t = D - (D·n) n`, where `D` is the
//! change of `d`. Within the friction limit, `‖t‖ ≤ μ δ` (F8), all of it is corrected with the same weights (sticking). Beyond it the pair slips, and
//! `restitution` reduces the slip velocity by what friction allows.

use glam::Vec3;

use super::super::filter::ContactFilter;
use super::neighbour_list::{NO_OFFSET, NeighbourList, PairBlock};
use super::restitution::{PairHit, Touched};
use super::swept::{COINCIDENT, SweptPair, TimeOfImpact};
use crate::lanes::{LANES, Lanes, SetLanes, Vector, Work, get};
use crate::particles::Particles;

/// One sweep over all blocks. Its output is the greatest overlap found, metres.
pub(super) struct PairSweep<'a> {
    pub(super) neighbours: &'a NeighbourList,
    pub(super) filter: &'a ContactFilter,
    pub(super) particles: &'a mut Particles,
    /// Whether a particle is so fast that pairs must be tested along their paths.
    pub(super) fast: bool,
    /// Length of the substep, seconds.
    pub(super) h: f32,
    pub(super) touched: &'a mut Vec<Touched>,
    pub(super) hits: &'a mut Vec<PairHit>,
    pub(super) times_of_impact: &'a mut Vec<TimeOfImpact>,
}

/// Share of the least distance that the relative displacement of a pair may have before its path is tested.
const HALF: f32 = 0.5;

impl Work for PairSweep<'_> {
    type Output = f32;

    #[inline(always)]
    fn run<L: Lanes>(mut self) -> f32 {
        let neighbours = self.neighbours;
        let mut worst = L::zero();
        let mut rest = 0.0_f32;
        for (number, block) in neighbours.blocks.iter().enumerate() {
            let BlockOverlap { overlap, hit, rare, normal } =
                self.solve_block::<L>(block, number as u32);
            if hit | rare == 0 {
                continue;
            }
            worst = overlap.max(worst);
            if hit & block.reported != 0 {
                self.record(block, hit & block.reported, overlap, normal);
            }
            if rare != 0 {
                rest = rest.max(self.solve_rare(block, rare));
            }
        }
        worst.largest(rest)
    }
}

/// The result of a block.
struct BlockOverlap<L> {
    /// Metres; zero in lanes without one.
    overlap: L,
    /// Bit mask of the lanes that overlapped and are solved.
    hit: u32,
    /// Bit mask of the lanes left to the scalar path.
    rare: u32,
    normal: Vector<L>,
}

impl PairSweep<'_> {
    #[inline(always)]
    fn solve_block<L: Lanes>(&mut self, block: &PairBlock, number: u32) -> BlockOverlap<L> {
        let [rows_a, rows_b] = &block.rows;
        let (a, w_a) = Vector::of(L::rows(&self.particles.position, rows_a));
        let (b, w_b) = Vector::of(L::rows(&self.particles.position, rows_b));
        let zero = L::zero();
        let mut offset = Vector::new(zero, zero, zero);
        if block.offset != NO_OFFSET {
            let [x, y, z] = &self.neighbours.offsets[block.offset as usize];
            offset = Vector::new(L::load(x), L::load(y), L::load(z));
        }
        let d = (a - b) + offset;
        let reach = L::load(&block.reach);
        let (squared, reach_squared) = (d.length_squared(), reach * reach);
        let mut hit = squared.lt(reach_squared);
        let mut rare = 0;
        if self.fast {
            let moved = d - self.start_separation(block, offset);
            let fast = (reach_squared * L::splat(HALF * HALF)).lt(moved.length_squared());
            rare = fast.bits();
            hit = fast.select(zero, hit);
        }
        let none = BlockOverlap { overlap: zero, hit: 0, rare, normal: d };
        if !hit.any() {
            return none;
        }
        let coincident = squared.le(reach_squared * L::splat(COINCIDENT * COINCIDENT)).and(hit);
        rare |= coincident.bits();
        hit = coincident.select(zero, hit);
        let distance = squared.sqrt();
        if !hit.any() {
            return BlockOverlap { rare, ..none };
        }
        let n = d * (L::splat(1.0) / distance);
        let overlap = reach - distance;
        let moved = d - self.start_separation(block, offset);
        let slid = moved - n * n.dot(moved);
        let length = slid.length();
        let most = L::load(&block.friction) * overlap;
        let sticking = length.le(most).and(L::splat(1.0));
        let apart = (n * overlap - slid * sticking) * (L::splat(1.0) / (w_a + w_b));
        let (a, b) = ((a + apart * w_a).or_else(hit, a), (b - apart * w_b).or_else(hit, b));
        L::put_rows(&mut self.particles.position, rows_a, a.with(w_a));
        L::put_rows(&mut self.particles.position, rows_b, b.with(w_b));
        self.touched.push(Touched {
            block: number,
            normal: [hit.and(n.x).array(), hit.and(n.y).array(), hit.and(n.z).array()],
            parting: n.dot(self.velocity(block)).array(),
            weights: [w_a.array(), w_b.array()],
            overlap: overlap.array(),
            gained: [0.0; LANES],
        });
        BlockOverlap { overlap: hit.and(overlap), hit: hit.bits(), rare, normal: n }
    }

    /// `d` at the start of the substep.
    #[inline(always)]
    fn start_separation<L: Lanes>(&self, block: &PairBlock, offset: Vector<L>) -> Vector<L> {
        let (a, _) = Vector::of(L::rows(&self.particles.start, &block.rows[0]));
        let (b, _) = Vector::of(L::rows(&self.particles.start, &block.rows[1]));
        (a - b) + offset
    }

    /// The relative velocity that led here.
    #[inline(always)]
    fn velocity<L: Lanes>(&self, block: &PairBlock) -> Vector<L> {
        let (a, _) = Vector::of(L::rows(&self.particles.velocity, &block.rows[0]));
        let (b, _) = Vector::of(L::rows(&self.particles.velocity, &block.rows[1]));
        a - b
    }

    /// Records the contacts that are to be reported.
    #[inline(always)]
    fn record<L: Lanes>(&mut self, block: &PairBlock, which: u32, overlap: L, normal: Vector<L>) {
        let normals = [normal.x.array(), normal.y.array(), normal.z.array()];
        let overlaps = overlap.array();
        for lane in SetLanes(which) {
            let rows = [block.rows[0][lane], block.rows[1][lane]];
            let place = Some((self.touched.len() - 1, lane));
            self.hit(rows, (get(&normals, lane), overlaps[lane]), place);
        }
    }

    #[inline(never)]
    fn hit(&mut self, rows: [u32; 2], how: (Vec3, f32), place: Option<(usize, usize)>) {
        let hit = PairHit::new(self.particles, self.filter, rows, how, place, self.h);
        self.hits.push(hit);
    }

    /// Solves pairs one by one; returns the greatest overlap, metres.
    #[inline(never)]
    fn solve_rare(&mut self, block: &PairBlock, which: u32) -> f32 {
        let mut worst = 0.0_f32;
        for lane in 0..block.count as usize {
            if which & (1 << lane) == 0 {
                continue;
            }
            let pair = pair_of(block, lane, &self.neighbours.offsets);
            let Some((normal, overlap, stopped)) = pair.solve(self.particles) else { continue };
            worst = worst.max(overlap);
            if stopped {
                self.times_of_impact.push(TimeOfImpact { pair, normal });
            }
            self.hit(pair.rows, (normal, overlap), None);
        }
        worst
    }
}

fn pair_of(block: &PairBlock, lane: usize, offsets: &[[[f32; LANES]; 3]]) -> SweptPair {
    let offset = offsets.get(block.offset as usize);
    SweptPair {
        rows: [block.rows[0][lane], block.rows[1][lane]],
        offset: offset.map_or(Vec3::ZERO, |offset| get(offset, lane)),
        reach: block.reach[lane],
        friction: block.friction[lane],
    }
}
