//! Joints turn within their limits and no farther, however hard they are hit.

use core::f32::consts::PI;

use super::*;
use crate::recipes::blueprint::checks::{assert_at_rest, excess};
use crate::{Plane, Simulation};

fn build(bones: Vec<Bone>) -> (Blueprint, Simulation) {
    let body = articulated(&ArticulatedSpec { bones, drag: 0.0 }).unwrap();
    assert_at_rest(&body);
    let mut world = Simulation::default();
    body.build(&mut world).unwrap();
    (body, world)
}

/// Largest deformation of a part, as a share of the length of the shortest bone.
fn bent(body: &Blueprint, world: &Simulation) -> f32 {
    let mut worst = 0.0_f32;
    for part in &body.parts {
        for (i, &a) in part.particles.iter().enumerate() {
            for (j, &b) in part.particles.iter().enumerate().skip(i + 1) {
                let [p, q] = [a, b].map(|k| world.particles.position(k as usize));
                worst = worst
                    .max((p.distance(q) - part.rest[i].distance(part.rest[j])).abs() / part.size.y);
            }
        }
    }
    worst
}

fn post() -> Bone {
    Bone { name: "post", head: Vec3::Y, tail: Vec3::ZERO, pinned: true, ..Bone::default() }
}

/// A post, and a bone joined to its foot.
fn hung(joint: Joint) -> Vec<Bone> {
    vec![post(), Bone { parent: Some(0), joint, ..Bone::default() }]
}

#[test]
fn bones_weigh_what_they_should_and_share_the_particles_of_their_joints() {
    let bones = vec![
        Bone { name: "upper", mass: 2.0, ..Bone::default() },
        Bone {
            name: "lower",
            parent: Some(0),
            head: Vec3::NEG_Y,
            tail: Vec3::new(0.3, -2.0, 0.0),
            mass: 3.0,
            joint: Joint::Hinge { axis: Vec3::Z * 5.0, min: 0.0, max: 2.0 },
            ..Bone::default()
        },
        Bone {
            name: "toe",
            parent: Some(1),
            head: Vec3::new(0.3, -2.0, 0.0),
            tail: Vec3::new(0.5, -2.0, 0.0),
            joint: Joint::Fixed,
            ..Bone::default()
        },
        Bone {
            name: "loose",
            parent: Some(0),
            head: Vec3::X,
            tail: Vec3::X * 2.0,
            joint: Joint::Free,
            ..Bone::default()
        },
    ];
    let (body, world) = build(bones);
    assert!((body.total_mass() - 7.0).abs() < 1e-5, "{}", body.total_mass());
    assert_eq!(
        body.parts.iter().map(|p| p.name).collect::<Vec<_>>(),
        ["upper", "lower", "toe", "loose"]
    );
    let shared = |a: usize, b: usize| {
        body.parts[a].particles.iter().filter(|i| body.parts[b].particles.contains(i)).count()
    };
    assert_eq!([shared(0, 1), shared(1, 2), shared(0, 3)], [2, 1, 0]);
    // Two merged pieces and a toe, one bone without a joint, and the hinge.
    assert_eq!(body.constraints.len(), 4);
    assert!(bent(&body, &world) < 1e-6 && excess(&world).0 < 1e-3);
    for part in &body.parts {
        assert!(part.rest[0].y > 0.0 && (part.rest[0] + part.rest[1]).length() < 1e-6, "{part:?}");
    }
}

#[test]
fn a_door_swings_between_its_stops_and_not_beyond() {
    let (min, max) = (f32::to_radians(-20.0), f32::to_radians(100.0));
    let joint = Joint::Hinge { axis: Vec3::Y, min, max };
    let mut bones = hung(joint);
    (bones[1].head, bones[1].tail) = (Vec3::Y * 0.5, Vec3::new(0.8, 0.5, 0.0));
    let (body, mut world) = build(bones);
    let tail = body.parts[1].particles[1] as usize;
    let (mut low, mut high, mut worst, mut fell) = (0.0_f32, 0.0_f32, 0.0_f32, 0.0_f32);
    for tick in 0..600 {
        if tick % 150 == 0 {
            // By the right-hand rule about y, x turns towards -z.
            let push = if tick % 300 == 0 { Vec3::NEG_Z } else { Vec3::Z };
            world.particles.add_impulse(tail, push * 2.0);
        }
        world.step(1.0 / 60.0).unwrap();
        let p = world.particles.position(tail);
        let angle = libm::atan2f(-p.z, p.x);
        (low, high) = (low.min(angle), high.max(angle));
        worst = worst.max(excess(&world).0);
        fell = fell.max((p.y - 0.5).abs());
    }
    println!(
        "a door: {:.2}° to {:.2}°, beyond its stops by {worst:.2}°, sags {fell:.1e} m",
        low * 180.0 / PI,
        high * 180.0 / PI
    );
    assert!(low < f32::to_radians(-19.0) && high > f32::to_radians(99.0), "it reaches both stops");
    assert!(worst < 1.0 && fell < 0.005, "{worst} {fell}");
}

