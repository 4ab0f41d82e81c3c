//! Features: the edges and triangles of bodies that collide by their surface, against shapes.
//!
//! The particles of a surface collide with shapes as balls ([`particle_contact`](super::particle_contact), [`body_contact`](super::body_contact)). That is all
//! there is to do where a shape is blunt: a triangle whose corners are outside of a plane is outside of it. But an edge, a corner, a thin post or a small ball
//! fits in between. So an edge or a triangle collides by that one of its points which is nearest to the shape, as a particle of its own: the point `Σ βₖ xₖ` of
//! corners with the weights `β` has the inverse mass `Σ βₖ² wₖ`, and an impulse on it moves each corner by `βₖ wₖ` of it.
//!
//! # The nearest point
//!
//! By alternating projections (von Neumann): from a point of the feature to the nearest one of the shape, from there to the nearest one of the feature, and so
//! on. For convex sets that are apart the distance falls with each and tends to the least one. Along an edge that is nearly parallel to one of the shape it falls
//! slowly, and is bisected. The point is sought where the feature is now; or, if the shape is in the surface by now, where the substep began. On its way from
//! there it is stopped as any particle is, on the side that it came from.
//!
//! What is left out because a shape is blunt there must be no deeper in it than what collides, or it would jump when it is found: so features keep a part of the
//! thickness only. What is recovered of an old overlap is no velocity, for the same reason. A feature that is pinned in a shape is attached to it.
//!
//! Meshes and heightfields are not convex, and collide with the particles alone.
//!
//! Where the nearest point of a triangle is on its side, or that of an edge at its end, the side or the particle is in contact and not the inside.

use core::ops::Range;

use glam::{Vec3, Vec4};

use super::distance::{to_segment, to_triangle};
use super::filter::ContactFilter;
use super::frame::Frame;
use super::shape::{Kind, Nearest, Shape};
use crate::particles::{Particles, Places};
use crate::tracked::Tracked;

/// Alternating projections for a point of a triangle. Two or three are mostly enough.
const PROJECTIONS: usize = 4;

/// Most points of an edge whose distance is measured.
const EDGE_ROUNDS: usize = 7;

/// Share of the thickness by which the distance would change from one end of an edge to the other, up to which a point counts as the nearest one. If it were
/// much less, the nearest point of an edge that lies on another would wander between their ends from substep to substep.
const LEVEL: f32 = 0.25;

/// A point whose weight for a corner is below this is on the opposite side, and no point of the inside.
const ON_SIDE: f32 = 1e-3;

/// Slope of the distance along an edge, from one of its ends, from which on no other point of it becomes the nearest one within a step.
const STEEP: f32 = 0.3;

/// How far a blunt shape presses in between the corners of a feature, at the most, as a share of the thickness.
const BLUNT: f32 = 0.6;

/// An edge or a triangle: the rows of its corners, ascending. Of an edge the last one is listed twice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Feature([u32; 3]);

/// The features of all bodies that collide by their surface. Rebuilt where their triangles have changed.
#[derive(Clone, Debug, Default)]
pub(crate) struct Features {
    list: Vec<Feature>,
    /// For each body its range in the list, and a range of rows that all of its corners are in.
    of_body: Vec<Range<usize>>,
    rows_of: Vec<Range<u32>>,
    /// What the list was built for: the revision of the triangles, the body of each row, and whether each body collides by its surface.
    revision: Option<u64>,
    bodies: Vec<u32>,
    by_surface: Vec<bool>,
}

impl Feature {
    fn is_edge(self) -> bool {
        self.0[1] == self.0[2]
    }

    /// The rows of its corners.
    pub(super) fn rows(&self) -> &[u32] {
        &self.0[..if self.is_edge() { 2 } else { 3 }]
    }

    /// The middle of its corners.
    pub(super) fn middle(self) -> SurfacePoint {
        let weights = if self.is_edge() { [0.5, 0.5, 0.0] } else { [1.0 / 3.0; 3] };
        SurfacePoint { rows: self.0, weights }
    }
}

