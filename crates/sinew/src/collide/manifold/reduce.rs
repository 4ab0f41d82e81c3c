//! Of many points of contact, the four that hold as well: a solver's work is proportional to their number.

use glam::Vec3;

use super::{Manifold, Point};

/// Numbers of points, four at most.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Chosen {
    list: [usize; 4],
    len: usize,
}

impl Chosen {
    fn push(&mut self, i: usize) {
        self.list[self.len] = i;
        self.len += 1;
    }

    pub(super) fn as_slice(&self) -> &[usize] {
        &self.list[..self.len]
    }
}

/// How steeply what is above the deepest point may rise from there and yet come down before the two are compared again: until then two of which one
/// leans by two degrees on the other's rim turn by no more than that, rad (`body_contact::normal_solve`).
const LOW: f32 = 5e-3;
/// What lengths count that lead to points above that. Of a box that leans by three degrees on another one both ends of the low edge must be there, or
/// it rocks from the one to the other for ever; but two points so near each other that they are as good as one are no better for being low.
const HIGH: f32 = 0.25;

/// Chooses among `count` points those within reach; of more than four: the deepest, the one farthest from it, and on both sides of the line between
/// them the one that spans the largest triangle with it; rather those that may come down soon ([`LOW`]). Of equals the first.
#[inline(always)]
pub(super) fn choose(
    count: usize,
    reach: f32,
    normal: Vec3,
    distance: impl Fn(usize) -> f32,
    place: impl Fn(usize) -> Vec3,
) -> Chosen {
    let (mut chosen, mut within) = (Chosen::default(), 0);
    let (mut least, mut deepest) = (f32::INFINITY, 0);
    for i in 0..count {
        let d = distance(i);
        if d > reach {
            continue;
        }
        if within < 4 {
            chosen.push(i);
        }
        within += 1;
        if d < least {
            (least, deepest) = (d, i);
        }
    }
    if within <= 4 {
        return chosen;
    }
    let origin = place(deepest);
    let share = |i: usize, squared: f32| {
        let rise = distance(i) - least;
        if rise * rise <= LOW * LOW * squared { 1.0 } else { HIGH }
    };
    let (mut most, mut farthest) = (0.0, deepest);
    for i in 0..count {
        let squared = (place(i) - origin).length_squared();
        let length = squared.sqrt() * share(i, squared);
        if length > most && distance(i) <= reach {
            (most, farthest) = (length, i);
        }
    }
    chosen = Chosen::default();
    chosen.push(deepest);
    if farthest == deepest {
        return chosen;
    }
    chosen.push(farthest);
    let across = normal.cross(place(farthest) - origin);
    // What spans less than a millionth of a square with the line adds nothing to it.
    let flat = 1e-6 * most * most;
    let (mut sides, mut ends) = ([-flat, flat], [deepest; 2]);
    for i in 0..count {
        let out = place(i) - origin;
        let area = across.dot(out) * share(i, out.length_squared());
        if distance(i) > reach {
            continue;
        }
        if area < sides[0] {
            (sides[0], ends[0]) = (area, i);
        }
        if area > sides[1] {
            (sides[1], ends[1]) = (area, i);
        }
    }
    for end in ends {
        if end != deepest {
            chosen.push(end);
        }
    }
    chosen
}

/// A manifold of those of some points that [`choose`] chooses.
pub(super) fn reduced(normal: Vec3, reach: f32, points: &[Point]) -> Manifold {
    let chosen = choose(points.len(), reach, normal, |i| points[i].distance, |i| points[i].on_b);
    let mut manifold = Manifold::new(normal);
    for &i in chosen.as_slice() {
        manifold.push(points[i]);
    }
    manifold
}
