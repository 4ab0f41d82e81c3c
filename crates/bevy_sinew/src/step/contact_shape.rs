//! What of a body touches others where it does not say ([`ContactShape::Auto`]): its particles if they let nothing through, otherwise its triangles or its
//! segments.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

use crate::components::{
    BodyConstraints, BodyParticles, Bound, ContactShape, DistanceConstraint, ParticleOf,
    ResolvedShape, RestPlace, WindSurface,
};
use crate::rows::{GONE, Rows};
use crate::world::SinewWorld;

/// Radius that closes a surface, as a share of its longest edge. Between balls of that radius at the corners of an equilateral triangle there is a gap of
/// no size, √3/6 = 0.289; between those of a right one it is closed from a quarter of its hypotenuse on.
const CLOSES: f32 = 0.29;

/// What a body is made of that may close it.
type Made = (
    Entity,
    Ref<'static, BodyParticles>,
    &'static mut Rows<BodyParticles>,
    Option<Ref<'static, WindSurface>>,
    Option<Ref<'static, BodyConstraints>>,
    &'static mut ResolvedShape,
);

/// Finds it for bodies whose particles, surface or rods have changed.
pub(crate) fn resolve_shapes(
    world: Res<SinewWorld>,
    mut bodies: Query<Made>,
    changed: Query<(), Or<(Changed<WindSurface>, Changed<BodyConstraints>)>>,
    parts: Parts,
) {
    let (particles, tables) = (&world.simulation.particles, &world.tables);
    if !tables.properties_gathered && changed.is_empty() {
        return;
    }
    for (body, members, mut rows, surface, constraints, mut resolved) in &mut bodies {
        let rows = rows.resolve(tables, members.is_changed(), members.iter());
        let there = rows.iter().filter(|&&row| row != GONE);
        let radius = there.map(|&row| particles.radius(row as usize)).fold(f32::INFINITY, f32::min);
        // What has a surface may be torn at any time, and its rods do not matter.
        let new = match (&surface, &constraints) {
            (Some(surface), _) => surface.is_changed(),
            (None, Some(constraints)) => constraints.is_changed(),
            (None, None) => false,
        };
        if !new && resolved.layout == tables.layout && resolved.radius == radius {
            continue;
        }
        let triangles = surface.as_ref().map_or(&[][..], |surface| &surface.triangles);
        let rods = constraints.as_deref();
        let shape = if !triangles.is_empty() {
            match parts.longest_edge(triangles) {
                Some(edge) if radius < CLOSES * edge => ContactShape::Triangles,
                _ => ContactShape::Particles,
            }
        } else {
            match rods.and_then(|rods| parts.longest_link(body, rods)) {
                Some(link) if radius > 0.0 && 2.0 * radius < link => ContactShape::Segments,
                _ => ContactShape::Particles,
            }
        };
        resolved.set_if_neq(ResolvedShape { shape, layout: tables.layout, radius });
    }
}

/// Particles at rest, and rods.
#[derive(SystemParam)]
pub(crate) struct Parts<'w, 's> {
    places: Query<'w, 's, &'static RestPlace>,
    rods: Query<'w, 's, &'static DistanceConstraint>,
    owners: Query<'w, 's, &'static ParticleOf>,
}

impl Parts<'_, '_> {
    /// The longest edge of some triangles in the rest shape, metres; `None` where a corner has no place there.
    fn longest_edge(&self, triangles: &[[Entity; 3]]) -> Option<f32> {
        let mut longest = 0.0_f32;
        for corners in triangles {
            let [a, b, c] = self.places.get_many(*corners).ok()?;
            for (one, other) in [(a, b), (b, c), (c, a)] {
                longest = longest.max(one.0.distance_squared(other.0));
            }
        }
        Some(longest.sqrt())
    }

    /// The longest rod of a chain, metres; `None` if it is none: a particle has more than two rods, or there are no rods.
    fn longest_link(&self, body: Entity, constraints: &BodyConstraints) -> Option<f32> {
        let mut ends: Vec<Entity> = Vec::new();
        let mut longest = None::<f32>;
        for rod in self.rods.iter_many(constraints.iter()) {
            let own = |end: Entity| self.owners.get(end).is_ok_and(|of| of.0 == body);
            if rod.bound == Bound::AtLeast || !own(rod.a) || !own(rod.b) {
                continue;
            }
            ends.extend([rod.a, rod.b]);
            longest = Some(longest.map_or(rod.rest, |longest| longest.max(rod.rest)));
        }
        ends.sort_unstable();
        let is_chain = ends.windows(3).all(|three| three[0] != three[2]);
        longest.filter(|_| is_chain)
    }
}