#[test]
fn a_chain_of_five_bones_swings_down_and_hangs() {
    let mut bones = vec![post()];
    for k in 0..5 {
        let (head, tail) = (Vec3::X * (0.3 * k as f32), Vec3::X * (0.3 * (k + 1) as f32));
        bones.push(Bone { parent: Some(k), head, tail, width: 0.05, ..Bone::default() });
    }
    let body = articulated(&ArticulatedSpec { bones, drag: 0.8 }).unwrap();
    let mut world = Simulation::default();
    body.build(&mut world).unwrap();
    let mut worst = 0.0_f32;
    for _ in 0..480 {
        world.step(1.0 / 60.0).unwrap();
        worst = worst.max(bent(&body, &world));
    }
    let end = world.particles.position(body.parts[5].particles[1] as usize);
    println!("the end of the chain is at {end}; bones were bent by {worst:.1e} at most");
    assert!(end.distance(Vec3::NEG_Y * 1.5) < 0.02, "{end}");
    assert!(worst < 0.01, "{worst}");
}

#[test]
fn a_cone_and_a_twist_are_held_against_gravity_and_blows() {
    let joint = Joint::Ball { cone: f32::to_radians(30.0), twist: f32::to_radians(20.0) };
    let (body, mut world) = build(hung(joint));
    world.forces.gravity = Vec3::X * 9.81;
    let mut worst = 0.0_f32;
    let [head, tail, left, right] = [0, 1, 2, 3].map(|k| body.parts[1].particles[k] as usize);
    for tick in 0..300 {
        if tick % 30 == 0 {
            let across = world.particles.position(left) - world.particles.position(right);
            let along = world.particles.position(tail) - world.particles.position(head);
            let spin = across.cross(along).normalize() * 0.5;
            world.particles.add_impulse(left, spin);
            world.particles.add_impulse(right, -spin);
        }
        world.step(1.0 / 60.0).unwrap();
        worst = worst.max(excess(&world).0);
    }
    let hangs = world.particles.position(tail);
    let angle = libm::atan2f(hangs.x, -hangs.y) * 180.0 / PI;
    println!(
        "a cone of 30° is held at {angle:.2}°; with blows at the twist it yields by {worst:.2}°"
    );
    assert!((angle - 30.0).abs() < 1.0, "{angle}");
    assert!(worst < 2.0, "{worst}");
}

fn leg(pinned: bool) -> Vec<Bone> {
    // It may bend 10° forward, to gather speed, and bends backward, towards -z: by the right-hand rule about x, a hanging bone (-y) turns towards -z.
    let knee =
        Joint::Hinge { axis: Vec3::X, min: f32::to_radians(-10.0), max: f32::to_radians(150.0) };
    vec![
        Bone {
            name: "thigh",
            head: Vec3::Y,
            tail: Vec3::Y * 0.55,
            mass: 8.0,
            pinned,
            ..Bone::default()
        },
        Bone {
            name: "shin",
            parent: Some(0),
            head: Vec3::Y * 0.55,
            tail: Vec3::Y * 0.1,
            mass: 4.0,
            joint: knee,
            ..Bone::default()
        },
    ]
}

