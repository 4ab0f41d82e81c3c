//! Text on images, in a font that the panel (egui) depends on anyway.

use std::sync::OnceLock;

use ab_glyph::{Font, FontRef, PxScale, ScaleFont, point};

use super::image::Image;

/// Size and colour of a text.
#[derive(Clone, Copy)]
pub(crate) struct Style {
    /// Height of a line, in pixels.
    pub(crate) size: f32,
    pub(crate) color: [u8; 3],
}

/// Writes one line with its top left corner at (`x`, `y`); characters that the font lacks are boxes.
pub(crate) fn write(image: &mut Image, [x, y]: [f32; 2], style: Style, text: &str) {
    let font = font().as_scaled(PxScale::from(style.size));
    let mut pen = x;
    let mut last = None;
    for letter in text.chars() {
        let id = font.glyph_id(letter);
        pen += last.map_or(0.0, |last| font.kern(last, id));
        last = Some(id);
        let glyph = id.with_scale_and_position(style.size, point(pen, y + font.ascent()));
        pen += font.h_advance(id);
        if let Some(outline) = font.outline_glyph(glyph) {
            let corner = outline.px_bounds().min;
            outline.draw(|dx, dy, coverage| {
                let at = [corner.x as i64 + i64::from(dx), corner.y as i64 + i64::from(dy)];
                // The typeface is light: its thin strokes would be too faint without raising the coverage.
                image.blend(at[0], at[1], style.color, coverage.powf(0.75));
            });
        }
    }
}

/// Width of a line of text, pixels.
pub(crate) fn width(style: Style, text: &str) -> f32 {
    let font = font().as_scaled(PxScale::from(style.size));
    let mut last = None;
    let advance = |letter| {
        let id = font.glyph_id(letter);
        let kern = last.replace(id).map_or(0.0, |last| font.kern(last, id));
        kern + font.h_advance(id)
    };
    text.chars().map(advance).sum()
}

/// As much of a text as fits into `room` pixels, with an ellipsis if it is shortened.
pub(crate) fn shortened(style: Style, text: &str, room: f32) -> String {
    if width(style, text) <= room {
        return text.to_owned();
    }
    let mut short = text.to_owned();
    while short.pop().is_some() {
        let with_dots = format!("{}…", short.trim_end());
        if width(style, &with_dots) <= room {
            return with_dots;
        }
    }
    String::new()
}

fn font() -> &'static FontRef<'static> {
    static FONT: OnceLock<FontRef<'static>> = OnceLock::new();
    FONT.get_or_init(|| {
        FontRef::try_from_slice(epaint_default_fonts::UBUNTU_LIGHT).expect("a font that egui ships")
    })
}
