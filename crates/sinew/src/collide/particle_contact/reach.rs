//! Which rows of an island may touch anything in a step: what is out of reach of all there is costs nothing but a look at how far it went.

use glam::Vec3;

use super::super::bounds::ClassBounds;
use super::{NormalImpulses, ParticleContacts};
use crate::islands::Islands;
use crate::particles::{Particles, Places};

impl ParticleContacts {
    /// Puts all rows of island `number` on the right side of everything, once, with friction; returns how far out the farthest was, metres.
    #[inline(never)]
    pub(crate) fn project_island(
        &self,
        places: &mut Places,
        normal_impulses: &mut NormalImpulses,
        (number, rows): (usize, &[u32]),
        substep: u32,
    ) -> f32 {
        let (rows, strays) = self.in_reach(places, number, rows);
        let common = self.common_bounds();
        let depths = rows.iter().map(|&row| {
            let bounds = self.bounds_of(row, strays, common);
            self.project(places, normal_impulses, (row, bounds), substep)
        });
        depths.fold(0.0, f32::max)
    }

    /// How far out the farthest of the rows of an island is at the end of a step, metres, moving nothing.
    pub(crate) fn island_error(&self, places: &Places, number: usize, rows: &[u32]) -> f32 {
        let (rows, strays) = self.in_reach(places, number, rows);
        let common = self.common_bounds();
        let errors = rows.iter().map(|&row| {
            let bounds = self.bounds_of(row, strays, common);
            self.error(places, row, bounds)
        });
        errors.fold(0.0, f32::max)
    }

    /// What bounds all rows alike, if they are of one class.
    fn common_bounds(&self) -> Option<&ClassBounds> {
        self.classes.of_everyone().map(|class| self.bounds.of(class))
    }

    /// What bounds a row; `None` of one that is far from all there is.
    #[inline]
    fn bounds_of<'a>(
        &'a self,
        row: u32,
        strays: bool,
        common: Option<&'a ClassBounds>,
    ) -> Option<&'a ClassBounds> {
        if !(strays || self.bounded[row as usize]) {
            return None;
        }
        Some(common.unwrap_or_else(|| self.bounds.of(self.classes.of(row))))
    }

    /// Those of the rows of an island that may touch something now, and whether one has gone further than was looked: then that is any of them.
    pub(super) fn in_reach<'a>(
        &'a self,
        places: &Places,
        number: usize,
        rows: &'a [u32],
    ) -> (&'a [u32], bool) {
        let strayed = |&row: &u32| {
            let last_seen = self.last_seen[row as usize];
            (places.position[places.at(row)] - last_seen).truncate().length_squared() > last_seen.w
        };
        match self.reaches.get(number) {
            Some(reach) if !rows.iter().any(strayed) => (&self.touching[reach.clone()], false),
            _ => (rows, true),
        }
    }

    /// Those of the rows of an island that may touch something, while none has gone further than was looked; `None` where nobody looked.
    pub(crate) fn touching(&self, number: usize) -> Option<&[u32]> {
        self.reaches.get(number).map(|reach| &self.touching[reach.clone()])
    }

    /// Where each row was when it was looked for, from its origin, and the square of how far it may go from there, m².
    pub(crate) fn last_seen(&self) -> &[glam::Vec4] {
        &self.last_seen
    }

    /// Puts a row that touches surfaces by itself outside of those, as [`project_island`](Self::project_island) does; returns how far out it was,
    /// metres.
    pub(crate) fn project_row(
        &self,
        places: &mut Places,
        normal_impulses: &mut NormalImpulses,
        row: u32,
        substep: u32,
    ) -> f32 {
        if self.is_solid(row) || places.position[places.at(row)].w == 0.0 {
            return 0.0;
        }
        self.leave(places, normal_impulses, row, substep)
    }

    /// Finds them, when the boxes of the islands and the candidates of the rows are known.
    pub(super) fn find_reaches(&mut self, particles: &Particles, islands: &Islands) {
        let Self { first, last_seen, reaches, touching, bounded, bounds, sort, .. } = self;
        reaches.clear();
        touching.clear();
        bounded.clear();
        bounded.resize(particles.len(), false);
        for (island, &(low, high)) in islands.list.iter().zip(&sort.islands) {
            let begin = touching.len();
            let held = bounds.hold(low, high);
            if !(held && first.is_empty()) {
                for &row in &islands.members[island.members.clone()] {
                    let i = row as usize;
                    if !held {
                        let at = particles.origin[i] + particles.position[i].truncate();
                        let around = last_seen[i].w.sqrt() + particles.radius[i];
                        bounded[i] = !bounds.hold(at - around, at + around);
                    }
                    let has_candidates = i + 1 < first.len() && first[i] < first[i + 1];
                    if bounded[i] || has_candidates {
                        touching.push(row);
                    }
                }
            }
            reaches.push(begin..touching.len());
        }
    }
}

/// What a coordinate of a box may be off by, as a share of it: it is a sum of two roundings.
const ROUNDED: f32 = 1e-6;

impl super::Bounds {
    /// Whether a box in the world is so far inside of all of them that nothing in it touches any.
    fn hold(&self, low: Vec3, high: Vec3) -> bool {
        if self.has_plane_constraint() {
            return false;
        }
        // A box of nothing at all.
        if low.cmpgt(high).any() {
            return true;
        }
        let slack = low.abs().max(high.abs()) * ROUNDED;
        let (low, high) = (low - slack, high + slack);
        let (planes, boxes) = self.all();
        let held = planes.iter().all(|plane| {
            let (n, offset) = (plane.normal.as_dvec3(), f64::from(plane.offset));
            let lowest = (n * low.as_dvec3()).min(n * high.as_dvec3()).element_sum();
            lowest >= offset + 1e-6 * offset.abs()
        });
        held && boxes.iter().all(|room| low.cmpge(room.min).all() && high.cmple(room.max).all())
    }
}
