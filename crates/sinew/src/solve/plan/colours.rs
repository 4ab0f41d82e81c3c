//! Colours: sets of constraints of which no two share a particle.
//!
//! **Strides.** Where particles are numbered row by row, most rods bind the particles `a` and `a + d` for one of a few strides `d`: along the row, across, along both diagonals.
//! Those of one stride fall into two colours without looking at anything else: by whether `a/d`, rounded down, is even. For `a` within
//! `[2jd, 2jd + d)` lies `a + d` within `[2jd + d, 2jd + 2d)`, so the pairs are disjoint. Such colours have long runs `(a, d), (a + 1, d), …`, which lanes take
//! without gathering. So a grid is found wherever it is, in a recipe or in a game's own constraints.
//!
//! **The rest** is coloured greedily: each takes the lowest colour that none of its particles has used, in the order given. A mesh takes some 13 colours.

/// The colour of what found no other: a particle in more than 64 constraints. Solved one after the other, which is always right.
pub(super) const OVERFLOW: u32 = GREEDY + 64;
/// The first greedy colour, after those of the strides.
pub(super) const GREEDY: u32 = 2 * STRIDES as u32;
/// The most strides that an island has colours for: a bit each.
const STRIDES: usize = 32;
/// So many rods of a stride are worth colours of their own: an eighth of them is lost to runs that do not fill the lanes.
const LEAST: usize = 64;

/// Which colours each particle's constraints have used, by phase: rods, other distances, laws.
#[derive(Clone, Debug, Default)]
pub(super) struct Colours {
    used: [Vec<[u64; 3]>; 3],
    /// Strides in which the particle is the first of a rod.
    strided: Vec<[u32; 3]>,
}

impl Colours {
    /// Nothing is used by any of so many particles.
    pub(super) fn reset(&mut self, particles: usize) {
        for used in &mut self.used {
            used.clear();
            used.resize(particles, [0; 3]);
        }
        self.strided.clear();
        self.strided.resize(particles, [0; 3]);
    }

    pub(super) fn rod(&mut self, phase: u32, rows: &[u32]) -> u32 {
        greedy(&mut self.used[0], phase, rows)
    }

    pub(super) fn distance(&mut self, phase: u32, rows: &[u32]) -> u32 {
        greedy(&mut self.used[1], phase, rows)
    }

    pub(super) fn law(&mut self, phase: u32, rows: &[u32]) -> u32 {
        greedy(&mut self.used[2], phase, rows)
    }
}

/// The lowest colour that none of the particles has used, which they now have; [`OVERFLOW`] if there is none.
fn greedy(used: &mut [[u64; 3]], phase: u32, rows: &[u32]) -> u32 {
    let phase = phase as usize;
    let taken = rows.iter().fold(0, |taken, &row| taken | used[row as usize][phase]);
    let colour = (!taken).trailing_zeros();
    if colour < 64 {
        rows.iter().for_each(|&row| used[row as usize][phase] |= 1 << colour);
    }
    GREEDY + colour
}

/// The strides that many rods of an island have, ascending.
#[derive(Clone, Debug, Default)]
pub(super) struct Strides {
    found: Vec<u32>,
    all: Vec<u32>,
}

impl Strides {
    /// Looks at the rods of an island (first and last place in it).
    pub(super) fn find(&mut self, ends: impl Iterator<Item = (u32, u32)>) {
        let Self { found, all } = self;
        found.clear();
        all.clear();
        all.extend(ends.map(|(a, b)| b - a));
        // A thirty-second each: no more than there is room for.
        let least = LEAST.max(all.len() / STRIDES + 1);
        if all.len() < LEAST {
            return;
        }
        all.sort_unstable();
        found
            .extend(all.chunk_by(|a, b| a == b).filter(|run| run.len() >= least).map(|run| run[0]));
    }

    /// The colour of a rod by its stride, or `None` if it has to look for another. `row` is that of its first particle.
    pub(super) fn colour(
        &self,
        a: u32,
        b: u32,
        phase: u32,
        row: u32,
        colours: &mut Colours,
    ) -> Option<u32> {
        let stride = b - a;
        let number = self.found.binary_search(&stride).ok()?;
        // Two rods between the same particles: the second has to go elsewhere.
        let taken = &mut colours.strided[row as usize][phase as usize];
        if *taken & 1 << number != 0 {
            return None;
        }
        *taken |= 1 << number;
        Some(2 * number as u32 + (a / stride % 2))
    }
}
