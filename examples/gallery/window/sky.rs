//! The sky, its light and the ground, all computed: no file is read, and a frame pays for no more than a background picture.

use bevy::asset::RenderAssetUsages;
use bevy::image::{ImageAddressMode, ImageFilterMode, ImageSampler, ImageSamplerDescriptor};
use bevy::light::{EnvironmentMapLight, Skybox};
use bevy::math::{Vec2, Vec3};
use bevy::prelude::*;
use bevy::render::render_resource::{
    Extent3d, TextureDimension, TextureFormat, TextureViewDescriptor, TextureViewDimension,
};

/// Colour of the sky at the horizon, and of the fog: brighter than white, because tone mapping darkens it.
pub(super) const HORIZON: [f32; 3] = [1.0, 1.27, 1.62];
/// Colour of the sky overhead, on the same scale.
const ZENITH: Vec3 = Vec3::new(0.16, 0.42, 1.05);
/// Colour of the thickest clouds.
const CLOUD: Vec3 = Vec3::new(1.7, 1.78, 1.9);
/// Value of the brightest texel of the sky, on the same scale: the texture has eight bits a channel, and nothing in the sky is brighter.
const BRIGHTEST: f32 = 2.0;
/// Side of a face of the sky cube, texels. A view covers some 140 of them, and everything in the sky is soft.
const FACE: u32 = 256;
/// Side of the ground's texture, texels.
const GROUND: u32 = 512;
/// Squares along a side of the ground's texture.
pub(super) const SQUARES: u32 = 4;

/// The skybox, for a camera of this exposure (`Exposure::exposure`).
pub(super) fn skybox(images: &mut Assets<Image>, exposure: f32) -> Skybox {
    Skybox { image: Some(images.add(cube())), brightness: BRIGHTEST / exposure, ..default() }
}

/// Ambient light from the sky, and a little from the ground: blue from above, warm from below. Metal reflects it.
pub(super) fn light(images: &mut Assets<Image>) -> EnvironmentMapLight {
    EnvironmentMapLight {
        // Fills the shadows of the sun's 7500 lx, cd/m².
        intensity: 220.0,
        ..EnvironmentMapLight::hemispherical_gradient(
            images,
            Color::linear_rgb(0.85, 1.05, 1.35),
            Color::linear_rgb(0.80, 0.88, 1.0),
            Color::linear_rgb(0.42, 0.39, 0.35),
        )
    }
}

/// Six faces in the order of the graphics API: +x, -x, +y, -y, +z, -z.
fn cube() -> Image {
    let mut data = Vec::with_capacity((6 * FACE * FACE * 4) as usize);
    for face in 0..6 {
        for (y, x) in (0..FACE).flat_map(|y| (0..FACE).map(move |x| (y, x))) {
            let [u, v] = [x, y].map(|i| (i as f32 + 0.5) / FACE as f32 * 2.0 - 1.0);
            let direction = match face {
                0 => Vec3::new(1.0, -v, -u),
                1 => Vec3::new(-1.0, -v, u),
                2 => Vec3::new(u, 1.0, v),
                3 => Vec3::new(u, -1.0, -v),
                4 => Vec3::new(u, -v, 1.0),
                _ => Vec3::new(-u, -v, -1.0),
            };
            let light = seen(direction.normalize()) / BRIGHTEST;
            let color = Color::linear_rgb(light.x, light.y, light.z).to_srgba();
            // Dither by half a step, without which so slow a gradient shows bands.
            let dither = hash(x as i32 + 7919 * face, y as i32) - 0.5;
            let bytes = [color.red, color.green, color.blue]
                .map(|c| (c * 255.0 + dither).round().clamp(0.0, 255.0) as u8);
            data.extend(bytes);
            data.push(255);
        }
    }
    let extent = Extent3d { width: FACE, height: FACE, depth_or_array_layers: 6 };
    let mut image = Image::new(
        extent,
        TextureDimension::D2,
        data,
        TextureFormat::Rgba8UnormSrgb,
        RenderAssetUsages::RENDER_WORLD,
    );
    image.texture_view_descriptor =
        Some(TextureViewDescriptor { dimension: Some(TextureViewDimension::Cube), ..default() });
    image
}

