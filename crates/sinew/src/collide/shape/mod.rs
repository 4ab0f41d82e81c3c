//! Collision shapes. A shape is validated when it is made, and tested against particles in every substep.
//!
//! | file | what it is |
//! |---|---|
//! | `fault` | why a shape is refused |
//! | `convex` | a sphere against any convex shape: one rule for all of them, with its derivation |
//! | `round`, `flat` | sphere, capsule and cylinder; box: nearest point and ray entry in closed form |
//! | `closed_form` | shapes whose nearest point has a closed form, eight points at a time |
//! | `inside` | the inverted box (solid outside), and the half-spaces of unbounded shapes |
//! | `hull` | convex hull: nearest point and ray entry |
//! | `triangle`, `surface` | a sphere against triangles: nearest point, crossing, and the rule for non-convex shapes |
//! | `local_face` | the one triangle that a sphere may meet in a step, eight spheres at a time |
//! | `tree`, `coarse` | bounding volume hierarchy; coarse distance grid |
//! | `mesh`, `height` | triangle mesh; heightfield |
//! | `ridges` | convex edges of those |
//! | `extent`, `scale` | AABBs; scaling |
//! | `content_hash` | hash of a shape |
//! | `words` | serialisation as plain words |
//! | `gap` | distance of two convex shapes |
//! | `convert` | conversion to `parry3d` shapes, for contact manifolds |

mod closed_form;
mod coarse;
mod content_hash;
pub(super) mod convert;
mod convex;
mod extent;
mod fault;
mod flat;
pub(super) mod gap;
mod height;
mod hull;
mod inside;
mod local_face;
mod mesh;
mod ridges;
mod round;
mod scale;
mod surface;
mod tree;
mod triangle;
mod words;

use std::sync::{Arc, OnceLock};

use glam::Vec3;

pub use fault::ShapeFault;
pub use scale::is_uniform;

pub(crate) use closed_form::ClosedForm;
pub(crate) use convert::{from_parry, pose, to_parry};
pub(crate) use local_face::{LaneFaces, LocalFace, Reachable, SphereTouches};
pub(crate) use ridges::Ridge;

use convex::Convex;
use fault::{is_length, is_size};
use flat::Cuboid;
use height::Heights;
use hull::ConvexHull;
use inside::HollowBox;
use mesh::Mesh;
use ridges::Ridges;
use round::{Ball, Capsule, Cylinder};
use surface::Surface as _;

/// A collision shape in its own frame, in metres. Cheap to clone: large data is shared.
///
/// Two shapes are equal if they are of the same kind with the same numbers.
#[derive(Clone)]
pub struct Shape {
    form: Form,
    /// See [`content_hash`](Self::content_hash).
    content_hash: u64,
    derived: Arc<Derived>,
}

/// What follows from the geometry of a shape; each made on first use.
#[derive(Default)]
struct Derived {
    /// The equivalent shape of `parry3d`.
    parry_shape: OnceLock<convert::ParryShape>,
    ridges: OnceLock<Ridges>,
}

/// The geometry of a shape.
#[derive(Clone, Debug, PartialEq)]
enum Form {
    HalfSpace,
    InsideBox(HollowBox),
    Ball(Ball),
    Capsule(Capsule),
    Cuboid(Cuboid),
    Cylinder(Cylinder),
    Hull(Arc<ConvexHull>),
    Mesh(Arc<Mesh>),
    Heights(Arc<Heights>),
}

/// The kind of a shape with its dimensions, for algorithms with special cases. Lengths in metres.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Kind<'a> {
    /// Solid below y = 0.
    HalfSpace,
    /// Solid outside of a box that is centred at the origin.
    InsideBox,
    /// Centred at the origin.
    Sphere { radius: f32 },
    /// Along y; the half height is that of the straight part.
    Capsule { radius: f32, half_height: f32 },
    /// Centred at the origin.
    Box { half_size: Vec3 },
    /// Along y.
    Cylinder { radius: f32, half_height: f32 },
    /// Its vertices, none of which is in the interior.
    Hull(&'a [Vec3]),
    /// A triangle mesh, closed or open.
    Mesh,
    /// Solid beneath a surface.
    HeightField,
}

/// Contact of a moving sphere with a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ShapeTouch {
    /// Direction in which the sphere must be moved: a unit vector.
    pub(crate) normal: Vec3,
    /// Distance by which it must be moved, metres; greater than 0.
    pub(crate) depth: f32,
}

