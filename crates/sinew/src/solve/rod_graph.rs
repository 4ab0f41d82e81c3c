//! The rods of an island as a graph: the rods at each particle, and the particles at their other ends.

/// No particle.
const NONE: u32 = u32::MAX;

/// Particles, and the rods between them (an adjacency list).
#[derive(Clone, Debug)]
pub(super) struct RodGraph {
    /// Where the rods of each particle begin; the last entry is the number of rod ends.
    first: Vec<u32>,
    rods: Vec<RodEnd>,
}

/// A rod as seen from one of its ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RodEnd {
    /// The particle at the other end.
    pub(super) to: u32,
    /// Its number in the list that the graph was built from.
    pub(super) number: u32,
    /// Rest length, metres.
    pub(super) rest: f32,
    /// Whether it may be shorter: a rope rather than a bar.
    pub(super) slackens: bool,
}

impl RodGraph {
    /// A graph of a number of particles. Rods are given by their two ends, the rest length in metres, and whether they slacken.
    pub(super) fn new(particles: usize, rods: &[(u32, u32, f32, bool)]) -> Self {
        let mut first = vec![0_u32; particles + 1];
        for &(a, b, ..) in rods {
            first[a as usize + 1] += 1;
            first[b as usize + 1] += 1;
        }
        for particle in 0..particles {
            first[particle + 1] += first[particle];
        }
        let none = RodEnd { to: NONE, number: 0, rest: 0.0, slackens: false };
        let (mut next, mut all) = (first.clone(), vec![none; 2 * rods.len()]);
        for (&(a, b, rest, slackens), number) in rods.iter().zip(0..) {
            for (from, to) in [(a, b), (b, a)] {
                let place = &mut next[from as usize];
                all[*place as usize] = RodEnd { to, number, rest, slackens };
                *place += 1;
            }
        }
        Self { first, rods: all }
    }

    /// The same, but where several rods connect the same two particles, all of them have the length and the number of the shortest.
    pub(super) fn shortest(particles: usize, rods: &[(u32, u32, f32, bool)]) -> Self {
        let Self { first, mut rods } = Self::new(particles, rods);
        let mut beside = vec![NONE; first.len()];
        for (particle, ends) in (0..).zip(first.windows(2)) {
            let own = &mut rods[ends[0] as usize..ends[1] as usize];
            let several = own.iter().fold(false, |several, rod| {
                several | (core::mem::replace(&mut beside[rod.to as usize], particle) == particle)
            });
            if !several {
                continue;
            }
            for place in 0..own.len() {
                let to = own[place].to;
                let between = own.iter().filter(|rod| rod.to == to);
                let shortest = between.copied().reduce(|a, b| if b.rest < a.rest { b } else { a });
                own[place] = shortest.unwrap_or(own[place]);
            }
        }
        Self { first, rods }
    }

    /// Number of particles.
    pub(super) fn particles(&self) -> usize {
        self.first.len() - 1
    }

    /// Number of rod ends, two for each rod.
    pub(super) fn ends(&self) -> usize {
        self.rods.len()
    }

    /// The rods at a particle.
    pub(super) fn rods_of(&self, particle: u32) -> &[RodEnd] {
        let at = particle as usize;
        &self.rods[self.first[at] as usize..self.first[at + 1] as usize]
    }

    /// For each particle a hash of its rods, independent of their order: two graphs differ at the particles with different hashes.
    pub(super) fn hashes(&self) -> Vec<u64> {
        let hash = |rod: &RodEnd| {
            let ends = u64::from(rod.rest.to_bits()) << 32 | u64::from(rod.to);
            let word = ends.wrapping_mul(0x9E37_79B9_7F4A_7C15);
            (word ^ word >> 32).wrapping_mul(0xD6E8_FEB8_6659_FD93)
        };
        let rods = (0..self.particles() as u32).map(|particle| self.rods_of(particle));
        rods.map(|own| own.iter().map(hash).fold(own.len() as u64, u64::wrapping_add)).collect()
    }
}
