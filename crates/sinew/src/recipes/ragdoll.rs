//! A human figure that falls as a ragdoll: particles at the joints, rods for bones, and inequalities that limit its pose.
//!
//! The trunk is two rigid frames with depth, thorax and pelvis, joined at the waist. Arms and legs are attached by ball joints with cone and twist limits.
//! Elbows and knees are hinges: both bones are connected to the two ends of a pin, and the signed angle about it keeps them from bending backward. The figure
//! stands upright with its arms hanging, elbows and knees slightly bent in their natural direction.

mod anatomy;

use glam::{DVec3, Vec3};

use self::anatomy::{APART, BONES, FIGURE, LIMITS, Limit, PARTS, PartShape};
use super::blueprint::{Blueprint, Part};
use super::fault::{RecipeFault, check_mass, ensure};
use super::limits::LENGTHS;
use crate::collide::Shape;
use crate::constraints::{Bound, Cone, Constraint, ConstraintKind, Distance, Hinge};
use crate::particles::ParticleSeed;
use crate::settings::BodySettings;

/// A ragdoll to build. The default is an adult of 1.75 m and 75 kg.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RagdollSpec {
    /// From the soles to the top of the head, metres, 1e-6 to 1e6. Default 1.75. All lengths and radii scale with it.
    pub height: f32,
    /// Total mass, kg, 1e-9 to 1e12. Default 75.
    pub mass: f32,
    /// Joint friction, 1/s, 0 to 1000. Default 0.5: the rate at which motion of the limbs relative to each other decays ([`BodySettings::damping`]). Without
    /// it, a head that hangs over an edge swings for minutes.
    pub damping: f32,
}

/// The particles of a ragdoll, in the order of [`Blueprint::particles`]. The figure's left is towards +x. A pin is the outer end of the axis of an elbow or a
/// knee; the other end is the joint itself.
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
    Face,
    LeftElbowPin,
    LeftKneePin,
    RightElbowPin,
    RightKneePin,
}

impl Default for RagdollSpec {
    fn default() -> Self {
        Self { height: 1.75, mass: 75.0, damping: 0.5 }
    }
}

impl RagdollParticle {
    /// Its index in the blueprint.
    pub const fn index(self) -> u32 {
        self as u32
    }

    /// The same joint on the other side; a joint in the middle is its own mirror image.
    pub fn mirrored(self) -> Self {
        match self.index() {
            i @ 5..=10 => FIGURE[i as usize + 6].particle,
            i @ 11..=16 => FIGURE[i as usize - 6].particle,
            i @ 18..=19 => FIGURE[i as usize + 2].particle,
            i @ 20..=21 => FIGURE[i as usize - 2].particle,
            _ => self,
        }
    }
}

/// Accepted error of a joint, as a share of the height, per second: half a millimetre for an adult at 600 substeps a second. With it a body at rest is swept
/// once or twice instead of four times, and its bones keep their length as well.
const TOLERANCE: f32 = 0.18;

/// Maximum number of sweeps in a substep. In a fall onto the head, seventy kilograms are above five: with 12 sweeps the neck is shortened by 2.5 % of its
/// length for a moment, with 24 by 1.2 %, with 40 by 0.6 %. Few substeps are that demanding: the average during a fall is two sweeps in each case.
const SWEEPS: u32 = 40;

/// A human figure of 22 particles ([`RagdollParticle`]) in 11 parts, standing with its soles at y = 0 below the origin of its coordinates, and facing +z.
///
/// Each particle's radius is the thickness of the body there, so that the figure rests on the ground as it is drawn. Parts are named `"head"`, `"torso"`,
/// `"pelvis"`, `"left upper arm"`, `"left forearm"`, `"left thigh"`, `"left shin"` and the same on the right. A limb's part is centred on its bone, with y from
/// the far joint to the near one; the others are upright when the figure stands. Its settings allow 40 sweeps, until no error exceeds 0.0003 of its height
/// (at 600 substeps a second; [in proportion](BodySettings#tolerance-as-a-speed)). Its joint limits are exceeded by a few degrees at most when it lands.
pub fn ragdoll(spec: &RagdollSpec) -> Result<Blueprint, RecipeFault> {
    ensure(LENGTHS.contains(&spec.height), RecipeFault::Size)?;
    check_mass(spec.mass)?;
    ensure((0.0..=1000.0).contains(&spec.damping), RecipeFault::Damping)?;
    let height = f64::from(spec.height);
    let seed = |joint: &anatomy::FigureParticle| {
        ParticleSeed::at((joint.position * height).as_vec3())
            .with_mass((joint.mass * f64::from(spec.mass)) as f32)
            .with_radius((joint.radius * height) as f32)
    };
    let mut body = Blueprint {
        particles: FIGURE.iter().map(seed).collect(),
        settings: BodySettings {
            max_sweeps: Some(SWEEPS),
            tolerance_speed: Some(TOLERANCE * spec.height),
            damping: spec.damping,
            ..BodySettings::default()
        },
        ..Blueprint::default()
    };
    for [a, b] in both_sides(BONES) {
        body.rod(a.index(), b.index());
    }
    for [a, b] in both_sides(APART) {
        let [a, b] = [a, b].map(RagdollParticle::index);
        let touching = body.particles[a as usize].radius + body.particles[b as usize].radius;
        body.distances.push(Distance::new(a, b, touching).with_bound(Bound::AtLeast));
    }
    for (limit, mirror) in LIMITS.iter().flat_map(|limit| [(limit, false), (limit, true)]) {
        let limit = limited(limit, mirror, height);
        // Limits in the middle are their own mirror image.
        body.constraints.extend(limit.filter(|limit| !body.constraints.contains(limit)));
    }
    body.parts = PARTS.iter().map(|part| shaped(part, &body, spec.height)).collect();
    Ok(body)
}

