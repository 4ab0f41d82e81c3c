//! Resolves [`ContactShape::Auto`]: the particles of a body if they leave no holes, otherwise its triangles or its segments.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

use crate::changes::count_and_changed;
use crate::components::{
    BodyConstraints, BodyParticles, Bound, ContactShape, DistanceConstraint, ParticleOf,
    ResolvedShape, RestPlace, WindSurface,
};
use crate::rows::{GONE, ResolvedRows};
use crate::world::SinewWorld;

/// How far a point of a triangle may be from its nearest corner, as a fraction of the diameter of the balls there, so that no ball of the same size passes
/// between them. Slightly less than 1, so that rounding does not decide.
const MAX_GAP: f32 = 0.995;

/// The components of a body that determine its contact shape.
type ShapeInputs = (
    Entity,
    Ref<'static, BodyParticles>,
    &'static mut ResolvedRows<BodyParticles>,
    Option<Ref<'static, WindSurface>>,
    Option<Ref<'static, BodyConstraints>>,
    &'static mut ResolvedShape,
);

/// Resolves the shape of bodies whose particles, surface or rods have changed.
pub(crate) fn resolve_shapes(
    world: Res<SinewWorld>,
    mut bodies: Query<ShapeInputs>,
    surfaces: Query<Ref<WindSurface>>,
    constraints: Query<Ref<BodyConstraints>>,
    rest_shape: RestShape,
) {
    let (particles, tables) = (&world.simulation.particles, &world.tables);
    let of_particles = tables.properties_gathered || tables.bodies_changed;
    if !(of_particles || count_and_changed(&surfaces).1 || count_and_changed(&constraints).1) {
        return;
    }
    for (body, members, mut rows, surface, constraints, mut resolved) in &mut bodies {
        let rows = rows.resolve(&tables.layout, members.is_changed(), members.iter());
        let there = rows.iter().filter(|&&row| row != GONE);
        let radius = there.map(|&row| particles.radius(row as usize)).fold(f32::INFINITY, f32::min);
        // A surface may be torn in any tick, and its rods do not affect the result.
        let new = match (&surface, &constraints) {
            (Some(surface), _) => surface.is_changed(),
            (None, Some(constraints)) => constraints.is_changed(),
            (None, None) => false,
        };
        let same = tables.layout.same_since(resolved.layout);
        let stays = !members.is_changed() && rows.iter().all(|&row| (row as usize) < same);
        if !new && stays && resolved.radius == radius {
            // The result is the same.
            resolved.bypass_change_detection().layout = tables.layout.number;
            continue;
        }
        let triangles = surface.as_ref().map_or(&[][..], |surface| &surface.triangles);
        let rods = constraints.as_deref();
        let shape = if !triangles.is_empty() {
            match rest_shape.widest_gap(triangles) {
                Some(gap) if MAX_GAP * 2.0 * radius < gap => ContactShape::Triangles,
                _ => ContactShape::Particles,
            }
        } else {
            match rods.and_then(|rods| rest_shape.longest_link(body, rods)) {
                Some(link) if radius > 0.0 && 2.0 * radius < link => ContactShape::Segments,
                _ => ContactShape::Particles,
            }
        };
        resolved.set_if_neq(ResolvedShape { shape, layout: tables.layout.number, radius });
    }
}

/// Rest positions of particles, and rods.
#[derive(SystemParam)]
pub(crate) struct RestShape<'w, 's> {
    places: Query<'w, 's, &'static RestPlace>,
    rods: Query<'w, 's, &'static DistanceConstraint>,
    owners: Query<'w, 's, &'static ParticleOf>,
}

impl RestShape<'_, '_> {
    /// The maximum distance of a point of the triangles from its nearest corner in the rest shape, metres; `None` if a corner has no rest position.
    fn widest_gap(&self, triangles: &[[Entity; 3]]) -> Option<f32> {
        let mut widest = 0.0_f32;
        for corners in triangles {
            let [a, b, c] = self.places.get_many(*corners).ok()?;
            widest = widest.max(gap([a.0, b.0, c.0]));
        }
        Some(widest)
    }

    /// The longest rod of a chain, metres; `None` if the body is not a chain: if a particle has more than two rods, or there are none.
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

/// The maximum distance of a point of a triangle from its nearest corner, in the unit of the corners.
///
/// With the sides `a ≤ b ≤ c` it is the circumradius, `a b c / 4A`, if the circumcentre is in the triangle: if no angle is obtuse. Otherwise the point is on
/// the longest side, where the bisector of `a` or of `b` intersects it: at `a/(2 cos β)` from their common corner, with `2 a c cos β = a² + c² - b²`.
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
