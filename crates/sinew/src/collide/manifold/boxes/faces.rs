//! Face clipping of two boxes: one face is a rectangle, and the opposing face of the other box, projected onto it, is a parallelogram. The contact area is what
//! they have in common. Eight pairs in SIMD lanes.
//!
//! The common area has at most eight corners, of three kinds: where a side of the parallelogram enters the rectangle, or begins inside it; where it leaves it,
//! or ends; and the rectangle's corners inside the parallelogram. So each of four sides is clipped to the rectangle (Cyrus, Beck 1978; Liang, Barsky 1984), and
//! each of four corners is tested. That is twelve candidates without a branch, which suits SIMD. A side is its middle and `s e`, with `e` half of it and `s`
//! from 1 to -1; it is within `|x| ≤ h` for `|s + x/eₓ| ≤ h/|eₓ|`.
//!
//! # Points on the rim
//!
//! A box squarely on another of its size has sides on the rim and corners on corners. Rectangle and parallelogram are both enlarged slightly ([`ROUNDING`]), so
//! that these points count as inside despite rounding: such a point may be found twice, but is never lost. [`choose`] reduces more than four points to some
//! that span an area, which two at the same place do not.

use super::super::reduce::choose;
use super::super::{Manifold, Point};
use super::axes::{LoadedPairs, WideAxes};
use crate::lanes::{LANES, LaneArray, Lanes, SetLanes, Vector, get};

/// Enlargement of a face as a share of its size: a few rounding errors.
const ROUNDING: f32 = 2e-6;
/// Least extent of a side along an axis of the rectangle, as a share of the rectangle's size, to be divided by: a side of less is parallel to the rim.
const ALONG: f32 = 1e-7;
/// A point closer to the rim of a face than this share of its size counts as clipped there.
const RIM: f32 = 1e-4;

/// Number of candidates for corners of the common area, and of points kept.
const PLACES: usize = 12;
const POINTS: usize = 4;

/// Face manifolds of eight pairs.
pub(super) struct WideManifolds {
    normal: [LaneArray; 3],
    on_a: [[LaneArray; 3]; POINTS],
    on_b: [[LaneArray; 3]; POINTS],
    distance: [LaneArray; POINTS],
    slope: LaneArray,
    len: [u32; LANES],
    /// The least distance of the points, metres; infinite without points.
    pub(super) nearest: LaneArray,
}

impl WideManifolds {
    /// The manifold of a lane.
    #[inline(always)]
    pub(super) fn of(&self, lane: usize) -> Manifold {
        let mut manifold = Manifold::new(get(&self.normal, lane));
        for (n, point) in manifold.points.iter_mut().enumerate() {
            let (on_a, on_b) = (get(&self.on_a[n], lane), get(&self.on_b[n], lane));
            *point = Point { on_a, on_b, distance: self.distance[n][lane] };
        }
        manifold.len = self.len[lane];
        manifold.slope = self.slope[lane];
        manifold
    }
}

/// An axis index per lane: 0, 1 or 2.
#[derive(Clone, Copy)]
struct Axis<L> {
    is_second: L,
    is_third: L,
}

impl<L: Lanes> Axis<L> {
    /// The component along the axis, then those along the two next axes.
    #[inline(always)]
    fn of(self, [x, y, z]: [L; 3]) -> [L; 3] {
        [self.pick(x, y, z), self.pick(y, z, x), self.pick(z, x, y)]
    }

    /// The inverse of [`of`](Self::of).
    #[inline(always)]
    fn back(self, [own, next, last]: [L; 3]) -> [L; 3] {
        [self.pick(own, last, next), self.pick(next, own, last), self.pick(last, next, own)]
    }

    #[inline(always)]
    fn pick(self, first: L, second: L, third: L) -> L {
        self.is_third.select(third, self.is_second.select(second, first))
    }
}

