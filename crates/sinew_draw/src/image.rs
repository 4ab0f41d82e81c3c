//! A picture in memory, and the colour arithmetic that everything which touches one shares.

use std::{
    fs::File,
    io::{self, BufWriter},
    path::Path,
};

use glam::Vec3;

/// A picture: rows from top to bottom, pixels from left to right, sRGB with straight alpha.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `width * height` pixels, red, green, blue, alpha.
    pub pixels: Vec<[u8; 4]>,
}

impl Image {
    /// A picture of one colour.
    pub fn new(width: usize, height: usize, fill: [u8; 4]) -> Self {
        Self { width, height, pixels: vec![fill; width * height] }
    }

    /// The pixel in column `x` of row `y`; panics outside of the picture.
    pub fn at(&self, x: usize, y: usize) -> [u8; 4] {
        assert!(x < self.width && y < self.height, "pixel outside of the picture");
        self.pixels[y * self.width + x]
    }

    /// Lays `color` over a pixel, `coverage` (0 to 1) thick; outside of the picture nothing happens.
    pub(crate) fn blend(&mut self, x: i64, y: i64, color: [u8; 3], coverage: f32) {
        if x < 0 || y < 0 || x >= self.width as i64 || y >= self.height as i64 {
            return;
        }
        let pixel = &mut self.pixels[y as usize * self.width + x as usize];
        for (under, over) in pixel.iter_mut().zip(color) {
            let mixed = f32::from(*under)
                + (f32::from(over) - f32::from(*under)) * coverage.clamp(0.0, 1.0);
            *under = mixed.round() as u8;
        }
    }
}

/// Writes a picture as PNG.
pub fn write_png(path: impl AsRef<Path>, image: &Image) -> io::Result<()> {
    let file = BufWriter::new(File::create(path)?);
    let mut encoder = png::Encoder::new(file, image.width as u32, image.height as u32);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    encoder.set_compression(png::Compression::Balanced);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(image.pixels.as_flattened())?;
    Ok(writer.finish()?)
}

/// sRGB, 0 to 1 a channel, to the linear light that shading adds up.
pub(crate) fn linear_of(srgb: [f32; 3]) -> Vec3 {
    Vec3::from(srgb.map(|c| if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }))
}

/// Rolls highlights off towards white and leaves everything else as it is (the Khronos "neutral" tone mapper).
pub(crate) fn tone(color: Vec3) -> Vec3 {
    const START: f32 = 0.76;
    let peak = color.max_element();
    if peak <= START {
        return color;
    }
    let room = 1.0 - START;
    let new = 1.0 - room * room / (peak + room - START);
    let white = 1.0 - 1.0 / (0.15 * (peak - new) + 1.0);
    (color * (new / peak)).lerp(Vec3::splat(new), white)
}

/// Linear light to sRGB bytes, by table: a power per channel and pixel would cost more than the shading.
pub(crate) struct SrgbTable(Vec<u8>);

impl SrgbTable {
    const STEPS: usize = 8192;

    pub(crate) fn new() -> Self {
        let encode = |c: f32| {
            if c <= 0.003_130_8 { c * 12.92 } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 }
        };
        let steps = 0..=Self::STEPS;
        Self(steps.map(|i| (encode(i as f32 / Self::STEPS as f32) * 255.0).round() as u8).collect())
    }

    #[inline]
    pub(crate) fn pixel(&self, linear: Vec3) -> [u8; 4] {
        let byte = |c: f32| self.0[(c.clamp(0.0, 1.0) * Self::STEPS as f32 + 0.5) as usize];
        [byte(linear.x), byte(linear.y), byte(linear.z), 255]
    }
}
