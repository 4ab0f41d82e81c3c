//! Executes edits: copies the particles of the body, changes them as one, validates them, and writes them back unless an error was found.

use bevy::ecs::entity_disabling::Disabled;
use bevy::ecs::query::Allow;
use bevy::ecs::system::SystemParam;
use bevy::math::DVec3;
use bevy::prelude::*;
use sinew::pose::{Motion, motion};
use sinew::{ParticleSeed, Particles};

use super::{BodyEdit, PendingEdits};
use crate::carry::{Jump, Jumps, RigidMotion};
use crate::components::{
    AngularVelocity, BodyParticles, CreationOrder, DrawnTransform, ExtractedTransform,
    ExtractedVelocity, LinearVelocity, Mass, PartOf, Particle, ParticleBody, ParticleOf, Pinned,
    PinnedTo, RigidPose, TickForces,
};
use crate::frames::{to_local, world_transform};
use crate::messages::{EditFault, Refusal, Refused, refuse};

/// Executes an edit at once. Does nothing in a world without the plugin.
pub(super) fn run(world: &mut World, entity: Entity, edit: BodyEdit) {
    world.run_system_cached_with(edit_now, (entity, edit)).ok();
}

fn edit_now(
    In((entity, edit)): In<(Entity, BodyEdit)>,
    mut editor: Editor,
    mut messages: MessageWriter<Refused>,
    mut pending: Query<&mut PendingEdits>,
    mut forces: Query<&mut TickForces>,
    mut commands: Commands,
) {
    if let Some(pushed) = TickForces::of(edit) {
        let reason = match (editor.check(entity, edit), forces.get_mut(entity)) {
            (Err(fault), _) => fault,
            (Ok(()), Ok(mut sum)) => match sum.add(pushed) {
                Ok(()) => return,
                Err(fault) => fault,
            },
            (Ok(()), Err(_)) => {
                commands.entity(entity).try_insert(pushed);
                return;
            }
        };
        return refuse(&mut messages, entity, Refusal::Edit(reason));
    }
    let reason = match editor.apply_now(entity, edit) {
        Ok(true) => return,
        Ok(false) => match pending.get_mut(entity) {
            Ok(list) if list.0.len() >= PendingEdits::MAX => EditFault::TooMany,
            Ok(mut list) => return list.0.push(edit),
            Err(_) => {
                commands.entity(entity).try_insert(PendingEdits(vec![edit]));
                return;
            }
        },
        Err(fault) => fault,
    };
    refuse(&mut messages, entity, Refusal::Edit(reason));
}

impl TickForces {
    /// The forces of an edit; `None` for any other edit.
    fn of(edit: BodyEdit) -> Option<Self> {
        match edit {
            BodyEdit::Force(force) => Some(Self { force, ..default() }),
            BodyEdit::Torque(torque) => Some(Self { torque, ..default() }),
            BodyEdit::ForceAt(force, point) => {
                Some(Self { at_points: vec![(force, point)], ..default() })
            }
            _ => None,
        }
    }

    /// Adds other forces, unless they exceed the limit.
    fn add(&mut self, others: Self) -> Result<(), EditFault> {
        if self.at_points.len() + others.at_points.len() > Self::MAX {
            return Err(EditFault::TooMany);
        }
        self.force += others.force;
        self.torque += others.torque;
        self.at_points.extend(others.at_points);
        Ok(())
    }
}

/// Executes the edits that were issued before a body had particles, as soon as it has them.
pub(crate) fn apply_pending(
    mut pending: Query<(Entity, Option<&CreationOrder>, &mut PendingEdits)>,
    mut editor: Editor,
    mut messages: MessageWriter<Refused>,
) {
    let mut waiting: Vec<_> =
        pending.iter_mut().filter(|(.., edits)| !edits.0.is_empty()).collect();
    waiting.sort_by_key(|(entity, order, _)| (order.copied(), *entity));
    for (entity, _, mut edits) in waiting {
        while let Some(&edit) = edits.0.first() {
            match editor.apply(entity, edit) {
                Ok(false) => break,
                Ok(true) => {}
                Err(fault) => refuse(&mut messages, entity, Refusal::Edit(fault)),
            }
            edits.0.remove(0);
        }
    }
}

