//! Ridges: the edges of a mesh or heightfield that may fit in between the particles of a cloth, as thin boxes that features collide with.
//!
//! A surface of triangles need not be convex, so the nearest point of a feature cannot be found by a descent. But what gets in between the corners of a feature
//! is an edge of the surface, or a vertex at the end of some: a face that does so has an edge that does. So each edge that is convex stands for itself, as a box
//! with the edge on it, and [features](crate::collide::features) collide with that box as with any convex shape.
//!
//! The box is in the solid. Behind a face it fills at most a right angle, so it lies along one face of an edge that is no sharper. A sharper edge, or an edge of
//! a sheet, gets a blade in the middle between its faces, or along its only one.

use glam::{Mat3, Vec3};

use super::flat::Cuboid;
use super::tree::AabbTree;
use super::{Form, Shape};
use crate::collide::frame::Frame;

/// Tangent of half of the angle by which a surface bends at an edge, up to which it counts as flat there: about 2°.
const FLAT: f32 = 0.02;

/// Cosine of the interior angle up to which an edge counts as sharper than a right angle. More than 0 by rounding.
const RIGHT_ANGLE: f32 = 1e-3;

/// The convex edges of a surface of triangles.
#[derive(Clone, Debug, Default)]
pub(super) struct Ridges {
    /// In the order of the tree.
    list: Vec<Ridge>,
    tree: AabbTree,
}

/// A convex edge of a surface of triangles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ridge {
    /// Metres, in the frame of the shape.
    ends: [Vec3; 2],
    /// Unit vectors that are perpendicular to the edge and to each other: away from the edge, into the solid or along the face of a sheet; and out of the face.
    inward: Vec3,
    out: Vec3,
    /// Extent of the surface along `inward`, and of the solid against `out`, metres.
    extent: f32,
    depth: f32,
    /// Whether the box has the edge in the middle of a side, and not at a corner.
    is_blade: bool,
    /// Tangent of half of the angle by which the surface bends; infinite at the end of a sheet.
    bend: f32,
    /// Sum of the heights of the triangles over the edge, metres.
    width: f32,
}

impl Ridges {
    /// The ridges of triangles, each with its unit normal. Closed are those that are solid behind.
    pub(super) fn of(
        vertices: &[Vec3],
        triangles: &[[u32; 3]],
        normals: &[Vec3],
        closed: bool,
    ) -> Self {
        let mut sides: Vec<([u32; 2], u32, u32)> = (0..)
            .zip(triangles)
            .flat_map(|(i, t)| {
                [0, 1, 2].map(|k| {
                    let (a, b, opposite) = (t[k], t[(k + 1) % 3], t[(k + 2) % 3]);
                    ([a.min(b), a.max(b)], i, opposite)
                })
            })
            .collect();
        sides.sort_unstable();
        let at = |row: u32| vertices[row as usize];
        let face = |&([a, b], i, opposite): &([u32; 2], u32, u32)| {
            let away = (at(opposite) - at(a)).reject_from(at(b) - at(a));
            let (height, normal) = (away.length(), normals[i as usize]);
            Face { along: away / height, height, normal }
        };
        let of_edge = |own: &[([u32; 2], u32, u32)]| {
            let ends = own[0].0.map(at);
            let faces = [face(&own[0]), face(own.last().unwrap_or(&own[0]))];
            Ridge::between(ends, faces, own.len(), closed)
        };
        let found: Vec<Ridge> =
            sides.chunk_by(|one, other| one.0 == other.0).filter_map(of_edge).collect();
        let bounds: Vec<_> = found.iter().map(Ridge::bounds).collect();
        let (tree, order) = AabbTree::new(&bounds);
        Self { list: order.iter().map(|&i| found[i as usize]).collect(), tree }
    }
}

/// A triangle beside an edge.
#[derive(Clone, Copy, Debug)]
struct Face {
    /// Unit vector in the triangle, perpendicular to the edge and away from it.
    along: Vec3,
    /// Extent in that direction, metres.
    height: f32,
    normal: Vec3,
}