/// Clips the best faces of eight pairs: up to four points each.
#[inline(always)]
pub(super) fn clip<L: Lanes>(pairs: &LoadedPairs<L>, axes: &WideAxes<L>) -> WideManifolds {
    let (zero, one) = (L::zero(), L::splat(1.0));
    let is_b = axes.face.lt(L::splat(3.0));
    let number = is_b.select(axes.face, axes.face - L::splat(3.0));
    let axis = Axis { is_second: number.same(one), is_third: number.same(one + one) };
    // The box with the reference face, and the other box in its coordinates: half sizes, axes by component, centre.
    let LoadedPairs { ha, hb, c, t, along, reach } = *pairs;
    let (h, k) = (choice(is_b, hb, ha), choice(is_b, ha, hb));
    let t = choice(is_b, t, [-along[0], -along[1], -along[2]]);
    let rows = [
        choice(is_b, [c[0][0], c[1][0], c[2][0]], c[0]),
        choice(is_b, [c[0][1], c[1][1], c[2][1]], c[1]),
        choice(is_b, [c[0][2], c[1][2], c[2][2]], c[2]),
    ];
    // By the axis across the face, then the two along it.
    let [up, x, y] = transposed(axis, rows);
    let [height, rim_x, rim_y] = axis.of(h);
    let [t_up, t_x, t_y] = axis.of(t);
    let side = t_up.lt(zero).select(-one, one);
    let centre = Vector::new(t_x, t_y, side * t_up - height);
    // The other box's most opposed face.
    let is_second = up[0].abs().lt(up[1].abs());
    let is_third = is_second.select(up[1], up[0]).abs().lt(up[2].abs());
    let other = Axis { is_second, is_third };
    let ([k0, k1, k2], up_by) = (other.of(k), other.of(up));
    let (x_by, y_by) = (other.of(x), other.of(y));
    let towards = (up_by[0] * side).lt(zero).select(-k0, k0);
    let middle = centre - Vector::new(x_by[0], y_by[0], side * up_by[0]) * towards;
    let sides = [
        Vector::new(x_by[1], y_by[1], side * up_by[1]) * k1,
        Vector::new(x_by[2], y_by[2], side * up_by[2]) * k2,
    ];
    let (places, mut chosen) = common_corners(middle, sides, [rim_x, rim_y]);
    let mut heights = [zero; PLACES];
    for i in 0..PLACES {
        heights[i] = places[i].z;
        chosen[i] = axes.past.select(zero, axes.near.and(chosen[i]));
    }
    choose(&places, &heights, Vector::new(zero, zero, one), reach, &mut chosen);
    let mut lowest = Vector::new(zero, zero, L::splat(f32::INFINITY));
    for i in 0..PLACES {
        let lower = chosen[i].and(places[i].z.lt(lowest.z));
        lowest = places[i].or_else(lower, lowest);
    }
    let most = L::splat(1.0 - RIM);
    let is_at = (rim_x * most).lt(lowest.x.abs()).or((rim_y * most).lt(lowest.y.abs()));
    let is_any = lowest.z.lt(L::splat(f32::INFINITY));
    let slope = (one - up_by[0] * up_by[0]).max(zero).sqrt();
    let (slots, there, len) = in_slots(&places, &chosen);
    let mut found = WideManifolds {
        normal: [[0.0; LANES]; 3],
        on_a: [[[0.0; LANES]; 3]; POINTS],
        on_b: [[[0.0; LANES]; 3]; POINTS],
        distance: [[0.0; LANES]; POINTS],
        slope: is_any.and(is_at).and(slope).array(),
        len,
        nearest: lowest.z.array(),
    };
    let across = axis.back([side, zero, zero]);
    for i in 0..3 {
        is_b.select(across[i], -side * up[i]).store(&mut found.normal[i]);
    }
    for n in 0..POINTS {
        let (p, there) = (slots[n], L::mask(there[n]));
        let from = p - centre;
        let on_face = axis.back([side * height, p.x, p.y]);
        for j in 0..3 {
            let on_other = x[j] * from.x + y[j] * from.y + side * up[j] * from.z;
            let (on_a, on_b) =
                (is_b.select(on_other, on_face[j]), is_b.select(on_face[j], on_other));
            there.and(on_a).store(&mut found.on_a[n][j]);
            there.and(on_b).store(&mut found.on_b[n][j]);
        }
        there.and(p.z).store(&mut found.distance[n]);
    }
    found
}

