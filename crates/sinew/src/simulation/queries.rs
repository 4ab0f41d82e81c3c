//! Spatial queries: ray casts, shape casts, overlaps, and the nearest particle.
//!
//! They test the world as the last step left it, item by item in index order, without an acceleration structure: a query costs some nanoseconds for each
//! particle and collider.

use glam::Vec3;

use super::Simulation;
use crate::collide::{
    AtStart, BodyCollider, ContactParticipant, Frame, Layers, ManifoldScratch, Obstacle, Shape,
    SweepHit, SweepMotion, collide, half_spaces,
};
use crate::particles::NO_BODY;
use crate::pose::pose;

/// What a query includes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Filter {
    /// Layers of the query; it includes what [interacts with](Layers::interacts_with) them. Default everything.
    pub layers: Layers,
    /// Whether colliders are included, and planes and boxes of [`Boundaries`](crate::Boundaries), which are in all layers. Default true.
    pub colliders: bool,
    /// Whether sensors are included among colliders. Default false.
    pub sensors: bool,
    /// Whether bodies and loose particles are included. Default true.
    pub bodies: bool,
    /// One participant to exclude, for instance the one that casts. Default none.
    pub except: Option<ContactParticipant>,
}

/// A hit of a ray or a shape cast.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// What was hit.
    pub participant: ContactParticipant,
    /// The particle that was hit, or the first particle of the triangle or body collider that was; `None` for colliders, planes and boxes.
    pub row: Option<u32>,
    /// Distance from the start of the cast, metres.
    pub distance: f32,
    /// Point of contact, metres.
    pub point: Vec3,
    /// Unit normal of the surface that was hit, outward.
    pub normal: Vec3,
}

/// Longest reach of an endless ray, metres: this distance and its square are finite in `f32`.
const FARTHEST_RAY: f32 = 1e18;
/// Longest way of a shape cast, metres. Longer ways are cut, because no bounding box can enclose an infinite one.
pub(super) const FARTHEST_CAST: f32 = 1e6;

impl Default for Filter {
    fn default() -> Self {
        Self {
            layers: Layers::new(u32::MAX, u32::MAX),
            colliders: true,
            sensors: false,
            bodies: true,
            except: None,
        }
    }
}

impl Simulation {
    /// First hit of a ray within `max` metres: a collider, a plane, a wall of a box from inside, a body collider, a triangle of a surface from either side, or
    /// a particle's sphere. The direction need not be a unit vector; a zero direction hits nothing.
    pub fn cast_ray(
        &self,
        origin: Vec3,
        direction: Vec3,
        max: f32,
        filter: &Filter,
    ) -> Option<Hit> {
        let direction = direction.try_normalize()?;
        let mut ray = Ray { origin, direction, max, first: None };
        // A component of the direction may be zero, and infinity times zero is NaN.
        let end = origin + direction * max.min(FARTHEST_RAY);
        let around = enlarged((origin.min(end), origin.max(end)));
        self.all_within(around, filter, &mut |participant, row, obstacle| {
            let met = match obstacle {
                Obstacle::Shape(shape, frame) => ray.shape(shape, frame),
                Obstacle::Triangle(corners) => ray.triangle(*corners),
                Obstacle::Ball(at, radius) => ray.ball(*at, *radius),
            };
            if let Some((distance, normal)) = met {
                ray.meet(distance, normal, participant, row);
            }
        });
        ray.first
    }

    /// First hit of a convex shape that moves up to `max` metres along a direction, without turning: a collider, a plane, a wall of a box, a body collider, a
    /// triangle of a surface from either side, or a particle's sphere. Nothing is tunnelled through, however far it goes and however thin that is. What it
    /// overlaps at the start is hit at distance zero. The direction need not be a unit vector; a zero direction hits nothing, and neither do half-spaces,
    /// meshes and heightfields when they are the moving shape.
    pub fn cast_shape(
        &self,
        shape: &Shape,
        frame: &Frame,
        direction: Vec3,
        max: f32,
        filter: &Filter,
    ) -> Option<Hit> {
        let direction = direction.try_normalize()?;
        let motion = SweepMotion {
            direction,
            length: max,
            clearance: 0.0,
            start: AtStart::Overlapped,
            along: &[],
        };
        Some(self.sweep(shape, frame, &motion, filter)?.hit())
    }

