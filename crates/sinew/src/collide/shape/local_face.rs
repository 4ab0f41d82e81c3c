//! The face of a surface that is all a sphere can meet while it stays near a place.
//!
//! A sphere against triangles ([`surface`](super::surface)) takes a search, crossings in double precision, and rounds until no triangle is left in between. Yet a
//! particle that lies on a terrain stays over one triangle for a whole step. So when a step begins, the triangle nearest to each particle is found, with what has
//! to hold for this one to be met and no other. In a substep these are a few products, for eight particles side by side.
//!
//! # Conditions
//!
//! Let `T` be the triangle nearest to the place `c`, with its unit normal `n` on the side of `c`; and let a sphere of radius `R` move from `p` to `q`, both within a
//! distance of `c` that is known when the step begins.
//!
//! 1. `p` is in front of the plane of `T`, and both are within the three planes through its edges. So if the path crosses that plane, it crosses `T`.
//! 2. A triangle within reach of the sphere that is nowhere in front of the plane of `T` is neither met before `T` nor nearer than it.
//! 3. Any other within reach is a *wall*. Its plane has `c`, `p` and `q` in front, `q` is no nearer to it than to the plane of `T`, and the place where the sphere is
//!    put keeps `R` from it.
//!
//! Then the contact is the one with the plane of `T`, of the depth `R - n·(q - a)` with a vertex `a` of it. Where a condition does not hold, the surface is searched as
//! before.

use glam::Vec3;

use super::ShapeTouch;
use super::surface::{CLEAR, SpherePath, Surface};
use super::triangle::{Feature, Triangle};
use crate::lanes::{LANES, LaneArray, Lanes, Number, Vector};

/// What a sphere may meet while its centre stays within a distance of a place.
pub(crate) enum Reachable {
    /// Nothing.
    Nothing,
    /// The face, as long as its conditions hold.
    Face(LocalFace),
    /// Several faces, or what is no face.
    Several,
}

/// The face that a sphere may meet. Positions are relative to `corner`, metres.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LocalFaceOf<N> {
    /// The first vertex of the triangle, in the frame of the shape.
    corner: Vector<N>,
    /// Unit normal of the triangle, on the side of the sphere.
    normal: Vector<N>,
    /// The conditions hold for centres within the distance whose square this is, m², of this place.
    centre: Vector<N>,
    square: N,
    /// Radius of the sphere, or what it keeps if that is less.
    reach: N,
    /// Unit vectors inwards from its edges. The first and the last edge begin and end at `corner`; the second is at `opposite` along its vector.
    sides: [Vector<N>; 3],
    opposite: N,
    /// What centres keep from its edges.
    margin: N,
    /// Unit normals of the walls, and where their planes are along them.
    walls: [(Vector<N>, N); WALLS],
}

/// The face of a single sphere.
pub(crate) type LocalFace = LocalFaceOf<f32>;

/// Those of eight spheres.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct LaneFaces([LaneArray; NUMBERS]);

/// Contacts of a sphere, or of eight, in the common case of a rule.
pub(crate) struct SphereTouches<N> {
    pub(crate) normal: Vector<N>,
    /// Penetration depth, metres.
    pub(crate) depth: N,
    /// Mask: whether it touches.
    pub(crate) touching: N,
    /// Mask: whether it is the common case; if not, the rest means nothing.
    pub(crate) certain: N,
}

/// Walls of a face. Where a terrain is concave at two edges of a triangle, it has two.
const WALLS: usize = 2;

/// Vectors in a [`LocalFaceOf`] apart from walls; where its other numbers begin; and how many numbers it has.
const VECTORS: usize = 6;
const OTHERS: usize = 3 * (VECTORS + WALLS);
const NUMBERS: usize = OTHERS + 4 + WALLS;

/// Triangles that are looked at around a place, at the most. Where there are more, they are so small beside the way of a step that a sphere does not stay over one.
const MOST: usize = 24;

/// Walls whose normals differ by less than this are one, as the two triangles of a flat cell are.
const PARALLEL: f32 = 1e-6;

