//! A face of a wooden crate, used for all six: planks set into a nailed frame with a diagonal brace.

use core::f32::consts::SQRT_2;

use glam::{Vec2, Vec3, vec2};

use super::Canvas;
use super::canvas::{hex, smooth};
use super::noise::{cell, fractal, noise};

const SIZE: u32 = 512;
const SIDE: f32 = SIZE as f32;
/// Width of the frame's boards.
const FRAME: f32 = 74.0;
/// Half the width of the brace.
const BRACE: f32 = 35.0;
const PLANKS: i32 = 5;

/// Paints the crate's face.
pub(crate) fn crate_face() -> Canvas {
    let woods = Woods {
        planks: [hex(0xa8_6f_3c), hex(0x5e_36_1a)],
        frame: [hex(0xc9_94_57), hex(0x7d_4c_25)],
        brace: [hex(0xbd_84_49), hex(0x70_42_20)],
    };
    Canvas::paint(SIZE, SIZE, |texel| nail(texel).unwrap_or_else(|| boards(texel, &woods)))
}

/// Light and dark colour of each kind of board.
struct Woods {
    planks: [Vec3; 2],
    frame: [Vec3; 2],
    brace: [Vec3; 2],
}

fn boards(texel: Vec2, woods: &Woods) -> Vec3 {
    let from_left = texel.x.min(SIDE - texel.x);
    let from_top = texel.y.min(SIDE - texel.y);
    let (far_x, far_y) = (texel.x > SIDE / 2.0, texel.y > SIDE / 2.0);
    if from_top < FRAME {
        let lit = bevel(from_top, FRAME - from_top, from_left + 6.0);
        return wood(texel, 10 + u32::from(far_y), woods.frame) * lit * nail_shadow(texel);
    }
    if from_left < FRAME {
        let lit = bevel(from_left, FRAME - from_left, from_top - FRAME);
        return wood(vec2(texel.y, texel.x), 20 + u32::from(far_x), woods.frame)
            * lit
            * nail_shadow(texel);
    }

    // From the lower left corner to the upper right one.
    let along = (texel.x - texel.y + SIDE) / SQRT_2;
    let across = (texel.x + texel.y - SIDE) / SQRT_2;
    let from_frame = from_left.min(from_top) - FRAME;
    if across.abs() < BRACE {
        let lit = bevel(BRACE - across.abs(), BRACE - across.abs(), from_frame);
        return wood(vec2(along, across + 40.0), 30, woods.brace) * lit * nail_shadow(texel);
    }

    let inner = SIDE - 2.0 * FRAME;
    let place = (texel.x - FRAME) / inner * PLANKS as f32;
    let plank = (place as i32).min(PLANKS - 1);
    let width = inner / PLANKS as f32;
    let within = (place - plank as f32) * width;
    let gap = within.min(width - within);
    let tone = 0.78 + 0.42 * cell(plank, 3, 5);
    let lit = tone
        * occlusion(from_frame, 26.0)
        * occlusion(across.abs() - BRACE, 22.0)
        * bevel(gap - 0.8, gap - 0.8, 90.0);
    wood(vec2(texel.y, within + plank as f32 * 97.0), 40 + plank as u32, woods.planks) * lit
}

/// Wood with its grain along x: growth rings drawn out into lines, knots that the grain flows around, and fine pores.
fn wood(at: Vec2, seed: u32, [light, dark]: [Vec3; 2]) -> Vec3 {
    let (flow, knot) = around_knots(at, seed);
    let drift = fractal(vec2(at.x * 0.006, flow * 0.018), seed);
    let rings = flow * 0.085 + drift * 5.5;
    let ring = rings - rings.floor();
    // Late wood darkens slowly and ends abruptly.
    let late = smooth(0.15, 0.9, ring) * smooth(1.0, 0.92, ring);
    let streak = fractal(vec2(at.x * 0.012, flow * 0.21), seed + 100);
    let pore = noise(vec2(at.x * 0.045, at.y * 0.62), seed + 200);
    let shade = 0.38 * late + 0.62 * (streak - 0.22) + 0.75 * knot;
    let worn =
        1.0 - 0.16 * smooth(0.66, 0.95, pore) - 0.12 * (fractal(at / 70.0, seed + 300) - 0.5);
    light.lerp(dark, shade.clamp(0.0, 1.0)) * worn
}

