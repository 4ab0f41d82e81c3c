//! The banner's texture: two panels sewn together down the middle, each with its half of the design.

use glam::{Vec2, Vec3, vec2};

use super::Canvas;
use super::cloth::{Dyes, on_sun, weave};

const WIDTH: u32 = 192;
const HEIGHT: u32 = 320;
/// Width of a panel in texels; the rest is cloth that filtering may read but no triangle shows.
const PANEL: f32 = 92.0;
const MARGIN: f32 = 2.0;

/// Dimensions of the banner, in metres, shared by its mesh and its texture.
pub(crate) mod shape {
    /// From the seam to either side.
    pub(crate) const HALF_WIDTH: f32 = 0.6;
    /// From the top edge to the tips of the tails.
    pub(crate) const LENGTH: f32 = 2.0;
    /// From the top edge to the notch between the tails.
    pub(crate) const NOTCH: f32 = 1.55;
}
use shape::{HALF_WIDTH, LENGTH, NOTCH};

/// Texture coordinate of a point of the banner. Points on the seam are in both panels.
pub(crate) fn banner_uv(at: Vec2, right: bool) -> Vec2 {
    let (start, from) =
        if right { (WIDTH as f32 - MARGIN - PANEL, 0.0) } else { (MARGIN, -HALF_WIDTH) };
    vec2((start + (at.x - from) / HALF_WIDTH * PANEL) / WIDTH as f32, -at.y / LENGTH)
}

/// Paints the banner, both panels side by side.
pub(crate) fn banner() -> Canvas {
    let dyes = Dyes::new();
    Canvas::paint(WIDTH, HEIGHT, |texel| {
        let right = texel.x > WIDTH as f32 / 2.0;
        let start = if right { WIDTH as f32 - MARGIN - PANEL } else { MARGIN };
        let across = ((texel.x - start) / PANEL).clamp(0.0, 1.0);
        let x = if right { across * HALF_WIDTH } else { (across - 1.0) * HALF_WIDTH };
        let at = vec2(x, -texel.y / HEIGHT as f32 * LENGTH);
        field(at, right, &dyes) * weave(texel)
    })
}

fn field(at: Vec2, right: bool, dyes: &Dyes) -> Vec3 {
    let seam = if at.x.abs() < 0.006 { 0.7 } else { 1.0 };
    let notch_line = at.y + NOTCH + at.x.abs() * (LENGTH - NOTCH) / HALF_WIDTH;
    let slope = (LENGTH - NOTCH) / HALF_WIDTH;
    let edge = (HALF_WIDTH - at.x.abs()).min(notch_line / (1.0 + slope * slope).sqrt());
    if at.y > -0.13 {
        return top_band(at, dyes);
    }
    if edge < 0.05 {
        return dyes.gold * if edge > 0.012 && edge < 0.038 { 1.0 } else { 0.72 };
    }
    if edge < 0.064 {
        return dyes.midnight;
    }

    let from_sun = at - vec2(0.0, -0.64);
    let distance = from_sun.length();
    if distance < 0.40 {
        return if on_sun(from_sun / 0.365, 20) { dyes.gold } else { dyes.midnight };
    }
    if distance < 0.445 {
        return dyes.ivory;
    }
    if distance < 0.46 {
        return dyes.midnight;
    }

    // Chevrons parallel to the notch, which swap dyes at the seam.
    let (own, other) =
        if right { (dyes.teal, dyes.vermilion) } else { (dyes.vermilion, dyes.teal) };
    let stripe = |from: f32, to: f32| notch_line > from && notch_line < to;
    let dye = if stripe(0.34, 0.45) {
        dyes.ivory
    } else if stripe(0.17, 0.28) {
        other
    } else {
        own
    };
    dye * seam
}

/// The hem at the top: dark, with a row of gold lozenges.
fn top_band(at: Vec2, dyes: &Dyes) -> Vec3 {
    const SPACING: f32 = 0.12;
    if at.y < -0.112 {
        return dyes.gold;
    }
    let x = (at.x / SPACING - (at.x / SPACING).floor() - 0.5).abs() * SPACING;
    let y = (at.y + 0.056).abs();
    if x + y * 1.1 < 0.036 { dyes.gold } else { dyes.midnight }
}