/// Colour of the sky in a direction.
fn seen(direction: Vec3) -> Vec3 {
    let horizon = Vec3::from(HORIZON);
    let up = direction.y;
    if up <= 0.0 {
        return horizon;
    }
    let down = 1.0 - up;
    // Scenes are viewed from above, so that only the lowest degrees of the sky are visible: it turns blue close to the horizon.
    let clear = horizon.lerp(ZENITH, 1.0 - down.powi(7));
    // A flat layer of clouds, seen from below; distant ones fade into the horizon.
    let at = Vec2::new(direction.x, direction.z) / (up + 0.10) * 0.9;
    let thick = smooth((layers(at) - 0.48) / 0.34) * smooth((up - 0.01) / 0.10);
    clear.lerp(CLOUD, 0.75 * thick)
}

/// Noise of five octaves, from 0 to 1.
fn layers(at: Vec2) -> f32 {
    let (mut sum, mut weight, mut scale) = (0.0, 0.5, 1.0);
    for layer in 0..5 {
        sum += weight * noise(at * scale + Vec2::splat(17.3 * layer as f32), i32::MAX);
        (weight, scale) = (weight * 0.5, scale * 2.03);
    }
    sum / 0.97
}

/// Smooth noise, from 0 to 1, that repeats after `period` units.
fn noise(at: Vec2, period: i32) -> f32 {
    let cell = at.floor();
    let (x, y) = (cell.x as i32, cell.y as i32);
    let [u, v] = (at - cell).to_array().map(smooth);
    let corner = |dx: i32, dy: i32| hash((x + dx).rem_euclid(period), (y + dy).rem_euclid(period));
    let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
    mix(mix(corner(0, 0), corner(1, 0), u), mix(corner(0, 1), corner(1, 1), u), v)
}

/// Smoothstep: from 0 to 1 with zero slope at both ends.
fn smooth(t: f32) -> f32 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// A pseudo-random number from 0 to 1.
fn hash(x: i32, y: i32) -> f32 {
    let mut bits = (x as u32).wrapping_mul(0x9E37_79B1) ^ (y as u32).wrapping_mul(0x85EB_CA77);
    bits = (bits ^ (bits >> 15)).wrapping_mul(0x2C1B_3C6D);
    bits = (bits ^ (bits >> 12)).wrapping_mul(0x297A_2D39);
    ((bits ^ (bits >> 15)) >> 8) as f32 / (1 << 24) as f32
}

/// Concrete slabs, [`SQUARES`] each way, with joints that show how fast a body moves over them. The texture has mipmaps, so that it fades with distance instead
/// of flickering.
pub(super) fn ground() -> Image {
    let side = GROUND / SQUARES;
    let mut level: Vec<[f32; 3]> = Vec::with_capacity((GROUND * GROUND) as usize);
    for (y, x) in (0..GROUND).flat_map(|y| (0..GROUND).map(move |x| (y, x))) {
        let slab = [x / side, y / side];
        // Slabs differ slightly in brightness, and form a faint checker.
        let own = 5.0 * (hash(slab[0] as i32, slab[1] as i32 + 99) - 0.5);
        let checker = if (slab[0] + slab[1]).is_multiple_of(2) { 4.5 } else { -4.5 };
        let at = Vec2::new(x as f32, y as f32) / GROUND as f32;
        let stain = 7.0 * (noise(at * 6.0, 6) - 0.5) + 5.0 * (noise(at * 23.0, 23) - 0.5);
        let grain = 6.0 * (hash(x as i32, y as i32) - 0.5);
        // Distance from the joint, texels.
        let edge = |i: u32| (i % side).min(side - 1 - i % side);
        let joint = if edge(x).min(edge(y)) == 0 { -26.0 } else { 0.0 };
        let grey = own + checker + stain + grain + joint;
        level.push([176.0 + grey, 174.0 + grey, 169.0 + grey]);
    }
    let (mut data, mut size, mut levels) = (Vec::new(), GROUND as usize, 0);
    loop {
        for texel in &level {
            data.extend(texel.map(|c| c.round().clamp(0.0, 255.0) as u8));
            data.push(255);
        }
        levels += 1;
        if size == 1 {
            break;
        }
        let wide = size;
        size /= 2;
        level = (0..size * size)
            .map(|i| {
                let first = i / size * 2 * wide + i % size * 2;
                let four = [first, first + 1, first + wide, first + wide + 1];
                core::array::from_fn(|c| four.map(|k| level[k][c]).iter().sum::<f32>() * 0.25)
            })
            .collect();
    }
    let extent = Extent3d { width: GROUND, height: GROUND, depth_or_array_layers: 1 };
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
