//! Converts the world into triangles for the software renderer.

use std::collections::BTreeMap;
use std::sync::Arc;

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, VertexAttributeValues};
use bevy::prelude::*;
use bevy::transform::helper::TransformHelper;
use sinew_draw as draw;
use sinew_scenes::{Look, Scene};

/// Textures in the format of the software renderer, kept from frame to frame.
#[derive(Resource, Default)]
pub(crate) struct Textures {
    loaded: BTreeMap<String, (Handle<Image>, Option<Arc<draw::Texture>>)>,
}

/// Starts loading the textures that the scene uses. Runs until [`Textures::ready`] and all meshes are loaded.
pub(crate) fn request_textures(
    looks: Query<&Look>,
    server: Res<AssetServer>,
    images: Res<Assets<Image>>,
    mut textures: ResMut<Textures>,
) {
    for path in looks.iter().filter_map(|look| look.texture.as_ref()) {
        let (handle, texture) = textures
            .loaded
            .entry(path.clone())
            .or_insert_with(|| (server.load(path.clone()), None));
        if texture.is_none()
            && let Some(image) = images.get(&*handle)
        {
            *texture = decode(image).map(Arc::new);
        }
    }
}

impl Textures {
    /// Whether every requested texture is loaded.
    pub(crate) fn ready(&self) -> bool {
        self.loaded.values().all(|(_, texture)| texture.is_some())
    }
}

/// A picture of the current world from the camera of the scene.
pub(crate) fn photograph(
    world: &mut World,
    scene: &Scene,
    width: usize,
    height: usize,
) -> draw::Image {
    let items = world.run_system_cached(collect).unwrap_or_default();
    let camera = draw::Camera { eye: scene.eye, target: scene.target, fov: 0.7 };
    let mut shot = draw::Scene::new(camera);
    shot.items = items;
    draw::render(&shot, width, height)
}

/// Everything with a mesh and a look, in world coordinates.
fn collect(
    things: Query<(Entity, &Mesh3d, &Look)>,
    meshes: Res<Assets<Mesh>>,
    textures: Res<Textures>,
    transforms: TransformHelper,
) -> Vec<draw::Item<'static>> {
    let item = |(entity, handle, look): (Entity, &Mesh3d, &Look)| {
        let mesh = meshes.get(&handle.0)?;
        let frame = transforms.compute_global_transform(entity).ok()?;
        let positions = float3(mesh, Mesh::ATTRIBUTE_POSITION)?;
        let placed: Vec<Vec3> = positions.iter().map(|p| frame.transform_point(*p)).collect();
        let indices: Vec<[u32; 3]> = match mesh.indices()? {
            Indices::U16(list) => {
                list.as_chunks::<3>().0.iter().map(|t| t.map(u32::from)).collect()
            }
            Indices::U32(list) => list.as_chunks::<3>().0.to_vec(),
        };
        let color = look.color.to_srgba();
        let mut item = draw::Item::new(placed, indices, [color.red, color.green, color.blue]);
        item.normals = float3(mesh, Mesh::ATTRIBUTE_NORMAL).map(|normals| {
            let turned =
                normals.iter().map(|n| frame.affine().transform_vector3(*n).normalize_or_zero());
            turned.collect::<Vec<_>>().into()
        });
        item.texture = look
            .texture
            .as_ref()
            .and_then(|path| textures.loaded.get(path))
            .and_then(|(_, texture)| texture.clone());
        if item.texture.is_some()
            && let Some(VertexAttributeValues::Float32x2(uvs)) =
                mesh.attribute(Mesh::ATTRIBUTE_UV_0)
        {
            item.uvs = Some(uvs.iter().map(|&uv| Vec2::from(uv)).collect::<Vec<_>>().into());
        }
        item.double_sided = look.double_sided;
        Some(item)
    };
    things.iter().filter_map(item).collect()
}

fn float3(mesh: &Mesh, attribute: bevy::mesh::MeshVertexAttribute) -> Option<Vec<Vec3>> {
    match mesh.attribute(attribute)? {
        VertexAttributeValues::Float32x3(list) => Some(list.iter().map(|&v| v.into()).collect()),
        _ => None,
    }
}

/// Converts an image to eight bits a channel; `None` for a format that the CPU cannot read.
fn decode(image: &Image) -> Option<draw::Texture> {
    debug_assert!(image.asset_usage.contains(RenderAssetUsages::MAIN_WORLD));
    let dynamic = image.clone().try_into_dynamic().ok()?;
    let pixels = dynamic.into_rgba8();
    let (width, height) = (pixels.width() as usize, pixels.height() as usize);
    Some(draw::Texture::from_rgba8(width, height, pixels.as_raw()))
}
