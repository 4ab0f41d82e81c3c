//! Control forces at gather: what each acts on is looked up when that changed, what it does is told to the solver every tick.

use std::collections::BTreeSet;

use bevy::prelude::*;
use sinew::forces::Control;
use sinew::pose::Pose;

use super::pins::sound;
use crate::commands::EditFault;
use crate::components::{
    BodyParticles, ControlForce, CreationOrder, Particle, ParticleBody, ResolvedTarget, RigidPose,
};
use crate::messages::{Refusal, Refused};
use crate::rows::{GONE, Rows};
use crate::world::SinewWorld;

/// Which particles an entity stands for.
type Targets<'w, 's> = Query<
    'w,
    's,
    (Option<&'static BodyParticles>, Option<&'static RigidPose>, Has<ParticleBody>, Has<Particle>),
>;

/// Tells the solver of all control forces, in the order of their creation.
pub(crate) fn gather_controls(
    mut world: ResMut<SinewWorld>,
    mut messages: MessageWriter<Refused>,
    mut controls: Query<(
        Entity,
        &CreationOrder,
        &ControlForce,
        Option<&Name>,
        &mut Rows<ControlForce>,
        &mut ResolvedTarget,
    )>,
    regrouped: Query<(), Or<(Changed<BodyParticles>, Changed<RigidPose>)>>,
    mut ungrouped: RemovedComponents<BodyParticles>,
    targets: Targets,
    frames: Query<&Transform, (Or<(With<ParticleBody>, With<RigidPose>)>, Without<Particle>)>,
    mut broken: Local<BTreeSet<Entity>>,
    mut ordered: Local<Vec<(CreationOrder, Entity)>>,
) {
    let SinewWorld { simulation, tables } = &mut *world;
    let list = &mut simulation.forces.controls;
    // Read even if there are no controls, or they would pile up.
    let ungrouped = ungrouped.read().count() > 0;
    if controls.is_empty() {
        list.clear();
        broken.clear();
        return;
    }
    let regrouped = ungrouped || !regrouped.is_empty();
    broken.retain(|&entity| controls.contains(entity));

    ordered.clear();
    ordered.extend(controls.iter().map(|(entity, order, ..)| (*order, entity)));
    ordered.sort_unstable();
    let mut used = 0;
    for &(_, entity) in &*ordered {
        let Ok((_, _, control, name, mut rows, mut resolved)) = controls.get_mut(entity) else {
            continue;
        };
        let target = control.on.unwrap_or(entity);
        let changed = regrouped || resolved.0 != Some(target);
        resolved.0 = Some(target);
        // Asked only if it changed, so that a warm tick looks up no particle.
        let named = core::iter::once(target).flat_map(|target| particles_of(&targets, target));
        let rows = rows.resolve(tables, changed, named);

        // The lists of rows and the names are kept from tick to tick.
        if used == list.len() {
            list.push(Control::default());
        }
        let slot = &mut list[used];
        slot.name.clear();
        slot.name.push_str(name.map_or("", Name::as_str));
        let takes_part = |&row: &u32| row != GONE && tables.refused[row as usize].is_none();
        slot.rows.clear();
        slot.rows.extend(rows.iter().copied().filter(takes_part));
        let frame = if control.local { frames.get(target).ok() } else { None };
        let frame = frame
            .map_or(Pose::IDENTITY, |f| Pose { translation: f.translation, rotation: f.rotation });
        let turn = Pose { translation: Vec3::ZERO, ..frame };
        slot.force = turn.point(control.force);
        slot.torque = turn.point(control.torque);
        slot.point = control.point.map(|point| frame.point(point));

        let reason = if !slot.is_valid() {
            Some(EditFault::NotFinite)
        } else if rows.iter().all(|&row| row == GONE) && !waits(&targets, target) {
            Some(EditFault::NoParticles)
        } else {
            None
        };
        if sound(&mut broken, &mut messages, entity, reason.map(Refusal::Control)) {
            used += 1;
        }
    }
    list.truncate(used);
}

fn particles_of(targets: &Targets, target: Entity) -> Vec<Entity> {
    match targets.get(target) {
        Ok((_, _, _, true)) => vec![target],
        Ok((Some(members), ..)) => members.iter().collect(),
        Ok((_, Some(posed), ..)) => posed.particles.clone(),
        _ => Vec::new(),
    }
}

/// Whether what has no particles is a body that is yet to be built: that is no fault.
fn waits(targets: &Targets, target: Entity) -> bool {
    targets.get(target).is_ok_and(|(.., is_body, _)| is_body)
}
