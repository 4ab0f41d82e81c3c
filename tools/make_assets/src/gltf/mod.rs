//! The models: each is built in code as one mesh and written as binary glTF.

mod banner;
mod delaunay;
mod lantern;
mod mesh;
mod writer;

pub(crate) use banner::banner;
pub(crate) use lantern::lantern;