/// What a sphere of radius `reach` may meet while its centre stays within `way` metres of `at`. A centre keeps `skin` metres from the surface at least.
pub(super) fn reachable(
    surface: &impl Surface,
    at: Vec3,
    (way, reach, skin): (f32, f32, f32),
) -> Reachable {
    // Where the sphere is put is as much farther away as it is too deep at first.
    let radius = way + 2.0 * reach;
    if !(at.is_finite() && radius.is_finite() && surface.is_away_from_rim(at, radius)) {
        return Reachable::Several;
    }
    let mut found = smallvec::SmallVec::<[(f32, Feature, Triangle); MOST]>::new();
    let mut many = false;
    surface.visit(&SpherePath::new(at, at, radius), &mut |_, triangle| {
        if many {
            return;
        }
        let close = triangle.closest(at);
        if close.square <= radius * radius {
            many = found.len() == MOST;
            if !many {
                found.push((close.square.sqrt(), close.feature, *triangle));
            }
        }
    });
    if many {
        return Reachable::Several;
    }
    let nearest = (0..found.len()).min_by(|&i, &k| found[i].0.total_cmp(&found[k].0));
    let nearest = nearest.filter(|&i| found[i].0 <= way + reach + skin);
    let Some(nearest) = nearest else {
        let inside = surface.front_only() && surface.is_inside(at, None);
        return if inside { Reachable::Several } else { Reachable::Nothing };
    };
    let (distance, feature, face) = found[nearest];
    let far = way + reach + (reach - distance).max(0.0) + skin;
    let others = found.iter().enumerate().filter(|&(i, other)| i != nearest && other.0 <= far);
    let others = others.map(|(_, (.., triangle))| triangle);
    let face = if feature == Feature::Face {
        face_at(&face, others, (at, surface.front_only()), (way, reach, 0.25 * skin))
    } else {
        None
    };
    face.map_or(Reachable::Several, Reachable::Face)
}

/// The conditions for a face, if there is room for all of them. Heights up to `tolerance` metres are rounding.
fn face_at<'a>(
    face: &Triangle,
    others: impl Iterator<Item = &'a Triangle>,
    (at, front_only): (Vec3, bool),
    (way, reach, tolerance): (f32, f32, f32),
) -> Option<LocalFace> {
    let [a, b, c] = face.corners;
    let in_front = face.normal.dot(at - a) >= 0.0;
    if !in_front && front_only {
        return None;
    }
    let normal = if in_front { face.normal } else { -face.normal };
    let side = |edge: Vec3| face.normal.cross(edge).try_normalize();
    let sides = [side(b - a)?, side(c - b)?, side(a - c)?];
    let everywhere = (Vector::zero(), f32::NEG_INFINITY);
    let mut walls = [everywhere; WALLS];
    let mut count = 0;
    for other in others {
        let heights = other.corners.into_iter().map(|corner| normal.dot(corner - a));
        if heights.fold(f32::NEG_INFINITY, f32::max) <= tolerance {
            continue;
        }
        let toward = other.normal.dot(at - other.corners[0]) >= 0.0;
        let along = if toward { other.normal } else { -other.normal };
        let offset = along.dot(other.corners[0] - a);
        let same = |wall: &&mut (Vector<f32>, f32)| {
            Vec3::from(wall.0).distance_squared(along) < PARALLEL * PARALLEL
        };
        if let Some(wall) = walls[..count].iter_mut().find(same) {
            wall.1 = wall.1.max(offset);
            continue;
        }
        *walls.get_mut(count)? = (along.into(), offset);
        count += 1;
    }
    Some(LocalFaceOf {
        corner: a.into(),
        normal: normal.into(),
        centre: (at - a).into(),
        square: way * way,
        reach,
        opposite: sides[1].dot(b - a),
        sides: [sides[0].into(), sides[1].into(), sides[2].into()],
        margin: tolerance,
        walls,
    })
}

