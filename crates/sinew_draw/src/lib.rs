//! Pictures without a GPU, for `gallery --headless`: a build server, a container or a remote shell has no display, and
//! still deserves to see what the solver did.
//!
//! A [`Scene`] goes in, an [`Image`] comes out of [`render`]; [`write_png`], [`write_gif`] and [`contact_sheet`] make
//! files of images. How one picture comes about, a file a stage:
//!
//! 1. `geometry` turns items and lines into plain triangles, and skips what cannot be drawn.
//! 2. `raster` clips them and lets the `euc` crate find which triangle each sample sees, for the eye and for the sun.
//! 3. `shadow` and `occlusion` answer how much of the sun and of the sky reaches a point.
//! 4. `shade` colours each sample, in front of the `backdrop` of ground and sky, and averages samples to pixels.
//!
//! Nothing here knows Bevy: whoever calls brings world-space triangles. It is a crate of its own so that it is optimised whatever the gallery is, and built once.

mod animation;
mod backdrop;
mod camera;
#[cfg(test)]
mod file_tests;
mod geometry;
mod image;
mod occlusion;
mod raster;
mod scene;
mod shade;
mod shadow;
mod sheet;
mod small_png;
#[cfg(test)]
mod tests;
mod text;
mod texture;

pub use animation::write_gif;
pub use camera::Camera;
pub use image::{Image, read_png, write_png};
pub use scene::{Item, Line, Scene};
pub use shade::render;
pub use sheet::contact_sheet;
pub use small_png::write_small_png;
pub use texture::Texture;
