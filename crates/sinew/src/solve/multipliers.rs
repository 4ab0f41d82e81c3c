//! The accumulated Lagrange multipliers of compliant constraints in a substep. Kept apart from the plan, so that threads that share the plan each write their
//! own.

use core::ops::Range;

/// The multipliers of consecutive distances and of consecutive constraints of a plan.
pub(crate) struct MultiplierSlice<'a> {
    /// Numbers in the plan of the first distance and the first constraint.
    first_distance: usize,
    first_constraint: usize,
    distances: &'a mut [f32],
    constraints: &'a mut [f32],
}

/// All multipliers of a plan.
#[derive(Clone, Debug, Default)]
pub(crate) struct Multipliers {
    distances: Vec<f32>,
    constraints: Vec<f32>,
}

impl Multipliers {
    /// Resizes to the numbers of distances and constraints.
    pub(crate) fn resize(&mut self, distances: usize, constraints: usize) {
        self.distances.resize(distances, 0.0);
        self.constraints.resize(constraints, 0.0);
    }

    /// All of them.
    pub(crate) fn all(&mut self) -> MultiplierSlice<'_> {
        MultiplierSlice {
            first_distance: 0,
            first_constraint: 0,
            distances: &mut self.distances,
            constraints: &mut self.constraints,
        }
    }
}

impl<'a> MultiplierSlice<'a> {
    /// The multiplier of distance number `i` of the plan.
    #[inline]
    pub(crate) fn distance(&mut self, i: usize) -> &mut f32 {
        &mut self.distances[i - self.first_distance]
    }

    /// The multiplier of constraint number `i` of the plan.
    #[inline]
    pub(crate) fn constraint(&mut self, i: usize) -> &mut f32 {
        &mut self.constraints[i - self.first_constraint]
    }

    /// The multipliers of several distances.
    #[inline]
    pub(crate) fn of_distances(&mut self, range: Range<usize>) -> &mut [f32] {
        &mut self.distances[range.start - self.first_distance..range.end - self.first_distance]
    }

    /// The multipliers of several constraints.
    #[inline]
    pub(crate) fn of_constraints(&mut self, range: Range<usize>) -> &mut [f32] {
        &mut self.constraints
            [range.start - self.first_constraint..range.end - self.first_constraint]
    }

    /// Splits before the distance and the constraint of these numbers. `None` leaves all of a list in the second part.
    pub(crate) fn split(self, distance: Option<usize>, constraint: Option<usize>) -> (Self, Self) {
        let distance = distance.unwrap_or(self.first_distance);
        let constraint = constraint.unwrap_or(self.first_constraint);
        let (distances, more) = self.distances.split_at_mut(distance - self.first_distance);
        let (constraints, others) =
            self.constraints.split_at_mut(constraint - self.first_constraint);
        let rest = MultiplierSlice {
            first_distance: distance,
            first_constraint: constraint,
            distances: more,
            constraints: others,
        };
        (MultiplierSlice { distances, constraints, ..self }, rest)
    }

    /// Reborrows the slice.
    pub(crate) fn reborrow(&mut self) -> MultiplierSlice<'_> {
        MultiplierSlice { distances: self.distances, constraints: self.constraints, ..*self }
    }
}
