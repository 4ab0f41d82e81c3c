//! Converts items and lines to triangles that are safe to draw: every number is finite, every triangle has an area, every normal is on the visible side.

use glam::{Vec2, Vec3};

use super::camera::View;
use super::scene::{Item, Line, Scene};

/// Cosine of the crease angle, 40 degrees: faces at less than this angle are shaded as one smooth surface.
const CREASE: f32 = 0.766;

/// Half the width of a line: the least, in samples, and as a fraction of the image's height.
const LINE_SAMPLES: f32 = 1.6;
const LINE: f32 = 0.0018;

/// A triangle in world space with the attributes for shading.
pub(crate) struct Triangle {
    pub(crate) positions: [Vec3; 3],
    pub(crate) normals: [Vec3; 3],
    pub(crate) uvs: [Vec2; 3],
    /// Geometric normal of the plane; for a double-sided item on the side of the eye.
    pub(crate) face: Vec3,
    /// Mip level of the texture: how many times it is halved.
    pub(crate) lod: f32,
    /// The item or line that it comes from.
    pub(crate) source: Source,
    /// A back face, or a line's ribbon for the shadow: not drawn, but it casts a shadow.
    pub(crate) hidden: bool,
}

/// The item or line that a triangle comes from, by index.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Source {
    Item(usize),
    Line(usize),
}

/// All triangles of a scene, for an image with this many rows of samples.
pub(crate) fn triangles(scene: &Scene, view: &View, rows: usize) -> Vec<Triangle> {
    let mut out = Vec::with_capacity(
        scene.items.iter().map(|i| i.indices.len()).sum::<usize>() + scene.lines.len() * 4,
    );
    for (index, item) in scene.items.iter().enumerate() {
        push_item(&mut out, index, item, view, rows);
    }
    for (index, line) in scene.lines.iter().enumerate() {
        push_line(&mut out, index, line, scene.sun, view, rows);
    }
    out
}

fn push_item(out: &mut Vec<Triangle>, index: usize, item: &Item, view: &View, rows: usize) {
    let faces = Faces::new(item);
    let pixel = view.pixel(rows);
    for (number, corners) in item.indices.iter().enumerate() {
        let Some(face) = faces.unit(number) else {
            continue;
        };
        let corners = corners.map(|i| i as usize);
        let positions = corners.map(|i| item.positions[i]);
        let behind = face.dot(view.eye - positions[0]) < 0.0;
        // The normals of a double-sided item point to the eye's side.
        let side = if behind && item.double_sided { -1.0 } else { 1.0 };
        let normals = corners.map(|i| {
            let given = item.normals.as_ref().and_then(|n| n.get(i)?.try_normalize());
            side * given.unwrap_or_else(|| faces.smooth(number, i))
        });
        let uvs = corners
            .map(|i| item.uvs.as_ref().and_then(|uvs| uvs.get(i).copied()).unwrap_or_default());
        let lod = item.texture.as_ref().map_or(0.0, |texture| {
            let texels = (uvs[1] - uvs[0]).perp_dot(uvs[2] - uvs[0]).abs() * texture.area();
            let to_eye = view.eye - positions[0];
            let depth = view.depth(positions[0]).max(view.near);
            let slant = face.dot(to_eye).abs() / to_eye.length().max(1e-6);
            let samples = faces.area(number) * slant.max(0.1) / (pixel * depth).powi(2);
            0.5 * (texels / samples.max(1e-6)).max(1e-6).log2()
        });
        out.push(Triangle {
            positions,
            normals,
            uvs,
            face: face * side,
            lod,
            source: Source::Item(index),
            hidden: behind && !item.double_sided,
        });
    }
}

/// The face normals of an item's triangles, and the faces at each vertex.
struct Faces {
    /// Face normals with a length of twice the area; zero for a triangle that cannot be drawn.
    planes: Vec<Vec3>,
    /// Start of each vertex's faces in `around`; empty if the item has normals of its own.
    starts: Vec<u32>,
    around: Vec<u32>,
}

