//! Ambient occlusion: how much of the sky's light reaches a point. Corners and the ground under bodies are darker, so that a box appears to stand on the ground
//! rather than to float.
//!
//! Computed in screen space: each pixel samples some others around it, and counts those above its own plane.

use std::{f32::consts::TAU, ops::Range};

use glam::{Vec2, Vec3};

use super::camera::View;

/// Pixels that are sampled around each pixel.
const TAPS: usize = 8;

/// Radius of the samples: the first relative to the distance between eye and target, the second relative to the image's height. The smaller one applies.
const REACH: f32 = 0.08;
const REACH_SEEN: f32 = 0.12;

/// What occlusion reads of a pixel: its distance (infinite for the sky), its normal in view space (right, up, away), and whether it is more than ground or sky.
#[derive(Clone, Copy)]
pub(crate) struct Facet {
    pub(crate) depth: f32,
    pub(crate) normal: Vec3,
    pub(crate) solid: bool,
}

/// Unoccluded fraction of the sky, 0 to 1, of each pixel.
pub(crate) fn openness(view: &View, facets: &[Facet], width: usize, height: usize) -> Vec<f32> {
    let around = Surroundings {
        facets,
        size: [width, height],
        half: view.half_height(),
        reach: view.distance * REACH,
        pixel: view.pixel(height),
        turns: (0..16).map(spiral).collect(),
    };
    // The ground alone occludes nothing: only pixels near something solid are processed.
    let farthest = (height as f32 * REACH_SEEN).ceil() as usize;
    let Some([columns, rows]) = around.solid(farthest) else {
        return vec![1.0; facets.len()];
    };
    let each_pixel = |out: &mut [f32], open: &(dyn Fn([usize; 2]) -> f32 + Sync)| {
        each_row(out, width, |y, row| {
            for x in columns.clone().filter(|_| rows.contains(&y)) {
                row[x] = open([x, y]);
            }
        });
    };
    let mut rough = vec![1.0f32; facets.len()];
    each_pixel(&mut rough, &|at| around.look(at));
    let mut smooth = vec![1.0f32; facets.len()];
    each_pixel(&mut smooth, &|at| blurred(&rough, facets, [width, height], at));
    smooth
}

/// One of sixteen rotations of the same spiral of samples, within radius 1.
fn spiral(turn: usize) -> [Vec2; TAPS] {
    let turn = turn as f32 / 16.0;
    std::array::from_fn(|tap| {
        let radius = (tap as f32 + 0.25 + turn * 0.75) / TAPS as f32;
        Vec2::from_angle((tap as f32 * 0.381_966 + turn) * TAU) * radius
    })
}

struct Surroundings<'a> {
    facets: &'a [Facet],
    size: [usize; 2],
    /// Half the image's height at distance 1, and the width of a pixel there.
    half: f32,
    pixel: f32,
    reach: f32,
    turns: Vec<[Vec2; TAPS]>,
}

impl Surroundings<'_> {
    /// Columns and rows around all solid pixels, with a margin.
    fn solid(&self, margin: usize) -> Option<[Range<usize>; 2]> {
        let [width, height] = self.size;
        let (mut low, mut high) = ([width, height], [0, 0]);
        for (i, _) in self.facets.iter().enumerate().filter(|(_, facet)| facet.solid) {
            for (axis, at) in [i % width, i / width].into_iter().enumerate() {
                low[axis] = low[axis].min(at);
                high[axis] = high[axis].max(at + 1);
            }
        }
        let range = |axis: usize| {
            low[axis].saturating_sub(margin)..(high[axis] + margin).min(self.size[axis])
        };
        (high[0] > 0).then(|| [range(0), range(1)])
    }

    fn look(&self, [x, y]: [usize; 2]) -> f32 {
        let [width, height] = self.size;
        let here = self.facets[y * width + x];
        if !here.depth.is_finite() {
            return 1.0;
        }
        let pixels = (self.reach / (here.depth * self.pixel)).min(height as f32 * REACH_SEEN);
        if pixels < 1.0 {
            return 1.0;
        }
        let center = self.point(x, y, here.depth);
        let fall = (self.reach * self.reach).recip();
        // A tile of 4×4 pixels has each rotation once; the blur averages exactly such a tile.
        let turn = [0, 8, 2, 10, 12, 4, 14, 6, 3, 11, 1, 9, 15, 7, 13, 5][y % 4 * 4 + x % 4];
        let start = Vec2::new(x as f32, y as f32) + 0.5;
        let mut closed = 0.0;
        for step in &self.turns[turn] {
            let at = start + *step * pixels;
            // Negative coordinates are excluded below: the conversion to an integer would round them to 0.
            let (tx, ty) = (at.x as usize, at.y as usize);
            if at.x < 0.0 || at.y < 0.0 || tx >= width || ty >= height {
                continue;
            }
            let there = self.facets[ty * width + tx].depth;
            if there == f32::INFINITY {
                continue;
            }
            let offset = self.point(tx, ty, there) - center;
            let square = offset.length_squared() + 1e-12;
            let near = (1.0 - square * fall).max(0.0);
            let above = offset.dot(here.normal) / square.sqrt();
            closed += near * (above - 0.06).max(0.0);
        }
        (1.0 - closed * (2.6 / TAPS as f32)).clamp(0.0, 1.0)
    }

    /// View-space position of a pixel at this depth.
    fn point(&self, x: usize, y: usize, depth: f32) -> Vec3 {
        let [width, height] = self.size;
        let across = (2 * x + 1) as f32 - width as f32;
        let up = height as f32 - (2 * y + 1) as f32;
        // Pixels are square.
        let scale = self.half / height as f32 * depth;
        Vec3::new(across * scale, up * scale, depth)
    }
}

/// Mean of a 4×4 tile, without pixels that are clearly in front of or behind this one.
fn blurred(
    rough: &[f32],
    facets: &[Facet],
    [width, height]: [usize; 2],
    [x, y]: [usize; 2],
) -> f32 {
    let depth = facets[y * width + x].depth;
    let slack = depth * 0.02;
    let (mut sum, mut count) = (0.0, 0.0);
    for ty in y.saturating_sub(2)..(y + 2).min(height) {
        for tx in x.saturating_sub(2)..(x + 2).min(width) {
            let i = ty * width + tx;
            if (facets[i].depth - depth).abs() <= slack {
                sum += rough[i];
                count += 1.0;
            }
        }
    }
    if count > 0.0 { sum / count } else { 1.0 }
}

/// Runs `work` on all rows of a buffer, distributed over the cores.
pub(crate) fn each_row<T: Send>(
    buffer: &mut [T],
    width: usize,
    work: impl Fn(usize, &mut [T]) + Sync,
) {
    let rows = buffer.len() / width.max(1);
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let band = rows.div_ceil(threads).max(1);
    std::thread::scope(|scope| {
        for (number, rows) in buffer.chunks_mut((band * width).max(1)).enumerate() {
            let work = &work;
            scope.spawn(move || {
                for (y, row) in rows.chunks_mut(width).enumerate() {
                    work(number * band + y, row);
                }
            });
        }
    });
}
