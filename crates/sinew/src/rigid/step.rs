//! One step of a rigid body: out of `f32`, one of the three ways through time, and back.

use glam::{DVec3, Vec3};

use super::principal::Spin;
use super::{RigidBody, RigidFault, euler, leapfrog, verlet};

/// How a rigid body steps through time. [`rigid`](super) compares them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum RigidIntegrator {
    /// As the lectures have it: velocities first, then position and rotation, each from its rate of change. Order 1. Energy and
    /// angular momentum drift, the more so the faster the body turns, and grow until the step is refused; to compare with.
    Euler,
    /// Kick, turn, kick, with the turn split into exact pieces (`leapfrog.rs`): order 2; exact, whatever the step, for
    /// a body with two equal moments. The default.
    #[default]
    Leapfrog,
    /// The discrete Moser–Veselov equations (`verlet.rs`): what Verlet's formula is for rotations. Order 2. A body that turns by more than
    /// half a radian in a step is taken through it in up to 64 smaller ones; one that is faster still, by `Leapfrog`.
    Verlet,
}

impl RigidBody {
    /// Moves the body through `h` seconds, during which `force` (N, at the barycentre) and `torque` (N·m, about the barycentre; see
    /// [`torque_of`](Self::torque_of)) act, both in the axes of the world and constant. Gravity is a force: `m g`.
    ///
    /// A negative `h` goes back: with `Leapfrog` and `Verlet` to where the body was, up to round-off.
    ///
    /// # Errors
    /// A body with a [fault](Self::fault), and a step that begins or ends with what is not finite. Then nothing changes.
    pub fn step(
        &mut self,
        force: Vec3,
        torque: Vec3,
        h: f32,
        integrator: RigidIntegrator,
    ) -> Result<(), RigidFault> {
        let principal = self.principal()?;
        if !(force.is_finite() && torque.is_finite() && h.is_finite()) {
            return Err(RigidFault::Step);
        }
        let h = f64::from(h);
        let mut next = *self;
        next.advance(force.as_dvec3(), h, integrator);

        let rotation = self.turn();
        let rate = rotation.conjugate() * self.angular_velocity.as_dvec3();
        let spin = Spin { rotation, momentum: rotation * principal.momentum(rate) };
        let way = match integrator {
            RigidIntegrator::Euler => euler::turn,
            RigidIntegrator::Leapfrog => leapfrog::turn,
            RigidIntegrator::Verlet => verlet::turn,
        };
        let spin = way(spin, &principal, torque.as_dvec3(), h);
        next.rotation = spin.rotation.as_quat();
        // With the rotation as it was rounded: so it is the angular momentum that is met, not the angular velocity.
        let spin = Spin { rotation: next.turn(), ..spin };
        next.angular_velocity = spin.rate(&principal).as_vec3();

        let places = next.origin.is_finite() && next.position.is_finite();
        let rates = next.velocity.is_finite() && next.angular_velocity.is_finite();
        if !(places && rates && next.rotation.is_finite()) {
            return Err(RigidFault::Step);
        }
        *self = next;
        Ok(())
    }

    /// The barycentre's part of a step.
    fn advance(&mut self, force: DVec3, h: f64, integrator: RigidIntegrator) {
        let kick = force * (h / f64::from(self.mass));
        let velocity = self.velocity.as_dvec3();
        // The mean velocity of the step; half of the kick makes it that of a parabola.
        let mean = match integrator {
            RigidIntegrator::Euler => velocity + kick,
            RigidIntegrator::Leapfrog | RigidIntegrator::Verlet => velocity + kick * 0.5,
        };
        self.velocity = (velocity + kick).as_vec3();
        let position = self.position.as_dvec3() + mean * h;
        let origin = self.origin.as_dvec3() + (position + 0.5).floor();
        // Past 16 777 216 m not every whole metre is an `f32`: what the rounding leaves goes into the position.
        let rounded = origin.as_vec3();
        self.position = (self.origin.as_dvec3() - rounded.as_dvec3() + position).as_vec3();
        self.origin = rounded;
    }
}
