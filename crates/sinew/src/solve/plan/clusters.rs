//! Clusters: a large island divided into ranges of consecutive particles that fit into a core's cache.
//!
//! A sweep has three phases: first the constraints within one cluster; then, with the boundaries shifted by half a cluster, the constraints between neighbours
//! across the first boundaries; last, the constraints that reach farther. In the first two phases clusters share no particle, so several threads can solve one
//! each with the same result. This requires a particle order in which neighbours are close: that of a grid's rows, or any of small bandwidth.
//!
//! An island may be mostly one contiguous run of rows: cloth, for example, tied to a rope that was spawned long before it. Then only that run is divided; the
//! constraints outside it, and those that connect it to the rest, belong to the last phase.

use core::ops::Range;

use crate::islands::SMALL_ISLAND;

/// Number of phases.
pub(super) const PHASES: u32 = 3;

/// Least number of particles of a cluster: 16 kB of positions, half of a core's L1 cache. The rest lengths stream through the other half.
const MIN_SIZE: u32 = 1024;
/// Greatest number of particles of a cluster, unless [`MAX_CLUSTERS`] requires more: 512 kB of positions, a core's L2 cache.
const MAX_SIZE: u32 = 32_768;
/// A cluster's size in multiples of the mean reach of a constraint, chosen so that about one constraint in eight connects two clusters.
const REACHES: u64 = 8;
/// Number of clusters that a key has bits for.
const MAX_CLUSTERS: u32 = 4096;

/// Least share of an island's particles (numerator, denominator) in a contiguous run for that run to be divided by itself.
const MIN_RUN: (usize, usize) = (3, 4);

/// How an island is divided.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Clusters {
    /// Particles in each cluster, a power of two; `u32::MAX` where the island is one cluster.
    size: u32,
    /// First and last member index of the divided run.
    run: (u32, u32),
}

/// Phase and cluster in which a constraint is swept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    pub(super) phase: u32,
    pub(super) cluster: u32,
}

impl Place {
    pub(super) const LAST: Self = Self { phase: 2, cluster: 0 };
}

impl Clusters {
    /// The division of an island of `members` particles, of which `run` are the member indices in its longest contiguous run of rows. `count` is the number of
    /// distances, `reach` the sum of their reaches in member indices.
    pub(super) fn of(members: usize, run: Range<usize>, count: u64, reach: u64) -> Self {
        let mostly = members > SMALL_ISLAND && run.len() * MIN_RUN.1 >= members * MIN_RUN.0;
        let run = if mostly { (run.start as u32, run.end as u32 - 1) } else { (0, u32::MAX) };
        if members <= MIN_SIZE as usize {
            return Self { size: u32::MAX, run };
        }
        let wanted =
            (REACHES * reach / count.max(1)).clamp(MIN_SIZE.into(), MAX_SIZE.into()) as u32;
        let enough = (members as u32).div_ceil(MAX_CLUSTERS / 2);
        Self { size: wanted.max(enough).next_power_of_two(), run }
    }

    /// Phase and cluster of a constraint whose particles lie between these two member indices.
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
        // A strip 200 columns wide: each particle is connected to its neighbours in its row and in the next one.
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
        // A run of half of the members is not most of the island.
        let clusters = Clusters::of(500, 250..500, 1000, 20_000);
        assert_eq!(clusters.place(3, 499), Place { phase: 0, cluster: 0 });
    }
}