impl Ridge {
    /// The ridge of an edge between two of its `count` faces; `None` if it is flat or hollow.
    fn between(
        ends: [Vec3; 2],
        [one, other]: [Face; 2],
        count: usize,
        closed: bool,
    ) -> Option<Self> {
        let ridge = Self {
            ends,
            inward: one.along,
            out: one.normal,
            extent: one.height,
            depth: other.height,
            is_blade: !closed,
            bend: f32::INFINITY,
            width: one.height + other.height,
        };
        let is_valid = one.along.is_finite() && other.along.is_finite() && ends[0] != ends[1];
        if !is_valid {
            return None;
        }
        if count != 2 {
            return Some(ridge);
        }
        // Of the interior angle: -1 where it is flat.
        let cosine = one.along.dot(other.along).clamp(-1.0, 1.0);
        let bend = ((1.0 + cosine) / (1.0 - cosine)).sqrt();
        let is_hollow = closed && one.normal.dot(other.along) > 0.0;
        if bend <= FLAT || is_hollow {
            return None;
        }
        let ridge = Self { bend, ..ridge };
        if !closed || cosine <= RIGHT_ANGLE {
            return Some(ridge);
        }
        // A blade between the faces.
        let inward = (one.along + other.along).normalize();
        let out = inward.cross((ends[1] - ends[0]).normalize());
        let extent = one.height.min(other.height);
        Some(Self { inward, out, extent, is_blade: true, ..ridge })
    }

    fn bounds(&self) -> (Vec3, Vec3) {
        let [a, b] = self.ends;
        (a.min(b), a.max(b))
    }

    /// How far the surface presses in between two points that lie on it on either side of the edge, at a distance in metres from each other: metres, at most.
    /// At a single edge `½ l tan ½δ` for the angle `δ` by which it bends; and where it goes on to bend like that, as round a post of many sides, as a cylinder
    /// of radius `R = w/δ` does, `w` being the width of a side: `l²/8R`.
    pub(crate) fn rise(&self, length: f32) -> f32 {
        self.bend * length * (length / (2.0 * self.width)).max(0.5)
    }

    /// The box that stands for it, and its frame in that of the shape. It reaches no deeper than `most`, metres: it is not known what is there. A blade is as
    /// wide as `blade`, metres.
    pub(crate) fn solid(&self, most: f32, blade: f32) -> (Shape, Frame) {
        let Self { ends: [a, b], inward, out, .. } = *self;
        let extent = self.extent.min(most);
        let depth = if self.is_blade { blade } else { self.depth.min(most) };
        let along = inward.cross(out);
        let half_size = 0.5 * Vec3::new(extent, depth, a.distance(b));
        let down = if self.is_blade { 0.0 } else { half_size.y };
        let middle = (a + b) * 0.5 + inward * half_size.x - out * down;
        let frame = Frame { translation: middle, rotation: Mat3::from_cols(inward, out, along) };
        (Shape::of(Form::Cuboid(Cuboid { half_size })), frame)
    }
}

impl Shape {
    /// Calls `call` with the ridges of a mesh or heightfield whose bounds overlap a box (low, high), metres in its frame. Other shapes have none.
    pub(crate) fn ridges_near(&self, (low, high): (Vec3, Vec3), mut call: impl FnMut(&Ridge)) {
        let ridges = match &self.form {
            Form::Mesh(mesh) => self.derived.ridges.get_or_init(|| mesh.ridges()),
            Form::Heights(heights) => self.derived.ridges.get_or_init(|| heights.ridges()),
            _ => return,
        };
        let is_near = |least: Vec3, most: Vec3| least.cmple(high).all() && most.cmpge(low).all();
        let mut cursor = 0;
        while let Some(range) = ridges.tree.next(&mut cursor, is_near) {
            for ridge in &ridges.list[range] {
                let (least, most) = ridge.bounds();
                if is_near(least, most) {
                    call(ridge);
                }
            }
        }
    }
}
