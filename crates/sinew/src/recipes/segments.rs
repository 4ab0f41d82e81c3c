//! Bodies that collide by their segments: each rod between two particles becomes a part with a capsule shape, so that nothing passes between the particles.

use glam::Vec3;

use super::blueprint::{Blueprint, Part};
use crate::collide::Shape;
use crate::constraints::{Bound, Distance};

impl Blueprint {
    /// The same body, colliding by its segments. For each pair of particles connected by a distance ([`Bound::Equal`] or [`Bound::AtMost`]) it gets a part
    /// named `"segment"`, whose shape is a capsule from one particle to the other, with the smaller [radius](crate::ParticleSeed::radius) of the two. The
    /// particles then have no contacts of their own.
    ///
    /// Use it for ropes whose particles are farther apart than they are thick, where something thin may come between two of them: posts and rails, edges of
    /// boxes, other ropes, knots. Friction of segments also has friction anchors (static friction from step to step), which that of single particles has not.
    /// It costs half as much again as particles for ropes that lie side by side, and some five times as much in a tangle.
    ///
    /// Distances are skipped if both particles are already in a part with a shape, or if a particle has radius 0. In a body that collides with itself, segments
    /// do not collide with their neighbours, nor with those that they overlap in the rest shape
    /// ([`BodyCollider::segment`](crate::collide::BodyCollider::segment)). A segment keeps its length where a soft distance stretches, and where one with
    /// [`Bound::AtMost`] folds up.
    ///
    /// Contacts and rods are solved in turns, once a substep, so a heavy load pulls a light rope into its support. With ten substeps a rope carries at each end
    /// some five times the mass of one of its particles where it lies across another rope, and ten times where it lies on a post of its own thickness; with
    /// forty it is twenty-five and a hundred times. With heavier loads the two may pass through each other: use more substeps, or heavier and fewer particles.
    ///
    /// An object that is attached to an end of the rope needs a distance longer than the sum of both thicknesses there, or [`Layers`](crate::Layers) that
    /// exclude contacts with the rope. A shorter distance works against the contact, which adds energy.
    ///
    /// [`build_colliding`](Self::build_colliding) makes body colliders of the parts. If a game removes a distance from the simulation, it also has to remove
    /// the body collider of that segment.
    ///
    /// ```
    /// use sinew::{BodyContacts, Simulation, recipes::{RopeSpec, rope}};
    ///
    /// let mut world = Simulation::default();
    /// let line = rope(&RopeSpec { segments: 10, ..Default::default() })?.with_segments();
    /// line.build_colliding(&mut world, BodyContacts { with_bodies: true, ..Default::default() })?;
    /// assert_eq!(world.body_colliders().len(), 10);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn with_segments(mut self) -> Self {
        let segments: Vec<Part> = self.distances.iter().filter_map(|d| self.segment(d)).collect();
        self.parts.extend(segments);
        self
    }

    /// The part along a distance; `None` if the distance is skipped.
    fn segment(&self, distance: &Distance) -> Option<Part> {
        let &Distance { a, b, rest: length, bound, .. } = distance;
        let within = |part: &&Part| {
            part.shape.is_some() && part.particles.contains(&a) && part.particles.contains(&b)
        };
        if bound == Bound::AtLeast || self.parts.iter().any(|part| within(&part)) {
            return None;
        }
        let thickness = |particle: u32| Some(self.particles.get(particle as usize)?.radius);
        let radius = thickness(a)?.min(thickness(b)?);
        let half = 0.5 * length;
        Some(Part {
            name: "segment",
            particles: vec![a, b],
            rest: vec![Vec3::Y * half, Vec3::Y * -half],
            size: Vec3::new(2.0 * radius, length + 2.0 * radius, 2.0 * radius),
            shape: Some(Shape::capsule(radius, length).ok()?),
        })
    }
}

#[cfg(test)]
mod tests;
