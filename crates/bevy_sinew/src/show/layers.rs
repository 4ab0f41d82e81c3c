//! Layers of debug lines for forces, angles, volumes and batches.

use bevy::prelude::*;
use sinew::ConstraintKind;
use sinew::constraints::{Patch, Volume};

use super::gizmo_config::SinewGizmoConfigGroup;
use crate::schedule::PhaseSteps;
use crate::world::SinewWorld;

const ANGLES: Color = Color::srgb(0.95, 0.4, 0.9);
const VOLUMES: Color = Color::srgb(0.25, 0.8, 0.65);

/// A colour for an index, so that consecutive ones differ: hues the golden angle apart.
pub(super) fn distinct(number: usize) -> Color {
    Color::hsl((number as f32 * 137.508).rem_euclid(360.0), 0.85, 0.6)
}

/// Draws the acceleration that each phase of the last substep added; in a phase step, their sum so far.
pub(super) fn draw_forces(
    mut gizmos: Gizmos<SinewGizmoConfigGroup>,
    world: Res<SinewWorld>,
    phases: Res<PhaseSteps>,
) {
    let particles = world.particles();
    let colors = SinewGizmoConfigGroup::FORCES.map(|(_, color)| color);
    let gravity = world.simulation().forces.gravity;
    let mut draw = |i: usize, acceleration: Vec3, color: Color| {
        let way = acceleration * SinewGizmoConfigGroup::METRES_PER_ACCELERATION;
        // An arrow shorter than a millimetre is not visible.
        if particles.inverse_mass(i) > 0.0 && way.length_squared() > 1e-6 && way.is_finite() {
            let at = particles.position(i);
            gizmos.arrow(at, at + way, color);
        }
    };
    if phases.shown().is_some() {
        (0..particles.len()).for_each(|i| draw(i, particles.acceleration(i), colors[0]));
        return;
    }
    let Some(forces) = &world.tables.forces else { return };
    for i in 0..particles.len() {
        let [own, rest @ ..] = forces.each_ref().map(|of| of.get(i).copied().unwrap_or_default());
        // The first phase sums up gravity and all forces that have no phase of their own; the weight is subtracted to tell them apart.
        let weight = gravity * particles.seed(i).gravity_scale;
        // A difference within round-off is no force.
        let own = if (own - weight).length() > 1e-4 * weight.length() {
            own - weight
        } else {
            Vec3::ZERO
        };
        [weight, own].into_iter().chain(rest).zip(colors).for_each(|(a, color)| draw(i, a, color));
    }
}

/// Draws angles with the arc between their arms, hinges with their axis, cones with their rim, bends across their edge.
pub(super) fn draw_angles(mut gizmos: Gizmos<SinewGizmoConfigGroup>, world: Res<SinewWorld>) {
    let particles = world.particles();
    for constraint in world.simulation().constraints() {
        if constraint.rows.iter().any(|&row| row as usize >= particles.len()) {
            continue;
        }
        let place = |i: usize| particles.position(constraint.rows[i] as usize);
        match (&constraint.kind, constraint.rows.len()) {
            (ConstraintKind::Angle(_), 3) => {
                let [a, joint, c] = [place(0), place(1), place(2)];
                let radius = 0.3 * joint.distance(a).min(joint.distance(c));
                gizmos.linestrip([a, joint, c], ANGLES);
                let [from, to] = [a, c].map(|end| (end - joint).normalize_or_zero());
                if radius > 1e-4 && from.cross(to).length_squared() > 1e-6 {
                    let [from, to] = [from, to].map(|way| joint + way * radius);
                    gizmos.short_arc_3d_between(joint, from, to, ANGLES);
                }
            }
            (ConstraintKind::Hinge(_), 4) => {
                let middle = place(1).midpoint(place(2));
                gizmos.line(place(1), place(2), ANGLES);
                gizmos.linestrip([place(0), middle, place(3)], ANGLES);
            }
            (ConstraintKind::Cone(cone), count @ 4..=5) => {
                let [o, x, y] = [place(0), place(1) - place(0), place(2) - place(0)];
                let (from, to) = if count == 5 { (place(3), place(4)) } else { (o, place(3)) };
                let axis = cone.axis.x * x + cone.axis.y * y + cone.axis.z * x.cross(y);
                let Some(axis) = axis.try_normalize() else { continue };
                let (sin, cos) = libm::sincosf(cone.max);
                let long = from.distance(to);
                let turn = Quat::from_rotation_arc(Vec3::Z, axis);
                let rim = Isometry3d::new(from + axis * (long * cos), turn);
                gizmos.line(from, to, ANGLES);
                gizmos.circle(rim, long * sin, ANGLES);
            }
            (ConstraintKind::Bend(_), 4) => {
                let middle = place(0).midpoint(place(1));
                gizmos.linestrip([place(2), middle, place(3)], ANGLES);
            }
            _ => {}
        }
    }
}

/// Draws the outlines of constraints on areas and volumes.
pub(super) fn draw_volumes(mut gizmos: Gizmos<SinewGizmoConfigGroup>, world: Res<SinewWorld>) {
    let particles = world.particles();
    for constraint in world.simulation().constraints() {
        if constraint.rows.iter().any(|&row| row as usize >= particles.len()) {
            continue;
        }
        let place = |i: usize| particles.position(constraint.rows[i] as usize);
        let count = constraint.rows.len();
        let mut outline = |corners: [usize; 3]| {
            let [a, b, c] = corners.map(place);
            gizmos.lineloop([a, b, c], VOLUMES);
        };
        match &constraint.kind {
            ConstraintKind::Area(_) if count == 3 => outline([0, 1, 2]),
            ConstraintKind::Tetrahedron(_) if count == 4 => {
                [[0, 1, 2], [0, 1, 3], [0, 2, 3]].into_iter().for_each(outline);
            }
            ConstraintKind::Patch(Patch { triangles, .. })
            | ConstraintKind::Volume(Volume { triangles, .. }) => {
                let triangles = triangles.iter().map(|t| t.map(|i| i as usize));
                triangles.filter(|t| t.iter().all(|&i| i < count)).for_each(outline);
            }
            _ => {}
        }
    }
}

/// Draws distances in a colour for each batch.
pub(super) fn draw_batches(mut gizmos: Gizmos<SinewGizmoConfigGroup>, world: Res<SinewWorld>) {
    let particles = world.particles();
    for (group, distance) in world.simulation().grouped_distances() {
        let [a, b] = [distance.a as usize, distance.b as usize];
        if a.max(b) < particles.len() {
            gizmos.line(particles.position(a), particles.position(b), distinct(group));
        }
    }
}
