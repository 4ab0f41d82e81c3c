//! The blocks, eight pairs at a time: each pair that overlaps is pushed apart, and held back from sliding.
//!
//! With `d = p_a - p_b`, `n = d/‖d‖`, the least distance `r` and inverse masses `w`, the overlap `δ = r - ‖d‖` is taken away as any distance is
//! (physics.md C1, C10):
//!
//! ```text
//! p_a += w_a/(w_a + w_b) δ n        p_b -= w_b/(w_a + w_b) δ n
//! ```
//!
//! which moves neither the barycentre nor turns anything about it. Since the substep began the two have slid past each other by `t = D - (D·n) n`,
//! where `D` is the change of `d`; where that is no more than friction holds, `‖t‖ ≤ μ δ` (F8), all of it is taken back by the same weights, and
//! nothing slides. Otherwise it slides, and `restitution` takes from its velocity what friction may.

use glam::Vec3;

use super::super::filter::ContactFilter;
use super::neighbour_list::{NO_OFFSET, NeighbourList, PairBlock};
use super::restitution::{PairHit, Touched};
use super::swept::{COINCIDENT, SweptPair, TimeOfImpact};
use crate::lanes::{LANES, Lanes, Vector, Work};
use crate::particles::Particles;

/// One sweep over all blocks; what comes of it is the greatest overlap that it met, metres.
pub(super) struct PairSweep<'a> {
    pub(super) neighbours: &'a NeighbourList,
    pub(super) filter: &'a ContactFilter,
    pub(super) particles: &'a mut Particles,
    /// Whether somebody is so fast that pairs must be asked for the way that they came.
    pub(super) fast: bool,
    /// Length of the substep, seconds.
    pub(super) h: f32,
    pub(super) touched: &'a mut Vec<Touched>,
    pub(super) hits: &'a mut Vec<PairHit>,
    pub(super) times_of_impact: &'a mut Vec<TimeOfImpact>,
}

/// The share of the least distance that a pair may move by, each against the other, before the way that it came counts.
const HALF: f32 = 0.5;

impl Work for PairSweep<'_> {
    type Output = f32;

    #[inline(always)]
    fn run<L: Lanes>(mut self) -> f32 {
        let neighbours = self.neighbours;
        let mut worst = L::zero();
        let mut rest = 0.0_f32;
        for (number, block) in neighbours.blocks.iter().enumerate() {
            let BlockOverlap { overlap, hit, rare, normal } = self.take::<L>(block, number as u32);
            if hit | rare == 0 {
                continue;
            }
            worst = overlap.max(worst);
            if hit & block.reported != 0 {
                self.note(block, hit & block.reported, overlap, normal);
            }
            if rare != 0 {
                rest = rest.max(self.treat(block, rare));
            }
        }
        worst.largest(rest)
    }
}

/// What a block came to.
struct BlockOverlap<L> {
    /// Metres; zero where there is none.
    overlap: L,
    /// Which overlapped, and are done.
    hit: u32,
    /// Which are to be treated one by one.
    rare: u32,
    normal: Vector<L>,
}

impl PairSweep<'_> {
    #[inline(always)]
    fn take<L: Lanes>(&mut self, block: &PairBlock, number: u32) -> BlockOverlap<L> {
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
            let moved = d - self.began(block, offset);
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
        let moved = d - self.began(block, offset);
        let slid = moved - n * n.dot(moved);
        let length = slid.length();
        let most = L::load(&block.friction) * overlap;
        let held = length.le(most).and(L::splat(1.0));
        let apart = (n * overlap - slid * held) * (L::splat(1.0) / (w_a + w_b));
        let (a, b) = ((a + apart * w_a).or_else(hit, a), (b - apart * w_b).or_else(hit, b));
        L::put_rows(&mut self.particles.position, rows_a, a.with(w_a));
        L::put_rows(&mut self.particles.position, rows_b, b.with(w_b));
        self.touched.push(Touched {
            block: number,
            normal: [hit.and(n.x).array(), hit.and(n.y).array(), hit.and(n.z).array()],
            parting: n.dot(self.velocity(block)).array(),
            weights: [w_a.array(), w_b.array()],
            impulse: most.array(),
        });
        BlockOverlap { overlap: hit.and(overlap), hit: hit.bits(), rare, normal: n }
    }

    /// What `d` was when the substep began.
    #[inline(always)]
    fn began<L: Lanes>(&self, block: &PairBlock, offset: Vector<L>) -> Vector<L> {
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

    /// Notes those that are to be reported.
    #[inline(always)]
    fn note<L: Lanes>(&mut self, block: &PairBlock, which: u32, overlap: L, normal: Vector<L>) {
        let overlaps = overlap.array();
        let (x, y, z) = (normal.x.array(), normal.y.array(), normal.z.array());
        for lane in 0..block.count as usize {
            if which & (1 << lane) != 0 {
                let rows = [block.rows[0][lane], block.rows[1][lane]];
                let place = Some((self.touched.len() - 1, lane));
                self.hit(rows, (Vec3::new(x[lane], y[lane], z[lane]), overlaps[lane]), place);
            }
        }
    }

    #[inline(never)]
    fn hit(&mut self, rows: [u32; 2], how: (Vec3, f32), place: Option<(usize, usize)>) {
        let hit = PairHit::new(self.particles, self.filter, rows, how, place, self.h);
        self.hits.push(hit);
    }

    /// One by one, and returns the greatest overlap, metres.
    #[inline(never)]
    fn treat(&mut self, block: &PairBlock, which: u32) -> f32 {
        let mut worst = 0.0_f32;
        for lane in 0..block.count as usize {
            if which & (1 << lane) == 0 {
                continue;
            }
            let pair = pair_of(block, lane, &self.neighbours.offsets);
            let Some((normal, overlap, stopped)) = pair.treat(self.particles) else { continue };
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
        offset: offset.map_or(Vec3::ZERO, |[x, y, z]| Vec3::new(x[lane], y[lane], z[lane])),
        reach: block.reach[lane],
        friction: block.friction[lane],
    }
}