impl Faces {
    fn new(item: &Item) -> Self {
        let plane = |corners: &[u32; 3]| {
            let [Some(a), Some(b), Some(c)] = corners.map(|i| item.positions.get(i as usize))
            else {
                return Vec3::ZERO;
            };
            let normal = (b - a).cross(c - a);
            // Also false for NaN; a corner at infinity has an infinite or unknown length.
            if normal.length_recip().is_finite() && normal.is_finite() {
                normal
            } else {
                Vec3::ZERO
            }
        };
        let planes: Vec<Vec3> = item.indices.iter().map(plane).collect();
        let (mut starts, mut around) = (Vec::new(), Vec::new());
        if item.normals.is_none() {
            let drawn = || {
                (0u32..).zip(item.indices.iter()).filter(|(f, _)| planes[*f as usize] != Vec3::ZERO)
            };
            starts = vec![0u32; item.positions.len() + 1];
            for (_, corners) in drawn() {
                corners.iter().for_each(|&i| starts[i as usize] += 1);
            }
            let mut sum = 0;
            for start in &mut starts {
                sum += *start;
                *start = sum;
            }
            // Filled from the back of each vertex's range, which leaves `starts` at its front.
            around = vec![0u32; sum as usize];
            for (face, corners) in drawn() {
                for &i in corners {
                    starts[i as usize] -= 1;
                    around[starts[i as usize] as usize] = face;
                }
            }
        }
        Self { planes, starts, around }
    }

    fn unit(&self, face: usize) -> Option<Vec3> {
        self.planes[face].try_normalize()
    }

    fn area(&self, face: usize) -> f32 {
        self.planes[face].length() * 0.5
    }

    /// Normal at a face's corner, averaged over the faces at the vertex within the crease angle.
    fn smooth(&self, face: usize, vertex: usize) -> Vec3 {
        let Some(own) = self.unit(face) else {
            return Vec3::Y;
        };
        let [Some(&start), Some(&end)] = [self.starts.get(vertex), self.starts.get(vertex + 1)]
        else {
            return own;
        };
        let alike = |plane: &Vec3| plane.dot(own) > CREASE * plane.length();
        let around =
            self.around[start as usize..end as usize].iter().map(|&f| self.planes[f as usize]);
        around.filter(alike).sum::<Vec3>().try_normalize().unwrap_or(own)
    }
}

/// A line is two thin ribbons: a visible one that faces the eye, and a hidden one that faces the sun and casts the shadow.
fn push_line(
    out: &mut Vec<Triangle>,
    index: usize,
    line: &Line,
    sun: Vec3,
    view: &View,
    rows: usize,
) {
    let ends = [line.from, line.to];
    let Some(along) = (line.to - line.from).try_normalize() else {
        return;
    };
    for hidden in [false, true] {
        let face = if hidden { sun } else { view.eye - line.from };
        let (Some(face), Some(side)) = (face.try_normalize(), along.cross(face).try_normalize())
        else {
            continue;
        };
        let [[a, b], [c, d]] = ends.map(|p| {
            let samples = LINE_SAMPLES.max(rows as f32 * LINE);
            let half = samples * view.pixel(rows) * view.depth(p).abs().max(view.near);
            // Moved a little towards the eye, so that a line on a surface is in front of it.
            let p = if hidden { p } else { p + (view.eye - p) * 0.002 };
            [p - side * half, p + side * half]
        });
        for positions in [[a, c, b], [b, c, d]] {
            if positions.iter().all(|p| p.is_finite()) {
                out.push(Triangle {
                    positions,
                    normals: [face; 3],
                    uvs: [Vec2::ZERO; 3],
                    face,
                    lod: 0.0,
                    source: Source::Line(index),
                    hidden,
                });
            }
        }
    }
}
