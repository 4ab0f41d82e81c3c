//! The human figure in numbers. Lengths are shares of the height, masses shares of the whole mass.
//!
//! Heights, breadths and lengths: Drillis & Contini, *Body Segment Parameters* (1966), as drawn in Winter, *Biomechanics and
//! Motor Control of Human Movement*, fig. 4.1: chin 0.870, shoulder 0.818, hip 0.530, knee 0.285 and ankle 0.039 above the
//! ground; half the shoulder breadth 0.129, hip breadth 0.191, upper arm 0.186, forearm 0.146, hand 0.108. The neck, sternum,
//! waist and pelvis particles and all depths and thicknesses are ours, chosen for a figure that looks the part.
//!
//! Masses: Winter, table 4.1 (after Dempster 1955): head and neck 0.081, thorax 0.216, abdomen 0.139, pelvis 0.142; each
//! upper arm 0.028, forearm 0.016, hand 0.006, thigh 0.100, shank 0.0465, foot 0.0145. A limb's mass goes to the two ends of
//! its bone so that its centre of mass stays where that table has it: at 0.436 (upper arm), 0.430 (forearm) and 0.433
//! (thigh, shank) of its length from the near end. The hand is at its own centre, a forearm and half a hand from the elbow.

use glam::DVec3;

use super::RagdollParticle::{self, *};
use crate::constraints::Bound;

/// A particle of the figure.
#[derive(Clone, Copy)]
pub(super) struct Joint {
    pub(super) particle: RagdollParticle,
    pub(super) position: DVec3,
    pub(super) radius: f64,
    pub(super) mass: f64,
}

/// "Turning `moved` about `joint` around `axis` (right-handed) by so many degrees brings it to its limit": from then on its
/// distance from `from` is bounded.
pub(super) struct Limit {
    pub(super) moved: RagdollParticle,
    pub(super) joint: RagdollParticle,
    pub(super) axis: DVec3,
    pub(super) degrees: f64,
    pub(super) from: RagdollParticle,
    pub(super) bound: Bound,
}

/// A part to draw.
pub(super) struct Segment {
    pub(super) name: &'static str,
    pub(super) particles: &'static [RagdollParticle],
    pub(super) shape: Shape,
}

/// How a part is drawn.
pub(super) enum Shape {
    /// A box about a centre, upright while the figure stands.
    Box { centre: DVec3, size: DVec3 },
    /// A capsule along the bone from the first particle to the second.
    Limb { thickness: f64 },
}

/// Mass at the far end of each limb, by the centre of its mass. Half a hand is 0.054 (its centre at 0.506 of 0.108).
const UPPER_ARM_FAR: f64 = 0.028 * 0.436;
const FOREARM_FAR: f64 = 0.016 * 0.430 * 0.146 / (0.146 + 0.055);
const THIGH_FAR: f64 = 0.100 * 0.433;
const SHIN_FAR: f64 = 0.0465 * 0.433;

/// Particles in the order of their numbers: the middle, the left, the right.
pub(super) const FIGURE: [Joint; 17] = [
    joint(Head, [0.0, 0.935, -0.01], 0.065, 0.081),
    // Thorax 0.216 = neck 0.016 + sternum 0.14 + shoulders 0.03 each; abdomen = waist.
    joint(Neck, [0.0, 0.850, -0.01], 0.030, 0.016),
    joint(Sternum, [0.0, 0.720, 0.04], 0.040, 0.140),
    joint(Waist, [0.0, 0.600, -0.03], 0.050, 0.139),
    // Pelvis 0.142 = 0.050 + hips 0.046 each.
    joint(Pelvis, [0.0, 0.550, 0.04], 0.040, 0.050),
    LEFT[0],
    LEFT[1],
    LEFT[2],
    LEFT[3],
    LEFT[4],
    LEFT[5],
    mirrored(LEFT[0], RightShoulder),
    mirrored(LEFT[1], RightElbow),
    mirrored(LEFT[2], RightHand),
    mirrored(LEFT[3], RightHip),
    mirrored(LEFT[4], RightKnee),
    mirrored(LEFT[5], RightAnkle),
];

/// One side.
const LEFT: [Joint; 6] = [
    joint(LeftShoulder, [0.129, 0.818, 0.0], 0.030, 0.030 + 0.028 - UPPER_ARM_FAR),
    joint(LeftElbow, [0.129, 0.632, -0.008], 0.022, UPPER_ARM_FAR + 0.016 - FOREARM_FAR),
    joint(LeftHand, [0.129, 0.431, 0.012], 0.025, FOREARM_FAR + 0.006),
    joint(LeftHip, [0.050, 0.530, 0.0], 0.045, 0.046 + 0.100 - THIGH_FAR),
    joint(LeftKnee, [0.050, 0.285, 0.010], 0.033, THIGH_FAR + 0.0465 - SHIN_FAR),
    joint(LeftAnkle, [0.050, 0.039, 0.0], 0.039, SHIN_FAR + 0.0145),
];

/// Rods; those of the left stand for both sides. Thorax and pelvis have all their pairs: rigid.
pub(super) const BONES: &[[RagdollParticle; 2]] = &[
    [Head, Neck],
    [Neck, Sternum],
    [Neck, Waist],
    [Neck, LeftShoulder],
    [Sternum, Waist],
    [Sternum, LeftShoulder],
    [Waist, LeftShoulder],
    [LeftShoulder, RightShoulder],
    [Waist, Pelvis],
    [Waist, LeftHip],
    [Pelvis, LeftHip],
    [LeftHip, RightHip],
    [LeftShoulder, LeftElbow],
    [LeftElbow, LeftHand],
    [LeftHip, LeftKnee],
    [LeftKnee, LeftAnkle],
];