/// Bends the grain around the board's knots. Returns the coordinate across the board that `at` would have without knots, and the strength of a knot there.
fn around_knots(at: Vec2, seed: u32) -> (f32, f32) {
    const STRETCH: f32 = 180.0;
    let section = (at.x / STRETCH).floor();
    let (mut flow, mut knot) = (at.y, 0.0);
    for index in [section as i32 - 1, section as i32, section as i32 + 1] {
        if cell(index, 8, seed) < 0.45 {
            continue;
        }
        let middle = vec2(
            (index as f32 + 0.2 + 0.6 * cell(index, 0, seed)) * STRETCH,
            (at.y / 97.0).floor() * 97.0 + 20.0 + 34.0 * cell(index, 1, seed),
        );
        let size = 5.0 + 4.5 * cell(index, 2, seed);
        let from = (at - middle) * vec2(0.55, 1.0);
        let near = libm::expf(-from.length_squared() / (size * size * 7.0));
        flow -= (at.y - middle.y) * 0.85 * near;
        let radius = from.length() + 1.6 * (noise(at * 0.3, seed) - 0.5);
        let heart = smooth(size * 1.05, size * 0.55, radius);
        let circles = 0.75 + 0.25 * libm::cosf(radius * 2.1);
        let bark = 0.55 * smooth(size * 0.75, size, radius) * smooth(size * 1.5, size, radius);
        knot += heart.max(bark) * circles;
    }
    (flow, knot)
}

/// Shading of a board's rounded edges, from the distances to its two sides and its nearer end: worn and pale just inside, dark at the rim.
fn bevel(side: f32, other: f32, end: f32) -> f32 {
    let edge = side.min(other).min(end);
    let rim = 0.42 + 0.58 * smooth(-0.3, 2.6, edge);
    let worn = 1.0 + 0.16 * smooth(2.0, 3.5, edge) * smooth(8.0, 3.5, edge);
    rim * worn
}

/// Light that reaches a plank at a distance from a board that stands out above it.
fn occlusion(distance: f32, reach: f32) -> f32 {
    0.34 + 0.66 * smooth(-reach * 0.35, reach, distance)
}

const NAIL: f32 = 6.2;

/// Colour of a nail's head, if there is one: iron, lit from above.
fn nail(texel: Vec2) -> Option<Vec3> {
    let from = texel - nearest_nail(texel);
    let distance = from.length();
    if distance > NAIL {
        return None;
    }
    let dome = 0.55 - 0.45 * from.y / NAIL;
    let rust = fractal(texel * 0.21, 61);
    let iron = hex(0x4a_4c_52).lerp(hex(0x7a_45_28), smooth(0.45, 0.75, rust));
    let glint = 0.35 * smooth(3.4, 0.4, from.distance(vec2(-1.2, -2.2)));
    Some(
        (iron * (0.45 + 0.9 * dome) + Vec3::splat(glint))
            * smooth(NAIL + 0.6, NAIL - 1.6, distance).max(0.35),
    )
}

fn nail_shadow(texel: Vec2) -> f32 {
    let distance = texel.distance(nearest_nail(texel) + vec2(0.0, 1.2));
    0.45 + 0.55 * smooth(NAIL - 1.0, NAIL + 6.0, distance)
}

/// Position of the nearest nail: two at each end of the frame's boards and of the brace, and one at each end of a plank.
fn nearest_nail(texel: Vec2) -> Vec2 {
    let mut nearest = Vec2::splat(f32::MAX);
    let mut offer = |nail: Vec2| {
        if texel.distance_squared(nail) < texel.distance_squared(nearest) {
            nearest = nail;
        }
    };
    let mirrored = |nail: Vec2, x: bool, y: bool| {
        vec2(if x { SIDE - nail.x } else { nail.x }, if y { SIDE - nail.y } else { nail.y })
    };
    for (x, y) in [(false, false), (true, false), (false, true), (true, true)] {
        offer(mirrored(vec2(22.0, 24.0), x, y));
        offer(mirrored(vec2(52.0, 50.0), x, y));
    }
    for flip in [false, true] {
        for aside in [-15.0, 15.0] {
            let from_corner = FRAME + 31.0;
            offer(mirrored(vec2(from_corner + aside, SIDE - from_corner + aside), flip, flip));
        }
        for plank in 0..PLANKS {
            let x = FRAME + (SIDE - 2.0 * FRAME) * (plank as f32 + 0.5) / PLANKS as f32;
            offer(mirrored(vec2(x, FRAME / 2.0), false, flip));
        }
    }
    nearest
}
