//! Still images for a repository: PNG with a palette.

use std::fs::File;
use std::io::{self, BufWriter};
use std::path::Path;

use super::animation::indexed;
use super::image::Image;

/// Writes an image as PNG with at most 255 colours, without transparency: a third of the bytes of [`write_png`](crate::write_png), for files that are kept in a
/// repository.
pub fn write_small_png(path: impl AsRef<Path>, image: &Image) -> io::Result<()> {
    let (palette, indices) = indexed(image);
    let file = BufWriter::new(File::create(path)?);
    let mut encoder = png::Encoder::new(file, image.width as u32, image.height as u32);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_palette(palette);
    encoder.set_compression(png::Compression::High);
    // Filters predict from neighbouring values, but neighbouring palette indices are not similar colours.
    encoder.set_filter(png::Filter::NoFilter);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&indices)?;
    Ok(writer.finish()?)
}
