//! Common to the flag and the banner: their dyes, their weave and the sun.

use core::f32::consts::TAU;

use glam::{Vec2, Vec3};

use super::canvas::hex;
use super::noise::{cell, fractal};

/// The project's four dyes and the ivory of undyed thread.
pub(super) struct Dyes {
    pub(super) vermilion: Vec3,
    pub(super) teal: Vec3,
    pub(super) midnight: Vec3,
    pub(super) gold: Vec3,
    pub(super) ivory: Vec3,
}

impl Dyes {
    pub(super) fn new() -> Self {
        Self {
            vermilion: hex(0xdb_3d_2a),
            teal: hex(0x0f_5a_68),
            midnight: hex(0x10_1d_33),
            gold: hex(0xf6_b4_35),
            ivory: hex(0xfa_f1_dc),
        }
    }
}

/// Brightness of the weave at `texel`, about 1: threads four texels wide that pass over and under each other, each a little different, and a slow unevenness of
/// the dye.
pub(super) fn weave(texel: Vec2) -> f32 {
    const THREAD: f32 = 4.0;
    let at = texel / THREAD;
    let (across, along) = (at.x.floor(), at.y.floor());
    let (column, row) = (across as i32, along as i32);
    let upright = (column + row) % 2 == 0;
    // A thread is brightest along its middle and darker where it passes under its neighbour.
    let (side, length) =
        if upright { (at.x - across, at.y - along) } else { (at.y - along, at.x - across) };
    let round = |t: f32| 4.0 * t * (1.0 - t);
    let relief = 0.55 * round(side) + 0.45 * round(length);
    let own = if upright { cell(column, 0, 71) } else { cell(row, 1, 71) };
    1.0 + 0.13 * (relief - 0.6) + 0.05 * (own - 0.5) + 0.09 * (fractal(texel / 90.0, 9) - 0.5)
}

/// Whether `at`, relative to the sun's centre, is on the sun: a disc of radius 0.46 in a crown of rays that reach 1.0.
pub(super) fn on_sun(at: Vec2, rays: u32) -> bool {
    let distance = at.length();
    if distance < 0.46 {
        return true;
    }
    let turn = libm::atan2f(at.x, at.y) / TAU * rays as f32;
    let from_middle = (turn - libm::roundf(turn)).abs();
    let long = libm::roundf(turn) as i32 % 2 == 0;
    let (start, end) = if long { (0.54, 1.0) } else { (0.54, 0.80) };
    // Wide at the disc, almost a point at the tip.
    distance > start
        && distance < end
        && from_middle < 0.015 + 0.40 * (end - distance) / (end - start)
}
