//! A software renderer for `gallery --headless`: on a build server, in a container or in a remote shell there is no display and no GPU.
//!
//! [`render`] turns a [`Scene`] into an [`Image`]; [`write_png`], [`write_gif`] and [`contact_sheet`] make files of images. The stages of rendering, one module
//! each:
//!
//! 1. `geometry` turns items and lines into triangles, and skips what cannot be drawn.
//! 2. `raster` clips them and finds the nearest triangle of each sample with the `euc` crate, as seen from the eye and from the sun.
//! 3. `shadow` and `occlusion` compute how much light of the sun and of the sky reaches a point.
//! 4. `shade` colours each sample, in front of the `backdrop` of ground and sky, and averages samples to pixels.
//!
//! It does not depend on Bevy: the caller provides triangles in world space. It is a crate of its own so that it is always optimised, whatever the profile of
//! the gallery, and compiled once.

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
