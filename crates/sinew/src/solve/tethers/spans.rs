//! Spans: the bound that `K` consecutive rods imply for the two particles at their ends: these are no farther apart than the rods are long together.
//!
//! A sweep propagates a pull by a rod or two, so a jerk travels through cloth at about 2 rods a step. Where a part that moves at `v` becomes taut, rods are
//! stretched by about `v` over that speed, whatever their material. Cloth on pins has [tethers](super); between particles that are all free, a span does the
//! same on a smaller scale: it propagates a pull by `K` rods at once. Like a tether, a span requires nothing that the rods do not require, and does nothing
//! while it is slack. Spans are the coarse level of multigrid (hierarchical position based dynamics; Müller 2008) on a grid from which no particle is left out,
//! so that nothing has to be interpolated.
//!
//! Spans are projected last in a sweep: the strain that remains is largest where rods come last.
//!
//! Where the island is swept in columns, spans are projected there: four loads serve eight particles, while packed particles have to be transposed for each
//! span.
//!
//! Spans are found where rods are strided, as along the rows and the columns of a grid: the two strides with the shortest rods are used. Diagonals are left
//! out, and so are meshes with another numbering. `K` is the largest power of two that is no more than the square root of the number of particles in such a
//! row: a row then takes as many consecutive spans as a span has rods.

use core::ops::Range;

use glam::Vec4;

use super::tether_length;
use crate::constraints::Distance;
use crate::lanes::{Columns, InstructionSet, LANES, Lanes, PARITY_ORDER, Vector, Work, with};
use crate::threads::{ExecutionContext, each};

/// The spans of one island, by colour. No two spans of a colour share a particle.
#[derive(Clone, Debug, Default)]
pub(in crate::solve) struct Spans {
    blocks: Vec<SpanBlock>,
    parts: Vec<SpanPart>,
}

/// A range of the spans of one colour, which shares no particle with the other ranges of its colour.
#[derive(Clone, Debug)]
struct SpanPart {
    /// Numbered through all strides.
    colour: u32,
    rows: Range<u32>,
    /// Number of rows from each span's first particle to its second.
    reach: u32,
    blocks: Range<usize>,
}

/// Spans that begin at eight consecutive rows, the even rows of the eight first, as [columns](Columns) store them.
#[derive(Clone, Debug)]
struct SpanBlock {
    /// The first of the rows, counted from that of the part: a span begins there.
    a: u32,
    /// Metres; infinite where no span begins.
    length: [f32; LANES],
}

/// The rods of one stride: from a particle to the one that many rows farther on.
struct Strided {
    /// Length of the rod that begins at each particle, metres; NaN where there is none.
    rests: Vec<f32>,
    stride: usize,
    /// Number of rods, and their total length, metres.
    count: usize,
    sum: f64,
}

/// Least number of rods of a stride that get spans, as a share of the particles. A grid's strides have nearly as many rods as particles.
const MIN_SHARE: f64 = 0.75;

/// Most strides that are considered: a grid has four.
const MAX_STRIDES: usize = 16;

/// Least number of particles in a part: some microseconds of work.
const MIN_PART: usize = 4096;

/// Most parts of a colour, so that tasks are listed without heap allocation.
const MAX_PARTS: usize = 32;

/// Fewest rods of a span.
const MIN_RODS: usize = 4;

impl Spans {
    /// The spans of an island whose particles are the consecutive rows from `first` on.
    pub(in crate::solve) fn of<'a>(
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

