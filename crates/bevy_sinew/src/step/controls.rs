//! Gathers control forces: the particles on which each acts are looked up when they change, its force is passed to the solver every tick. Forces and torques on
//! whole bodies, and those of the current tick, are passed in the same list.

use std::collections::BTreeSet;

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use sinew::forces::Control;
use sinew::pose::Pose;

use super::pins::check_once;
use crate::components::{
    BodyParticles, ControlForce, CreationOrder, ExternalForce, ExternalTorque, Particle,
    ParticleBody, ParticleRow, ResolvedTarget, RigidPose, TickForces, fill_sorted,
};
use crate::frames::Frames;
use crate::messages::{EditFault, Refusal, Refused};
use crate::rows::{GONE, ResolvedRows};
use crate::schedule::SinewClock;
use crate::targets::{Targets, particles_of, waits};
use crate::world::{SinewWorld, Tables};

/// Passes all control forces to the solver, in the order of their creation.
pub(crate) fn gather_controls(
    mut world: ResMut<SinewWorld>,
    mut messages: MessageWriter<Refused>,
    mut controls: Query<(
        Entity,
        &CreationOrder,
        &ControlForce,
        Option<&Name>,
        &mut ResolvedRows<ControlForce>,
        &mut ResolvedTarget,
    )>,
    regrouped: Query<(), Or<(Changed<BodyParticles>, Changed<RigidPose>)>>,
    mut ungrouped: RemovedComponents<BodyParticles>,
    targets: Targets,
    framed: Query<(), (Or<(With<ParticleBody>, With<RigidPose>)>, Without<Particle>)>,
    frames: Frames,
    mut body_forces: BodyForces,
    mut broken: Local<BTreeSet<Entity>>,
    mut ordered: Local<Vec<(CreationOrder, Entity)>>,
) {
    let SinewWorld { simulation, tables } = &mut *world;
    let list = &mut simulation.forces.controls;
    // Read even without controls, since unread messages would accumulate.
    let ungrouped = ungrouped.read().count() > 0;
    if controls.is_empty() && body_forces.is_empty() {
        list.clear();
        broken.clear();
        return;
    }
    let regrouped = ungrouped || !regrouped.is_empty();
    broken.retain(|&entity| controls.contains(entity) || body_forces.forced.contains(entity));

    fill_sorted(&mut ordered, controls.iter().map(|(entity, order, ..)| (*order, entity)));
    let mut used = 0;
    for &(_, entity) in &*ordered {
        let Ok((_, _, control, name, mut rows, mut resolved)) = controls.get_mut(entity) else {
            continue;
        };
        let target = control.on.unwrap_or(entity);
        let changed = regrouped || resolved.0 != Some(target);
        resolved.0 = Some(target);
        // Evaluated only if it changed, so that a warm tick looks up no particle.
        let named = core::iter::once(target).flat_map(|target| particles_of(&targets, target));
        let rows = rows.resolve(&tables.layout, changed, named);

        let slot = slot(list, used, tables, rows);
        slot.name.push_str(name.map_or("", Name::as_str));
        let in_frame = control.local && framed.contains(target);
        let frame = if in_frame { frames.of(target).ok() } else { None };
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
        if check_once(&mut broken, &mut messages, entity, reason.map(Refusal::Control)) {
            used += 1;
        }
    }
    body_forces.add_to(tables, (list, &mut used), &mut broken, &mut messages);
    list.truncate(used);
}

/// The control at an index, without a name, on those of the rows that exist and are not set aside. The allocations of names and rows are kept from tick to
/// tick.
fn slot<'a>(
    list: &'a mut Vec<Control>,
    used: usize,
    tables: &Tables,
    rows: &[u32],
) -> &'a mut Control {
    if used == list.len() {
        list.push(Control::default());
    }
    let slot = &mut list[used];
    slot.name.clear();
    slot.rows.clear();
    slot.rows.extend(rows.iter().filter(|&&row| tables.is_valid(row as usize)));
    slot
}

