//! A human figure that falls as one: particles at the joints, rods for bones, and inequalities that keep it from folding up.
//!
//! The trunk is two rigid frames with depth, thorax and pelvis, which meet in the waist; arms, legs and head are chains of
//! rods. It stands upright with its arms hanging, elbows and knees a little bent the way they bend.
//!
//! What it does not have yet: limits of the angles themselves. A distance cannot tell forward from backward, so an elbow may
//! still bend the wrong way, the upper arm has no twist, and a rod's picture may turn about its axis. The limits here
//! are distances between particles on both sides of a joint: coarse, but as cheap and as stable as a bone.

mod anatomy;

use std::f64::consts::PI;

use glam::{DVec3, Vec3};

use self::anatomy::{APART, BONES, FIGURE, LIMITS, Limit, PARTS, Shape};
use super::blueprint::{Blueprint, Part, gap};
use super::{LENGTHS, MASSES};
use crate::constraints::{Bound, Distance};
use crate::particles::ParticleSeed;

/// A ragdoll to build. The default is an adult of 1.75 m and 75 kg.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RagdollSpec {
    /// From the soles to the top of the head, metres, 1e-6 to 1e6; default 1.75. All lengths and radii go with it.
    pub height: f32,
    /// Mass of the whole figure, kg, 1e-9 to 1e12; default 75.
    pub mass: f32,
}

/// Why a ragdoll is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RagdollFault {
    /// NaN, or outside the range.
    #[error("its height is not between 1e-6 and 1e6 metres")]
    Height,
    /// NaN, or outside the range.
    #[error("its mass is not between 1e-9 and 1e12 kilograms")]
    Mass,
}

/// The particles of a ragdoll, in the order of [`Blueprint::particles`]. Its own left is towards +x.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u32)]
#[allow(missing_docs, reason = "the names say it")]
pub enum RagdollParticle {
    Head,
    Neck,
    Sternum,
    Waist,
    Pelvis,
    LeftShoulder,
    LeftElbow,
    LeftHand,
    LeftHip,
    LeftKnee,
    LeftAnkle,
    RightShoulder,
    RightElbow,
    RightHand,
    RightHip,
    RightKnee,
    RightAnkle,
}

impl Default for RagdollSpec {
    fn default() -> Self {
        Self { height: 1.75, mass: 75.0 }
    }
}

impl RagdollParticle {
    /// Its number in the blueprint.
    pub const fn index(self) -> u32 {
        self as u32
    }

    /// The same joint on the other side; those in the middle are their own.
    pub fn mirrored(self) -> Self {
        match self.index() {
            i @ 5..=10 => FIGURE[i as usize + 6].particle,
            i @ 11..=16 => FIGURE[i as usize - 6].particle,
            _ => self,
        }
    }
}

/// A human figure of 17 particles ([`RagdollParticle`]) in 11 parts, standing with its soles at y = 0 below the origin of its
/// coordinates, and facing +z.
///
/// Each particle's radius is the thickness of the body there, so that it comes to rest on the ground as thick as it is drawn.
/// Parts are called `"head"`, `"torso"`, `"pelvis"`, `"left upper arm"`, `"left forearm"`, `"left thigh"`, `"left shin"` and
/// the same on the right. A limb's part is centred on its bone, with y from the far joint to the near one; the others are
/// upright when the figure stands.
pub fn ragdoll(spec: &RagdollSpec) -> Result<Blueprint, RagdollFault> {
    if !LENGTHS.contains(&spec.height) {
        return Err(RagdollFault::Height);
    }
    if !MASSES.contains(&spec.mass) {
        return Err(RagdollFault::Mass);
    }
    let height = f64::from(spec.height);
    let seed = |joint: &anatomy::Joint| {
        ParticleSeed::at((joint.position * height).as_vec3())
            .with_mass((joint.mass * f64::from(spec.mass)) as f32)
            .with_radius((joint.radius * height) as f32)
    };
    let mut body =
        Blueprint { particles: FIGURE.iter().map(seed).collect(), ..Blueprint::default() };
    for [a, b] in both_sides(BONES) {
        body.rod(a.index(), b.index());
    }
    for [a, b] in both_sides(APART) {
        let [a, b] = [a, b].map(RagdollParticle::index);
        let touching = body.particles[a as usize].radius + body.particles[b as usize].radius;
        body.distances.push(Distance::new(a, b, touching).with_bound(Bound::AtLeast));
    }
    for limit in LIMITS {
        let [a, b] = [limit.moved, limit.from];
        let rest = (limit_distance(limit) * height) as f32;
        for [a, b] in both_sides(&[[a, b]]) {
            let tie = Distance::new(a.index(), b.index(), rest).with_bound(limit.bound);
            body.distances.push(tie);
        }
    }
    body.parts = PARTS.iter().map(|part| shaped(part, &body, spec.height)).collect();
    Ok(body)
}

/// Pairs of the table, each followed by its mirror image unless that is the pair itself.
fn both_sides(
    pairs: &[[RagdollParticle; 2]],
) -> impl Iterator<Item = [RagdollParticle; 2]> + use<'_> {
    pairs.iter().flat_map(|&pair @ [a, b]| {
        let mirror = pair.map(RagdollParticle::mirrored);
        let itself = mirror == pair || mirror == [b, a];
        std::iter::once(pair).chain((!itself).then_some(mirror))
    })
}

/// How far the two ends of a limit are from each other, as a share of the height, when the moved one is turned about the
/// joint as far as it goes (Rodrigues' rotation formula).
fn limit_distance(limit: &Limit) -> f64 {
    let at = |particle: RagdollParticle| FIGURE[particle.index() as usize].position;
    let (arm, axis, angle) =
        (at(limit.moved) - at(limit.joint), limit.axis, limit.degrees / 180.0 * PI);
    let (sin, cos) = (libm::sin(angle), libm::cos(angle));
    let turned = arm * cos + axis.cross(arm) * sin + axis * (axis.dot(arm) * (1.0 - cos));
    (at(limit.joint) + turned - at(limit.from)).length()
}

/// A part of the table for a figure of this height.
fn shaped(part: &anatomy::Segment, body: &Blueprint, height: f32) -> Part {
    let at = |particle: &RagdollParticle| body.particles[particle.index() as usize];
    let positions: Vec<Vec3> = part.particles.iter().map(|p| at(p).position).collect();
    let (rest, size) = match part.shape {
        Shape::Box { centre, size } => {
            let centre = (centre * f64::from(height)).as_vec3();
            (positions.iter().map(|&p| p - centre).collect(), size * f64::from(height))
        }
        Shape::Limb { thickness } => {
            let half = DVec3::Y * f64::from(gap(positions[0], positions[1])) * 0.5;
            let thickness = thickness * f64::from(height);
            let size = DVec3::new(thickness, 2.0 * half.y + thickness, thickness);
            (vec![half.as_vec3(), (-half).as_vec3()], size)
        }
    };
    Part {
        name: part.name,
        particles: part.particles.iter().map(|p| p.index()).collect(),
        rest,
        size: size.as_vec3(),
    }
}

#[cfg(test)]
mod tests;