impl Features {
    /// Lists the features of the triangles of bodies that collide by their surface.
    pub(super) fn update(
        &mut self,
        surfaces: &Tracked<Vec<[u32; 3]>>,
        filter: &ContactFilter,
        particles: &Particles,
    ) {
        let by_surface = filter.bodies().iter().map(|body| body.surface && !body.disabled);
        if self.revision == Some(surfaces.revision())
            && self.bodies == particles.body
            && by_surface.clone().eq(self.by_surface.iter().copied())
        {
            return;
        }
        let Self { list, of_body, rows_of, revision, bodies, by_surface: known } = self;
        *revision = Some(surfaces.revision());
        bodies.clone_from(&particles.body);
        known.clear();
        known.extend(by_surface);
        list.clear();
        for corners in surfaces {
            let mut corners = *corners;
            corners.sort_unstable();
            let [a, b, c] = corners;
            let Some(body) = bodies.get(c as usize).filter(|_| a < b && b < c) else { continue };
            let is_one = bodies[a as usize] == *body && bodies[b as usize] == *body;
            if is_one && known.get(*body as usize) == Some(&true) {
                list.extend([[a, b, b], [b, c, c], [a, c, c], [a, b, c]].map(Feature));
            }
        }
        // Body by body, and edges before triangles.
        let body = |feature: &Feature| bodies[feature.0[0] as usize];
        list.sort_unstable_by_key(|feature| (body(feature), !feature.is_edge(), *feature));
        list.dedup();
        of_body.clear();
        of_body.resize(known.len(), 0..0);
        rows_of.clear();
        rows_of.resize(known.len(), 0..0);
        let mut begin = 0;
        for own in list.chunk_by(|one, next| body(one) == body(next)) {
            let number = body(&own[0]) as usize;
            of_body[number] = begin..begin + own.len();
            begin += own.len();
            let end = own.iter().map(|feature| feature.0[2] + 1).max().unwrap_or(0);
            rows_of[number] = own[0].0[0]..end;
        }
    }

    /// Whether no body has any.
    pub(super) fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Forgets all.
    pub(super) fn clear(&mut self) {
        self.list.clear();
        self.of_body.clear();
        self.rows_of.clear();
        self.revision = None;
    }

    /// The bodies that have features.
    pub(super) fn bodies(&self) -> impl Iterator<Item = u32> {
        (0..).zip(&self.of_body).filter(|(_, own)| !own.is_empty()).map(|(body, _)| body)
    }

    /// The first row of a body that has features.
    pub(super) fn first_row(&self, body: u32) -> u32 {
        self.rows_of[body as usize].start
    }

    /// The features of a body.
    fn of(&self, body: u32) -> &[Feature] {
        let range = self.of_body.get(body as usize).cloned().unwrap_or_default();
        &self.list[range]
    }
}

/// The radius with which a convex shape is rounded everywhere, metres: 0 if it has an edge. `None` for shapes that features do not collide with: those that only
/// have flat or hollow sides, and meshes and heightfields, to which there may be several nearest points.
pub(super) fn rounding(shape: &Shape) -> Option<f32> {
    match shape.kind() {
        Kind::HalfSpace | Kind::InsideBox | Kind::Mesh | Kind::HeightField => None,
        Kind::Sphere { radius } | Kind::Capsule { radius, .. } => Some(radius),
        Kind::Box { .. } | Kind::Cylinder { .. } | Kind::Hull(_) => Some(0.0),
    }
}

/// A shape beside which features are searched for, as a step begins.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShapeBeside<'a> {
    pub(super) shape: &'a Shape,
    /// AABB in the world over the step, metres.
    pub(super) bounds: (Vec3, Vec3),
    /// Its frame when the step begins, from an origin in the world.
    pub(super) frame: Frame,
    pub(super) origin: Vec3,
    /// How far a point of it may move in the step, metres, and how far it does if nothing flings it.
    pub(super) reach: Reach,
}

/// How far something may move in a step, metres, and how far it does if nothing flings it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reach {
    pub(super) most: f32,
    pub(super) likely: f32,
}

/// The corners of a body as a step begins, and what is known of them beside a shape. Scratch.
#[derive(Clone, Debug, Default)]
pub(super) struct Corners {
    /// Position of each row, metres in the world, and how far it may move.
    moving: Vec<(Vec3, Reach)>,
    /// AABB of their balls over the step, metres in the world; and the least radius, metres.
    bounds: (Vec3, Vec3),
    thickness: f32,
    /// The square of the longest edge, m², once it is needed.
    longest: Option<f32>,
    /// Of each row six bits for the sides of the shape's bounds that it stays beyond, and six for the sides of a box that it stays over.
    sides: Vec<u16>,
    /// Its distance from the shape, metres, and the direction of that, once they are needed.
    nearest: Vec<Option<(f32, Vec3)>>,
}

