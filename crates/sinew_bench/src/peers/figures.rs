//! Boxes and ragdolls as rigid bodies and joints of rapier, at default settings; sleeping is on in the user scenes only.

use rapier3d::prelude::*;
use sinew::glam::{Quat, Vec3};
use sinew::pose::Pose;

use super::limbs::{self, Form, Limb, LimbJoint};
use crate::measure::{Cube, World};
use crate::places;
use crate::row::Stretch;

/// A rapier world of rigid bodies.
pub(super) struct Rigid {
    world: PhysicsWorld,
    /// The joints, each with the length of the bone that it attaches, metres.
    lengths: Vec<(ImpulseJointHandle, f64)>,
}

/// Half the size of the floor slab, m.
const FLOOR: Vec3 = Vec3::new(200.0, 1.0, 200.0);

pub(super) fn boxes(side: u32) -> Rigid {
    let mut world = floored();
    for place in places::places(side) {
        let place = vector(place + Vec3::Y * 0.5);
        let body = RigidBodyBuilder::dynamic().translation(place).can_sleep(false);
        world.insert(body, ColliderBuilder::cuboid(0.5, 0.5, 0.5));
    }
    world.into()
}

pub(super) fn heap(edge: u32) -> Rigid {
    let mut world = floored();
    for place in places::stacked(edge) {
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
    for (half, place) in places::stairs(side) {
        let stair = ColliderBuilder::cuboid(half.x, half.y, half.z).translation(vector(place));
        world.insert_collider(stair, None);
    }
    with_dolls(world, side)
}

/// A thousand boxes that lie side by side, and may sleep or not.
pub(super) fn lying(sleep: bool) -> Rigid {
    let mut world = floored();
    for place in places::lying() {
        let body = RigidBodyBuilder::dynamic().translation(vector(place)).can_sleep(sleep);
        world.insert(body, ColliderBuilder::cuboid(0.5, 0.5, 0.5));
    }
    world.into()
}

/// A thousand boxes that fall and may sleep, in rows or poured between four walls.
pub(super) fn pile(poured: bool) -> Rigid {
    let mut world = floored();
    if poured {
        fixed(&mut world, places::pit());
    }
    for (place, turn) in places::pile(poured) {
        let body = RigidBodyBuilder::dynamic()
            .pose(rapier3d::math::Pose::from_parts(vector(place), turned(turn)));
        world.insert(body, ColliderBuilder::cuboid(0.5, 0.5, 0.5));
    }
    world.into()
}

/// A hundred ragdolls that may sleep, above stairs with steps of height `rise`, metres, and a floor.
pub(super) fn figures(rise: f32) -> Rigid {
    let mut world = floored();
    fixed(&mut world, places::flight(rise));
    let figure = limbs::figure();
    let mut rigid = Rigid::from(world);
    places::figures(rise).for_each(|place| insert(&mut rigid, &figure, place, true));
    rigid
}

impl World for Rigid {
    fn tick(&mut self) {
        self.world.step();
    }

    /// Distance between the two anchors of each joint, relative to the length of the attached bone: rigid bones do not stretch, but joints open.
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
    /// Sets the number of substeps.
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

/// Adds `side × side` ragdolls above the ground.
fn with_dolls(world: PhysicsWorld, side: u32) -> Rigid {
    let figure = limbs::figure();
    let mut rigid = Rigid::from(world);
    let places = places::places(side).map(|place| (place + Vec3::Y, Quat::IDENTITY));
    places.for_each(|place| insert(&mut rigid, &figure, place, false));
    rigid
}

fn floored() -> PhysicsWorld {
    let mut world = PhysicsWorld::new();
    let slab = ColliderBuilder::cuboid(FLOOR.x, FLOOR.y, FLOOR.z);
    world.insert_collider(slab.translation(vector(Vec3::NEG_Y * FLOOR.y)), None);
    world
}

/// Adds static boxes of given sizes at given positions.
fn fixed(world: &mut PhysicsWorld, boxes: impl Iterator<Item = (Vec3, Vec3)>) {
    for (size, place) in boxes {
        let half = 0.5 * size;
        let wall = ColliderBuilder::cuboid(half.x, half.y, half.z).translation(vector(place));
        world.insert_collider(wall, None);
    }
}

/// Adds a ragdoll at a position with a rotation.
fn insert(
    Rigid { world, lengths }: &mut Rigid,
    (limbs, joints): &(Vec<Limb>, Vec<LimbJoint>),
    (place, turn): (Vec3, Quat),
    sleeps: bool,
) {
    let body = |limb: &Limb| {
        let centre = vector(place + turn * limb.centre);
        let pose = rapier3d::math::Pose::from_parts(centre, turned(turn));
        let body = RigidBodyBuilder::dynamic().pose(pose).can_sleep(sleeps);
        let shape = match limb.form {
            Form::Capsule { half, radius } => {
                ColliderBuilder::capsule_from_endpoints(vector(-half), vector(half), radius)
            }
            Form::Cuboid { half } => ColliderBuilder::cuboid(half.x, half.y, half.z),
        };
        world.insert(body, shape.density(limbs::DENSITY)).0
    };
    let bodies: Vec<RigidBodyHandle> = limbs.iter().map(body).collect();
    for joint in joints {
        let [first, second] = joint.limbs.map(|limb| bodies[limb]);
        let [one, other] = joint.limbs.map(|limb| vector(joint.point - limbs[limb].centre));
        let handle = if joint.hinge {
            let joint = RevoluteJointBuilder::new(Vector::X).limits(limbs::LIMITS.1);
            let joint = joint.local_anchor1(one).local_anchor2(other).contacts_enabled(false);
            world.insert_impulse_joint(first, second, joint)
        } else {
            let axes = [JointAxis::AngX, JointAxis::AngY, JointAxis::AngZ];
            let joint = SphericalJointBuilder::new().local_anchor1(one).local_anchor2(other);
            let joint = joint.contacts_enabled(false);
            let limit = |joint: SphericalJointBuilder, axis| joint.limits(axis, limbs::LIMITS.0);
            world.insert_impulse_joint(first, second, axes.into_iter().fold(joint, limit))
        };
        lengths.push((handle, joint.length));
    }
}

fn vector(v: Vec3) -> Vector {
    Vector::from(v.to_array())
}

fn turned(q: Quat) -> Rotation {
    Rotation::from_xyzw(q.x, q.y, q.z, q.w)
}
