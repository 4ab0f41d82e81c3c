//! Colours: sets of constraints of which no two share a particle.
//!
//! **Strides.** Where particles are numbered row by row, most distances connect the particles `a` and `a + d` for one of a few strides `d`: along the row,
//! across it, along both diagonals. The distances of one stride fall into two colours by arithmetic alone: by whether `a/d`, rounded down, is even. If `a` is
//! in `[2jd, 2jd + d)`, then `a + d` is in `[2jd + d, 2jd + 2d)`, so the pairs are disjoint. Such colours contain long runs `(a, d), (a + 1, d), …`, which
//! lanes load without gathering. A grid is thus recognised wherever it comes from, a recipe or a game's own constraints.
//!
//! **Greedy colours.** The other constraints are coloured greedily: in input order, each takes the lowest colour that none of its particles has used. A mesh
//! needs about 13 colours.

use super::GroupKind;

/// The colour of constraints for which no colour was free: a particle has more than 64 of them. They are solved one after the other, which is always correct.
pub(super) const OVERFLOW: u32 = GREEDY + 64;
/// The first greedy colour, after those of the strides.
pub(super) const GREEDY: u32 = 2 * MAX_STRIDES as u32;
/// The most strides that an island has colours for: one bit each.
const MAX_STRIDES: usize = 32;
/// Least number of distances of one stride that get colours of their own. At this length about an eighth is lost to runs that do not fill the lanes.
const MIN_COUNT: u32 = 64;

/// Colours used by each particle's constraints, by kind and phase.
#[derive(Clone, Debug, Default)]
pub(super) struct Colours {
    used: [Vec<[u64; 3]>; 3],
    /// Strides in which the particle is the first end of a distance, for rods and for other distances.
    strided: [Vec<[u32; 3]>; 2],
}

impl Colours {
    /// Resizes to `particles` and clears the used colours of the rows in `these`.
    pub(super) fn reset(&mut self, particles: usize, these: &[u32]) {
        for used in &mut self.used {
            used.resize(particles, [0; 3]);
            these.iter().for_each(|&row| used[row as usize] = [0; 3]);
        }
        for strided in &mut self.strided {
            strided.resize(particles, [0; 3]);
            these.iter().for_each(|&row| strided[row as usize] = [0; 3]);
        }
    }

    /// The lowest colour that none of the particles has used, which is then marked as used; [`OVERFLOW`] if there is none.
    pub(super) fn greedy(&mut self, kind: GroupKind, phase: u32, rows: &[u32]) -> u32 {
        let (used, phase) = (&mut self.used[kind as usize], phase as usize);
        let taken = rows.iter().fold(0, |taken, &row| taken | used[row as usize][phase]);
        let colour = lowest(taken);
        if colour < OVERFLOW {
            let bit = 1 << (colour - GREEDY);
            rows.iter().for_each(|&row| used[row as usize][phase] |= bit);
        }
        colour
    }

    /// Whether this is the first distance of that stride that begins at `row`. A second distance between the same two particles needs another colour.
    pub(super) fn take_stride(
        &mut self,
        kind: GroupKind,
        number: usize,
        phase: u32,
        row: u32,
    ) -> bool {
        let taken = &mut self.strided[kind as usize][row as usize][phase as usize];
        let first = *taken & 1 << number == 0;
        *taken |= 1 << number;
        first
    }
}

/// The lowest greedy colour whose bit is clear; [`OVERFLOW`] if all are set.
pub(super) fn lowest(taken: u64) -> u32 {
    GREEDY + (!taken).trailing_zeros()
}

/// Number of distances of each stride. Scratch.
#[derive(Clone, Debug, Default)]
pub(super) struct StrideCounts {
    of: Vec<u32>,
    all: u32,
}

impl StrideCounts {
    pub(super) fn clear(&mut self) {
        self.of.clear();
        self.all = 0;
    }

    /// Counts a distance between two member indices of an island.
    pub(super) fn add(&mut self, (a, b): (u32, u32)) {
        let stride = (b - a) as usize;
        if stride >= self.of.len() {
            self.of.resize(stride + 1, 0);
        }
        self.of[stride] += 1;
        self.all += 1;
    }
}

/// The frequent strides of the distances of one kind in an island, ascending.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Strides(Vec<u32>);

impl Strides {
    /// The strides that occur often enough to get colours of their own.
    pub(super) fn of(counts: &StrideCounts) -> Self {
        // At least a thirty-second of all each, so that there are never more than `MAX_STRIDES`.
        let least = MIN_COUNT.max(counts.all / MAX_STRIDES as u32 + 1);
        Self((0..).zip(&counts.of).filter(|(_, count)| **count >= least).map(|own| own.0).collect())
    }

    /// The index and the colour of the stride between two member indices; `None` if that stride is not frequent.
    pub(super) fn colour(&self, a: u32, b: u32) -> Option<(usize, u32)> {
        let stride = b - a;
        let number = self.0.binary_search(&stride).ok()?;
        Some((number, 2 * number as u32 + (a / stride % 2)))
    }
}