/// Clears the forces of the tick at its end.
pub(crate) fn drop_tick_forces(
    world: Res<SinewWorld>,
    clock: Res<SinewClock>,
    mut forces: Query<&mut TickForces>,
) {
    if clock.is_behind(&world) {
        for mut forces in &mut forces {
            forces.set_if_neq(TickForces::default());
        }
    }
}

/// Bodies and rigid parts with forces on the whole, and particles with forces of the tick.
#[derive(SystemParam)]
pub(crate) struct BodyForces<'w, 's> {
    forced: Query<'w, 's, Forced, WithBodyForces>,
    ordered: Local<'s, Vec<(Option<CreationOrder>, Entity)>>,
}

/// The forces on an entity, and its particles.
type Forced = (
    Entity,
    Option<&'static CreationOrder>,
    Option<(Ref<'static, BodyParticles>, &'static mut ResolvedRows<BodyParticles>)>,
    Option<(Ref<'static, RigidPose>, &'static mut ResolvedRows<RigidPose>)>,
    Option<&'static ParticleRow>,
    Option<&'static ExternalForce>,
    Option<&'static ExternalTorque>,
    Option<&'static TickForces>,
);

type WithBodyForces = Or<(
    (With<TickForces>, Or<(With<BodyParticles>, With<RigidPose>, With<ParticleRow>)>),
    (
        Or<(With<ExternalForce>, With<ExternalTorque>)>,
        Or<(With<BodyParticles>, With<RigidPose>)>,
        Without<Particle>,
    ),
)>;

impl BodyForces<'_, '_> {
    /// Whether there are none.
    fn is_empty(&self) -> bool {
        self.forced.is_empty()
    }

    /// Adds their forces, in the order of their creation; an entity with a number that is not finite is refused, and none of its forces acts.
    fn add_to(
        &mut self,
        tables: &Tables,
        (list, used): (&mut Vec<Control>, &mut usize),
        broken: &mut BTreeSet<Entity>,
        messages: &mut MessageWriter<Refused>,
    ) {
        let Self { forced, ordered } = self;
        fill_sorted(ordered, forced.iter().map(|(entity, order, ..)| (order.copied(), entity)));
        for &(_, entity) in &**ordered {
            let Ok((_, _, members, posed, row, force, torque, tick)) = forced.get_mut(entity)
            else {
                continue;
            };
            let particle = row.map(|row| [row.0]);
            let rows = match (members, posed, &particle) {
                (Some((members, rows)), ..) => {
                    rows.into_inner().resolve(&tables.layout, members.is_changed(), members.iter())
                }
                (None, Some((posed, rows)), _) => rows.into_inner().resolve(
                    &tables.layout,
                    posed.is_changed(),
                    posed.particles.iter().copied(),
                ),
                (None, None, Some(row)) => row,
                (None, None, None) => continue,
            };
            // The steady force on a single particle is a property of the particle.
            let force = force.filter(|_| particle.is_none()).map_or(Vec3::ZERO, |force| force.0);
            let torque = torque.map_or(Vec3::ZERO, |torque| torque.0);
            let nothing = TickForces::default();
            let tick = tick.unwrap_or(&nothing);
            let (first, mut valid) = (*used, true);
            let whole = (force + tick.force, torque + tick.torque, None);
            let points = tick.at_points.iter().map(|&(f, point)| (f, Vec3::ZERO, Some(point)));
            for (force, torque, point) in core::iter::once(whole).chain(points) {
                let slot = slot(list, *used, tables, rows);
                *used += 1;
                (slot.force, slot.torque, slot.point) = (force, torque, point);
                valid &= slot.is_valid();
            }
            let reason = (!valid).then_some(Refusal::Control(EditFault::NotFinite));
            if !check_once(broken, messages, entity, reason) {
                *used = first;
            }
        }
    }
}
