//! Outlines of colliders as debug lines.

use core::f32::consts::TAU;

use bevy::prelude::*;

use super::gizmo_config::SinewGizmoConfigGroup;
use crate::components::{Collider, PlacedCollider, RigidPose, Sensor};

/// Number of segments of a circle.
const CIRCLE_SEGMENTS: u32 = 24;
/// Half the size of the drawn part of an infinite plane, metres.
const PLANE_HALF_SIZE: f32 = 5.0;

/// Draws static and kinematic colliders at their position in the last tick: grey, green for sensors, red if set aside; and those of rigid parts, blue.
pub(super) fn draw_colliders(
    mut gizmos: Gizmos<SinewGizmoConfigGroup>,
    colliders: Query<(&Collider, &PlacedCollider, &Transform, Has<Sensor>, Has<RigidPose>)>,
) {
    for (collider, placed, transform, sensor, part) in &colliders {
        let (at, color) = if part {
            (transform.with_scale(Vec3::ONE), Color::srgb(0.4, 0.5, 1.0))
        } else if placed.valid().is_none() {
            (placed.at, Color::srgb(1.0, 0.2, 0.2))
        } else if sensor {
            (placed.at, Color::srgb(0.3, 0.9, 0.5))
        } else {
            (placed.at, Color::srgb(0.7, 0.7, 0.7))
        };
        if at.is_finite() {
            outline(&mut gizmos, collider, at, color);
        }
    }
}

fn outline(
    gizmos: &mut Gizmos<SinewGizmoConfigGroup>,
    collider: &Collider,
    at: Transform,
    color: Color,
) {
    let point = |p: Vec3| at.transform_point(p);
    let boxed = |centre: Vec3, size: Vec3| Transform {
        translation: point(centre),
        scale: at.scale * size,
        ..at
    };
    let mut ring =
        |centre: Vec3, u: Vec3, v: Vec3| gizmos.lineloop(round(centre, u, v).map(point), color);
    let (x, y, z) = (Vec3::X, Vec3::Y, Vec3::Z);
    match *collider {
        Collider::HalfSpace => {
            gizmos.cube(
                boxed(Vec3::ZERO, Vec3::new(2.0 * PLANE_HALF_SIZE, 0.0, 2.0 * PLANE_HALF_SIZE)),
                color,
            );
            gizmos.line(point(Vec3::ZERO), point(y), color);
        }
        Collider::Sphere { radius: r } => {
            ring(Vec3::ZERO, x * r, y * r);
            ring(Vec3::ZERO, y * r, z * r);
            ring(Vec3::ZERO, z * r, x * r);
        }
        Collider::Cylinder { radius: r, height } => {
            let h = 0.5 * height;
            ring(y * h, x * r, z * r);
            ring(y * -h, x * r, z * r);
            for side in [x, -x, z, -z] {
                gizmos.line(point(side * r + y * h), point(side * r - y * h), color);
            }
        }
        Collider::Capsule { radius: r, length } => {
            let h = 0.5 * length;
            ring(y * h, x * r, z * r);
            ring(y * -h, x * r, z * r);
            for side in [x, z] {
                // A circle whose upper half is moved up and whose lower half is moved down.
                let apart = move |p: Vec3| p + y * if p.y >= 0.0 { h } else { -h };
                gizmos.lineloop(round(Vec3::ZERO, side * r, y * r).map(apart).map(point), color);
            }
        }
        Collider::Box { size } | Collider::InsideBox { size } => {
            gizmos.cube(boxed(Vec3::ZERO, size), color);
        }
        Collider::Shape(ref shape) => {
            let (low, high) = shape.0.bounds();
            gizmos.cube(boxed((low + high) * 0.5, high - low), color);
        }
    }
}

/// Points on an ellipse, from its centre and two semi-axes.
fn round(centre: Vec3, u: Vec3, v: Vec3) -> impl Iterator<Item = Vec3> {
    (0..CIRCLE_SEGMENTS).map(move |i| {
        let turn = TAU * i as f32 / CIRCLE_SEGMENTS as f32;
        centre + u * libm::cosf(turn) + v * libm::sinf(turn)
    })
}
