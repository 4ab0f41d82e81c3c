//! Spans: what rods in a row imply of the two particles at its ends, `K` rods apart: that they are no farther from each other than those rods are long together.
//!
//! A sweep hands a pull on by a rod or two, so that a jerk goes through cloth at some 2 rods a step, and where a part of it that moves at `v` gets taut, rods are
//! stretched by about `v` over that speed, whatever they are made of. What hangs on pins has [tethers](super); between particles that are all free a span does the
//! same at a smaller scale: a pull goes on by `K` rods at once. As a tether, a span asks for nothing that the rods do not ask for, and does nothing while it is slack.
//! They are the coarse level of multigrid (hierarchical position based dynamics; Müller 2008) on a grid of which no particle is left out, so that nothing has to be
//! interpolated.
//!
//! They are found where rods run in step, as along the rows and the columns of a grid: of two strides, those of the shortest rods. Diagonals are left out, and so are
//! meshes that are numbered in another order. `K` is the largest power of two that is no more than the root of how many particles such a row has: as many spans
//! side by side reach through it as a span has rods.

use core::ops::Range;

use glam::Vec4;

use super::taut;
use crate::constraints::Distance;
use crate::lanes::{LANES, Lanes, Vector, Work, with};
use crate::threads::{ExecutionContext, each};

/// The spans of one island: colour by colour, of which no two share a particle.
#[derive(Clone, Debug, Default)]
pub(in crate::solve) struct Spans {
    blocks: Vec<SpanBlock>,
    parts: Vec<SpanPart>,
}

/// A stretch of the spans of one colour, which shares no particle with the others of its colour.
#[derive(Clone, Debug)]
struct SpanPart {
    /// Counted through all strides.
    colour: u32,
    rows: Range<u32>,
    blocks: Range<usize>,
}

/// Eight spans of one colour. Where there are fewer, one stands there again: it computes the same and writes the same.
#[derive(Clone, Debug)]
struct SpanBlock {
    /// Rows, counted from the first of the part.
    a: [u32; LANES],
    b: [u32; LANES],
    /// Metres.
    length: [f32; LANES],
}

/// Rods in step: from each particle to that a stride farther on.
struct Strided {
    /// Of each particle, how long its rod is, metres; NaN without.
    rests: Vec<f32>,
    stride: usize,
    /// How many there are, and how long all of them are together, metres.
    count: usize,
    sum: f64,
}

/// So many rods of a stride are worth spans, as a share of the particles: those of a grid have nearly as many.
const MANY: f64 = 0.75;

/// Of so many strides rods are looked at: a grid has four.
const MOST_STRIDES: usize = 16;

/// Particles in a part, at least: some microseconds of work.
const PART: usize = 4096;

/// No more parts than that in a colour, so that tasks are listed without a heap.
const MOST_PARTS: usize = 32;

/// The fewest rods that a span has.
const FEWEST: usize = 4;

impl Spans {
    /// Of an island whose particles are the consecutive rows from its first on.
    pub(super) fn of<'a>(
        first: u32,
        members: usize,
        rods: impl Iterator<Item = &'a Distance>,
    ) -> Self {
        let mut strides = strides(first, members, rods);
        strides.sort_by(|one, other| one.mean().total_cmp(&other.mean()));
        let mut spans = Self::default();
        for strided in strides.iter().take(2) {
            strided.list(first, &mut spans);
        }
        spans
    }

    /// Holds particles, in positions that begin with row `first`, to what their spans allow: by as many workers as there are, to the same bits.
    pub(in crate::solve) fn project(
        &self,
        position: &mut [Vec4],
        first: u32,
        execution: ExecutionContext,
    ) {
        for parts in self.parts.chunk_by(|one, other| one.colour == other.colour) {
            let mut left = Some((&mut *position, first));
            let tasks = parts.iter().filter_map(|part| {
                let (position, first) = left.take()?;
                let (_, position) = position.split_at_mut((part.rows.start - first) as usize);
                let (own, position) = position.split_at_mut(part.rows.len());
                left = Some((position, part.rows.end));
                let blocks = &self.blocks[part.blocks.clone()];
                Some(ProjectSpans { blocks, position: own })
            });
            each(execution.workers, tasks, |part| with(execution.instructions, part));
        }
    }

    /// All of them, some more than once: the rows of their ends, in an island that begins with row 0, and their lengths, metres.
    #[cfg(test)]
    pub(super) fn listed(&self) -> Vec<(u32, u32, f32)> {
        let each = self.parts.iter().flat_map(|part| {
            let blocks = self.blocks[part.blocks.clone()].iter();
            blocks.map(|block| (part.rows.start, block))
        });
        each.flat_map(|(first, block)| {
            (0..LANES)
                .map(move |lane| (first + block.a[lane], first + block.b[lane], block.length[lane]))
        })
        .collect()
    }

    pub(super) fn is_empty(&self) -> bool {
        self.blocks.is_empty()
    }
}

