//! Rotations of rigid states: a quaternion, and the part of it that `f32` drops in a step.

use super::turn::{LaneArray, Matrix};
use crate::lanes::{Lanes, Vector};

/// Eight rotations in memory.
#[derive(Clone, Debug, Default)]
pub(super) struct WideRotation {
    pub(super) whole: [LaneArray; 4],
    pub(super) remainder: [LaneArray; 4],
}

/// A rotation in each lane: a quaternion of nearly unit length, and the part of it that `f32` has dropped in this step.
#[derive(Clone, Copy)]
pub(super) struct Rotation<L> {
    pub(super) whole: [L; 4],
    pub(super) remainder: [L; 4],
}

impl<L: Lanes> Rotation<L> {
    #[inline(always)]
    pub(super) fn load(from: &WideRotation) -> Self {
        Self { whole: load_four(&from.whole), remainder: load_four(&from.remainder) }
    }

    #[inline(always)]
    pub(super) fn store(self, to: &mut WideRotation) {
        store_four(self.whole, &mut to.whole);
        store_four(self.remainder, &mut to.remainder);
    }

    /// Followed, in its own frame, by the turn of the unit quaternion `(v, w)`, `w` not negative. The length is kept.
    #[inline(always)]
    pub(super) fn further(self, v: Vector<L>, w: L) -> Self {
        let [x, y, z, s] = self.whole;
        let axis = Vector::new(x, y, z);
        // w - 1, for which `w` itself has too few digits.
        let less = -v.length_squared() / (L::splat(1.0) + w);
        let by = v * s + axis * less + axis.cross(v);
        let by = [by.x, by.y, by.z, s * less - axis.dot(v)];
        let mut next = self;
        for (i, by) in by.into_iter().enumerate() {
            let (before, step) = (next.whole[i], by + next.remainder[i]);
            next.whole[i] = before + step;
            next.remainder[i] = step - (next.whole[i] - before);
        }
        next
    }

    /// Turned further by a few roundings, stored in the remainder; `half` is half of the turn, radians, in world axes.
    #[inline(always)]
    pub(super) fn nudged(self, half: Vector<L>) -> Self {
        let [x, y, z, s] = self.whole;
        let axis = Vector::new(x, y, z);
        let by = half * s + half.cross(axis);
        let [a, b, c, d] = self.remainder;
        let remainder = [a + by.x, b + by.y, c + by.z, d - half.dot(axis)];
        Self { remainder, ..self }
    }

    /// The turn of the remainder, in world axes, radians.
    #[inline(always)]
    pub(super) fn nudge(&self) -> Vector<L> {
        let ([x, y, z, s], [a, b, c, d]) = (self.whole, self.remainder);
        let (axis, by) = (Vector::new(x, y, z), Vector::new(a, b, c));
        (by * s - axis * d + axis.cross(by)) * L::splat(2.0)
    }

    #[inline(always)]
    pub(super) fn matrix(&self) -> Matrix<L> {
        Matrix::of(self.whole)
    }

    /// This rotation where the mask is set, elsewhere the other.
    #[inline(always)]
    pub(super) fn or_else(self, mask: L, other: Self) -> Self {
        let mut one = self;
        for i in 0..4 {
            one.whole[i] = mask.select(self.whole[i], other.whole[i]);
            one.remainder[i] = mask.select(self.remainder[i], other.remainder[i]);
        }
        one
    }
}

#[inline(always)]
pub(super) fn load_four<L: Lanes>(from: &[LaneArray; 4]) -> [L; 4] {
    [L::load(&from[0]), L::load(&from[1]), L::load(&from[2]), L::load(&from[3])]
}

#[inline(always)]
pub(super) fn store_four<L: Lanes>(from: [L; 4], to: &mut [LaneArray; 4]) {
    from[0].store(&mut to[0]);
    from[1].store(&mut to[1]);
    from[2].store(&mut to[2]);
    from[3].store(&mut to[3]);
}
