//! Why a shape is refused, and which lengths are not.

use std::ops::RangeInclusive;

use glam::Vec3;

use crate::convex_hull::ConvexHullFault;

/// Why a shape is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ShapeFault {
    /// NaN, not positive, or outside the range.
    #[error("its radius is not between 1e-6 and 1e6 metres")]
    Radius,
    /// NaN, not positive, or outside the range.
    #[error("its half height is not between 1e-6 and 1e6 metres")]
    Height,
    /// NaN, not positive, or outside the range.
    #[error("its size is not between 1e-6 and 1e6 metres on every axis")]
    Size,
    /// NaN, not positive, or so that what comes out is outside the range.
    #[error("its scale is not a positive number on every axis")]
    Scale,
    /// The points have no hull.
    #[error("it has no hull: {0}")]
    Hull(#[from] ConvexHullFault),
    /// A coordinate is NaN, or out of range.
    #[error("point {0} is not within 1e6 metres of the origin")]
    Point(usize),
    /// A triangle names a vertex that is not there.
    #[error("triangle {0} has a corner that is no vertex")]
    Corner(usize),
    /// No triangle, or all of them collapsed.
    #[error("none of its triangles has an area")]
    NoArea,
    /// More triangles than can be numbered.
    #[error("it has more than 1e9 triangles")]
    TooMany,
    /// A landscape without a cell.
    #[error("it has fewer than two columns or rows of heights")]
    Grid,
    /// Their number is not that of the grid.
    #[error("the number of its heights is not that of its columns times its rows")]
    Heights,
    /// NaN, or out of range.
    #[error("height {0} is not within 1e6 metres of 0")]
    Altitude(usize),
}

/// Lengths that a shape accepts, metres; as those of recipes are. Squares and volumes then stay inside `f32` with room to spare.
const LENGTHS: RangeInclusive<f32> = 1e-6..=1e6;

/// Whether `x` may be a size: a length in metres.
pub(super) fn is_length(x: f32) -> bool {
    LENGTHS.contains(&x)
}

/// Whether all three may be sizes.
pub(super) fn is_size(size: Vec3) -> bool {
    size.to_array().into_iter().all(is_length)
}

/// Whether `x` may be a coordinate, metres.
pub(super) fn is_coordinate(x: f32) -> bool {
    x.abs() <= *LENGTHS.end()
}

/// The number of the first point that is not finite or too far out.
pub(super) fn stray(points: &[Vec3]) -> Option<usize> {
    points.iter().position(|p| !p.to_array().into_iter().all(is_coordinate))
}
