//! Doing an edit: the particles of the body are copied, changed as one, looked at, and written back, or not if anything is wrong.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use sinew::pose::{Motion, motion};
use sinew::{ParticleSeed, Particles};

use super::{BodyEdit, PendingEdits};
use crate::carry::Carry;
use crate::components::{
    BodyParticles, CreationOrder, ExtractedTransform, Mass, Particle, ParticleBody, Pinned,
    PinnedTo, RigidPose, TickForces,
};
use crate::frames::{into, on_top};
use crate::messages::{EditFault, Refusal, Refused, refuse};

/// Does an edit at once. Without the plugin there is nobody to do it.
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
    let reason = match editor.apply(entity, edit) {
        Ok(true) => return,
        Ok(false) => match pending.get_mut(entity) {
            Ok(list) if list.0.len() >= PendingEdits::MOST => EditFault::TooMany,
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
    /// What an edit asks for, if it is a force.
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

    /// Adds others, unless they would be too many.
    fn add(&mut self, others: Self) -> Result<(), EditFault> {
        if self.at_points.len() + others.at_points.len() > Self::MOST {
            return Err(EditFault::TooMany);
        }
        self.force += others.force;
        self.torque += others.torque;
        self.at_points.extend(others.at_points);
        Ok(())
    }
}

/// Does what bodies were told before they had particles, as soon as they have.
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

/// All that an edit looks at and changes.
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
        Without<Particle>,
    >,
    particles: Query<'w, 's, (&'static mut Particle, &'static Mass, Has<Pinned>, Has<PinnedTo>)>,
    transforms: Query<'w, 's, &'static mut Transform>,
    parents: Query<'w, 's, &'static ChildOf>,
}

impl Editor<'_, '_> {
    /// What is wrong with an edit, or with asking it of an entity.
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

