//! Projection of tethers in eights: on packed particles, and on particles in columns.

use core::ops::Range;

use glam::Vec4;

use super::{IslandTethers, TetherBlock};
use crate::lanes::{Columns, InstructionSet, LANES, Lanes, Vector, Work, with};

impl IslandTethers {
    /// Moves the particles of an island that are too far from their `pins` to the allowed distance, in positions that begin with row `first`. Returns the
    /// largest excess found, metres.
    pub(in crate::solve) fn project(
        &self,
        position: &mut [Vec4],
        first: u32,
        pins: &[Vec4],
        instructions: InstructionSet,
    ) -> f32 {
        with(instructions, ProjectTethers { blocks: &self.blocks, position, first, pins })
    }

    /// Like [`project`](Self::project), for some members in columns. The columns begin with member `first`, an even number of members before theirs.
    pub(in crate::solve) fn project_columns(
        &self,
        columns: &mut Columns,
        first: usize,
        members: &Range<usize>,
        pins: &[Vec4],
        instructions: InstructionSet,
    ) -> f32 {
        with(instructions, ProjectColumns { blocks: self.among(members), columns, first, pins })
    }

    /// Like [`project`](Self::project), for all but some members, which form one section.
    pub(in crate::solve) fn project_others(
        &self,
        position: &mut [Vec4],
        first: u32,
        members: &Range<usize>,
        pins: &[Vec4],
        instructions: InstructionSet,
    ) -> f32 {
        let among = self.places_among(members);
        let others = [&self.blocks[..among.start], &self.blocks[among.end..]];
        let mut worst = 0.0_f32;
        for blocks in others.into_iter().filter(|blocks| !blocks.is_empty()) {
            let position = &mut *position;
            let found = with(instructions, ProjectTethers { blocks, position, first, pins });
            worst = worst.max(found);
        }
        worst
    }
}

/// Moves one particle to the distance that a tether allows, as [`project_tether`] does for eight; returns the excess, metres.
#[inline]
pub(super) fn hold_one(q: &mut Vec4, pin: Vec4, length: f32) -> f32 {
    let d = (*q - pin).truncate();
    let distance = d.length();
    if !(q.w > 0.0 && distance > length) {
        return 0.0;
    }
    let far = distance - length;
    *q -= (d * (far / distance)).extend(0.0);
    far
}

struct ProjectTethers<'a> {
    blocks: &'a [TetherBlock],
    position: &'a mut [Vec4],
    first: u32,
    pins: &'a [Vec4],
}

impl Work for ProjectTethers<'_> {
    type Output = f32;

    #[inline(always)]
    fn run<L: Lanes>(self) -> f32 {
        let Self { blocks, position, first, pins } = self;
        let mut worst = L::zero();
        for block in blocks {
            let mut rows = block.rows;
            rows.iter_mut().for_each(|row| *row -= first);
            let (p, w) = Vector::of(L::rows(position, &rows));
            let (held, far, out) =
                project_tether(p, w, block.pins_of(pins), L::load(&block.length));
            if out.any() {
                L::put_rows(position, &rows, held.with(w));
                worst = far.max(worst);
            }
        }
        worst.largest(0.0)
    }
}

struct ProjectColumns<'a> {
    blocks: &'a [TetherBlock],
    columns: &'a mut Columns,
    first: usize,
    pins: &'a [Vec4],
}

impl Work for ProjectColumns<'_> {
    type Output = f32;

    #[inline(always)]
    fn run<L: Lanes>(self) -> f32 {
        let Self { blocks, columns, first, pins } = self;
        let mut worst = L::zero();
        for block in blocks {
            let at = columns.at(block.member - first as u32);
            let mut eights = columns.view();
            let (p, w) = Vector::of(eights.load::<L>(at));
            let (held, far, out) =
                project_tether(p, w, block.pins_of(pins), L::load(&block.length));
            if out.any() {
                eights.put(at, held.with(w));
                worst = far.max(worst);
            }
        }
        worst.largest(0.0)
    }
}

impl TetherBlock {
    /// The positions of the pins of the eight.
    #[inline(always)]
    fn pins_of<L: Lanes>(&self, pins: &[Vec4]) -> [L; 4] {
        if self.one_pin {
            let pin = pins[self.pins[0] as usize];
            return [L::splat(pin.x), L::splat(pin.y), L::splat(pin.z), L::splat(pin.w)];
        }
        L::rows(pins, &self.pins)
    }
}

/// Moves eight particles to within the lengths of their tethers. Returns the positions, the excess of each, metres, and a mask of those that were too far away.
///
/// `C = ‖d‖ - L ≤ 0` with `d = p - q` and a pin of infinite mass: all of the correction goes to the particle, `Δp = -C d/‖d‖`.
#[inline(always)]
pub(in crate::solve) fn project_tether<L: Lanes>(
    p: Vector<L>,
    w: L,
    pin: [L; 4],
    length: L,
) -> (Vector<L>, L, L) {
    let d = p - Vector::of(pin).0;
    let square = d.length_squared();
    let out = (length * length).lt(square).and(L::zero().lt(w));
    if !out.any() {
        return (p, L::zero(), out);
    }
    let distance = square.sqrt();
    let far = distance - length;
    ((p - d * (far / distance)).or_else(out, p), out.and(far), out)
}

const _: () = assert!(LANES == 8, "members are put eight by eight");
