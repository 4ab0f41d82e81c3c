//! Rasterisation with `euc`: takes triangles in clip space, returns the nearest triangle of each sample.
//!
//! `euc` does not clip, so triangles are clipped against the near plane and far outside of the image beforehand. Its fragments are not colours but the
//! triangle's number and the position in it (a visibility buffer): each sample is shaded once, afterwards and on all cores, however often it was overdrawn.

use euc::{
    DepthStrategy, Interpolate, Pipeline,
    buffer::Buffer2d,
    rasterizer::{BackfaceCullingDisabled, Triangles},
};
use glam::{Vec2, Vec3, Vec4};

/// Guard band: how far beyond the edge a triangle may reach before it is clipped, as a multiple of the image's half size. Far enough that few triangles are
/// clipped, near enough that pixel coordinates stay small.
const GUARD: f32 = 3.0;

/// The triangle at a sample, and the barycentric weights of its first two corners there.
#[derive(Clone, Copy)]
pub(crate) struct Fragment {
    pub(crate) triangle: u32,
    pub(crate) weights: [f32; 2],
}

impl Fragment {
    /// No triangle.
    pub(crate) const NONE: Self = Self { triangle: u32::MAX, weights: [0.0; 2] };
}

/// The samples of an image: the fragment of each and its reversed depth (0 is nothing).
pub(crate) struct Samples {
    pub(crate) fragments: Buffer2d<Fragment>,
    pub(crate) depth: Buffer2d<f32>,
}

/// Finds the nearest triangle of each sample. `project` returns the clip coordinates of a triangle's corners, or `None` to leave it out.
pub(crate) fn nearest(
    size: [usize; 2],
    near: f32,
    count: usize,
    project: impl Fn(usize) -> Option<[Vec4; 3]>,
) -> Samples {
    let mut fragments = Buffer2d::new(size, Fragment::NONE);
    let mut depth = Buffer2d::new(size, 0.0);
    Numbered.draw::<Triangles<_, BackfaceCullingDisabled>, _>(
        &clipped(size, near, count, project),
        &mut fragments,
        Some(&mut depth),
    );
    Samples { fragments, depth }
}

/// Depth nearest to the light in each texel, for an orthographic projection; infinite where there is no triangle.
pub(crate) fn depths(
    size: usize,
    count: usize,
    project: impl Fn(usize) -> Option<[Vec4; 3]>,
) -> Buffer2d<f32> {
    let mut depth = Buffer2d::new([size; 2], f32::INFINITY);
    DepthOnly.draw::<Triangles<_, BackfaceCullingDisabled>, _>(
        &clipped([size; 2], 0.5, count, project),
        &mut Buffer2d::new([size; 2], ()),
        Some(&mut depth),
    );
    depth
}

/// A vertex for the rasteriser: clip coordinates, the triangle, and the position in it.
#[derive(Clone, Copy)]
struct Corner {
    clip: Vec4,
    at: Fragment,
}

/// Corners of all triangles, clipped to what `euc` can draw; three for each triangle.
fn clipped(
    size: [usize; 2],
    near: f32,
    count: usize,
    project: impl Fn(usize) -> Option<[Vec4; 3]>,
) -> Vec<Corner> {
    // A vertex is inside of a plane where the product with it, less the offset, is positive.
    let planes = [
        (Vec4::W, near),
        (Vec4::new(1.0, 0.0, 0.0, GUARD), 0.0),
        (Vec4::new(-1.0, 0.0, 0.0, GUARD), 0.0),
        (Vec4::new(0.0, 1.0, 0.0, GUARD), 0.0),
        (Vec4::new(0.0, -1.0, 0.0, GUARD), 0.0),
    ];
    let mut out = Vec::with_capacity(count * 3);
    let (mut polygon, mut cut) = (Vec::with_capacity(8), Vec::with_capacity(8));
    for triangle in 0..count {
        let Some(clips) = project(triangle) else {
            continue;
        };
        polygon.clear();
        for (clip, weights) in clips.into_iter().zip([[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]]) {
            let triangle = triangle as u32;
            polygon.push(Corner { clip, at: Fragment { triangle, weights } });
        }
        for (plane, offset) in planes {
            let inside = |c: &Corner| plane.dot(c.clip) - offset;
            if polygon.iter().any(|c| inside(c) < 0.0) {
                cut_polygon(&polygon, &mut cut, inside);
                std::mem::swap(&mut polygon, &mut cut);
            }
        }
        for i in 2..polygon.len() {
            push(&mut out, [polygon[0], polygon[i - 1], polygon[i]], size);
        }
    }
    out
}

