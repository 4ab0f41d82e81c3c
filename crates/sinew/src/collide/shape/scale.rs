//! Scaling of shapes.

use std::sync::Arc;

use glam::Vec3;

use super::{Form, Shape, ShapeFault};
use crate::collide::shape::height::Heights;

/// Sides of the prism that replaces a cylinder that is no longer circular, and of the rings that replace a scaled sphere: the true surface is at most 1 % of
/// the width farther out.
const SIDES: usize = 24;

/// Relative difference up to which factors count as equal: round-off. Modelling tools write factors such as 0.99999994 and 1.0000001, and more of it comes from
/// the product of several parents' scales.
const ROUND_OFF: f32 = 1e-4;

/// Whether a scale is the same along all axes, within round-off. No scale with a NaN is.
pub fn is_uniform(scale: Vec3) -> bool {
    let allowed = ROUND_OFF * scale.abs().max_element();
    let near = |a: f32, b: f32| (a - b).abs() <= allowed;
    near(scale.x, scale.y) && near(scale.y, scale.z) && near(scale.z, scale.x)
}

impl Shape {
    /// The same shape scaled by a positive factor along each of its own axes. Boxes, hulls, meshes and heightfields take any factors; a half-space does not
    /// change. A sphere or a capsule stays one if all three factors are equal ([`is_uniform`]), and a cylinder if those along x and z are. With other factors
    /// they become a hull with 24 sides, whose vertices are on the true surface.
    ///
    /// # Errors
    /// [`ShapeFault::Scale`] if a factor is NaN, infinite, zero or negative, or the error of the constructor for the result.
    pub fn scaled(&self, factor: Vec3) -> Result<Self, ShapeFault> {
        let positive = factor.is_finite() && factor.min_element() > 0.0;
        positive.then_some(()).ok_or(ShapeFault::Scale)?;
        let across = is_uniform(factor.with_y(factor.x));
        let even = is_uniform(factor);
        let stretch = |points: &[Vec3]| points.iter().map(|&p| p * factor).collect::<Vec<_>>();
        match &self.form {
            Form::HalfSpace => Ok(self.clone()),
            Form::InsideBox(hollow) => Self::inside_box(2.0 * hollow.half_size * factor),
            Form::Ball(ball) if even => Self::sphere(ball.radius * factor.x),
            Form::Ball(ball) => Self::hull(&stretch(&rings(ball.radius, 0.0))),
            Form::Capsule(c) if even => {
                Self::capsule(c.radius * factor.x, 2.0 * c.half_height * factor.x)
            }
            Form::Capsule(c) => Self::hull(&stretch(&rings(c.radius, c.half_height))),
            Form::Cuboid(cuboid) => Self::cuboid(2.0 * cuboid.half_size * factor),
            Form::Cylinder(c) if across => {
                Self::cylinder(c.radius * factor.x, 2.0 * c.half_height * factor.y)
            }
            Form::Cylinder(c) => {
                let up = Vec3::Y * c.half_height;
                let ring = ring(c.radius);
                let ends: Vec<Vec3> = ring.iter().flat_map(|&p| [p + up, p - up]).collect();
                Self::hull(&stretch(&ends))
            }
            Form::Hull(hull) => Self::hull(&stretch(&hull.points)),
            Form::Mesh(mesh) => Self::mesh(stretch(&mesh.vertices), mesh.triangles.clone()),
            Form::Heights(heights) => {
                let scaled: Heights = heights.scaled(factor)?;
                Ok(Self::of(Form::Heights(Arc::new(scaled))))
            }
        }
    }
}

/// Points of a circle about the y axis.
fn ring(radius: f32) -> [Vec3; SIDES] {
    std::array::from_fn(|i| {
        let angle = std::f64::consts::TAU * i as f64 / SIDES as f64;
        Vec3::new(radius * libm::cos(angle) as f32, 0.0, radius * libm::sin(angle) as f32)
    })
}

/// Points of a sphere, or of the caps of a capsule: rings and the two poles.
fn rings(radius: f32, half_height: f32) -> Vec<Vec3> {
    let mut points = vec![Vec3::Y * (radius + half_height), Vec3::NEG_Y * (radius + half_height)];
    for latitude in 0..SIDES / 4 {
        let angle = std::f64::consts::TAU * latitude as f64 / SIDES as f64;
        let up = radius * libm::sin(angle) as f32 + half_height;
        for p in ring(radius * libm::cos(angle) as f32) {
            points.extend([p.with_y(up), p.with_y(-up)]);
        }
    }
    points
}
