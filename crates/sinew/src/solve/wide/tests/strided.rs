//! Compliant distances in columns, strided or loose, move as the scalar kernel moves them, with any instruction set and whichever lanes are empty.

use super::super::{LooseDistances, sweep_loose};
use super::*;
use crate::lanes::Columns;
use crate::solve::rods::Rods;

/// Distances of one colour from some rows to those a stride farther on.
fn strided(from: impl Iterator<Item = u32>, stride: u32) -> Vec<Distance> {
    from.map(|a| Distance::new(a, a + stride, 0.8).with_compliance(3e-4)).collect()
}

/// Three sweeps in columns, with the largest correction of each. The first two rows belong to another cluster batch.
fn in_columns(state: &State, distances: &[Distance], set: InstructionSet) -> (State, [f32; 3]) {
    let (mut rods, mut loose) = (Rods::default(), LooseDistances::default());
    let (batches, left) = rods.add_soft_to_columns(distances, &(2..200));
    let blocks = loose.add(&left, false, 2);
    let (mut columns, mut state) = (Columns::default(), state.clone());
    let mut sums = vec![0.0; distances.len()];
    columns.reset(rods.half());
    columns.transpose_in(0, &state.now, set);
    let found = [(); 3].map(|()| {
        let (columns, how, batches) = (&mut columns, (CONTEXT, set), batches.clone());
        let (found, count) = rods.sweep_soft(columns, batches, (2, 0), &mut sums, how);
        assert_eq!(count + left.len(), distances.len());
        let sums = &mut sums[count..];
        found.max(sweep_loose(&loose, columns, blocks.clone(), 2, sums, CONTEXT, set))
    });
    columns.transpose_out(0, &mut state.now, set);
    (state, found)
}

#[test]
fn in_columns_they_move_as_one_by_one_to_the_bits_of_any_instructions() {
    let mut random = Random::new(7);
    let cases = [
        // Next neighbours but one in rows of 24, in both colours; the second with a gap.
        strided((2..190).filter(|a| a % 4 < 2 && a % 24 < 22), 2),
        strided((2..190).filter(|a| a % 4 > 1 && a % 24 < 22 && *a != 62), 2),
        // Two grid rows apart with every eighth missing; an odd stride.
        strided((2..50).filter(|a| a % 8 != 5), 48),
        strided(3..54, 51),
        // Strides too short for batches of their own.
        strided((2..190).filter(|a| a / 4 % 2 == 0), 4),
        strided((2..190).filter(|a| a / 6 % 2 == 1), 6),
    ];
    for distances in cases {
        let places: Vec<Vec3> = (0..200).map(|_| random.vector()).collect();
        let mut start = State::at(&places, distances.len(), &mut random);
        // Two with coincident ends, which have no direction.
        for d in [distances[0], distances[distances.len() - 1]] {
            start.now[d.b as usize] = start.now[d.a as usize].truncate().extend(1.5);
        }
        let (group, mut truth) = (Group::Distances(distances.clone()), start.clone());
        let errors = [(); 3].map(|()| truth.one_by_one(&group, CONTEXT));
        let (first, found) = in_columns(&start, &distances, InstructionSet::Scalar);
        for (one, other) in truth.now.iter().zip(&first.now) {
            assert!(one.abs_diff_eq(*other, 2e-6), "{one} {other}");
        }
        for (one, other) in errors.iter().zip(found) {
            assert!((one - other).abs() < 2e-6, "{one} {other}");
        }
        for set in SETS {
            let (own, own_found) = in_columns(&start, &distances, set);
            assert!(own.bits() == first.bits() && own_found == found, "{set:?}");
        }
    }
}