    /// Does an edit, or changes nothing. `Ok(false)` if the body has no particles yet.
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
        let own = self.transforms.get(target).ok().copied();
        let now = own.and_then(|own| self.place(target, own));
        // A teleport says where its transform is to be, which its parents then put elsewhere.
        let edit = match (edit, own) {
            (BodyEdit::Teleport(to), Some(own)) => {
                let to = self.place(target, to.with_scale(own.scale));
                BodyEdit::Teleport(to.ok_or(EditFault::NoTransform)?)
            }
            _ => edit,
        };
        // What somebody has moved goes there first: the next tick would do it, but the edit may ask where it is.
        let moved = known.zip(now).and_then(|(old, new)| Carry::between(&old, &new));
        if let Some(carry) = moved.filter(|_| known != now) {
            group.carry(&carry);
        }
        let mut frame = if moved.is_some() || known.is_none() { now } else { known };
        group.edit(edit, frame.as_mut())?;
        let moves =
            matches!(edit, BodyEdit::Teleport(_) | BodyEdit::Displace(_) | BodyEdit::Turn(_));
        if moves && frame.is_some_and(|frame| !frame.is_finite()) {
            return Err(EditFault::NotFinite);
        }
        self.commit(&group)?;
        if let Some(frame) = frame {
            self.leave(target, frame, moves, known.is_some());
        }
        Ok(true)
    }

    /// Where its parents put an entity whose transform is `own`; `None` if they shear it.
    fn place(&self, entity: Entity, own: Transform) -> Option<Transform> {
        let of = |entity| self.transforms.get(entity).ok().copied();
        on_top(own, entity, of, &self.parents).ok()
    }

    /// Leaves an entity somewhere in the world: writes its transform, if it `moves`, and where the simulation knows it to be, if that is `known`.
    fn leave(&mut self, entity: Entity, frame: Transform, moves: bool, known: bool) {
        let mut place = Some(frame);
        if moves && let Some(above) = self.place(entity, Transform::IDENTITY) {
            let own = match self.transforms.get_mut(entity) {
                Ok(mut transform) if self.parents.contains(entity) => {
                    let own = into(&above, &frame).with_scale(transform.scale);
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

    /// Copies of particles, without those that are gone.
    fn group(&self, members: impl Iterator<Item = Entity>) -> Group {
        let copy = |entity| {
            let (&particle, &Mass(mass), pinned, pinned_to) = self.particles.get(entity).ok()?;
            Some(Member { entity, particle, mass, held: pinned || pinned_to })
        };
        let sound = |member: &Member| member.as_free().fault().is_none();
        let (sound, faulty) = members.filter_map(copy).partition(sound);
        Group { sound, faulty }
    }

    fn commit(&mut self, group: &Group) -> Result<(), EditFault> {
        if group.sound.iter().any(|member| member.as_free().fault().is_some()) {
            return Err(EditFault::NotFinite);
        }
        for member in group.sound.iter().chain(&group.faulty) {
            if let Ok((mut particle, ..)) = self.particles.get_mut(member.entity) {
                particle.set_if_neq(member.particle);
            }
        }
        Ok(())
    }
}

/// Particles that are edited as one.
struct Group {
    sound: Vec<Member>,
    /// Set aside for a bad number: left alone, but a teleport does not leave them behind.
    faulty: Vec<Member>,
}

struct Member {
    entity: Entity,
    particle: Particle,
    /// kg, pinned or not.
    mass: f32,
    held: bool,
}

impl Member {
    /// As the solver has it: of infinite mass if it is pinned.
    fn seed(&self) -> ParticleSeed {
        if self.held { self.as_free().pinned() } else { self.as_free() }
    }

    fn as_free(&self) -> ParticleSeed {
        let Particle { position, remainder, velocity, lag } = self.particle;
        let seed = ParticleSeed::at(position).with_mass(self.mass);
        ParticleSeed { remainder, velocity, lag, ..seed }
    }
}

impl Group {
    /// On what has a frame, if it has one: a teleport moves it along.
    fn edit(&mut self, edit: BodyEdit, frame: Option<&mut Transform>) -> Result<(), EditFault> {
        match edit {
            // Those act in the next tick, and are kept until then.
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
                let Some(found) = self.motion(false) else { return Ok(()) };
                for member in self.free() {
                    let own = member.particle.velocity;
                    member.particle.set_velocity(own + (velocity - found.velocity));
                }
            }
            BodyEdit::AngularVelocity(spin) => self.spin(spin),
            BodyEdit::Teleport(to) => {
                let frame = frame.ok_or(EditFault::NoTransform)?;
                let to = to.with_scale(frame.scale);
                self.carry(&Carry::between(frame, &to).ok_or(EditFault::NoTransform)?);
                *frame = to;
            }
            BodyEdit::Displace(by) => {
                self.all().for_each(|member| member.particle.displace(by));
                if let Some(frame) = frame {
                    frame.translation += by;
                }
            }
            BodyEdit::Turn(by) => {
                let Some(found) = self.motion(true) else { return Ok(()) };
                let near = self.sound.first().map_or(Vec3::ZERO, |first| first.particle.position);
                let centre = near.as_dvec3() + found.barycentre.as_dvec3();
                let carry = Carry::about(centre, by).ok_or(EditFault::NotFinite)?;
                self.carry(&carry);
                if let Some(frame) = frame {
                    carry.take_frame(frame);
                }
            }
            BodyEdit::Reverse => self.free().for_each(|member| member.particle.reverse()),
        }
        Ok(())
    }

    /// On one particle, which is a point: it has a place and a velocity, and nothing that could turn.
    fn edit_single(&mut self, edit: BodyEdit) {
        let place = |group: &mut Self, to: Vec3| {
            group.all().for_each(|member| member.particle.teleport(to));
        };
        match edit {
            BodyEdit::Teleport(to) => place(self, to.translation),
            BodyEdit::Turn(_) | BodyEdit::AngularVelocity(_) => {}
            // It needs no frame for what is left, so nothing of it is refused.
            _ => self.edit(edit, None).unwrap_or_default(),
        }
    }

    /// Does to them what the solver's columns do to their rows, as far as velocities go.
    fn push(&mut self, push: impl FnOnce(&mut Particles, &[u32])) {
        let (mut columns, mut rows) = (Particles::default(), Vec::new());
        // Without a fault, as all here are, each has its row.
        rows.extend(self.sound.iter().filter_map(|member| columns.push(member.seed()).ok()));
        if rows.len() < self.sound.len() {
            return;
        }
        push(&mut columns, &rows);
        for (i, member) in self.sound.iter_mut().enumerate().filter(|(_, member)| !member.held) {
            member.particle.velocity = columns.velocity(i);
            member.particle.lag = columns.lag(i);
        }
    }

    /// Adds the spin that is missing. The lag stays: the barycentre's velocity is still as old as it was.
    fn spin(&mut self, spin: Vec3) {
        let Some(found) = self.motion(false) else { return };
        let missing = (spin - found.angular_velocity).as_dvec3();
        let near =
            self.sound.first().map_or(Vec3::ZERO, |first| first.particle.position).as_dvec3();
        let centre = near + found.barycentre.as_dvec3();
        for member in self.free() {
            let turn = missing.cross(member.particle.exact() - centre);
            member.particle.velocity = (member.particle.velocity.as_dvec3() + turn).as_vec3();
        }
    }

    fn carry(&mut self, carry: &Carry) {
        self.all().for_each(|member| carry.take(&mut member.particle));
    }

    fn all(&mut self) -> impl Iterator<Item = &mut Member> {
        self.sound.iter_mut().chain(&mut self.faulty)
    }

    fn free(&mut self) -> impl Iterator<Item = &mut Member> {
        self.sound.iter_mut().filter(|member| !member.held)
    }

    /// How those move together that can move, or all of them; the barycentre is relative to the first, wherever that is.
    fn motion(&self, all: bool) -> Option<Motion> {
        let near = self.sound.first()?.particle.position;
        let points = self.sound.iter().filter(|member| all || !member.held).map(|member| {
            let Particle { position, remainder, velocity, .. } = member.particle;
            ((position - near) + remainder, velocity, member.mass)
        });
        motion(points)
    }
}