/// Where a ray hits a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayHit {
    /// Distance along the ray, metres.
    pub distance: f32,
    /// Unit surface normal at the hit, against the ray.
    pub normal: Vec3,
}

/// The point on the surface of a shape that is nearest to a query point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// That surface point, metres.
    pub point: Vec3,
    /// Unit outward normal there: towards the query point if that is outside, away from it if it is inside.
    pub normal: Vec3,
    /// Distance from the query point, metres; negative if that is inside a solid.
    pub distance: f32,
}

impl Shape {
    /// An infinite floor: solid below y = 0.
    pub fn half_space() -> Self {
        Self::of(Form::HalfSpace)
    }

    /// A closed room: solid outside of a box that is centred at the origin. `size` is that of the box, metres.
    ///
    /// # Errors
    /// If a length is not between 1e-6 and 1e6 metres.
    pub fn inside_box(size: Vec3) -> Result<Self, ShapeFault> {
        is_size(size).then_some(()).ok_or(ShapeFault::Size)?;
        Ok(Self::of(Form::InsideBox(HollowBox { half_size: 0.5 * size })))
    }

    /// A sphere that is centred at the origin, of a radius in metres.
    ///
    /// # Errors
    /// If the radius is not between 1e-6 and 1e6 metres.
    pub fn sphere(radius: f32) -> Result<Self, ShapeFault> {
        is_length(radius).then_some(()).ok_or(ShapeFault::Radius)?;
        Ok(Self::of(Form::Ball(Ball { radius })))
    }

    /// A capsule along y: a cylinder with a hemisphere on either end, of a radius in metres. `length` is that of the cylinder without the caps, metres.
    ///
    /// # Errors
    /// If one of them is not between 1e-6 and 1e6 metres.
    pub fn capsule(radius: f32, length: f32) -> Result<Self, ShapeFault> {
        is_length(radius).then_some(()).ok_or(ShapeFault::Radius)?;
        is_length(length).then_some(()).ok_or(ShapeFault::Height)?;
        Ok(Self::of(Form::Capsule(Capsule { radius, half_height: 0.5 * length })))
    }

    /// A box that is centred at the origin, of edge lengths in metres.
    ///
    /// # Errors
    /// If one of them is not between 1e-6 and 1e6 metres.
    pub fn cuboid(size: Vec3) -> Result<Self, ShapeFault> {
        is_size(size).then_some(()).ok_or(ShapeFault::Size)?;
        Ok(Self::of(Form::Cuboid(Cuboid { half_size: 0.5 * size })))
    }

    /// A cylinder along y that is centred at the origin, of a radius and a height in metres.
    ///
    /// # Errors
    /// If one of them is not between 1e-6 and 1e6 metres.
    pub fn cylinder(radius: f32, height: f32) -> Result<Self, ShapeFault> {
        is_length(radius).then_some(()).ok_or(ShapeFault::Radius)?;
        is_length(height).then_some(()).ok_or(ShapeFault::Height)?;
        Ok(Self::of(Form::Cylinder(Cylinder { radius, half_height: 0.5 * height })))
    }

    /// The [convex hull](crate::recipes::convex_hull) of points, in metres.
    ///
    /// # Errors
    /// If a point is not finite or farther than 1e6 metres from the origin, if there are fewer than four or more than 65 536 points, or if they lie in a plane
    /// to a millionth of their extent.
    pub fn hull(points: &[Vec3]) -> Result<Self, ShapeFault> {
        Ok(Self::of(Form::Hull(Arc::new(ConvexHull::new(points)?))))
    }

