//! Ridges: the edges of a mesh or heightfield that may fit in between the particles of a cloth, as thin boxes that features collide with.
//!
//! A surface of triangles need not be convex, so the nearest point of a feature cannot be found by a descent. But what gets in between the corners of a feature
//! is an edge of the surface, or a vertex at the end of some: a face that does so has an edge that does. So each edge that is convex stands for itself, as a box
//! with the edge on it, and [features](crate::collide::features) collide with that box as with any convex shape.
//!
//! The box is in the solid. Behind a face it fills at most a right angle, so it lies along one face of an edge that is no sharper. A sharper edge, or an edge of
//! a sheet, gets a blade in the middle between its faces, or along its only one. It is made smaller until it fits in, as at tips, in narrow triangles and in thin
//! walls.

use std::sync::OnceLock;

use glam::{Mat3, Vec3};

use super::flat::Cuboid;
use super::tree::AabbTree;
use super::{Form, Shape};
use crate::collide::frame::Frame;

/// Tangent of half of the angle by which a surface bends at an edge, up to which it counts as flat there: about 2°.
const FLAT: f32 = 0.02;

/// Cosine of the interior angle up to which an edge counts as sharper than a right angle. More than 0 by rounding.
const RIGHT_ANGLE: f32 = 1e-3;

/// How often a box that does not fit in is halved.
const HALVINGS: usize = 6;

/// The convex edges of a surface of triangles.
#[derive(Clone, Debug, Default)]
pub(super) struct Ridges {
    /// In the order of the tree.
    list: Vec<Ridge>,
    tree: AabbTree,
}

/// A convex edge of a surface of triangles.
#[derive(Clone, Debug)]
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
    /// Greatest size at which the box fits in, metres; found on first use.
    room: OnceLock<f32>,
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
        let found = sides.chunk_by(|one, other| one.0 == other.0).filter_map(|own| {
            let ends = own[0].0.map(at);
            let face = |&(_, i, opposite): &([u32; 2], u32, u32)| {
                Face::new(ends, at(opposite), normals[i as usize])
            };
            let (first, last) = (face(&own[0]), face(own.last()?));
            match own.len() {
                2 => Ridge::between(ends, [first, last], closed),
                _ => Ridge::end(ends, [first, last], closed),
            }
        });
        Self::new(found)
    }

    /// In the order in which they are given.
    pub(super) fn new(found: impl Iterator<Item = Ridge>) -> Self {
        let found: Vec<Ridge> = found.collect();
        let bounds: Vec<_> = found.iter().map(Ridge::bounds).collect();
        let (tree, order) = AabbTree::new(&bounds);
        Self { list: order.iter().map(|&i| found[i as usize].clone()).collect(), tree }
    }
}

/// A triangle beside an edge.
#[derive(Clone, Copy, Debug)]
pub(super) struct Face {
    /// Unit vector in the triangle, perpendicular to the edge and away from it.
    along: Vec3,
    /// Extent in that direction, metres.
    height: f32,
    normal: Vec3,
}

impl Face {
    /// A triangle with its third corner and its unit normal.
    #[inline]
    pub(super) fn new([a, b]: [Vec3; 2], opposite: Vec3, normal: Vec3) -> Self {
        let away = (opposite - a).reject_from(b - a);
        let height = away.length();
        Self { along: away / height, height, normal }
    }
}

impl Ridge {
    /// The ridge of an edge between two triangles; `None` if it is flat or hollow.
    #[inline]
    pub(super) fn between(ends: [Vec3; 2], faces: [Face; 2], closed: bool) -> Option<Self> {
        let [one, other] = faces;
        // Of the interior angle: -1 where it is flat.
        let cosine = one.along.dot(other.along).clamp(-1.0, 1.0);
        let bend = ((1.0 + cosine) / (1.0 - cosine)).sqrt();
        let is_hollow = closed && one.normal.dot(other.along) > 0.0;
        if bend <= FLAT || is_hollow {
            return None;
        }
        let ridge = Self { bend, ..Self::end(ends, faces, closed)? };
        if !closed || cosine <= RIGHT_ANGLE {
            return Some(ridge);
        }
        // A blade between the faces.
        let inward = (one.along + other.along).normalize();
        let out = inward.cross((ends[1] - ends[0]).normalize());
        let extent = one.height.min(other.height);
        Some(Self { inward, out, extent, is_blade: true, ..ridge })
    }

