//! The momenta of an island that nothing outside holds: what its constraints among themselves cannot have changed is put back.
//!
//! Constraints among the particles of an island sum to no momentum, but a correction is rounded to the spacing of positions, 6e-8 m within a
//! metre, and divided by `h` becomes a kick: at 600 substeps a second, noise of some 1e-5 m/s that adds up like a random walk, until after a
//! minute a free brick tumbles otherwise than it should. What the sums must be is known, so the difference is taken from all particles as the
//! answer of a rigid body to it ([`Whole`]).
//!
//! The angular momentum `Σ m p × v`, with `p` where the substep began, is what Verlet conserves, and what corrections along the start of the
//! step ([`Direction::StepStart`]) keep. To the nearest point they do not: a cube of rods loses its spin as `ω₀/√(1 + 2ω₀²ht)`, and a skin under
//! pressure makes some out of nothing. That is mended in the same way, unless
//! [`keep_spin`](crate::SolverSettings::keep_spin) asks for the lectures' loop as it is.

use glam::DVec3;

use super::plan::{Group, Island, Kind, Plan};
use crate::constraints::{Direction, Law};
use crate::integrate::Integrator;
use crate::particles::{Particles, Whole};

/// What an island's momenta were before it was solved.
#[derive(Clone, Copy, Debug)]
pub(super) struct Momenta {
    /// `Σ m v`, kg·m/s.
    linear: DVec3,
    /// `Σ m p × v` about the island's origin, kg·m²/s.
    angular: DVec3,
    /// Whether the corrections keep the angular one.
    keeps_angular: bool,
}

impl Momenta {
    /// The momenta that are to be kept, or `None` if something outside holds the island: a pinned particle, or a law of a game's own; or if there is
    /// an explicit rigid body in it, whose velocities are its own.
    pub(super) fn to_keep(
        particles: &Particles,
        plan: &Plan,
        island: &Island,
        direction: Direction,
    ) -> Option<Self> {
        let keeps_angular = direction == Direction::StepStart || island.settings.keep_spin;
        let rows = &plan.members[island.members.clone()];
        island.free.then(|| Self { keeps_angular, ..Self::of(particles, rows) })
    }

    fn of(particles: &Particles, rows: &[u32]) -> Self {
        let (mut linear, mut angular) = (DVec3::ZERO, DVec3::ZERO);
        for &row in rows {
            let i = row as usize;
            let velocity = particles.velocity[i].truncate().as_dvec3();
            let momentum = velocity / f64::from(particles.position[i].w);
            linear += momentum;
            angular += particles.start[i].truncate().as_dvec3().cross(momentum);
        }
        Self { linear, angular, keeps_angular: false }
    }

    /// Takes from the derived velocities of an island what it has beyond these momenta.
    pub(super) fn restore(&self, particles: &mut Particles, plan: &Plan, island: &Island) {
        let rows = &plan.members[island.members.clone()];
        let now = Self::of(particles, rows);
        let Some(whole) = Whole::at_start(particles, rows) else { return };
        let linear = now.linear - self.linear;
        let angular = if self.keeps_angular {
            // About the barycentre: what the linear excess has about the origin goes with it.
            now.angular - self.angular - whole.centre(particles).cross(linear)
        } else {
            DVec3::ZERO
        };
        if !(linear.is_finite() && angular.is_finite()) {
            return;
        }
        let excess = whole.answer(linear, angular);
        for &row in rows {
            let share = excess.at(whole.arm(particles, row as usize));
            particles.velocity[row as usize] -= share.extend(0.0);
        }
    }
}

/// Whether an island has constraints, all of them between its own particles, and no particle that is held. To be asked once a step.
pub(crate) fn is_free(particles: &Particles, plan: &Plan, island: &Island) -> bool {
    // A game's own law may hold on to the world, and is of a group of its own.
    let own = |group: &Group| {
        let first = plan.constraints.get(group.range.start);
        group.kind != Kind::Constraints || !matches!(first.map(|c| &c.law), Some(Law::Custom(_)))
    };
    let groups = &plan.groups[island.groups.clone()];
    // Explicit Euler adds the forces of the substep after the constraints.
    !groups.is_empty()
        && !island.rigid
        && island.settings.integrator != Integrator::ExplicitEuler
        && groups.iter().all(own)
        && plan.members[island.members.clone()]
            .iter()
            .all(|&row| particles.position[row as usize].w > 0.0)
}
