//! A swallow-tailed banner as a test for cloth from meshes: no grid, random order, and a seam to weld.

use glam::{Vec2, Vec3, vec2};

use super::delaunay::triangulate;
use super::mesh::Mesh;
use super::writer::{Surface, write};
use crate::paint::shape::{HALF_WIDTH, LENGTH, NOTCH};
use crate::paint::{self, Dice};

/// The banner as a binary glTF file. Its top edge is at y = 0; it lies in the plane z = 0 and faces +z.
pub(crate) fn banner() -> Vec<u8> {
    let mut dice = Dice::new(20);
    let mut mesh = Mesh::default();
    for right in [false, true] {
        sew_panel(&mut mesh, right, &mut dice);
    }
    shuffle(&mut mesh, &mut dice);
    let picture = paint::banner().to_png();
    write(
        "banner",
        &mesh,
        &Surface { picture: &picture, glow: None, roughness: 0.9, double_sided: true },
    )
}

/// Approximate distance between vertices, in metres.
const SPACING: f32 = 0.082;

/// Adds one half of the banner. It has seam vertices of its own, at exactly the positions of the other half's.
fn sew_panel(mesh: &mut Mesh, right: bool, dice: &mut Dice) {
    let side = if right { HALF_WIDTH } else { -HALF_WIDTH };
    let corners = [vec2(0.0, 0.0), vec2(0.0, -NOTCH), vec2(side, -LENGTH), vec2(side, 0.0)];
    let mut points = Vec::new();
    for (index, &from) in corners.iter().enumerate() {
        let to = corners[(index + 1) % corners.len()];
        let steps = libm::roundf(from.distance(to) / SPACING) as usize;
        points.extend((0..steps).map(|step| from.lerp(to, step as f32 / steps as f32)));
    }
    scatter(&mut points, side, dice);

    let exact: Vec<[f64; 2]> = points.iter().map(|point| point.to_array().map(f64::from)).collect();
    let vertices: Vec<u32> = points
        .iter()
        .map(|&point| mesh.push(point.extend(0.0), Vec3::Z, paint::banner_uv(point, right)))
        .collect();
    mesh.triangles.extend(
        triangulate(&exact).into_iter().map(|corners| corners.map(|corner| vertices[corner])),
    );
}

/// Fills the panel with random points that keep a minimum distance, until no more fit.
fn scatter(points: &mut Vec<Vec2>, side: f32, dice: &mut Dice) {
    let mut misses = 0;
    while misses < 3000 {
        let at = vec2(side * dice.unit(), -LENGTH * dice.unit());
        let inside = at.y > -NOTCH - at.x.abs() / HALF_WIDTH * (LENGTH - NOTCH);
        let free = points.iter().all(|point| point.distance(at) > SPACING * 0.82);
        if inside && free {
            points.push(at);
        } else {
            misses += 1;
        }
    }
}

/// Shuffles vertices and triangles, and rotates the first corner of each triangle.
fn shuffle(mesh: &mut Mesh, dice: &mut Dice) {
    let mut order: Vec<usize> = (0..mesh.positions.len()).collect();
    dice.shuffle(&mut order);
    let mut place = vec![0; order.len()];
    for (new, &old) in order.iter().enumerate() {
        place[old] = new as u32;
    }
    mesh.positions = order.iter().map(|&old| mesh.positions[old]).collect();
    mesh.normals = order.iter().map(|&old| mesh.normals[old]).collect();
    mesh.uvs = order.iter().map(|&old| mesh.uvs[old]).collect();

    dice.shuffle(&mut mesh.triangles);
    for triangle in &mut mesh.triangles {
        *triangle = triangle.map(|vertex| place[vertex as usize]);
        triangle.rotate_left(dice.below(3));
    }
}