/// Particles that come no nearer than their radii together, so that limbs do not pass through each other and the trunk.
pub(super) const APART: &[[RagdollParticle; 2]] = &[
    [LeftKnee, RightKnee],
    [LeftAnkle, RightAnkle],
    [LeftElbow, Waist],
    [LeftElbow, Sternum],
    [LeftHand, Pelvis],
    [LeftHand, Waist],
    [LeftHand, LeftHip],
    [LeftHand, Head],
];

/// Axes that turn what hangs below its joint (an arm, a leg) or stands above it (the trunk, the head) in the named direction.
const FORWARD_BELOW: DVec3 = DVec3::NEG_X;
const BACK_BELOW: DVec3 = DVec3::X;
const FORWARD_ABOVE: DVec3 = DVec3::X;
const LEFT_ABOVE: DVec3 = DVec3::NEG_Z;
const LEFT_BELOW: DVec3 = DVec3::Z;

/// Limits; those of the left stand for both sides. The angles are rounded from the ranges of motion of the American Academy of
/// Orthopaedic Surgeons (*Joint Motion*, 1965), less what thick limbs cannot do.
pub(super) const LIMITS: &[Limit] = &[
    // Neck: 45° from the line of the spine, all around.
    limit(Head, Neck, FORWARD_ABOVE, 45.0, Waist, Bound::AtLeast),
    // Waist: bends 45° forward, 35° to a side, twists 45°, which is also some 25° back.
    limit(Sternum, Waist, FORWARD_ABOVE, 45.0, Pelvis, Bound::AtLeast),
    limit(LeftShoulder, Waist, LEFT_ABOVE, 35.0, LeftHip, Bound::AtLeast),
    limit(Sternum, Waist, DVec3::NEG_Y, 45.0, LeftHip, Bound::AtMost),
    // Shoulder: across the chest by 45°.
    limit(LeftElbow, LeftShoulder, DVec3::NEG_Z, 45.0, RightShoulder, Bound::AtLeast),
    // Elbow: 140°.
    limit(LeftHand, LeftElbow, FORWARD_BELOW, 140.0, LeftShoulder, Bound::AtLeast),
    // Hip: 110° forward, 30° back, 45° outward.
    limit(LeftKnee, LeftHip, FORWARD_BELOW, 110.0, Waist, Bound::AtLeast),
    limit(LeftKnee, LeftHip, BACK_BELOW, 30.0, Pelvis, Bound::AtMost),
    limit(LeftKnee, LeftHip, LEFT_BELOW, 45.0, RightHip, Bound::AtMost),
    // Knee: 135°.
    limit(LeftAnkle, LeftKnee, BACK_BELOW, 135.0, LeftHip, Bound::AtLeast),
];

/// The parts. The torso's box spans shoulders and chest; the head's box is as tall as from chin to crown.
pub(super) const PARTS: &[Segment] = &[
    boxed("head", &[Head, Neck], [0.0, 0.935, -0.01], [0.090, 0.130, 0.110]),
    boxed(
        "torso",
        &[Neck, Sternum, Waist, LeftShoulder, RightShoulder],
        [0.0, 0.725, 0.0],
        [0.230, 0.240, 0.140],
    ),
    boxed("pelvis", &[Waist, Pelvis, LeftHip, RightHip], [0.0, 0.545, 0.0], [0.191, 0.110, 0.140]),
    limb("left upper arm", &[LeftShoulder, LeftElbow], 0.052),
    limb("left forearm", &[LeftElbow, LeftHand], 0.044),
    limb("left thigh", &[LeftHip, LeftKnee], 0.086),
    limb("left shin", &[LeftKnee, LeftAnkle], 0.066),
    limb("right upper arm", &[RightShoulder, RightElbow], 0.052),
    limb("right forearm", &[RightElbow, RightHand], 0.044),
    limb("right thigh", &[RightHip, RightKnee], 0.086),
    limb("right shin", &[RightKnee, RightAnkle], 0.066),
];

const fn joint(particle: RagdollParticle, [x, y, z]: [f64; 3], radius: f64, mass: f64) -> Joint {
    let position = DVec3::new(x, y, z);
    Joint { particle, position, radius, mass }
}

const fn mirrored(left: Joint, particle: RagdollParticle) -> Joint {
    let position = DVec3::new(-left.position.x, left.position.y, left.position.z);
    Joint { particle, position, ..left }
}

const fn limit(
    moved: RagdollParticle,
    joint: RagdollParticle,
    axis: DVec3,
    degrees: f64,
    from: RagdollParticle,
    bound: Bound,
) -> Limit {
    Limit { moved, joint, axis, degrees, from, bound }
}

const fn boxed(
    name: &'static str,
    particles: &'static [RagdollParticle],
    [x, y, z]: [f64; 3],
    size: [f64; 3],
) -> Segment {
    let centre = DVec3::new(x, y, z);
    let size = DVec3::from_array(size);
    Segment { name, particles, shape: Shape::Box { centre, size } }
}

const fn limb(
    name: &'static str,
    particles: &'static [RagdollParticle; 2],
    thickness: f64,
) -> Segment {
    Segment { name, particles, shape: Shape::Limb { thickness } }
}
