//! Bodies that collide by their segments: each rod between two particles becomes a part, a capsule, so that nothing passes between the two.

use glam::Vec3;

use super::blueprint::{Blueprint, Part};
use crate::collide::Shape;
use crate::constraints::{Bound, Distance};

impl Blueprint {
    /// The same body, colliding by its segments: between each two particles that a distance ties together ([`Bound::Equal`] or [`Bound::AtMost`]) it
    /// gets a part, `"segment"`, whose shape is a capsule from one to the other, as thick as the thinner one's [radius](crate::ParticleSeed::radius).
    /// The particles then touch nothing by themselves.
    ///
    /// It is for ropes whose particles are further apart than they are thick, where something thin may come between two of them: posts and rails,
    /// edges of boxes, other ropes, knots. Friction of segments also remembers where it holds, which that of single particles does not. It costs half
    /// as much again as particles do for ropes that lie side by side, and some five times as much in a tangle.
    ///
    /// Left out are distances whose particles are both in a part already that has a shape, and those with a particle of radius 0. In a body that
    /// touches itself, segments do not touch their neighbours, nor those that they overlap in the rest shape
    /// ([`BodyCollider::segment`](crate::collide::BodyCollider::segment)). A segment keeps its length where a soft distance stretches, and where one
    /// that is [`Bound::AtMost`] folds up.
    ///
    /// Contacts and rods take turns, once a substep: a heavy load draws a light rope into what holds it up. With ten substeps a rope bears at each
    /// end some five times the mass of one of its particles where it lies across another rope, and ten times where it lies on a post of its own
    /// thickness; with forty it is twenty-five and a hundred times. With more than that they may pass through each other:
    /// take more substeps, or heavier and fewer particles.
    ///
    /// What is tied to an end of the rope is to be tied by more than both are thick there, or to be on [`Layers`](crate::Layers) that the rope does
    /// not mind: a tie that is shorter fights with the contact, and that brings in energy.
    ///
    /// [`build_colliding`](Self::build_colliding) makes solids of the parts. Whoever removes a distance from the simulation removes its solid, too.
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

    /// The part along a distance; `None` if it is to have none.
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
