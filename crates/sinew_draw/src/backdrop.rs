//! The background: a sky gradient, and a checkered ground that fades into it.

use glam::Vec3;

use super::camera::View;
use super::image::linear_of;

/// Colours in linear light, and the size of the ground's squares.
pub(crate) struct Backdrop {
    pub(crate) zenith: Vec3,
    pub(crate) horizon: Vec3,
    squares: [Vec3; 2],
    cell: f32,
    target: Vec3,
    distance: f32,
    height: Option<f32>,
}

impl Backdrop {
    pub(crate) fn new(view: &View, height: Option<f32>) -> Self {
        Self {
            zenith: linear_of([0.47, 0.65, 0.87]),
            horizon: linear_of([0.91, 0.94, 0.965]),
            squares: [linear_of([0.885, 0.885, 0.88]), linear_of([0.825, 0.83, 0.84])],
            cell: 10f32.powf((view.distance / 7.0).log10().round()),
            target: view.target,
            distance: view.distance,
            height,
        }
    }

    /// Colour of the sky in a direction.
    #[inline]
    pub(crate) fn sky(&self, ray: Vec3) -> Vec3 {
        let rise = ray.y / ray.length();
        let t = (rise * 2.2).clamp(0.0, 1.0);
        self.horizon.lerp(self.zenith, t * (2.0 - t))
    }

    /// Distance along `ray` to the ground, if it is visible from above.
    #[inline]
    pub(crate) fn ground_depth(&self, eye: Vec3, ray: Vec3) -> Option<f32> {
        let below = eye.y - self.height?;
        (below > 0.0 && ray.y < 0.0).then(|| below / -ray.y)
    }

    /// Colour of the ground at a point, averaged over a sample of this width, and how far it has faded into the sky there, 0 to 1.
    #[inline]
    pub(crate) fn ground(&self, point: Vec3, width: [f32; 2]) -> (Vec3, f32) {
        let square = |x: f32, width: f32| {
            // Mean, over the sample's width, of a wave that is +1 on even squares and −1 on odd ones.
            let w = (width / self.cell).max(1e-3);
            let sum = |x: f32| 1.0 - 4.0 * (x * 0.5 - (x * 0.5).floor() - 0.5).abs();
            let x = x / self.cell;
            (sum(x + w * 0.5) - sum(x - w * 0.5)) * 0.5 / w
        };
        let checker = 0.5 + 0.5 * square(point.x, width[0]) * square(point.z, width[1]);
        let away = point.with_y(self.target.y).distance(self.target) / self.distance;
        let fade = ((away - 0.5) / 3.5).clamp(0.0, 1.0);
        let fade = fade * fade * (3.0 - 2.0 * fade);
        (self.squares[0].lerp(self.squares[1], checker), fade)
    }
}
