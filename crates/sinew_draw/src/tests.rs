//! Tests of rendered images.

use std::f32::consts::FRAC_PI_4;

use glam::{Vec2, Vec3, vec3};

use super::scene::Line;
use super::*;

const RED: [f32; 3] = [0.9, 0.1, 0.1];
const BLUE: [f32; 3] = [0.1, 0.1, 0.9];

/// A scene with a camera on +Z, directed at the point (0, 1, 0).
fn scene<'a>() -> Scene<'a> {
    Scene::new(Camera { eye: vec3(0.0, 1.0, 4.0), target: vec3(0.0, 1.0, 0.0), fov: FRAC_PI_4 })
}

fn triangle<'a>(corners: [Vec3; 3], color: [f32; 3]) -> Item<'a> {
    Item::new(corners.to_vec(), vec![[0, 1, 2]], color)
}

fn upright<'a>(z: f32, color: [f32; 3]) -> Item<'a> {
    triangle([vec3(-1.0, 0.4, z), vec3(1.0, 0.4, z), vec3(0.0, 2.0, z)], color)
}

fn brightness([r, g, b, _]: [u8; 4]) -> u32 {
    u32::from(r) + u32::from(g) + u32::from(b)
}

#[test]
fn the_nearer_triangle_hides_the_farther_one_in_any_order() {
    for order in [[0, 1], [1, 0]] {
        let mut scene = scene();
        let items = [upright(0.5, RED), upright(-0.5, BLUE)];
        scene.items = order.map(|i: usize| items[i].clone()).to_vec();
        let [r, _, b, _] = render(&scene, 64, 64).at(32, 32);
        assert!(r > 150 && b < 100, "red in front: {r} {b}");
    }
}

#[test]
fn the_back_of_a_body_is_not_drawn_and_the_back_of_a_sheet_is() {
    let mut scene = scene();
    scene.ground = None;
    let sky = render(&scene, 64, 64).at(32, 32);
    let mut item = upright(0.0, RED);
    item.indices = vec![[0, 2, 1]].into();
    scene.items = vec![item];
    assert_eq!(render(&scene, 64, 64).at(32, 32), sky);
    scene.items[0].double_sided = true;
    let [r, _, b, _] = render(&scene, 64, 64).at(32, 32);
    assert!(r > b + 50, "red: {r} {b}");
}

#[test]
fn a_shadow_darkens_the_ground() {
    let mut scene = scene();
    scene.camera.eye = vec3(0.0, 6.0, 4.0);
    scene.camera.target = Vec3::ZERO;
    scene.sun = Vec3::Y;
    let lit = render(&scene, 64, 64);
    // Outside of the camera's view, between the ground and the sun.
    let roof = [vec3(-0.5, 20.0, -0.5), vec3(0.5, 20.0, -0.5), vec3(0.0, 20.0, 0.5)];
    scene.items = vec![triangle(roof, RED)];
    let dark = render(&scene, 64, 64);
    assert!(brightness(dark.at(32, 32)) + 100 < brightness(lit.at(32, 32)));
    assert_eq!(dark.at(4, 60), lit.at(4, 60), "far from the shadow nothing changes");
}

#[test]
fn a_surface_does_not_shade_itself() {
    let mut scene = scene();
    scene.camera.eye = vec3(3.0, 4.0, 4.0);
    scene.sun = vec3(0.9, 0.3, 0.2);
    let corner = |i: u32| vec3((i % 9) as f32 * 0.5 - 2.0, 1.0, (i / 9) as f32 * 0.5 - 2.0);
    let quads = (0..72u32).filter(|i| i % 9 != 8);
    let indices: Vec<_> = quads.flat_map(|i| [[i, i + 9, i + 1], [i + 1, i + 9, i + 10]]).collect();
    scene.items = vec![Item::new((0..81).map(corner).collect::<Vec<_>>(), indices, [0.5; 3])];
    let image = render(&scene, 64, 64);
    let middle: Vec<_> = (24..40).flat_map(|y| (24..40).map(move |x| (x, y))).collect();
    let shades = middle.iter().map(|&(x, y)| brightness(image.at(x, y)));
    assert!(
        shades.clone().max().unwrap() - shades.min().unwrap() < 12,
        "a flat plate is evenly lit"
    );
}

