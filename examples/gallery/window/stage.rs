//! Light, ground and camera, and materials for the looks of scenes.

use bevy::camera::{Exposure, Hdr};
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::light::{
    CascadeShadowConfigBuilder, DirectionalLightShadowMap, GlobalAmbientLight, NotShadowCaster,
};
use bevy::prelude::*;
use bevy::render::view::{ColorGrading, ColorGradingGlobal};
use bevy_panorbit_camera::{PanOrbitCamera, PanOrbitCameraPlugin};
use sinew_scenes::{Look, Scene};

use super::sky;

/// Side of the shadow map, texels. The edge of a shadow is five texels wide.
const SHADOW_TEXELS: usize = 2048;
/// Distance from the camera up to which the sun casts shadows, metres. It is spread over the texels and so also determines how soft shadows are: some 6 cm
/// here.
const SUN_REACH: f32 = 22.0;
/// The same for the light from overhead. Its shadows are so soft (some 20 cm) that they darken what is near the ground, below an edge or in a fold: they serve
/// as ambient occlusion. Bevy's own techniques were tried on `playground`, `stage` and `pile` in November 2026. `ScreenSpaceAmbientOcclusion` at its best
/// quality changes one pixel in 400 by more than 4 %, and requires multisampling off, which leaves jagged edges; `ContactShadows` of the sun leave dots on
/// round bodies, and those of this light are invisible.
const SKY_REACH: f32 = 80.0;

/// Lowest height of the point that the camera orbits, metres above the ground; also the lowest height of the camera.
const LOWEST: f32 = 0.05;
/// Bounds of the point that the camera orbits: a box on the ground, metres. The ground is twice as wide.
const ROOM: Vec3 = Vec3::new(60.0, 20.0, 60.0);

/// Adds the stage to the app.
pub(super) fn add(app: &mut App) {
    app.add_plugins(PanOrbitCameraPlugin)
        .insert_resource(DirectionalLightShadowMap { size: SHADOW_TEXELS })
        // The environment map of the sky replaces it.
        .insert_resource(GlobalAmbientLight::NONE)
        .add_systems(Startup, set_up)
        .add_systems(Update, (dress, keep_width));
}

/// Moves the camera to the viewpoint of the scene; a restart of the same scene leaves it where the user put it.
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
        // Keeps the camera above the ground: there is nothing to see below.
        pitch_lower_limit: Some(0.0),
        focus_bounds_shape: Some(Cuboid::from_size(ROOM).into()),
        focus_bounds_origin: Vec3::Y * (0.5 * ROOM.y + LOWEST),
        ..default()
    }
}

fn set_up(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut images: ResMut<Assets<Image>>,
) {
    let exposure = Exposure { ev100: 10.0 };
    let [red, green, blue] = sky::HORIZON;
    let fog = DistanceFog {
        color: Color::linear_rgb(red, green, blue),
        falloff: FogFalloff::Linear { start: 20.0, end: 58.0 },
        ..default()
    };
    let color_grading = ColorGrading {
        // Restores the saturation that tone mapping removes.
        global: ColorGradingGlobal { post_saturation: 1.18, ..default() },
        ..default()
    };
    commands.spawn((
        Camera3d::default(),
        // Tone mapping as a separate pass, so that sky and fog go through the same curve and match at the horizon.
        Hdr,
        Tonemapping::TonyMcMapface,
        color_grading,
        sky::skybox(&mut images, exposure.exposure()),
        sky::light(&mut images),
        exposure,
        Projection::from(PerspectiveProjection { fov: FIELD, ..default() }),
        fog,
        orbit(Vec3::ZERO),
    ));
    let reach = |metres| {
        CascadeShadowConfigBuilder { num_cascades: 1, maximum_distance: metres, ..default() }
            .build()
    };
    commands.spawn((
        DirectionalLight {
            color: Color::srgb(1.0, 0.95, 0.86),
            illuminance: 7_500.0,
            shadow_maps_enabled: true,
            ..default()
        },
        reach(SUN_REACH),
        Transform::from_xyz(4.2, 6.0, 2.4).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    commands.spawn((
        DirectionalLight {
            color: Color::srgb(0.9, 0.95, 1.0),
            // Strong compared with the light of the sky, which has no shadows, so that the inside of a heap is dark.
            illuminance: 3_500.0,
            shadow_maps_enabled: true,
            // Small in spite of its large texels: a body on the ground must darken it up to the edge of contact.
            shadow_normal_bias: 0.3,
            ..default()
        },
        reach(SKY_REACH),
        // Slightly from the side opposite the sun, so that bodies in the sun's shadow are shaded.
        Transform::from_xyz(-0.9, 6.0, -0.3).looking_at(Vec3::ZERO, Vec3::Z),
    ));
    let half = 60.0;
    let mut ground = Plane3d::default().mesh().size(2.0 * half, 2.0 * half).build();
    // Slabs of half a metre.
    if let Some(bevy::mesh::VertexAttributeValues::Float32x2(uvs)) =
        ground.attribute_mut(Mesh::ATTRIBUTE_UV_0)
    {
        let turns = 2.0 * half / (0.5 * sky::SQUARES as f32);
        uvs.iter_mut().flatten().for_each(|uv| *uv *= turns);
    }
    commands.spawn((
        Name::new("stage ground"),
        Mesh3d(meshes.add(ground)),
        MeshMaterial3d(materials.add(StandardMaterial {
            base_color_texture: Some(images.add(sky::ground())),
            perceptual_roughness: 0.95,
            reflectance: 0.2,
            ..default()
        })),
        // Slightly below zero, against z-fighting with objects on the ground.
        Transform::from_xyz(0.0, -0.002, 0.0),
    ));
}

/// Vertical field of view, radians, for a picture of the aspect ratio that scenes are framed for.
const FIELD: f32 = 0.7;
/// That aspect ratio, width over height. Pictures without a window are slightly wider.
const FRAMED: f32 = 1.5;

/// In a narrower view, as beside the panel, keeps the horizontal extent of a scene: more is visible above and below, and nothing is cut off at the sides.
fn keep_width(mut camera: Single<(&Camera, &mut Projection), With<PanOrbitCamera>>) {
    let (camera, projection) = &mut *camera;
    let Some(size) = camera.logical_viewport_size().filter(|size| size.min_element() > 0.0) else {
        return;
    };
    let wider = (FRAMED * size.y / size.x).max(1.0);
    let fov = 2.0 * ((0.5 * FIELD).tan() * wider).atan();
    if let Projection::Perspective(now) = &**projection
        && (now.fov - fov).abs() > 1e-4
        && let Projection::Perspective(lens) = &mut **projection
    {
        lens.fov = fov;
    }
}

/// The look that an entity's material was made from. A rollback writes all looks, and few of them differ then.
#[derive(Component)]
struct Dressed(Look);

/// Creates materials for entities with a new or a changed look.
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
        let clear = look.color.alpha() < 1.0;
        let material = StandardMaterial {
            base_color: look.color,
            base_color_texture: look.texture.as_ref().map(|path| server.load(path.clone())),
            double_sided: look.double_sided,
            cull_mode: (!look.double_sided).then_some(bevy::render::render_resource::Face::Back),
            perceptual_roughness: look.roughness,
            metallic: look.metallic,
            alpha_mode: if clear { AlphaMode::Blend } else { AlphaMode::Opaque },
            ..default()
        };
        let material = MeshMaterial3d(materials.add(material));
        let mut entity = commands.entity(entity);
        entity.try_insert((material, Dressed(look.clone())));
        if clear {
            entity.try_insert(NotShadowCaster);
        }
    }
}
