//! Reasons to refuse a shape, and the ranges of valid lengths.

use std::ops::RangeInclusive;

use glam::Vec3;

use crate::convex_hull::ConvexHullFault;

/// Why a shape is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ShapeFault {
    /// A radius is NaN or outside of the valid range.
    #[error("its radius is not between 1e-6 and 1e6 metres")]
    Radius,
    /// The length of a capsule or the height of a cylinder is NaN or outside of the valid range.
    #[error("its length or height is not between 1e-6 and 1e6 metres")]
    Height,
    /// A size is NaN or outside of the valid range on some axis.
    #[error("its size is not between 1e-6 and 1e6 metres on every axis")]
    Size,
    /// A factor is NaN, infinite, zero or negative.
    #[error("its scale is not a positive number on every axis")]
    Scale,
    /// The points have no convex hull.
    #[error("it has no hull: {0}")]
    Hull(#[from] ConvexHullFault),
    /// A coordinate of the point with this index is NaN or out of range.
    #[error("point {0} is not within 1e6 metres of the origin")]
    Point(usize),
    /// The triangle with this index refers to a missing vertex.
    #[error("triangle {0} has a corner that is no vertex")]
    Corner(usize),
    /// There is no triangle, or none has an area.
    #[error("none of its triangles has an area")]
    NoArea,
    /// There are more than 1e9 triangles or vertices, which cannot be indexed.
    #[error("it has more than 1e9 triangles or vertices")]
    TooMany,
    /// A heightfield has no cell.
    #[error("it has fewer than two columns or rows of heights")]
    Grid,
    /// The number of heights does not match the grid.
    #[error("the number of its heights is not that of its columns times its rows")]
    Heights,
    /// The height with this index is NaN or out of range.
    #[error("height {0} is not within 1e6 metres of 0")]
    Altitude(usize),
}

/// Valid lengths of shapes, metres; the same as those of recipes. Squares and volumes then stay well within `f32`.
const LENGTHS: RangeInclusive<f32> = 1e-6..=1e6;

/// Whether `x` is a valid length, metres.
pub(super) fn is_length(x: f32) -> bool {
    LENGTHS.contains(&x)
}

/// Whether all three are valid lengths.
pub(super) fn is_size(size: Vec3) -> bool {
    size.to_array().into_iter().all(is_length)
}

/// Whether `x` is a valid coordinate, metres.
pub(super) fn is_coordinate(x: f32) -> bool {
    x.abs() <= *LENGTHS.end()
}

/// Index of the first point that is not finite or too far out.
pub(super) fn first_out_of_range(points: &[Vec3]) -> Option<usize> {
    points.iter().position(|p| !p.to_array().into_iter().all(is_coordinate))
}
