//! The human figure in numbers. Lengths are shares of the height, masses shares of the total mass.
//!
//! Heights, breadths and lengths: Drillis & Contini, *Body Segment Parameters* (1966), as drawn in Winter, *Biomechanics and Motor Control of Human Movement*,
//! fig. 4.1: chin 0.870, shoulder 0.818, hip 0.530, knee 0.285 and ankle 0.039 above the ground; half the shoulder breadth 0.129, hip breadth 0.191, upper arm
//! 0.186, forearm 0.146, hand 0.108. The neck, sternum, waist, pelvis and face particles, the pins and all depths and thicknesses are not from the literature
//! but chosen for a plausible figure.
//!
//! Masses: Winter, table 4.1 (after Dempster 1955): head and neck 0.081, thorax 0.216, abdomen 0.139, pelvis 0.142; each upper arm 0.028, forearm 0.016, hand
//! 0.006, thigh 0.100, shank 0.0465, foot 0.0145. A limb's mass is split between the two ends of its bone so that its centre of mass is where that table has
//! it: at 0.436 (upper arm), 0.430 (forearm) and 0.433 (thigh, shank) of its length from the near end. The hand is at its own centre, a forearm and half a hand
//! from the elbow.

use glam::DVec3;

use super::RagdollParticle::{self, *};

/// A particle of the figure.
#[derive(Clone, Copy)]
pub(super) struct FigureParticle {
    pub(super) particle: RagdollParticle,
    pub(super) position: DVec3,
    pub(super) radius: f64,
    pub(super) mass: f64,
}

/// A limit of a joint, in degrees.
pub(super) enum Limit {
    /// The direction from `joint` to `moved` stays within an angle of a direction that is fixed in the frame of three particles.
    Cone {
        frame: [RagdollParticle; 3],
        joint: RagdollParticle,
        moved: RagdollParticle,
        around: DVec3,
        degrees: f64,
    },
    /// Limits the angle about the axis of the second and third particle, from the first to the fourth particle, relative to the standing figure: `below` and
    /// `above` are degrees to either side.
    Turn { rows: [RagdollParticle; 4], below: f64, above: f64 },
    /// The same, relative to a straight joint.
    Hinge { rows: [RagdollParticle; 4], below: f64, above: f64 },
}

/// A rigid part: its particles and its shape.
pub(super) struct Segment {
    pub(super) name: &'static str,
    pub(super) particles: &'static [RagdollParticle],
    pub(super) shape: PartShape,
}

/// Shape of a part.
pub(super) enum PartShape {
    /// A box about a centre, upright while the figure stands.
    Box { centre: DVec3, size: DVec3 },
    /// A capsule along the bone from the first particle to the second; the third particle is beside it.
    Limb { thickness: f64 },
}

/// Mass at the far end of each limb, from its centre of mass. Half a hand is 0.054 (its centre at 0.506 of 0.108).
const UPPER_ARM_FAR: f64 = 0.028 * 0.436;
const FOREARM_FAR: f64 = 0.016 * 0.430 * 0.146 / (0.146 + 0.055);
const THIGH_FAR: f64 = 0.100 * 0.433;
const SHIN_FAR: f64 = 0.0465 * 0.433;

const ELBOW: f64 = UPPER_ARM_FAR + 0.016 - FOREARM_FAR;
const KNEE: f64 = THIGH_FAR + 0.0465 - SHIN_FAR;
/// Share of an elbow's or a knee's mass that its pin has: enough for the limits to act on the pin.
const PIN: f64 = 0.4;

/// Particles in the order of their indices: the middle, the left, the right.
pub(super) const FIGURE: [FigureParticle; 22] = [
    // Head 0.081 = its middle 0.061 + the face 0.020.
    joint(Head, [0.0, 0.935, -0.01], 0.065, 0.061),
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
    joint(Face, [0.0, 0.920, 0.045], 0.015, 0.020),
    LEFT_PINS[0],
    LEFT_PINS[1],
    mirrored(LEFT_PINS[0], RightElbowPin),
    mirrored(LEFT_PINS[1], RightKneePin),
];

