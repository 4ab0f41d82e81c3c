//! A six-sided lantern with a handle, as one watertight surface: the handle grows out of the roof, so the solid has a hole through it but no inner walls.

use core::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3, vec2, vec3};

use super::mesh::{Corner, Mesh, centroid};
use super::writer::{Surface, write};
use crate::paint::{self, Swatch};

/// The lantern as a binary glTF file, its centre of mass at the origin.
pub(crate) fn lantern() -> Vec<u8> {
    let mut triangles = Vec::new();
    let rings: Vec<Vec<Vec3>> = ROWS.iter().map(ring).collect();
    body(&mut triangles, &rings);
    handle(&mut triangles, &rings);
    let middle = centroid(&triangles);
    for corner in triangles.as_flattened_mut() {
        corner.position -= middle;
    }

    let mesh = Mesh::from_triangles(&triangles, libm::cosf(28.0 * PI / 180.0));
    let (picture, glow) = (paint::lantern_palette().to_png(), paint::lantern_glow().to_png());
    write(
        "lantern",
        &mesh,
        &Surface { picture: &picture, glow: Some(&glow), roughness: 0.5, double_sided: false },
    )
}

/// A horizontal outline of the body, and the material of the band from it up to the next one.
struct Row {
    /// Distance from the axis to the middle of a side.
    apothem: f32,
    height: f32,
    /// Depth of the panes behind the posts.
    recess: f32,
    cover: Swatch,
}

const fn row(apothem: f32, height: f32, recess: f32, cover: Swatch) -> Row {
    Row { apothem, height, recess, cover }
}

const ROWS: [Row; 22] = [
    row(0.120, 0.000, 0.0, Swatch::Enamel),
    row(0.145, 0.008, 0.0, Swatch::Enamel),
    row(0.150, 0.022, 0.0, Swatch::Enamel),
    row(0.136, 0.050, 0.0, Swatch::Brass),
    row(0.136, 0.066, 0.0, Swatch::Iron),
    row(0.126, 0.072, 0.0, Swatch::Iron),
    row(0.126, 0.082, 0.016, Swatch::Glass),
    row(0.130, 0.145, 0.013, Swatch::Glass),
    row(0.134, 0.210, 0.011, Swatch::Glass),
    row(0.137, 0.275, 0.013, Swatch::Glass),
    row(0.140, 0.338, 0.017, Swatch::Iron),
    row(0.140, 0.348, 0.0, Swatch::Brass),
    row(0.188, 0.345, 0.0, Swatch::Brass),
    row(0.192, 0.360, 0.0, Swatch::Enamel),
    row(0.150, 0.376, 0.0, Swatch::Enamel),
    row(0.112, 0.400, 0.0, Swatch::Enamel),
    row(0.082, 0.432, 0.0, Swatch::Enamel),
    row(0.066, 0.462, 0.0, Swatch::Brass),
    row(0.082, 0.468, 0.0, Swatch::Brass),
    row(0.080, 0.482, 0.0, Swatch::Enamel),
    row(0.052, 0.500, 0.0, Swatch::Enamel),
    row(0.020, 0.510, 0.0, Swatch::Brass),
];

const SIDES: usize = 6;
/// Points of a ring on each side: a post's edge, a pane from the second point to the third, a post's edge.
const PER_SIDE: usize = 4;
const AROUND: usize = SIDES * PER_SIDE;

fn ring(row: &Row) -> Vec<Vec3> {
    let half_side = row.apothem * libm::tanf(PI / SIDES as f32);
    let post = half_side - 0.016_f32.min(half_side * 0.22);
    let pane = post - 0.009_f32.min(half_side * 0.12);
    (0..AROUND)
        .map(|index| {
            let side = (index / PER_SIDE) as f32 * TAU / SIDES as f32;
            let (outward, along) = (direction(side), direction(side + PI / 2.0));
            let (recess, aside) =
                [(0.0, -post), (row.recess, -pane), (row.recess, pane), (0.0, post)]
                    [index % PER_SIDE];
            outward * (row.apothem - recess) + along * aside + Vec3::Y * row.height
        })
        .collect()
}

/// The horizontal unit vector at an angle from x, counter-clockwise as seen from above.
fn direction(angle: f32) -> Vec3 {
    vec3(libm::cosf(angle), 0.0, -libm::sinf(angle))
}

