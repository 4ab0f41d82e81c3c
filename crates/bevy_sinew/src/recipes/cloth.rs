//! Cloth: a rectangular grid, or any mesh.

use bevy::prelude::*;
use sinew::recipes::{Blueprint, ClothMaterial, ClothSpec, cloth_from_mesh, cloth_grid, grid_uvs};

use super::build::{MeshShape, Recipe};
use crate::components::{CreationOrder, ParticleBody};
use crate::messages::Refusal;

/// A piece of cloth. It deforms a mesh: a generated one for a grid, or a copy of the mesh that it was made from.
///
/// It collides with everything but itself, by its triangles if its particles are too far apart to close the surface
/// ([`ContactShape::Auto`](crate::ContactShape)). With [`BodyContacts::ALL`](crate::BodyContacts::ALL) it also collides with itself.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # fn spawn(mut commands: Commands) {
/// let flag = Cloth::grid(1.5, 1.0, 24, 16).pinned(ClothPins::LeftEdge);
/// commands.spawn((flag, Transform::from_xyz(0.0, 3.0, 0.0)));
/// commands.spawn(Wind { pressure: Vec3::X * 5.0, gusts: 0.4, ..default() });
/// # }
/// ```
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(ParticleBody, CreationOrder)]
pub struct Cloth {
    /// The shape. Default a grid of 1 m × 1 m in 20 × 20 cells.
    pub shape: ClothShape,
    /// The particles that are pinned. Default none.
    pub pins: ClothPins,
    /// Mass per area, kg/m². Default 0.2, plain cotton.
    pub density: f32,
    /// Compliance of the threads (the inverse of their stiffness), m/N. Default 0: the cloth does not stretch.
    pub stretch_compliance: f32,
    /// Compliance of folds, m/N; `None` for no resistance to bending. Default 1.
    pub bend_compliance: Option<f32>,
    /// Radius of every particle, metres: the gap between cloth and ground. Default 0.005.
    pub radius: f32,
}

/// The shape of a cloth.
#[derive(Reflect, Clone, Debug, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
#[non_exhaustive]
pub enum ClothShape {
    /// A rectangle about the origin of the body's xy plane, in equal cells, with a generated mesh with texture coordinates.
    Grid {
        /// Length along x, metres.
        width: f32,
        /// Length along y, metres.
        height: f32,
        /// Number of cells along x.
        columns: u32,
        /// Number of cells along y.
        rows: u32,
    },
    /// The triangles of the entity's `Mesh3d`, once it is loaded. Vertices at the same position (as at texture seams) become one particle. The entity gets a
    /// copy of the mesh, so that other entities with the same handle are not affected.
    Mesh,
}

/// The particles of a cloth that are pinned. Edges and corners are in the body's own frame.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # fn example(mut commands: Commands) {
/// // A flag on its pole, and a towel on one nail.
/// commands.spawn(Cloth::grid(1.5, 1.0, 24, 16).pinned(ClothPins::LeftEdge));
/// commands.spawn(Cloth::grid(0.5, 1.0, 10, 20).pinned(ClothPins::Particles(vec![0])));
/// # }
/// ```
#[derive(Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
#[non_exhaustive]
pub enum ClothPins {
    /// None: the cloth falls.
    #[default]
    None,
    /// The two ends of its upper edge.
    TopCorners,
    /// Its upper edge: all particles within a thousandth of its height of its highest point.
    TopEdge,
    /// Its left edge, like a flag on its pole.
    LeftEdge,
    /// The four corners of its bounding rectangle.
    Corners,
    /// The particles with these indices: row by row on a grid; on a mesh, the particles that these vertices follow.
    Particles(Vec<u32>),
}

impl Default for ClothShape {
    fn default() -> Self {
        Self::Grid { width: 1.0, height: 1.0, columns: 20, rows: 20 }
    }
}

impl Default for Cloth {
    fn default() -> Self {
        let material = ClothMaterial::default();
        Self {
            shape: ClothShape::default(),
            pins: ClothPins::None,
            density: material.density,
            stretch_compliance: material.stretch_compliance,
            bend_compliance: material.bend_compliance,
            radius: material.radius,
        }
    }
}