    /// Projects the spans, in positions that begin with row `first`: with all workers, and with the same bits for any number of them.
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
                Some(ProjectSpans { blocks, reach: part.reach, position: own })
            });
            each(execution.workers, tasks, |part| with(execution.instructions, part));
        }
    }

    /// Like [`project`](Self::project), on particles in columns that begin with row `first`.
    pub(in crate::solve) fn project_columns(
        &self,
        columns: &mut Columns,
        first: u32,
        instructions: InstructionSet,
    ) {
        with(instructions, SpanColumns { spans: self, columns, first });
    }

    /// All spans: the rows of their ends, in an island that begins with row 0, and their lengths, metres.
    #[cfg(test)]
    pub(super) fn listed(&self) -> Vec<(u32, u32, f32)> {
        let each = self.parts.iter().flat_map(|part| {
            let blocks = self.blocks[part.blocks.clone()].iter();
            blocks.map(|block| (part.rows.start, part.reach, block))
        });
        each.flat_map(|(first, reach, block)| {
            let spans = (0..LANES).filter(|lane| block.length[*lane].is_finite());
            spans.map(move |lane| {
                let a = first + block.a + PARITY_ORDER[lane] as u32;
                (a, a + reach, block.length[lane])
            })
        })
        .collect()
    }

    pub(super) fn is_empty(&self) -> bool {
        self.blocks.is_empty()
    }
}

/// The rods of each frequent stride.
fn strides<'a>(
    first: u32,
    members: usize,
    rods: impl Iterator<Item = &'a Distance>,
) -> Vec<Strided> {
    let (mut strides, mut last) = (Vec::<Strided>::new(), 0);
    for d in rods {
        let (a, stride) = ((d.a.min(d.b) - first) as usize, d.a.abs_diff(d.b) as usize);
        // In plan order, most rods have the stride of the previous one.
        if strides.get(last).is_none_or(|own| own.stride != stride) {
            last = match strides.iter().position(|own| own.stride == stride) {
                Some(known) => known,
                None if strides.len() == MAX_STRIDES => continue,
                None => {
                    let rests = vec![f32::NAN; members];
                    strides.push(Strided { rests, stride, count: 0, sum: 0.0 });
                    strides.len() - 1
                }
            };
        }
        let Strided { rests, count, sum, .. } = &mut strides[last];
        // Of two rods between the same particles, the shorter one counts.
        rests[a] = if rests[a] <= d.rest { rests[a] } else { d.rest };
        *count += 1;
        *sum += f64::from(d.rest);
    }
    strides.retain(|own| own.count as f64 >= MIN_SHARE * members as f64);
    strides
}

impl Strided {
    fn mean(&self) -> f64 {
        self.sum / self.count as f64
    }

    /// The number of rods of a span; 0 if rows are too short.
    fn rods(&self) -> usize {
        // For each particle, the number of consecutive rods from it on.
        let (mut follow, mut most) = (vec![0_usize; self.rests.len()], 0);
        for a in (0..self.rests.len()).rev() {
            if self.rests[a] >= 0.0 {
                follow[a] = 1 + follow.get(a + self.stride).copied().unwrap_or(0);
                most = most.max(follow[a]);
            }
        }
        let rods = 1 << ((most + 1).ilog2() / 2);
        if rods < MIN_RODS { 0 } else { rods }
    }

    /// Lists the spans, one colour after the other: by the parity of `a / reach`, as for the [colours](crate::solve::plan) of strides.
    fn list(&self, first: u32, spans: &mut Spans) {
        let rods = self.rods();
        if rods == 0 {
            return;
        }
        let (members, reach) = (self.rests.len(), rods * self.stride);
        let length = |a: usize| -> f64 {
            (0..rods).map(|rod| f64::from(self.rests[a + rod * self.stride])).sum()
        };
        // Whole pairs of bands: the spans of a colour begin in one band and end in the next.
        let part = MIN_PART.max(members / MAX_PARTS).next_multiple_of(2 * reach);
        let Spans { blocks, parts } = spans;
        let colour = parts.last().map_or(0, |part| part.colour + 1);
        for parity in 0..2 {
            for begin in (parity * reach..members.saturating_sub(reach)).step_by(part) {
                let end = (begin + part).min(members);
                let own = (begin..end.saturating_sub(reach))
                    .filter(|a| a / reach % 2 == parity)
                    .map(|a| ((a - begin) as u32, tether_length(length(a))))
                    // Not where a row ends or has a gap.
                    .filter(|span| !span.1.is_nan());
                let before = blocks.len();
                for (a, length) in own {
                    // Not across the end of a band: what is written back for the first eight would be out of date for the other eight.
                    let band = (a as usize + begin) / reach;
                    let fits = |block: &&mut SpanBlock| {
                        a < block.a + LANES as u32 && (block.a as usize + begin) / reach == band
                    };
                    let all = blocks.len() - before;
                    let last = blocks.last_mut().filter(|_| all > 0).filter(fits);
                    let lane =
                        |from: u32| PARITY_ORDER.iter().position(|row| *row as u32 == a - from);
                    if let Some(block) = last {
                        lane(block.a).into_iter().for_each(|lane| block.length[lane] = length);
                    } else {
                        let mut lengths = [f32::INFINITY; LANES];
                        lengths[0] = length;
                        blocks.push(SpanBlock { a, length: lengths });
                    }
                }
                parts.push(SpanPart {
                    colour: colour + parity as u32,
                    rows: first + begin as u32..first + end as u32,
                    reach: reach as u32,
                    blocks: before..blocks.len(),
                });
            }
        }
    }
}

