//! Articulated bodies (physics.md B3, C5): rigid bones, joined where they share particles, with limits on the angles between them.
//!
//! A chain, a door, a lamp, an animal. Two bones that share one particle turn freely about it; two that share two particles turn about the line through them. A
//! [`Cone`](crate::constraints::Cone) or a [`Hinge`](crate::constraints::Hinge) limits the angles of a joint, so that an elbow bends one way only.

mod joints;

use glam::{DVec3, Vec3};

use self::joints::{BoneAxes, Skeleton};
use super::blueprint::{Blueprint, Part};
use super::fault::{RecipeFault, check_particles, ensure};
use super::limits::{LENGTHS, MASSES};
use crate::collide::Shape;
use crate::constraints::{Constraint, ConstraintKind, Rigid};
use crate::particles::ParticleSeed;
use crate::settings::BodySettings;

/// An articulated body to build. The default has no bones, and is refused.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ArticulatedSpec {
    /// The bones; a parent precedes its children.
    pub bones: Vec<Bone>,
    /// Share of the velocity of every particle lost per second, 0 to 1. Default 0.
    pub drag: f32,
}

/// A bone in its pose at build time, which is the rest pose of all its joints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bone {
    /// Name of its part. Default `"bone"`.
    pub name: &'static str,
    /// Index of the bone to which it is joined, lower than its own. Default none.
    pub parent: Option<usize>,
    /// Its near end, metres, where the joint is. Default the origin.
    pub head: Vec3,
    /// Its far end, metres. Default 1 m below the origin.
    pub tail: Vec3,
    /// Thickness, metres, 1e-6 to 1e6. Default 0.1. The radius of its particles is half of it.
    pub width: f32,
    /// Mass, kg, 1e-9 to 1e12. Default 1. Distributed like that of a thin rod: a sixth at each end, the rest in the middle.
    pub mass: f32,
    /// How it is joined to its parent; ignored if it has none. Default a ball joint without limits.
    pub joint: Joint,
    /// Whether its particles have infinite mass, which holds it in place. Default false. A joint on it is then a fixed point.
    pub pinned: bool,
}

/// How a bone is joined to its parent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Joint {
    /// A ball joint at its head.
    Ball {
        /// Largest angle between the bone and its direction at build time, in the frame of its parent, radians, 0 to π (no limit). Best below 80° if the twist
        /// is limited too: the twist is measured from an arm 90° to the side, and is undefined where the bone points along that arm.
        cone: f32,
        /// Largest twist about its own axis in either direction, radians, 0 to π (no limit).
        twist: f32,
    },
    /// A hinge about an axis through its head.
    Hinge {
        /// Direction of the axis, of any length but zero. Positive angles follow the right-hand rule about it.
        axis: Vec3,
        /// Smallest angle from the pose at build time, radians, -π to 0.
        min: f32,
        /// Largest angle, radians, 0 to π. From -π to π is no limit.
        max: f32,
    },
    /// No joint: parent and child are one rigid piece, with a part each.
    Fixed,
    /// Not connected to its parent.
    Free,
}

impl Default for Bone {
    fn default() -> Self {
        Self {
            name: "bone",
            parent: None,
            head: Vec3::ZERO,
            tail: Vec3::NEG_Y,
            width: 0.1,
            mass: 1.0,
            joint: Joint::default(),
            pinned: false,
        }
    }
}

/// A ball joint without limits.
impl Default for Joint {
    fn default() -> Self {
        Self::Ball { cone: core::f32::consts::PI, twist: core::f32::consts::PI }
    }
}

/// Maximum number of sweeps in a substep: an impact travels through a chain of bones by one joint a sweep. With 12, the limits of five bones that are thrown
/// about are exceeded by a few degrees at most.
pub(super) const SWEEPS: u32 = 12;