#[test]
fn a_knee_that_is_kicked_the_wrong_way_stays_at_its_limit() {
    for (pinned, speed) in [(true, 5.0), (true, 15.0), (false, 5.0), (false, 15.0)] {
        let (body, mut world) = build(leg(pinned));
        let [head, tail] = [0, 1].map(|k| body.parts[1].particles[k] as usize);
        world.forces.gravity = Vec3::ZERO;
        let foot = 1.0 / world.particles.inverse_mass(tail);
        world.particles.add_impulse(tail, Vec3::Z * (speed * foot));
        let (mut worst, mut ahead) = (0.0_f32, 0.0_f32);
        for _ in 0..120 {
            world.step(1.0 / 60.0).unwrap();
            worst = worst.max(excess(&world).0);
            let shin = world.particles.position(tail) - world.particles.position(head);
            ahead = ahead.max(if pinned { shin.z } else { 0.0 });
        }
        println!(
            "kicked at {speed} m/s, thigh held: {pinned}: {worst:.2}° beyond, {ahead:.4} m ahead; bent {:.1e}",
            bent(&body, &world)
        );
        assert!(worst < 1.0, "{worst}");
        assert!(!pinned || (0.07..0.09).contains(&ahead), "it goes to its stop: {ahead}");
    }
}

#[test]
fn whatever_is_done_to_them_bones_stay_finite_and_come_together_again() {
    let mut bones = leg(false);
    for k in 2..6 {
        let head = bones[k - 1].tail;
        let joint = Joint::Ball { cone: f32::to_radians(40.0), twist: f32::to_radians(30.0) };
        bones.push(Bone {
            parent: Some(k - 1),
            head,
            tail: head + Vec3::new(0.1, -0.2, 0.1),
            joint,
            ..Bone::default()
        });
    }
    let (body, mut world) = build(bones);
    world.boundaries.planes.push(Plane::ground(-1.0));
    // So that a bone that was hit stops spinning.
    world.forces.drag = 0.9;
    let mut worst = 0.0_f32;
    for tick in 0..600_u32 {
        if tick < 300 && tick % 20 == 0 {
            let i = (tick as usize * 7) % world.particles.len();
            let side = Vec3::new((tick % 3) as f32 - 1.0, 1.0, (tick % 5) as f32 - 2.0);
            world.particles.set_velocity(i, side * 200.0);
        }
        world.step(1.0 / 60.0).unwrap();
        assert!((0..world.particles.len()).all(|i| world.particles.position(i).is_finite()));
        worst = worst.max(excess(&world).0);
    }
    println!(
        "hit at 200 m/s: {worst:.1}° beyond at the worst, {:.2}° at the end; bent {:.1e}",
        excess(&world).0,
        bent(&body, &world)
    );
    assert!(excess(&world).0 < 1.0 && bent(&body, &world) < 0.01);
}

#[test]
fn what_is_no_skeleton_is_refused() {
    type Spoil = fn(&mut Bone);
    let cases: [(Spoil, RecipeFault); 10] = [
        (|b| b.parent = Some(1), RecipeFault::BoneParent(1)),
        (|b| b.tail = b.head, RecipeFault::BoneLength(1)),
        (|b| b.head.x = f32::NAN, RecipeFault::BoneLength(1)),
        (|b| b.head.x = 1e9, RecipeFault::BoneLength(1)),
        (|b| b.width = 0.0, RecipeFault::BoneWidth(1)),
        (|b| b.mass = f32::INFINITY, RecipeFault::BoneMass(1)),
        (|b| b.joint = Joint::Ball { cone: -1.0, twist: 1.0 }, RecipeFault::JointLimits(1)),
        (|b| b.joint = Joint::Ball { cone: 1.0, twist: f32::NAN }, RecipeFault::JointLimits(1)),
        (
            |b| b.joint = Joint::Hinge { axis: Vec3::X, min: 0.1, max: 1.0 },
            RecipeFault::JointLimits(1),
        ),
        (
            |b| b.joint = Joint::Hinge { axis: Vec3::ZERO, min: 0.0, max: 1.0 },
            RecipeFault::JointAxis(1),
        ),
    ];
    for (spoil, fault) in cases {
        let mut bones = hung(Joint::default());
        spoil(&mut bones[1]);
        assert_eq!(articulated(&ArticulatedSpec { bones, drag: 0.0 }), Err(fault));
    }
    assert_eq!(articulated(&ArticulatedSpec::default()), Err(RecipeFault::NoBones));
    let drag = ArticulatedSpec { bones: vec![post()], drag: f32::NAN };
    assert_eq!(articulated(&drag), Err(RecipeFault::Drag));
}
