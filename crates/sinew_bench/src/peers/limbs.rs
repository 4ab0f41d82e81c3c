//! The recipe's ragdoll for engines of rigid bodies: rigid limbs of the same sizes and densities, with a joint where two of them share a particle.

use sinew::glam::Vec3;
use sinew::recipes::{Part, RagdollParticle as P, RagdollSpec, ragdoll};

/// Density of a limb, kg/m³.
pub(super) const DENSITY: f32 = 1000.0;

/// Angle limits, radians: about each axis of a spherical joint, and about the x axis of a hinge.
pub(super) const LIMITS: ([f32; 2], [f32; 2]) = ([-1.0, 1.0], [-2.4, 2.4]);

/// A rigid limb.
pub(super) struct Limb {
    /// Its centre in the ragdoll's frame, metres.
    pub(super) centre: Vec3,
    pub(super) form: Form,
}

/// Shape of a limb.
pub(super) enum Form {
    /// Segment from `-half` to `half` about its centre, and radius, metres.
    Capsule { half: Vec3, radius: f32 },
    /// Half of its edge lengths, metres.
    Cuboid { half: Vec3 },
}

/// A joint between two limbs.
pub(super) struct LimbJoint {
    pub(super) limbs: [usize; 2],
    /// Its position in the ragdoll's frame, metres.
    pub(super) point: Vec3,
    /// Whether it is a hinge about the x axis; otherwise it is a spherical joint.
    pub(super) hinge: bool,
    /// Length of the bone that it attaches, metres.
    pub(super) length: f64,
}

/// The joints: parent part, attached part, the shared particle, and whether it is a hinge.
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

/// The limbs of a ragdoll, and its joints.
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

/// Arms and legs are capsules from one joint to the next; other parts are boxes.
fn limb(part: &Part, at: impl Fn(u32) -> Vec3) -> Limb {
    let [from, to] = [part.particles[0], part.particles[1]].map(at);
    if ["arm", "thigh", "shin"].iter().any(|word| part.name.contains(word)) {
        let (centre, half) = (0.5 * (from + to), 0.5 * (to - from));
        Limb { centre, form: Form::Capsule { half, radius: 0.5 * part.size.x } }
    } else {
        // Such a part is upright: its particles have their rest offsets from the centre.
        Limb { centre: from - part.rest[0], form: Form::Cuboid { half: 0.5 * part.size } }
    }
}
