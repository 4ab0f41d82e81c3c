//! Rigid bodies of any shape, made of four or eight particles with exactly the mass and inertia of the shape.

use bevy::prelude::*;
use sinew::Shape;
use sinew::recipes::{Blueprint, RecipeFault, SolidLayout, SolidSpec, solid};

use super::bind::attach;
use super::build::{MeshShape, Recipe};
use super::rigid_box::pose_of;
use crate::components::{Collider, CreationOrder, ParticleBody, Sleep};
use crate::messages::Refusal;
use crate::same::same_variants;

/// A rigid body in the shape of its mesh. Its mass, centre of mass and inertia are those of the shape with a uniform density ([`sinew::recipes::solid`]).
///
/// It collides by the convex hull of its shape, unless its [`BodyContacts`](crate::BodyContacts) are by particles: these are inside, about half way to the
/// surface (see `radius`). Wind does not act on it. It is built at its `Transform`, which then follows it; the scale applies to the shape. The mesh is not
/// changed, and other entities may share it. To make it float by its shape, add [`Floats::mesh`](crate::Floats::mesh).
///
/// For a round body use [`RigidShape::Sphere`], `Capsule` or `Cylinder`: it has exactly that mass distribution, collides and rolls as that shape, while the
/// hull of a mesh has corners.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// fn spawn(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>) {
///     let top = meshes.add(Cone::new(0.3, 0.5));
///     commands.spawn((RigidMesh::density(700.0), Mesh3d(top), Transform::from_xyz(0.0, 1.0, 0.0)));
///     let ball = RigidMesh::density(700.0).shaped(RigidShape::Sphere { radius: 0.3 });
///     let mesh = meshes.add(Sphere::new(0.3));
///     commands.spawn((ball, Mesh3d(mesh), Transform::from_xyz(1.0, 1.0, 0.0)));
/// }
/// ```
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(ParticleBody, CreationOrder, Sleep)]
#[doc(alias = "Solid")]
pub struct RigidMesh {
    /// The shape. Default the mesh.
    pub shape: RigidShape,
    /// Mass or density. Default 1 kg.
    pub bulk: Bulk,
    /// The number of particles. Default eight.
    pub particles: RigidParticles,
    /// Radius of every particle, metres, 0 or more. Default 0.
    pub radius: f32,
}

/// The shape of a [`RigidMesh`].
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # fn example(mut commands: Commands) {
/// commands.spawn(RigidMesh { shape: RigidShape::Sphere { radius: 0.3 }, ..default() });
/// // The shape of the mesh on the same entity.
/// commands.spawn((RigidMesh::default(), Mesh3d::default(), Mass(3.0)));
/// # }
/// ```
#[derive(Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
#[non_exhaustive]
pub enum RigidShape {
    /// The inside of the entity's `Mesh3d`, once it is loaded: a closed surface that faces outwards, which need not be convex. The default.
    #[default]
    Mesh,
    /// The convex hull of the entity's `Mesh3d`, once it is loaded: for a mesh that is not closed.
    Hull,
    /// The convex hull of these points, metres in the body's own frame. No mesh is needed.
    Points(Vec<Vec3>),
    /// A ball of this radius, metres, about the origin. No mesh is needed.
    Sphere {
        /// Radius, metres.
        radius: f32,
    },
    /// A capsule along y, like Bevy's `Capsule3d`. No mesh is needed.
    Capsule {
        /// Radius, metres.
        radius: f32,
        /// Length of its straight part, without the hemispherical ends, metres.
        length: f32,
    },
    /// A cylinder along y, like Bevy's `Cylinder`. No mesh is needed.
    Cylinder {
        /// Radius, metres.
        radius: f32,
        /// Height, metres.
        height: f32,
    },
}

