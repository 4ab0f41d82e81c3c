//! The ragdoll of the recipe as rivals have it: rigid limbs of the same sizes and densities, and a joint where two of them share a particle.

use sinew::glam::Vec3;
use sinew::recipes::{Part, RagdollParticle as P, RagdollSpec, ragdoll};

/// Kilograms in a cubic metre of a limb.
pub(super) const DENSITY: f32 = 1000.0;

/// Limits about each axis of a joint that turns about all three, radians, and of one that turns about one, the x axis.
pub(super) const LIMITS: ([f32; 2], [f32; 2]) = ([-1.0, 1.0], [-2.4, 2.4]);

/// A rigid limb.
pub(super) struct Limb {
    /// Where its middle is in the figure, metres.
    pub(super) centre: Vec3,
    pub(super) form: Form,
}

/// What a limb is.
pub(super) enum Form {
    /// From `-half` to `half` about its middle, metres.
    Capsule { half: Vec3, radius: f32 },
    /// Half of its edges, metres.
    Cuboid { half: Vec3 },
}

/// Where two limbs, by their numbers, hang together.
pub(super) struct LimbJoint {
    pub(super) limbs: [usize; 2],
    /// In the figure, metres.
    pub(super) point: Vec3,
    /// Whether it turns about one axis alone.
    pub(super) hinge: bool,
    /// How long the bone is that hangs on it, metres.
    pub(super) length: f64,
}

/// Where a part hangs on another, and whether it turns about one axis alone.
const JOINTS: [(&str, &str, P, bool); 10] = [
    ("torso", "head", P::Neck, false),
    ("torso", "pelvis", P::Waist, false),
    ("torso", "left upper arm", P::LeftShoulder, false),
    ("torso", "right upper arm", P::RightShoulder, false),
    ("pelvis", "left thigh", P::LeftHip, false),
    ("pelvis", "right thigh", P::RightHip, false),
    ("left upper arm", "left forearm", P::LeftElbow, true),
    ("right upper arm", "right forearm", P::RightElbow, true),
    ("left thigh", "left shin", P::LeftKnee, true),
    ("right thigh", "right shin", P::RightKnee, true),
];

/// The limbs of a figure, and what holds them together.
pub(super) fn figure() -> (Vec<Limb>, Vec<LimbJoint>) {
    let doll = ragdoll(&RagdollSpec::default()).expect("the ragdoll is sound");
    let at = |i: u32| doll.particles[i as usize].position;
    let find = |name: &str| doll.parts.iter().position(|part| part.name == name);
    let joint = |(first, second, joint, hinge): (&str, &str, P, bool)| {
        let limbs = [find(first)?, find(second)?];
        let length = f64::from(doll.parts[limbs[1]].size.max_element());
        Some(LimbJoint { limbs, point: at(joint.index()), hinge, length })
    };
    let limbs = doll.parts.iter().map(|part| limb(part, at)).collect();
    (limbs, JOINTS.into_iter().filter_map(joint).collect())
}

/// An arm or a leg is a capsule from one joint to the next; what else there is, a box.
fn limb(part: &Part, at: impl Fn(u32) -> Vec3) -> Limb {
    let [from, to] = [part.particles[0], part.particles[1]].map(at);
    if ["arm", "thigh", "shin"].iter().any(|word| part.name.contains(word)) {
        let (centre, half) = (0.5 * (from + to), 0.5 * (to - from));
        Limb { centre, form: Form::Capsule { half, radius: 0.5 * part.size.x } }
    } else {
        // A part of this kind is upright: a particle is as far from the centre as it says.
        Limb { centre: from - part.rest[0], form: Form::Cuboid { half: 0.5 * part.size } }
    }
}
