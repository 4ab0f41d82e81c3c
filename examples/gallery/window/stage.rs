//! Light, ground, camera, and materials for what scenes say of their looks.

use bevy::asset::RenderAssetUsages;
use bevy::camera::{Exposure, Hdr};
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::image::{ImageAddressMode, ImageFilterMode, ImageSampler, ImageSamplerDescriptor};
use bevy::light::{CascadeShadowConfigBuilder, DirectionalLightShadowMap, GlobalAmbientLight};
use bevy::prelude::*;
use bevy::render::render_resource::{Extent3d, TextureDimension, TextureFormat};
use bevy_panorbit_camera::{PanOrbitCamera, PanOrbitCameraPlugin};
use sinew_scenes::{Look, Scene};

/// Sky, and what the ground fades into: brighter than white, because the tone mapping will not let it be.
const HORIZON: Color = Color::linear_rgb(1.15, 1.42, 1.75);

/// Adds the stage to the app.
pub(super) fn add(app: &mut App) {
    app.add_plugins(PanOrbitCameraPlugin)
        .insert_resource(ClearColor(HORIZON))
        .insert_resource(DirectionalLightShadowMap { size: 2048 })
        .insert_resource(GlobalAmbientLight {
            color: Color::srgb(0.75, 0.85, 1.0),
            brightness: 420.0,
            ..default()
        })
        .add_systems(Startup, set_up)
        .add_systems(Update, dress);
}

/// Points the camera where the scene wants to be seen from; a restart of the same scene leaves it where the visitor put it.
pub(super) fn aim(world: &mut World, scene: &Scene, moved: bool) {
    if !moved {
        return;
    }
    let mut cameras = world.query_filtered::<Entity, With<PanOrbitCamera>>();
    let Some(camera) = cameras.iter(world).next() else { return };
    world.entity_mut(camera).insert((
        Transform::from_translation(scene.eye).looking_at(scene.target, Vec3::Y),
        orbit(scene.target),
    ));
}

fn orbit(focus: Vec3) -> PanOrbitCamera {
    PanOrbitCamera {
        focus,
        zoom_lower_limit: 0.3,
        zoom_upper_limit: Some(40.0),
        pitch_lower_limit: Some(-0.05),
        ..default()
    }
}

fn set_up(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut images: ResMut<Assets<Image>>,
) {
    commands.spawn((
        Camera3d::default(),
        // Tone mapping as a pass of its own, so that the sky and the fog go through the same curve and meet at the horizon.
        Hdr,
        Tonemapping::TonyMcMapface,
        Exposure { ev100: 10.0 },
        Projection::from(PerspectiveProjection { fov: 0.7, ..default() }),
        DistanceFog {
            color: HORIZON,
            falloff: FogFalloff::Linear { start: 12.0, end: 42.0 },
            ..default()
        },
        orbit(Vec3::ZERO),
    ));
    commands.spawn((
        DirectionalLight {
            color: Color::srgb(1.0, 0.96, 0.89),
            illuminance: 7_500.0,
            shadow_maps_enabled: true,
            ..default()
        },
        CascadeShadowConfigBuilder {
            num_cascades: 2,
            first_cascade_far_bound: 7.0,
            maximum_distance: 30.0,
            ..default()
        }
        .build(),
        Transform::from_xyz(3.0, 6.0, 3.5).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    // The sky's own light from the other side, so that shadows are blue and not black.
    commands.spawn((
        DirectionalLight { color: Color::srgb(0.7, 0.82, 1.0), illuminance: 1_300.0, ..default() },
        Transform::from_xyz(-4.0, 3.0, -2.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    let half = 60.0;
    let mut ground = Plane3d::default().mesh().size(2.0 * half, 2.0 * half).build();
    // Two squares to a turn of the texture: squares of half a metre.
    if let Some(bevy::mesh::VertexAttributeValues::Float32x2(uvs)) =
        ground.attribute_mut(Mesh::ATTRIBUTE_UV_0)
    {
        uvs.iter_mut().flatten().for_each(|uv| *uv *= 2.0 * half);
    }
    commands.spawn((
        Mesh3d(meshes.add(ground)),
        MeshMaterial3d(materials.add(StandardMaterial {
            base_color_texture: Some(images.add(checker())),
            perceptual_roughness: 0.95,
            reflectance: 0.2,
            ..default()
        })),
        // A hair below zero: what lies on the ground must not flicker through it.
        Transform::from_xyz(0.0, -0.002, 0.0),
    ));
}

/// A quiet checker of 2 × 2 squares with its own smaller copies, so that it fades with distance instead of flickering.
fn checker() -> Image {
    const SIZE: u32 = 256;
    let (light, dark) = ([188_u8, 190, 192], [171_u8, 174, 178]);
    let mut data = Vec::new();
    let mut levels = 0;
    let mut size = SIZE;
    while size > 0 {
        for y in 0..size {
            for x in 0..size {
                let texel = if size == 1 {
                    [180, 182, 185]
                } else if (x * 2 / size + y * 2 / size).is_multiple_of(2) {
                    light
                } else {
                    dark
                };
                data.extend(texel);
                data.push(255);
            }
        }
        levels += 1;
        size /= 2;
    }
    let extent = Extent3d { width: SIZE, height: SIZE, depth_or_array_layers: 1 };
    let mut image = Image::new_uninit(
        extent,
        TextureDimension::D2,
        TextureFormat::Rgba8UnormSrgb,
        RenderAssetUsages::RENDER_WORLD,
    );
    image.data = Some(data);
    image.texture_descriptor.mip_level_count = levels;
    image.sampler = ImageSampler::Descriptor(ImageSamplerDescriptor {
        address_mode_u: ImageAddressMode::Repeat,
        address_mode_v: ImageAddressMode::Repeat,
        mag_filter: ImageFilterMode::Linear,
        min_filter: ImageFilterMode::Linear,
        mipmap_filter: ImageFilterMode::Linear,
        anisotropy_clamp: 8,
        ..default()
    });
    image
}

/// The look that an entity has its material of. Going back in time writes all looks, and hardly any is another one then.
#[derive(Component)]
struct Dressed(Look);

/// Gives everything with a look its material.
fn dress(
    mut commands: Commands,
    changed: Query<(Entity, &Look, Option<&Dressed>), (Changed<Look>, With<Mesh3d>)>,
    arrived: Query<
        (Entity, &Look, Option<&Dressed>),
        (Added<Mesh3d>, Without<MeshMaterial3d<StandardMaterial>>),
    >,
    server: Res<AssetServer>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    for (entity, look, dressed) in changed.iter().chain(&arrived) {
        if dressed.is_some_and(|dressed| dressed.0 == *look) {
            continue;
        }
        let material = StandardMaterial {
            base_color: look.color,
            base_color_texture: look.texture.as_ref().map(|path| server.load(path.clone())),
            double_sided: look.double_sided,
            cull_mode: (!look.double_sided).then_some(bevy::render::render_resource::Face::Back),
            perceptual_roughness: look.roughness,
            metallic: look.metallic,
            ..default()
        };
        let material = MeshMaterial3d(materials.add(material));
        commands.entity(entity).try_insert((material, Dressed(look.clone())));
    }
}
