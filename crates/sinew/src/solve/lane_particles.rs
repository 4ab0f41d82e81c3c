//! The same particle of eight bodies that are solved side by side.

use glam::{Vec3, Vec4};

use crate::lanes::{LANES, Lanes};

/// `x y z w` of one particle of each body, in `SoA` order, on cache lines of its own.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct LaneParticles([[f32; LANES]; 4]);

impl LaneParticles {
    pub(super) const ZERO: Self = Self([[0.0; LANES]; 4]);

    #[inline(always)]
    pub(crate) fn load<L: Lanes>(&self) -> [L; 4] {
        let [x, y, z, w] = &self.0;
        [L::load(x), L::load(y), L::load(z), L::load(w)]
    }

    /// Writes `x y z`.
    #[inline(always)]
    pub(crate) fn put<L: Lanes>(&mut self, [a, b, c, _]: [L; 4]) {
        let [x, y, z, _] = &mut self.0;
        a.store(x);
        b.store(y);
        c.store(z);
    }

    /// Writes all four.
    #[inline(always)]
    pub(super) fn set<L: Lanes>(&mut self, [a, b, c, d]: [L; 4]) {
        let [x, y, z, w] = &mut self.0;
        a.store(x);
        b.store(y);
        c.store(z);
        d.store(w);
    }

    /// Writes `w`.
    #[inline(always)]
    pub(super) fn set_fourths<L: Lanes>(&mut self, w: L) {
        w.store(&mut self.0[3]);
    }

    /// A copy with the same number in all `w`.
    pub(super) fn with_fourths(&self, fourth: f32) -> Self {
        let [x, y, z, _] = self.0;
        Self([x, y, z, [fourth; LANES]])
    }

    /// The `w` of all eight.
    pub(super) fn fourths(&self) -> &[f32; LANES] {
        &self.0[3]
    }

    /// Copies the particle in lane `from` of another entry into `lane`.
    pub(super) fn copy_lane(&mut self, lane: usize, other: &Self, from: usize) {
        // Written out, because it runs for each particle of each body that changes its lane.
        let (lane, from) = (lane % LANES, from % LANES);
        let ([x, y, z, w], [a, b, c, d]) = (&mut self.0, &other.0);
        (x[lane], y[lane], z[lane], w[lane]) = (a[from], b[from], c[from], d[from]);
    }

    /// The particle of one body.
    pub(super) fn lane(&self, lane: usize) -> Vec4 {
        let [x, y, z, w] = &self.0;
        Vec4::new(x[lane], y[lane], z[lane], w[lane])
    }

    /// Writes all four of one body.
    pub(super) fn set_lane_whole(&mut self, lane: usize, to: Vec4) {
        let [x, y, z, w] = &mut self.0;
        (x[lane], y[lane], z[lane], w[lane]) = (to.x, to.y, to.z, to.w);
    }

    /// Writes `x y z` of one body.
    pub(super) fn set_lane(&mut self, lane: usize, to: Vec3) {
        let [x, y, z, _] = &mut self.0;
        (x[lane], y[lane], z[lane]) = (to.x, to.y, to.z);
    }
}
