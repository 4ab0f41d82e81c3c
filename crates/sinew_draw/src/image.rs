//! An image in memory, and the colour arithmetic that the other modules share.

use std::{
    fs::File,
    io::{self, BufWriter},
    path::Path,
};

use glam::Vec3;

/// An image: rows from top to bottom, pixels from left to right, sRGB with straight alpha.
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
    /// An image of one colour.
    pub fn new(width: usize, height: usize, fill: [u8; 4]) -> Self {
        Self { width, height, pixels: vec![fill; width * height] }
    }

    /// The pixel in column `x` of row `y`; panics outside of the image.
    pub fn at(&self, x: usize, y: usize) -> [u8; 4] {
        assert!(x < self.width && y < self.height, "pixel outside of the picture");
        self.pixels[y * self.width + x]
    }

    /// The image reduced by `factor`: each pixel is the mean light of `factor` × `factor` pixels. A remainder at the right and at the bottom is cut off.
    pub fn shrunk(&self, factor: usize) -> Self {
        let factor = factor.max(1);
        let light: Vec<f32> =
            (0..=255_u8).map(|byte| linear_of([f32::from(byte) / 255.0; 3]).x).collect();
        let srgb = SrgbTable::new();
        let share = 1.0 / (factor * factor) as f32;
        let mut small = Self::new(self.width / factor, self.height / factor, [0; 4]);
        for (i, pixel) in small.pixels.iter_mut().enumerate() {
            let (left, top) = (i % small.width * factor, i / small.width * factor);
            let mut sum = Vec3::ZERO;
            for (x, y) in (0..factor * factor).map(|k| (left + k % factor, top + k / factor)) {
                let [r, g, b, _] = self.at(x, y);
                sum += Vec3::from([r, g, b].map(|byte| light[usize::from(byte)]));
            }
            *pixel = srgb.pixel(sum * share);
        }
        small
    }

    /// The part of `width` × `height` pixels whose upper left corner is in column `left` of row `top`; panics if it exceeds the image.
    pub fn part(&self, [left, top]: [usize; 2], width: usize, height: usize) -> Self {
        let rows = (top..top + height).flat_map(|y| {
            let first = y * self.width + left;
            self.pixels[first..first + width].iter().copied()
        });
        Self { width, height, pixels: rows.collect() }
    }

    /// Copies another image into this one, with its upper left corner in column `left` of row `top`; panics if it does not fit.
    pub fn place(&mut self, image: &Self, [left, top]: [usize; 2]) {
        for y in 0..image.height {
            let first = (top + y) * self.width + left;
            self.pixels[first..first + image.width]
                .copy_from_slice(&image.pixels[y * image.width..][..image.width]);
        }
    }

    /// Blends `color` over a pixel with a coverage of 0 to 1; does nothing outside of the image.
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

/// Writes an image as PNG.
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

/// Reads a PNG of eight bits a channel or fewer, with or without a palette.
pub fn read_png(bytes: &[u8]) -> io::Result<Image> {
    let mut decoder = png::Decoder::new(io::Cursor::new(bytes));
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut reader = decoder.read_info()?;
    let size = reader.output_buffer_size().ok_or(io::ErrorKind::OutOfMemory)?;
    let mut data = vec![0; size];
    let info = reader.next_frame(&mut data)?;
    let channels = info.color_type.samples();
    let pixel = |p: &[u8]| match *p {
        [r, g, b, a] => [r, g, b, a],
        [r, g, b] => [r, g, b, 255],
        [l, a] => [l, l, l, a],
        [l] => [l, l, l, 255],
        _ => [0; 4],
    };
    let pixels = data[..info.buffer_size()].chunks_exact(channels).map(pixel).collect();
    Ok(Image { width: info.width as usize, height: info.height as usize, pixels })
}

/// Converts sRGB, 0 to 1 a channel, to linear light, in which shading adds up.
pub(crate) fn linear_of(srgb: [f32; 3]) -> Vec3 {
    Vec3::from(srgb.map(|c| if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }))
}

/// Compresses highlights towards white and leaves everything else as it is (the Khronos "neutral" tone mapper).
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

/// Converts linear light to sRGB bytes by table: a power per channel and pixel would cost more than the shading.
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