impl RigidShape {
    /// The solver's shape of a round body, scaled; `None` for shapes from points.
    fn round(&self, scale: Vec3) -> Option<Result<Shape, RecipeFault>> {
        let shape = match *self {
            Self::Sphere { radius } => Shape::sphere(radius),
            Self::Capsule { radius, length } => Shape::capsule(radius, length),
            Self::Cylinder { radius, height } => Shape::cylinder(radius, height),
            Self::Mesh | Self::Hull | Self::Points(_) => return None,
        };
        Some(shape.and_then(|shape| shape.scaled(scale.abs())).map_err(|_| RecipeFault::Size))
    }
}

/// The mass or the density of a [`RigidMesh`] or a [`SoftBody`](crate::SoftBody).
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
pub enum Bulk {
    /// Mass, kg, 1e-9 to 1e12. Default 1.
    Mass(f32),
    /// Density, kg/m³: water has 1000.
    Density(f32),
}

/// The number of particles of a [`RigidMesh`].
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum RigidParticles {
    /// Eight particles and 28 distances. The default.
    #[default]
    Eight,
    /// Four particles and 6 distances: the same mass and inertia at less than a quarter of the cost.
    Four,
}

impl Default for Bulk {
    fn default() -> Self {
        Self::Mass(1.0)
    }
}

same_variants!(Bulk, sinew::recipes::Bulk { Mass(mass), Density(density) });

impl Default for RigidMesh {
    fn default() -> Self {
        Self {
            shape: RigidShape::default(),
            bulk: Bulk::default(),
            particles: RigidParticles::default(),
            radius: 0.0,
        }
    }
}

impl RigidMesh {
    /// A body in the shape of its mesh, with a mass in kg.
    pub fn mass(mass: f32) -> Self {
        Self { bulk: Bulk::Mass(mass), ..default() }
    }

    /// A body in the shape of its mesh, with a density in kg/m³.
    pub fn density(density: f32) -> Self {
        Self { bulk: Bulk::Density(density), ..default() }
    }

    /// Returns the same body in another shape.
    pub fn shaped(self, shape: RigidShape) -> Self {
        Self { shape, ..self }
    }
}

impl Recipe for RigidMesh {
    fn wants_mesh(&self) -> bool {
        matches!(self.shape, RigidShape::Mesh | RigidShape::Hull)
    }

    fn blueprint(&self, mesh: Option<&MeshShape>, scale: Vec3) -> Result<Blueprint, Refusal> {
        let scaled = |points: &[Vec3]| points.iter().map(|&p| p * scale).collect::<Vec<_>>();
        let round = self.shape.round(scale).transpose()?;
        let shape = match (round, &self.shape, mesh) {
            (Some(round), ..) => sinew::recipes::SolidShape::Collider(round),
            (None, RigidShape::Points(points), _) => {
                sinew::recipes::SolidShape::Hull(scaled(points))
            }
            (None, RigidShape::Hull, Some(mesh)) => {
                sinew::recipes::SolidShape::Hull(scaled(&mesh.positions))
            }
            (None, RigidShape::Mesh, Some(mesh)) => sinew::recipes::SolidShape::Mesh {
                vertices: scaled(&mesh.positions),
                triangles: mesh.faces(scale),
            },
            _ => return Err(Refusal::NoMesh),
        };
        let layout = match self.particles {
            RigidParticles::Eight => SolidLayout::Eight,
            RigidParticles::Four => SolidLayout::Four,
        };
        let spec =
            SolidSpec { shape, bulk: self.bulk.into(), layout, radius: self.radius, ..default() };
        let mut blueprint = solid(&spec)?;
        // As for boxes: rods lose spin unless they are corrected along their direction at the start of the step.
        blueprint.settings.gradient_at.get_or_insert(sinew::GradientAt::StepStart);
        Ok(blueprint)
    }

    fn collider(&self, blueprint: &Blueprint) -> Option<Collider> {
        blueprint.parts.first()?.shape.clone().map(Collider::from)
    }

    fn finish(&self, world: &mut World, body: Entity, blueprint: &Blueprint, particles: &[Entity]) {
        if let Some(part) = blueprint.parts.first() {
            attach(world, body, pose_of(part, particles));
        }
    }
}
