//! Looks that go into a file: a mesh is a handle of one run of the program, the words that it is made from are not.

use std::collections::BTreeMap;

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;
use bevy_sinew::{BodyPart, MeshFollow, PartOf, WindSurface};

use crate::bevy_version::OnAdd;
use crate::look::Look;
use crate::scene::InScene;
use crate::shapes::{ball, cylinder, part_mesh, rounded_box};

/// What an entity is drawn as, as words. Part of the state, saved along: what comes back from a file is given its mesh and its [`Look`] again.
///
/// Without it an entity of a scene has its mesh and its look by itself, and comes back from a file without either.
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
    /// What its body makes: a cloth, a rope, a soft body, the limbs of a ragdoll. The default.
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

    /// A surface of what the body makes as its mesh.
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

/// Gives what has a skin its look and its mesh, as soon as it has it: the limbs of a figure take on the look that it has when they are made.
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

/// Gives what has come back from a file its look, and the mesh that its body once made. (What is not saved is taken away from what comes back, so that the
/// observer alone comes too early.)
pub(crate) fn dress_again(
    mut commands: Commands,
    plain: Query<(Entity, &Skin), Without<Look>>,
    bare: Query<(Entity, &MeshFollow, &WindSurface), (With<Skin>, Without<Mesh3d>)>,
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

/// The triangles of a body as a mesh whose vertices follow its particles. Positions and normals are filled in by the simulation.
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