/// `one` where the mask is set, else `other`.
#[inline(always)]
fn choice<L: Lanes>(mask: L, one: [L; 3], other: [L; 3]) -> [L; 3] {
    [mask.select(one[0], other[0]), mask.select(one[1], other[1]), mask.select(one[2], other[2])]
}

/// Rows of a matrix permuted by [`Axis::of`], as columns.
#[inline(always)]
fn transposed<L: Lanes>(axis: Axis<L>, rows: [[L; 3]; 3]) -> [[L; 3]; 3] {
    let mut by = rows;
    for j in 0..3 {
        let column = axis.of([rows[0][j], rows[1][j], rows[2][j]]);
        for i in 0..3 {
            by[i][j] = column[i];
        }
    }
    by
}

/// Compacts the chosen places; with a bit mask of the lanes that have so many, and the number in each lane.
#[inline(always)]
fn in_slots<L: Lanes>(
    places: &[Vector<L>; PLACES],
    chosen: &[L; PLACES],
) -> ([Vector<L>; POINTS], [u32; POINTS], [u32; LANES]) {
    let mut at = [[[0.0; LANES]; PLACES]; 3];
    let mut bits = [0; LANES];
    for i in 0..PLACES {
        places[i].x.store(&mut at[0][i]);
        places[i].y.store(&mut at[1][i]);
        places[i].z.store(&mut at[2][i]);
        for lane in SetLanes(chosen[i].bits()) {
            bits[lane] |= 1 << i;
        }
    }
    let mut slots = [[[0.0; LANES]; POINTS]; 3];
    let (mut there, mut len) = ([0; POINTS], [0; LANES]);
    for lane in 0..LANES {
        // At most four are chosen.
        for i in SetLanes(bits[lane]) {
            let n = len[lane] as usize % POINTS;
            for axis in 0..3 {
                slots[axis][n][lane] = at[axis][i][lane];
            }
            there[n] |= 1 << lane;
            len[lane] += 1;
        }
    }
    let mut found = [places[0]; POINTS];
    for n in 0..POINTS {
        let [x, y, z] = &slots;
        found[n] = Vector::new(L::load(&x[n]), L::load(&y[n]), L::load(&z[n]));
    }
    (found, there, len)
}

/// The corners of the common area of a rectangle about zero and a parallelogram, on the plane of the parallelogram, with masks of those that exist.
#[inline(always)]
fn common_corners<L: Lanes>(
    middle: Vector<L>,
    [e, f]: [Vector<L>; 2],
    rim: [L; 2],
) -> ([Vector<L>; PLACES], [L; PLACES]) {
    let (zero, one) = (L::zero(), L::splat(1.0));
    let mut places = [middle; PLACES];
    let mut there = [zero; PLACES];
    let by = [Inverse::of(e, rim), Inverse::of(f, rim)];
    // In order around: along `e` from 1 to -1, along `f`, and back.
    let bases = [middle + f, middle - e, middle - f, middle + e];
    let (mut from, mut to, mut inside) = ([one; 4], [one; 4], [zero; 4]);
    for k in 0..4 {
        let (first, last) = by[k % 2].within(bases[k], k > 1);
        (from[k], to[k]) = (first, last);
        inside[k] = last.le(first);
    }
    for k in 0..4 {
        let direction = if k % 2 == 0 { e } else { f };
        let direction = if k > 1 { -direction } else { direction };
        places[2 * k] = bases[k] + direction * from[k];
        places[2 * k + 1] = bases[k] + direction * to[k];
        // Where a side ends the next one begins, if any of that is inside.
        let next = inside[(k + 1) % 4];
        let is_cut = (-one).lt(to[k]).or(next.select(zero, inside[k]));
        there[2 * k] = inside[k];
        there[2 * k + 1] = inside[k].and(is_cut);
    }
    let turn = one / (e.x * f.y - e.y * f.x);
    let within = L::splat(1.0 + ROUNDING);
    for (k, [sx, sy]) in [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]].iter().enumerate() {
        let (x, y) = (rim[0] * L::splat(*sx), rim[1] * L::splat(*sy));
        let (qx, qy) = (x - middle.x, y - middle.y);
        let u = (qx * f.y - qy * f.x) * turn;
        let v = (e.x * qy - e.y * qx) * turn;
        places[8 + k] = Vector::new(x, y, middle.z + e.z * u + f.z * v);
        there[8 + k] = u.abs().lt(within).and(v.abs().lt(within));
    }
    (places, there)
}

