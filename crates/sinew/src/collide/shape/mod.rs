//! Shapes: what can be solid. Made once, checked when they are made, and then asked in every substep whether a particle is in them.
//!
//! | file | what it is |
//! |---|---|
//! | `fault` | why a shape is refused |
//! | `convex` | a sphere against anything without dents: one rule for all of them, and how it follows |
//! | `round`, `flat` | sphere, capsule and cylinder; box: nearest point and way in, in closed form |
//! | `closed_form` | those whose nearest point has a closed form, eight at a time |
//! | `inside` | what is solid outside of a box, and the half-spaces of what is endless |
//! | `hull` | the same for what is given by its corners |
//! | `triangle`, `surface` | a sphere against triangles: nearest point, crossing, and the same rule for what has dents |
//! | `tree`, `coarse` | which triangles are near; whether any are |
//! | `mesh`, `height` | triangles in any order; triangles over a grid |
//! | `extent`, `scale` | the box around a shape; the same shape in another size |
//! | `content_hash` | a number made of what a shape is |
//! | `words` | a shape as plain words, to be stored |
//! | `gap` | how far two convex shapes are apart |
//! | `convert` | the shapes that `parry3d` knows, for what two solids do to each other |

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
mod mesh;
mod round;
mod scale;
mod surface;
mod tree;
mod triangle;
mod words;

use std::sync::{Arc, OnceLock};

use glam::Vec3;

pub use fault::ShapeFault;

pub(crate) use closed_form::ClosedForm;
pub(crate) use convert::{ours, pose};

use convex::Convex;
use fault::{is_length, is_size};
use flat::Cuboid;
use height::Heights;
use hull::ConvexHull;
use inside::HollowBox;
use mesh::Mesh;
use round::{Ball, Capsule, Cylinder};

/// A shape, in coordinates of its own, metres. Cheap to clone: what is large is shared.
///
/// Two are equal if they are of the same kind with the same numbers.
#[derive(Clone)]
pub struct Shape {
    form: Form,
    /// A number made of what it is: see [`content_hash`](Self::content_hash).
    content_hash: u64,
    /// The same as `parry3d` has it; made when it is asked for first.
    twin: Arc<OnceLock<convert::Twin>>,
}

/// What a shape is.
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

/// What a shape is, for those who have a way of their own with some of them. Lengths in metres.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Kind<'a> {
    /// Solid below y = 0.
    HalfSpace,
    /// Solid outside of a box about the origin.
    InsideBox,
    /// About the origin.
    Sphere { radius: f32 },
    /// Along y; the half height is that of the straight part.
    Capsule { radius: f32, half_height: f32 },
    /// About the origin.
    Box { half_size: Vec3 },
    /// Along y.
    Cylinder { radius: f32, half_height: f32 },
    /// Its corners; there are no points inside.
    Hull(&'a [Vec3]),
    /// Triangles.
    Mesh,
    /// Solid beneath a surface.
    HeightField,
}

/// What a sphere that goes somewhere has run into.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ShapeTouch {
    /// Which way it must be moved: a unit vector.
    pub(crate) normal: Vec3,
    /// How far it must be moved, metres; greater than 0.
    pub(crate) depth: f32,
}

/// Where a ray meets a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayHit {
    /// How far along the ray, metres.
    pub distance: f32,
    /// Unit vector out of the surface there, against the ray.
    pub normal: Vec3,
}

/// The place on a shape's surface that is nearest to a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// That place, metres.
    pub point: Vec3,
    /// Unit vector out of the surface there: towards the point if it is outside, away from it if it is inside.
    pub normal: Vec3,
    /// How far away it is, metres; negative if the point is inside a solid.
    pub distance: f32,
}

impl Shape {
    /// All that is below y = 0: a floor without end.
    pub fn half_space() -> Self {
        Self::of(Form::HalfSpace)
    }

    /// All that is outside of a box about the origin: a room without a door. The size is that of the box, metres.
    ///
    /// # Errors
    /// If a length is not between 1e-6 and 1e6 metres.
    pub fn inside_box(size: Vec3) -> Result<Self, ShapeFault> {
        is_size(size).then_some(()).ok_or(ShapeFault::Size)?;
        Ok(Self::of(Form::InsideBox(HollowBox { half_size: 0.5 * size })))
    }

