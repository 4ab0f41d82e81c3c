//! The lantern's palette: its mesh selects a swatch by column and a shade of it by row.

use glam::Vec3;

use super::Canvas;
use super::canvas::{hex, smooth};

/// One column of the palette.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Swatch {
    /// The enamel of roof and foot.
    Enamel,
    /// The posts between the panes.
    Iron,
    /// Trim, knob and handle.
    Brass,
    /// The lit panes: hottest in the middle of the column.
    Glass,
}

impl Swatch {
    /// Texture coordinate of the swatch's column.
    pub(crate) fn u(self) -> f32 {
        (f32::from(self as u8) + 0.5) / COLUMNS as f32
    }
}

const COLUMNS: u32 = 4;
/// Width of a column, texels: enough that filtering between texels, or a mip level or two, does not mix two swatches.
const COLUMN: u32 = 16;
const ROWS: u32 = 32;

/// Base colours of the lantern. Row 0 is the top of each swatch, and its lightest shade.
pub(crate) fn lantern_palette() -> Canvas {
    Canvas::paint(COLUMNS * COLUMN, ROWS, |texel| {
        let down = texel.y / ROWS as f32;
        match texel.x as u32 / COLUMN {
            0 => hex(0xe2_48_30).lerp(hex(0x7d_1c_1c), down),
            1 => hex(0x3a_4a_5c).lerp(hex(0x14_1d_2b), down),
            2 => hex(0xff_d0_6a).lerp(hex(0x8f_58_1c), down),
            _ => flame(down),
        }
    })
}

/// Emissive colours of the lantern: black except for the glass.
pub(crate) fn lantern_glow() -> Canvas {
    Canvas::paint(COLUMNS * COLUMN, ROWS, |texel| {
        if texel.x as u32 / COLUMN == 3 { flame(texel.y / ROWS as f32) } else { Vec3::ZERO }
    })
}

fn flame(down: f32) -> Vec3 {
    let heat = smooth(0.62, 0.0, (down - 0.56).abs());
    hex(0xc8_5a_10).lerp(hex(0xff_e9_a0), heat)
}
