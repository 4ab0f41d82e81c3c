//! The point of an edge or a triangle at which it meets a shape, and the motion of that point.
//!
//! By alternating projections (von Neumann): from a point of the feature to the nearest one of the shape, from there to the nearest one of the feature, and so
//! on. For convex sets that are apart the distance falls with each and tends to the least one. Along an edge that is nearly parallel to one of the shape it falls
//! slowly, and is bisected. The point is sought where the feature is now; or, if the shape is in the surface by now, where the substep began. On its way from
//! there it is stopped as any particle is, on the side that it came from.
//!
//! Where the nearest point of a triangle is on its side, or that of an edge at its end, the side or the particle is in contact and not the inside.

use glam::{Vec3, Vec4};

use super::distance::{to_segment, to_triangle};
use super::shape::{Kind, Nearest, Shape, ShapeTouch};
use crate::particles::{Particles, Places};

/// Alternating projections for a point of a triangle. Two or three are mostly enough.
const PROJECTIONS: usize = 4;

/// Most points of an edge whose distance is measured.
const EDGE_ROUNDS: usize = 7;

/// Share of the thickness by which the distance would change from one end of an edge to the other, up to which a point counts as the nearest one. If it were
/// much less, the nearest point of an edge that lies on another would wander between their ends from substep to substep.
const LEVEL: f32 = 0.25;

/// A point whose weight for a corner is below this is on the opposite side, and no point of the inside.
const ON_SIDE: f32 = 1e-3;

/// How far a blunt shape presses in between the corners of a feature, at the most, as a share of the thickness.
pub(super) const BLUNT: f32 = 0.6;

/// A point of a particle, an edge or a triangle: the weighted mean of some rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SurfacePoint {
    /// Of a particle or an edge the last one is repeated, and has the weight 0.
    rows: [u32; 3],
    weights: [f32; 3],
}

/// A plane in the frame of a shape that has all of the shape behind it.
#[derive(Clone, Copy, Debug)]
pub(super) struct SupportPlane {
    /// Unit vector out of the shape, or zero if no plane has been found yet.
    pub(super) normal: Vec3,
    /// Its distance from the origin of that frame, metres.
    pub(super) offset: f32,
}

impl Default for SupportPlane {
    fn default() -> Self {
        Self { normal: Vec3::ZERO, offset: f32::INFINITY }
    }
}

impl SupportPlane {
    /// Distance of the nearest of three points from it, metres; less than that by as much as rounding may be.
    #[inline]
    pub(super) fn distance(&self, points: [Vec3; 3]) -> f32 {
        let [a, b, c] = each(points, |point| self.normal.dot(point));
        let least = a.min(b).min(c);
        let distance = least - self.offset;
        distance - 1e-5 * (least.abs() + self.offset.abs() + distance.abs())
    }

    /// Whether all of these points are farther than `distance` metres in front of it.
    #[inline]
    fn is_behind(&self, points: [Vec3; 3], distance: f32) -> bool {
        self.distance(points) > distance
    }
}

/// The face of a box through which a feature has the shortest way out, or from which it is farthest away. That of a single point of it may be another: a thread
/// across a plate does not get out of it through a side.
fn way_out(half_size: Vec3, corners: [Vec3; 3]) -> SupportPlane {
    let mut least = (f32::INFINITY, SupportPlane::default());
    for axis in 0..3 {
        let [a, b, c] = each(corners, |corner| corner[axis]);
        let half = half_size[axis];
        for (sign, lowest) in [(1.0, a.min(b).min(c)), (-1.0, -a.max(b).max(c))] {
            if half - lowest < least.0 {
                let mut normal = Vec3::ZERO;
                normal[axis] = sign;
                least = (half - lowest, SupportPlane { normal, offset: half });
            }
        }
    }
    least.1
}

/// Motion of a point in a substep, from an origin in the world.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfacePath {
    /// Metres, in the world.
    pub(super) origin: Vec3,
    /// Where it was when the substep began, metres.
    pub(super) start: Vec3,
    /// `[x y z w]`: where it is, metres, and its inverse mass, 1/kg.
    pub(super) now: Vec4,
}

impl SurfacePoint {
    /// The rows with a weight, and their weights.
    pub(super) fn shares(&self) -> impl Iterator<Item = (u32, f32)> {
        self.rows.into_iter().zip(self.weights).filter(|&(_, weight)| weight > 0.0)
    }

    /// The whole of a particle.
    pub(super) fn particle(row: u32) -> Self {
        Self { rows: [row; 3], weights: [1.0, 0.0, 0.0] }
    }

    #[inline]
    pub(super) fn is_particle(&self) -> bool {
        self.rows[0] == self.rows[1]
    }

