//! Why a recipe is refused: what all of them may say, and what only one does.

use super::limits::{LENGTHS, MASSES};
use super::mass::MassFault;
use super::mesh::MeshFault;
use crate::convex_hull::ConvexHullFault;

/// Why a recipe is refused: a number that is NaN or out of its range, unless something else is said.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RecipeFault {
    /// A width, a height, an edge or the longest side; or a solid is so thin (about 1 in 100 000), or so far from the zero of its coordinates, that `f32`
    /// cannot say where its particles are.
    #[error("its size is not between 1e-6 and 1e6 metres, or it is too thin or too far from zero")]
    Size,
    /// By density, what comes of it.
    #[error("its mass is not between 1e-9 and 1e12 kilograms")]
    Mass,
    /// Of cloth.
    #[error("its mass per area is not between 1e-6 and 1e6 kilograms per square metre")]
    Density,
    /// Of its particles.
    #[error("its radius is not between 0 and 1e6 metres")]
    Radius,
    /// A share.
    #[error("its drag is not a share between 0 and 1 per second")]
    Drag,
    /// Of a ragdoll.
    #[error("its damping is not between 0 and 1000 per second")]
    Damping,
    /// Of a soft body.
    #[error("its damping ratio is not between 0 and 10")]
    DampingRatio,
    /// Of a rope, or of cloth that is stretched.
    #[error("its compliance is not a finite number of metres per newton")]
    Compliance,
    /// Of cloth.
    #[error("its bend compliance is not a finite number of metres per newton")]
    BendCompliance,
    /// Of the skin of a soft body in N/m, of a lattice in Pa.
    #[error("its stiffness is out of range")]
    Stiffness,
    /// Of the skin of a soft body.
    #[error("its bending stiffness is not a finite number of newton metres")]
    BendStiffness,
    /// Of a lattice.
    #[error("its Poisson's ratio is not between 0.25 and 0.49")]
    Poisson,
    /// Of a soft body.
    #[error("its pressure is not between 0.01 and 100 times its volume")]
    Pressure,
    /// Of the volume of a soft body.
    #[error("the softness of its volume is not a finite number in range")]
    Softness,
    /// No cells along an axis.
    #[error("it has no cells")]
    NoCells,
    /// More than 2²⁴ particles.
    #[error("it would have more than 16777216 particles")]
    TooMany,
    /// Triangles or cells so small or so large that a mass, a length or a compliance is no ordinary `f32`.
    #[error(
        "a mass, a length or a compliance is too small or too large to simulate: check its units"
    )]
    Scale,
    /// The mesh that it is to be made from is none.
    #[error(transparent)]
    Mesh(#[from] MeshFault),
    /// The mesh has no inside: it is open, flat or inside out.
    #[error(transparent)]
    Inside(#[from] MassFault),
    /// The points of a solid have no hull.
    #[error(transparent)]
    Hull(#[from] ConvexHullFault),
    /// The shape of a solid is a half space, a mesh or a height field: what has no inside, or cannot move.
    #[error("its shape is a half space, a mesh or a height field, which cannot be a solid")]
    Shape,
    /// Of a rope.
    #[error("its ends are not within 1e6 metres of its origin")]
    Ends,
    /// The ends of a rope coincide, or nearly.
    #[error("its ends are not between 1e-6 and 1e6 metres apart")]
    Apart,
    /// Of a rope: none, or too many.
    #[error("the number of its segments is not between 1 and 16777215")]
    Segments,
    /// Of a rope.
    #[error("its slack is not a share between 0 and 100 of the gap between its ends")]
    Slack,
    /// Slack in a rope of a single segment, which cannot sag.
    #[error("it has slack but only one segment, which cannot sag")]
    SlackOfOne,
    /// An articulated body without any.
    #[error("it has no bones")]
    NoBones,
    /// A parent that is not an earlier bone.
    #[error("the parent of bone {0} is not an earlier bone")]
    BoneParent(usize),
    /// An end is not finite, or the ends are less than 1e-6 or more than 1e6 metres apart; or so far from the origin that `f32` cannot tell
    /// its width.
    #[error("bone {0} is not between 1e-6 and 1e6 metres long and near the origin")]
    BoneLength(usize),
    /// Of a bone.
    #[error("the width of bone {0} is not between 1e-6 and 1e6 metres")]
    BoneWidth(usize),
    /// Of a bone.
    #[error("the mass of bone {0} is not between 1e-9 and 1e12 kilograms")]
    BoneMass(usize),
    /// An angle of a joint.
    #[error("a limit of the joint of bone {0} is out of range")]
    JointLimits(usize),
    /// A hinge's axis that is zero or not finite.
    #[error("the axis of the joint of bone {0} has no direction")]
    JointAxis(usize),
}

/// Refuses what does not hold.
pub(super) fn ensure(holds: bool, otherwise: RecipeFault) -> Result<(), RecipeFault> {
    holds.then_some(()).ok_or(otherwise)
}

/// A mass of all, kilograms.
pub(super) fn check_mass(mass: f32) -> Result<(), RecipeFault> {
    ensure(MASSES.contains(&mass), RecipeFault::Mass)
}

/// A radius of particles in metres, or none at all; and a drag, as a share per second.
pub(super) fn check_particles(radius: f32, drag: f32) -> Result<(), RecipeFault> {
    ensure((0.0..=*LENGTHS.end()).contains(&radius), RecipeFault::Radius)?;
    ensure((0.0..=1.0).contains(&drag), RecipeFault::Drag)
}
