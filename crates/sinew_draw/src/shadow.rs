//! Shadow map: the depth as seen from the sun, sampled with soft edges.

use euc::buffer::Buffer2d;
use glam::{Vec3, Vec4};

use super::camera::View;
use super::geometry::Triangle;
use super::raster;

/// Depth of the scene as seen from the sun.
pub(crate) struct ShadowMap {
    depth: Buffer2d<f32>,
    /// Texels along a side.
    size: usize,
    /// Unit vector towards the sun, and two perpendicular to it.
    pub(crate) sun: Vec3,
    right: Vec3,
    up: Vec3,
    /// Centre and half width of the covered square, perpendicular to the sun; texel size in the world.
    middle: [f32; 2],
    half: f32,
    texel: f32,
}

impl ShadowMap {
    /// Builds a map that covers all triangles near the camera's target; a body that flew off to the horizon must not cost the rest its resolution.
    pub(crate) fn new(triangles: &[Triangle], sun: Vec3, view: &View, size: usize) -> Self {
        let sun = sun.try_normalize().unwrap_or(Vec3::Y);
        // Aligned with the world's vertical, so that upright things cover few texels.
        let right = Vec3::Y.cross(sun).try_normalize().unwrap_or(Vec3::X);
        let up = sun.cross(right);
        let reach = view.distance * 3.0;
        let (mut low, mut high) = ([f32::MAX; 2], [f32::MIN; 2]);
        for p in triangles.iter().flat_map(|t| t.positions) {
            if p.distance_squared(view.target) < reach * reach {
                for (axis, across) in [right, up].into_iter().enumerate() {
                    low[axis] = low[axis].min(p.dot(across));
                    high[axis] = high[axis].max(p.dot(across));
                }
            }
        }
        let empty = low[0] > high[0];
        let middle = [0, 1].map(|i| if empty { 0.0 } else { (low[i] + high[i]) * 0.5 });
        // With a margin of a few texels, so that soft edges stay within the map.
        let half =
            if empty { 1.0 } else { ((high[0] - low[0]).max(high[1] - low[1]) * 0.51).max(1e-3) };
        let mut map = Self {
            depth: Buffer2d::new([0; 2], 0.0),
            size,
            sun,
            right,
            up,
            middle,
            half,
            texel: 2.0 * half / size as f32,
        };
        map.depth = raster::depths(size, triangles.len(), |t| {
            Some(triangles[t].positions.map(|p| map.project(p)))
        });
        map
    }

    /// Position in the map: x and y from −1 to 1; depth grows away from the sun, in world units.
    #[inline]
    fn project(&self, p: Vec3) -> Vec4 {
        let x = (p.dot(self.right) - self.middle[0]) / self.half;
        let y = (p.dot(self.up) - self.middle[1]) / self.half;
        Vec4::new(x, y, -p.dot(self.sun), 1.0)
    }

    /// Lit fraction, 0 to 1, of a point on a surface with this geometric normal, which faces the sun.
    #[inline]
    pub(crate) fn light(&self, point: Vec3, normal: Vec3) -> f32 {
        let cosine = normal.dot(self.sun).clamp(0.0, 1.0);
        let sine = (1.0 - cosine * cosine).sqrt();
        // Normal offset: the point is moved off the surface by as much as the surface slopes over the width of the soft edge, so that the surface does not
        // shade itself.
        let lifted = point + normal * (self.texel * (0.4 + 2.6 * sine));
        let p = self.project(lifted);
        let (u, v) = ((p.x + 1.0) * 0.5 * self.size as f32, (1.0 - p.y) * 0.5 * self.size as f32);
        let limit = self.size as f32 - 3.0;
        if !(u > 2.0 && v > 2.0 && u < limit && v < limit) {
            return 1.0;
        }
        // A box filter three texels wide that moves smoothly: four taps a side, the outer two weighted by their part.
        let (x, y) = ((u - 0.5).floor(), (v - 0.5).floor());
        let (fx, fy) = (u - 0.5 - x, v - 0.5 - y);
        let depth = self.depth.as_ref();
        let mut lit = 0.0;
        for (row, wy) in [1.0 - fy, 1.0, 1.0, fy].into_iter().enumerate() {
            let start = (y as usize + row - 1) * self.size + x as usize - 1;
            let taps = &depth[start..start + 4];
            let open = |tap: usize| if taps[tap] >= p.z { 1.0 } else { 0.0 };
            lit += wy * (open(0) * (1.0 - fx) + open(1) + open(2) + open(3) * fx);
        }
        lit / 9.0
    }
}
