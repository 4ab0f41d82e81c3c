//! Features: the edges and triangles of bodies that collide by their surface, against shapes.
//!
//! The particles of a surface collide with shapes as balls ([`particle_contact`](super::particle_contact), [`body_contact`](super::body_contact)). That is all
//! there is to do where a shape is blunt: a triangle whose corners are outside of a plane is outside of it. But an edge, a corner, a thin post or a small ball
//! fits in between. So an edge or a triangle collides by that one of its points which is nearest to the shape, as a particle of its own: the point `Σ βₖ xₖ` of
//! corners with the weights `β` has the inverse mass `Σ βₖ² wₖ`, and an impulse on it moves each corner by `βₖ wₖ` of it
//! ([`SurfacePoint`]).
//!
//! What is left out because a shape is blunt there must be no deeper in it than what collides, or it would jump when it is found: so features keep a part of the
//! thickness only. What is recovered of an old overlap is no velocity, for the same reason. A feature that is pinned in a shape is attached to it.
//!
//! Meshes and heightfields are not convex. Their [ridges](super::shape::Ridge), each a thin box along an edge, are.

use core::ops::Range;

use glam::Vec3;

use super::filter::ContactFilter;
use super::frame::Frame;
use super::shape::{Kind, Ridge, Shape};
use super::surface_point::{BLUNT, SurfacePoint, each, greatest};
use crate::particles::Particles;
use crate::tracked::Tracked;

/// Slope of the distance along an edge, from one of its ends, from which on no other point of it becomes the nearest one within a step.
const STEEP: f32 = 0.3;

/// Depth of what stands for a ridge, as a share of the longest edge. Of capes, which are about as thick as that, it is their thickness.
const RIDGE_DEPTH: f32 = 0.25;

/// Number of features whose bounds are tested together.
const CHUNK: usize = 32;

/// An edge or a triangle: the rows of its corners, ascending. Of an edge the last one is listed twice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Feature([u32; 3]);

/// The features of all bodies that collide by their surface. Rebuilt where their triangles have changed.
#[derive(Clone, Debug, Default)]
pub(crate) struct Features {
    list: Vec<Feature>,
    of_body: Vec<BodyFeatures>,
    chunks: Vec<FeatureChunk>,
    chunk_rows: Vec<u32>,
    /// What the list was built for: the revision of the triangles, the body of each row, and whether each body collides by its surface.
    revision: Option<u64>,
    bodies: Vec<u32>,
    by_surface: Vec<bool>,
}

/// The features of a body.
#[derive(Clone, Debug, Default)]
struct BodyFeatures {
    /// Those that it has in the list, and in chunks.
    list: Range<usize>,
    chunks: Range<usize>,
    /// All of its corners are among these.
    rows: Range<u32>,
}

/// Features of one body whose bounds are tested together.
#[derive(Clone, Debug)]
struct FeatureChunk {
    list: Range<usize>,
    /// Where their corners are in `chunk_rows`, each once.
    rows: Range<usize>,
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
        SurfacePoint::middle_of(self.0)
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
        let Self { list, of_body, chunks, chunk_rows, revision, bodies, by_surface: known } = self;
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
        of_body.resize_with(known.len(), BodyFeatures::default);
        chunks.clear();
        chunk_rows.clear();
        let mut begin = 0;
        for own in list.chunk_by(|one, next| body(one) == body(next)) {
            let first_chunk = chunks.len();
            for chunk in own.chunks(CHUNK) {
                let mut rows: Vec<u32> = chunk.iter().flat_map(|one| one.0).collect();
                rows.sort_unstable();
                rows.dedup();
                chunks.push(FeatureChunk {
                    list: begin..begin + chunk.len(),
                    rows: chunk_rows.len()..chunk_rows.len() + rows.len(),
                });
                chunk_rows.extend(rows);
                begin += chunk.len();
            }
            let end = own.iter().map(|feature| feature.0[2] + 1).max().unwrap_or(0);
            of_body[body(&own[0]) as usize] = BodyFeatures {
                list: begin - own.len()..begin,
                chunks: first_chunk..chunks.len(),
                rows: own[0].0[0]..end,
            };
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
        self.revision = None;
    }