/// The left side.
const LEFT: [FigureParticle; 6] = [
    joint(LeftShoulder, [0.129, 0.818, 0.0], 0.030, 0.030 + 0.028 - UPPER_ARM_FAR),
    joint(LeftElbow, [0.129, 0.632, -0.008], 0.022, (1.0 - PIN) * ELBOW),
    joint(LeftHand, [0.129, 0.431, 0.012], 0.025, FOREARM_FAR + 0.006),
    joint(LeftHip, [0.050, 0.530, 0.0], 0.045, 0.046 + 0.100 - THIGH_FAR),
    joint(LeftKnee, [0.050, 0.285, 0.010], 0.033, (1.0 - PIN) * KNEE),
    joint(LeftAnkle, [0.050, 0.039, 0.0], 0.039, SHIN_FAR + 0.0145),
];

/// The outer ends of the pins of elbow and knee: the outer epicondyle of the bone, where the limb is thickest.
const LEFT_PINS: [FigureParticle; 2] = [
    joint(LeftElbowPin, [0.164, 0.632, -0.008], 0.0, PIN * ELBOW),
    joint(LeftKneePin, [0.090, 0.285, 0.010], 0.0, PIN * KNEE),
];

/// Rods; those on the left are mirrored to the right. Thorax and pelvis have all their pairs and so are rigid.
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
    [Head, Face],
    [Neck, Face],
    [LeftShoulder, LeftElbowPin],
    [LeftElbow, LeftElbowPin],
    [LeftElbowPin, LeftHand],
    [LeftHip, LeftKneePin],
    [LeftKnee, LeftKneePin],
    [LeftKneePin, LeftAnkle],
];

/// Pairs of particles that come no nearer than the sum of their radii, so that limbs do not pass through each other and the trunk.
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

/// Limits; those on the left are mirrored to the right. The angles are rounded from the ranges of motion of the American Academy of Orthopaedic Surgeons
/// (*Joint Motion*, 1965), reduced where thick limbs would intersect; x is to the figure's left, y up, z forward.
///
/// A twist is measured from a particle of the trunk, and is undefined where the limb points at that particle. So it is measured from one that the cone keeps
/// out of reach. The upper arm reaches everywhere; its twist limit is wide instead.
pub(super) const LIMITS: &[Limit] = &[
    // Neck: bends 45° all around (flexion, extension and lateral bending 45°) and turns 60° to either side.
    cone_from([Waist, LeftShoulder, RightShoulder], [Neck, Head], [0.0, 1.0, 0.0], 45.0),
    turn([LeftShoulder, Neck, Head, Face], 60.0, 60.0),
    // Spine: forward 47° (of 80°, the rest is in the hips), back 27° (25°), sideways 36° (35°); turns 40° (45°).
    cone([Waist, LeftHip, RightHip], Neck, [0.0, 0.966, 0.259], 37.0),
    turn([Pelvis, Waist, Neck, LeftShoulder], 40.0, 40.0),
    // Shoulder: up to 180° forward and sideways, 55° back (60°), across the body 56° both hanging and level; turns 90° to either side.
    cone([LeftShoulder, RightShoulder, Waist], LeftElbow, [0.652, -0.351, 0.672], 110.0),
    turn([Sternum, LeftShoulder, LeftElbow, LeftElbowPin], 90.0, 90.0),
    // Elbow: closes by 145° (150°), and not beyond straight.
    Limit::Hinge {
        rows: [LeftShoulder, LeftElbow, LeftElbowPin, LeftHand],
        below: 145.0,
        above: 0.0,
    },
    // Hip: forward 117° (120°), back 27° (30°); outward 45°, inward 30°; turns 45° either way.
    cone([LeftHip, RightHip, Waist], LeftKnee, [0.0, -0.707, 0.707], 72.0),
    cone([LeftHip, RightHip, Waist], LeftKnee, [-1.0, 0.0, 0.0], 135.0),
    cone([LeftHip, RightHip, Waist], LeftKnee, [1.0, 0.0, 0.0], 120.0),
    turn([RightHip, LeftHip, LeftKnee, LeftKneePin], 45.0, 45.0),
    // Knee: closes by 135°, and not beyond straight.
    Limit::Hinge { rows: [LeftHip, LeftKnee, LeftKneePin, LeftAnkle], below: 0.0, above: 135.0 },
];

