//! Adds a blueprint to a simulation, for use of this crate without an engine.

use core::ops::Range;

use super::blueprint::{Blueprint, BlueprintFault};
use crate::collide::{BodyCollider, BodyContacts};
use crate::constraints::{Constraint, Distance};
use crate::simulation::Simulation;

impl Blueprint {
    /// Adds the particles, constraints and triangles to a simulation and returns the rows of the particles, in the order of the blueprint. If the blueprint has
    /// solver settings of its own, the particles form a body with them.
    ///
    /// # Errors
    /// A [`BlueprintFault`] if the blueprint is not [valid](Self::validate); the simulation is then unchanged.
    ///
    /// ```
    /// use sinew::{Simulation, recipes::{RopeSpec, rope}};
    ///
    /// let mut world = Simulation::default();
    /// let rows = rope(&RopeSpec { pin_start: true, ..Default::default() })?.build(&mut world)?;
    /// assert_eq!(rows, 0..21);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn build(&self, simulation: &mut Simulation) -> Result<Range<usize>, BlueprintFault> {
        self.add(simulation, self.settings != Default::default())
    }

    /// The same, as a body that takes part in contacts: its parts collide by their shapes, and its other particles as balls of their radius.
    ///
    /// # Errors
    /// A [`BlueprintFault`] if the blueprint is not [valid](Self::validate); the simulation is then unchanged.
    pub fn build_colliding(
        &self,
        simulation: &mut Simulation,
        contacts: BodyContacts,
    ) -> Result<Range<usize>, BlueprintFault> {
        let rows = self.add(simulation, true)?;
        simulation.contacts.resize(simulation.bodies.len(), BodyContacts::default());
        if let Some(own) = simulation.contacts.last_mut() {
            *own = contacts;
        }
        if contacts.with_itself {
            for (i, seed) in rows.clone().zip(&self.particles) {
                simulation.particles.set_rest(i, Some(seed.position));
            }
        }
        for part in &self.parts {
            if let Some(shape) = &part.shape {
                let own = part.particles.iter().map(|&i| rows.start as u32 + i).collect();
                let rest = part.rest.as_slice().into();
                let body_colliders = simulation.body_colliders_mut();
                let id = body_colliders.last().map_or(0, |last| last.id + 1);
                body_colliders.push(BodyCollider { rows: own, rest, shape: shape.clone(), id });
            }
        }
        Ok(rows)
    }

    fn add(&self, simulation: &mut Simulation, body: bool) -> Result<Range<usize>, BlueprintFault> {
        self.validate()?;
        let first = simulation.particles.len();
        for (index, seed) in self.particles.iter().enumerate() {
            let added = simulation.particles.push(*seed);
            added.map_err(|fault| BlueprintFault::Particle { index, fault })?;
        }
        let offset = first as u32;
        let moved = |d: &Distance| Distance { a: d.a + offset, b: d.b + offset, ..*d };
        simulation.extend_distances(self.distances.iter().map(moved));
        let moved =
            |c: &Constraint| Constraint::new(c.rows.iter().map(|row| row + offset), c.kind.clone());
        simulation.extend_constraints(self.constraints.iter().map(moved));
        if body {
            let body = simulation.bodies.len() as u32;
            simulation.bodies.push(self.settings);
            let rows = first..simulation.particles.len();
            rows.for_each(|i| simulation.particles.set_body(i, Some(body)));
        }
        let corners = self.triangles.iter().map(|t| t.map(|i| i + offset));
        simulation.forces.surfaces.extend(corners);
        Ok(first..simulation.particles.len())
    }
}