    /// The bodies that have features.
    pub(super) fn bodies(&self) -> impl Iterator<Item = u32> {
        (0..).zip(&self.of_body).filter(|(_, own)| !own.list.is_empty()).map(|(body, _)| body)
    }

    /// The first row of a body that has features.
    pub(super) fn first_row(&self, body: u32) -> u32 {
        self.of_body[body as usize].rows.start
    }

    /// The features of a body.
    fn of(&self, body: u32) -> &[Feature] {
        &self.list[self.of_body[body as usize].list.clone()]
    }
}

/// The radius with which a convex shape is rounded everywhere, metres: 0 if it has an edge. `None` for shapes that features do not collide with as a whole: those
/// that only have flat or hollow sides, and meshes and heightfields, to which there may be several nearest points.
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
    /// AABB of their balls over the step, metres in the world, and of those of each chunk; and the least radius, metres.
    bounds: (Vec3, Vec3),
    chunks: Vec<(Vec3, Vec3)>,
    thickness: f32,
    /// The longest edge, metres, once it is needed.
    longest: Option<f32>,
    /// What is known of each row in a search, and the number of the last search.
    beside: Vec<CornerBeside>,
    search: u32,
}

/// A corner beside a shape.
#[derive(Clone, Copy, Debug, Default)]
struct CornerBeside {
    /// The search that this is of.
    search: u32,
    /// Six bits for the sides of the shape's bounds that it stays beyond, and six for the sides of a box that it stays over.
    sides: u16,
    /// Its distance from the shape, metres, and the direction of that, once they are needed.
    nearest: Option<(f32, Vec3)>,
}

impl Corners {
    /// AABB of their balls over the step, metres in the world.
    pub(super) fn bounds(&self) -> (Vec3, Vec3) {
        self.bounds
    }

    /// How far one of them is likely to move, metres, at the most.
    pub(super) fn motion(&self) -> f32 {
        self.moving.iter().fold(0.0, |most, (_, reach)| most.max(reach.likely))
    }