    /// A sphere about the origin.
    ///
    /// # Errors
    /// If the radius is not between 1e-6 and 1e6 metres.
    pub fn sphere(radius: f32) -> Result<Self, ShapeFault> {
        is_length(radius).then_some(()).ok_or(ShapeFault::Radius)?;
        Ok(Self::of(Form::Ball(Ball { radius })))
    }

    /// A cylinder along y with half a sphere on either end. `length` is that of the cylinder, without the caps.
    ///
    /// # Errors
    /// If one of them is not between 1e-6 and 1e6 metres.
    pub fn capsule(radius: f32, length: f32) -> Result<Self, ShapeFault> {
        is_length(radius).then_some(()).ok_or(ShapeFault::Radius)?;
        is_length(length).then_some(()).ok_or(ShapeFault::Height)?;
        Ok(Self::of(Form::Capsule(Capsule { radius, half_height: 0.5 * length })))
    }

    /// A box about the origin, from the lengths of its edges.
    ///
    /// # Errors
    /// If one of them is not between 1e-6 and 1e6 metres.
    pub fn cuboid(size: Vec3) -> Result<Self, ShapeFault> {
        is_size(size).then_some(()).ok_or(ShapeFault::Size)?;
        Ok(Self::of(Form::Cuboid(Cuboid { half_size: 0.5 * size })))
    }

    /// A cylinder along y, about the origin.
    ///
    /// # Errors
    /// If one of them is not between 1e-6 and 1e6 metres.
    pub fn cylinder(radius: f32, height: f32) -> Result<Self, ShapeFault> {
        is_length(radius).then_some(()).ok_or(ShapeFault::Radius)?;
        is_length(height).then_some(()).ok_or(ShapeFault::Height)?;
        Ok(Self::of(Form::Cylinder(Cylinder { radius, half_height: 0.5 * height })))
    }

    /// The smallest body without dents around points ([`convex_hull`](crate::recipes::convex_hull)).
    ///
    /// # Errors
    /// If a point is not finite or farther than 1e6 metres from the origin, if they are fewer than four or more than 65 536, or if they lie in a
    /// plane to a millionth of their extent.
    pub fn hull(points: &[Vec3]) -> Result<Self, ShapeFault> {
        Ok(Self::of(Form::Hull(Arc::new(ConvexHull::new(points)?))))
    }

