//! Forces, impulses, velocities, teleports and reversal as commands: on a whole body, on a rigid part of one, or on a single particle.
//!
//! A body stores no velocity; its particles do. A command therefore distributes a change of the whole to the particles as a rigid body would receive it
//! ([`sinew::Particles`] has the arithmetic), and writes nothing but [`Particle`](crate::Particle)s and, for a teleport, the body's `Transform`. It takes
//! effect where commands are applied, not at the next tick: the second of two commands starts from the result of the first.

mod edit;
mod editor;
mod relax;

pub use edit::BodyEdit;
pub use relax::{Relax, RelaxFinished, RelaxWorld, SinewCommandsExt};

use bevy::prelude::*;

use editor::run;
pub(crate) use editor::{Editor, apply_pending};
pub(crate) use relax::{any_relax, run_relax};

/// Commands that push, move, turn and reverse bodies and particles.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// fn shoot(mut commands: Commands) {
///     // It takes effect when the body is built.
///     commands
///         .spawn((RigidBox::new(Vec3::splat(0.3)), Transform::from_xyz(0.0, 1.0, 0.0)))
///         .apply_impulse(Vec3::new(4.0, 0.0, 0.0))
///         .set_angular_velocity(Vec3::Y * 3.0);
/// }
/// # let mut app = App::new();
/// # app.add_plugins((MinimalPlugins, SinewPlugins)).add_systems(Startup, shoot);
/// # app.finish();
/// # app.update();
/// ```
///
/// The entity is a body, an entity with a [`RigidPose`](crate::RigidPose) (the head of a ragdoll), or a particle. Commands on a body that is not built yet are
/// executed in the tick in which it is ([`PendingEdits`]). [Pinned](crate::Pinned) particles are not affected, except that a teleport moves them along;
/// particles that are set aside for an invalid number are not affected either.
///
/// A command that cannot be executed changes nothing and is refused with one [`Refused`](crate::Refused) message ([`EditFault`](crate::EditFault) is the
/// reason). A command on an entity that no longer exists is ignored.
///
/// A velocity that the game wrote to [`LinearVelocity`](crate::LinearVelocity) or [`AngularVelocity`](crate::AngularVelocity) before counts as set before the
/// command, and both follow the command at once. The other extracted components of the body are updated in the next tick.
pub trait BodyCommandsExt {
    /// Executes one edit. All other methods but [`relax`](Self::relax) call it.
    fn edit_body(&mut self, edit: BodyEdit) -> &mut Self;

    /// Moves the body to its rest state in the next tick: inserts a [`Relax`], which describes it.
    fn relax(&mut self) -> &mut Self;

    /// Applies a force at the centre of mass, N, for the next tick only; several add up. For a steady force use [`ExternalForce`](crate::ExternalForce).
    fn apply_force(&mut self, force: Vec3) -> &mut Self {
        self.edit_body(BodyEdit::Force(force))
    }

    /// Applies a force, N, at a point of the world, metres, for the next tick only: as at the centre of mass, and with the torque of its lever.
    fn apply_force_at(&mut self, force: Vec3, point: Vec3) -> &mut Self {
        self.edit_body(BodyEdit::ForceAt(force, point))
    }

    /// Applies a torque, N·m, for the next tick only. For a steady torque use [`ExternalTorque`](crate::ExternalTorque).
    fn apply_torque(&mut self, torque: Vec3) -> &mut Self {
        self.edit_body(BodyEdit::Torque(torque))
    }

    /// Applies an impulse at the centre of mass, N·s: the velocity of all particles changes by the same amount, and the momentum of the body by exactly the
    /// impulse.
    fn apply_impulse(&mut self, impulse: Vec3) -> &mut Self {
        self.edit_body(BodyEdit::Impulse(impulse))
    }

    /// Applies an impulse, N·s, at a point of the world, metres: as at the centre of mass, and with the spin that its lever gives. The point need not be on the
    /// body. A single particle has no lever.
    fn apply_impulse_at(&mut self, impulse: Vec3, point: Vec3) -> &mut Self {
        self.edit_body(BodyEdit::ImpulseAt(impulse, point))
    }

