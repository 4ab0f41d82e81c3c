//! Volume, barycentre and inertia of a closed mesh: exact, for any shape that has an interior.
//!
//! # The integrals
//!
//! Choose any point `o`. Each triangle `a b c` forms a tetrahedron with it, counted positive where the outside of the triangle faces away from `o` and negative
//! otherwise. Points outside a closed mesh are then counted equally often with either sign, and points inside once. So an integral over the interior is a sum
//! over triangles. For one tetrahedron, with `a`, `b`, `c` relative to `o`,
//!
//! ```text
//! V = a · (b × c) / 6        ∫ x dV = V s / 4        ∫ x xᵀ dV = V (a aᵀ + b bᵀ + c cᵀ + s sᵀ) / 20        s = a + b + c
//! ```
//!
//! The last one: a point of the tetrahedron is `x = Σ λᵢ vᵢ` over its four corners with `λ` uniform on the simplex, for which the mean of `λᵢ²` is 1/10 and
//! that of `λᵢ λⱼ` is 1/20; so the mean of `x xᵀ` is `(Σ vᵢ vᵢᵀ + (Σ v)(Σ v)ᵀ) / 20`, where the fourth corner is zero. About the mean `c` it is `∫ (x - c)(x -
//! c)ᵀ dV = ∫ x xᵀ dV - V c cᵀ`.
//!
//! `o` is the centre of the bounding box, so that a mesh far from the origin loses no precision in the subtraction. All in `f64`.

use glam::{DMat3, DVec3, Mat3, Vec3};

use super::nearest::bounds;
use crate::coincident::first_coincident;
use crate::collide::{Shape, ShapeKind};
use crate::convex_hull::convex_hull;
use crate::pose::{outer, symmetric};

/// Volume, barycentre and second moments of the interior of a closed mesh, at uniform density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MassProperties {
    /// Enclosed volume, m³, positive.
    pub volume: f64,
    /// Barycentre, metres, in the coordinates of the mesh.
    pub barycentre: DVec3,
    /// Mean of `x xᵀ` over the interior, with `x` relative to the barycentre, m²: symmetric, positive definite. Multiplied by the mass, these are the second
    /// moments.
    pub spread: DMat3,
}

/// Why a mesh has no mass properties.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MassFault {
    /// There are no vertices, or no triangles.
    #[error("its mesh has no vertices or no triangles")]
    Empty,
    /// A vertex has a coordinate that is NaN or infinite.
    #[error("vertex {0} of its mesh is not at a finite position")]
    NotFinite(usize),
    /// A triangle has a corner that is no vertex.
    #[error("triangle {0} of its mesh has a corner that is no vertex")]
    NoSuchVertex(usize),
    /// The edge between these two vertices does not have equally many triangles in both directions: there is a hole, or a flipped triangle.
    #[error("its mesh is open, or turned round in part, between the vertices {0} and {1}")]
    Open(u32, u32),
    /// The mesh is closed, but its triangles face inward.
    #[error("its mesh is inside out")]
    InsideOut,
    /// It encloses nothing, is thinner than a millionth of its length, or intersects itself such that the moments are not those of any body.
    #[error("its mesh encloses no volume")]
    Flat,
}

/// Smallest ratio of thickness squared to length squared of a solid: at a thickness of a millionth of the length, `f32` vertices carry no information.
const FLAT: f64 = 1e-12;
/// Relative round-off threshold: a volume below this share of the sum of its tetrahedra's magnitudes is round-off.
const CANCELLED: f64 = 1e-12;

impl MassProperties {
    /// Mass properties of a collision shape; `None` if it has no interior or cannot move: a half space, a mesh, a height field.
    ///
    /// The mean squares along the axes are `r²/5` for a ball, `a²/12` for a box, and for a cylinder along y `h²/12` along it and `r²/4` across. A capsule is a
    /// cylinder and two half balls. A point of a half ball is `l/2 + t` from the centre, where the mean of `t` is `3r/8` and that of its square `r²/5`.
    pub fn of_shape(shape: &Shape) -> Option<Self> {
        let ball = |r: f64| core::f64::consts::PI * 4.0 / 3.0 * r * r * r;
        let tube = |r: f64, h: f64| core::f64::consts::PI * r * r * h;
        let (volume, spread) = match shape.kind() {
            ShapeKind::Sphere { radius } => {
                let r = f64::from(radius);
                (ball(r), DVec3::splat(r * r / 5.0))
            }
            ShapeKind::Box { half_size } => {
                let size = 2.0 * half_size.as_dvec3();
                (size.element_product(), size * size / 12.0)
            }
            ShapeKind::Cylinder { radius, half_height } => {
                let (r, h) = (f64::from(radius), 2.0 * f64::from(half_height));
                (tube(r, h), DVec3::new(r * r / 4.0, h * h / 12.0, r * r / 4.0))
            }
            ShapeKind::Capsule { radius, half_height } => {
                let (r, l) = (f64::from(radius), 2.0 * f64::from(half_height));
                let (middle, ends) = (tube(r, l), ball(r));
                let across = middle * r * r / 4.0 + ends * r * r / 5.0;
                let far = l * l / 4.0 + 3.0 * l * r / 8.0 + r * r / 5.0;
                let along = middle * l * l / 12.0 + ends * far;
                (middle + ends, DVec3::new(across, along, across) / (middle + ends))
            }
            ShapeKind::Hull(points) => {
                return Self::of_mesh(points, &convex_hull(points).ok()?).ok();
            }
            ShapeKind::HalfSpace
            | ShapeKind::InsideBox
            | ShapeKind::Mesh
            | ShapeKind::HeightField => return None,
        };
        let spread = DMat3::from_diagonal(spread);
        Some(Self { volume, barycentre: DVec3::ZERO, spread })
    }