impl<N: Number> LocalFaceOf<N> {
    /// Contacts of spheres whose centres move from `from` to `to`, in the frame of the shape.
    #[inline(always)]
    pub(crate) fn touch(&self, from: Vector<N>, to: Vector<N>) -> SphereTouches<N> {
        let (from, to) = (from - self.corner, to - self.corner);
        let height = self.normal.dot(to);
        let depth = self.reach - height;
        let placed = to + self.normal * depth.max(N::zero());
        let mut certain = N::zero().le(self.normal.dot(from));
        for end in [from, to] {
            let [first, second, third] = self.sides;
            let within = (end - self.centre).length_squared().le(self.square);
            let over = self.margin.le(first.dot(end)).and(self.margin.le(third.dot(end)));
            let over = over.and((self.opposite + self.margin).le(second.dot(end)));
            certain = certain.and(within).and(over);
        }
        let (kept, least) = (self.reach * N::splat(CLEAR), height.max(N::zero()));
        for (wall, offset) in self.walls {
            let in_front = offset.le(wall.dot(from)).and((offset + least).le(wall.dot(to)));
            certain = certain.and(in_front).and((offset + kept).le(wall.dot(placed)));
        }
        let touching = height.lt(kept);
        SphereTouches { normal: self.normal, depth, touching, certain }
    }
}

impl LocalFace {
    /// The contact of a single sphere, or `None` without one; `None` if the conditions do not hold.
    #[inline]
    pub(crate) fn touch_one(&self, from: Vec3, to: Vec3) -> Option<Option<ShapeTouch>> {
        let found = self.touch(from.into(), to.into());
        let touch = || ShapeTouch::new(found.normal.into(), found.depth);
        found.certain.any().then(|| if found.touching.any() { touch() } else { None })
    }
}

impl LaneFaces {
    /// Eight faces; of fewer, the last one is repeated.
    pub(crate) fn of<'a>(faces: impl Iterator<Item = &'a LocalFace>) -> Self {
        let mut lanes = Self([[0.0; LANES]; NUMBERS]);
        let mut put = |lane: usize, numbers: [f32; NUMBERS]| {
            lanes.0.iter_mut().zip(numbers).for_each(|(to, number)| to[lane] = number);
        };
        let (mut lane, mut last) = (0, [0.0; NUMBERS]);
        for face in faces.take(LANES) {
            last = face.numbers();
            put(lane, last);
            lane += 1;
        }
        (lane..LANES).for_each(|lane| put(lane, last));
        lanes
    }

    /// Loads them.
    #[inline(always)]
    pub(crate) fn load<L: Lanes>(&self) -> LocalFaceOf<L> {
        let mut numbers = [L::zero(); NUMBERS];
        for (number, lanes) in numbers.iter_mut().zip(&self.0) {
            *number = L::load(lanes);
        }
        LocalFaceOf::from_numbers(&numbers)
    }
}

impl<N: Copy> LocalFaceOf<N> {
    /// All of its numbers: vectors, those of the walls last, then the rest.
    fn numbers(&self) -> [N; NUMBERS] {
        let Self { corner, normal, centre, sides: [first, second, third], walls, .. } = self;
        let vectors = [corner, normal, centre, first, second, third].into_iter();
        let vectors = vectors.chain(walls.iter().map(|(wall, _)| wall));
        let others = [self.square, self.reach, self.opposite, self.margin].into_iter();
        let others = others.chain(walls.iter().map(|&(_, offset)| offset));
        let mut all = [self.square; NUMBERS];
        let numbers = vectors.flat_map(|v| [v.x, v.y, v.z]).chain(others);
        all.iter_mut().zip(numbers).for_each(|(to, number)| *to = number);
        all
    }

    /// From these.
    #[inline(always)]
    fn from_numbers(all: &[N; NUMBERS]) -> Self {
        let mut walls = [(vector(all, VECTORS), all[OTHERS + 4]); WALLS];
        for (i, wall) in walls.iter_mut().enumerate() {
            *wall = (vector(all, VECTORS + i), all[OTHERS + 4 + i]);
        }
        Self {
            corner: vector(all, 0),
            normal: vector(all, 1),
            centre: vector(all, 2),
            sides: [vector(all, 3), vector(all, 4), vector(all, 5)],
            walls,
            square: all[OTHERS],
            reach: all[OTHERS + 1],
            opposite: all[OTHERS + 2],
            margin: all[OTHERS + 3],
        }
    }
}

/// The vector with a number among the first of these.
#[inline(always)]
fn vector<N: Copy>(all: &[N; NUMBERS], number: usize) -> Vector<N> {
    let first = 3 * number;
    Vector { x: all[first], y: all[first + 1], z: all[first + 2] }
}
