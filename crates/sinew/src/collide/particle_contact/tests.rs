//! Tests come with the shapes.