    /// A triangle mesh, vertices in metres. If the triangles enclose a volume (each edge belongs to two triangles with opposite directions, counter-clockwise
    /// seen from outside), it is solid inside. Otherwise they are a sheet, which nothing passes from either side. Vertices at exactly the same position are
    /// merged. Triangles without an area are left out.
    ///
    /// # Errors
    /// If a vertex is not finite or farther than 1e6 metres from the origin, if a triangle refers to a missing vertex, if no triangle has an area, if the
    /// extent of the mesh is not between 1e-6 and 1e6 metres, or if there are more than 1e9 triangles or vertices.
    pub fn mesh(vertices: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Result<Self, ShapeFault> {
        Ok(Self::of(Form::Mesh(Arc::new(Mesh::new(&vertices, &triangles)?))))
    }

    /// A heightfield: `columns` heights along x in each of `rows` along z, row by row, over a rectangle of `size.x` by `size.z` metres centred at the origin.
    /// Heights are in units of `size.y` metres. A cell is divided by the diagonal from its corner at +z to that at +x. It is solid below the surface, down to 5
    /// % of the longer side of the rectangle below its lowest point.
    ///
    /// # Errors
    /// If there are fewer than two columns or rows, if the number of heights is not their product, if a height is not finite or farther than 1e6 metres from 0,
    /// or if the size, or that of a cell, is not between 1e-6 and 1e6 metres on every axis.
    pub fn height_field(
        columns: usize,
        rows: usize,
        heights: &[f32],
        size: Vec3,
    ) -> Result<Self, ShapeFault> {
        Ok(Self::of(Form::Heights(Arc::new(Heights::new(columns, rows, heights, size)?))))
    }

    /// Contact of a sphere whose centre moves from `from`, the start of a substep, to `to`. `None` if it neither overlaps the shape at `to` nor passed through
    /// it on the way. Otherwise the correction from `to` to just outside, on the side that it came from. A sphere that began inside takes the shortest way out.
    /// Lengths in metres, in the frame of the shape. What is not finite touches nothing.
    #[inline]
    pub(crate) fn touch(&self, from: Vec3, to: Vec3, radius: f32) -> Option<ShapeTouch> {
        match &self.form {
            Form::HalfSpace => ShapeTouch::new(Vec3::Y, radius - to.y),
            Form::InsideBox(hollow) => hollow.touch(to, radius),
            Form::Ball(ball) => ball.touch(from, to, radius),
            Form::Capsule(capsule) => capsule.touch(from, to, radius),
            Form::Cuboid(cuboid) => cuboid.touch(from, to, radius),
            Form::Cylinder(cylinder) => cylinder.touch(from, to, radius),
            Form::Hull(hull) => hull.touch(from, to, radius),
            Form::Mesh(mesh) => mesh.touch(from, to, radius),
            Form::Heights(heights) => heights.touch(from, to, radius),
        }
    }

    /// The same contact for a sphere that may meet only `face`, if the conditions for that hold: see [`reachable`](Self::reachable).
    #[inline]
    pub(crate) fn touch_at(
        &self,
        face: Option<&LocalFace>,
        (from, to, radius): (Vec3, Vec3, f32),
    ) -> Option<ShapeTouch> {
        let only = face.and_then(|face| face.touch_one(from, to));
        only.unwrap_or_else(|| self.touch(from, to, radius))
    }

    /// What a sphere may meet while its centre stays within `way` metres of a place, in the frame of the shape.
    pub(crate) fn reachable(&self, at: Vec3, way: f32, radius: f32) -> Reachable {
        match &self.form {
            Form::Mesh(mesh) => mesh.reachable(at, way, radius),
            Form::Heights(heights) => heights.reachable(at, way, radius),
            _ => Reachable::Several,
        }
    }

    /// The first hit of a ray from `origin` along the unit vector `direction`, at most `max` metres away. A ray from within a solid does not hit the surface
    /// where it leaves; on a mesh or heightfield that is not convex it may hit where it enters again.
    pub fn cast_ray(&self, origin: Vec3, direction: Vec3, max: f32) -> Option<RayHit> {
        // Farther hits do not matter, and the midpoint of an infinite segment does not exist.
        let max = max.min(1e9);
        match &self.form {
            Form::HalfSpace => {
                let distance = origin.y / -direction.y;
                (origin.y >= 0.0 && direction.y < 0.0 && distance <= max)
                    .then_some(RayHit { distance, normal: Vec3::Y })
            }
            Form::InsideBox(hollow) => hollow.cast(origin, direction, max),
            Form::Ball(ball) => ball.cast(origin, direction, max),
            Form::Capsule(capsule) => capsule.cast(origin, direction, max),
            Form::Cuboid(cuboid) => cuboid.cast(origin, direction, max),
            Form::Cylinder(cylinder) => cylinder.cast(origin, direction, max),
            Form::Hull(hull) => hull.cast(origin, direction, max),
            Form::Mesh(mesh) => mesh.cast(origin, direction, max),
            Form::Heights(heights) => heights.cast(origin, direction, max),
        }
    }

    /// The point on the surface that is nearest to a finite point. Where there are several, one of them.
    pub fn nearest(&self, point: Vec3) -> Nearest {
        match &self.form {
            Form::HalfSpace => {
                Nearest { point: point.with_y(0.0), normal: Vec3::Y, distance: point.y }
            }
            Form::InsideBox(hollow) => hollow.nearest(point),
            Form::Ball(ball) => ball.nearest(point),
            Form::Capsule(capsule) => capsule.nearest(point),
            Form::Cuboid(cuboid) => cuboid.nearest(point),
            Form::Cylinder(cylinder) => cylinder.nearest(point),
            Form::Hull(hull) => hull.nearest(point),
            Form::Mesh(mesh) => mesh.nearest(point),
            Form::Heights(heights) => heights.nearest(point),
        }
    }

    /// Calls `call` with the triangles within a box, in metres, whose own bounds (low, high) pass `keep`. Returns false for a shape without triangles.
    pub(super) fn triangles_near(
        &self,
        bounds: (Vec3, Vec3),
        keep: &dyn Fn(Vec3, Vec3) -> bool,
        call: &mut dyn FnMut([Vec3; 3]),
    ) -> bool {
        match &self.form {
            Form::Mesh(mesh) => mesh.near(keep, call),
            Form::Heights(field) => field.near(bounds, keep, call),
            _ => return false,
        }
        true
    }

    /// Its kind.
    pub(crate) fn kind(&self) -> Kind<'_> {
        match &self.form {
            Form::HalfSpace => Kind::HalfSpace,
            Form::InsideBox(_) => Kind::InsideBox,
            Form::Ball(ball) => Kind::Sphere { radius: ball.radius },
            Form::Capsule(Capsule { radius, half_height }) => {
                Kind::Capsule { radius: *radius, half_height: *half_height }
            }
            Form::Cuboid(cuboid) => Kind::Box { half_size: cuboid.half_size },
            Form::Cylinder(Cylinder { radius, half_height }) => {
                Kind::Cylinder { radius: *radius, half_height: *half_height }
            }
            Form::Hull(hull) => Kind::Hull(&hull.points),
            Form::Mesh(_) => Kind::Mesh,
            Form::Heights(_) => Kind::HeightField,
        }
    }