    /// The middle of a feature with corners in these rows. Of an edge the last one is repeated.
    pub(super) fn middle_of(rows: [u32; 3]) -> Self {
        let weights = if rows[1] == rows[2] { [0.5, 0.5, 0.0] } else { [1.0 / 3.0; 3] };
        Self { rows, weights }
    }

    /// The middle of its feature.
    pub(super) fn middle(self) -> Self {
        if self.is_particle() { self } else { Self::middle_of(self.rows) }
    }

    /// The rows of its corners.
    pub(super) fn rows(&self) -> impl Iterator<Item = u32> + use<> {
        let Self { rows, .. } = *self;
        let [a, b, c] = rows;
        rows.into_iter().take(if a == b { 1 } else { 2 + usize::from(b != c) })
    }

    /// By this particles come before edges, and edges before triangles.
    pub(super) fn order(&self) -> (usize, [u32; 3]) {
        (self.rows().count(), self.rows)
    }

    /// The row with the first corner: positions of the point are relative to its origin.
    pub(super) fn first(&self) -> u32 {
        self.rows[0]
    }

    /// The row with the greatest weight.
    pub(super) fn main_row(&self) -> u32 {
        let [a, b, c] = self.weights;
        let greatest = if a >= b && a >= c { 0 } else { 1 + usize::from(c > b) };
        self.rows[greatest]
    }

    /// Its corners in a column of positions that begins with the row `begin`, from the origin of the first of them, metres.
    pub(super) fn corners(&self, column: &[Vec4], origin: &[Vec3], begin: u32) -> [Vec3; 3] {
        let at = |row: u32| row.wrapping_sub(begin) as usize;
        let home = origin[at(self.rows[0])];
        each(self.rows, |row| column[at(row)].truncate() + (origin[at(row)] - home))
    }

    /// The same point of some corners.
    pub(super) fn of(&self, corners: [Vec3; 3]) -> Vec3 {
        corners[0] * self.weights[0] + corners[1] * self.weights[1] + corners[2] * self.weights[2]
    }

    /// How far it keeps from shapes, metres, if it has moved by `moved` metres past one in this substep: the radius of a particle. A feature keeps to what a
    /// blunt shape leaves of the radius, so that one that is left out for that is no deeper than one that collides; and what is fast is stopped earlier.
    pub(super) fn thickness(&self, radius: f32, moved: f32) -> f32 {
        if self.is_particle() { radius } else { radius.min((1.0 - BLUNT) * radius + moved) }
    }

    /// Radius of the particles, averaged there, metres, from a column of radii that begins with the row `begin`.
    #[inline]
    pub(super) fn radius(&self, radius: &[f32], begin: u32) -> f32 {
        let [a, b, c] = each(self.rows, |row| radius[row.wrapping_sub(begin) as usize]);
        let [of_a, of_b, of_c] = self.weights;
        a * of_a + b * of_b + c * of_c
    }

    /// Its motion in this substep.
    #[inline]
    pub(super) fn path(&self, particles: &Particles) -> SurfacePath {
        let Particles { position, start, origin, .. } = particles;
        let first = self.rows[0] as usize;
        if self.is_particle() {
            let start = start[first].truncate();
            return SurfacePath { origin: origin[first], start, now: position[first] };
        }
        let w = self.inverse_mass_of(each(self.rows, |row| position[row as usize].w));
        SurfacePath {
            origin: origin[first],
            start: self.of(self.corners(start, origin, 0)),
            now: self.of(self.corners(position, origin, 0)).extend(w),
        }
    }

    /// The motion of each corner in this substep.
    #[inline]
    pub(super) fn corner_paths(&self, particles: &Particles) -> [SurfacePath; 3] {
        let of = |row: u32| Self::particle(row).path(particles);
        let [a, b, c] = self.rows;
        let (first, second) = (of(a), of(b));
        [first, second, if b == c { second } else { of(c) }]
    }

    /// Its velocity, m/s.
    pub(super) fn velocity(&self, particles: &Particles) -> Vec3 {
        if self.is_particle() {
            return particles.velocity(self.rows[0] as usize);
        }
        self.shares().map(|(row, weight)| particles.velocity(row as usize) * weight).sum()
    }

    /// Applies an impulse in N·s to the velocity of the point.
    pub(super) fn apply_impact(&self, particles: &mut Particles, impulse: Vec3) {
        for (row, weight) in self.shares() {
            let i = row as usize;
            particles.velocity[i] += (impulse * (weight * particles.position[i].w)).extend(0.0);
        }
    }

