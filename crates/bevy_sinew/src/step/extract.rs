//! Extraction: what a game wants to know of a body, read off its particles after each tick.

use bevy::prelude::*;
use sinew::pose::{motion, pose};

use crate::components::{
    AngularVelocity, Barycenter, BodyParticles, ExtractedTransform, LinearVelocity, Particle,
    RigidPose,
};
use crate::rows::{GONE, Rows};
use crate::world::SinewWorld;

/// Writes the transform of everything that has a [`RigidPose`].
pub(crate) fn extract_poses(
    world: Res<SinewWorld>,
    mut posed: Query<(
        Ref<RigidPose>,
        &mut Rows<RigidPose>,
        &mut Transform,
        Option<&mut ExtractedTransform>,
    )>,
) {
    let (particles, tables) = (&world.simulation.particles, &world.tables);
    for (rigid, mut rows, mut transform, known) in &mut posed {
        let rows = rows.resolve(tables, rigid.is_changed(), rigid.particles.iter().copied());
        let points = rows.iter().zip(&rigid.rest).filter_map(|(&row, &rest)| {
            let i = row as usize;
            let sound = row != GONE && tables.refused[i].is_none();
            sound.then(|| (particles.position(i), rest, tables.mass[i]))
        });
        let Some(found) = pose(points, transform.rotation) else { continue };
        transform.translation = found.translation;
        transform.rotation = found.rotation;
        if let Some(mut known) = known {
            known.0 = Some(*transform);
        }
    }
}

/// Writes the velocities and the barycentre of every body that has particles.
pub(crate) fn extract_motion(
    world: Res<SinewWorld>,
    mut bodies: Query<(
        Ref<BodyParticles>,
        &mut Rows<BodyParticles>,
        &mut LinearVelocity,
        &mut AngularVelocity,
        &mut Barycenter,
    )>,
) {
    let (simulation, tables) = (&world.simulation, &world.tables);
    for (members, mut rows, mut linear, mut angular, mut barycenter) in &mut bodies {
        let rows = rows.resolve(tables, members.is_changed(), members.iter());
        let points = rows.iter().filter_map(|&row| {
            let i = row as usize;
            let sound = row != GONE && tables.refused[i].is_none();
            let position = || simulation.particles.position(i);
            sound.then(|| (position(), simulation.velocity_now(i), tables.mass[i]))
        });
        if let Some(found) = motion(points) {
            linear.0 = found.velocity;
            angular.0 = found.angular_velocity;
            barycenter.position = found.barycentre;
            barycenter.mass = found.mass;
        }
    }
}

/// Moves the transforms of loose particles that have one: a ball on its own is drawn where its particle is.
pub(crate) fn extract_particles(
    mut particles: Query<(&Particle, &mut Transform), Changed<Particle>>,
) {
    for (particle, mut transform) in &mut particles {
        if particle.position.is_finite() {
            transform.translation = particle.position;
        }
    }
}
