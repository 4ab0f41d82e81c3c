//! The plan: distances sorted into colours, so that no two of a colour share a particle.
//!
//! In the order in which a game adds them, each constraint waits for the particle that the last one moved, and stiff cloth swept outwards
//! from its pins pumps up energy until it bursts. Colour by colour, neighbours in the plan are independent: a core overlaps them, and the
//! sweep has no direction. The price is one bit mask per particle while compiling.

use core::ops::Range;

use crate::constraints::{Bound, Distance};

/// The distances in solving order, and what a sweep needs beside them. Compiled when the topology changes; scratch, never saved.
#[derive(Clone, Debug, Default)]
pub(crate) struct Plan {
    /// The distances, colour after colour; within a colour in the order given.
    pub(crate) distances: Vec<Distance>,
    /// The multiplier that each distance has summed up in this substep.
    pub(crate) lambdas: Vec<f32>,
    /// The groups of `distances`: first what is soft or one-sided, then the hard rods, colour by colour: bones
    /// have the last word over the limits of their joints. The last colour may be the overflow:
    /// constraints that found no free colour.
    pub(crate) groups: Vec<Group>,
    /// How many rows it was compiled for.
    pub(crate) rows: usize,
    used: Vec<u64>,
    group_of: Vec<u8>,
}

/// Distances of one kind and one colour: no two share a particle, except in the overflow.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Group {
    /// Where they are in the plan.
    pub(crate) range: Range<usize>,
    /// Hard rods, which the shortest kernel serves.
    pub(crate) rods: bool,
}

/// The colour of what found no other: a particle in more than 64 constraints. Solved one after the other, which is always right.
const OVERFLOW: usize = 64;
/// Colours, the overflow included. What is no rod is numbered from 0, rods from here.
const COLOURS: usize = OVERFLOW + 1;
/// The group of a faulty distance.
const LEFT_OUT: u8 = u8::MAX;

impl Plan {
    /// Compiles the valid ones among `distances`, for `particles` rows. Linear in both; keeps its memory.
    ///
    /// Greedy colouring: each constraint takes the lowest colour that neither of its particles has used. The grid of a cloth needs 8 colours
    /// that way, a mesh some 13.
    pub(crate) fn compile(&mut self, distances: &[Distance], particles: usize) {
        self.rows = particles;
        self.used.clear();
        self.used.resize(particles, 0);
        self.group_of.clear();
        let mut counts = [0_usize; 2 * COLOURS];
        for distance in distances {
            if distance.fault(particles).is_some() {
                self.group_of.push(LEFT_OUT);
                continue;
            }
            let (a, b) = (distance.a as usize, distance.b as usize);
            let colour = (!(self.used[a] | self.used[b])).trailing_zeros() as usize;
            if colour < OVERFLOW {
                self.used[a] |= 1 << colour;
                self.used[b] |= 1 << colour;
            }
            let rod = distance.compliance == 0.0 && distance.bound == Bound::Equal;
            let group = if rod { COLOURS + colour } else { colour };
            counts[group] += 1;
            self.group_of.push(group as u8);
        }

        self.groups.clear();
        let mut next = [0_usize; 2 * COLOURS];
        let mut total = 0;
        for (group, count) in counts.iter().enumerate() {
            next[group] = total;
            if *count > 0 {
                let rods = group >= COLOURS;
                self.groups.push(Group { range: total..total + count, rods });
            }
            total += count;
        }
        self.distances.clear();
        self.distances.resize(total, Distance::new(0, 0, 0.0));
        for (distance, &group) in distances.iter().zip(&self.group_of) {
            if group != LEFT_OUT {
                self.distances[next[group as usize]] = *distance;
                next[group as usize] += 1;
            }
        }
        self.lambdas.clear();
        self.lambdas.resize(total, 0.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_distances_of_a_colour_share_a_particle_and_none_is_lost() {
        let mut distances = Vec::new();
        let (columns, rows) = (13, 9);
        let at = |c: u32, r: u32| r * columns + c;
        for r in 0..rows {
            for c in 0..columns {
                for (dc, dr) in [(1, 0), (0, 1), (1, 1), (2, 0)] {
                    if c + dc < columns && r + dr < rows {
                        distances.push(Distance::new(at(c, r), at(c + dc, r + dr), 1.0));
                    }
                }
            }
        }
        let mut plan = Plan::default();
        plan.compile(&distances, (columns * rows) as usize);
        assert_eq!(plan.distances.len(), distances.len());
        assert!(plan.groups.len() <= 16, "{}", plan.groups.len());
        for group in &plan.groups {
            let mut seen = std::collections::BTreeSet::new();
            for distance in &plan.distances[group.range.clone()] {
                assert!(seen.insert(distance.a) && seen.insert(distance.b));
            }
        }
    }

    #[test]
    fn a_hub_of_a_hundred_spokes_overflows_and_is_still_all_there() {
        let distances: Vec<_> = (1..=100).map(|i| Distance::new(0, i, 1.0)).collect();
        let mut plan = Plan::default();
        plan.compile(&distances, 101);
        assert_eq!(plan.distances.len(), 100);
        assert_eq!(plan.groups.len(), 65);
        assert_eq!(plan.groups.last().unwrap().range.len(), 36);
    }

    #[test]
    fn a_faulty_distance_is_left_out_and_the_rest_keeps_its_order() {
        let good = [Distance::new(0, 1, 1.0), Distance::new(2, 3, 2.0)];
        let bad = Distance::new(1, 1, 1.0);
        let (mut with, mut without) = (Plan::default(), Plan::default());
        with.compile(&[good[0], bad, good[1], Distance::new(0, 9, 1.0)], 4);
        without.compile(&good, 4);
        assert_eq!(with.distances, without.distances);
        assert_eq!(with.groups, without.groups);
    }
}