    /// Triangles. If they enclose a volume, each edge of two of them in opposite directions, counter-clockwise seen from outside, then what is inside
    /// is solid. Otherwise they are a sheet, which nothing passes from either side. Corners in the very same place are one. Triangles without an area
    /// are left out.
    ///
    /// # Errors
    /// If a vertex is not finite or farther than 1e6 metres from the origin, if a triangle names one that is not there, or if no triangle has an
    /// area.
    pub fn mesh(vertices: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Result<Self, ShapeFault> {
        Ok(Self::of(Form::Mesh(Arc::new(Mesh::new(&vertices, &triangles)?))))
    }

    /// A landscape: `columns` heights along x in each of `rows` along z, row by row, over a rectangle of `size.x` by `size.z` metres about the
    /// origin. Heights are in units of `size.y`. A cell is cut in two from its corner at +z to that at +x. It is solid from there down to a twentieth
    /// of its width below its lowest point.
    ///
    /// # Errors
    /// If there are fewer than two columns or rows, if the number of heights is not their product, if a height is not finite or farther than 1e6
    /// metres from 0, or if the size is not between 1e-6 and 1e6 metres on every axis.
    pub fn height_field(
        columns: usize,
        rows: usize,
        heights: &[f32],
        size: Vec3,
    ) -> Result<Self, ShapeFault> {
        Ok(Self::of(Form::Heights(Arc::new(Heights::new(columns, rows, heights, size)?))))
    }

    /// A sphere whose centre goes from `from`, where a substep began, to `to`: `None` if it neither overlaps the shape there nor went through it on
    /// the way. Otherwise how it must be moved from `to` to be just outside, on the side where it came from. One that began inside goes the nearest
    /// way out. Lengths in metres, in the shape's own coordinates. What is not finite touches nothing.
    #[inline]
    pub(crate) fn touch(&self, from: Vec3, to: Vec3, radius: f32) -> Option<ShapeTouch> {
        match &self.form {
            Form::HalfSpace => ShapeTouch::new(Vec3::Y, radius - to.y),
            Form::InsideBox(room) => room.touch(to, radius),
            Form::Ball(ball) => ball.touch(from, to, radius),
            Form::Capsule(capsule) => capsule.touch(from, to, radius),
            Form::Cuboid(cuboid) => cuboid.touch(from, to, radius),
            Form::Cylinder(cylinder) => cylinder.touch(from, to, radius),
            Form::Hull(hull) => hull.touch(from, to, radius),
            Form::Mesh(mesh) => mesh.touch(from, to, radius),
            Form::Heights(heights) => heights.touch(from, to, radius),
        }
    }

    /// Where a ray from `origin` along a unit vector meets the surface first, at most `max` metres away. From within a solid it meets nothing.
    pub fn cast_ray(&self, origin: Vec3, direction: Vec3, max: f32) -> Option<RayHit> {
        // Farther than this is nothing, and a way without end has no middle.
        let max = max.min(1e9);
        match &self.form {
            Form::HalfSpace => {
                let distance = origin.y / -direction.y;
                (origin.y >= 0.0 && direction.y < 0.0 && distance <= max)
                    .then_some(RayHit { distance, normal: Vec3::Y })
            }
            Form::InsideBox(room) => room.cast(origin, direction, max),
            Form::Ball(ball) => ball.cast(origin, direction, max),
            Form::Capsule(capsule) => capsule.cast(origin, direction, max),
            Form::Cuboid(cuboid) => cuboid.cast(origin, direction, max),
            Form::Cylinder(cylinder) => cylinder.cast(origin, direction, max),
            Form::Hull(hull) => hull.cast(origin, direction, max),
            Form::Mesh(mesh) => mesh.cast(origin, direction, max),
            Form::Heights(heights) => heights.cast(origin, direction, max),
        }
    }

    /// The place on the surface that is nearest to a finite point. Where several are, one of them.
    pub fn nearest(&self, point: Vec3) -> Nearest {
        match &self.form {
            Form::HalfSpace => {
                Nearest { point: point.with_y(0.0), normal: Vec3::Y, distance: point.y }
            }
            Form::InsideBox(room) => room.nearest(point),
            Form::Ball(ball) => ball.nearest(point),
            Form::Capsule(capsule) => capsule.nearest(point),
            Form::Cuboid(cuboid) => cuboid.nearest(point),
            Form::Cylinder(cylinder) => cylinder.nearest(point),
            Form::Hull(hull) => hull.nearest(point),
            Form::Mesh(mesh) => mesh.nearest(point),
            Form::Heights(heights) => heights.nearest(point),
        }
    }

    /// Calls with the triangles within a box, metres, whose own boxes `keep` lets pass, by their lowest and highest coordinates; false for what is of none.
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

    /// What it is.
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

    /// Of a hull, the outward normals of its faces, and how far it reaches along each, metres from its origin; of anything else none.
    pub(crate) fn faces(&self) -> impl Iterator<Item = (Vec3, f32)> {
        let hull = if let Form::Hull(hull) = &self.form { Some(hull) } else { None };
        hull.into_iter().flat_map(|hull| hull.faces())
    }

    /// Of a hull, the corners of the faces whose normals are as near to a unit direction as a cosine says, some of them several times; of anything else
    /// none.
    pub(crate) fn corners_towards(
        &self,
        direction: Vec3,
        cosine: f32,
    ) -> impl Iterator<Item = Vec3> {
        let hull = if let Form::Hull(hull) = &self.form { Some(hull) } else { None };
        hull.into_iter().flat_map(move |hull| hull.corners_towards(direction, cosine))
    }

    fn of(form: Form) -> Self {
        Self { content_hash: content_hash::of(&form), form, twin: Arc::default() }
    }

    /// A number made of what it is, by which what is remembered of one shape is not taken for what is of another. All meshes have one number, and all
    /// heightfields: of those nothing of the kind is remembered.
    #[inline]
    pub(crate) fn content_hash(&self) -> u64 {
        self.content_hash
    }
}

impl PartialEq for Shape {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.twin, &other.twin) || self.form == other.form
    }
}

impl std::fmt::Debug for Shape {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.form.fmt(f)
    }
}

impl ShapeTouch {
    /// `None` if there is nothing to do, also where the numbers are not finite.
    #[inline(always)]
    fn new(normal: Vec3, depth: f32) -> Option<Self> {
        (depth > 0.0 && depth < f32::INFINITY).then_some(Self { normal, depth })
    }

    /// From where something is to where it must be.
    fn between(to: Vec3, end: Vec3) -> Option<Self> {
        let way = end - to;
        let depth = way.length();
        if depth > 0.0 { Self::new(way / depth, depth) } else { None }
    }
}

#[cfg(test)]
mod tests;
