//! One step of a rigid body: from `f32` to `f64`, one of the three integrators, and back.

use glam::{DVec3, Vec3};

use super::principal::Spin;
use super::{RigidBody, RigidFault, euler, leapfrog, verlet};

/// Integrator of a rigid body. [`rigid`](super) compares them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum RigidIntegrator {
    /// As in the lectures: velocities first, then position and rotation, each from its rate of change. Order 1. Energy and angular momentum drift, faster the
    /// faster the body turns, and grow until the step is refused. For comparison.
    Euler,
    /// Kick, turn, kick, with the turn split into parts with exact solutions (`leapfrog.rs`): order 2; exact, whatever the step, for a body with two equal
    /// moments. The default.
    #[default]
    Leapfrog,
    /// The discrete Moser–Veselov equations (`verlet.rs`): Verlet's formula for rotations. Order 2. A step in which the body turns by more than half a radian
    /// is divided into up to 64 parts; a body that is faster still is integrated by `Leapfrog`.
    Verlet,
}

impl RigidBody {
    /// Advances the body by `h` seconds under a constant `force` (N, at the barycentre) and `torque` (N·m, about the barycentre; see
    /// [`torque_of`](Self::torque_of)), both in the axes of the world. Gravity is a force: `m g`.
    ///
    /// A negative `h` goes back in time: with `Leapfrog` and `Verlet` to the earlier state, up to round-off.
    ///
    /// # Errors
    /// A body with a [fault](Self::fault), non-finite arguments, and a step with a non-finite result. Then nothing changes.
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
        // With the rounded rotation, so that the angular momentum is kept exactly, rather than the angular velocity.
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

    /// Advances the barycentre.
    fn advance(&mut self, force: DVec3, h: f64, integrator: RigidIntegrator) {
        let kick = force * (h / f64::from(self.mass));
        let velocity = self.velocity.as_dvec3();
        // Mean velocity of the step; half of the kick makes it that of a parabola.
        let mean = match integrator {
            RigidIntegrator::Euler => velocity + kick,
            RigidIntegrator::Leapfrog | RigidIntegrator::Verlet => velocity + kick * 0.5,
        };
        self.velocity = (velocity + kick).as_vec3();
        let position = self.position.as_dvec3() + mean * h;
        let origin = self.origin.as_dvec3() + (position + 0.5).floor();
        // Beyond 16 777 216 m not every whole metre is an `f32`: the rounding error goes into the position.
        let rounded = origin.as_vec3();
        self.position = (self.origin.as_dvec3() - rounded.as_dvec3() + position).as_vec3();
        self.origin = rounded;
    }
}