    /// Shape cast with a given [`SweepMotion`]. Of several simultaneous hits the first found counts.
    pub(super) fn sweep(
        &self,
        shape: &Shape,
        frame: &Frame,
        motion: &SweepMotion,
        filter: &Filter,
    ) -> Option<SweptHit> {
        if !(frame.is_valid() && motion.length >= 0.0) {
            return None;
        }
        let mut motion = SweepMotion { length: motion.length.min(FARTHEST_CAST), ..*motion };
        let (low, high) = shape.bounds_in(frame);
        let by = motion.direction * motion.length;
        let around = (low.min(low + by) - motion.clearance, high.max(high + by) + motion.clearance);
        let mut first: Option<SweptHit> = None;
        self.obstacles(around, filter, &mut |participant, row, obstacle| {
            let Some(at) = shape.sweep(frame, &motion, obstacle) else { return };
            let nearest = first.map_or(at.distance, |first| first.at.distance.min(at.distance));
            if first.is_none_or(|first| at.is_before(&first.at, &motion)) {
                first = Some(SweptHit { participant, row, at });
            }
            if let Some(first) = &mut first {
                first.at.distance = nearest;
            }
            motion.length = motion.length.min(at.distance + motion.tie_tolerance());
        });
        first
    }

    /// Calls `call` with all that is included, collides, and may be in a box: colliders, walls, body colliders, triangles, particles' spheres.
    pub(super) fn obstacles(
        &self,
        around: (Vec3, Vec3),
        filter: &Filter,
        call: &mut dyn FnMut(ContactParticipant, Option<u32>, &Obstacle),
    ) {
        self.all_within(around, filter, &mut |participant, row, obstacle| {
            let collides = match obstacle {
                Obstacle::Shape(..) => true,
                // Particles and triangles of a body collider collide by its shape.
                Obstacle::Triangle(_) => !row.is_some_and(|row| self.is_excluded(row)),
                Obstacle::Ball(_, radius) => *radius > 0.0,
            };
            if collides {
                call(participant, row, obstacle);
            }
        });
    }

    /// [`obstacles`](Self::obstacles), and what does not collide: triangles that are part of a body collider, and particles without a radius.
    fn all_within(
        &self,
        around: (Vec3, Vec3),
        filter: &Filter,
        call: &mut dyn FnMut(ContactParticipant, Option<u32>, &Obstacle),
    ) {
        let in_reach = |obstacle: &Obstacle| {
            let (low, high) = obstacle.bounds();
            low.cmple(around.1).all() && high.cmpge(around.0).all()
        };
        for (number, collider) in self.colliders.iter().enumerate() {
            let obstacle = Obstacle::Shape(&collider.shape, collider.end);
            if self.counts_collider(number, filter) && in_reach(&obstacle) {
                call(ContactParticipant::Collider(number as u32), None, &obstacle);
            }
        }
        self.walls(filter, &mut |participant, wall, frame| {
            let obstacle = Obstacle::Shape(wall, frame);
            if in_reach(&obstacle) {
                call(participant, None, &obstacle);
            }
        });
        if !filter.bodies {
            return;
        }
        for solid in &self.body_colliders {
            let Some((participant, row)) = self.counts_solid(solid, filter) else { continue };
            let obstacle = match self.frame_near(solid, around) {
                Some(frame) => Obstacle::Shape(&solid.shape, frame),
                None => continue,
            };
            if in_reach(&obstacle) {
                call(participant, Some(row), &obstacle);
            }
        }
        for corners in &self.forces.surfaces {
            let Some(participant) = self.counts_row(corners[0], filter) else { continue };
            // A triangle with a missing particle is skipped.
            if corners.iter().any(|&row| row as usize >= self.particles.len()) {
                continue;
            }
            let obstacle =
                Obstacle::Triangle(corners.map(|row| self.particles.position(row as usize)));
            if in_reach(&obstacle) {
                call(participant, Some(corners[0]), &obstacle);
            }
        }
        for row in 0..self.particles.len() as u32 {
            let i = row as usize;
            let obstacle = Obstacle::Ball(self.particles.position(i), self.particles.radius[i]);
            if in_reach(&obstacle)
                && !self.is_excluded(row)
                && let Some(participant) = self.counts_row(row, filter)
            {
                call(participant, Some(row), &obstacle);
            }
        }
    }

