//! Conversion to the shapes of `parry3d`, for contact manifolds of two body colliders. The library is not part of the public API; its vectors are those of
//! another version of `glam`.

use glam::Vec3;
use parry3d::math::{Pose, Rotation, Vector};
use parry3d::shape as parry;
use parry3d::utils::Array2;

use super::height::Heights;
use super::hull::ConvexHull;
use super::mesh::Mesh;
use super::{Form, Shape};
use crate::collide::frame::Frame;

/// A `parry3d` shape.
pub(super) struct ParryShape(Box<dyn parry::Shape>);

impl Shape {
    /// The equivalent `parry3d` shape. Made on first use, which takes time for a mesh or a heightfield.
    pub(crate) fn parry(&self) -> &dyn parry::Shape {
        &*self.derived.parry_shape.get_or_init(|| ParryShape(build(&self.form))).0
    }
}

fn build(form: &Form) -> Box<dyn parry::Shape> {
    match form {
        Form::HalfSpace => Box::new(parry::HalfSpace::new(Vector::Y)),
        // Handled wall by wall (`Obstacle::with`): `parry3d` has no such shape.
        Form::InsideBox(_) => Box::new(parry::HalfSpace::new(Vector::Y)),
        Form::Ball(ball) => Box::new(parry::Ball::new(ball.radius)),
        Form::Capsule(c) => Box::new(parry::Capsule::new_y(c.half_height, c.radius)),
        Form::Cuboid(cuboid) => Box::new(parry::Cuboid::new(to_parry(cuboid.half_size))),
        Form::Cylinder(c) => Box::new(parry::Cylinder::new(c.half_height, c.radius)),
        Form::Hull(hull) => of_hull(hull),
        Form::Mesh(mesh) => of_mesh(mesh),
        Form::Heights(heights) => of_heights(heights),
    }
}

/// The polyhedron of the known faces; where `parry3d` rejects that, a mesh of its triangles.
fn of_hull(hull: &ConvexHull) -> Box<dyn parry::Shape> {
    let points = vectors(&hull.points);
    if let Some(body) = parry::ConvexPolyhedron::from_convex_mesh(points.clone(), &hull.triangles) {
        return Box::new(body);
    }
    of_triangles(points, hull.triangles.clone(), true)
}

fn of_mesh(mesh: &Mesh) -> Box<dyn parry::Shape> {
    of_triangles(vectors(&mesh.vertices), mesh.triangles.clone(), mesh.is_solid())
}

/// Pseudo-normals (internal edges) keep a body that slides over the mesh from catching on edges within it.
fn of_triangles(
    points: Vec<Vector>,
    triangles: Vec<[u32; 3]>,
    solid: bool,
) -> Box<dyn parry::Shape> {
    let flags = if solid {
        parry::TriMeshFlags::FIX_INTERNAL_EDGES | parry::TriMeshFlags::ORIENTED
    } else {
        parry::TriMeshFlags::FIX_INTERNAL_EDGES_TWO_SIDED
    };
    match parry::TriMesh::with_flags(points, triangles, flags) {
        Ok(mesh) => Box::new(mesh),
        // Fails only without triangles, which no mesh of ours is.
        Err(_) => Box::new(parry::Ball::new(0.0)),
    }
}

/// `parry3d` stores a grid by columns; the diagonals of the cells are the same.
fn of_heights(heights: &Heights) -> Box<dyn parry::Shape> {
    let (columns, rows) = heights.grid();
    let by_columns = (0..columns * rows).map(|i| heights.height(i / rows, i % rows)).collect();
    let grid = Array2::new(rows, columns, by_columns);
    let flags = parry::HeightFieldFlags::FIX_INTERNAL_EDGES;
    let size = heights.size();
    Box::new(parry::HeightField::with_flags(grid, Vector::new(size.x, 1.0, size.z), flags))
}

fn vectors(points: &[Vec3]) -> Vec<Vector> {
    points.iter().map(|&p| to_parry(p)).collect()
}

/// A frame as a pose of `parry3d`. The quaternion is taken from the largest of its four terms.
pub(crate) fn pose(frame: &Frame) -> Pose {
    let r = &frame.rotation;
    let [x, y, z] = [r.x_axis, r.y_axis, r.z_axis];
    let squares = [
        1.0 + x.x + y.y + z.z,
        1.0 + x.x - y.y - z.z,
        1.0 - x.x + y.y - z.z,
        1.0 - x.x - y.y + z.z,
    ];
    let (w, i, j, k) = if squares[0] >= 1.0 {
        (squares[0], y.z - z.y, z.x - x.z, x.y - y.x)
    } else if squares[1] >= squares[2] && squares[1] >= squares[3] {
        (y.z - z.y, squares[1], x.y + y.x, z.x + x.z)
    } else if squares[2] >= squares[3] {
        (z.x - x.z, x.y + y.x, squares[2], y.z + z.y)
    } else {
        (x.y - y.x, z.x + x.z, y.z + z.y, squares[3])
    };
    let length = (w * w + i * i + j * j + k * k).sqrt();
    let rotation = Rotation::from_xyzw(i / length, j / length, k / length, w / length);
    Pose::from_parts(to_parry(frame.translation), rotation)
}

pub(crate) fn from_parry(v: Vector) -> Vec3 {
    Vec3::new(v.x, v.y, v.z)
}

pub(crate) fn to_parry(v: Vec3) -> Vector {
    Vector::new(v.x, v.y, v.z)
}
