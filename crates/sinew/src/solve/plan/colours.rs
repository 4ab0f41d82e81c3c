//! Colours: sets of constraints of which no two share a particle.
//!
//! **Strides.** Where particles are numbered row by row, most distances bind the particles `a` and `a + d` for one of a few strides `d`: along the row,
//! across, along both diagonals. Those of one stride fall into two colours without looking at anything else: by whether `a/d`, rounded down, is even.
//! For `a` within `[2jd, 2jd + d)` lies `a + d` within `[2jd + d, 2jd + 2d)`, so the pairs are disjoint. Such colours have long runs `(a, d), (a + 1,
//! d), …`, which lanes take without gathering. So a grid is found wherever it is, in a recipe or in a game's own constraints.
//!
//! **The rest** is coloured greedily: each takes the lowest colour that none of its particles has used, in the order given. A mesh takes some 13
//! colours.

use super::GroupKind;

/// The colour of what found no other: a particle in more than 64 constraints. Solved one after the other, which is always right.
pub(super) const OVERFLOW: u32 = GREEDY + 64;
/// The first greedy colour, after those of the strides.
pub(super) const GREEDY: u32 = 2 * STRIDES as u32;
/// The most strides that an island has colours for: a bit each.
const STRIDES: usize = 32;
/// So many distances of a stride are worth colours of their own: an eighth of them is lost to runs that do not fill the lanes.
const LEAST: u32 = 64;

/// Which colours each particle's constraints have used, by kind and phase.
#[derive(Clone, Debug, Default)]
pub(super) struct Colours {
    used: [Vec<[u64; 3]>; 3],
    /// Strides in which the particle is the first of a distance: of rods, and of the others.
    strided: [Vec<[u32; 3]>; 2],
}

impl Colours {
    /// Of so many particles, nothing is used by these.
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

    /// The lowest colour that none of the particles has used, which they now have; [`OVERFLOW`] if there is none.
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

    /// Whether `row` is the first of a distance of that stride for the first time: of two between the same particles, the second has to go elsewhere.
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

/// The lowest greedy colour whose bit is not set; [`OVERFLOW`] if all are.
pub(super) fn lowest(taken: u64) -> u32 {
    GREEDY + (!taken).trailing_zeros()
}

/// How many distances have which stride. Scratch.
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

    /// Counts a distance between two places in an island.
    pub(super) fn add(&mut self, (a, b): (u32, u32)) {
        let stride = (b - a) as usize;
        if stride >= self.of.len() {
            self.of.resize(stride + 1, 0);
        }
        self.of[stride] += 1;
        self.all += 1;
    }
}

/// The strides that many distances of one kind in an island have, ascending.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Strides(Vec<u32>);

impl Strides {
    /// Those that so many have.
    pub(super) fn of(counts: &StrideCounts) -> Self {
        // A thirty-second each: no more than there is room for.
        let least = LEAST.max(counts.all / STRIDES as u32 + 1);
        Self((0..).zip(&counts.of).filter(|(_, count)| **count >= least).map(|own| own.0).collect())
    }

    /// The number of the stride between two places, and the colour that it gives to a distance between them; `None` if it is no stride of many.
    pub(super) fn colour(&self, a: u32, b: u32) -> Option<(usize, u32)> {
        let stride = b - a;
        let number = self.0.binary_search(&stride).ok()?;
        Some((number, 2 * number as u32 + (a / stride % 2)))
    }
}
