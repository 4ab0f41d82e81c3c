//! Soft bodies: a skin around a volume, made from a mesh, or a solid soft box or ball.

use bevy::prelude::*;
use sinew::recipes::{
    Blueprint, SoftLatticeSpec, SoftMeshSpec, SoftShape as Lattice, soft_lattice, soft_mesh,
};

use super::build::{MeshShape, Recipe};
use super::rigid_mesh::Bulk;
use crate::components::{CreationOrder, ParticleBody, Sleep, Softness};
use crate::frames::even_factor;
use crate::messages::Refusal;

/// A soft body: an inflated ball, a cushion, a cube of jelly. It deforms a mesh: a generated one, or a copy of the one it was made from.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// fn spawn(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>) {
///     let ball = meshes.add(Sphere::new(0.4).mesh().ico(3).unwrap());
///     commands.spawn((SoftBody { pressure: 1.1, ..SoftBody::from_mesh() }, Mesh3d(ball)));
///     commands.spawn((SoftBody::cuboid(Vec3::splat(0.5), UVec3::splat(4)), Transform::from_xyz(2.0, 1.0, 0.0)));
/// }
/// ```
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(ParticleBody, CreationOrder, Sleep)]
pub struct SoftBody {
    /// The shape. Default a cube of 1 m in 4 × 4 × 4 cells.
    pub shape: SoftShape,
    /// Mass or density. Default 100 kg/m³; 1 kg from a mesh.
    pub bulk: Bulk,
    /// Damping ratio of its constraints, 0 (undamped) to 10. Default 0.3; 0.1 from a mesh.
    pub damping: f32,
    /// Radius of every particle, metres, 0 or more: the gap between body and ground. Default 0.005. Rigid bodies collide only with particles that have a
    /// radius.
    pub radius: f32,
    /// From a mesh: stiffness of the skin against stretching, N/m, 1e-6 to 1e9. Default 100, that of 0.1 mm of rubber.
    pub stretch: f32,
    /// From a mesh: stiffness of the skin against bending, N·m, 0 or more. Default 0.01.
    pub bend: f32,
    /// From a mesh: the volume that is kept, as a multiple of that of the mesh, 0.01 to 100. Default 1; more puts the skin under tension, like the pressure in
    /// a ball.
    pub pressure: f32,
    /// From a mesh: how hard the volume is kept. Default hard; with a soft one the body can be squashed.
    pub softness: Softness,
    /// A box or a ball: Young's modulus, Pa, 1e-3 to 1e12. Default 2e4 (gelatine 1e3 to 1e5, rubber 1e6). Stiff bodies need more substeps
    /// ([`SoftLatticeSpec::stiffness`]).
    pub stiffness: f32,
    /// A box or a ball: Poisson's ratio, the sideways expansion relative to the compression, 0.25 to 0.49. Default 0.35.
    pub poisson: f32,
}

/// The shape of a [`SoftBody`].
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::SoftShape;
/// # fn example(mut commands: Commands) {
/// let shape = SoftShape::Ball { radius: 0.4, cells: 6 };
/// commands.spawn(SoftBody { shape, ..default() });
/// # }
/// ```
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
#[non_exhaustive]
pub enum SoftShape {
    /// The entity's `Mesh3d`, once it is loaded, as a skin around a volume: closed, facing outwards. Vertices at the same position become one particle. The
    /// entity gets a copy of the mesh, so that other entities with the same handle are not affected.
    Mesh,
    /// A box about the body's origin, soft throughout, with a generated mesh.
    Cuboid {
        /// Edge lengths, metres, 1e-6 to 1e6.
        size: Vec3,
        /// Number of cells along each edge, 1 or more. Cells should be nearly cubes.
        cells: UVec3,
    },
    /// A ball about the body's origin, soft throughout, with a generated mesh.
    Ball {
        /// Radius, metres, 1e-6 to 1e6.
        radius: f32,
        /// Number of cells across, 1 or more; rounded up to an even number.
        cells: u32,
    },
}

impl Default for SoftShape {
    fn default() -> Self {
        Self::Cuboid { size: Vec3::ONE, cells: UVec3::splat(4) }
    }
}

impl Default for SoftBody {
    fn default() -> Self {
        let (skin, flesh) = (SoftMeshSpec::default(), SoftLatticeSpec::default());
        Self {
            shape: SoftShape::default(),
            bulk: Bulk::Density(100.0),
            damping: flesh.damping,
            radius: skin.radius,
            stretch: skin.stretch,
            bend: skin.bend,
            pressure: skin.pressure,
            softness: skin.softness.into(),
            stiffness: flesh.stiffness,
            poisson: flesh.poisson,
        }
    }
}

impl SoftBody {
    /// A skin in the shape of the entity's `Mesh3d`, with 1 kg, which keeps its volume.
    pub fn from_mesh() -> Self {
        let skin = SoftMeshSpec::default();
        Self {
            shape: SoftShape::Mesh,
            bulk: Bulk::default(),
            damping: skin.damping,
            radius: skin.radius,
            ..default()
        }
    }

    /// A box with these edge lengths, metres, and this number of cells along each.
    pub fn cuboid(size: Vec3, cells: UVec3) -> Self {
        Self { shape: SoftShape::Cuboid { size, cells }, ..default() }
    }

    /// A ball with this radius, metres, and this number of cells across.
    pub fn ball(radius: f32, cells: u32) -> Self {
        Self { shape: SoftShape::Ball { radius, cells }, ..default() }
    }

    /// Returns the same body with another mass, kg.
    pub fn with_mass(self, mass: f32) -> Self {
        Self { bulk: Bulk::Mass(mass), ..self }
    }

    /// Returns the same body with another density, kg/m³.
    pub fn with_density(self, density: f32) -> Self {
        Self { bulk: Bulk::Density(density), ..self }
    }

    fn lattice(&self, shape: Lattice) -> SoftLatticeSpec {
        SoftLatticeSpec {
            shape,
            bulk: self.bulk.into(),
            stiffness: self.stiffness,
            poisson: self.poisson,
            damping: self.damping,
            radius: self.radius,
            ..default()
        }
    }

    fn skin(&self) -> SoftMeshSpec {
        SoftMeshSpec {
            bulk: self.bulk.into(),
            stretch: self.stretch,
            bend: self.bend,
            damping: self.damping,
            pressure: self.pressure,
            softness: self.softness.into(),
            radius: self.radius,
            ..default()
        }
    }
}

impl Recipe for SoftBody {
    fn wants_mesh(&self) -> bool {
        self.shape == SoftShape::Mesh
    }

    fn blueprint(&self, mesh: Option<&MeshShape>, scale: Vec3) -> Result<Blueprint, Refusal> {
        Ok(match (self.shape, mesh) {
            (SoftShape::Cuboid { size, cells }, _) => {
                soft_lattice(&self.lattice(Lattice::Box { size: size * scale.abs(), cells }))?
            }
            (SoftShape::Ball { radius, cells }, _) => {
                let radius = radius * even_factor(scale)?;
                soft_lattice(&self.lattice(Lattice::Ball { radius, cells }))?
            }
            (SoftShape::Mesh, Some(mesh)) => {
                let scaled: Vec<Vec3> = mesh.positions.iter().map(|p| *p * scale).collect();
                soft_mesh(&self.skin(), &scaled, mesh.faces(scale).as_flattened())?
            }
            (SoftShape::Mesh, None) => return Err(Refusal::NoMesh),
        })
    }
}
