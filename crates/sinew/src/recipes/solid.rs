//! Any solid as four or eight particles with exactly its mass and inertia (physics.md B2): equimomental particles.
//!
//! # Why so few are enough
//!
//! The motion of a rigid body under forces depends on ten numbers: its mass, its barycentre and its six second moments `M S`, where `S` is the mean of `x xᵀ`
//! over the solid, with `x` relative to the barycentre ([`MassProperties`]). Along its principal axes `S` is diagonal, with `s₁`, `s₂`, `s₃`. Particles of
//! equal mass `M/n` at `(±√s₁, ±√s₂, ±√s₃)` from the barycentre have
//!
//! - the mass `M`, being `n` times `M/n`;
//! - the second moment `n · M/n · s₁ = M s₁` along the first axis, and so on: each is at the root mean square distance of the solid;
//! - the same barycentre and no mixed moments, if over all particles the signs, and the products of two signs, sum to zero.
//!
//! All **eight** choices of signs satisfy that, and so do the **four** with an even number of minus signs, which are every other corner of the same box: `+++
//! +-- -+- --+`. Each column sums to zero, and the products of the first two are `+ - - +`. Fewer than four particles cannot span a volume. A solid box has `s₁
//! = a²/12`: its particles are at `½a/√3`, those of [`BoxLayout::Equimomental`](super::BoxLayout).

use glam::Vec3;

use super::blueprint::{Blueprint, Part};
use super::fault::{RecipeFault, check_mass, check_particles, ensure};
use super::limits::LENGTHS;
use super::mass::MassProperties;
use super::nearest::bounds;
use crate::collide::Shape;
use crate::convex_hull::convex_hull;

/// A solid to build. The default has an empty shape, and is refused.
#[derive(Clone, Debug, PartialEq)]
pub struct SolidSpec {
    /// The shape.
    pub shape: SolidShape,
    /// Mass or density. Default 1 kg.
    pub bulk: Bulk,
    /// Number and arrangement of the particles. Default eight.
    pub layout: SolidLayout,
    /// Radius of every particle, metres, 0 or more. Default 0. The particles are inside the solid, about half way out.
    pub radius: f32,
    /// Share of the velocity lost per second, 0 to 1. Default 0.
    pub drag: f32,
}

/// The shape of a solid, in metres. Its coordinates become the body's own frame, so the mesh can be drawn unchanged with the extracted transform, wherever its
/// origin is.
#[derive(Clone, Debug, PartialEq)]
pub enum SolidShape {
    /// A closed surface, counter-clockwise from outside; see [`MassProperties::of_mesh`] for the requirements.
    Mesh {
        /// Corners of the triangles, metres.
        vertices: Vec<Vec3>,
        /// Triangles between the vertices.
        triangles: Vec<[u32; 3]>,
    },
    /// The [convex hull](convex_hull) of points, metres: for a mesh that is not closed, or a convex collider.
    Hull(Vec<Vec3>),
    /// A collision shape with an interior: a sphere, a capsule, a box, a cylinder or a hull. Mass, inertia and collision are exactly those of the shape. A ball
    /// of this kind rolls.
    Collider(Shape),
}

/// The amount of material of a solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bulk {
    /// Its mass, kg, 1e-9 to 1e12.
    Mass(f32),
    /// Its density, kg/m³ (water has 1000), such that the mass is between 1e-9 and 1e12 kg.
    Density(f32),
}

impl Bulk {
    /// The mass of a body of `volume` m³, kg.
    pub(super) fn mass_of(self, volume: f64) -> Result<f64, RecipeFault> {
        let mass = match self {
            Self::Mass(mass) => f64::from(mass),
            Self::Density(density) => f64::from(density) * volume,
        };
        check_mass(mass as f32)?;
        Ok(mass)
    }
}

/// The particles that represent a solid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum SolidLayout {
    /// Eight, at the corners of a box along the principal axes, with all 28 pairs connected. The default: it spreads the solver's corrections best.
    ///
    /// Particle `i` is on the positive side of the axes nearest to x, y and z where bit 0, 1 and 2 of `i` is set.
    #[default]
    Eight,
    /// Four, at every other corner of that box, with all 6 pairs connected: the same mass, barycentre and inertia with less than a quarter of the work.
    Four,
}

