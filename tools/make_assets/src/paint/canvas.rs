//! The canvas of all textures, and their colour arithmetic.
//!
//! Colours are linear light until they are encoded: anti-aliased edges blended in sRGB are too dark.

use glam::{Vec2, Vec3, vec2, vec3};

/// A finished texture, row by row from the top, in sRGB.
pub(crate) struct Canvas {
    width: u32,
    height: u32,
    texels: Vec<u8>,
}

impl Canvas {
    /// Samples `colour_at` on a 3 × 3 grid in each texel. Points are in texels from the top left.
    pub(crate) fn paint(width: u32, height: u32, colour_at: impl Fn(Vec2) -> Vec3) -> Self {
        const GRID: u32 = 3;
        let mut texels = Vec::with_capacity((width * height * 3) as usize);
        for row in 0..height {
            for column in 0..width {
                let mut sum = Vec3::ZERO;
                for sample in 0..GRID * GRID {
                    let within = vec2((sample % GRID) as f32 + 0.5, (sample / GRID) as f32 + 0.5)
                        / GRID as f32;
                    sum += colour_at(vec2(column as f32, row as f32) + within);
                }
                texels.extend((sum / (GRID * GRID) as f32).to_array().map(encode));
            }
        }
        Self { width, height, texels }
    }

    /// The texture as a PNG file.
    ///
    /// `Fast` is the only compression whose bytes cannot change with the rest of the build: the others use `flate2`, and its compressor depends on the features
    /// that other packages enable.
    pub(crate) fn to_png(&self) -> Vec<u8> {
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, self.width, self.height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        encoder.set_compression(png::Compression::Fast);
        encoder.set_filter(png::Filter::Adaptive);
        encoder
            .write_header()
            .and_then(|mut writer| {
                writer.write_image_data(&self.texels)?;
                writer.finish()
            })
            .expect("writing to memory cannot fail");
        file
    }
}

/// A colour in the notation of style sheets, `0xrrggbb`, converted to linear light.
pub(super) fn hex(code: u32) -> Vec3 {
    let channel = |shift: u32| decode(((code >> shift) & 0xff) as f32 / 255.0);
    vec3(channel(16), channel(8), channel(0))
}

/// Smoothstep: 0 below `from`, 1 above `to`; falls where `to < from`.
pub(super) fn smooth(from: f32, to: f32, value: f32) -> f32 {
    let t = ((value - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

fn encode(linear: f32) -> u8 {
    let linear = linear.clamp(0.0, 1.0);
    let srgb = if linear <= 0.003_130_8 {
        linear * 12.92
    } else {
        1.055 * libm::powf(linear, 1.0 / 2.4) - 0.055
    };
    libm::roundf(srgb * 255.0) as u8
}

fn decode(srgb: f32) -> f32 {
    if srgb <= 0.040_45 { srgb / 12.92 } else { libm::powf((srgb + 0.055) / 1.055, 2.4) }
}
