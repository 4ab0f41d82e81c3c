//! Forces, impulses, velocities, teleports and reversal as commands: on a whole body, on a rigid part of one, or on a single particle.
//!
//! A body has no velocity of its own to be set: its particles have. So a command spreads over them what a game wants of the whole, as a rigid
//! body would take it ([`sinew::Particles`] has the arithmetic), and changes nothing but [`Particle`](crate::Particle)s and, for a teleport, the
//! body's `Transform`. It acts at once where commands are applied, and not at the next tick: two in a row see each other.

mod edit;
mod editor;
mod relax;

pub use edit::BodyEdit;
pub use relax::{Relax, RelaxFinished, RelaxWorld, SinewCommandsExt};

use bevy::prelude::*;

use editor::run;
pub(crate) use editor::{Editor, apply_pending};
pub(crate) use relax::{is_asked, relax_asked};

/// Pushing, moving and turning back what is made of particles.
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
/// The entity is a body, something with a [`RigidPose`](crate::RigidPose) (the head of a ragdoll), or a particle. A body whose particles are not
/// built yet keeps what it is told for the tick in which they are ([`PendingEdits`]). Particles that are [pinned](crate::Pinned) do not notice,
/// except that a teleport takes them along; those that are set aside for a bad number are left alone.
///
/// What cannot be done changes nothing and is refused with one [`Refused`](crate::Refused) message ([`EditFault`](crate::EditFault) says why). An entity that is
/// gone is passed over in silence.
///
/// What is read back of the body ([`LinearVelocity`](crate::LinearVelocity), …) follows after the next tick.
pub trait BodyCommandsExt {
    /// Does one edit: what all the others here call.
    fn edit_body(&mut self, edit: BodyEdit) -> &mut Self;

    /// Brings it to rest in the next tick, where it would come to rest in time: inserts a [`Relax`], which says more.
    fn relax(&mut self) -> &mut Self;

    /// A force at the barycentre, N, for the next tick alone; several add up. A steady one is [`ExternalForce`](crate::ExternalForce).
    fn apply_force(&mut self, force: Vec3) -> &mut Self {
        self.edit_body(BodyEdit::Force(force))
    }

    /// A force, N, at a point of the world, metres, for the next tick alone: as at the barycentre, with its lever.
    fn apply_force_at(&mut self, force: Vec3, point: Vec3) -> &mut Self {
        self.edit_body(BodyEdit::ForceAt(force, point))
    }

    /// A torque, N·m, for the next tick alone. A steady one is [`ExternalTorque`](crate::ExternalTorque).
    fn apply_torque(&mut self, torque: Vec3) -> &mut Self {
        self.edit_body(BodyEdit::Torque(torque))
    }

    /// An impulse at the barycentre, N·s: all its particles change their velocity by the same, its momentum changes by exactly that.
    fn apply_impulse(&mut self, impulse: Vec3) -> &mut Self {
        self.edit_body(BodyEdit::Impulse(impulse))
    }

    /// An impulse, N·s, at a point of the world, metres: as at the barycentre, and with the spin that its lever gives. The point need not be on the
    /// body. A single particle has no lever.
    fn apply_impulse_at(&mut self, impulse: Vec3, point: Vec3) -> &mut Self {
        self.edit_body(BodyEdit::ImpulseAt(impulse, point))
    }

    /// An angular impulse about the barycentre, N·m·s: the angular momentum changes by exactly that, the momentum does not. What would turn a line
    /// about itself, or a single particle, is lost.
    fn apply_angular_impulse(&mut self, angular_impulse: Vec3) -> &mut Self {
        self.edit_body(BodyEdit::AngularImpulse(angular_impulse))
    }

    /// Gives the barycentre this velocity, m/s, true at this instant. Spin and inner motion stay.
    fn set_linear_velocity(&mut self, velocity: Vec3) -> &mut Self {
        self.edit_body(BodyEdit::LinearVelocity(velocity))
    }

    /// Gives the body this angular velocity, rad/s about the barycentre, which keeps its own velocity. Inner motion that is no spin stays. About a
    /// line on which all its particles lie there is no spin.
    fn set_angular_velocity(&mut self, angular_velocity: Vec3) -> &mut Self {
        self.edit_body(BodyEdit::AngularVelocity(angular_velocity))
    }

    /// Makes it move as one rigid body, with this velocity (m/s) and this angular velocity (rad/s), both true at this instant: all other motion
    /// is gone. `set_motion(Vec3::ZERO, Vec3::ZERO)` brings it to rest.
    fn set_motion(&mut self, velocity: Vec3, angular_velocity: Vec3) -> &mut Self {
        self.edit_body(BodyEdit::Motion(velocity, angular_velocity))
    }

    /// Moves it so that its `Transform` is this one, in the frame of its parents if it has any, except for the scale, which stays: the same as changing
    /// the `Transform`, but at once. Velocities turn along and are otherwise kept. A single particle goes to the translation and keeps its velocity.
    fn teleport(&mut self, to: Transform) -> &mut Self {
        self.edit_body(BodyEdit::Teleport(to))
    }

    /// Moves it by so many metres; velocities are kept.
    fn displace(&mut self, by: Vec3) -> &mut Self {
        self.edit_body(BodyEdit::Displace(by))
    }

    /// Turns it about its barycentre, velocities with it. A single particle has nothing to turn.
    fn turn(&mut self, by: Quat) -> &mut Self {
        self.edit_body(BodyEdit::Turn(by))
    }

    /// Sends it back the way it came: what is neither damped nor corrected returns to its start within round-off. It goes back by one substep at
    /// once: after N substeps, N - 1 more lead back. (Twice in a row is not nothing: the second goes on by that substep.)
    fn reverse(&mut self) -> &mut Self {
        self.edit_body(BodyEdit::Reverse)
    }
}

impl BodyCommandsExt for EntityCommands<'_> {
    fn edit_body(&mut self, edit: BodyEdit) -> &mut Self {
        // Whether the entity is still there turns out when it is done; that it is not is no reason to end the game.
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

/// What a body was told before it had particles, in that order. It is done as soon as it has; part of the state.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct PendingEdits(pub Vec<BodyEdit>);

impl PendingEdits {
    /// How many edits wait at most; more than these and a body whose mesh never comes would fill the memory of a game that pushes it every frame.
    pub const MOST: usize = 64;
}
