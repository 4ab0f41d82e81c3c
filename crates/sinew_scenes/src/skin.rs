//! Looks that can be saved: a mesh is a handle that is valid in one run of the program only, so the recipe for the mesh is saved instead.

use std::collections::BTreeMap;

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;
use bevy_sinew::{BodyPart, Cloth, MeshFollow, PartOf, SoftBody, WindSurface};

use crate::bevy_version::OnAdd;
use crate::look::Look;
use crate::scene::InScene;
use crate::shapes::{ball, cylinder, part_mesh, rounded_box};

/// Recipe for the mesh and the surface of an entity. It is part of the saved state: an entity that is loaded from a file gets its mesh and its [`Look`] from
/// it.
///
/// Without it an entity of a scene has its own mesh and look, and is loaded from a file without either.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct Skin {
    /// Its mesh.
    pub shape: SkinShape,
    /// Its surface.
    pub look: Look,
}

/// The mesh of a [`Skin`]. Lengths are metres.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
pub enum SkinShape {
    /// The mesh that its body builds: a cloth, a rope, a soft body, the limbs of a ragdoll. The default.
    #[default]
    Own,
    /// A box with rounded edges.
    Box {
        /// Lengths of its edges.
        size: Vec3,
        /// Radius of the rounding.
        rounding: f32,
    },
    /// A ball with its texture wrapped around the y axis.
    Ball {
        /// Its radius.
        radius: f32,
    },
    /// A cylinder along y.
    Cylinder {
        /// Its radius.
        radius: f32,
        /// Its height.
        height: f32,
    },
}

impl Skin {
    /// A mesh and a surface.
    pub fn new(shape: SkinShape, look: Look) -> Self {
        Self { shape, look }
    }

    /// A surface for the mesh that the body builds.
    pub fn own(look: Look) -> Self {
        Self { shape: SkinShape::Own, look }
    }

    /// A box with edges rounded by 15 mm.
    pub fn cuboid(size: Vec3, look: Look) -> Self {
        Self { shape: SkinShape::Box { size, rounding: 0.015 }, look }
    }
}

impl SkinShape {
    fn mesh(self) -> Option<Mesh> {
        match self {
            Self::Own => None,
            Self::Box { size, rounding } => Some(rounded_box(size, rounding, 2)),
            Self::Ball { radius } => Some(ball(radius)),
            Self::Cylinder { radius, height } => Some(cylinder(radius, height)),
        }
    }
}

/// Inserts the look and the mesh of an added skin at once, because limbs of a ragdoll take the look that the body has when they are built.
pub(crate) fn dress(
    added: OnAdd<Skin>,
    mut commands: Commands,
    skins: Query<&Skin>,
    meshes: Option<ResMut<Assets<Mesh>>>,
) {
    let Ok(skin) = skins.get(added.entity) else { return };
    let mut entity = commands.entity(added.entity);
    entity.insert((InScene, skin.look.clone()));
    if let Some((mut meshes, mesh)) = meshes.zip(skin.shape.mesh()) {
        entity.insert(Mesh3d(meshes.add(mesh)));
    }
}

/// Inserts the look, and the mesh that the body built, into entities that were loaded from a file. The observer alone is not enough: loading removes components
/// that are not saved, after the observer has run.
pub(crate) fn dress_again(
    mut commands: Commands,
    plain: Query<(Entity, &Skin), Without<Look>>,
    bare: Query<
        (Entity, &MeshFollow, &WindSurface),
        // Cloth and soft bodies have one from their recipes.
        (With<Skin>, Without<Mesh3d>, Without<Cloth>, Without<SoftBody>),
    >,
    parts: Query<(Entity, &BodyPart, &Name, &PartOf), Without<Mesh3d>>,
    bodies: Query<&Look, With<Skin>>,
    meshes: Option<ResMut<Assets<Mesh>>>,
) {
    for (entity, skin) in &plain {
        commands.entity(entity).insert((InScene, skin.look.clone()));
    }
    let Some(mut meshes) = meshes else { return };
    for (entity, follow, surface) in &bare {
        commands.entity(entity).insert(Mesh3d(meshes.add(surface_mesh(follow, surface))));
    }
    for (entity, part, name, body) in &parts {
        if let Ok(look) = bodies.get(body.0) {
            let mesh = Mesh3d(meshes.add(part_mesh(part, name)));
            commands.entity(entity).insert((mesh, look.clone()));
        }
    }
}

/// The triangles of a body as a mesh whose vertices follow its particles. The simulation fills in positions and normals.
fn surface_mesh(follow: &MeshFollow, surface: &WindSurface) -> Mesh {
    let numbers: BTreeMap<Entity, u32> = follow.vertices.iter().copied().zip(0..).collect();
    let corners = surface.triangles.iter().filter_map(|triangle| {
        let [a, b, c] = triangle.map(|corner| numbers.get(&corner).copied());
        Some([a?, b?, c?])
    });
    let vertices = follow.vertices.len();
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, vec![[0.0_f32; 3]; vertices])
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, vec![[0.0_f32, 1.0, 0.0]; vertices])
        .with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, vec![[0.0_f32; 2]; vertices])
        .with_inserted_indices(Indices::U32(corners.flatten().collect()))
}
