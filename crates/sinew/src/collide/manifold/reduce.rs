//! Reduces many contact points to four that support a body as well: the solver's cost is proportional to the number of points.

use glam::Vec3;
use smallvec::SmallVec;

use super::{Manifold, Point};
use crate::lanes::{Number, Vector};

/// Greatest slope from the deepest point to a higher one at which the higher one may still come into contact before the next narrow phase. Until then, two
/// bodies of which one leans by two degrees on the rim of the other turn by no more than this, rad (`TURNED` and `STEEP` of `body_contact::contact_cache`).
const LOW_SLOPE: f32 = 5e-3;
/// Weight of the distance to points above that slope. If a box leans on another by three degrees, both ends of the low edge must be kept, or it rocks from one
/// to the other for ever. But of two points so close together that either would do, the lower one is not the better choice.
const HIGH_WEIGHT: f32 = 0.25;

/// Selects among points those within reach and leaves their masks in `chosen`. If there are more than four: the deepest, the one farthest from it, and on each
/// side of the line between them the one that spans the largest triangle with it, with points that may soon come into contact preferred ([`LOW_SLOPE`]). The
/// first of equals is taken.
#[inline(always)]
pub(super) fn choose<N: Number>(
    places: &[Vector<N>],
    distances: &[N],
    normal: Vector<N>,
    reach: N,
    chosen: &mut [N],
) {
    let (zero, one) = (N::zero(), N::splat(1.0));
    let (mut count, mut least, mut deepest) = (zero, N::splat(f32::INFINITY), zero);
    let mut origin = normal;
    for i in 0..places.len() {
        chosen[i] = chosen[i].and(distances[i].le(reach));
        count = count + chosen[i].and(one);
        let less = chosen[i].and(distances[i].lt(least));
        least = less.select(distances[i], least);
        deepest = less.select(N::splat(i as f32), deepest);
        origin = places[i].or_else(less, origin);
    }
    let many = N::splat(4.0).lt(count);
    if !many.any() {
        return;
    }
    // Squared lengths. `flat` below: a point that spans less than a millionth of the square of the line adds no area.
    let (mut most, mut farthest, mut line) = (zero, deepest, Vector::new(zero, zero, zero));
    for i in 0..places.len() {
        let out = places[i] - origin;
        let squared = out.length_squared();
        let weight = length_weight(distances[i] - least, squared);
        let length = squared * weight * weight;
        let more = chosen[i].and(most.lt(length));
        most = more.select(length, most);
        farthest = more.select(N::splat(i as f32), farthest);
        line = out.or_else(more, line);
    }
    let across = normal.cross(line);
    let flat = most * N::splat(1e-6);
    let (mut sides, mut ends) = ([-flat, flat], [deepest; 2]);
    for i in 0..places.len() {
        let out = places[i] - origin;
        let area = across.dot(out) * length_weight(distances[i] - least, out.length_squared());
        let beyond = [chosen[i].and(area.lt(sides[0])), chosen[i].and(sides[1].lt(area))];
        for side in 0..2 {
            sides[side] = beyond[side].select(area, sides[side]);
            ends[side] = beyond[side].select(N::splat(i as f32), ends[side]);
        }
    }
    for (i, chosen) in chosen.iter_mut().enumerate() {
        let i = N::splat(i as f32);
        let spans = i.same(ends[0]).or(i.same(ends[1]));
        let best = i.same(deepest).or(i.same(farthest)).or(spans);
        *chosen = many.select(best, *chosen);
    }
}

/// Weight of the distance to a point that is `rise` metres above the deepest one; `squared` is that distance squared, metres².
#[inline(always)]
fn length_weight<N: Number>(rise: N, squared: N) -> N {
    (rise * rise)
        .le(squared * N::splat(LOW_SLOPE * LOW_SLOPE))
        .select(N::splat(1.0), N::splat(HIGH_WEIGHT))
}

/// A manifold of the points that [`choose`] selects.
pub(super) fn reduced(normal: Vec3, reach: f32, points: &[Point]) -> Manifold {
    let mut manifold = Manifold::new(normal);
    if points.len() <= manifold.points.len() {
        let within = points.iter().filter(|point| point.distance <= reach);
        within.for_each(|point| manifold.push(*point));
        return manifold;
    }
    let mut places: SmallVec<[Vector<f32>; 17]> = SmallVec::new();
    places.extend(points.iter().map(|point| Vector::splat(point.on_b)));
    let distances: SmallVec<[f32; 17]> = points.iter().map(|point| point.distance).collect();
    let mut chosen: SmallVec<[f32; 17]> = distances.iter().map(|d| d.same(*d)).collect();
    choose(&places, &distances, Vector::splat(normal), reach, &mut chosen);
    for (point, _) in points.iter().zip(&chosen).filter(|(_, chosen)| chosen.any()) {
        manifold.push(*point);
    }
    manifold
}
