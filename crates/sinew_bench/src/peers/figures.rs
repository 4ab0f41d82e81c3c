//! Boxes and ragdolls as rapier's rigid bodies and joints, with its default settings, except that nothing sleeps.

use rapier3d::prelude::*;
use sinew::glam::{Quat, Vec3};
use sinew::pose::Pose;
use sinew::recipes::{Blueprint, Part, RagdollParticle as P, RagdollSpec, ragdoll};

use crate::measure::{Cube, World};
use crate::places::{places, stacked, stairs};
use crate::row::Stretch;

/// A world of rigid bodies.
pub(super) struct Rigid {
    world: PhysicsWorld,
    /// How long the bones are that hang on joints, metres: one for each joint.
    lengths: Vec<(ImpulseJointHandle, f64)>,
}

/// Half the size of the slab that is the floor, m.
const FLOOR: Vec3 = Vec3::new(200.0, 1.0, 200.0);

/// Where a part of a ragdoll hangs on another, and whether it turns about one axis alone.
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

/// Limits about each axis of a joint that turns about all three, radians, and of one that turns about one.
const LIMITS: ([f32; 2], [f32; 2]) = ([-1.0, 1.0], [-2.4, 2.4]);

pub(super) fn boxes(side: u32) -> Rigid {
    let mut world = floored();
    for place in places(side) {
        let place = vector(place + Vec3::Y * 0.5);
        let body = RigidBodyBuilder::dynamic().translation(place).can_sleep(false);
        world.insert(body, ColliderBuilder::cuboid(0.5, 0.5, 0.5));
    }
    world.into()
}

pub(super) fn heap(edge: u32) -> Rigid {
    let mut world = floored();
    for place in stacked(edge) {
        let body = RigidBodyBuilder::dynamic().translation(vector(place)).can_sleep(false);
        world.insert(body, ColliderBuilder::cuboid(0.5, 0.5, 0.5));
    }
    world.into()
}

pub(super) fn ragdolls(side: u32) -> Rigid {
    with_dolls(floored(), side)
}

pub(super) fn on_stairs(side: u32) -> Rigid {
    let mut world = PhysicsWorld::new();
    for (half, place) in stairs(side) {
        let stair = ColliderBuilder::cuboid(half.x, half.y, half.z).translation(vector(place));
        world.insert_collider(stair, None);
    }
    with_dolls(world, side)
}

impl World for Rigid {
    fn tick(&mut self) {
        self.world.step();
    }

    /// How far the two anchors of a joint are apart, as a share of the bone that hangs on it: rigid bones do not stretch, and gape instead.
    fn stretch(&self) -> Option<Stretch> {
        let gaps = self.lengths.iter().filter_map(|&(handle, length)| {
            let joint = self.world.impulse_joints.get(handle)?;
            let place = |body, anchor: Vector| {
                Some(self.world.bodies.get(body)?.position().transform_point(anchor))
            };
            let one = place(joint.body1(), joint.data.local_anchor1())?;
            let other = place(joint.body2(), joint.data.local_anchor2())?;
            Some(f64::from((one - other).length()) / length)
        });
        (!self.lengths.is_empty()).then(|| Stretch::of_shares(gaps))
    }

    fn cubes(&self) -> Vec<Cube> {
        let array = |v: Vector| Vec3::new(v.x, v.y, v.z);
        let cube = |body: &RigidBody| {
            let (place, q) = (body.position().translation, body.position().rotation);
            let rotation = Quat::from_xyzw(q.x, q.y, q.z, q.w);
            let pose = Pose { translation: array(place), rotation };
            Cube { pose, velocity: array(body.linvel()) }
        };
        self.world.bodies.iter().map(|(_, body)| cube(body)).collect()
    }
}

impl Rigid {
    /// The same with so many substeps.
    pub(super) fn with(mut self, substeps: u32) -> Self {
        self.world.integration_parameters.num_solver_iterations = substeps as usize;
        self
    }
}

impl From<PhysicsWorld> for Rigid {
    fn from(world: PhysicsWorld) -> Self {
        Self { world, lengths: Vec::new() }
    }
}

/// The same with `side × side` ragdolls above the ground.
fn with_dolls(world: PhysicsWorld, side: u32) -> Rigid {
    let doll = ragdoll(&RagdollSpec::default()).expect("the ragdoll is sound");
    let mut rigid = Rigid::from(world);
    places(side).for_each(|place| insert(&mut rigid, &doll, place + Vec3::Y));
    rigid
}

fn floored() -> PhysicsWorld {
    let mut world = PhysicsWorld::new();
    let slab = ColliderBuilder::cuboid(FLOOR.x, FLOOR.y, FLOOR.z);
    world.insert_collider(slab.translation(vector(Vec3::NEG_Y * FLOOR.y)), None);
    world
}

/// The parts of a ragdoll as capsules and boxes of the same sizes and masses, and a joint where two parts share a particle.
fn insert(Rigid { world, lengths }: &mut Rigid, doll: &Blueprint, place: Vec3) {
    let at = |i: u32| doll.particles[i as usize].position;
    let mut handles = Vec::new();
    for part in &doll.parts {
        let (shape, centre) = shape(part, at);
        let body = RigidBodyBuilder::dynamic().translation(vector(place + centre));
        let (handle, _) = world.insert(body.can_sleep(false), shape.density(1000.0));
        handles.push((part.name, handle, centre, part.size));
    }
    let find = |name: &str| handles.iter().find(|(part, ..)| *part == name);
    for (first, second, joint, hinge) in JOINTS {
        let (Some(&(_, first, one, _)), Some(&(_, second, other, size))) =
            (find(first), find(second))
        else {
            continue;
        };
        let point = at(joint.index());
        let [one, other] = [point - one, point - other].map(vector);
        let handle = if hinge {
            let joint = RevoluteJointBuilder::new(Vector::X).limits(LIMITS.1);
            let joint = joint.local_anchor1(one).local_anchor2(other).contacts_enabled(false);
            world.insert_impulse_joint(first, second, joint)
        } else {
            let axes = [JointAxis::AngX, JointAxis::AngY, JointAxis::AngZ];
            let joint = SphericalJointBuilder::new().local_anchor1(one).local_anchor2(other);
            let joint = joint.contacts_enabled(false);
            let joint = axes.into_iter().fold(joint, |joint, axis| joint.limits(axis, LIMITS.0));
            world.insert_impulse_joint(first, second, joint)
        };
        lengths.push((handle, f64::from(size.max_element())));
    }
}

/// A limb is a capsule from one joint to the next; what else there is, a box.
fn shape(part: &Part, at: impl Fn(u32) -> Vec3) -> (ColliderBuilder, Vec3) {
    let [from, to] = [part.particles[0], part.particles[1]].map(at);
    let limb = ["arm", "thigh", "shin"].iter().any(|word| part.name.contains(word));
    if limb {
        let (centre, half) = (0.5 * (from + to), 0.5 * (to - from));
        let radius = 0.5 * part.size.x;
        (ColliderBuilder::capsule_from_endpoints(vector(-half), vector(half), radius), centre)
    } else {
        let half = 0.5 * part.size;
        // A part of this kind is upright: a particle is as far from the centre as it says.
        (ColliderBuilder::cuboid(half.x, half.y, half.z), from - part.rest[0])
    }
}

fn vector(v: Vec3) -> Vector {
    Vector::from(v.to_array())
}