    /// Inverse mass, 1/kg.
    pub(super) fn inverse_mass(&self, places: &Places) -> f32 {
        self.inverse_mass_of(each(self.rows, |row| places.position[places.at(row)].w))
    }

    /// The same, from those of its corners.
    #[inline(always)]
    fn inverse_mass_of(&self, [a, b, c]: [f32; 3]) -> f32 {
        let [of_a, of_b, of_c] = self.weights;
        of_a * of_a * a + of_b * of_b * b + of_c * of_c * c
    }

    /// Displaces the point by the impulse `impulse`, in kg m.
    pub(super) fn apply_impulse(&self, places: &mut Places, impulse: Vec3) {
        for (row, weight) in self.shares() {
            let w = places.position[places.at(row)].w;
            places.displace(row, impulse * (weight * w));
        }
    }

    /// Displaces the point by a distance in metres that is no velocity: where the substep began is displaced as well. The point must not be pinned.
    pub(super) fn shift(&self, places: &mut Places, by: Vec3) {
        let impulse = by / self.inverse_mass(places);
        for (row, weight) in self.shares() {
            let i = places.at(row);
            let by = (impulse * (weight * places.position[i].w)).extend(0.0);
            places.position[i] += by;
            places.start[i] += by;
        }
    }

    /// Moves the point to that one of its feature which is nearest to a shape, in whose frame the corners are given, where a substep began and where they are
    /// now. Returns whether it is inside of the feature and not on a side, and near enough to touch. `plane` becomes one between the two, which spares the
    /// search as long as they stay apart.
    pub(super) fn approach(
        &mut self,
        (shape, plane): (&Shape, &mut SupportPlane),
        [start, now]: [[Vec3; 3]; 2],
        radius: f32,
    ) -> bool {
        let moved = greatest(each([0, 1, 2], |k| start[k].distance_squared(now[k]))).sqrt();
        let thickness = self.thickness(radius, moved);
        if plane.is_behind(start, thickness) && plane.is_behind(now, thickness) {
            return false;
        }
        if !start.iter().chain(&now).all(|corner| corner.is_finite()) {
            return false;
        }
        let (began, reach) = (self.weights, thickness + moved);
        match self.descend((shape, plane), now, (thickness, reach)) {
            None => return false,
            Some(distance) if distance <= 0.0 => {
                // By now the shape is in the surface.
                self.weights = began;
                self.descend((shape, plane), start, (thickness, f32::INFINITY));
            }
            Some(_) => {}
        }
        let may_touch = !(plane.is_behind(start, thickness) && plane.is_behind(now, thickness));
        may_touch && self.is_inside()
    }

    /// How far the corners of a feature may move from where a plane was found, metres, before it could touch what is behind: at these corners, and with this
    /// radius. They have moved by twice that in a substep then, which adds to its [thickness](Self::thickness) until that is the radius.
    pub(super) fn free_way(plane: &SupportPlane, corners: [Vec3; 3], radius: f32) -> f32 {
        let distance = plane.distance(corners);
        (distance - radius).max((distance - (1.0 - BLUNT) * radius) / 3.0)
    }

    /// Moves the point to the nearest one of its feature as a step begins, in the frame of the shape, unless that is on a side: from there it may get anywhere.
    /// Returns a plane between the two.
    pub(super) fn begin(&mut self, shape: &Shape, corners: [Vec3; 3], radius: f32) -> SupportPlane {
        let (mut nearest, mut plane) = (*self, SupportPlane::default());
        let thickness = self.thickness(radius, 0.0);
        nearest.descend((shape, &mut plane), corners, (thickness, f32::INFINITY));
        if nearest.is_inside() {
            *self = nearest;
        }
        plane
    }

    /// Contact with a collider of the point at these weights of the corners, which move from `start` to `now`: as that of a particle ([`Shape::touch`]), except that
    /// out of a box it takes the shortest way for the whole of its feature, where the substep began. Not for bodies that fall into cloth: it is wrapped around
    /// them then, and the shortest way may be past the body.
    pub(super) fn touch_collider(
        &self,
        shape: &Shape,
        [start, now]: [[Vec3; 3]; 2],
        thickness: f32,
    ) -> Option<ShapeTouch> {
        let (from, to) = (self.of(start), self.of(now));
        if let Kind::Box { half_size } = shape.kind()
            && to.abs().cmplt(half_size).all()
        {
            let SupportPlane { normal, offset } = way_out(half_size, start);
            return ShapeTouch::new(normal, thickness + offset - normal.dot(to));
        }
        shape.touch(from, to, thickness)
    }

    /// Whether it is inside of its feature, and not on a side.
    fn is_inside(&self) -> bool {
        let [a, b, c] = self.weights;
        a > ON_SIDE && b > ON_SIDE && (c > ON_SIDE || self.rows[1] == self.rows[2])
    }