/// The reciprocals of a side's extents along the axes of the rectangle, and the rectangle's half widths in units of the side.
#[derive(Clone, Copy)]
struct Inverse<L> {
    by: [L; 2],
    width: [L; 2],
}

impl<L: Lanes> Inverse<L> {
    #[inline(always)]
    fn of(side: Vector<L>, rim: [L; 2]) -> Self {
        let (mut by, mut width) = (rim, rim);
        let along = [side.x, side.y];
        for axis in 0..2 {
            let least = rim[axis] * L::splat(ALONG);
            let divisor = along[axis].abs().lt(least).select(least, along[axis]);
            by[axis] = L::splat(1.0) / divisor;
            width[axis] = rim[axis] * L::splat(1.0 + ROUNDING) * by[axis].abs();
        }
        Self { by, width }
    }

    /// The range of a side with middle `base` that is within the rectangle, from 1 down to -1; with the direction reversed if `back`. If none of it is inside,
    /// the end is greater than the beginning.
    #[inline(always)]
    fn within(&self, base: Vector<L>, back: bool) -> (L, L) {
        let one = L::splat(1.0);
        let (mut x, mut y) = (base.x * self.by[0], base.y * self.by[1]);
        if back {
            (x, y) = (-x, -y);
        }
        let from = one.min(self.width[0] - x).min(self.width[1] - y);
        let to = (-one).max(-self.width[0] - x).max(-self.width[1] - y);
        (from, to)
    }
}

#[cfg(test)]
mod tests {
    use core::f32::consts::FRAC_PI_4;

    use glam::{Vec2, Vec3};

    use super::super::super::tests::Random;
    use super::super::axes::three;
    use super::*;
    use crate::lanes::{InstructionSet, kernel, set};

    fn vector<L: Lanes>(from: &[LaneArray; 3]) -> Vector<L> {
        let [x, y, z] = three::<L>(from);
        Vector::new(x, y, z)
    }

    kernel!(
        fn corners<L: Lanes>(
            middle: &[LaneArray; 3],
            sides: &[[LaneArray; 3]; 2],
            rim: &[LaneArray; 2],
        ) -> Vec<Vec<Vec3>> {
            let sides = [vector::<L>(&sides[0]), vector::<L>(&sides[1])];
            let rim = [L::load(&rim[0]), L::load(&rim[1])];
            let (places, there) = common_corners(vector::<L>(middle), sides, rim);
            let mut found = vec![Vec::new(); LANES];
            for (place, there) in places.iter().zip(&there) {
                let (at, there) =
                    ([place.x.array(), place.y.array(), place.z.array()], there.bits());
                for (lane, found) in found.iter_mut().enumerate() {
                    if there >> lane & 1 == 1 {
                        found.push(get(&at, lane));
                    }
                }
            }
            found
        }
    );

    /// Sorted by angle about their middle.
    fn in_order(mut corners: Vec<Vec3>) -> Vec<Vec2> {
        let centre = corners.iter().sum::<Vec3>() / corners.len().max(1) as f32;
        corners.sort_by(|p, q| {
            let angle = |p: &Vec3| libm::atan2f(p.y - centre.y, p.x - centre.x);
            angle(p).total_cmp(&angle(q))
        });
        corners.into_iter().map(Vec3::truncate).collect()
    }

