//! Contact sheets: several images on one page, to show a motion at a glance.

use super::image::Image;
use super::text::{self, Style};

const PAPER: [u8; 4] = [250, 250, 251, 255];
const INK: [u8; 3] = [28, 33, 43];
const GREY: [u8; 3] = [104, 112, 126];
/// Corner radius of the images, pixels.
const CORNER: f32 = 8.0;

/// A page with a title, a subtitle, and captioned images in rows of `columns`. All cells have the size of the largest image.
pub fn contact_sheet(
    title: &str,
    subtitle: &str,
    frames: &[(String, Image)],
    columns: usize,
) -> Image {
    let columns = columns.clamp(1, frames.len().max(1));
    let rows = frames.len().div_ceil(columns);
    let cell_width = frames.iter().map(|(_, image)| image.width).max().unwrap_or(320);
    let cell_height = frames.iter().map(|(_, image)| image.height).max().unwrap_or(0);
    // All sizes scale with the images, so that a page that is scaled down for a README stays legible.
    let unit = (cell_width as f32 / 320.0).clamp(0.75, 2.5);
    let px = |n: f32| (n * unit).round() as usize;
    let (margin, gap, caption_room) = (px(28.0), px(16.0), px(26.0));
    let title_style = Style { size: 30.0 * unit, color: INK };
    let subtitle_style = Style { size: 17.0 * unit, color: GREY };
    let caption_style = Style { size: 16.0 * unit, color: GREY };

    let header = px(34.0) + if subtitle.is_empty() { 0 } else { px(24.0) } + px(14.0);
    let width = 2 * margin + columns * cell_width + (columns - 1) * gap;
    let height = margin + header + rows * (cell_height + caption_room + gap) + margin / 2;
    let mut page = Image::new(width, height, PAPER);

    let room = (width - 2 * margin) as f32;
    let left = margin as f32;
    let fitted = text::shortened(title_style, title, room);
    text::write(&mut page, [left, margin as f32 - 4.0 * unit], title_style, &fitted);
    let fitted = text::shortened(subtitle_style, subtitle, room);
    text::write(&mut page, [left, margin as f32 + 34.0 * unit], subtitle_style, &fitted);

    for (number, (caption, image)) in frames.iter().enumerate() {
        let x = margin + number % columns * (cell_width + gap);
        let y = margin + header + number / columns * (cell_height + caption_room + gap);
        paste(&mut page, image, [x, y], CORNER * unit);
        let fitted = text::shortened(caption_style, caption, cell_width as f32);
        let indent = (image.width as f32 - text::width(caption_style, &fitted)) * 0.5;
        let below = (y + image.height) as f32 + 5.0 * unit;
        text::write(&mut page, [x as f32 + indent, below], caption_style, &fitted);
    }
    page
}

/// Copies an image with rounded corners.
fn paste(page: &mut Image, image: &Image, [left, top]: [usize; 2], radius: f32) {
    let half = [image.width as f32 * 0.5, image.height as f32 * 0.5];
    for y in 0..image.height {
        for x in 0..image.width {
            // Distance outside of the rounded rectangle.
            let dx = ((x as f32 + 0.5 - half[0]).abs() - half[0] + radius).max(0.0);
            let dy = ((y as f32 + 0.5 - half[1]).abs() - half[1] + radius).max(0.0);
            let coverage = (radius - dx.hypot(dy) + 0.5).clamp(0.0, 1.0);
            let [r, g, b, _] = image.at(x, y);
            page.blend((left + x) as i64, (top + y) as i64, [r, g, b], coverage);
        }
    }
}
