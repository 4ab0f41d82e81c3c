//! Articulated bodies (physics.md B3, C5): bones that are rigid, joined where they share particles, and limits of the angles between them.
//!
//! A chain, a door, a lamp, an animal. Two bones that share one particle turn about it in any way; two that share two turn about the line
//! through them. What a joint allows beyond that is a [`Cone`] or a [`Hinge`] of angles, so an elbow knows forward from backward.

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

/// A body of bones to build. The default has none, and is refused.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ArticulatedSpec {
    /// The bones; each after its parent.
    pub bones: Vec<Bone>,
    /// Share of the velocity of every particle lost per second, 0 to 1; default 0.
    pub drag: f32,
}

/// One bone, where it is when the body is built. All its joints are at rest there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bone {
    /// What its part is called; default `"bone"`.
    pub name: &'static str,
    /// The number of the bone that it is joined to, a lower one than its own; default none.
    pub parent: Option<usize>,
    /// Its near end, metres: where the joint is. Default the origin.
    pub head: Vec3,
    /// Its far end, metres. Default 1 m below.
    pub tail: Vec3,
    /// How thick it is, metres, 1e-6 to 1e6; default 0.1. Its particles have half of that for their radius.
    pub width: f32,
    /// Kilograms, 1e-9 to 1e12; default 1. Spread like that of a thin rod: a sixth at each end, the rest in the middle.
    pub mass: f32,
    /// How it is joined to its parent; of no meaning without one. Default free to turn in any way.
    pub joint: Joint,
    /// Whether it is held where it is, by infinite mass; default not. A joint of its is then a fixed point.
    pub pinned: bool,
}

/// How a bone is joined to its parent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Joint {
    /// At its head, about which it turns.
    Ball {
        /// Largest angle between the bone and where it was built, seen from its parent, radians, 0 to π (any). Best below 80° if there is a
        /// limit of twist, which has no meaning where the bone points along the arm that it is measured from, 90° to the side.
        cone: f32,
        /// Largest twist about itself to either side, radians, 0 to π (any).
        twist: f32,
    },
    /// About an axis through its head.
    Hinge {
        /// Direction of the axis, of any length but zero. A positive angle turns the bone by the right hand about it.
        axis: Vec3,
        /// Smallest angle from where it was built, radians, -π to 0.
        min: f32,
        /// Largest angle, radians, 0 to π. From -π to π is all the way round.
        max: f32,
    },
    /// Not at all: parent and child are one rigid piece, with a part each.
    Fixed,
    /// Loose: it has nothing to do with its parent.
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

/// A ball without limits.
impl Default for Joint {
    fn default() -> Self {
        Self::Ball { cone: core::f32::consts::PI, twist: core::f32::consts::PI }
    }
}

/// Sweeps in a substep that it asks for: a blow is carried through a chain of bones one joint a sweep. With 12, the limits of five bones that
/// are thrown about yield by some degrees at most.
pub(super) const SWEEPS: u32 = 12;

/// A body of rigid bones.
///
/// Each bone is a [`Rigid`] set of particles: its head, which its parent has as well, its tail, two in the middle at half its width to either
/// side, and one beside each joint that it carries, a width to the side: the pin of the hinge, or the arm that twist is measured from. A child
/// whose head is at its parent's tail shares that particle. Its limits are a [`Cone`](crate::constraints::Cone) and
/// [`Hinge`](crate::constraints::Hinge)s.
///
/// There is a part for each bone, in the order of the bones: centred on it, with y from the tail to the head. It asks for 12 sweeps.
///
/// # Errors
/// What [`RecipeFault`] lists.
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
        // All of them are there.
        let _ = body.pin(i);
    }
    for members in &skeleton.pieces {
        let held = |&i: &u32| body.particles[i as usize].mass == f32::INFINITY;
        if !members.is_empty() && !members.iter().all(held) {
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
    // A thousandth of a width is an angle that shows.
    let tells = reach * f32::EPSILON <= 1e-3 * bone.width.min(length);
    ensure(LENGTHS.contains(&length) && tells, RecipeFault::BoneLength(number))?;
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

/// A particle before it is one.
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

/// A direction across another one: the coordinate axis that it is least along, made upright on it.
fn across(along: DVec3) -> DVec3 {
    let [x, y, z] = along.abs().to_array();
    let axis = if x <= y && x <= z {
        DVec3::X
    } else if y <= z {
        DVec3::Y
    } else {
        DVec3::Z
    };
    along.cross(axis).normalize_or_zero()
}

#[cfg(test)]
mod tests;
