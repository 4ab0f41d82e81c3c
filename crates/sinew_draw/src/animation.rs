//! Animations as GIF, the format that every README viewer shows.
//!
//! GIF has 256 colours and no motion compensation. Three things keep the file small and the picture steady: one palette for all frames, dithering by a fixed
//! pattern (pixels that do not change keep their bytes), and frames that hold only what changed.

use std::{
    collections::HashMap,
    fs::File,
    io::{self, BufWriter},
    path::Path,
};

use color_quant::NeuQuant;
use gif::{DisposalMethod, Encoder, EncodingError, Frame, Repeat};

use super::image::Image;

/// Colours in the palette; the one index that is left means "unchanged".
const COLORS: usize = 255;

/// Amplitude of dithering in a channel, steps of 1/255.
const DITHER: f32 = 2.0;

/// Writes images of one size as a GIF that repeats forever, `delay` hundredths of a second apart.
pub fn write_gif(path: impl AsRef<Path>, frames: &[Image], delay: u16) -> io::Result<()> {
    let invalid = |why: &str| io::Error::new(io::ErrorKind::InvalidInput, why);
    let first = frames.first().ok_or_else(|| invalid("an animation needs a frame"))?;
    let side = |n: usize| {
        u16::try_from(n).map_err(|_| invalid("a GIF is at most 65535 pixels wide and high"))
    };
    let (width, height) = (side(first.width)?, side(first.height)?);
    if frames.iter().any(|f| (f.width, f.height) != (first.width, first.height)) {
        return Err(invalid("the frames of an animation are of one size"));
    }

    let mut palette = Palette::new(frames);
    let file = BufWriter::new(File::create(path)?);
    let mut encoder = Encoder::new(file, width, height, &palette.bytes()).map_err(error)?;
    encoder.set_repeat(Repeat::Infinite).map_err(error)?;
    let mut shown = Vec::new();
    for image in frames {
        let indices = palette.indices(image);
        encoder.write_frame(&change(&shown, &indices, first.width, delay)).map_err(error)?;
        shown = indices;
    }
    Ok(())
}

/// Palette of a single image (red, green, blue of each colour), and the palette index of each pixel. Not dithered: the pattern would increase the file for
/// little benefit.
pub(crate) fn indexed(image: &Image) -> (Vec<u8>, Vec<u8>) {
    let mut palette = Palette::new(std::slice::from_ref(image));
    let indices = palette.indices_dithered(image, 0.0);
    (palette.bytes(), indices)
}

fn error(error: EncodingError) -> io::Error {
    match error {
        EncodingError::Io(error) => error,
        other => io::Error::other(other),
    }
}

/// A frame of the smallest rectangle around all pixels that changed since the last frame; unchanged pixels in it are transparent.
fn change(shown: &[u8], indices: &[u8], width: usize, delay: u16) -> Frame<'static> {
    let height = indices.len() / width.max(1);
    let same = |i: usize| shown.get(i) == Some(&indices[i]);
    let (mut left, mut right, mut top, mut bottom) = (width, 0, height, 0);
    for i in (0..indices.len()).filter(|&i| !same(i)) {
        let (x, y) = (i % width, i / width);
        (left, right) = (left.min(x), right.max(x + 1));
        (top, bottom) = (top.min(y), bottom.max(y + 1));
    }
    if right == 0 {
        // Nothing changed, but time passes: a frame of one pixel carries the delay.
        (left, right, top, bottom) = (0, 1, 0, 1);
    }
    let rows = (top..bottom).flat_map(|y| (left..right).map(move |x| y * width + x));
    let buffer: Vec<u8> = rows.map(|i| if same(i) { COLORS as u8 } else { indices[i] }).collect();
    Frame {
        delay,
        dispose: DisposalMethod::Keep,
        transparent: Some(COLORS as u8),
        left: left as u16,
        top: top as u16,
        width: (right - left) as u16,
        height: (bottom - top) as u16,
        buffer: buffer.into(),
        ..Frame::default()
    }
}

/// The palette of an animation.
struct Palette {
    quantizer: NeuQuant,
    /// Cache of palette indices by colour, rounded to 7 bits a channel: finding the nearest colour is slow, and images repeat themselves.
    known: HashMap<u32, u8>,
}

impl Palette {
    fn new(frames: &[Image]) -> Self {
        // Rare colours are weighted above their frequency: a small red ball matters as much as a wide sky.
        let mut seen = HashMap::<[u8; 3], u32>::new();
        let stride = (frames.len() * frames[0].pixels.len() / 2_000_000).max(1);
        for [r, g, b, _] in frames.iter().flat_map(|f| &f.pixels).step_by(stride) {
            *seen.entry([r & !3, g & !3, b & !3]).or_default() += 1;
        }
        let mut seen: Vec<_> = seen.into_iter().collect();
        seen.sort_unstable();
        let mut samples = Vec::new();
        for ([r, g, b], count) in seen {
            for _ in 0..(count as f32).sqrt().ceil() as usize {
                samples.extend([r | 2, g | 2, b | 2, 255]);
            }
        }
        // NeuQuant steps through the samples in prime strides and requires a few thousand at least.
        while samples.len() < 4 * 4096 && !samples.is_empty() {
            samples.extend_from_within(..);
        }
        Self { quantizer: NeuQuant::new(3, COLORS, &samples), known: HashMap::new() }
    }

    fn bytes(&self) -> Vec<u8> {
        let mut bytes = self.quantizer.color_map_rgb();
        bytes.resize(256 * 3, 0);
        bytes
    }

    fn indices(&mut self, image: &Image) -> Vec<u8> {
        self.indices_dithered(image, DITHER)
    }

    fn indices_dithered(&mut self, image: &Image, dither: f32) -> Vec<u8> {
        let mut out = Vec::with_capacity(image.pixels.len());
        for (i, pixel) in image.pixels.iter().enumerate() {
            let (x, y) = (i % image.width, i / image.width);
            let threshold =
                [0, 8, 2, 10, 12, 4, 14, 6, 3, 11, 1, 9, 15, 7, 13, 5][y % 4 * 4 + x % 4] as f32;
            let push = (threshold / 7.5 - 1.0) * dither;
            let [r, g, b] = [0, 1, 2].map(|c| (f32::from(pixel[c]) + push).clamp(0.0, 255.0) as u8);
            let key = u32::from_be_bytes([0, r & !1, g & !1, b & !1]);
            let quantizer = &self.quantizer;
            out.push(
                *self.known.entry(key).or_insert_with(|| quantizer.index_of(&[r, g, b, 255]) as u8),
            );
        }
        out
    }
}