    fn area(c: &[Vec2]) -> f32 {
        (0..c.len()).map(|i| 0.5 * c[i].perp_dot(c[(i + 1) % c.len()])).sum()
    }

    /// Clips a polygon to a rectangle, one side after the other (Sutherland, Hodgman 1974).
    fn cut(mut polygon: Vec<Vec2>, rim: Vec2) -> Vec<Vec2> {
        for (axis, sign) in [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0)] {
            let inside = |p: Vec2| rim[axis] - sign * p[axis];
            let before = core::mem::take(&mut polygon);
            for (i, &q) in before.iter().enumerate() {
                let p = before[(i + before.len() - 1) % before.len()];
                let (at_p, at_q) = (inside(p), inside(q));
                if (at_p < 0.0) != (at_q < 0.0) {
                    polygon.push(p + (q - p) * (at_p / (at_p - at_q)));
                }
                if at_q >= 0.0 {
                    polygon.push(q);
                }
            }
        }
        polygon
    }

    /// Parallelograms at random, squarely on the rectangle, on its rim within rounding, and past it: the area is that of clipping to one side after the other,
    /// the corners lie within the rectangle and on the plane, and each instruction set gives the same bits.
    #[test]
    fn twelve_places_hold_the_corners_of_what_two_faces_share() {
        let mut random = Random::new(7);
        let (mut shared, mut apart) = (0, 0);
        for round in 0..2000 {
            let mut middle = [[0.0; LANES]; 3];
            let (mut sides, mut rims) = ([[[0.0; LANES]; 3]; 2], [[0.0; LANES]; 2]);
            let sizes = [(); LANES].map(|()| (random.vector() * 0.4 + Vec3::splat(0.6)).truncate());
            for (lane, rim) in sizes.into_iter().enumerate() {
                (rims[0][lane], rims[1][lane]) = (rim.x, rim.y);
                let angle = [0.0, 1e-7, 1e-6, 1e-4, FRAC_PI_4, 3.0 * random.number()][round % 6];
                let (s, c) = (libm::sinf(angle), libm::cosf(angle));
                let aligned = round / 6 % 3 == 0;
                let size = if aligned { rim } else { rim + random.vector().truncate() * 0.19 };
                let at = if aligned { Vec3::ZERO } else { random.vector() };
                set(&mut middle, lane, at);
                set(&mut sides[0], lane, Vec3::new(c, s, 0.3 * random.number()) * size.x);
                set(&mut sides[1], lane, Vec3::new(-s, c, 0.3 * random.number()) * size.y);
            }
            let found = corners(&middle, &sides, &rims, InstructionSet::best());
            for other in [InstructionSet::Scalar, InstructionSet::Simd128] {
                assert_eq!(found, corners(&middle, &sides, &rims, other));
            }
            for (lane, found) in found.into_iter().enumerate() {
                let (m, e, f) = (get(&middle, lane), get(&sides[0], lane), get(&sides[1], lane));
                let rim = sizes[lane];
                let up = e.cross(f);
                for p in &found {
                    assert!(p.truncate().abs().cmple(rim * 1.00001).all(), "{p} {rim}");
                    assert!((p - m).dot(up).abs() < 1e-4 * up.length(), "{p} is off its plane");
                }
                let quad = [m + e + f, m - e + f, m - e - f, m + e - f].map(Vec3::truncate);
                let expected = cut(quad.to_vec(), rim);
                let (own, wanted) = (area(&in_order(found)), area(&expected));
                shared += usize::from(wanted > 0.01);
                apart += usize::from(expected.is_empty());
                assert!((own - wanted).abs() < 2e-5, "round {round}: {own} instead of {wanted}");
            }
        }
        assert!(shared > 5000 && apart > 300, "{shared} {apart}");
    }
}
