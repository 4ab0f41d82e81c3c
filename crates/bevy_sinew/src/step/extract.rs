//! Extraction: transforms, velocities and other aggregates of a body, computed from its particles after each tick.

use bevy::ecs::entity_disabling::Disabled;
use bevy::ecs::query::Allow;
use bevy::math::Affine3A;
use bevy::prelude::*;
use sinew::pose::{Pose, pose};

use crate::components::{
    AngularVelocity, BodyParticles, BodyReport, ExtractedTransform, ExtractedVelocity, Inertia,
    Interpolate, LinearVelocity, Particle, ParticleRow, RigidPose, WorldCenterOfMass, fill_sorted,
};
use crate::frames::{to_local, world_transform};
use crate::rows::{GONE, ResolvedRows};
use crate::schedule::FixedTick;
use crate::world::SinewWorld;

/// A pose and its rows.
type Posed = (Ref<'static, RigidPose>, &'static mut ResolvedRows<RigidPose>);

/// Writes the transform of every entity with a [`RigidPose`], relative to its parent. Parents are written first.
pub(crate) fn extract_poses(
    world: Res<SinewWorld>,
    mut roots: ParamSet<(
        Query<
            (Posed, &mut Transform, Option<&mut ExtractedTransform>, Has<Interpolate>),
            Without<ChildOf>,
        >,
        Query<&mut Transform, Allow<Disabled>>,
    )>,
    mut children: Query<
        (Entity, Posed, Option<&mut ExtractedTransform>, Has<Interpolate>),
        With<ChildOf>,
    >,
    parents: Query<&ChildOf, Allow<Disabled>>,
    fixed_tick: Res<FixedTick>,
    mut order: Local<Vec<(usize, Entity)>>,
) {
    if world.tables.rested {
        return;
    }
    // While time is paused nothing moves: a pose that is computed again may differ in its last digits, but it is the same pose.
    let stands = fixed_tick.remaining == 0;
    let stays = |known: Option<&ExtractedTransform>, found: &Pose| {
        let known = known.and_then(|known| known.0);
        known.filter(|known| stands && is_at(known, found))
    };
    for ((rigid, mut rows), mut transform, known, eased) in &mut roots.p0() {
        let here = rows.current(&world.tables.layout);
        if !eased && !rigid.is_changed() && world.are_unmoved(here) {
            continue;
        }
        let at_hand = rows.collider.and_then(|number| world.rigid_pose(number, transform.rotation));
        let found = at_hand.or_else(|| found(&world, &rigid, &mut rows, transform.rotation));
        let Some(found) = found else { continue };
        // The pose of a sleeping body may differ in its last digits, which depend on the previous one. It is kept, whether the previous pose is known or was
        // restored.
        let is_known = known.as_ref().is_none_or(|known| known.0 == Some(*transform));
        if !eased && is_known && is_at(&transform, &found) && world.slept_through(rows.get()) {
            continue;
        }
        if let Some(known) = stays(known.as_deref(), &found) {
            transform.set_if_neq(known);
            continue;
        }
        transform.translation = found.translation;
        transform.rotation = found.rotation;
        if let Some(mut known) = known {
            known.0 = Some(*transform);
        }
    }
    if children.is_empty() {
        return;
    }
    let depth = |child| parents.iter_ancestors(child).count();
    fill_sorted(&mut order, children.iter().map(|(child, ..)| (depth(child), child)));
    let mut transforms = roots.p1();
    for &(_, child) in &*order {
        let Ok((_, (rigid, mut rows), known, eased)) = children.get_mut(child) else { continue };
        // If a parent had moved, the body would have been moved along.
        if !eased && !rigid.is_changed() && world.are_unmoved(rows.current(&world.tables.layout)) {
            continue;
        }
        let of = |entity| transforms.get(entity).ok().copied();
        let Ok(above) = world_transform(Transform::IDENTITY, child, of, &parents) else { continue };
        let Some(own) = of(child) else { continue };
        let before = above.rotation * own.rotation;
        let Some(found) = found(&world, &rigid, &mut rows, before) else { continue };
        let is_there =
            known.as_deref().and_then(|known| known.0).is_some_and(|known| is_at(&known, &found));
        if !eased && is_there && world.slept_through(rows.get()) {
            continue;
        }
        if stays(known.as_deref(), &found).is_some() {
            continue;
        }
        let place = Transform { translation: found.translation, rotation: found.rotation, ..own };
        let own = to_local(&above, &place);
        if let Ok(mut transform) = transforms.get_mut(child) {
            *transform = own;
        }
        if let Some(mut known) = known {
            // Stored as it will be computed in the next tick, to the last bit, if the entity is not moved.
            let of = |entity| transforms.get(entity).ok().copied();
            known.0 = world_transform(own, child, of, &parents).ok();
        }
    }
}

