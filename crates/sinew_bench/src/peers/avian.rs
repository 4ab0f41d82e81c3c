//! The user scenes of rigid bodies in Avian, a physics engine for Bevy: an app with its plugins at default settings, but single-threaded.

use core::time::Duration;

use avian3d::prelude::*;
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use sinew::pose::Pose;

use super::limbs::{self, Form, Limb, LimbJoint};
use crate::measure::{Cube, TICK, World as Contender};
use crate::places;
use crate::row::Stretch;

/// Half the size of the floor slab, m.
const FLOOR: Vec3 = Vec3::new(200.0, 1.0, 200.0);

/// An app with rigid bodies.
pub(super) struct Avian {
    app: App,
    joints: Vec<Hung>,
}

/// A joint: its two bodies, its anchor in the frame of each, and the length of the bone that it attaches, metres.
struct Hung {
    bodies: [Entity; 2],
    anchors: [Vec3; 2],
    length: f64,
}

/// A thousand boxes that fall and may sleep, in rows or poured between four walls.
pub(super) fn pile(poured: bool) -> Avian {
    let mut avian = Avian::floored();
    if poured {
        avian.fix(places::pit());
    }
    for (place, turn) in places::pile(poured) {
        avian.cube(Transform::from_translation(place).with_rotation(turn));
    }
    avian
}

/// A thousand boxes that lie side by side, and may sleep or not.
pub(super) fn lying(sleep: bool) -> Avian {
    let mut avian = Avian::floored();
    for place in places::lying() {
        let cube = avian.cube(Transform::from_translation(place));
        if !sleep {
            avian.app.world_mut().entity_mut(cube).insert(SleepingDisabled);
        }
    }
    avian
}

/// A hundred ragdolls that may sleep, above stairs with steps of height `rise`, metres, and a floor.
pub(super) fn figures(rise: f32) -> Avian {
    let mut avian = Avian::floored();
    avian.fix(places::flight(rise));
    let figure = limbs::figure();
    places::figures(rise).for_each(|place| avian.figure(&figure, place));
    avian
}

impl Contender for Avian {
    fn tick(&mut self) {
        self.app.update();
    }

    /// Distance between the two anchors of each joint, relative to the length of the attached bone.
    fn stretch(&self) -> Option<Stretch> {
        let world = self.app.world();
        let gap = |hung: &Hung| {
            let [one, other] = [0, 1].map(|end| {
                let body = world.entity(hung.bodies[end]);
                Some(body.get::<Position>()?.0 + body.get::<Rotation>()?.0 * hung.anchors[end])
            });
            Some(f64::from(one?.distance(other?)) / hung.length)
        };
        (!self.joints.is_empty()).then(|| Stretch::of_shares(self.joints.iter().filter_map(gap)))
    }

    fn cubes(&self) -> Vec<Cube> {
        let world = self.app.world();
        let Some(mut bodies) =
            world.try_query::<(&RigidBody, &Position, &Rotation, &LinearVelocity)>()
        else {
            return Vec::new();
        };
        let cube = |(_, place, turn, velocity): (_, &Position, &Rotation, &LinearVelocity)| Cube {
            pose: Pose { translation: place.0, rotation: turn.0 },
            velocity: velocity.0,
        };
        bodies.iter(world).filter(|(body, ..)| body.is_dynamic()).map(cube).collect()
    }
}

impl Avian {
    fn floored() -> Self {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, AssetPlugin::default(), TransformPlugin));
        app.add_plugins(PhysicsPlugins::default());
        let tick = Duration::from_secs_f32(TICK);
        app.insert_resource(Time::<Fixed>::from_duration(tick));
        app.insert_resource(TimeUpdateStrategy::ManualDuration(tick));
        app.finish();
        app.cleanup();
        let mut avian = Self { app, joints: Vec::new() };
        avian.fix([(2.0 * FLOOR, Vec3::NEG_Y * FLOOR.y)].into_iter());
        avian
    }

    /// Adds static boxes of given sizes at given positions.
    fn fix(&mut self, boxes: impl Iterator<Item = (Vec3, Vec3)>) {
        for (size, place) in boxes {
            let shape = Collider::cuboid(size.x, size.y, size.z);
            self.app.world_mut().spawn((
                RigidBody::Static,
                shape,
                Transform::from_translation(place),
            ));
        }
    }

    fn cube(&mut self, place: Transform) -> Entity {
        let cube = (RigidBody::Dynamic, Collider::cuboid(1.0, 1.0, 1.0), place);
        self.app.world_mut().spawn(cube).id()
    }

    /// Adds a ragdoll at a position with a rotation.
    fn figure(
        &mut self,
        (limbs, joints): &(Vec<Limb>, Vec<LimbJoint>),
        (place, turn): (Vec3, Quat),
    ) {
        let world = self.app.world_mut();
        let mut body = |limb: &Limb| {
            let shape = match limb.form {
                Form::Capsule { half, radius } => Collider::capsule_endpoints(radius, -half, half),
                Form::Cuboid { half } => {
                    let size = 2.0 * half;
                    Collider::cuboid(size.x, size.y, size.z)
                }
            };
            let place = Transform::from_translation(place + turn * limb.centre).with_rotation(turn);
            world.spawn((RigidBody::Dynamic, shape, ColliderDensity(limbs::DENSITY), place)).id()
        };
        let bodies: Vec<Entity> = limbs.iter().map(&mut body).collect();
        for joint in joints {
            let ends = joint.limbs.map(|limb| bodies[limb]);
            let anchors = joint.limbs.map(|limb| joint.point - limbs[limb].centre);
            let ([first, second], [one, other]) = (ends, anchors);
            if joint.hinge {
                let [min, max] = limbs::LIMITS.1;
                let joint = RevoluteJoint::new(first, second).with_hinge_axis(Vec3::X);
                let joint = joint.with_local_anchor1(one).with_local_anchor2(other);
                world.spawn((joint.with_angle_limits(min, max), JointCollisionDisabled));
            } else {
                let [min, max] = limbs::LIMITS.0;
                let joint = SphericalJoint::new(first, second);
                let joint = joint.with_local_anchor1(one).with_local_anchor2(other);
                let joint = joint.with_swing_limits(min, max).with_twist_limits(min, max);
                world.spawn((joint, JointCollisionDisabled));
            }
            self.joints.push(Hung { bodies: ends, anchors, length: joint.length });
        }
    }
}
