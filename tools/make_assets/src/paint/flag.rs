//! The flag of Sinew: two strands, twisted from hoist to fly, that part around a sun and close again behind it.

use core::f32::consts::{FRAC_PI_2, PI};

use glam::{Vec2, Vec3, vec2};

use super::Canvas;
use super::canvas::smooth;
use super::cloth::{Dyes, on_sun, weave};

const WIDTH: u32 = 512;
const HEIGHT: u32 = 320;

/// Paints the flag, hoist to the left.
pub(crate) fn flag() -> Canvas {
    let dyes = Dyes::new();
    Canvas::paint(WIDTH, HEIGHT, |texel| {
        let (dye, relief) = sewn_edges(texel, &dyes).unwrap_or_else(|| field(texel, &dyes));
        dye * relief * weave(texel) * hem_shade(texel)
    })
}

/// Half the strand's width, where the flag is 2 high.
const STRAND: f32 = 0.082;
/// Width of the dark line around a strand, which makes the crossings legible.
const OUTLINE: f32 = 0.024;

/// The flag without its hems, as dye and brightness.
fn field(texel: Vec2, dyes: &Dyes) -> (Vec3, f32) {
    let half = vec2(WIDTH as f32, HEIGHT as f32) / 2.0;
    let at = vec2(texel.x - half.x, half.y - texel.y) / half.y;
    let front = strand_in_front(at.x);
    for strand in [front, 1 - front] {
        let aside = distance_to_strand(at, if strand == 0 { 1.0 } else { -1.0 });
        if aside.abs() < STRAND {
            let dye = if strand == 0 { dyes.ivory } else { dyes.gold };
            return (dye, fibres(aside / STRAND));
        }
        if aside.abs() < STRAND + OUTLINE {
            return (dyes.midnight, 1.0);
        }
    }
    if at.y.abs() < path(at.x).0.abs() {
        let dye = if on_sun(at / 0.43, 20) { dyes.gold } else { dyes.midnight };
        (dye, 1.0)
    } else if at.y > 0.0 {
        (dyes.vermilion, rays_of_dawn(at))
    } else {
        (dyes.teal, ripples(at))
    }
}

/// Rays above the strands, tone on tone, which open out from the sun.
fn rays_of_dawn(at: Vec2) -> f32 {
    let turn = libm::atan2f(at.x, at.y) / PI * 14.0;
    if (turn - libm::roundf(turn)).abs() < 0.25 { 1.10 } else { 0.86 }
}

/// Water below the strands: rings that widen with the distance from the sun.
fn ripples(at: Vec2) -> f32 {
    let ring = libm::sqrtf(at.length()) * 9.0;
    if ring - ring.floor() < 0.5 { 1.22 } else { 0.88 }
}

/// End of the eye around the sun, along the flag.
const EYE: f32 = 0.74;
/// Radians of twist per unit along the flag.
const TWIST: f32 = 7.6;

/// Height of the first strand's middle at `x`, and its slope; the second strand is its mirror image. The eye and the twist are each a piece of a sine, joined
/// where both are straight.
fn path(x: f32) -> (f32, f32) {
    const EYE_HEIGHT: f32 = 0.56;
    let side = if x < 0.0 { -1.0 } else { 1.0 };
    let along = x.abs();
    if along < EYE {
        let angle = along / EYE * FRAC_PI_2;
        (EYE_HEIGHT * libm::cosf(angle), -side * EYE_HEIGHT * FRAC_PI_2 / EYE * libm::sinf(angle))
    } else {
        let height = EYE_HEIGHT * FRAC_PI_2 / EYE / TWIST;
        let angle = (along - EYE) * TWIST;
        (-height * libm::sinf(angle), -side * height * TWIST * libm::cosf(angle))
    }
}

/// The strand that is in front near `x`: they alternate from crossing to crossing.
fn strand_in_front(x: f32) -> u32 {
    let crossing = libm::roundf((x.abs() - EYE).max(0.0) * TWIST / PI) as u32;
    (crossing + u32::from(x < 0.0)) % 2
}

/// Signed distance from `at` to a strand's middle, by iterating to the nearest point of its path.
fn distance_to_strand(at: Vec2, mirror: f32) -> f32 {
    let mut x = at.x;
    for _ in 0..5 {
        let (height, slope) = path(x);
        let (height, slope) = (height * mirror, slope * mirror);
        x -= ((x - at.x) + (height - at.y) * slope) / (1.0 + slope * slope);
    }
    let height = path(x).0 * mirror;
    let distance = at.distance(vec2(x, height));
    if at.y < height { -distance } else { distance }
}

/// Shading of a strand: three rounded fibres with furrows between. `aside` runs from −1 to 1.
fn fibres(aside: f32) -> f32 {
    let within = (aside + 1.0) * 1.5;
    let within = within - within.floor();
    let furrow = smooth(0.0, 0.16, within) * smooth(1.0, 0.84, within);
    (0.62 + 0.38 * furrow) * (1.0 - 0.16 * aside * aside)
}

const HOIST: f32 = 22.0;
const HEM: f32 = 9.0;

/// The canvas sleeve at the hoist with its two brass eyelets, and the thread of the seams.
fn sewn_edges(texel: Vec2, dyes: &Dyes) -> Option<(Vec3, f32)> {
    if texel.x < HOIST {
        for row in [34.0, HEIGHT as f32 - 34.0] {
            let distance = texel.distance(vec2(HOIST / 2.0, row));
            if distance < 3.2 {
                return Some((dyes.midnight, 0.7));
            }
            if distance < 7.0 {
                return Some((dyes.gold, 0.55 + 0.45 * smooth(7.0, 4.4, distance)));
            }
        }
        let stitch = (texel.x - (HOIST - 4.0)).abs() < 0.8 && texel.y % 9.0 < 6.0;
        return Some(if stitch { (dyes.vermilion, 0.9) } else { (dyes.ivory, 0.93) });
    }
    let (edge, along) = from_edge(texel);
    let stitch = (edge - HEM + 2.0).abs() < 0.7 && along % 9.0 < 5.5;
    stitch.then_some((dyes.ivory, 0.85))
}

/// Shading of the hem, which is cloth folded double: a little darker, with a crease at its inner side.
fn hem_shade(texel: Vec2) -> f32 {
    if texel.x < HOIST {
        return 1.0 - 0.3 * smooth(2.5, 0.0, HOIST - texel.x);
    }
    let sleeve_shadow = 1.0 - 0.35 * smooth(5.0, 0.0, texel.x - HOIST);
    let (edge, _) = from_edge(texel);
    let fold = if edge < HEM { 0.88 } else { 1.0 - 0.22 * smooth(2.5, 0.0, edge - HEM) };
    sleeve_shadow * fold
}

/// Distance of `texel` from the nearest of the three hemmed edges, and position along that edge.
fn from_edge(texel: Vec2) -> (f32, f32) {
    let top_or_bottom = texel.y.min(HEIGHT as f32 - texel.y);
    let fly = WIDTH as f32 - texel.x;
    if fly < top_or_bottom { (fly, texel.y) } else { (top_or_bottom, texel.x) }
}