/// Everything that an edit reads and writes. A disabled body can be edited, too.
#[derive(SystemParam)]
pub(crate) struct Editor<'w, 's> {
    wholes: Query<
        'w,
        's,
        (
            Option<&'static BodyParticles>,
            Option<&'static RigidPose>,
            Has<ParticleBody>,
            Option<&'static mut ExtractedTransform>,
        ),
        (Without<Particle>, Allow<Disabled>),
    >,
    particles: Query<
        'w,
        's,
        (&'static mut Particle, &'static Mass, Has<Pinned>, Has<PinnedTo>),
        Allow<Disabled>,
    >,
    transforms: Query<'w, 's, &'static mut Transform, Allow<Disabled>>,
    drawn: Query<'w, 's, &'static DrawnTransform, Allow<Disabled>>,
    parents: Query<'w, 's, &'static ChildOf, Allow<Disabled>>,
    velocities: Query<
        'w,
        's,
        (
            &'static mut LinearVelocity,
            Option<&'static mut AngularVelocity>,
            &'static mut ExtractedVelocity,
        ),
        Allow<Disabled>,
    >,
    jumps: Option<ResMut<'w, Jumps>>,
    owners: Query<'w, 's, (Option<&'static PartOf>, Option<&'static ParticleOf>), Allow<Disabled>>,
}

impl Editor<'_, '_> {
    /// The error of an edit on an entity, if it has one.
    fn check(&self, target: Entity, edit: BodyEdit) -> Result<(), EditFault> {
        if !edit.is_valid() {
            return Err(EditFault::NotFinite);
        }
        let whole = self.wholes.get(target);
        let is_one = |(members, posed, is_body, _): (
            Option<&BodyParticles>,
            Option<&RigidPose>,
            bool,
            _,
        )| { members.is_some() || posed.is_some() || is_body };
        if self.particles.contains(target) || whole.is_ok_and(is_one) {
            Ok(())
        } else {
            Err(EditFault::NoParticles)
        }
    }

    /// Executes an edit between two ticks. Velocities that the game wrote before are applied first, as the next tick would do it: otherwise a jump would be lost
    /// when the running speed is set in the same frame. For the same reason the extracted velocities of the body follow the edit at once.
    fn apply_now(&mut self, target: Entity, edit: BodyEdit) -> Result<bool, EditFault> {
        self.check(target, edit)?;
        let body = match self.owners.get(target) {
            Ok((Some(&PartOf(body)), _) | (None, Some(&ParticleOf(body)))) => body,
            _ => target,
        };
        self.apply_written(body)?;
        let before = self.velocity(body);
        let done = self.apply(target, edit)?;
        if let (Some(before), Some(after)) = (before, self.velocity(body)) {
            self.note_velocity(body, before, after);
        }
        Ok(done)
    }

    /// Applies the velocities that the game wrote to a body since the last tick. Numbers that are not finite are left for the next tick, which refuses them.
    fn apply_written(&mut self, body: Entity) -> Result<(), EditFault> {
        let Ok((linear, angular, known)) = self.velocities.get(body) else { return Ok(()) };
        let now = (linear.0, angular.map_or(Vec3::ZERO, |angular| angular.0));
        if !(now.0.is_finite() && now.1.is_finite()) {
            return Ok(());
        }
        for written in BodyEdit::of_written(now, known.0).into_iter().flatten() {
            // A body that is not built yet has them as its initial velocities.
            if !self.apply(body, written)? {
                return Ok(());
            }
            if let Ok((.., mut known)) = self.velocities.get_mut(body) {
                known.0 = Some(now);
            }
        }
        Ok(())
    }

