//! Reasons why a recipe is refused, both common and specific ones.

use super::limits::{LENGTHS, MASSES};
use super::mass::MassFault;
use super::mesh::MeshFault;
use crate::convex_hull::ConvexHullFault;

/// Why a recipe is refused. Unless stated otherwise: a number is NaN or out of its range.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RecipeFault {
    /// A width, a height, an edge or the longest side is out of range; or a solid is so thin (about 1 in 100 000), or so far from the origin of its
    /// coordinates, that `f32` cannot represent the positions of its particles.
    #[error("its size is not between 1e-6 and 1e6 metres, or it is too thin or too far from zero")]
    Size,
    /// The mass; if a density is given, the resulting mass.
    #[error("its mass is not between 1e-9 and 1e12 kilograms")]
    Mass,
    /// The mass per area of cloth.
    #[error("its mass per area is not between 1e-6 and 1e6 kilograms per square metre")]
    Density,
    /// The radius of the particles.
    #[error("its radius is not between 0 and 1e6 metres")]
    Radius,
    /// The drag, a share.
    #[error("its drag is not a share between 0 and 1 per second")]
    Drag,
    /// The damping of a ragdoll.
    #[error("its damping is not between 0 and 1000 per second")]
    Damping,
    /// The damping ratio of a soft body.
    #[error("its damping ratio is not between 0 and 10")]
    DampingRatio,
    /// The compliance of a rope, or of cloth against stretching.
    #[error("its compliance is not a finite number of metres per newton")]
    Compliance,
    /// The bending compliance of cloth.
    #[error("its bend compliance is not a finite number of metres per newton")]
    BendCompliance,
    /// The stiffness of the skin of a soft body, N/m, or of a lattice, Pa.
    #[error("its stiffness is out of range")]
    Stiffness,
    /// The bending stiffness of the skin of a soft body.
    #[error("its bending stiffness is not a finite number of newton metres")]
    BendStiffness,
    /// Poisson's ratio of a lattice.
    #[error("its Poisson's ratio is not between 0.25 and 0.49")]
    Poisson,
    /// The pressure of a soft body.
    #[error("its pressure is not between 0.01 and 100 times its volume")]
    Pressure,
    /// The softness of the volume of a soft body.
    #[error("the softness of its volume is not a finite number in range")]
    Softness,
    /// There are no cells along an axis.
    #[error("it has no cells")]
    NoCells,
    /// More than 2²⁴ particles.
    #[error("it would have more than 16777216 particles")]
    TooMany,
    /// Triangles or cells are so small or so large that a mass, a length or a compliance is not a normal `f32`.
    #[error(
        "a mass, a length or a compliance is too small or too large to simulate: check its units"
    )]
    Scale,
    /// The mesh from which the body is made is invalid.
    #[error(transparent)]
    Mesh(#[from] MeshFault),
    /// The mesh has no interior: it is open, flat or inside out.
    #[error(transparent)]
    Inside(#[from] MassFault),
    /// The points of a solid have no convex hull.
    #[error(transparent)]
    Hull(#[from] ConvexHullFault),
    /// The shape of a solid is a half space, a mesh or a height field, which has no interior or cannot move.
    #[error("its shape is a half space, a mesh or a height field, which cannot be a solid")]
    Shape,
    /// The ends of a rope.
    #[error("its ends are not within 1e6 metres of its origin")]
    Ends,
    /// The ends of a rope coincide, or nearly.
    #[error("its ends are not between 1e-6 and 1e6 metres apart")]
    Apart,
    /// A rope has no segments, or too many.
    #[error("the number of its segments is not between 1 and 16777215")]
    Segments,
    /// The slack of a rope.
    #[error("its slack is not a share between 0 and 100 of the gap between its ends")]
    Slack,
    /// A rope of a single segment has slack, but cannot sag.
    #[error("it has slack but only one segment, which cannot sag")]
    SlackOfOne,
    /// An articulated body has no bones.
    #[error("it has no bones")]
    NoBones,
    /// A bone's parent is not an earlier bone.
    #[error("the parent of bone {0} is not an earlier bone")]
    BoneParent(usize),
    /// An end of a bone is not finite, or the ends are less than 1e-6 or more than 1e6 metres apart, or so far from the origin that `f32` cannot resolve the
    /// bone's width.
    #[error("bone {0} is not between 1e-6 and 1e6 metres long and near the origin")]
    BoneLength(usize),
    /// The width of a bone.
    #[error("the width of bone {0} is not between 1e-6 and 1e6 metres")]
    BoneWidth(usize),
    /// The mass of a bone.
    #[error("the mass of bone {0} is not between 1e-9 and 1e12 kilograms")]
    BoneMass(usize),
    /// An angle limit of a joint.
    #[error("a limit of the joint of bone {0} is out of range")]
    JointLimits(usize),
    /// The axis of a hinge is zero or not finite.
    #[error("the axis of the joint of bone {0} has no direction")]
    JointAxis(usize),
}

/// Returns the fault `otherwise` unless `holds`.
pub(super) fn ensure(holds: bool, otherwise: RecipeFault) -> Result<(), RecipeFault> {
    holds.then_some(()).ok_or(otherwise)
}

/// Checks the total mass of a body, kg.
pub(super) fn check_mass(mass: f32) -> Result<(), RecipeFault> {
    ensure(MASSES.contains(&mass), RecipeFault::Mass)
}

/// Checks the radius of particles in metres, 0 for none, and a drag, as a share per second.
pub(super) fn check_particles(radius: f32, drag: f32) -> Result<(), RecipeFault> {
    ensure((0.0..=*LENGTHS.end()).contains(&radius), RecipeFault::Radius)?;
    ensure((0.0..=1.0).contains(&drag), RecipeFault::Drag)
}