    /// Mass properties of a closed mesh of triangles, counter-clockwise from outside. It need not be convex or connected, and may have cavities, whose
    /// triangles face into them. Vertices at the same position count as one, so texture seams are no problem.
    ///
    /// # Errors
    /// A [`MassFault`] if the mesh is invalid, open, inside out or flat.
    pub fn of_mesh(positions: &[Vec3], triangles: &[[u32; 3]]) -> Result<Self, MassFault> {
        check(positions, triangles)?;
        let [low, high] = bounds(positions.iter().copied()).map(Vec3::as_dvec3);
        let middle = (low + high) * 0.5;
        let (mut volume, mut all, mut first, mut second) = (0.0, 0.0, DVec3::ZERO, DMat3::ZERO);
        for t in triangles {
            let [a, b, c] = t.map(|i| positions[i as usize].as_dvec3() - middle);
            let (v, s) = (a.dot(b.cross(c)) / 6.0, a + b + c);
            volume += v;
            all += v.abs();
            first += s * (v / 4.0);
            second += (outer(a, a) + outer(b, b) + outer(c, c) + outer(s, s)) * (v / 20.0);
        }
        if volume.abs() <= CANCELLED * all {
            return Err(MassFault::Flat);
        }
        if volume < 0.0 {
            return Err(MassFault::InsideOut);
        }
        let mean = first * (1.0 / volume);
        let spread = second * (1.0 / volume) - outer(mean, mean);
        let found = Self { volume, barycentre: middle + mean, spread };
        let (squares, _) = found.principal();
        if !(squares.min_element() > FLAT * squares.max_element() && squares.is_finite()) {
            return Err(MassFault::Flat);
        }
        Ok(found)
    }

    /// Inertia tensor about the barycentre for a body of `mass` kg, kg·m², in the axes of the mesh: `M (tr(S) 1 - S)`.
    pub fn inertia(&self, mass: f32) -> Mat3 {
        let s = self.spread;
        let trace = s.x_axis.x + s.y_axis.y + s.z_axis.z;
        ((DMat3::from_diagonal(DVec3::splat(trace)) - s) * f64::from(mass)).as_mat3()
    }

    /// Mean squares along the principal axes, m², and the axes, one in each column: unit vectors, in the order and with the signs that are nearest to x, y and
    /// z.
    ///
    /// A shape with equal moments about several axes (a cube) has no unique axes and gets those of the mesh.
    pub fn principal(&self) -> (DVec3, DMat3) {
        // Rounding of f32 vertices, in a moment that should be zero or in two that should be equal, would select arbitrary axes.
        let mut rows = self.spread.to_cols_array_2d();
        for i in 0..3 {
            for j in 0..3 {
                if i != j && rows[i][j].abs() <= NEGLIGIBLE * (rows[i][i] * rows[j][j]).sqrt() {
                    rows[i][j] = 0.0;
                }
            }
        }
        let (squares, axes) = symmetric::eigen(rows);
        let order = nearest_order(&axes);
        let axis = |k: usize| {
            let axis = DVec3::from_array(axes[order[k]]);
            if axis[k] < 0.0 { -axis } else { axis }
        };
        let squares = DVec3::from_array(order.map(|row| squares[row]));
        (squares, DMat3::from_cols(axis(0), axis(1), axis(2)))
    }
}

/// A mean of `x y` below this share of the product of the root mean squares of `x` and `y` counts as zero: a few roundings of `f32`.
const NEGLIGIBLE: f64 = 3e-7;

/// Index of the vector that is most along x, of the one of the other two that is most along y, and of the last one.
fn nearest_order(axes: &[[f64; 3]; 3]) -> [usize; 3] {
    let longer =
        |k: usize, a: usize, b: usize| if axes[b][k].abs() > axes[a][k].abs() { b } else { a };
    let x = longer(0, longer(0, 0, 1), 2);
    let [p, q] = [[1, 2], [0, 2], [0, 1]][x];
    let y = longer(1, p, q);
    [x, y, p + q - y]
}

/// Checks the input before the integration.
fn check(positions: &[Vec3], triangles: &[[u32; 3]]) -> Result<(), MassFault> {
    if positions.is_empty() || triangles.is_empty() {
        return Err(MassFault::Empty);
    }
    if let Some(vertex) = positions.iter().position(|p| !p.is_finite()) {
        return Err(MassFault::NotFinite(vertex));
    }
    let is_vertex = |i: &u32| (*i as usize) < positions.len();
    if let Some(number) = triangles.iter().position(|t| !t.iter().all(is_vertex)) {
        return Err(MassFault::NoSuchVertex(number));
    }
    let same = first_coincident(positions);
    // Every side of a triangle as its edge and a direction, +1 or -1. In a closed surface the directions of each edge sum to zero.
    let mut sides = Vec::with_capacity(3 * triangles.len());
    for t in triangles {
        let t = t.map(|i| same[i as usize]);
        for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
            if a != b {
                sides.push(([a.min(b), a.max(b)], if a < b { 1 } else { -1 }));
            }
        }
    }
    sides.sort_unstable();
    for edge in sides.chunk_by(|a, b| a.0 == b.0) {
        if edge.iter().map(|side| side.1).sum::<i32>() != 0 {
            let [a, b] = edge[0].0;
            return Err(MassFault::Open(a, b));
        }
    }
    Ok(())
}

#[cfg(test)]
pub(super) mod tests;