    /// The velocity and the angular velocity of all particles of a body with extracted velocities, and whether those of its free particles are of this instant.
    fn velocity(&self, body: Entity) -> Option<(Vec3, Vec3, bool)> {
        let (.., known) = self.velocities.get(body).ok()?;
        known.0?;
        let group = match self.wholes.get(body) {
            Ok((Some(members), ..)) => self.group(members.iter()),
            _ => self.group([body].into_iter()),
        };
        let (found, _) = group.motion(true)?;
        let is_free = |member: &&Member| !member.is_pinned;
        let mut free = group.valid.iter().filter(is_free);
        let is_instant = free.all(|member| member.particle.lag == 0.0);
        Some((found.velocity, found.angular_velocity, is_instant))
    }

    /// Updates the extracted velocities of a body by what an edit changed.
    fn note_velocity(
        &mut self,
        body: Entity,
        before: (Vec3, Vec3, bool),
        after: (Vec3, Vec3, bool),
    ) {
        let Ok((mut linear, angular, mut known)) = self.velocities.get_mut(body) else { return };
        let (velocity, spin, is_instant) = after;
        if (before.0, before.1) == (velocity, spin) {
            return;
        }
        // The extracted velocities are those of this instant, half a substep later than those of particles with a lag.
        linear.0 = if is_instant { velocity } else { linear.0 + (velocity - before.0) };
        let mut now = (linear.0, Vec3::ZERO);
        if let Some(mut angular) = angular {
            angular.0 = if is_instant { spin } else { angular.0 + (spin - before.1) };
            now.1 = angular.0;
        }
        known.0 = Some(now);
    }

    /// Executes an edit; on an error nothing changes. `Ok(false)` if the body has no particles yet.
    pub(crate) fn apply(&mut self, target: Entity, edit: BodyEdit) -> Result<bool, EditFault> {
        if !edit.is_valid() {
            return Err(EditFault::NotFinite);
        }
        if self.particles.contains(target) {
            let mut group = self.group([target].into_iter());
            group.edit_single(edit);
            return self.commit(&group).map(|()| true);
        }
        let whole = self.wholes.get(target).map_err(|_| EditFault::NoParticles)?;
        let (members, posed, is_body, known) = whole;
        let mut group = match (members, posed) {
            (Some(members), _) => self.group(members.iter()),
            (None, Some(posed)) => self.group(posed.particles.iter().copied()),
            (None, None) if is_body => return Ok(false),
            (None, None) => return Err(EditFault::NoParticles),
        };
        let known = known.and_then(|known| known.0);
        let own = self.own(target);
        let now = own.and_then(|own| self.place(target, own));
        // A teleport specifies the entity's own transform, which its parents then move elsewhere.
        let edit = match (edit, own) {
            (BodyEdit::Teleport(to), Some(own)) => {
                let to = self.place(target, to.with_scale(own.scale));
                BodyEdit::Teleport(to.ok_or(EditFault::NoTransform)?)
            }
            _ => edit,
        };
        // A `Transform` that the game has changed is applied first: the next tick would do it, but the edit may depend on the position.
        let moved = known.zip(now).and_then(|(old, new)| RigidMotion::between(&old, &new));
        if let Some(rigid_motion) = moved.filter(|_| known != now) {
            group.move_all(&rigid_motion);
        }
        let before = known.or(now);
        let mut frame = if moved.is_some() || known.is_none() { now } else { known };
        group.edit(edit, frame.as_mut())?;
        let moves =
            matches!(edit, BodyEdit::Teleport(_) | BodyEdit::Displace(_) | BodyEdit::Turn(_));
        if moves && frame.is_some_and(|frame| !frame.is_finite()) {
            return Err(EditFault::NotFinite);
        }
        self.commit(&group)?;
        if let (Some(jumps), Some((before, frame))) = (&mut self.jumps, before.zip(frame)) {
            let motion = RigidMotion::between(&before, &frame).filter(|to| !to.is_identity());
            jumps.0.extend(motion.map(|motion| Jump { body: target, motion, carried: false }));
        }
        if let Some(frame) = frame {
            self.leave(target, frame, moves, known.is_some());
        }
        Ok(true)
    }

    /// The transform of an entity at the end of the last tick, and with what the game has changed since; not where it is drawn between two ticks.
    fn own(&self, entity: Entity) -> Option<Transform> {
        let own = *self.transforms.get(entity).ok()?;
        Some(self.drawn.get(entity).map_or(own, |drawn| drawn.actual(own)))
    }