/// Writes the poses of bodies and loose particles in a [phase that is shown](crate::PhaseSteps), for the renderer only: the components have the state at the
/// end of the tick.
pub(crate) fn show_poses(
    world: Res<SinewWorld>,
    mut bodies: Query<(Entity, Ref<RigidPose>, &mut ResolvedRows<RigidPose>, &Transform)>,
    loose: Query<(Entity, &ParticleRow), (With<Particle>, With<GlobalTransform>)>,
    children: Query<&Children>,
    mut globals: Query<&mut GlobalTransform>,
) {
    let mut put = |entity: Entity, place: Vec3, rotation: Option<Quat>| {
        let Ok(old) = globals.get(entity).copied() else { return };
        let (scale, turned, _) = old.to_scale_rotation_translation();
        let rotation = rotation.unwrap_or(turned);
        let new = GlobalTransform::from(Affine3A::from_scale_rotation_translation(
            scale, rotation, place,
        ));
        // Its descendants move along.
        let along = new.affine() * old.affine().inverse();
        if !along.is_finite() {
            return;
        }
        for entity in core::iter::once(entity).chain(children.iter_descendants(entity)) {
            if let Ok(mut global) = globals.get_mut(entity) {
                *global = GlobalTransform::from(along * global.affine());
            }
        }
    };
    for (entity, rigid, mut rows, transform) in &mut bodies {
        if let Some(found) = found(&world, &rigid, &mut rows, transform.rotation) {
            put(entity, found.translation, Some(found.rotation));
        }
    }
    for (entity, row) in &loose {
        if let Some(row) = row.within(world.particles()) {
            put(entity, world.particles().position(row), None);
        }
    }
}

/// Whether a transform equals a pose within round-off.
fn is_at(transform: &Transform, pose: &Pose) -> bool {
    let off = (transform.translation - pose.translation).abs().max_element();
    let turned = Vec4::from(transform.rotation) - Vec4::from(pose.rotation);
    let digits = 1e-6 * pose.translation.abs().max_element();
    off <= digits.max(1e-5) && turned.abs().max_element() <= 1e-5
}

/// The pose of the particles in the world, with the rotation near the previous one (`before`); `None` if none of the particles exists.
fn found(
    world: &SinewWorld,
    rigid: &Ref<RigidPose>,
    rows: &mut ResolvedRows<RigidPose>,
    before: Quat,
) -> Option<Pose> {
    let (particles, tables) = (&world.simulation.particles, &world.tables);
    let rows = rows.resolve(&tables.layout, rigid.is_changed(), rigid.particles.iter().copied());
    let valid = |row: u32| tables.is_valid(row as usize);
    // Relative to a nearby point: far from the origin, world positions do not have enough digits for a rotation.
    let &first = rows.iter().find(|&&row| valid(row))?;
    let near = particles.position(first as usize);
    let points = rows.iter().zip(&rigid.rest).filter_map(|(&row, &rest)| {
        let i = row as usize;
        valid(row).then(|| (particles.relative_to(i, near), rest, tables.mass[i]))
    });
    let found = pose(points, before)?;
    Some(Pose { translation: near + found.translation, ..found })
}