/// The pairs of the table, each followed by its mirror image unless that is the same pair.
fn both_sides(
    pairs: &[[RagdollParticle; 2]],
) -> impl Iterator<Item = [RagdollParticle; 2]> + use<'_> {
    pairs.iter().flat_map(|&pair @ [a, b]| {
        let mirror = pair.map(RagdollParticle::mirrored);
        let itself = mirror == pair || mirror == [b, a];
        std::iter::once(pair).chain((!itself).then_some(mirror))
    })
}

/// A limit of the table, or its mirror image, for a figure of this height. Angles do not depend on it, but the coefficients of the axis of a cone do: they
/// combine lengths with a cross product of lengths.
fn limited(limit: &Limit, mirror: bool, height: f64) -> Option<Constraint> {
    let side = |p: RagdollParticle| if mirror { p.mirrored() } else { p };
    let at = |p: RagdollParticle| (FIGURE[p.index() as usize].position * height).as_vec3();
    let turn = |rows: [RagdollParticle; 4], below: f64, above: f64, from: Option<f64>| {
        let rows = rows.map(side);
        let now = || f64::from(Hinge::rest(rows.map(at)).min);
        // The mirror image turns the other way.
        let (below, above) = if mirror { (above, below) } else { (below, above) };
        let middle = from.unwrap_or_else(now);
        let kind = Hinge::between(
            (middle - below.to_radians()) as f32,
            (middle + above.to_radians()) as f32,
        );
        Constraint::new(rows.map(RagdollParticle::index), ConstraintKind::Hinge(kind))
    };
    Some(match *limit {
        Limit::Cone { frame, joint, moved, around, degrees } => {
            // For a frame in the middle the mirror image keeps the order of the particles; otherwise its cross product would be reversed.
            let [o, x, y] = if frame[0] == side(frame[0]) { frame } else { frame.map(side) };
            let (joint, moved) = (side(joint), side(moved));
            let around = if mirror { DVec3::new(-around.x, around.y, around.z) } else { around };
            let cone =
                Cone::about(at(o), at(x), at(y), around.as_vec3(), degrees.to_radians() as f32)?;
            let begin = (joint != o).then_some(joint);
            let rows = [o, x, y].into_iter().chain(begin).chain([moved]);
            Constraint::new(rows.map(RagdollParticle::index), ConstraintKind::Cone(cone))
        }
        Limit::Turn { rows, below, above } => turn(rows, below, above, None),
        Limit::Hinge { rows, below, above } => turn(rows, below, above, Some(std::f64::consts::PI)),
    })
}

/// A part of the table for a figure of this height.
fn shaped(part: &anatomy::Segment, body: &Blueprint, height: f32) -> Part {
    let at = |particle: &RagdollParticle| body.particles[particle.index() as usize];
    let positions: Vec<Vec3> = part.particles.iter().map(|p| at(p).position).collect();
    let (rest, size, limb) = match part.shape {
        PartShape::Box { centre, size } => {
            let centre = (centre * f64::from(height)).as_vec3();
            (positions.iter().map(|&p| p - centre).collect(), size * f64::from(height), false)
        }
        PartShape::Limb { thickness } => {
            let [near, far] = [positions[0], positions[1]].map(Vec3::as_dvec3);
            let y = (near - far).normalize_or_zero();
            let x = DVec3::X.reject_from_normalized(y).normalize_or_zero();
            let axes = [x, y, x.cross(y)];
            let local = |p: &Vec3| {
                let from = p.as_dvec3() - (near + far) * 0.5;
                DVec3::from_array(axes.map(|axis| axis.dot(from))).as_vec3()
            };
            let thickness = thickness * f64::from(height);
            let size = DVec3::new(thickness, near.distance(far) + thickness, thickness);
            (positions.iter().map(local).collect(), size, true)
        }
    };
    Part {
        name: part.name,
        particles: part.particles.iter().map(|p| p.index()).collect(),
        rest,
        size: size.as_vec3(),
        shape: if limb {
            Shape::capsule(0.5 * size.x as f32, (size.y - size.x) as f32).ok()
        } else {
            Shape::cuboid(size.as_vec3()).ok()
        },
    }
}

#[cfg(test)]
mod tests;