impl Features {
    /// Collects the corners of a body, which move as far as `reach` says.
    pub(super) fn collect(
        &self,
        body: u32,
        particles: &Particles,
        reach: impl Fn(u32) -> Reach,
        corners: &mut Corners,
    ) {
        let Corners { moving, bounds, thickness, longest, .. } = corners;
        moving.clear();
        (*thickness, *longest) = (f32::INFINITY, None);
        *bounds = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for row in self.rows_of[body as usize].clone() {
            let (i, reach) = (row as usize, reach(row));
            let at = particles.origin[i] + particles.position[i].truncate();
            let around = reach.most + particles.radius[i];
            *thickness = thickness.min(particles.radius[i]);
            *bounds = (bounds.0.min(at - around), bounds.1.max(at + around));
            moving.push((at, reach));
        }
    }

    /// Calls `found` with the features of a body that a shape may touch in this step between their [collected](Self::collect) corners.
    ///
    /// Left out is what stays away from the shape, what stays over one flat side of it, and features that it is blunt beside: it presses in so little between
    /// their corners that the surface itself stays outside. Between two points of a convex shape whose normals differ by the angle `δ` it is at most
    /// `½ l tan ½δ` higher than they are, `l` apart; a ball of radius `R` is `l²/8R` higher, and in the middle of an equilateral triangle `l²/6R`.
    ///
    /// Normals tell this from a distance, too: from the distance `d` of an edge or a corner of the shape they differ by `l/d`. So they are not used where a
    /// corner may come from so far that this is too little to be noticed.
    pub(super) fn find_beside(
        &self,
        body: u32,
        beside: &ShapeBeside,
        particles: &Particles,
        corners: &mut Corners,
        mut found: impl FnMut(Feature),
    ) {
        let ShapeBeside { shape, bounds, frame, origin, reach: carried } = *beside;
        let Corners { moving, bounds: own, thickness, longest, sides, nearest } = corners;
        if own.0.cmpgt(bounds.1).any() || own.1.cmplt(bounds.0).any() {
            return;
        }
        let Some(rounding) = rounding(shape) else { return };
        if rounding > 0.0 {
            let edges = || self.of(body).iter().take_while(|feature| feature.is_edge());
            let square = |edge: &Feature| {
                let [a, b, _] = edge.0.map(|row| row as usize);
                particles.separation(a, b).length_squared()
            };
            let longest = longest.get_or_insert_with(|| edges().map(square).fold(0.0, f32::max));
            if *longest <= 6.0 * BLUNT * rounding * *thickness {
                return;
            }
        }
        let first = self.rows_of[body as usize].start;
        let at = |row: u32| {
            let i = row as usize;
            frame.local(particles.position[i].truncate() + (particles.origin[i] - origin))
        };
        sides.clear();
        sides.extend((first..).zip(&*moving).map(|(row, &(place, reach))| {
            let around = reach.most + particles.radius[row as usize];
            let below = (place + around).cmplt(bounds.0).bitmask();
            let above = (place - around).cmpgt(bounds.1).bitmask();
            let is_far = below | above != 0;
            let reach = reach.most + carried.most;
            let over = if is_far { 0 } else { flat_sides(shape, at(row), reach) };
            (below | above << 3 | over << 6) as u16
        }));
        nearest.clear();
        nearest.resize(moving.len(), None);
        for &feature in self.of(body) {
            let corners = feature.0.map(|row| (row - first) as usize);
            if corners.iter().fold(!0, |all, &corner| all & sides[corner]) != 0 {
                continue;
            }
            let [a, b, c] = feature.0.map(&at);
            let longest =
                a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
            let thickness = feature.middle().radius(&particles.radius, 0);
            if longest <= 6.0 * BLUNT * rounding * thickness {
                continue;
            }
            let each = corners.map(|corner| moving[corner].1);
            let reach = each.iter().fold(0.0_f32, |most, one| most.max(one.most)) + carried.most;
            let likely = each.iter().fold(0.0_f32, |most, one| most.max(one.likely));
            let likely = likely + carried.likely;
            let near = [(corners[0], a), (corners[1], b), (corners[2], c)].map(|(corner, at)| {
                *nearest[corner].get_or_insert_with(|| {
                    let nearest = shape.nearest(at);
                    let direction =
                        if nearest.distance > 0.0 { at - nearest.point } else { nearest.normal };
                    (nearest.distance, direction.normalize_or(nearest.normal))
                })
            });
            // What is pinned in a shape is attached to it.
            let is_attached = |(&row, &(distance, _)): (&u32, &(f32, Vec3))| {
                let i = row as usize;
                particles.position[i].w == 0.0 && distance < particles.radius[i]
            };
            if feature.0.iter().zip(&near).any(is_attached) {
                continue;
            }
            let farthest = near.iter().fold(f32::MIN, |far, &(distance, _)| far.max(distance));
            // No point of the feature is nearer to the shape by more than its extent.
            if farthest - longest.sqrt() > reach + thickness {
                continue;
            }
            let lift = 4.0 * BLUNT * thickness;
            let normals = near.map(|(_, normal)| normal);
            if !(likely * lift <= longest && is_held(feature, [a, b, c], normals, lift)) {
                found(feature);
            }
        }
    }
}

