//! Separating axes of two boxes, eight pairs in SIMD lanes.
//!
//! There are 15: the 3 normals of `b`, the 3 of `a`, and the 9 products of an edge of each. With `a`'s axes `Rⱼ` and centre `t` in the coordinates of `b`, and
//! `cᵢⱼ = eᵢ·Rⱼ`:
//!
//! ```text
//! face i of b:  |tᵢ| - hbᵢ - Σⱼ haⱼ |cᵢⱼ|
//! face j of a:  |t·Rⱼ| - haⱼ - Σᵢ hbᵢ |cᵢⱼ|
//! edges i, j:   (|t·(eᵢ×Rⱼ)| - Σₖ hbₖ |eₖ·(eᵢ×Rⱼ)| - Σₖ haₖ |Rₖ·(eᵢ×Rⱼ)|) / √(1 - cᵢⱼ²)
//! ```

use glam::{Mat3, Vec3};

use super::super::BIAS;
use super::{BoxPair, Frame, NEXT};
use crate::lanes::{LANES, LaneArray, Lanes, get, set};

/// Edges closer to parallel than this (squared sine) have no accurate product; a face normal serves as well there.
pub(super) const PARALLEL: f32 = 1e-6;

/// Rounding error of a separation, as a share of the numbers that it is a difference of: a few units in the last place.
const ROUNDING: f32 = 5e-7;

/// Up to eight pairs, one a lane.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct WidePairs {
    /// Half sizes of `a` and of `b`, metres.
    half_sizes: [[LaneArray; 3]; 2],
    /// Components of `a`'s axes in the coordinates of `b`, by axis of `a`: `cᵢⱼ` at `[j][i]`.
    axes: [[LaneArray; 3]; 3],
    offset: [LaneArray; 3],
    reach: LaneArray,
}

/// The best axes of a pair: those of least overlap, or greatest distance.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axes {
    /// Separation along the best face normal, metres.
    pub(super) face_separation: f32,
    /// The best pair of edges: an axis of `b` and one of `a`.
    pub(super) edge: (usize, usize),
    /// Separation along their product, metres. Negative infinity where no edges are farther apart than the faces, or overlap less.
    pub(super) edge_separation: f32,
    /// By how much an axis must be better to be preferred, metres.
    pub(super) bias: f32,
    /// Whether the edges are better than the face by more than that.
    pub(super) edge_wins: bool,
}

/// Eight pairs loaded into SIMD registers.
pub(super) struct LoadedPairs<L> {
    /// Half sizes of `a` and of `b`, metres.
    pub(super) ha: [L; 3],
    pub(super) hb: [L; 3],
    /// `cᵢⱼ` at `[j][i]`.
    pub(super) c: [[L; 3]; 3],
    /// The centre of `a` by axes of `b` (`t`) and by axes of `a` (`along`), metres.
    pub(super) t: [L; 3],
    pub(super) along: [L; 3],
    pub(super) reach: L,
}

/// The best axes of eight pairs.
pub(super) struct WideAxes<L> {
    /// The best face: 0, 1, 2 of `b`; 3, 4, 5 of `a`.
    pub(super) face: L,
    pub(super) face_separation: L,
    edge: L,
    edge_separation: L,
    bias: L,
    edge_wins: L,
    /// Mask of pairs whose other box is past the rim of the face.
    pub(super) past: L,
    /// Mask of pairs within reach.
    pub(super) near: L,
}

/// [`WideAxes`] in memory.
pub(super) struct StoredAxes {
    face_separation: LaneArray,
    edge: LaneArray,
    edge_separation: LaneArray,
    bias: LaneArray,
    edge_wins: u32,
}

impl WidePairs {
    /// No pairs: empty lanes are out of reach.
    pub(super) const NONE: Self = Self {
        half_sizes: [[[0.0; LANES]; 3]; 2],
        axes: [[[0.0; LANES]; 3]; 3],
        offset: [[0.0; LANES]; 3],
        reach: [-1.0; LANES],
    };

    /// Writes a pair into a lane.
    #[inline(always)]
    pub(super) fn put(&mut self, lane: usize, half_sizes: [Vec3; 2], a_in_b: &Frame, reach: f32) {
        for (to, from) in [(0, half_sizes[0]), (1, half_sizes[1])] {
            set(&mut self.half_sizes[to], lane, from);
        }
        let Mat3 { x_axis, y_axis, z_axis } = a_in_b.rotation;
        for (to, from) in [(0, x_axis), (1, y_axis), (2, z_axis)] {
            set(&mut self.axes[to], lane, from);
        }
        set(&mut self.offset, lane, a_in_b.translation);
        self.reach[lane] = reach;
    }

    /// The pair in a lane.
    #[inline(always)]
    pub(super) fn pair(&self, lane: usize) -> BoxPair {
        let [x, y, z] = &self.axes;
        let rotation = Mat3::from_cols(get(x, lane), get(y, lane), get(z, lane));
        BoxPair {
            half_sizes: [get(&self.half_sizes[0], lane), get(&self.half_sizes[1], lane)],
            frame: Frame { translation: get(&self.offset, lane), rotation },
            reach: self.reach[lane],
        }
    }

