//! Sensors among static and kinematic geometry: the body colliders that are in one when a step begins, and those that meet one in the step.
//!
//! A sensor moves nothing, so the way of a body collider through a step is known at its end. It is then cast along the straight line of its displacement
//! relative to the sensor, turned as when the step began. What a thin sensor misses are tips of shapes that turn through it within a step, and bodies that
//! come back within one.

use glam::Vec3;

use super::super::frame::Frame;
use super::super::impact::{ContactParticipant, Impacts};
use super::super::manifold::{ManifoldScratch, collide};
use super::super::shape::Shape;
use super::super::sweep::{AtStart, Obstacle, SweepMotion};
use super::groups::BodyGroups;
use super::swept_bounds::SweptBounds;
use crate::particles::Particles;

/// Overlaps of sensors and body colliders in a step.
#[derive(Clone, Debug, Default)]
pub(super) struct Sensors {
    overlaps: Vec<SensorOverlap>,
    paths: Vec<SensorPath>,
}

/// Overlap of a sensor and a body collider, in world coordinates.
#[derive(Clone, Copy, Debug)]
struct SensorOverlap {
    participants: [ContactParticipant; 2],
    point: Vec3,
    normal: Vec3,
}

/// A body collider near a sensor that it does not overlap, from the beginning of the step or the instant at which the pair was found.
#[derive(Clone, Debug)]
pub(super) struct SensorPath {
    pub(super) participants: [ContactParticipant; 2],
    /// Number of the body collider.
    pub(super) number: u32,
    /// Its shape and that of the sensor, and their frames then, from `origin`.
    pub(super) shapes: [Shape; 2],
    pub(super) frames: [Frame; 2],
    /// Mean position of its particles then, from `origin`, metres.
    pub(super) mean: Vec3,
    /// Displacement until the end of the step that the sensor gives to what moves with it, metres.
    pub(super) carried: Vec3,
    pub(super) origin: Vec3,
}

impl Sensors {
    /// Begins a step.
    pub(super) fn begin(&mut self) {
        self.overlaps.clear();
        self.paths.clear();
    }

    /// Records a body collider near a sensor.
    pub(super) fn note(
        &mut self,
        path: SensorPath,
        swept: &SweptBounds,
        scratch: &mut ManifoldScratch,
    ) {
        let ([shape, sensor], [own, here]) = (&path.shapes, &path.frames);
        let mut found = None;
        collide(shape, sensor, &own.from_within(here), 0.0, scratch, &mut |manifold| {
            let first = manifold.points().first();
            found = found.or(first.map(|point| (own.point(point.on_a), manifold.normal)));
        });
        // The surface of a mesh is that of its triangles: what is wholly inside touches none.
        let centre = here.local(swept.centre);
        if found.is_none() && sensor.contains(centre) {
            found = Some((swept.centre, sensor.nearest(centre).normal));
        }
        let Some((point, normal)) = found else { return self.paths.push(path) };
        let (point, normal) = (path.origin + point, here.turn(normal));
        self.overlaps.push(SensorOverlap { participants: path.participants, point, normal });
    }

    /// Reports all overlaps of the step, at the end of it.
    pub(super) fn report(
        &mut self,
        groups: &BodyGroups,
        particles: &Particles,
        impacts: &mut Impacts,
    ) {
        let Self { overlaps, paths } = self;
        overlaps.extend(paths.drain(..).filter_map(|path| path.overlap(groups, particles)));
        for SensorOverlap { participants, point, normal } in overlaps.drain(..) {
            impacts.add(participants, point, normal, 0.0, true);
        }
    }
}

impl SensorPath {
    /// Where the body collider meets the sensor on its way, if it does.
    fn overlap(&self, groups: &BodyGroups, particles: &Particles) -> Option<SensorOverlap> {
        let rows = &groups.rows[groups.parts[self.number as usize].entries.clone()];
        let mut sum = Vec3::ZERO;
        for i in rows.iter().map(|&row| row as usize) {
            let position = particles.position.get(i)?.truncate();
            sum += position + (particles.origin[i] - self.origin);
        }
        let way = sum / rows.len() as f32 - self.mean - self.carried;
        let length = way.length();
        if length.is_nan() || length <= 0.0 {
            return None;
        }
        let motion = SweepMotion {
            direction: way / length,
            length,
            clearance: 0.0,
            start: AtStart::Overlapped,
            along: &[],
        };
        let ([shape, sensor], [own, here]) = (&self.shapes, &self.frames);
        let hit = shape.sweep(own, &motion, &Obstacle::Shape(sensor, *here))?;
        let (point, normal) = (self.origin + hit.point.as_vec3(), hit.normal.as_vec3());
        Some(SensorOverlap { participants: self.participants, point, normal })
    }
}
