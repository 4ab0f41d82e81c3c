//! Cloth and rope as soft bodies of rapier.

use rapier3d::prelude::*;
use sinew::{Bound, Simulation};

use crate::measure::{World, stretch_of};
use crate::row::Stretch;

/// Stiffness of an edge, as rapier's frequency in Hz: beyond this value nothing is gained. rapier's own cloth example uses 100, with which this cloth stretches
/// by 2.2 % instead of 0.8 %; the time is the same.
const HERTZ: f32 = 1000.0;

/// A soft body, with the distances that it was made from.
pub(super) struct Soft {
    world: PhysicsWorld,
    body: SoftBodyHandle,
    distances: Vec<sinew::Distance>,
}

/// One soft body with the same particles and edges, without colliders, that never sleeps; substeps and sweeps are those of the simulation.
pub(super) fn soft(from: &Simulation) -> Soft {
    let particles = &from.particles;
    let count = particles.len();
    let rows = 0..count;
    let at = |i| Vector::from(particles.position(i).to_array());
    let pinned: Vec<u32> =
        (0..count as u32).filter(|&i| particles.inverse_mass(i as usize) == 0.0).collect();
    let masses =
        rows.clone().map(|i| particles.mass(i)).map(|m| if m.is_finite() { m } else { 1.0 });
    let builder = SoftBodyBuilder::new(rows.clone().map(at).collect())
        .masses(masses.collect())
        .pinned_particles(pinned)
        .edges(from.distances().iter().map(|d| [d.a, d.b]).collect())
        .softness(SpringCoefficients::new(HERTZ, 1.0))
        .additional_pgs_iterations(from.settings.max_sweeps as usize - 1)
        .no_surface_collider()
        .can_sleep(false);
    let thread = from.distances().first().is_some_and(|d| d.bound == Bound::AtMost);
    let builder = if thread { builder.tension_only() } else { builder };
    let mut world = PhysicsWorld::new();
    world.integration_parameters.num_solver_iterations = from.settings.substeps as usize;
    let body = world.insert_soft_body(builder);
    Soft { world, body, distances: from.distances().to_vec() }
}

impl World for Soft {
    fn tick(&mut self) {
        self.world.step();
    }

    fn stretch(&self) -> Option<Stretch> {
        let body = self.world.soft_bodies.get(self.body)?;
        stretch_of(&self.distances, |i| body.particle_position(i).to_array().into())
    }
}
