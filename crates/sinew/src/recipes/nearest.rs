//! Nearest-point queries by a k-d tree, so that a mesh with tens of thousands of stray vertices is still processed quickly.

use glam::{DVec3, Vec3};

/// Points sorted so that the middle one of every slice splits it in two along its widest axis.
pub(super) struct NearestSearch<'a> {
    points: &'a [Vec3],
    /// Bounding box of all points.
    bounds: [Vec3; 2],
    order: Vec<u32>,
    /// For each place in `order`, the axis along which its point splits.
    axes: Vec<u8>,
}

impl<'a> NearestSearch<'a> {
    /// Sorts finite points, at least one; O(n log n).
    pub(super) fn new(points: &'a [Vec3]) -> Self {
        let mut tree = Self {
            points,
            bounds: bounds(points.iter().copied()),
            order: (0..points.len() as u32).collect(),
            axes: vec![0; points.len()],
        };
        split(points, &mut tree.order, &mut tree.axes);
        tree
    }

    /// Index of the nearest point; the first of equally near ones. 0 if there are no points.
    pub(super) fn find(&self, target: Vec3) -> u32 {
        let mut best = (f64::INFINITY, 0);
        let [low, high] = self.bounds;
        let outside = target.as_dvec3() - target.max(low).min(high).as_dvec3();
        self.search(target.as_dvec3(), (0, self.order.len()), outside, &mut best);
        best.1
    }

    /// Searches a slice of `order` whose points are at least as far from the target as `outside` on each axis.
    fn search(
        &self,
        target: DVec3,
        (from, to): (usize, usize),
        outside: DVec3,
        best: &mut (f64, u32),
    ) {
        if from == to {
            return;
        }
        let middle = from.midpoint(to);
        let index = self.order[middle];
        let away = target - self.points[index as usize].as_dvec3();
        let found = (away.length_squared(), index);
        if found < *best {
            *best = found;
        }
        let axis = usize::from(self.axes[middle]);
        let (below, above) = ((from, middle), (middle + 1, to));
        let (near, far) = if away[axis] < 0.0 { (below, above) } else { (above, below) };
        self.search(target, near, outside, best);
        let mut beyond = outside;
        beyond[axis] = away[axis];
        if beyond.length_squared() <= best.0 {
            self.search(target, far, beyond, best);
        }
    }
}

fn split(points: &[Vec3], order: &mut [u32], axes: &mut [u8]) {
    if order.len() < 2 {
        return;
    }
    let at = |i: u32| points[i as usize];
    let [low, high] = bounds(order.iter().map(|&i| at(i)));
    let axis = (high.as_dvec3() - low.as_dvec3()).max_position();
    let middle = order.len() / 2;
    order.select_nth_unstable_by(middle, |&i, &j| at(i)[axis].total_cmp(&at(j)[axis]));
    axes[middle] = axis as u8;
    split(points, &mut order[..middle], &mut axes[..middle]);
    split(points, &mut order[middle + 1..], &mut axes[middle + 1..]);
}

/// The lowest and the highest coordinates.
pub(super) fn bounds(points: impl Iterator<Item = Vec3>) -> [Vec3; 2] {
    let none = [Vec3::INFINITY, Vec3::NEG_INFINITY];
    points.fold(none, |[low, high], p| [low.min(p), high.max(p)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_random::Random;

    #[test]
    fn the_tree_finds_what_looking_at_all_points_finds() {
        let mut random = Random::new(7);
        // 32 values an axis, so that many points tie.
        let mut value = || random.below(32) as f32;
        let mut point = || Vec3::new(value(), value(), 0.25 * value());
        let points: Vec<Vec3> = (0..500).map(|_| point()).collect();
        let tree = NearestSearch::new(&points);
        for _ in 0..500 {
            let target = 2.0 * point() - 16.0; // inside and outside
            let away = |i: &u32| (points[*i as usize] - target).length_squared();
            let expected = (0..500).min_by(|a, b| away(a).total_cmp(&away(b)));
            assert_eq!(Some(tree.find(target)), expected);
        }
    }
}