    /// The faces of a hull: outward normal, and extent along it from the origin, metres. Empty for any other shape.
    pub(crate) fn faces(&self) -> impl Iterator<Item = (Vec3, f32)> {
        let hull = if let Form::Hull(hull) = &self.form { Some(hull) } else { None };
        hull.into_iter().flat_map(|hull| hull.faces())
    }

    /// The vertices of the hull faces whose normals are within an angle of a unit direction, given by its cosine; some of them several times. Empty for any
    /// other shape.
    pub(crate) fn corners_towards(
        &self,
        direction: Vec3,
        cosine: f32,
    ) -> impl Iterator<Item = Vec3> {
        let hull = if let Form::Hull(hull) = &self.form { Some(hull) } else { None };
        hull.into_iter().flat_map(move |hull| hull.corners_towards(direction, cosine))
    }

    fn of(form: Form) -> Self {
        let content_hash = content_hash::of(&form);
        Self { form, content_hash, derived: Arc::default() }
    }

    /// A hash of its kind and numbers, so that cached data of one shape is not used for another, and a change of it wakes what lies on it. Computed when the
    /// shape is made.
    #[inline]
    pub(crate) fn content_hash(&self) -> u64 {
        self.content_hash
    }
}

impl PartialEq for Shape {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.derived, &other.derived) || self.form == other.form
    }
}

impl std::fmt::Debug for Shape {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.form.fmt(f)
    }
}

impl ShapeTouch {
    /// `None` if the depth is not positive or not finite.
    #[inline(always)]
    pub(super) fn new(normal: Vec3, depth: f32) -> Option<Self> {
        (depth > 0.0 && depth < f32::INFINITY).then_some(Self { normal, depth })
    }

    /// The correction that moves `to` to `end`.
    fn between(to: Vec3, end: Vec3) -> Option<Self> {
        let shift = end - to;
        let depth = shift.length();
        if depth > 0.0 { Self::new(shift / depth, depth) } else { None }
    }
}

#[cfg(test)]
mod tests;