impl Cloth {
    /// A grid of `width` × `height` metres in `columns` × `rows` cells.
    pub fn grid(width: f32, height: f32, columns: u32, rows: u32) -> Self {
        Self { shape: ClothShape::Grid { width, height, columns, rows }, ..default() }
    }

    /// Cloth in the shape of the entity's `Mesh3d`.
    pub fn from_mesh() -> Self {
        Self { shape: ClothShape::Mesh, ..default() }
    }

    /// Returns the same cloth with pins.
    pub fn pinned(self, pins: ClothPins) -> Self {
        Self { pins, ..self }
    }

    fn material(&self) -> ClothMaterial {
        ClothMaterial {
            density: self.density,
            stretch_compliance: self.stretch_compliance,
            bend_compliance: self.bend_compliance,
            radius: self.radius,
            ..default()
        }
    }

    /// The solver's grid, scaled; `None` for a mesh.
    fn spec(&self, scale: Vec3) -> Option<ClothSpec> {
        match self.shape {
            ClothShape::Grid { width, height, columns, rows } => Some(ClothSpec {
                width: width * scale.x.abs(),
                height: height * scale.y.abs(),
                columns,
                rows,
                material: self.material(),
                ..default()
            }),
            ClothShape::Mesh => None,
        }
    }
}

impl Recipe for Cloth {
    fn wants_mesh(&self) -> bool {
        self.shape == ClothShape::Mesh
    }

    fn blueprint(&self, mesh: Option<&MeshShape>, scale: Vec3) -> Result<Blueprint, Refusal> {
        let mut blueprint = match (self.spec(scale), mesh) {
            (Some(spec), _) => cloth_grid(&spec)?,
            (None, Some(mesh)) => {
                let scaled: Vec<Vec3> = mesh.positions.iter().map(|p| *p * scale).collect();
                cloth_from_mesh(&scaled, mesh.triangles.as_flattened(), &self.material())?
            }
            (None, None) => return Err(Refusal::NoMesh),
        };
        for pin in self.pins.choose(&blueprint) {
            // All chosen particles exist: an index beyond the last one was ignored.
            let _ = blueprint.pin(pin);
        }
        Ok(blueprint)
    }

    fn uvs(&self) -> Option<Vec<[f32; 2]>> {
        self.spec(Vec3::ONE).and_then(|spec| grid_uvs(&spec).ok())
    }
}

impl ClothPins {
    /// The particles to pin, by their rest positions.
    fn choose(&self, blueprint: &Blueprint) -> Vec<u32> {
        let at = |i: &u32| blueprint.particles[*i as usize].position;
        let all = 0..blueprint.particles.len() as u32;
        let (min, max) = all.clone().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(min, max), i| {
            (min.min(at(&i)), max.max(at(&i)))
        });
        let near = (max - min) * 1e-3;
        let top = |i: &u32| at(i).y >= max.y - near.y;
        let ends = |edge: Vec<u32>| -> Vec<u32> {
            let left = edge.iter().copied().min_by(|a, b| at(a).x.total_cmp(&at(b).x));
            let right = edge.iter().copied().max_by(|a, b| at(a).x.total_cmp(&at(b).x));
            left.into_iter().chain(right).collect()
        };
        match self {
            Self::None => Vec::new(),
            Self::TopCorners => ends(all.filter(top).collect()),
            Self::TopEdge => all.filter(top).collect(),
            Self::LeftEdge => all.filter(|i| at(i).x <= min.x + near.x).collect(),
            Self::Corners => {
                let bottom = |i: &u32| at(i).y <= min.y + near.y;
                let mut corners = ends(all.clone().filter(top).collect());
                corners.extend(ends(all.filter(bottom).collect()));
                corners
            }
            // On a grid, vertices and particles have the same indices; the particles of a mesh are in the solver's order.
            Self::Particles(list) => {
                let particle = |vertex: &u32| blueprint.vertices.get(*vertex as usize).copied();
                list.iter().filter_map(particle).collect()
            }
        }
    }
}