fn body(triangles: &mut Vec<[Corner; 3]>, rings: &[Vec<Vec3>]) {
    for (index, pair) in rings.windows(2).enumerate() {
        let (below, above) = (&pair[0], &pair[1]);
        for from in 0..AROUND {
            if HANDLE_FEET.contains(&(index, from)) {
                continue;
            }
            let to = (from + 1) % AROUND;
            let pane = from % PER_SIDE == 1;
            let cover = ROWS[index].cover;
            let cover = if cover == Swatch::Glass && !pane { Swatch::Iron } else { cover };
            quad(triangles, [below[from], below[to], above[to], above[from]], |at| {
                texture(cover, at.y)
            });
        }
    }
    let (bottom, top) = (&rings[0], &rings[rings.len() - 1]);
    for from in 0..AROUND {
        let to = (from + 1) % AROUND;
        let axis = |y: f32| vec3(0.0, y, 0.0);
        fan(triangles, [axis(bottom[0].y), bottom[to], bottom[from]], Swatch::Enamel);
        fan(triangles, [axis(top[0].y + 0.008), top[from], top[to]], Swatch::Brass);
    }
}

/// The faces of the roof from which the handle grows, as ring and index around it: the bevels of two opposite corners.
const HANDLE_FEET: [(usize, usize); 2] = [(14, 3), (14, 15)];

/// Sweeps a square tube along half an ellipse, from one missing face of the roof to the other.
fn handle(triangles: &mut Vec<[Corner; 3]>, rings: &[Vec<Vec3>]) {
    const STEPS: usize = 18;
    const SPAN: f32 = 0.150;
    const BASE: f32 = 0.418;
    const RISE: f32 = 0.174;
    const THICKNESS: f32 = 0.008;
    let corner_angle = PI / SIDES as f32;
    let (outward, along) = (direction(corner_angle), direction(corner_angle + PI / 2.0));
    let foot = |(index, from): (usize, usize)| {
        let (below, above) = (&rings[index], &rings[index + 1]);
        [below[from], below[from + 1], above[from + 1], above[from]]
    };

    let mut sections = vec![foot(HANDLE_FEET[0])];
    sections.extend((0..=STEPS).map(|step| {
        let angle = PI * step as f32 / STEPS as f32;
        let (sin, cos) = (libm::sinf(angle), libm::cosf(angle));
        let middle = outward * (SPAN * cos) + Vec3::Y * (BASE + RISE * sin);
        let away = (outward * (cos / SPAN) + Vec3::Y * (sin / RISE)).normalize() * THICKNESS;
        let aside = along * THICKNESS;
        [middle + away - aside, middle + away + aside, middle - away + aside, middle - away - aside]
    }));
    // The far foot is reached from the other side, which swaps left and right.
    let [a, b, c, d] = foot(HANDLE_FEET[1]);
    sections.push([b, a, d, c]);

    for pair in sections.windows(2) {
        for from in 0..4 {
            let to = (from + 1) % 4;
            quad(triangles, [pair[0][from], pair[0][to], pair[1][to], pair[1][from]], |at| {
                texture(Swatch::Brass, at.y)
            });
        }
    }
}

/// Texture coordinate of a swatch at a height. Swatches are shaded from the lantern's foot to its top, the glass from the panes' lower edge to their upper
/// edge.
fn texture(cover: Swatch, height: f32) -> Vec2 {
    let (bottom, top) = if cover == Swatch::Glass { (0.082, 0.338) } else { (-0.10, 0.60) };
    vec2(cover.u(), 1.0 - ((height - bottom) / (top - bottom)).clamp(0.0, 1.0))
}

fn fan(triangles: &mut Vec<[Corner; 3]>, corners: [Vec3; 3], cover: Swatch) {
    triangles.push(corners.map(|position| Corner { position, uv: texture(cover, position.y) }));
}

/// Two triangles over a face whose corners are counter-clockwise seen from outside.
fn quad(triangles: &mut Vec<[Corner; 3]>, corners: [Vec3; 4], uv: impl Fn(Vec3) -> Vec2) {
    let [a, b, c, d] = corners.map(|position| Corner { position, uv: uv(position) });
    triangles.extend([[a, b, c], [a, c, d]]);
}