/// The parts. The torso's box spans shoulders and chest; the head's box reaches from chin to crown.
pub(super) const PARTS: &[Segment] = &[
    boxed("head", &[Head, Neck, Face], [0.0, 0.935, -0.01], [0.090, 0.130, 0.110]),
    boxed(
        "torso",
        &[Neck, Sternum, Waist, LeftShoulder, RightShoulder],
        [0.0, 0.725, 0.0],
        [0.230, 0.240, 0.140],
    ),
    boxed("pelvis", &[Waist, Pelvis, LeftHip, RightHip], [0.0, 0.545, 0.0], [0.191, 0.110, 0.140]),
    limb("left upper arm", &[LeftShoulder, LeftElbow, LeftElbowPin], 0.052),
    limb("left forearm", &[LeftElbow, LeftHand, LeftElbowPin], 0.044),
    limb("left thigh", &[LeftHip, LeftKnee, LeftKneePin], 0.086),
    limb("left shin", &[LeftKnee, LeftAnkle, LeftKneePin], 0.066),
    limb("right upper arm", &[RightShoulder, RightElbow, RightElbowPin], 0.052),
    limb("right forearm", &[RightElbow, RightHand, RightElbowPin], 0.044),
    limb("right thigh", &[RightHip, RightKnee, RightKneePin], 0.086),
    limb("right shin", &[RightKnee, RightAnkle, RightKneePin], 0.066),
];

const fn joint(
    particle: RagdollParticle,
    [x, y, z]: [f64; 3],
    radius: f64,
    mass: f64,
) -> FigureParticle {
    let position = DVec3::new(x, y, z);
    FigureParticle { particle, position, radius, mass }
}

const fn mirrored(left: FigureParticle, particle: RagdollParticle) -> FigureParticle {
    let position = DVec3::new(-left.position.x, left.position.y, left.position.z);
    FigureParticle { particle, position, ..left }
}

/// A cone whose joint is the first particle of the frame.
const fn cone(
    frame: [RagdollParticle; 3],
    moved: RagdollParticle,
    around: [f64; 3],
    degrees: f64,
) -> Limit {
    cone_from(frame, [frame[0], moved], around, degrees)
}

const fn cone_from(
    frame: [RagdollParticle; 3],
    [joint, moved]: [RagdollParticle; 2],
    [x, y, z]: [f64; 3],
    degrees: f64,
) -> Limit {
    Limit::Cone { frame, joint, moved, around: DVec3::new(x, y, z), degrees }
}

const fn turn(rows: [RagdollParticle; 4], below: f64, above: f64) -> Limit {
    Limit::Turn { rows, below, above }
}

const fn boxed(
    name: &'static str,
    particles: &'static [RagdollParticle],
    [x, y, z]: [f64; 3],
    size: [f64; 3],
) -> Segment {
    let centre = DVec3::new(x, y, z);
    let size = DVec3::from_array(size);
    Segment { name, particles, shape: PartShape::Box { centre, size } }
}

const fn limb(
    name: &'static str,
    particles: &'static [RagdollParticle; 3],
    thickness: f64,
) -> Segment {
    Segment { name, particles, shape: PartShape::Limb { thickness } }
}