    /// Calls `call` with the included planes, and with the walls of boxes, as half-spaces.
    fn walls(&self, filter: &Filter, call: &mut dyn FnMut(ContactParticipant, &Shape, Frame)) {
        let everywhere = Layers::new(u32::MAX, u32::MAX);
        let none = self.boundaries.planes.is_empty() && self.boundaries.boxes.is_empty();
        if none || !filter.colliders || !everywhere.interacts_with(filter.layers) {
            return;
        }
        let solid = Shape::half_space();
        half_spaces(&self.boundaries, &mut |participant, frame| {
            if filter.except != Some(participant) {
                call(participant, &solid, frame);
            }
        });
    }

    /// Frame of a body collider, if it may be in a box: no point of it is farther from its first particle than that particle is from the collider's origin,
    /// plus the shape's farthest point from it.
    fn frame_near(&self, solid: &BodyCollider, around: (Vec3, Vec3)) -> Option<Frame> {
        let (&row, &rest) = (solid.rows.first()?, solid.rest.first()?);
        let (low, high) = solid.shape.bounds();
        let reach = low.abs().max(high.abs()).length() + rest.length();
        let at = self.particles.position(row as usize);
        let near = (at - at.clamp(around.0, around.1)).length_squared() <= reach * reach;
        if near { self.frame_of(solid) } else { None }
    }

    /// Calls `found` with everything that overlaps a shape: once for each collider, plane and body collider and for each wall of a box, and with a row for each
    /// triangle of a surface and each particle. Particles are spheres of their radii, zero included.
    pub fn overlaps(
        &self,
        shape: &Shape,
        frame: &Frame,
        filter: &Filter,
        mut found: impl FnMut(ContactParticipant, Option<u32>),
    ) {
        if !frame.is_valid() {
            return;
        }
        let around = enlarged(shape.bounds_in(frame));
        self.all_within(around, filter, &mut |participant, row, obstacle| {
            let overlaps = match obstacle {
                Obstacle::Shape(theirs, at) => overlap(shape, theirs, &frame.from_within(at)),
                Obstacle::Triangle(corners) => {
                    !row.is_some_and(|row| self.is_excluded(row))
                        && shape.overlaps_triangle(frame, corners)
                }
                Obstacle::Ball(at, radius) => shape.nearest(frame.local(*at)).distance <= *radius,
            };
            if overlaps {
                found(participant, row);
            }
        });
    }

    /// The particle whose centre is nearest to a point, within `max` metres, and its distance; the first of equals.
    pub fn nearest_particle(&self, point: Vec3, max: f32, filter: &Filter) -> Option<(u32, f32)> {
        let mut nearest = None;
        let mut least = max;
        for row in 0..self.particles.len() as u32 {
            let distance = self.particles.relative_to(row as usize, point).length();
            // False for NaN, too.
            let nearer = distance < least || (nearest.is_none() && distance <= least);
            if nearer && self.counts_row(row, filter).is_some() {
                (nearest, least) = (Some(row), distance);
            }
        }
        nearest.map(|row| (row, least))
    }