/// A body of rigid bones.
///
/// Each bone is a [`Rigid`] set of particles: its head, which belongs to its parent as well; its tail; two in the middle, half its width to either side; and
/// one for each joint that it carries, a width to the side of the joint. The last is the pin of a hinge, or the arm from which twist is measured. A child whose
/// head is at its parent's tail shares that particle. The limits are a [`Cone`](crate::constraints::Cone) and [`Hinge`](crate::constraints::Hinge)s.
///
/// There is one part for each bone, in the same order: centred on the bone, with y from the tail to the head. Its settings allow 12 sweeps.
///
/// # Errors
/// A [`RecipeFault`] if the spec has no bones, or a value is out of range.
pub fn articulated(spec: &ArticulatedSpec) -> Result<Blueprint, RecipeFault> {
    ensure(!spec.bones.is_empty(), RecipeFault::NoBones)?;
    check_particles(0.0, spec.drag)?;
    for (number, bone) in spec.bones.iter().enumerate() {
        check(number, bone)?;
    }
    let skeleton = Skeleton::of(&spec.bones);
    let place = |i: u32| skeleton.points[i as usize].position;
    let mut body = Blueprint {
        particles: skeleton.points.iter().map(|p| p.seed(spec.drag)).collect(),
        settings: BodySettings { max_sweeps: Some(SWEEPS), ..BodySettings::default() },
        ..Blueprint::default()
    };
    for (i, _) in (0..).zip(&skeleton.points).filter(|(_, point)| point.pinned) {
        // The index is in range, so this does not fail.
        let _ = body.pin(i);
    }
    for members in &skeleton.pieces {
        let is_pinned = |&i: &u32| body.particles[i as usize].mass == f32::INFINITY;
        if !members.is_empty() && !members.iter().all(is_pinned) {
            let rest: Vec<Vec3> = members.iter().map(|&i| place(i)).collect();
            body.constraints.push(Constraint::new(
                members.iter().copied(),
                ConstraintKind::Rigid(Rigid::of(rest)),
            ));
        }
    }
    body.constraints.extend(skeleton.limits(&spec.bones));
    for (bone, members) in spec.bones.iter().zip(&skeleton.members) {
        let frame = BoneAxes::of(bone);
        let local = |&i: &u32| frame.local(place(i));
        body.parts.push(Part {
            name: bone.name,
            particles: members.clone(),
            rest: members.iter().map(local).collect(),
            size: Vec3::new(bone.width, bone.head.distance(bone.tail) + bone.width, bone.width),
            shape: Shape::capsule(0.5 * bone.width, bone.head.distance(bone.tail)).ok(),
        });
    }
    Ok(body)
}

fn check(number: usize, bone: &Bone) -> Result<(), RecipeFault> {
    let length = bone.head.distance(bone.tail);
    let reach = bone.head.abs().max(bone.tail.abs()).max_element();
    let parent = bone.parent.is_none_or(|parent| parent < number);
    ensure(parent, RecipeFault::BoneParent(number))?;
    ensure(LENGTHS.contains(&bone.width), RecipeFault::BoneWidth(number))?;
    // Rounding of a thousandth of the width would be a visible angle.
    let resolved = reach * f32::EPSILON <= 1e-3 * bone.width.min(length);
    ensure(LENGTHS.contains(&length) && resolved, RecipeFault::BoneLength(number))?;
    ensure(MASSES.contains(&bone.mass), RecipeFault::BoneMass(number))?;
    let angles = |all: [f32; 2]| {
        let within = all.iter().all(|angle| (0.0..=core::f32::consts::PI).contains(angle));
        ensure(within, RecipeFault::JointLimits(number))
    };
    match bone.joint {
        Joint::Ball { cone, twist } => angles([cone, twist]),
        Joint::Hinge { min, max, axis } => {
            angles([-min, max])?;
            let axis = axis.as_dvec3().try_normalize();
            ensure(axis.is_some(), RecipeFault::JointAxis(number))
        }
        Joint::Fixed | Joint::Free => Ok(()),
    }
}

/// A particle of a bone while the skeleton is being built.
struct BonePoint {
    position: Vec3,
    mass: f64,
    radius: f32,
    pinned: bool,
}

impl BonePoint {
    fn seed(&self, drag: f32) -> ParticleSeed {
        let seed = ParticleSeed::at(self.position).with_mass(self.mass as f32);
        seed.with_radius(self.radius).with_drag(drag)
    }
}

/// A unit vector perpendicular to `along`: its cross product with the coordinate axis along which it is smallest.
fn across(along: DVec3) -> DVec3 {
    along.cross(DVec3::AXES[along.abs().min_position()]).normalize_or_zero()
}

#[cfg(test)]
mod tests;