/// Writes the velocities, the centre of mass and the inertia of every body with particles.
///
/// While time is paused, velocities are kept unless one of the particles was changed: the solver's accelerations belong to the last step, not to a state that a
/// snapshot has restored.
pub(crate) fn extract_motion(
    world: Res<SinewWorld>,
    particles: Query<Ref<Particle>>,
    mut bodies: Query<(
        Ref<BodyParticles>,
        &mut ResolvedRows<BodyParticles>,
        &mut LinearVelocity,
        &mut AngularVelocity,
        &mut ExtractedVelocity,
        &mut WorldCenterOfMass,
        &mut Inertia,
        Option<&ResolvedRows<RigidPose>>,
    )>,
) {
    let (simulation, tables) = (&world.simulation, &world.tables);
    if tables.rested {
        return;
    }
    for (
        members,
        mut rows,
        mut linear,
        mut angular,
        mut known,
        mut barycenter,
        mut inertia,
        part,
    ) in &mut bodies
    {
        if !members.is_changed() && world.are_unmoved(rows.current(&tables.layout)) {
            continue;
        }
        let rows = rows.resolve(&tables.layout, members.is_changed(), members.iter());
        let is_written = |entity| particles.get(entity).is_ok_and(|one| one.is_changed());
        let moves = tables.stepped || is_stale(&known, || members.iter().any(is_written));
        // If the body is one rigid part, its motion is that of the part.
        let at_hand = part
            .filter(|part| part.current(&tables.layout) == rows)
            .and_then(|part| world.rigid_motion(part.collider?));
        let found = at_hand.or_else(|| {
            let there = rows.iter().filter(|&&row| tables.is_valid(row as usize));
            simulation.motion(there.map(|&row| (row, tables.mass[row as usize])))
        });
        if let Some(found) = found {
            if moves {
                linear.0 = found.velocity;
                angular.0 = found.angular_velocity;
                known.0 = Some((found.velocity, found.angular_velocity));
            }
            barycenter.position = found.barycentre;
            barycenter.mass = found.mass;
            inertia.0 = found.inertia;
        }
    }
}

/// Writes the velocities of single particles that have a [`LinearVelocity`].
pub(crate) fn extract_particle_velocities(
    world: Res<SinewWorld>,
    mut particles: Query<
        (Ref<Particle>, &ParticleRow, &mut LinearVelocity, &mut ExtractedVelocity),
        Without<BodyParticles>,
    >,
) {
    let (simulation, tables) = (&world.simulation, &world.tables);
    if tables.rested {
        return;
    }
    for (particle, row, mut linear, mut known) in &mut particles {
        let Some(i) = row.get().filter(|&row| tables.is_valid(row)) else { continue };
        if !tables.stepped && !is_stale(&known, || particle.is_changed()) {
            continue;
        }
        let velocity = simulation.velocity_now(i);
        linear.0 = velocity;
        known.0 = Some((velocity, Vec3::ZERO));
    }
}

/// While time is paused, whether the stored velocities are out of date: there are none, or particles were written without the velocities, as when a snapshot is
/// restored.
fn is_stale(known: &Mut<ExtractedVelocity>, mut is_written: impl FnMut() -> bool) -> bool {
    known.0.is_none() || !known.is_changed() && is_written()
}

/// Writes the transforms of loose particles that have one, relative to their parent: a mesh on the same entity is drawn at the particle.
pub(crate) fn extract_particles(
    mut particles: ParamSet<(
        Query<(&Particle, &mut Transform), (Changed<Particle>, Without<ChildOf>)>,
        Query<&mut Transform, Allow<Disabled>>,
    )>,
    children: Query<(Entity, &Particle), (With<Transform>, With<ChildOf>)>,
    parents: Query<&ChildOf, Allow<Disabled>>,
) {
    for (particle, mut transform) in &mut particles.p0() {
        if particle.position.is_finite() {
            transform.translation = particle.position;
        }
    }
    let mut transforms = particles.p1();
    for (child, particle) in &children {
        let of = |entity| transforms.get(entity).ok().copied();
        let above = world_transform(Transform::IDENTITY, child, of, &parents);
        let at = Transform::from_translation(particle.position);
        let place = above.map(|above| to_local(&above, &at).translation);
        // If the parent is sheared, no transform of the child expresses its position.
        if let (Ok(place), Ok(mut transform)) = (place, transforms.get_mut(child))
            && place.is_finite()
        {
            transform.translation = place;
        }
    }
}

/// Writes the reports of the bodies with a [`BodyReport`].
pub(crate) fn extract_reports(
    world: Res<SinewWorld>,
    mut bodies: Query<(Ref<BodyParticles>, &mut ResolvedRows<BodyParticles>, &mut BodyReport)>,
) {
    for (members, mut rows, mut report) in &mut bodies {
        let rows = rows.resolve(&world.tables.layout, members.is_changed(), members.iter());
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