    fn counts_collider(&self, number: usize, filter: &Filter) -> bool {
        let collider = &self.colliders[number];
        filter.colliders
            && collider.is_valid()
            && (filter.sensors || !collider.sensor)
            && collider.layers.interacts_with(filter.layers)
            && filter.except != Some(ContactParticipant::Collider(number as u32))
    }

    /// The participant that a row belongs to, if the filter includes it.
    fn counts_row(&self, row: u32, filter: &Filter) -> Option<ContactParticipant> {
        let body = *self.particles.body.get(row as usize)?;
        let participant = if body == NO_BODY {
            ContactParticipant::Particle(row)
        } else {
            ContactParticipant::Body(body)
        };
        let own = self.contacts.get(body as usize).copied().unwrap_or_default();
        let met = !own.disabled && own.layers.interacts_with(filter.layers);
        let counts = filter.bodies && met && filter.except != Some(participant);
        counts.then_some(participant)
    }

    /// The participant that a body collider belongs to, with its first row, if the filter includes it.
    fn counts_solid(
        &self,
        solid: &BodyCollider,
        filter: &Filter,
    ) -> Option<(ContactParticipant, u32)> {
        let row = *solid.rows.first()?;
        self.counts_row(row, filter).map(|participant| (participant, row))
    }

    /// Pose of a body collider, fitted to its particles.
    pub(super) fn frame_of(&self, solid: &BodyCollider) -> Option<Frame> {
        let points = solid.rows.iter().zip(&*solid.rest).filter_map(|(&row, &rest)| {
            let i = row as usize;
            (i < self.particles.len())
                .then(|| (self.particles.position(i), rest, self.particles.mass(i)))
        });
        let found = pose(points, glam::Quat::IDENTITY)?;
        Some(Frame::new(found.translation, found.rotation))
    }

    /// Whether a row does not collide by itself: it is part of a body collider, which collides in its place, or its body takes no part in contacts.
    fn is_excluded(&self, row: u32) -> bool {
        self.scratch.contacts.is_excluded(row)
    }
}

/// First hit of a shape cast.
#[derive(Clone, Copy)]
pub(super) struct SweptHit {
    participant: ContactParticipant,
    row: Option<u32>,
    pub(super) at: SweepHit,
}

impl SweptHit {
    /// The hit as it is returned to the caller.
    pub(super) fn hit(&self) -> Hit {
        let Self { participant, row, at: SweepHit { distance, point, normal, .. } } = *self;
        Hit { participant, row, distance, point: point.as_vec3(), normal: normal.as_vec3() }
    }
}

/// A box with a margin against rounding, so that contacts in the last digit are not missed.
fn enlarged((low, high): (Vec3, Vec3)) -> (Vec3, Vec3) {
    let margin = 1e-6 * low.abs().max(high.abs()).max_element();
    (low - margin, high + margin)
}

/// Whether two shapes overlap; `a_in_b` is the frame of the first in that of the second.
fn overlap(a: &Shape, b: &Shape, a_in_b: &Frame) -> bool {
    let mut overlaps = false;
    collide(a, b, a_in_b, 0.0, &mut ManifoldScratch::default(), &mut |_| overlaps = true);
    overlaps
}

/// A ray and its first hit so far.
struct Ray {
    origin: Vec3,
    direction: Vec3,
    /// Remaining length, metres.
    max: f32,
    first: Option<Hit>,
}

impl Ray {
    fn meet(
        &mut self,
        distance: f32,
        normal: Vec3,
        participant: ContactParticipant,
        row: Option<u32>,
    ) {
        if (0.0..=self.max).contains(&distance) && (self.first.is_none() || distance < self.max) {
            let point = self.origin + self.direction * distance;
            self.max = distance;
            self.first = Some(Hit { participant, row, distance, point, normal });
        }
    }

    /// Distance to a shape, metres, and its unit normal there; `None` if the ray misses it. The same for the methods below.
    fn shape(&self, shape: &Shape, frame: &Frame) -> Option<(f32, Vec3)> {
        let (origin, direction) = (frame.local(self.origin), frame.turn_back(self.direction));
        let hit = shape.cast_ray(origin, direction, self.max)?;
        Some((hit.distance, frame.turn(hit.normal)))
    }