/// The rods of each stride that many have.
fn strides<'a>(
    first: u32,
    members: usize,
    rods: impl Iterator<Item = &'a Distance>,
) -> Vec<Strided> {
    let (mut strides, mut last) = (Vec::<Strided>::new(), 0);
    for d in rods {
        let (a, stride) = ((d.a.min(d.b) - first) as usize, d.a.abs_diff(d.b) as usize);
        // In the order of a plan, most have the stride of the one before.
        if strides.get(last).is_none_or(|own| own.stride != stride) {
            last = match strides.iter().position(|own| own.stride == stride) {
                Some(known) => known,
                None if strides.len() == MOST_STRIDES => continue,
                None => {
                    let rests = vec![f32::NAN; members];
                    strides.push(Strided { rests, stride, count: 0, sum: 0.0 });
                    strides.len() - 1
                }
            };
        }
        let Strided { rests, count, sum, .. } = &mut strides[last];
        // Of two between the same particles, the shorter one counts.
        rests[a] = if rests[a] <= d.rest { rests[a] } else { d.rest };
        *count += 1;
        *sum += f64::from(d.rest);
    }
    strides.retain(|own| own.count as f64 >= MANY * members as f64);
    strides
}

impl Strided {
    fn mean(&self) -> f64 {
        self.sum / self.count as f64
    }

    /// How many rods a span has: none if rows are too short.
    fn rods(&self) -> usize {
        // Of each particle, how many rods follow each other from it on.
        let (mut follow, mut most) = (vec![0_usize; self.rests.len()], 0);
        for a in (0..self.rests.len()).rev() {
            if self.rests[a] >= 0.0 {
                follow[a] = 1 + follow.get(a + self.stride).copied().unwrap_or(0);
                most = most.max(follow[a]);
            }
        }
        let rods = 1 << ((most + 1).ilog2() / 2);
        if rods < FEWEST { 0 } else { rods }
    }

    /// Lists its spans, one colour after the other: by which of `K` strides they begin in, as [colours](crate::solve::plan) of strides do.
    fn list(&self, first: u32, spans: &mut Spans) {
        let rods = self.rods();
        if rods == 0 {
            return;
        }
        let (members, reach) = (self.rests.len(), rods * self.stride);
        let length = |a: usize| -> f64 {
            (0..rods).map(|rod| f64::from(self.rests[a + rod * self.stride])).sum()
        };
        // Whole pairs of bands: in one the spans of a colour begin, in the next they end.
        let part = PART.max(members / MOST_PARTS).next_multiple_of(2 * reach);
        let Spans { blocks, parts } = spans;
        let colour = parts.last().map_or(0, |part| part.colour + 1);
        for parity in 0..2 {
            for begin in (parity * reach..members.saturating_sub(reach)).step_by(part) {
                let end = (begin + part).min(members);
                let own = (begin..end.saturating_sub(reach))
                    .filter(|a| a / reach % 2 == parity)
                    .map(|a| ((a - begin) as u32, taut(length(a))))
                    // Not where a row ends, or has a gap.
                    .filter(|span| !span.1.is_nan());
                let own: Vec<(u32, f32)> = own.collect();
                let before = blocks.len();
                blocks.extend(own.chunks(LANES).map(|some| {
                    let of = |lane: usize| some[if lane < some.len() { lane } else { 0 }];
                    SpanBlock {
                        a: core::array::from_fn(|lane| of(lane).0),
                        b: core::array::from_fn(|lane| of(lane).0 + reach as u32),
                        length: core::array::from_fn(|lane| of(lane).1),
                    }
                }));
                parts.push(SpanPart {
                    colour: colour + parity as u32,
                    rows: first + begin as u32..first + end as u32,
                    blocks: before..blocks.len(),
                });
            }
        }
    }
}

/// Projects some spans, whose part has these positions.
struct ProjectSpans<'a> {
    blocks: &'a [SpanBlock],
    position: &'a mut [Vec4],
}

impl Work for ProjectSpans<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { blocks, position } = self;
        for SpanBlock { a, b, length } in blocks {
            let (one, wa) = Vector::of(L::rows(position, a));
            let (other, wb) = Vector::of(L::rows(position, b));
            let (d, length) = (one - other, L::load(length));
            let (square, weights) = (d.length_squared(), wa + wb);
            let out = (length * length).lt(square).and(L::zero().lt(weights));
            if !out.any() {
                continue;
            }
            // As of a rope: with `d = a - b`, `s = (‖d‖ - L)/(‖d‖ (w_a + w_b))`.
            let distance = square.sqrt();
            let scale = out.and((distance - length) / (distance * weights));
            L::put_rows(position, a, (one - d * (wa * scale)).with(wa));
            L::put_rows(position, b, (other + d * (wb * scale)).with(wb));
        }
    }
}
