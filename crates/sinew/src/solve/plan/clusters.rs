//! Clusters: a large island cut into stretches of consecutive particles that fit into a core's cache.
//!
//! A sweep takes them in phases. In the first, all that binds particles of one cluster; then, with the cuts moved by half a cluster, what binds
//! neighbours across the first cuts; last, what reaches farther than that. In the first two phases clusters share no particle, so several threads may
//! each take one, and the result is the same. It needs an order of the particles in which neighbours are near: that of a grid's rows, or any of small
//! bandwidth.
//!
//! Where an island is mostly one run of rows, as cloth is that a rope is tied to which came long before it, that is what is cut; and whatever is not in it, and
//! what binds that to it, is of the last phase.

use core::ops::Range;

use crate::islands::SMALL_ISLAND;

/// How many phases there are.
pub(super) const PHASES: u32 = 3;

/// How many particles a cluster has at least: 16 kB of positions, half of a core's first cache; the rest lengths stream through the other half.
const LEAST: u32 = 1024;
/// And at most: 512 kB of positions, a core's second cache.
const MOST: u32 = 32_768;
/// So many of the mean reach of a constraint are in a cluster, so that one in eight or so binds two.
const REACHES: u64 = 8;
/// A key has room for so many clusters.
const CLUSTERS: u32 = 4096;

/// A run of fewer particles of an island, as a share of all, is not cut by itself.
const MOSTLY: (usize, usize) = (3, 4);

/// How an island is cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Clusters {
    /// Particles in each, a power of two; more than there are where the island is one cluster.
    size: u32,
    /// The first place that is cut, and the last.
    run: (u32, u32),
}

/// Where a constraint is swept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    pub(super) phase: u32,
    pub(super) cluster: u32,
}

impl Place {
    pub(super) const LAST: Self = Self { phase: 2, cluster: 0 };
}

impl Clusters {
    /// For an island of so many particles, those in a `run` of places in rows that follow each other, of which so many pairs are bound, which reach over so many
    /// places in sum.
    pub(super) fn of(members: usize, run: Range<usize>, count: u64, reach: u64) -> Self {
        let mostly = members > SMALL_ISLAND && run.len() * MOSTLY.1 >= members * MOSTLY.0;
        let run = if mostly { (run.start as u32, run.end as u32 - 1) } else { (0, u32::MAX) };
        if members <= LEAST as usize {
            return Self { size: u32::MAX, run };
        }
        let wanted = (REACHES * reach / count.max(1)).clamp(LEAST.into(), MOST.into()) as u32;
        let enough = (members as u32).div_ceil(CLUSTERS / 2);
        Self { size: wanted.max(enough).next_power_of_two(), run }
    }

    /// Where a constraint goes whose particles lie between these two places in the island.
    pub(super) fn place(self, first: u32, last: u32) -> Place {
        if first < self.run.0 || last > self.run.1 {
            return Place::LAST;
        }
        let (first, last) = (first - self.run.0, last - self.run.0);
        let half = self.size / 2;
        let (whole, moved) = (first / self.size, (first + half) / self.size);
        if whole == last / self.size {
            Place { phase: 0, cluster: whole }
        } else if moved == (last + half) / self.size {
            Place { phase: 1, cluster: moved }
        } else {
            Place::LAST
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clusters_of_a_phase_share_no_particle() {
        // A strip of 200 columns: each particle is bound to its neighbours in the row and in the next one.
        let columns = 200;
        let ends =
            (0..40_000_u32).flat_map(|a| [(a, a + 1), (a, a + columns), (a, a + columns + 1)]);
        let reach = ends.clone().map(|(a, b)| u64::from(b - a)).sum();
        let clusters = Clusters::of(40_300, 0..40_300, ends.clone().count() as u64, reach);
        let mut owner = [vec![None; 40_300], vec![None; 40_300]];
        let mut counts = [0; 3];
        for (a, b) in ends {
            let Place { phase, cluster } = clusters.place(a, b);
            counts[phase as usize] += 1;
            if phase < 2 {
                for particle in [a, b] {
                    let owner = &mut owner[phase as usize][particle as usize];
                    assert!(owner.is_none_or(|owner| owner == cluster));
                    *owner = Some(cluster);
                }
            }
        }
        assert!(counts[1] > 0 && counts[1] * 8 < counts[0] && counts[2] == 0, "{counts:?}");
    }

    #[test]
    fn a_small_island_is_one_cluster() {
        let clusters = Clusters::of(2000, 0..2000, 1, 1999);
        assert_eq!(clusters.place(0, 1999), Place { phase: 0, cluster: 0 });
    }

    #[test]
    fn what_is_not_in_the_run_that_is_most_of_an_island_comes_last() {
        let clusters = Clusters::of(500, 21..500, 1000, 20_000);
        assert_eq!(clusters.place(21, 499), Place { phase: 0, cluster: 0 });
        for (first, last) in [(0, 1), (20, 21), (3, 499)] {
            assert_eq!(clusters.place(first, last), Place { phase: 2, cluster: 0 });
        }
        // Of two halves none is the whole.
        let clusters = Clusters::of(500, 250..500, 1000, 20_000);
        assert_eq!(clusters.place(3, 499), Place { phase: 0, cluster: 0 });
    }
}