    /// The least radius, metres.
    pub(super) fn thickness(&self) -> f32 {
        self.thickness
    }
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
        let Corners { moving, bounds, chunks, thickness, longest, beside, search } = corners;
        let own = &self.of_body[body as usize];
        moving.clear();
        (*thickness, *longest, *search) = (f32::INFINITY, None, 0);
        for row in own.rows.clone() {
            let i = row as usize;
            *thickness = thickness.min(particles.radius[i]);
            let at = particles.origin[i] + particles.position[i].truncate();
            moving.push((at, reach(row)));
        }
        beside.clear();
        beside.resize(moving.len(), CornerBeside::default());
        let empty = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        let union =
            |one: (Vec3, Vec3), other: (Vec3, Vec3)| (one.0.min(other.0), one.1.max(other.1));
        chunks.clear();
        chunks.extend(self.chunks[own.chunks.clone()].iter().map(|chunk| {
            let rows = self.chunk_rows[chunk.rows.clone()].iter();
            let ball = |&row: &u32| {
                let (at, reach) = moving[(row - own.rows.start) as usize];
                let around = reach.most + particles.radius[row as usize];
                (at - around, at + around)
            };
            rows.map(ball).fold(empty, union)
        }));
        *bounds = chunks.iter().copied().fold(empty, union);
    }

    /// The longest edge of a body whose corners have been [collected](Self::collect), metres.
    pub(super) fn longest(&self, body: u32, particles: &Particles, corners: &mut Corners) -> f32 {
        *corners.longest.get_or_insert_with(|| {
            let edges = self.of(body).iter().take_while(|feature| feature.is_edge());
            let square = |edge: &Feature| {
                let [a, b, _] = edge.0.map(|row| row as usize);
                particles.separation(a, b).length_squared()
            };
            edges.map(square).fold(0.0, f32::max).sqrt()
        })
    }

    /// Calls `found` with the features of a body that a shape may touch in this step between their [collected](Self::collect) corners, and with how far the two
    /// may approach each other, metres.
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
        mut found: impl FnMut(Feature, f32),
    ) {
        let ShapeBeside { shape, bounds, frame, origin, reach: carried } = *beside;
        if are_apart(corners.bounds, bounds) {
            return;
        }
        let Some(rounding) = rounding(shape) else { return };
        if rounding > 0.0 {
            let longest = self.longest(body, particles, corners);
            if longest * longest <= 6.0 * BLUNT * rounding * corners.thickness {
                return;
            }
        }
        let Corners { moving, chunks, beside, search, .. } = corners;
        *search += 1;
        let BodyFeatures { chunks: own_chunks, rows, .. } = &self.of_body[body as usize];
        let first = rows.start;
        let at = |row: u32| {
            let i = row as usize;
            frame.local(particles.position[i].truncate() + (particles.origin[i] - origin))
        };
        let sides_of = |row: u32| {
            let (place, reach) = moving[(row - first) as usize];
            let around = reach.most + particles.radius[row as usize];
            let below = (place + around).cmplt(bounds.0).bitmask();
            let above = (place - around).cmpgt(bounds.1).bitmask();
            let is_far = below | above != 0;
            let reach = reach.most + carried.most;
            let over = if is_far { 0 } else { flat_sides(shape, at(row), reach) };
            (below | above << 3 | over << 6) as u16
        };
        let near_chunks = self.chunks[own_chunks.clone()].iter().zip(&*chunks);
        let near_chunks = near_chunks.filter(|(_, own)| !are_apart(**own, bounds));
        for &feature in near_chunks.flat_map(|(chunk, _)| &self.list[chunk.list.clone()]) {
            let corners = each(feature.0, |row| (row - first) as usize);
            let sides = each(feature.0, |row| {
                let known = &mut beside[(row - first) as usize];
                if known.search != *search {
                    let sides = sides_of(row);
                    *known = CornerBeside { search: *search, sides, nearest: None };
                }
                known.sides
            });
            if sides[0] & sides[1] & sides[2] != 0 {
                continue;
            }
            let [a, b, c] = each(feature.0, &at);
            let longest =
                a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
            let thickness = feature.middle().radius(&particles.radius, 0);
            if longest <= 6.0 * BLUNT * rounding * thickness {
                continue;
            }
            let reach = greatest(each(corners, |corner| moving[corner].1.most)) + carried.most;
            let likely = greatest(each(corners, |corner| moving[corner].1.likely)) + carried.likely;
            let near = each([(corners[0], a), (corners[1], b), (corners[2], c)], |(corner, at)| {
                *beside[corner].nearest.get_or_insert_with(|| {
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
            let farthest = greatest(each(near, |(distance, _)| distance));
            // No point of the feature is nearer to the shape by more than its extent.
            if farthest - longest.sqrt() > reach + thickness {
                continue;
            }
            let lift = 4.0 * BLUNT * thickness;
            let normals = each(near, |(_, normal)| normal);
            if !(likely * lift <= longest && is_held(feature, [a, b, c], normals, lift)) {
                found(feature, reach);
            }
        }
    }
}

/// Whether a ridge is blunt beside features of a thickness and of a length at the most, metres: the particles keep all of them away from it.
pub(super) fn is_blunt(ridge: &Ridge, longest: f32, thickness: f32) -> bool {
    ridge.rise(longest) <= BLUNT * thickness
}

/// The box that stands for a ridge of a surface beside features of a thickness and of a length at the most that move by `motion` in a substep, metres, and its
/// frame in that of the surface. It is so deep that nothing is beyond its middle within a substep, nor where sweeps leave some of a load. A blade takes half of
/// its width from what features keep of their thickness, on either side, so that particles stay farther away.
pub(super) fn ridge_box(
    (ridge, surface): (&Ridge, &Shape),
    (longest, thickness): (f32, f32),
    motion: f32,
) -> (Shape, Frame) {
    let depth = thickness.max(RIDGE_DEPTH * longest) + 2.0 * motion;
    ridge.solid(surface, depth, (1.0 - BLUNT) * thickness)
}

/// Whether two AABBs have no point in common.
fn are_apart(one: (Vec3, Vec3), other: (Vec3, Vec3)) -> bool {
    one.0.cmpgt(other.1).any() || one.1.cmplt(other.0).any()
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