/// The work of projecting some spans; the positions are those of their part.
struct ProjectSpans<'a> {
    blocks: &'a [SpanBlock],
    reach: u32,
    position: &'a mut [Vec4],
}

impl Work for ProjectSpans<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { blocks, reach, position } = self;
        for SpanBlock { a, length } in blocks {
            let (mut ones, mut others) = ([*a; LANES], [*a + reach; LANES]);
            for lane in 0..LANES {
                // Where no span begins, the first one is repeated, since the row may not exist.
                let row = if length[lane].is_finite() { PARITY_ORDER[lane] as u32 } else { 0 };
                (ones[lane], others[lane]) = (a + row, a + row + reach);
            }
            let (one, other) = (L::rows(position, &ones), L::rows(position, &others));
            // Where a row is written twice, the last lane prevails.
            let mut again = *length;
            for (lane, length_) in again.iter_mut().enumerate() {
                *length_ = if length[lane].is_finite() { *length_ } else { length[0] };
            }
            let Some((one, other)) = project_span(one, other, L::load(&again)) else { continue };
            L::put_rows(position, &ones, one);
            L::put_rows(position, &others, other);
        }
    }
}

/// The work of projecting all spans of an island whose particles are in columns.
struct SpanColumns<'a> {
    spans: &'a Spans,
    columns: &'a mut Columns,
    /// The row with which the columns begin.
    first: u32,
}

impl Work for SpanColumns<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { spans, columns, first } = self;
        for part in &spans.parts {
            let from = part.rows.start - first;
            for SpanBlock { a, length } in &spans.blocks[part.blocks.clone()] {
                let (a, b) = (from + a, from + a + part.reach);
                let one = [columns.at(a), columns.at(a + 1)];
                let other = [columns.at(b), columns.at(b + 1)];
                let mut eights = columns.view();
                let held = project_span(
                    eights.load_run::<L>(one),
                    eights.load_run(other),
                    L::load(length),
                );
                let Some((moved, others)) = held else { continue };
                // In this order: rows of the first eight at which no span begins may be among the other eight.
                eights.put_run(one, moved);
                eights.put_run(other, others);
            }
        }
    }
}

/// Moves both ends of eight spans to the allowed distance; `None` if all are within it. Ends within it stay as they are, to the bit.
///
/// As for a rope: with `d = a - b`, `s = (‖d‖ - L)/(‖d‖ (w_a + w_b))`.
#[inline(always)]
fn project_span<L: Lanes>(one: [L; 4], other: [L; 4], length: L) -> Option<([L; 4], [L; 4])> {
    let ((a, wa), (b, wb)) = (Vector::of(one), Vector::of(other));
    let d = a - b;
    let (square, weights) = (d.length_squared(), wa + wb);
    let out = (length * length).lt(square).and(L::zero().lt(weights));
    if !out.any() {
        return None;
    }
    let distance = square.sqrt();
    let scale = (distance - length) / (distance * weights);
    let (to_a, to_b) = (d * (wa * scale), d * (wb * scale));
    let (a, b) = ((a - to_a).or_else(out, a), (b + to_b).or_else(out, b));
    Some((a.with(wa), b.with(wb)))
}
