//! Measurements for lessons that concern more than one entity: all bodies of a name, the particles of a body, the strain of its rods.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::sinew::Frame;
use bevy_sinew::sinew::pose::pose;
use bevy_sinew::{BodyParticles, Bound, ConstraintOf, CreationOrder, SinewWorld, WindSurface};

/// The entities with this name, in the order of their creation.
pub(crate) fn entities_named(world: &mut World, name: &str) -> Vec<Entity> {
    let mut named = world.query::<(Entity, &Name, Option<&CreationOrder>)>();
    let mut found: Vec<(Option<CreationOrder>, Entity)> = named
        .iter(world)
        .filter(|(_, its, _)| its.as_str() == name)
        .map(|(entity, _, order)| (order.copied(), entity))
        .collect();
    found.sort_unstable();
    found.into_iter().map(|(_, entity)| entity).collect()
}

/// A component of entity number `place`, from 0, of those with this name, in the order of their creation.
pub(crate) fn nth_component_of<C: Component + Clone>(
    world: &mut World,
    name: &str,
    place: usize,
) -> Option<C> {
    let entity = *entities_named(world, name).get(place)?;
    world.get::<C>(entity).cloned()
}

/// The positions of the particles of all bodies of a name, metres, in the order of their creation.
pub(crate) fn points_of(world: &mut World, name: &str) -> Vec<Vec3> {
    let mut points = Vec::new();
    for body in entities_named(world, name) {
        let Some(particles) = world.get::<BodyParticles>(body) else { continue };
        let at = |p: Entity| world.get::<Particle>(p).map(|p| p.position);
        points.extend(particles.iter().filter_map(at));
    }
    points
}

/// Depth of the lowest body below a level, millimetres; 0 if none is below it. Of a body that collides by its shape it is the shape's, whose particles may lie
/// outside of it: those beside a knee, which carry a bone's inertia, do.
pub(crate) fn deepest_below(world: &World, level: f32) -> f64 {
    let Some(solver) = world.get_resource::<SinewWorld>() else { return 0.0 };
    let simulation = solver.simulation();
    let particles = &simulation.particles;
    let mut has_shape = vec![false; particles.len()];
    let mut lowest = level;
    for collider in simulation.body_colliders() {
        let rows = collider.rows.iter().map(|&row| row as usize);
        let points = rows.clone().zip(&*collider.rest);
        let points = points.map(|(i, &rest)| (particles.position(i), rest, particles.mass(i)));
        let Some(pose) = pose(points, Quat::IDENTITY) else { continue };
        rows.for_each(|i| has_shape[i] = true);
        let rotation = Mat3::from_quat(pose.rotation);
        let frame = Frame { translation: pose.translation, rotation };
        lowest = lowest.min(collider.shape.bounds_in(&frame).0.y);
    }
    for i in (0..particles.len()).filter(|&i| !has_shape[i]) {
        lowest = lowest.min(particles.position(i).y);
    }
    f64::from(level - lowest) * 1e3
}

/// Whether the bodies of a name are clear of the ground: each particle by more than its radius and a centimetre.
pub(crate) fn is_in_flight(world: &mut World, name: &str) -> bool {
    entities_named(world, name).into_iter().all(|body| {
        let Some(particles) = world.get::<BodyParticles>(body) else { return false };
        particles.iter().all(|particle| {
            let radius = world.get::<Radius>(particle).map_or(0.0, |radius| radius.0);
            world.get::<Particle>(particle).is_some_and(|at| at.position.y > radius + 0.01)
        })
    })
}

/// Extent of the particles of all bodies of a name along x, metres.
pub(crate) fn width_of(world: &mut World, name: &str) -> Option<f64> {
    let along = points_of(world, name).into_iter().map(|point| f64::from(point.x));
    let (least, most) =
        along.fold((f64::MAX, f64::MIN), |(least, most), x| (least.min(x), most.max(x)));
    (least < most).then_some(most - least)
}

/// The strain of each hard rod of the bodies of a name: the error of its length as a fraction of the length.
pub(crate) fn strains_of(world: &mut World, name: &str) -> Vec<f64> {
    let bodies = entities_named(world, name);
    let mut rods = world.query::<(&DistanceConstraint, &ConstraintOf)>();
    let hard = |(rod, of): &(&DistanceConstraint, &ConstraintOf)| {
        let held = rod.bound == Bound::Equal && rod.softness == Softness::Hard;
        held && rod.rest > 0.0 && bodies.contains(&of.0)
    };
    let strain = |(rod, _): (&DistanceConstraint, &ConstraintOf)| {
        let [a, b] = [rod.a, rod.b].map(|end| world.get::<Particle>(end).map(|p| p.position));
        let (apart, rest) = (f64::from(a?.distance(b?)), f64::from(rod.rest));
        Some((apart - rest).abs() / rest)
    };
    rods.iter(world).filter(hard).filter_map(strain).collect()
}

/// The mean of the numbers; `None` if there are none.
pub(crate) fn mean(numbers: &[f64]) -> Option<f64> {
    (!numbers.is_empty()).then(|| numbers.iter().sum::<f64>() / numbers.len() as f64)
}

/// The volume enclosed by the surface of a body, m³.
pub(crate) fn volume_of(world: &World, body: Entity) -> Option<f64> {
    let skin = world.get::<WindSurface>(body)?;
    let six = |triangle: &[Entity; 3]| {
        let [a, b, c] = triangle.map(|p| world.get::<Particle>(p).map(|p| p.position.as_dvec3()));
        Some(a?.dot(b?.cross(c?)))
    };
    skin.triangles.iter().map(six).sum::<Option<f64>>().map(|six| six / 6.0)
}

/// The volume of Bevy's UV sphere of this many sectors and stacks, m³, from its radius in metres: frusta between regular polygons, a little less than 4/3 π r³.
pub(crate) fn faceted_ball(radius: f64, sectors: u32, stacks: u32) -> f64 {
    let turn = core::f64::consts::TAU / f64::from(sectors);
    // Area of the regular polygon in a circle of radius 1.
    let polygon = 0.5 * f64::from(sectors) * libm::sin(turn);
    let ring = |i: u32| libm::sincos(core::f64::consts::PI * f64::from(i) / f64::from(stacks));
    let frusta = (0..stacks).map(|i| {
        let ((upper, top), (lower, bottom)) = (ring(i), ring(i + 1));
        polygon * (top - bottom) * (upper * upper + upper * lower + lower * lower) / 3.0
    });
    radius * radius * radius * frusta.sum::<f64>()
}

/// The upward velocity, m/s, after some seconds, of a body thrown up at `speed` under `gravity`, in air that takes the fraction `drag` of the velocity in a
/// second: v = (v₀ + g/c) exp(−ct) − g/c, with exp(−c) = 1 − drag.
pub(crate) fn thrown(speed: f64, gravity: f64, drag: f64, seconds: f64) -> f64 {
    let rate = -libm::log1p(-drag);
    if rate < 1e-9 {
        return speed - gravity * seconds;
    }
    let terminal = gravity / rate;
    (speed + terminal) * libm::exp(-rate * seconds) - terminal
}