    /// Solves `|o + t d - c|² = r²`. From inside, the distance is zero; a sphere without a radius is never hit.
    fn ball(&self, centre: Vec3, radius: f32) -> Option<(f32, Vec3)> {
        let from = self.origin - centre;
        let along = from.dot(self.direction);
        let outside = from.length_squared() - radius * radius;
        let beneath = along * along - outside;
        let inside = outside <= 0.0;
        if radius <= 0.0 || !(inside || (beneath >= 0.0 && along < 0.0)) {
            return None;
        }
        let distance = if inside { 0.0 } else { -along - beneath.sqrt() };
        // Normalised, because for a small sphere far off the difference has few digits.
        let normal = (from + self.direction * distance).try_normalize();
        Some((distance, normal.unwrap_or(-self.direction)))
    }

    /// Möller and Trumbore, *Fast, Minimum Storage Ray/Triangle Intersection*, 1997: Cramer's rule for `o + t d = a + u (b - a) + v (c - a)`.
    fn triangle(&self, [a, b, c]: [Vec3; 3]) -> Option<(f32, Vec3)> {
        let (ab, ac, from) = (b - a, c - a, self.origin - a);
        let across = self.direction.cross(ac);
        let volume = ab.dot(across);
        if volume == 0.0 {
            return None;
        }
        let u = from.dot(across) / volume;
        let other = from.cross(ab);
        let (v, distance) = (self.direction.dot(other) / volume, ac.dot(other) / volume);
        (u >= 0.0 && v >= 0.0 && u + v <= 1.0).then(|| {
            let normal = ab.cross(ac).normalize_or_zero();
            // The normal of the side that was hit.
            (distance, if normal.dot(self.direction) > 0.0 { -normal } else { normal })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collide::Collider;
    use crate::particles::ParticleSeed;
    use crate::recipes::{BoxSpec, ClothSpec, box_3d, cloth_grid};

    /// A ground, a box of 1 m at 5 m along x, a cloth at 10 m, and a ball at 3 m along z.
    fn world() -> Simulation {
        let mut world = Simulation::default();
        world.colliders.push(Collider::fixed(Shape::half_space(), Frame::at(Vec3::NEG_Y)));
        let cube = box_3d(&BoxSpec::default()).unwrap();
        let cube = cube.transformed(glam::Quat::IDENTITY, Vec3::X * 5.0);
        cube.build_colliding(&mut world, Default::default()).unwrap();
        let turned = glam::Quat::from_xyzw(0.0, 1.0, 0.0, 1.0);
        let cloth = cloth_grid(&ClothSpec::default()).unwrap().transformed(turned, Vec3::X * 10.0);
        cloth.build_colliding(&mut world, Default::default()).unwrap();
        world.particles.push(ParticleSeed::at(Vec3::Z * 3.0).with_radius(0.5)).unwrap();
        world.forces.gravity = Vec3::ZERO;
        world.step(1e-3).unwrap();
        world
    }

    #[test]
    fn a_ray_meets_the_first_thing_in_its_way_and_what_does_not_count_is_passed() {
        let world = world();
        let all = Filter::default();
        let hit = world.cast_ray(Vec3::ZERO, Vec3::X * 7.0, 100.0, &all).unwrap();
        assert_eq!(hit.participant, ContactParticipant::Body(0));
        assert!(
            (hit.distance - 4.5).abs() < 1e-4 && (hit.normal + Vec3::X).length() < 1e-4,
            "{hit:?}"
        );
        let past = Filter { except: Some(ContactParticipant::Body(0)), ..all };
        let hit = world.cast_ray(Vec3::ZERO, Vec3::X, 100.0, &past).unwrap();
        assert_eq!(hit.participant, ContactParticipant::Body(1));
        assert!(
            (hit.distance - 10.0).abs() < 0.01 && (hit.normal + Vec3::X).length() < 1e-4,
            "{hit:?}"
        );
        let hit = world.cast_ray(Vec3::ZERO, Vec3::Z, 100.0, &all).unwrap();
        assert!(
            (hit.distance - 2.5).abs() < 1e-4
                && matches!(hit.participant, ContactParticipant::Particle(_)),
            "{hit:?}"
        );
        let hit = world.cast_ray(Vec3::ZERO, Vec3::NEG_Y, 100.0, &all).unwrap();
        assert_eq!((hit.participant, hit.row), (ContactParticipant::Collider(0), None));
        assert!((hit.point + Vec3::Y).length() < 1e-5);
        assert_eq!(world.cast_ray(Vec3::ZERO, Vec3::NEG_Y, 0.9, &all), None, "too short");
        assert_eq!(world.cast_ray(Vec3::ZERO, Vec3::ZERO, 9.0, &all), None, "no direction");
        let bodies = Filter { colliders: false, ..all };
        assert_eq!(world.cast_ray(Vec3::ZERO, Vec3::NEG_Y, 100.0, &bodies), None);
        assert_eq!(world.cast_ray(Vec3::NAN, Vec3::NEG_Y, 100.0, &all), None);
    }

    /// Found by fuzzing: the triangle's first particle existed, and another did not.
    #[test]
    fn a_ray_passes_a_triangle_whose_particle_is_gone() {
        let mut world = world();
        world.forces.surfaces.insert(0, [0, 1, 1_000_000]);
        let hit = world.cast_ray(Vec3::ZERO, Vec3::X, 100.0, &Filter::default()).unwrap();
        assert_eq!(hit.participant, ContactParticipant::Body(0));
    }

    #[test]
    fn a_shape_meets_the_first_thing_on_its_way_with_the_side_that_leads() {
        let world = world();
        let all = Filter::default();
        let ball = Shape::sphere(0.5).unwrap();
        let cast = |shape: &Shape, from: Vec3, direction: Vec3, filter: &Filter| {
            world.cast_shape(shape, &Frame::at(from), direction, 100.0, filter)
        };
        let hit = cast(&ball, Vec3::ZERO, Vec3::X * 3.0, &all).unwrap();
        assert_eq!(hit.participant, ContactParticipant::Body(0));
        assert!((hit.distance - 4.0).abs() < 1e-4 && hit.normal.abs_diff_eq(-Vec3::X, 1e-3));
        assert!((hit.point.x - 4.5).abs() < 1e-3, "{hit:?}");
        let past = Filter { except: Some(ContactParticipant::Body(0)), ..all };
        let hit = cast(&ball, Vec3::ZERO, Vec3::X, &past).unwrap();
        assert_eq!(hit.participant, ContactParticipant::Body(1), "the cloth, by its triangles");
        assert!((hit.distance - 9.5).abs() < 0.02, "{hit:?}");
        let hit = cast(&ball, Vec3::ZERO, Vec3::Z, &all).unwrap();
        assert!(matches!(hit.participant, ContactParticipant::Particle(_)));
        assert!((hit.distance - 2.0).abs() < 1e-4, "{hit:?}");
        // A box turned by 45 degrees comes down on an edge.
        let tilted =
            Frame::new(Vec3::Y * 3.0, glam::Quat::from_xyzw(0.0, 0.0, 0.3826834, 0.9238795));
        let cube = Shape::cuboid(Vec3::ONE).unwrap();
        let hit = world.cast_shape(&cube, &tilted, Vec3::NEG_Y, 100.0, &all).unwrap();
        assert_eq!(hit.participant, ContactParticipant::Collider(0));
        assert!((hit.distance - (4.0 - 0.5 * 2f32.sqrt())).abs() < 1e-4, "{hit:?}");
        assert!(hit.normal.abs_diff_eq(Vec3::Y, 1e-4));
        // Overlapping from the start; too short; no direction; a shape that cannot be cast.
        let hit = cast(&ball, Vec3::new(5.0, 0.9, 0.0), Vec3::Y, &all).unwrap();
        assert_eq!((hit.participant, hit.distance), (ContactParticipant::Body(0), 0.0));
        assert_eq!(world.cast_shape(&ball, &Frame::IDENTITY, Vec3::X, 3.9, &all), None);
        assert_eq!(cast(&ball, Vec3::ZERO, Vec3::ZERO, &all), None);
        assert_eq!(cast(&ball, Vec3::NAN, Vec3::X, &all), None);
        assert_eq!(cast(&Shape::half_space(), Vec3::Y * 9.0, Vec3::NEG_Y, &past), None);
    }

    /// At its hit distance a cast shape touches what it hit, and overlapped nothing before.
    #[test]
    fn a_cast_of_any_shape_ends_where_it_touches() {
        let world = world();
        let all = Filter::default();
        let shapes = [
            Shape::sphere(0.3).unwrap(),
            Shape::capsule(0.2, 0.6).unwrap(),
            Shape::cuboid(Vec3::new(0.3, 0.5, 0.7)).unwrap(),
            Shape::cylinder(0.25, 0.5).unwrap(),
        ];
        let mut met = 0;
        for (number, shape) in shapes.iter().enumerate() {
            for step in 0..40 {
                let angle = step as f32 * 0.157;
                let turn = glam::Quat::from_xyzw(0.3, 0.1 * step as f32, -0.2, 1.0);
                let from = Frame::new(Vec3::new(2.0, 1.5, 1.0), turn);
                let direction = Vec3::new(libm::cosf(angle), -0.35, 0.5 * libm::sinf(angle));
                let Some(hit) = world.cast_shape(shape, &from, direction, 50.0, &all) else {
                    continue;
                };
                met += 1;
                let direction = direction.normalize();
                let mut found = false;
                for (share, touches) in [(hit.distance - 2e-3, false), (hit.distance + 2e-3, true)]
                {
                    let there = Frame { translation: from.translation + direction * share, ..from };
                    let mut any = false;
                    world.overlaps(shape, &there, &all, |_, _| any = true);
                    found |= any != touches;
                }
                // At grazing incidence two millimetres may not be enough.
                assert!(!found || hit.normal.dot(direction).abs() < 0.1, "{number} {step} {hit:?}");
                assert!(hit.normal.dot(direction) < 1e-3, "{hit:?}");
            }
        }
        assert!(met > 80, "{met}");
    }

    #[test]
    fn a_shape_finds_what_it_overlaps() {
        let world = world();
        let probe = Shape::sphere(1.0).unwrap();
        let found = |at: Vec3| {
            let mut found = Vec::new();
            let all = Filter::default();
            world.overlaps(&probe, &Frame::at(at), &all, |participant, _| found.push(participant));
            found.dedup();
            found
        };
        assert_eq!(found(Vec3::new(5.0, 1.2, 0.0)), [ContactParticipant::Body(0)]);
        assert_eq!(
            found(Vec3::new(5.0, -0.5, 0.0)),
            [ContactParticipant::Collider(0), ContactParticipant::Body(0)]
        );
        assert_eq!(found(Vec3::new(10.2, 0.5, 0.0)), [ContactParticipant::Body(1)]);
        assert_eq!(found(Vec3::Y * 20.0), []);
    }

    #[test]
    fn the_nearest_particle_is_found_within_reach() {
        let world = world();
        let all = Filter::default();
        let (row, distance) = world.nearest_particle(Vec3::Z * 3.25, 1.0, &all).unwrap();
        assert!((distance - 0.25).abs() < 1e-5 && row as usize == world.particles.len() - 1);
        assert_eq!(world.nearest_particle(Vec3::Y * 50.0, 1.0, &all), None);
        assert_eq!(world.nearest_particle(Vec3::NAN, 1.0, &all), None);
    }
}