    /// The ridge of an edge at which a surface ends, or of which more than two triangles are a part; `None` if it has no direction.
    pub(super) fn end(ends: [Vec3; 2], [one, other]: [Face; 2], closed: bool) -> Option<Self> {
        let is_valid = one.along.is_finite() && other.along.is_finite() && ends[0] != ends[1];
        is_valid.then(|| Self {
            ends,
            inward: one.along,
            out: one.normal,
            extent: one.height,
            depth: other.height,
            is_blade: !closed,
            bend: f32::INFINITY,
            width: one.height + other.height,
            room: OnceLock::new(),
        })
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

    /// The box that stands for it on a surface, and its frame in that of the surface. It reaches no deeper than `most`, metres. A blade is as wide as `blade`,
    /// metres, and no box is smaller.
    pub(crate) fn solid(&self, surface: &Shape, most: f32, blade: f32) -> (Shape, Frame) {
        let room = *self.room.get_or_init(|| self.find_room(surface));
        let within = |size: f32| size.min(most).min(room).max(blade);
        let depth = if self.is_blade { blade } else { within(self.depth) };
        let (cuboid, frame) = self.cuboid(within(self.extent), depth);
        (Shape::of(Form::Cuboid(cuboid)), frame)
    }

    /// The greatest size at which no corner of the box is outside of a surface by more than a tenth of that, of some halved ones; 0 if it is none of them.
    fn find_room(&self, surface: &Shape) -> f32 {
        let mut room = self.extent.max(self.depth);
        for _ in 0..HALVINGS {
            let depth = if self.is_blade { 0.0 } else { self.depth.min(room) };
            let (cuboid, frame) = self.cuboid(self.extent.min(room), depth);
            let fits = (0..8_u32).all(|i| {
                let sign = |bit: u32| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
                let corner = frame.point(cuboid.half_size * Vec3::new(sign(0), sign(1), sign(2)));
                surface.nearest(corner).distance <= 0.1 * room
            });
            if fits {
                return room;
            }
            room *= 0.5;
        }
        0.0
    }

    fn cuboid(&self, extent: f32, depth: f32) -> (Cuboid, Frame) {
        let ([a, b], inward, out) = (self.ends, self.inward, self.out);
        let half_size = 0.5 * Vec3::new(extent, depth, a.distance(b));
        let down = if self.is_blade { 0.0 } else { half_size.y };
        let translation = (a + b) * 0.5 + inward * half_size.x - out * down;
        let rotation = Mat3::from_cols(inward, out, inward.cross(out));
        (Cuboid { half_size }, Frame { translation, rotation })
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recipes::convex_hull;

    const EVERYWHERE: (Vec3, Vec3) = (Vec3::NEG_INFINITY, Vec3::INFINITY);

    fn hull(points: &[Vec3]) -> Shape {
        Shape::mesh(points.to_vec(), convex_hull(points).unwrap()).unwrap()
    }

    fn block(size: Vec3, at: Vec3) -> Vec<Vec3> {
        let sign = |bit: u32, i: u32| if i >> bit & 1 == 1 { 0.5 } else { -0.5 };
        (0..8).map(|i| at + size * Vec3::new(sign(0, i), sign(1, i), sign(2, i))).collect()
    }

    fn cube() -> Shape {
        hull(&block(Vec3::ONE, Vec3::ZERO))
    }

    /// Its sides meet at a little more than a right angle; beside the base they are sharper.
    fn spike() -> Shape {
        let base = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        let [a, b, c, d] = base.map(|(x, z)| Vec3::new(0.1 * x, 0.0, 0.1 * z));
        hull(&[a, b, c, d, Vec3::Y])
    }

    fn all(shape: &Shape) -> Vec<Ridge> {
        let mut found = Vec::new();
        shape.ridges_near(EVERYWHERE, |ridge| found.push(ridge.clone()));
        found
    }

    #[test]
    fn only_convex_edges_are_ridges() {
        let cube = all(&cube());
        assert_eq!(cube.len(), 12, "without the diagonals of its sides");
        assert!(cube.iter().all(|ridge| (ridge.bend - 1.0).abs() < 1e-5 && !ridge.is_blade));
        // A valley between two rows of hills: the floor's edges are hollow.
        let heights = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
        let valley = Shape::height_field(3, 3, &heights, Vec3::new(2.0, 1.0, 2.0)).unwrap();
        let valley = all(&valley);
        assert_eq!(valley.len(), 8, "its rim");
        assert!(valley.iter().all(|ridge| ridge.bend == f32::INFINITY));
        // A square sheet: its rim, from both sides.
        let square = [Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y];
        let sheet = Shape::mesh(square.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).unwrap();
        let sheet = all(&sheet);
        assert_eq!(sheet.len(), 4);
        assert!(sheet.iter().all(|ridge| ridge.is_blade && ridge.bend == f32::INFINITY));
    }

    #[test]
    fn the_box_has_the_edge_on_it_and_is_in_the_solid_but_for_a_blade() {
        // A wall of 3 cm round a hollow of 1 m, without lid and floor: the boxes must not fill the hollow.
        let wall = |x: f32, z: f32| {
            let [wide, deep] = [x, z].map(|side| if side == 0.0 { 1.06 } else { 0.03 });
            block(Vec3::new(wide, 1.0, deep), Vec3::new(x, 0.0, z) * 0.515)
        };
        let (mut points, mut triangles) = (Vec::new(), Vec::new());
        for part in [wall(1.0, 0.0), wall(-1.0, 0.0), wall(0.0, 1.0), wall(0.0, -1.0)] {
            let first = points.len() as u32;
            triangles.extend(convex_hull(&part).unwrap().iter().map(|t| t.map(|i| i + first)));
            points.extend(part);
        }
        let walls = Shape::mesh(points, triangles).unwrap();
        for shape in [cube(), spike(), walls] {
            for ridge in all(&shape) {
                let (most, blade) = (0.2, 0.01);
                let (solid, frame) = ridge.solid(&shape, most, blade);
                assert!(frame.is_valid(), "{frame:?}");
                for end in ridge.ends {
                    let away = solid.nearest(frame.local(end)).distance;
                    assert!(away.abs() < 1e-6, "{ridge:?}: {away}");
                }
                let (_, half) = solid.bounds();
                for i in 0..8_u32 {
                    let sign = |bit: u32| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
                    let corner = frame.point(half * Vec3::new(sign(0), sign(1), sign(2)));
                    let out = shape.nearest(corner).distance;
                    let left = 0.1 * most + 0.5 * blade;
                    assert!(out < left, "{ridge:?}: {out} m outside");
                }
            }
        }
    }

    /// The ridges of a heightfield are found by its grid, those of a mesh by sorting.
    #[test]
    fn a_heightfield_has_the_ridges_of_its_triangles() {
        let (columns, rows) = (5_u32, 4_u32);
        let heights = [0.0, 0.3, 0.1, 0.9, 0.2, 0.7, 0.1, 0.4, 0.0, 0.5];
        let heights: Vec<f32> = (0..20).map(|i| heights[i * 7 % 10]).collect();
        let size = Vec3::new(4.0, 1.0, 3.0);
        let field = Shape::height_field(5, 4, &heights, size).unwrap();
        let point = |i: u32| {
            let (x, z) = ((i % columns) as f32 - 2.0, (i / columns) as f32 - 1.5);
            Vec3::new(x, heights[i as usize], z)
        };
        let vertices: Vec<Vec3> = (0..20).map(point).collect();
        let cells = (0..rows - 1).flat_map(|j| (0..columns - 1).map(move |i| j * columns + i));
        let triangles: Vec<[u32; 3]> = cells
            .flat_map(|a| {
                let (b, c) = (a + columns, a + 1);
                [[a, b, c], [b, b + 1, c]]
            })
            .collect();
        let normal = |t: &[u32; 3]| {
            let [a, b, c] = t.map(point);
            (b - a).cross(c - a).normalize()
        };
        let normals: Vec<Vec3> = triangles.iter().map(normal).collect();
        let expected = Ridges::of(&vertices, &triangles, &normals, true).list;
        let found = all(&field);
        assert_eq!(found.len(), expected.len());
        assert!(found.len() > 20);
        for ridge in &found {
            let middle = |ridge: &Ridge| (ridge.ends[0] + ridge.ends[1]) * 0.5;
            let near = |other: &&Ridge| middle(ridge).distance(middle(other)) < 1e-5;
            let other = expected.iter().find(near).expect("the same edge");
            assert!(ridge.bend == other.bend || (ridge.bend - other.bend).abs() < 1e-4);
            assert!((ridge.width - other.width).abs() < 1e-4);
            assert_eq!(ridge.is_blade, other.is_blade);
        }
    }

    /// From a single edge as from a wedge, and along many as from a cylinder.
    #[test]
    fn a_ridge_rises_between_two_points_as_a_wedge_or_a_cylinder_does() {
        let cube = all(&cube());
        assert!(cube.iter().all(|ridge| (ridge.rise(0.2) - 0.1).abs() < 1e-5));
        let (radius, sides) = (0.5, 64_u32);
        let ring = |height: f32| {
            (0..sides).map(move |i| {
                let angle = core::f64::consts::TAU * f64::from(i) / f64::from(sides);
                let (x, z) = (libm::cos(angle) as f32, libm::sin(angle) as f32);
                Vec3::new(radius * x, height, radius * z)
            })
        };
        let post = hull(&ring(-1.0).chain(ring(1.0)).collect::<Vec<_>>());
        let upright = all(&post).into_iter().filter(|ridge| ridge.ends[0].y != ridge.ends[1].y);
        let mut count = 0;
        for ridge in upright {
            let (found, expected) = (ridge.rise(0.3), 0.3 * 0.3 / (8.0 * radius));
            assert!((found / expected - 1.0).abs() < 0.02, "{found} {expected}");
            count += 1;
        }
        assert_eq!(count, sides);
    }
}
