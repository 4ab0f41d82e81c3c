//! Eight AABBs side by side: a box is compared with all of them at once.

use glam::Vec3;

use super::is_box;
use crate::lanes::{LANES, Lanes};

/// Up to eight boxes, metres. In an invalid or empty lane the least corner is +∞ and the greatest -∞, so that nothing overlaps it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EightBoxes {
    least: [[f32; LANES]; 3],
    most: [[f32; LANES]; 3],
}

impl EightBoxes {
    /// No boxes.
    pub(crate) const EMPTY: Self =
        Self { least: [[f32::INFINITY; LANES]; 3], most: [[f32::NEG_INFINITY; LANES]; 3] };

    /// Sets the box of a lane, and returns whether it is valid.
    #[inline(always)]
    pub(crate) fn set(&mut self, lane: usize, one: &(Vec3, Vec3)) -> bool {
        let valid = is_box(one);
        let (least, most) = if valid { *one } else { (Vec3::INFINITY, Vec3::NEG_INFINITY) };
        for axis in 0..3 {
            self.least[axis][lane] = least[axis];
            self.most[axis][lane] = most[axis];
        }
        valid
    }

    /// Least and greatest corner of the box in a lane.
    #[inline(always)]
    pub(crate) fn lane(&self, lane: usize) -> [[f32; 3]; 2] {
        let [x, y, z] = &self.least;
        let [to_x, to_y, to_z] = &self.most;
        [[x[lane], y[lane], z[lane]], [to_x[lane], to_y[lane], to_z[lane]]]
    }

    /// The union of all.
    pub(crate) fn bounds(&self) -> (Vec3, Vec3) {
        let least = self.least.map(|of_axis| of_axis.into_iter().fold(f32::INFINITY, f32::min));
        let most = self.most.map(|of_axis| of_axis.into_iter().fold(f32::NEG_INFINITY, f32::max));
        (least.into(), most.into())
    }

    /// A bit for each of the boxes that a box (least and greatest corner) overlaps or touches.
    #[inline(always)]
    pub(crate) fn overlapping<L: Lanes>(&self, [least, most]: [[f32; 3]; 2]) -> u32 {
        let mut apart = L::zero();
        for axis in 0..3 {
            let (own_least, own_most) = (L::load(&self.least[axis]), L::load(&self.most[axis]));
            apart = apart.or(own_most.lt(L::splat(least[axis])));
            apart = apart.or(L::splat(most[axis]).lt(own_least));
        }
        !apart.bits() & ((1 << LANES) - 1)
    }
}