    /// The world transform of an entity whose own transform is `own`; `None` if its parents shear it.
    fn place(&self, entity: Entity, own: Transform) -> Option<Transform> {
        world_transform(own, entity, |entity| self.own(entity), &self.parents).ok()
    }

    /// Stores the new placement of an entity: its transform, if the edit `moves` it, and the extracted transform, if that is `known`.
    fn leave(&mut self, entity: Entity, frame: Transform, moves: bool, known: bool) {
        let mut place = Some(frame);
        if moves && let Some(above) = self.place(entity, Transform::IDENTITY) {
            let own = match self.transforms.get_mut(entity) {
                Ok(mut transform) if self.parents.contains(entity) => {
                    let own = to_local(&above, &frame).with_scale(transform.scale);
                    transform.set_if_neq(own);
                    own
                }
                Ok(mut transform) => {
                    transform.set_if_neq(frame);
                    frame
                }
                Err(_) => return,
            };
            place = self.place(entity, own);
        }
        if let (Ok((.., Some(mut its_known))), true) = (self.wholes.get_mut(entity), known) {
            its_known.set_if_neq(ExtractedTransform(place));
        }
    }

    /// Copies the particles that still exist.
    fn group(&self, members: impl Iterator<Item = Entity>) -> Group {
        let copy = |entity| {
            let (&particle, &Mass(mass), pinned, pinned_to) = self.particles.get(entity).ok()?;
            Some(Member { entity, particle, mass, is_pinned: pinned || pinned_to })
        };
        let valid = |member: &Member| member.as_free().fault().is_none();
        let (valid, invalid) = members.filter_map(copy).partition(valid);
        Group { valid, invalid }
    }

    fn commit(&mut self, group: &Group) -> Result<(), EditFault> {
        if group.valid.iter().any(|member| member.as_free().fault().is_some()) {
            return Err(EditFault::NotFinite);
        }
        for member in group.valid.iter().chain(&group.invalid) {
            if let Ok((mut particle, ..)) = self.particles.get_mut(member.entity) {
                particle.set_if_neq(member.particle);
            }
        }
        Ok(())
    }
}

/// Particles that are edited as one.
struct Group {
    valid: Vec<Member>,
    /// Particles that are set aside for an invalid number: they are not edited, but teleported with the others.
    invalid: Vec<Member>,
}

struct Member {
    entity: Entity,
    particle: Particle,
    /// Mass, kg, whether pinned or not.
    mass: f32,
    is_pinned: bool,
}

impl Member {
    /// The solver's data of the particle: infinite mass if it is pinned.
    fn seed(&self) -> ParticleSeed {
        if self.is_pinned { self.as_free().pinned() } else { self.as_free() }
    }

    fn as_free(&self) -> ParticleSeed {
        let Particle { position, remainder, velocity, lag } = self.particle;
        let seed = ParticleSeed::at(position).with_mass(self.mass);
        ParticleSeed { remainder, velocity, lag, ..seed }
    }
}

