//! Surfaces, described without a renderer.

use bevy::prelude::*;

/// The surface of an entity with a `Mesh3d`, for any renderer: a renderer creates a Bevy material or one of the software renderer from it.
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct Look {
    /// Colour; it multiplies the texture.
    pub color: Color,
    /// Path of a texture among the assets.
    pub texture: Option<String>,
    /// Whether both sides are drawn, as for cloth.
    pub double_sided: bool,
    /// Roughness from 0 (a mirror) to 1 (chalk).
    pub roughness: f32,
    /// Metalness from 0 to 1.
    pub metallic: f32,
}

impl Default for Look {
    fn default() -> Self {
        Self {
            color: Color::srgb(0.8, 0.8, 0.8),
            texture: None,
            double_sided: false,
            roughness: 0.7,
            metallic: 0.0,
        }
    }
}

impl Look {
    /// A plain colour, by its sRGB bytes as in `0xRRGGBB`.
    pub fn color(rgb: u32) -> Self {
        let [_, red, green, blue] = rgb.to_be_bytes();
        Self { color: Color::srgb_u8(red, green, blue), ..default() }
    }

    /// A texture, by its path among the assets.
    pub fn texture(path: &str) -> Self {
        Self { color: Color::WHITE, texture: Some(path.to_owned()), ..default() }
    }

    /// The same, drawn on both sides.
    pub fn double_sided(self) -> Self {
        Self { double_sided: true, ..self }
    }

    /// The same, translucent: opacity from 0 (clear) to 1. Below 1 it casts no shadow. The software renderer draws it opaque.
    pub fn opacity(self, opacity: f32) -> Self {
        Self { color: self.color.with_alpha(opacity), ..self }
    }

    /// The same with another roughness, 0 to 1.
    pub fn roughness(self, roughness: f32) -> Self {
        Self { roughness, ..self }
    }

    /// The same as metal.
    pub fn metal(self) -> Self {
        Self { metallic: 0.9, roughness: 0.35, ..self }
    }
}
