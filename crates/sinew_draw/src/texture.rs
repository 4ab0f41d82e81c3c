//! Textures with mipmaps and trilinear filtering.

use glam::{Vec2, Vec3};

use super::image::linear_of;

/// A repeating texture, with mipmaps.
#[derive(Clone, Debug)]
pub struct Texture {
    levels: Vec<Level>,
}

#[derive(Clone, Debug)]
struct Level {
    width: usize,
    height: usize,
    /// Linear light.
    texels: Vec<Vec3>,
}

impl Texture {
    /// Creates a texture from sRGB bytes, four a pixel, rows from the top; alpha is ignored. Panics if `rgba` is too short or the texture is empty.
    pub fn from_rgba8(width: usize, height: usize, rgba: &[u8]) -> Self {
        assert!(
            width > 0 && height > 0 && rgba.len() >= width * height * 4,
            "a texture needs its texels"
        );
        let decoded: Vec<f32> = (0..=255).map(|b| linear_of([b as f32 / 255.0; 3]).x).collect();
        let texel = |p: &[u8]| Vec3::from([p[0], p[1], p[2]].map(|b| decoded[usize::from(b)]));
        let mut levels = vec![Level {
            width,
            height,
            texels: rgba.chunks_exact(4).take(width * height).map(texel).collect(),
        }];
        while let Some(last) = levels.last()
            && last.width.max(last.height) > 1
        {
            levels.push(last.halved());
        }
        Self { levels }
    }

    /// Number of texels in the finest level.
    pub(crate) fn area(&self) -> f32 {
        (self.levels[0].width * self.levels[0].height) as f32
    }

    /// Linear light at `uv`; `lod` is the mip level, the number of times the texture is halved so that a texel is about a sample wide.
    #[inline]
    pub(crate) fn sample(&self, uv: Vec2, lod: f32) -> Vec3 {
        let lod = lod.clamp(0.0, (self.levels.len() - 1) as f32);
        let level = lod as usize;
        let fine = self.levels[level].bilinear(uv);
        match self.levels.get(level + 1) {
            Some(coarse) if lod.fract() > 0.0 => fine.lerp(coarse.bilinear(uv), lod.fract()),
            _ => fine,
        }
    }
}

impl Level {
    fn halved(&self) -> Self {
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        let at = |x: usize, y: usize| {
            self.texels[y.min(self.height - 1) * self.width + x.min(self.width - 1)]
        };
        let average = |i: usize| {
            let (x, y) = (i % width * 2, i / width * 2);
            (at(x, y) + at(x + 1, y) + at(x, y + 1) + at(x + 1, y + 1)) * 0.25
        };
        Self { width, height, texels: (0..width * height).map(average).collect() }
    }

    #[inline]
    fn bilinear(&self, uv: Vec2) -> Vec3 {
        let size = Vec2::new(self.width as f32, self.height as f32);
        let at = (uv - uv.floor()) * size - 0.5;
        let cell = at.floor();
        let part = at - cell;
        let column = |x: f32| (x as i64).rem_euclid(self.width as i64) as usize;
        let row = |y: f32| (y as i64).rem_euclid(self.height as i64) as usize * self.width;
        let (x0, x1) = (column(cell.x), column(cell.x + 1.0));
        let (y0, y1) = (row(cell.y), row(cell.y + 1.0));
        let top = self.texels[y0 + x0].lerp(self.texels[y0 + x1], part.x);
        let bottom = self.texels[y1 + x0].lerp(self.texels[y1 + x1], part.x);
        top.lerp(bottom, part.y)
    }
}
