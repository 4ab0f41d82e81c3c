//! The textures: each is a function from a point to a colour, sampled by the canvas.

mod ball;
mod banner;
mod canvas;
mod cloth;
mod crate_face;
mod flag;
mod lantern;
mod noise;

pub(crate) use ball::ball;
pub(crate) use banner::{banner, banner_uv, shape};
pub(crate) use canvas::Canvas;
pub(crate) use crate_face::crate_face;
pub(crate) use flag::flag;
pub(crate) use lantern::{Swatch, lantern_glow, lantern_palette};
pub(crate) use noise::Dice;