impl Group {
    /// Executes an edit on a body that has a `frame`, or none; a teleport moves the frame along.
    fn edit(&mut self, edit: BodyEdit, frame: Option<&mut Transform>) -> Result<(), EditFault> {
        match edit {
            // These act in the next tick, and are stored until then.
            BodyEdit::Force(_) | BodyEdit::ForceAt(..) | BodyEdit::Torque(_) => {}
            BodyEdit::Impulse(impulse) => self.push(|p, rows| p.apply_impulse(rows, impulse)),
            BodyEdit::ImpulseAt(impulse, point) => {
                self.push(|p, rows| p.apply_impulse_at(rows, impulse, point));
            }
            BodyEdit::AngularImpulse(impulse) => {
                self.push(|p, rows| p.apply_angular_impulse(rows, impulse));
            }
            BodyEdit::Motion(velocity, spin) => {
                self.push(|p, rows| p.set_motion(rows, velocity, spin));
            }
            BodyEdit::LinearVelocity(velocity) => {
                let Some((found, _)) = self.motion(false) else { return Ok(()) };
                for member in self.free() {
                    let own = member.particle.velocity;
                    member.particle.set_velocity(own + (velocity - found.velocity));
                }
            }
            BodyEdit::AngularVelocity(spin) => self.spin(spin),
            BodyEdit::Teleport(to) => {
                let frame = frame.ok_or(EditFault::NoTransform)?;
                let to = to.with_scale(frame.scale);
                self.move_all(&RigidMotion::between(frame, &to).ok_or(EditFault::NoTransform)?);
                *frame = to;
            }
            BodyEdit::Displace(by) => {
                self.all().for_each(|member| member.particle.displace(by));
                if let Some(frame) = frame {
                    frame.translation += by;
                }
            }
            BodyEdit::Turn(by) => {
                let Some((_, centre)) = self.motion(true) else { return Ok(()) };
                let rigid_motion = RigidMotion::about(centre, by).ok_or(EditFault::NotFinite)?;
                self.move_all(&rigid_motion);
                if let Some(frame) = frame {
                    rigid_motion.apply_to_frame(frame);
                }
            }
            BodyEdit::Reverse => self.free().for_each(|member| member.particle.reverse()),
        }
        Ok(())
    }

    /// Executes an edit on a single particle: a point, which has a position and a velocity, but no rotation.
    fn edit_single(&mut self, edit: BodyEdit) {
        let place = |group: &mut Self, to: Vec3| {
            group.all().for_each(|member| member.particle.teleport(to));
        };
        match edit {
            BodyEdit::Teleport(to) => place(self, to.translation),
            BodyEdit::Turn(_) | BodyEdit::AngularVelocity(_) => {}
            // The remaining edits need no frame, so none of them fails.
            _ => self.edit(edit, None).unwrap_or_default(),
        }
    }

    /// Applies an operation of the solver's columns to the particles' velocities.
    fn push(&mut self, push: impl FnOnce(&mut Particles, &[u32])) {
        let (mut columns, mut rows) = (Particles::default(), Vec::new());
        // None of these particles has a fault, so each gets a row.
        rows.extend(self.valid.iter().filter_map(|member| columns.push(member.seed()).ok()));
        if rows.len() < self.valid.len() {
            return;
        }
        push(&mut columns, &rows);
        for (i, member) in self.valid.iter_mut().enumerate().filter(|(_, member)| !member.is_pinned)
        {
            member.particle.velocity = columns.velocity(i);
            member.particle.lag = columns.lag(i);
        }
    }

    /// Adds the missing angular velocity. The lag is kept, because the velocity of the centre of mass is as old as before.
    fn spin(&mut self, spin: Vec3) {
        let Some((found, centre)) = self.motion(false) else { return };
        let missing = (spin - found.angular_velocity).as_dvec3();
        for member in self.free() {
            let turn = missing.cross(member.particle.exact() - centre);
            member.particle.velocity = (member.particle.velocity.as_dvec3() + turn).as_vec3();
        }
    }

    fn move_all(&mut self, rigid_motion: &RigidMotion) {
        self.all().for_each(|member| rigid_motion.apply(&mut member.particle));
    }

    fn all(&mut self) -> impl Iterator<Item = &mut Member> {
        self.valid.iter_mut().chain(&mut self.invalid)
    }

    fn free(&mut self) -> impl Iterator<Item = &mut Member> {
        self.valid.iter_mut().filter(|member| !member.is_pinned)
    }

    /// The rigid motion of the free particles, or of `all`, and their centre of mass in the world, metres.
    fn motion(&self, all: bool) -> Option<(Motion, DVec3)> {
        let near = self.valid.first()?.particle.position;
        let points = self.valid.iter().filter(|member| all || !member.is_pinned).map(|member| {
            let Particle { position, remainder, velocity, .. } = member.particle;
            ((position - near) + remainder, velocity, member.mass)
        });
        let found = motion(points)?;
        let centre = near.as_dvec3() + found.barycentre.as_dvec3();
        Some((found, centre))
    }
}
