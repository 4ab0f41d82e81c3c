//! Pseudo-random numbers and noise that are the same on every machine.

use glam::{Vec2, vec2};

/// A small pseudo-random generator (PCG's output function over a linear congruential generator).
pub(crate) struct Dice(u32);

impl Dice {
    pub(crate) fn new(seed: u32) -> Self {
        Self(scramble(seed))
    }

    /// The next number in `0.0..1.0`.
    pub(crate) fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        to_unit(scramble(self.0))
    }

    /// The next whole number in `0..end`.
    pub(crate) fn below(&mut self, end: usize) -> usize {
        ((self.unit() * end as f32) as usize).min(end - 1)
    }

    /// Shuffles `items`, each order with the same probability.
    pub(crate) fn shuffle<T>(&mut self, items: &mut [T]) {
        for last in (1..items.len()).rev() {
            items.swap(last, self.below(last + 1));
        }
    }
}

/// A pseudo-random number in `0.0..1.0` for a cell of a lattice.
pub(super) fn cell(x: i32, y: i32, seed: u32) -> f32 {
    to_unit(scramble(scramble(scramble(seed) ^ x as u32) ^ y as u32))
}

/// Smooth noise in `0.0..1.0`, one bump per unit.
pub(super) fn noise(at: Vec2, seed: u32) -> f32 {
    let corner = at.floor();
    let t = at - corner;
    let t = t * t * (Vec2::splat(3.0) - 2.0 * t);
    let (x, y) = (corner.x as i32, corner.y as i32);
    let low = cell(x, y, seed) * (1.0 - t.x) + cell(x + 1, y, seed) * t.x;
    let high = cell(x, y + 1, seed) * (1.0 - t.x) + cell(x + 1, y + 1, seed) * t.x;
    low * (1.0 - t.y) + high * t.y
}

/// Four octaves of [`noise`], still in `0.0..1.0`.
pub(super) fn fractal(at: Vec2, seed: u32) -> f32 {
    let octave = |level: u32| {
        let scale = (1 << level) as f32;
        noise(at * scale + vec2(17.3, 5.9) * level as f32, seed + level) / scale
    };
    (octave(0) + octave(1) + octave(2) + octave(3)) / 1.875
}

fn scramble(bits: u32) -> u32 {
    let state = bits.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

fn to_unit(bits: u32) -> f32 {
    (bits >> 8) as f32 / (1 << 24) as f32
}