    /// Applies an angular impulse about the centre of mass, N·m·s: the angular momentum changes by exactly that, the momentum does not change. A part that
    /// would turn a line about itself, or a single particle, has no effect.
    fn apply_angular_impulse(&mut self, angular_impulse: Vec3) -> &mut Self {
        self.edit_body(BodyEdit::AngularImpulse(angular_impulse))
    }

    /// Sets the velocity of the centre of mass, m/s, at this instant. Spin and internal motion stay.
    fn set_linear_velocity(&mut self, velocity: Vec3) -> &mut Self {
        self.edit_body(BodyEdit::LinearVelocity(velocity))
    }

    /// Sets the angular velocity about the centre of mass, rad/s. The velocity of the centre of mass stays, and so does internal motion that is not spin. A
    /// body whose particles all lie on a line has no spin about it.
    fn set_angular_velocity(&mut self, angular_velocity: Vec3) -> &mut Self {
        self.edit_body(BodyEdit::AngularVelocity(angular_velocity))
    }

    /// Sets the motion of the body to one rigid motion, with this velocity (m/s) and this angular velocity (rad/s) at this instant; internal motion is removed.
    /// `set_motion(Vec3::ZERO, Vec3::ZERO)` stops the body.
    fn set_motion(&mut self, velocity: Vec3, angular_velocity: Vec3) -> &mut Self {
        self.edit_body(BodyEdit::Motion(velocity, angular_velocity))
    }

    /// Moves the body so that its `Transform` is this one, relative to its parent if it has one; the scale is ignored. The same as writing the `Transform`, but
    /// at once. Velocities turn with the body and are otherwise kept. A single particle moves to the translation and keeps its velocity.
    fn teleport(&mut self, to: Transform) -> &mut Self {
        self.edit_body(BodyEdit::Teleport(to))
    }

    /// Moves the body by a displacement, metres; velocities are kept.
    fn displace(&mut self, by: Vec3) -> &mut Self {
        self.edit_body(BodyEdit::Displace(by))
    }

    /// Rotates the body about its centre of mass, velocities included. No effect on a single particle.
    fn turn(&mut self, by: Quat) -> &mut Self {
        self.edit_body(BodyEdit::Turn(by))
    }

    /// Reverses the motion: motion that is neither damped nor corrected returns to its start within round-off. The reversal itself goes back by one substep:
    /// after N substeps, N - 1 more lead back to the start. (Two reversals do not cancel: the second goes on by that substep.)
    fn reverse(&mut self) -> &mut Self {
        self.edit_body(BodyEdit::Reverse)
    }
}

impl BodyCommandsExt for EntityCommands<'_> {
    fn edit_body(&mut self, edit: BodyEdit) -> &mut Self {
        // The entity may be gone when the command is applied; that must not panic.
        self.queue_silenced(edit)
    }

    fn relax(&mut self) -> &mut Self {
        self.try_insert(Relax::default())
    }
}

impl BodyCommandsExt for EntityWorldMut<'_> {
    fn edit_body(&mut self, edit: BodyEdit) -> &mut Self {
        let entity = self.id();
        self.world_scope(|world| run(world, entity, edit));
        self
    }

    fn relax(&mut self) -> &mut Self {
        self.insert(Relax::default())
    }
}

impl EntityCommand for BodyEdit {
    type Out = ();

    fn apply(self, entity: EntityWorldMut) {
        let id = entity.id();
        run(entity.into_world_mut(), id, self);
    }
}

/// The edits of a body that wait until it has particles, in the order in which they were issued. Part of the state.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct PendingEdits(pub Vec<BodyEdit>);

impl PendingEdits {
    /// How many edits may wait; a further one is refused. Without a limit, a game that pushes a body in every frame would fill the memory if its mesh never
    /// loads.
    pub const MAX: usize = 64;
}