/// The part of a convex polygon where `inside` is positive (one plane of the Sutherland–Hodgman algorithm).
fn cut_polygon(polygon: &[Corner], out: &mut Vec<Corner>, inside: impl Fn(&Corner) -> f32) {
    out.clear();
    for (i, b) in polygon.iter().enumerate() {
        let a = &polygon[(i + polygon.len() - 1) % polygon.len()];
        let (da, db) = (inside(a), inside(b));
        if (da < 0.0) != (db < 0.0) {
            let t = da / (da - db);
            out.push(a.towards(*b, t));
        }
        if db >= 0.0 {
            out.push(*b);
        }
    }
}

/// Adds a triangle if it covers something, prepared for `euc`.
///
/// - `euc` tests all samples of the rectangle around a triangle. For a long sliver across the image (a pole, a rope) that is a thousand times too many, so it
///   is halved until it fills a fair part of its rectangles.
/// - `euc` rounds each triangle separately, which leaves pinholes between neighbours, so each is enlarged in its own plane by some hundredths of a sample.
fn push(out: &mut Vec<Corner>, corners: [Corner; 3], size: [usize; 2]) {
    let [a, b, c] = corners.map(|c| Vec3::new(c.clip.x, c.clip.y, c.clip.w));
    let determinant = (a - c).cross(b - c).dot(c);
    // `euc` divides by this.
    if !determinant.is_normal() || !determinant.recip().is_finite() {
        return;
    }
    let half = Vec2::new(size[0] as f32, size[1] as f32) * 0.5;
    let at = [a, b, c].map(|p| p.truncate() / p.z * half);
    let edge = |i: usize| at[i].distance_squared(at[(i + 1) % 3]);
    let longest = if edge(0) >= edge(1).max(edge(2)) {
        0
    } else if edge(1) >= edge(2) {
        1
    } else {
        2
    };
    let area = (at[1] - at[0]).perp_dot(at[2] - at[0]).abs();
    let around = (at[0].max(at[1]).max(at[2]) - at[0].min(at[1]).min(at[2])).element_product();
    if around > 256.0 && around > 5.0 * area {
        let [p, q, r] = [0, 1, 2].map(|i| corners[(longest + i) % 3]);
        let middle = p.towards(q, 0.5);
        push(out, [p, middle, r], size);
        push(out, [middle, q, r], size);
        return;
    }
    let length = edge(longest).sqrt();
    // Limited so that the tip of a sliver does not show.
    let by = (0.03 * length / area).min(0.3 / length);
    let middle = corners[0].towards(corners[1], 0.5).towards(corners[2], 1.0 / 3.0);
    out.extend(corners.map(|corner| middle.towards(corner, 1.0 + by)));
}

impl Corner {
    /// The point at `t` on the straight line to another corner.
    fn towards(self, other: Self, t: f32) -> Self {
        Self {
            clip: self.clip.lerp(other.clip, t),
            at: Fragment::lerp2(self.at, other.at, 1.0 - t, t),
        }
    }
}

impl Interpolate for Fragment {
    #[inline(always)]
    fn lerp2(a: Self, b: Self, x: f32, y: f32) -> Self {
        Self {
            triangle: a.triangle,
            weights: [a.weights[0] * x + b.weights[0] * y, a.weights[1] * x + b.weights[1] * y],
        }
    }

    #[inline(always)]
    fn lerp3(a: Self, b: Self, c: Self, x: f32, y: f32, z: f32) -> Self {
        Self {
            triangle: a.triangle,
            weights: [
                a.weights[0] * x + b.weights[0] * y + c.weights[0] * z,
                a.weights[1] * x + b.weights[1] * y + c.weights[1] * z,
            ],
        }
    }
}

/// Pipeline that writes fragments.
struct Numbered;

impl Pipeline for Numbered {
    type Vertex = Corner;
    type VsOut = Fragment;
    type Pixel = Fragment;

    #[inline(always)]
    fn vert(&self, corner: &Corner) -> ([f32; 4], Fragment) {
        (corner.clip.to_array(), corner.at)
    }

    #[inline(always)]
    fn frag(&self, fragment: &Fragment) -> Fragment {
        *fragment
    }

    fn get_depth_strategy(&self) -> DepthStrategy {
        DepthStrategy::IfMoreWrite
    }
}

/// Pipeline that writes only the depth.
struct DepthOnly;

impl Pipeline for DepthOnly {
    type Vertex = Corner;
    type VsOut = ();
    type Pixel = ();

    #[inline(always)]
    fn vert(&self, corner: &Corner) -> ([f32; 4], ()) {
        (corner.clip.to_array(), ())
    }

    #[inline(always)]
    fn frag(&self, (): &()) {}
}
