//! Solids: rigid bodies of any shape, out of four or eight particles that weigh and turn exactly as they do.

use bevy::prelude::*;
use sinew::Shape;
use sinew::recipes::{Blueprint, RecipeFault, SolidLayout, SolidSpec, solid};

use super::bind::attach;
use super::build::{MeshShape, Recipe};
use super::rigid_box::pose_of;
use crate::components::{Collider, CreationOrder, ParticleBody, Sleep};
use crate::messages::Refusal;
use crate::same::same_variants;

/// A rigid body in the shape of its mesh. Its mass, barycentre and inertia are those of the shape filled evenly ([`sinew::recipes::solid`]).
///
/// Its particles are inside, about half way out: it meets the ground with these (see `radius`), unless it collides by its hull
/// ([`BodyContacts`](crate::BodyContacts)), and wind does not press on it. Its `Transform` says
/// where it is built, and then follows it; the scale is that of the shape. The mesh is drawn as it is, and others may share it. To have it float by
/// its shape, give it [`Floats::mesh`](crate::Floats::mesh).
///
/// What is round is best said so: a [`RigidShape::Sphere`], a `Capsule` or a `Cylinder` weighs, collides and rolls as exactly that, where the hull of its
/// mesh has corners.
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
    /// What it looks like. Default its mesh.
    pub shape: RigidShape,
    /// How much of it there is. Default 1 kg.
    pub bulk: Bulk,
    /// Which particles stand for it. Default eight.
    pub particles: RigidParticles,
    /// Radius of every particle, metres, 0 and up. Default 0.
    pub radius: f32,
}

/// The shape of a [`RigidMesh`].
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # fn example(mut commands: Commands) {
/// commands.spawn(RigidMesh { shape: RigidShape::Sphere { radius: 0.3 }, ..default() });
/// // Whatever the mesh beside it shows.
/// commands.spawn((RigidMesh::default(), Mesh3d::default(), Mass(3.0)));
/// # }
/// ```
#[derive(Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
#[non_exhaustive]
pub enum RigidShape {
    /// The inside of the entity's `Mesh3d`, once it is loaded: a closed surface that faces outwards, dents and all. The default.
    #[default]
    Mesh,
    /// The convex hull of the entity's `Mesh3d`, once it is loaded: for a mesh that is not closed.
    Hull,
    /// The convex hull of these points, metres in the body's own frame. It needs no mesh.
    Points(Vec<Vec3>),
    /// A ball of this radius, metres, about the origin. It needs no mesh.
    Sphere {
        /// Metres.
        radius: f32,
    },
    /// A capsule along y, of this radius and, without its round ends, this length, metres, as Bevy's `Capsule3d`. It needs no mesh.
    Capsule {
        /// Metres.
        radius: f32,
        /// Of its straight part, metres.
        length: f32,
    },
    /// A cylinder along y, of this radius and height, metres, as Bevy's `Cylinder`. It needs no mesh.
    Cylinder {
        /// Metres.
        radius: f32,
        /// Metres.
        height: f32,
    },
}

impl RigidShape {
    /// What is round, in another size; `None` of what is made of points.
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

/// How much of a [`RigidMesh`] or a [`SoftBody`](crate::SoftBody) there is.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
pub enum Bulk {
    /// Its mass, kg, 1e-9 to 1e12. Default 1.
    Mass(f32),
    /// Its density, kg/m³: water has 1000.
    Density(f32),
}

/// Which particles stand for a [`RigidMesh`].
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum RigidParticles {
    /// Eight, all 28 pairs tied. The default.
    #[default]
    Eight,
    /// Four, all 6 pairs tied: the same mass and inertia for less than a quarter of the work.
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
    /// In the shape of its mesh, with a mass in kg.
    pub fn mass(mass: f32) -> Self {
        Self { bulk: Bulk::Mass(mass), ..default() }
    }

    /// In the shape of its mesh, with a density in kg/m³.
    pub fn density(density: f32) -> Self {
        Self { bulk: Bulk::Density(density), ..default() }
    }

    /// The same in another shape.
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
        // As a box: rods bleed the spin of what they hold unless they act along where they were.
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
