//! Broad phase: the surfaces that each row may touch in a step.

use glam::Vec3;

use super::super::features::Features;
use super::super::frame::Frame;
use super::super::nearby;
use super::super::shape::{Reachable, Shape};
use super::super::world::World;
use super::surface::SurfaceForm;
use super::{NO_FACE, NormalImpulse, ParticleContacts, SurfaceCandidate};
use crate::particles::Particles;

/// Scratch of sorting candidates by row.
#[derive(Clone, Debug, Default)]
pub(super) struct CandidateSort {
    /// Row and candidate, surface by surface.
    found: Vec<(u32, SurfaceCandidate)>,
    /// Swept bounds of each island.
    pub(super) islands: Vec<(Vec3, Vec3)>,
}

impl ParticleContacts {
    /// Finds the candidates of a step, and resets an accumulated impulse for each.
    pub(super) fn broad_phase(
        &mut self,
        particles: &Particles,
        world: &World,
        features: &Features,
        normal_impulses: &mut Vec<NormalImpulse>,
    ) {
        self.first.clear();
        self.candidates.clear();
        self.faces.clear();
        self.elastic.clear();
        self.late.0.clear();
        normal_impulses.clear();
        self.reaches.clear();
        self.batches.clear();
        self.features.clear();
        self.inside.clear();
        self.ignored.clear();
        self.set_recovery(world.dt / world.substeps.max(1) as f32, world.g());
        if self.is_empty() {
            return;
        }
        self.record_references(particles, world);
        if !self.surfaces.is_empty() {
            self.find_ignored(particles, world);
            self.find_candidates(particles, world);
            if !features.is_empty() {
                self.find_features(particles, world, features);
            }
            normal_impulses.resize(self.candidates.len(), NormalImpulse::default());
        }
        self.find_reaches(particles, world.islands);
        self.make_batches(particles, world.islands);
    }

    /// Lists the surfaces with the rows that ignore them.
    fn find_ignored(&mut self, particles: &Particles, world: &World) {
        for (surface, number) in self.surfaces.iter().zip(0..) {
            if surface.is_ignored(world.filter) {
                let rows = (0..).zip(&particles.body);
                let ignoring = rows.filter(|&(_, &body)| !surface.may_touch(world.filter, body));
                self.ignored.extend(ignoring.map(|(row, _)| [number, row]));
            }
        }
    }

    /// A box about all poses of a surface in the step, between two of which the motion is nearly straight; infinite for planes and rooms.
    pub(super) fn bounds_of_surface(&self, number: usize) -> (Vec3, Vec3) {
        match &self.surfaces[number].form {
            SurfaceForm::Shape(shape) => self.swept_bounds(number, shape, None),
            _ => (Vec3::NEG_INFINITY, Vec3::INFINITY),
        }
    }

    /// The same about a shape of a surface, or about one that has a frame in that of the surface.
    pub(super) fn swept_bounds(
        &self,
        number: usize,
        shape: &Shape,
        part: Option<&Frame>,
    ) -> (Vec3, Vec3) {
        let steps = self.frames.len() / self.surfaces.len();
        let instants = if self.surfaces[number].moves { steps } else { 1 };
        let frames = self.frames.iter().skip(number).step_by(self.surfaces.len()).take(instants);
        frames
            .map(|frame| shape.bounds_in(&frame.of_part(part)))
            .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), (least, most)| {
                (low.min(least), high.max(most))
            })
    }

    /// Finds the surfaces that each row may touch.
    fn find_candidates(&mut self, particles: &Particles, world: &World) {
        let islands = world.islands;
        let classes = self.classes.all().len();
        self.sort.found.clear();
        for number in 0..self.surfaces.len() {
            let (low, high) = self.bounds_of_surface(number);
            for (island, &(least, most)) in islands.list.iter().zip(&self.sort.islands) {
                if least.cmpgt(high).any() || most.cmplt(low).any() {
                    continue;
                }
                for &row in &islands.members[island.members.clone()] {
                    let i = row as usize;
                    let way = self.reference[i].w.sqrt();
                    let reach = way + particles.radius[i];
                    let at = particles.origin[i] + particles.position[i].truncate();
                    let near = (at + reach).cmpge(low).all() && (at - reach).cmple(high).all();
                    let pinned = particles.position[i].w == 0.0;
                    if !near || self.is_excluded(row) || pinned {
                        continue;
                    }
                    let material = self.materials[number * classes + self.classes.of(row)];
                    let Some(material) = material.filter(|_| !self.ignores(row, number)) else {
                        continue;
                    };
                    let gravity = world.row_gravity.of(row);
                    let candidate = SurfaceCandidate::new(number, material, gravity);
                    let surface = &self.surfaces[number];
                    let reachable = surface.reachable(&self.frames[number], particles, (i, way));
                    let face = match reachable {
                        Reachable::Nothing => continue,
                        Reachable::Several => NO_FACE,
                        Reachable::Face(face) => {
                            self.faces.push(face);
                            self.faces.len() as u32 - 1
                        }
                    };
                    self.sort.found.push((row, SurfaceCandidate { face, ..candidate }));
                }
            }
        }
        self.sort_by_row(particles.len());
    }

    /// Records the position of each row and how far it may move, and the swept bounds of each island.
    fn record_references(&mut self, particles: &Particles, world: &World) {
        let islands = world.islands;
        self.reference.resize(particles.len(), glam::Vec4::ZERO);
        self.sort.islands.clear();
        for island in &islands.list {
            let members = &islands.members[island.members.clone()];
            let rows = || members.iter().map(|&row| row as usize);
            // An island whose rows all belong to body colliders gets an empty box.
            if members.iter().all(|&row| self.is_excluded(row)) {
                self.sort.islands.push((Vec3::INFINITY, Vec3::NEG_INFINITY));
                continue;
            }
            let fastest = rows()
                .map(|i| particles.velocity[i].truncate().length_squared())
                .fold(0.0, f32::max)
                .sqrt();
            let reach = nearby::reach(fastest, world.g(), world.dt);
            let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
            for i in rows() {
                self.reference[i] = particles.position[i].truncate().extend(reach * reach);
                let at = particles.origin[i] + particles.position[i].truncate();
                let around = reach + particles.radius[i];
                (low, high) = (low.min(at - around), high.max(at + around));
            }
            self.sort.islands.push((low, high));
        }
    }

    /// Counting sort of the candidates by row, stable in the order of surfaces.
    fn sort_by_row(&mut self, rows: usize) {
        let Self {
            first, candidates, elastic, surfaces, sort: CandidateSort { found, .. }, ..
        } = self;
        first.resize(rows + 1, 0);
        for &(row, _) in found.iter() {
            first[row as usize + 1] += 1;
        }
        for row in 0..rows {
            first[row + 1] += first[row];
        }
        candidates.resize(found.len(), SurfaceCandidate::default());
        // The entry of each row advances as it fills, and ends where that of the next row began.
        for &(row, candidate) in found.iter() {
            let place = &mut first[row as usize];
            candidates[*place as usize] = candidate;
            if candidate.restitution > 0.0 && !surfaces[candidate.surface as usize].sensor {
                elastic.push([row, *place]);
            }
            *place += 1;
        }
        first.rotate_right(1);
        first[0] = 0;
    }
}
