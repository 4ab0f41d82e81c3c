//! An egui panel that tunes, inspects and steps a Sinew world.