/// Whether the corners of a feature, or its sides, keep all of it away from a convex shape, by the normals at the corners: to `¼ lift`, metres.
fn is_held(feature: Feature, [p, q, r]: [Vec3; 3], [a, b, c]: [Vec3; 3], lift: f32) -> bool {
    if feature.is_edge() {
        let along = q - p;
        let (length, slope) = (along.length(), STEEP * along.length());
        // It is nearest at an end where it leads away from there.
        return a.distance(b) * length <= lift || a.dot(along) > slope || b.dot(along) < -slope;
    }
    let longest = p.distance(q).max(q.distance(r)).max(r.distance(p));
    // Beside a straight edge of the shape the distance rises and falls along one line of the triangle only, so its nearest points reach to its sides.
    let plane = (q - p).cross(r - p).normalize_or_zero();
    let turned = |one: Vec3, other: Vec3| one.cross(other).dot(plane).abs();
    turned(a, b).max(turned(b, c)).max(turned(c, a)) * longest <= lift
}

/// Bits of the sides of a box that a point is over, and stays over wherever it moves by `reach` metres along them; none of another shape.
fn flat_sides(shape: &Shape, at: Vec3, reach: f32) -> u32 {
    let Kind::Box { half_size } = shape.kind() else { return 0 };
    let room = half_size - at.abs() - reach;
    (0..3).fold(0, |sides, axis| {
        let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
        let is_over = at[axis].abs() >= half_size[axis] && room[next] >= 0.0 && room[last] >= 0.0;
        let side = if at[axis] > 0.0 { axis } else { axis + 3 };
        sides | u32::from(is_over) << side
    })
}

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
    /// Whether all of these points are farther than `distance` metres in front of it, by more than rounding.
    #[inline]
    fn is_behind(&self, points: [Vec3; 3], distance: f32) -> bool {
        let least = points.map(|point| self.normal.dot(point)).into_iter().fold(f32::MAX, f32::min);
        least - self.offset > distance + 1e-5 * (least.abs() + self.offset.abs() + distance)
    }
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

    /// The middle of its feature.
    pub(super) fn middle(self) -> Self {
        if self.is_particle() { self } else { Feature(self.rows).middle() }
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
        self.rows.map(|row| column[at(row)].truncate() + (origin[at(row)] - home))
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
        self.shares().map(|(row, weight)| weight * radius[row.wrapping_sub(begin) as usize]).sum()
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
        let w = self.shares().map(|(row, weight)| weight * weight * position[row as usize].w).sum();
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
        self.shares().map(|(row, weight)| weight * weight * places.position[places.at(row)].w).sum()
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
        let moved = (0..3).map(|k| start[k].distance_squared(now[k])).fold(0.0, f32::max).sqrt();
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

    /// Whether it is inside of its feature, and not on a side.
    fn is_inside(&self) -> bool {
        self.rows().zip(self.weights).all(|(_, weight)| weight > ON_SIDE)
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
        let extent = || corners.map(|corner| corner.distance_squared(first.at)).into_iter();
        let is_far = || first.distance - extent().fold(0.0, f32::max).sqrt() > reach;
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
            let ends = [corners[0], corners[1]].map(Vec3::as_dvec3);
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
            let weights = to_triangle(toward, corners.map(Vec3::as_dvec3)).map(|one| one as f32);
            let moved = (0..3).map(|k| (weights[k] - self.weights[k]).abs()).fold(0.0, f32::max);
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
