//! Extraction: what a game wants to know of a body, read off its particles after each tick.

use bevy::prelude::*;
use sinew::pose::{motion, pose};

use crate::components::{
    AngularVelocity, Barycenter, BodyParticles, BodyReport, ExtractedTransform, Inertia,
    LinearVelocity, Particle, RigidPose,
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
        let sound = |row: u32| row != GONE && tables.refused[row as usize].is_none();
        // Relative to a point near them: far out, positions in the world have no digits for how a body is turned.
        let Some(&first) = rows.iter().find(|&&row| sound(row)) else { continue };
        let near = particles.position(first as usize);
        let points = rows.iter().zip(&rigid.rest).filter_map(|(&row, &rest)| {
            let i = row as usize;
            sound(row).then(|| (particles.relative_to(i, near), rest, tables.mass[i]))
        });
        let Some(found) = pose(points, transform.rotation) else { continue };
        transform.translation = near + found.translation;
        transform.rotation = found.rotation;
        if let Some(mut known) = known {
            known.0 = Some(*transform);
        }
    }
}

/// Writes the velocities, the barycentre and the inertia of every body that has particles.
pub(crate) fn extract_motion(
    world: Res<SinewWorld>,
    mut bodies: Query<(
        Ref<BodyParticles>,
        &mut Rows<BodyParticles>,
        &mut LinearVelocity,
        &mut AngularVelocity,
        &mut Barycenter,
        &mut Inertia,
    )>,
) {
    let (simulation, tables) = (&world.simulation, &world.tables);
    for (members, mut rows, mut linear, mut angular, mut barycenter, mut inertia) in &mut bodies {
        let rows = rows.resolve(tables, members.is_changed(), members.iter());
        let sound = |row: u32| row != GONE && tables.refused[row as usize].is_none();
        let Some(&first) = rows.iter().find(|&&row| sound(row)) else { continue };
        let near = simulation.particles.position(first as usize);
        let points = rows.iter().filter(|&&row| sound(row)).map(|&row| {
            let i = row as usize;
            let position = simulation.particles.relative_to(i, near);
            (position, simulation.velocity_now(i), tables.mass[i])
        });
        if let Some(found) = motion(points) {
            linear.0 = found.velocity;
            angular.0 = found.angular_velocity;
            barycenter.position = near + found.barycentre;
            barycenter.mass = found.mass;
            inertia.0 = found.inertia;
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

/// Fills the reports of the bodies that ask for one.
pub(crate) fn extract_reports(
    world: Res<SinewWorld>,
    mut bodies: Query<(Ref<BodyParticles>, &mut Rows<BodyParticles>, &mut BodyReport)>,
) {
    for (members, mut rows, mut report) in &mut bodies {
        let rows = rows.resolve(&world.tables, members.is_changed(), members.iter());
        let Some(&first) = rows.iter().find(|&&row| row != GONE) else { continue };
        let Some(island) = world.simulation.island_report(first as usize) else { continue };
        *report = BodyReport {
            sweeps: island.sweeps,
            converged: island.converged,
            fallbacks: island.fallbacks,
            error: island.error,
            strain: island.strain,
            seconds: island.seconds,
        };
    }
}
