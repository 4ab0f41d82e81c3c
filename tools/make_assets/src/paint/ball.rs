//! A beach ball for spheres: eight gores between two different caps, so that any spin is visible.

use core::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};

use super::Canvas;
use super::canvas::{hex, smooth};

const WIDTH: u32 = 512;
const HEIGHT: u32 = 256;
const GORES: usize = 8;

/// Paints the ball as an equirectangular map: longitude across, the north pole along the top.
pub(crate) fn ball() -> Canvas {
    let white = hex(0xfb_f6_ea);
    let red = hex(0xd9_34_2b);
    let orange = hex(0xf7_92_1e);
    let navy = hex(0x1a_2f_4d);
    let gores: [Vec3; GORES] = [red, white, orange, white, red, white, orange, white];
    let caps = [[orange, white, navy], [white, navy, red]];
    Canvas::paint(WIDTH, HEIGHT, |texel| surface(texel, &gores, &caps, navy))
}

fn surface(texel: Vec2, gores: &[Vec3; GORES], caps: &[[Vec3; 3]; 2], navy: Vec3) -> Vec3 {
    let polar = texel.y / HEIGHT as f32 * PI;
    let from_pole = polar.min(PI - polar);
    let from_equator = PI / 2.0 - from_pole;
    let cap = &caps[usize::from(polar > PI / 2.0)];

    // Each cap is a disc, a ring and a rim, welded to the gores under it.
    const RIM: f32 = 0.46;
    for (radius, colour) in [0.13, 0.36, RIM].into_iter().zip(cap) {
        if from_pole < radius {
            return *colour * weld(radius - from_pole) * weld(from_pole - (radius - 0.1).min(0.36));
        }
    }
    const BELT: f32 = 0.085;
    if from_equator < BELT {
        return navy * weld(BELT - from_equator);
    }

    let gore = texel.x / WIDTH as f32 * GORES as f32;
    let index = gore as usize % GORES;
    let across = gore - gore.floor();
    // Measured on the sphere rather than on the map, where the seams would widen towards the poles.
    let from_seam = across.min(1.0 - across) / GORES as f32 * TAU * libm::sinf(polar);
    gores[index] * weld(from_seam) * weld(from_pole - RIM) * weld(from_equator - BELT)
}

/// Brightness at an angle from a seam: a dark line, then vinyl that rises to its full colour.
fn weld(angle: f32) -> f32 {
    let angle = angle.abs();
    0.5 + 0.3 * smooth(0.006, 0.022, angle) + 0.2 * smooth(0.0, 0.26, angle)
}