    /// Loads all eight pairs.
    #[inline(always)]
    pub(super) fn loaded<L: Lanes>(&self) -> LoadedPairs<L> {
        let c = [three::<L>(&self.axes[0]), three::<L>(&self.axes[1]), three::<L>(&self.axes[2])];
        let t = three::<L>(&self.offset);
        let mut along = t;
        for j in 0..3 {
            along[j] = c[j][0] * t[0] + c[j][1] * t[1] + c[j][2] * t[2];
        }
        let (ha, hb) = (three::<L>(&self.half_sizes[0]), three::<L>(&self.half_sizes[1]));
        LoadedPairs { ha, hb, c, t, along, reach: L::load(&self.reach) }
    }
}

impl<L: Lanes> LoadedPairs<L> {
    /// Finds the best axes of each pair.
    #[inline(always)]
    pub(super) fn separate(&self) -> WideAxes<L> {
        let Self { ha, hb, c, t, along, reach } = *self;
        let (zero, one) = (L::zero(), L::splat(1.0));
        let mut s = c;
        for j in 0..3 {
            for i in 0..3 {
                s[j][i] = c[j][i].abs();
            }
        }
        let small = L::splat(BIAS.1) * least(ha).min(least(hb));
        let mut near = zero.same(zero);
        // Lower bound of the distance, squared, and number of axes with a positive separation, for the axes of each box, which are orthogonal.
        let (mut squared, mut beyond) = ([zero; 2], [zero; 2]);
        let (mut face, mut most) = (zero, L::splat(f32::NEG_INFINITY));
        for i in 0..3 {
            let taken = s[0][i] * ha[0] + s[1][i] * ha[1] + s[2][i] * ha[2];
            let apart = t[i].abs() - hb[i] - taken;
            near = near.and(apart.le(reach));
            let out = apart.max(zero);
            squared[0] = squared[0] + out * out;
            beyond[0] = beyond[0] + zero.lt(apart).and(one);
            let more = most.lt(apart);
            face = more.select(L::splat(i as f32), face);
            most = more.select(apart, most);
        }
        let mut of_a = most + bias(small, most);
        for j in 0..3 {
            let taken = s[j][0] * hb[0] + s[j][1] * hb[1] + s[j][2] * hb[2];
            let apart = along[j].abs() - ha[j] - taken;
            near = near.and(apart.le(reach));
            let out = apart.max(zero);
            squared[1] = squared[1] + out * out;
            beyond[1] = beyond[1] + zero.lt(apart).and(one);
            let more = of_a.lt(apart);
            face = more.select(L::splat((3 + j) as f32), face);
            of_a = more.select(apart, of_a);
            most = more.select(apart, most);
        }
        near = near.and(squared[0].max(squared[1]).le(reach * reach));
        let (mut edge, mut edge_separation) = (zero, L::splat(f32::NEG_INFINITY));
        if near.any() {
            let unlikely = most.min(zero);
            for i in 0..3 {
                let (i1, i2) = NEXT[i];
                for j in 0..3 {
                    let (j1, j2) = NEXT[j];
                    let along = (c[j][i1] * t[i2] - c[j][i2] * t[i1]).abs();
                    let extent = s[j][i2] * hb[i1]
                        + s[j][i1] * hb[i2]
                        + ha[j1] * s[j2][i]
                        + ha[j2] * s[j1][i];
                    // Where the edges are nearly parallel, the quotient is of two small numbers: the possible rounding error is subtracted.
                    let apart = along - extent - (along + extent) * L::splat(ROUNDING);
                    // The divisor is at most 1, so a negative separation can only decrease.
                    let likely = unlikely.lt(apart);
                    let square = one - c[j][i] * c[j][i];
                    let apart = apart / square.max(L::splat(PARALLEL)).sqrt();
                    let more =
                        likely.and(L::splat(PARALLEL).lt(square)).and(edge_separation.lt(apart));
                    edge = more.select(L::splat((3 * i + j) as f32), edge);
                    edge_separation = more.select(apart, edge_separation);
                }
            }
            near = near.and(edge_separation.le(reach));
        }
        let bias = bias(small, most);
        let of_b = face.lt(L::splat(3.0));
        WideAxes {
            face,
            face_separation: most,
            edge,
            edge_separation,
            bias,
            edge_wins: (most + bias).lt(edge_separation),
            past: one.lt(of_b.select(beyond[0], beyond[1])),
            near,
        }
    }
}

impl<L: Lanes> WideAxes<L> {
    #[inline(always)]
    pub(super) fn in_lanes(&self) -> StoredAxes {
        StoredAxes {
            face_separation: self.face_separation.array(),
            edge: self.edge.array(),
            edge_separation: self.edge_separation.array(),
            bias: self.bias.array(),
            edge_wins: self.edge_wins.bits(),
        }
    }
}

impl StoredAxes {
    /// The axes of a lane.
    #[inline(always)]
    pub(super) fn of(&self, lane: usize) -> Axes {
        let edge = self.edge[lane] as usize;
        Axes {
            face_separation: self.face_separation[lane],
            edge: (edge / 3, edge % 3),
            edge_separation: self.edge_separation[lane],
            bias: self.bias[lane],
            edge_wins: self.edge_wins >> lane & 1 == 1,
        }
    }
}

/// By how much an axis must be better than one of a given separation, metres.
#[inline(always)]
fn bias<L: Lanes>(small: L, separation: L) -> L {
    small + L::splat(BIAS.0) * separation.abs()
}

#[inline(always)]
fn least<L: Lanes>([x, y, z]: [L; 3]) -> L {
    x.min(y).min(z)
}

#[inline(always)]
pub(super) fn three<L: Lanes>([x, y, z]: &[LaneArray; 3]) -> [L; 3] {
    [L::load(x), L::load(y), L::load(z)]
}
