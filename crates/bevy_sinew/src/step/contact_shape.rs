//! What of a body touches others where it does not say ([`ContactShape::Auto`]): its particles if they let nothing through, otherwise its triangles or its
//! segments.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

use crate::changes::census;
use crate::components::{
    BodyConstraints, BodyParticles, Bound, ContactShape, DistanceConstraint, ParticleOf,
    ResolvedShape, RestPlace, WindSurface,
};
use crate::rows::{GONE, Rows};
use crate::world::SinewWorld;

/// How far a place of a triangle may be from its nearest corner, as a share of the diameter of the balls there, for none as large to pass between them. A
/// little less than all of it, so that rounding does not decide.
const CLOSED: f32 = 0.995;

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
    surfaces: Query<Ref<WindSurface>>,
    constraints: Query<Ref<BodyConstraints>>,
    parts: Parts,
) {
    let (particles, tables) = (&world.simulation.particles, &world.tables);
    let of_particles = tables.properties_gathered || tables.bodies_changed;
    if !(of_particles || census(&surfaces).1 || census(&constraints).1) {
        return;
    }
    for (body, members, mut rows, surface, constraints, mut resolved) in &mut bodies {
        let rows = rows.resolve(&tables.layout, members.is_changed(), members.iter());
        let there = rows.iter().filter(|&&row| row != GONE);
        let radius = there.map(|&row| particles.radius(row as usize)).fold(f32::INFINITY, f32::min);
        // What has a surface may be torn at any time, and its rods do not matter.
        let new = match (&surface, &constraints) {
            (Some(surface), _) => surface.is_changed(),
            (None, Some(constraints)) => constraints.is_changed(),
            (None, None) => false,
        };
        let same = tables.layout.same_since(resolved.layout);
        let stays = !members.is_changed() && rows.iter().all(|&row| (row as usize) < same);
        if !new && stays && resolved.radius == radius {
            // What it comes to is the same.
            resolved.bypass_change_detection().layout = tables.layout.number;
            continue;
        }
        let triangles = surface.as_ref().map_or(&[][..], |surface| &surface.triangles);
        let rods = constraints.as_deref();
        let shape = if !triangles.is_empty() {
            match parts.widest_gap(triangles) {
                Some(gap) if CLOSED * 2.0 * radius < gap => ContactShape::Triangles,
                _ => ContactShape::Particles,
            }
        } else {
            match rods.and_then(|rods| parts.longest_link(body, rods)) {
                Some(link) if radius > 0.0 && 2.0 * radius < link => ContactShape::Segments,
                _ => ContactShape::Particles,
            }
        };
        resolved.set_if_neq(ResolvedShape { shape, layout: tables.layout.number, radius });
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
    /// How far a place in some triangles may be from its nearest corner in the rest shape, metres; `None` where a corner has no place there.
    fn widest_gap(&self, triangles: &[[Entity; 3]]) -> Option<f32> {
        let mut widest = 0.0_f32;
        for corners in triangles {
            let [a, b, c] = self.places.get_many(*corners).ok()?;
            widest = widest.max(gap([a.0, b.0, c.0]));
        }
        Some(widest)
    }

    /// The longest rod of a chain, metres; `None` if it is none: a particle has more than two rods, or there are no rods.
    fn longest_link(&self, body: Entity, constraints: &BodyConstraints) -> Option<f32> {
        let mut ends: Vec<Entity> = Vec::new();
        let mut longest = None::<f32>;
        for rod in constraints.iter().filter_map(|rod| self.rods.get(rod).ok()) {
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

/// How far a place of a triangle may be from its nearest corner, in the unit of its places.
///
/// With the sides `a ≤ b ≤ c` that is its circumradius, `a b c / 4A`, where the centre of its circumcircle is in it: where no angle is obtuse. Otherwise the
/// place is on the longest side, where the bisector of `a` or of `b` meets it: at `a/(2 cos β)` from their common corner, with `2 a c cos β = a² + c² - b²`.
pub fn gap(corners: [Vec3; 3]) -> f32 {
    let [p, q, r] = corners;
    let mut squares = [p.distance_squared(q), q.distance_squared(r), r.distance_squared(p)];
    squares.sort_unstable_by(f32::total_cmp);
    let [a, b, c] = squares;
    let area = 0.5 * (q - p).cross(r - p).length();
    if c <= a + b && area > 0.0 {
        return (a * b * c).sqrt() / (4.0 * area);
    }
    let along = |own: f32, other: f32| own * c.sqrt() / (own + c - other);
    let far = along(a, b).max(along(b, a));
    if far.is_finite() { far } else { 0.5 * c.sqrt() }
}