#[test]
fn what_reaches_behind_the_eye_is_cut_off_cleanly() {
    let mut scene = scene();
    scene.ground = None;
    let sky = render(&scene, 64, 64);
    // A long strip below the eye, from far in front to far behind.
    let strip = [vec3(-1.0, 0.0, -50.0), vec3(-1.0, 0.0, 50.0), vec3(1.0, 0.0, 50.0)];
    scene.items = vec![triangle(strip, RED)];
    let image = render(&scene, 64, 64);
    for y in 0..32 {
        for x in 0..64 {
            assert_eq!(image.at(x, y), sky.at(x, y), "nothing above the horizon at {x} {y}");
        }
    }
    assert_ne!(image.at(24, 60), sky.at(24, 60), "the strip is there");

    // Wholly behind the eye: nothing is drawn.
    scene.items =
        vec![triangle([vec3(-1.0, 0.0, 9.0), vec3(1.0, 0.0, 9.0), vec3(0.0, 2.0, 9.0)], RED)];
    scene.items[0].double_sided = true;
    assert_eq!(render(&scene, 64, 64), sky);
}

#[test]
fn an_empty_scene_is_sky_over_ground() {
    let image = render(&scene(), 64, 64);
    let [r, _, b, _] = image.at(32, 0);
    assert!(b > r, "the sky is blue: {r} {b}");
    assert!(brightness(image.at(32, 60)) > 500, "the ground is bright");
    assert_eq!(render(&scene(), 0, 5).pixels.len(), 0);
}

#[test]
fn what_cannot_be_drawn_is_left_out() {
    let mut scene = scene();
    let empty = render(&scene, 48, 48);
    let p = Vec3::ONE;
    scene.items = vec![
        triangle([vec3(f32::NAN, 0.0, 0.0), vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0)], RED),
        triangle([vec3(f32::INFINITY, 0.0, 0.0), vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0)], RED),
        triangle([p, p, p], RED),
        triangle([p, p * 2.0, p * 3.0], RED),
        Item::new(vec![p], vec![[0, 1, 2]], RED),
    ];
    let (from, color) = (Vec3::ZERO, RED);
    for to in [Vec3::ZERO, Vec3::NAN, Vec3::INFINITY] {
        scene.lines.push(Line { from, to, color });
    }
    assert_eq!(render(&scene, 48, 48), empty);
}

#[test]
fn huge_and_tiny_things_do_no_harm() {
    let mut scene = scene();
    let far = 1e12;
    scene.items = vec![
        triangle([vec3(-far, 0.3, -far), vec3(far, 0.3, -far), vec3(0.0, 0.3, far)], BLUE),
        triangle([vec3(-far, 0.0, 0.0), vec3(far, 1e-3, 0.0), vec3(far, far, 1e-9)], BLUE),
        triangle([Vec3::ONE, Vec3::ONE + Vec3::X * 1e-6, Vec3::ONE + Vec3::Y * 1e-6], BLUE),
        upright(0.0, RED),
    ];
    scene.items[0].double_sided = true;
    let [r, _, b, _] = render(&scene, 64, 64).at(32, 32);
    assert!(r > b + 50, "the red one is still there: {r} {b}");
}

#[test]
fn lines_are_seen() {
    let mut scene = scene();
    let (from, to) = (vec3(-1.0, 1.0, 0.0), vec3(1.0, 1.0, 0.0));
    scene.lines = vec![Line { from, to, color: RED }];
    let image = render(&scene, 64, 64);
    let [r, g, ..] = image.at(32, 32);
    assert!(r > g + 60, "red on the line: {r} {g}");
    let [r, g, ..] = image.at(32, 40);
    assert!(r.abs_diff(g) < 30, "and nothing beside it: {r} {g}");
}

#[test]
fn a_texture_has_its_first_row_at_the_top() {
    let (white, black) = ([255, 255, 255, 255], [0, 0, 0, 255]);
    let texels = [white, white, black, black].concat();
    let mut scene = scene();
    let corners =
        vec![vec3(-1.0, 0.1, 0.0), vec3(1.0, 0.1, 0.0), vec3(1.0, 2.0, 0.0), vec3(-1.0, 2.0, 0.0)];
    let mut item = Item::new(corners, vec![[0, 1, 2], [0, 2, 3]], [1.0; 3]);
    item.uvs = Some(vec![Vec2::Y, Vec2::ONE, Vec2::X, Vec2::ZERO].into());
    item.texture = Some(Texture::from_rgba8(2, 2, &texels).into());
    scene.items = vec![item];
    let image = render(&scene, 64, 64);
    assert!(brightness(image.at(32, 22)) > brightness(image.at(32, 42)) + 200);
}
