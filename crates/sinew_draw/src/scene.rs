//! The input of `render`, in world space, so that a caller only copies what it already has.

use std::{borrow::Cow, sync::Arc};

use glam::{Vec2, Vec3};

use super::camera::Camera;
use super::texture::Texture;

/// What is drawn in one image.
pub struct Scene<'a> {
    /// The camera.
    pub camera: Camera,
    /// Direction from the scene to the sun; the length does not matter.
    pub sun: Vec3,
    /// Height of the infinite ground, or `None` for sky only.
    pub ground: Option<f32>,
    /// Surfaces.
    pub items: Vec<Item<'a>>,
    /// Lines: springs, ropes, gizmos.
    pub lines: Vec<Line>,
}

impl Scene<'_> {
    /// An empty scene with the ground at height 0 and a late-morning sun from behind on the left of a camera that looks along −Z.
    pub fn new(camera: Camera) -> Self {
        Self {
            camera,
            sun: Vec3::new(-0.55, 0.95, 0.8),
            ground: Some(0.0),
            items: Vec::new(),
            lines: Vec::new(),
        }
    }
}

/// A triangle mesh. Triangles with a missing or non-finite corner, and those without area, are left out.
#[derive(Clone)]
pub struct Item<'a> {
    /// Vertices in world space.
    pub positions: Cow<'a, [Vec3]>,
    /// A normal per vertex. With `None` they are computed, smooth across shared vertices but not across sharp edges, so that both a cloth and a box of eight
    /// vertices look right.
    pub normals: Option<Cow<'a, [Vec3]>>,
    /// A texture coordinate per vertex, (0, 0) at the top left of the texture, repeating.
    pub uvs: Option<Cow<'a, [Vec2]>>,
    /// Three vertices a triangle, counter-clockwise seen from the front.
    pub indices: Cow<'a, [[u32; 3]]>,
    /// sRGB, 0 to 1 a channel; multiplies the texture.
    pub color: [f32; 3],
    /// Texture; drawn only if there are `uvs`.
    pub texture: Option<Arc<Texture>>,
    /// Whether the back is visible too, and some sunlight shines through, as for a sheet of cloth.
    pub double_sided: bool,
}

impl<'a> Item<'a> {
    /// A closed body of one colour, with computed normals.
    pub fn new(
        positions: impl Into<Cow<'a, [Vec3]>>,
        indices: impl Into<Cow<'a, [[u32; 3]]>>,
        color: [f32; 3],
    ) -> Self {
        Self {
            positions: positions.into(),
            normals: None,
            uvs: None,
            indices: indices.into(),
            color,
            texture: None,
            double_sided: false,
        }
    }
}

/// A straight line, some pixels wide at any distance, that casts a thin shadow.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    /// Its start.
    pub from: Vec3,
    /// Its end.
    pub to: Vec3,
    /// sRGB, 0 to 1 a channel; not shaded.
    pub color: [f32; 3],
}