    /// Moves the point to where its feature is nearest to the shape, or deepest in it. Returns its distance from the shape there or close by, metres, negative
    /// inside of it; `None` if no point of the feature is within `reach`.
    fn descend(
        &mut self,
        (shape, plane): (&Shape, &mut SupportPlane),
        corners: [Vec3; 3],
        (thickness, reach): (f32, f32),
    ) -> Option<f32> {
        let first = Self::measure(shape, self.of(corners));
        *plane = first.plane();
        // No point of the feature is nearer by more than its extent.
        let extent = || greatest(each(corners, |corner| corner.distance_squared(first.at)));
        let is_far = || first.distance - extent().sqrt() > reach;
        if first.distance > reach && is_far() {
            return None;
        }
        let best = if self.rows[1] == self.rows[2] {
            self.descend_edge(shape, first, corners, thickness)
        } else {
            self.descend_triangle(shape, first, corners, thickness)
        };
        *plane = best.plane();
        Some(best.distance)
    }

    /// Along an edge the distance is convex, and its slope says on which side the least one is. Alternating projections are soon there, unless the edge is nearly
    /// parallel to one of the shape: after two of them the interval that is left is bisected.
    fn descend_edge(
        &mut self,
        shape: &Shape,
        first: Measured,
        corners: [Vec3; 3],
        thickness: f32,
    ) -> Measured {
        let along = corners[1] - corners[0];
        let (mut t, mut low, mut high) = (self.weights[1], 0.0, 1.0);
        let (mut best, mut now) = ((t, first), first);
        for round in 1..EDGE_ROUNDS {
            let slope = now.normal.dot(along);
            if slope.abs() <= LEVEL * thickness {
                break;
            }
            if slope > 0.0 {
                high = t;
            } else {
                low = t;
            }
            let ends = [corners[0].as_dvec3(), corners[1].as_dvec3()];
            let projected = to_segment(now.toward(thickness).as_dvec3(), ends) as f32;
            let projected = projected.clamp(low, high);
            t = if round <= 2 { projected } else { 0.5 * (low + high) };
            now = Self::measure(shape, corners[0] + along * t);
            if now.distance < best.1.distance {
                best = (t, now);
            }
        }
        self.weights = [1.0 - best.0, best.0, 0.0];
        best.1
    }

    /// Alternating projections.
    fn descend_triangle(
        &mut self,
        shape: &Shape,
        first: Measured,
        corners: [Vec3; 3],
        thickness: f32,
    ) -> Measured {
        let mut now = first;
        for round in 1..=PROJECTIONS {
            let toward = now.toward(thickness).as_dvec3();
            let weights = to_triangle(toward, each(corners, Vec3::as_dvec3));
            let weights = each(weights, |one| one as f32);
            let moved = greatest(each([0, 1, 2], |k| (weights[k] - self.weights[k]).abs()));
            self.weights = weights;
            if moved < ON_SIDE || round == PROJECTIONS {
                break;
            }
            now = Self::measure(shape, self.of(corners));
        }
        now
    }

    /// The distance of a point from a shape.
    fn measure(shape: &Shape, at: Vec3) -> Measured {
        let nearest = shape.nearest(at);
        let Nearest { point, distance, .. } = nearest;
        let normal = if distance > 0.0 { (at - point) / distance } else { nearest.normal };
        Measured { at, point, normal, distance }
    }
}

/// The distance of a point from a shape, in its frame.
#[derive(Clone, Copy)]
struct Measured {
    at: Vec3,
    /// The nearest point on the surface of the shape, metres.
    point: Vec3,
    /// Unit vector out of the shape.
    normal: Vec3,
    /// Metres, negative inside of it.
    distance: f32,
}

impl Measured {
    /// The support plane there.
    fn plane(&self) -> SupportPlane {
        SupportPlane { normal: self.normal, offset: self.normal.dot(self.point) }
    }

    /// What the point is to be projected from. From the inside of the shape the way to its surface leads out of it: the deepest point is the other way.
    fn toward(&self, thickness: f32) -> Vec3 {
        if self.distance > 0.0 { self.point } else { self.at - self.normal * thickness }
    }
}

/// A function of each corner. `array::map` is a call for each of them, which took half of the time.
#[inline(always)]
pub(super) fn each<T, U>([a, b, c]: [T; 3], mut of: impl FnMut(T) -> U) -> [U; 3] {
    [of(a), of(b), of(c)]
}

/// The greatest of three.
#[inline(always)]
pub(super) fn greatest([a, b, c]: [f32; 3]) -> f32 {
    a.max(b).max(c)
}