impl Default for SolidSpec {
    fn default() -> Self {
        Self {
            shape: SolidShape::Hull(Vec::new()),
            bulk: Bulk::Mass(1.0),
            layout: SolidLayout::default(),
            radius: 0.0,
            drag: 0.0,
        }
    }
}

impl SolidShape {
    /// Mass properties of the interior of the shape.
    ///
    /// # Errors
    /// [`RecipeFault::Inside`] for an unsuitable mesh, [`RecipeFault::Hull`] for points without a hull, [`RecipeFault::Shape`] for a shape without an interior.
    pub fn mass_properties(&self) -> Result<MassProperties, RecipeFault> {
        Ok(match self {
            Self::Mesh { vertices, triangles } => MassProperties::of_mesh(vertices, triangles)?,
            Self::Hull(points) => MassProperties::of_mesh(points, &convex_hull(points)?)?,
            Self::Collider(shape) => MassProperties::of_shape(shape).ok_or(RecipeFault::Shape)?,
        })
    }

    /// The corners of the bounding box, metres.
    fn bounds(&self) -> [Vec3; 2] {
        match self {
            Self::Mesh { vertices: points, .. } | Self::Hull(points) => {
                bounds(points.iter().copied())
            }
            Self::Collider(shape) => shape.bounds().into(),
        }
    }

    /// The collision shape. A mesh collides by its convex hull, because contacts between two hulls are fast.
    fn collider(&self) -> Option<Shape> {
        match self {
            Self::Mesh { vertices: points, .. } | Self::Hull(points) => Shape::hull(points).ok(),
            Self::Collider(shape) => Some(shape.clone()),
        }
    }
}

/// Builds a solid of any shape and uniform density: 4 or 8 particles, all pairs connected, one part named `"solid"`.
///
/// The size of the part is that of the shape's bounding box. There are no triangles: the particles are inside, where no wind acts.
///
/// # Errors
/// A [`RecipeFault`] if a value is out of range or the shape is unsuitable.
pub fn solid(spec: &SolidSpec) -> Result<Blueprint, RecipeFault> {
    check_particles(spec.radius, spec.drag)?;
    let properties = spec.shape.mass_properties()?;
    let [low, high] = spec.shape.bounds();
    let size = high - low;
    ensure(LENGTHS.contains(&size.max_element()), RecipeFault::Size)?;
    let mass = spec.bulk.mass_of(properties.volume)? as f32;
    let rest = places(&properties, spec.layout);
    ensure(is_resolved(&rest, &properties), RecipeFault::Size)?;
    let count = rest.len() as u32;
    let mut body = Blueprint::fully_connected(&rest, mass, spec.radius, spec.drag);
    let shape = spec.shape.collider();
    body.parts = vec![Part { name: "solid", particles: (0..count).collect(), rest, size, shape }];
    Ok(body)
}

/// Positions of the particles in the coordinates of the mesh.
fn places(properties: &MassProperties, layout: SolidLayout) -> Vec<Vec3> {
    let (squares, axes) = properties.principal();
    let reach = squares.map(f64::sqrt);
    let corner = |&i: &u32| {
        let side = |k: usize| {
            if i >> k & 1 == 1 { axes.col(k) * reach[k] } else { axes.col(k) * -reach[k] }
        };
        (properties.barycentre + side(0) + side(1) + side(2)).as_vec3()
    };
    match layout {
        SolidLayout::Eight => [0, 1, 2, 3, 4, 5, 6, 7].iter().map(corner).collect(),
        // Those with an even number of minus signs.
        SolidLayout::Four => [7, 1, 2, 4].iter().map(corner).collect(),
    }
}

/// Whether the rounded positions are accurate to a hundredth of the shortest distance between two particles.
fn is_resolved(rest: &[Vec3], properties: &MassProperties) -> bool {
    let shortest = 2.0 * properties.principal().0.min_element().sqrt();
    let farthest = rest.iter().fold(0.0, |far: f32, r| far.max(r.abs().max_element()));
    f64::from(farthest) * f64::from(f32::EPSILON) <= 1e-2 * shortest
}

#[cfg(test)]
mod tests;
