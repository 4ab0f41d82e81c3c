//! The rows of an island that may touch anything in a step: rows out of reach cost only the check of how far they have moved.

use glam::{Vec3, Vec4};

use super::super::bounds::ClassBounds;
use super::{InstantInterval, NormalImpulses, ParticleContacts};
use crate::islands::Islands;
use crate::lanes::{InstructionSet, LANES, Lanes, Vector, kernel};
use crate::particles::{Particles, Places};

impl ParticleContacts {
    /// Projects all rows of island `number` out of everything once, with friction; returns the greatest depth, metres.
    #[inline(never)]
    pub(crate) fn project_island(
        &self,
        places: &mut Places,
        normal_impulses: &mut NormalImpulses,
        (number, rows): (usize, &[u32]),
        (interval, instructions): (InstantInterval, InstructionSet),
    ) -> f32 {
        let worst = self.project_island_rows(
            places,
            normal_impulses,
            (number, rows),
            (interval, instructions),
        );
        worst.max(self.project_features(places, number, interval))
    }

    /// The same for the rows alone, without what is between them.
    #[inline]
    fn project_island_rows(
        &self,
        places: &mut Places,
        normal_impulses: &mut NormalImpulses,
        (number, rows): (usize, &[u32]),
        (interval, instructions): (InstantInterval, InstructionSet),
    ) -> f32 {
        let (near, exceeded) = self.in_reach(places, number, rows, instructions);
        if exceeded || !self.has_batches(number) {
            let common = self.common_bounds();
            let depths = near.iter().map(|&row| {
                let bounds = self.bounds_of(row, exceeded, common);
                self.project(places, normal_impulses, (row, bounds), interval)
            });
            return depths.fold(0.0, f32::max);
        }
        // Rows do not interact, so projecting all of them out of the plain bounds first and then out of the surfaces gives the same result as row by row.
        let batches = (number, interval);
        let mut worst = self.leave_bounds_in_batches(places, batches, instructions);
        if worst > 0.0 && near.iter().any(|&row| self.exceeds_skin(places, row)) {
            for &row in near {
                worst = worst.max(self.project_row(places, normal_impulses, row, interval));
            }
        } else {
            let depth = self.leave_in_batches(places, normal_impulses, batches, instructions);
            worst = worst.max(depth);
        }
        if self.holds_in_plane() {
            for &row in near {
                worst = worst.max(self.project_into_plane(places, row));
            }
        }
        worst
    }

    /// Projects these rows out of everything, wherever they have moved to.
    pub(crate) fn project_rows(
        &self,
        places: &mut Places,
        normal_impulses: &mut NormalImpulses,
        rows: impl Iterator<Item = u32>,
        interval: InstantInterval,
    ) {
        if self.is_empty() {
            return;
        }
        let common = self.common_bounds();
        for row in rows {
            let bounds = self.bounds_of(row, true, common);
            self.project(places, normal_impulses, (row, bounds), interval);
        }
    }

    /// The greatest depth of the rows of an island at the end of a step, metres. Moves nothing.
    pub(crate) fn island_error(
        &self,
        places: &Places,
        (number, rows): (usize, &[u32]),
        instructions: InstructionSet,
    ) -> f32 {
        // Particles of body colliders do not collide themselves.
        if rows.iter().all(|&row| self.is_excluded(row)) {
            return 0.0;
        }
        let (rows, exceeded) = self.in_reach(places, number, rows, instructions);
        let common = self.common_bounds();
        let errors = rows.iter().map(|&row| {
            let bounds = self.bounds_of(row, exceeded, common);
            self.error(places, row, bounds)
        });
        errors.fold(0.0, f32::max)
    }

    /// The plain bounds of all rows, if there is only one body class.
    fn common_bounds(&self) -> Option<&ClassBounds> {
        self.classes.common().map(|class| self.bounds.of(class))
    }

    /// The plain bounds of a row; `None` for a row that is far from all of them.
    #[inline]
    fn bounds_of<'a>(
        &'a self,
        row: u32,
        exceeded: bool,
        common: Option<&'a ClassBounds>,
    ) -> Option<&'a ClassBounds> {
        if !(exceeded || self.bounded[row as usize]) {
            return None;
        }
        Some(common.unwrap_or_else(|| self.bounds.of(self.classes.of(row))))
    }

    /// The rows of an island that may touch something now, and whether one has moved further than the broad phase allowed for: then all rows are returned.
    pub(super) fn in_reach<'a>(
        &'a self,
        places: &Places,
        number: usize,
        rows: &'a [u32],
        instructions: InstructionSet,
    ) -> (&'a [u32], bool) {
        match self.reaches.get(number) {
            Some(reach) if !self.any_exceeds_skin(places, rows, instructions) => {
                (&self.touching[reach.clone()], false)
            }
            _ => (rows, true),
        }
    }

    /// Whether a row of these has moved further than the broad phase allowed for.
    fn any_exceeds_skin(
        &self,
        places: &Places,
        rows: &[u32],
        instructions: InstructionSet,
    ) -> bool {
        let (Some(&first), Some(&last)) = (rows.first(), rows.last()) else { return false };
        if (last - first) as usize + 1 != rows.len() {
            return rows.iter().any(|&row| self.exceeds_skin(places, row));
        }
        // Rows are mostly contiguous: then all are checked, which takes less time than to branch after each.
        let now = &places.position[places.at(first)..][..rows.len()];
        let reference = &self.reference[first as usize..][..rows.len()];
        any_beyond(now, reference, instructions)
    }

    /// Whether a row has moved further than the broad phase allowed for.
    #[inline]
    pub(super) fn exceeds_skin(&self, places: &Places, row: u32) -> bool {
        is_beyond(places.position[places.at(row)], self.reference[row as usize])
    }

    /// Whether the only row of an island may touch something now.
    #[inline]
    pub(crate) fn may_touch(&self, places: &Places, number: usize, row: u32) -> bool {
        match self.reaches.get(number) {
            Some(reach) => !reach.is_empty() || self.exceeds_skin(places, row),
            None => true,
        }
    }

    /// The rows of an island that may touch something as long as none has moved further than the broad phase allowed for; `None` where no broad phase ran.
    pub(crate) fn touching(&self, number: usize) -> Option<&[u32]> {
        self.reaches.get(number).map(|reach| &self.touching[reach.clone()])
    }

    /// `[x y z d²]`: position of each row when the broad phase ran, from its origin, and the square of the distance that it may move from there, m².
    pub(crate) fn reference(&self) -> &[glam::Vec4] {
        &self.reference
    }

    /// Projects a row out of its surfaces, as [`project_island`](Self::project_island) does; returns the greatest depth, metres.
    pub(crate) fn project_row(
        &self,
        places: &mut Places,
        normal_impulses: &mut NormalImpulses,
        row: u32,
        interval: InstantInterval,
    ) -> f32 {
        if self.is_excluded(row) || places.position[places.at(row)].w == 0.0 {
            return 0.0;
        }
        self.project_to_surfaces(places, normal_impulses, row, interval)
    }

    /// Finds the rows in reach, once the bounds of the islands and the candidates of the rows are known.
    pub(super) fn find_reaches(&mut self, particles: &Particles, islands: &Islands) {
        let Self { first, reference, reaches, touching, bounded, bounds, sort, .. } = self;
        reaches.clear();
        touching.clear();
        bounded.clear();
        bounded.resize(particles.len(), false);
        for (island, &(low, high)) in islands.list.iter().zip(&sort.islands) {
            let begin = touching.len();
            let held = bounds.contain(low, high);
            if !(held && first.is_empty()) {
                for &row in &islands.members[island.members.clone()] {
                    let i = row as usize;
                    if !held {
                        let at = particles.origin[i] + particles.position[i].truncate();
                        let around = reference[i].w.sqrt() + particles.radius[i];
                        bounded[i] = !bounds.contain(at - around, at + around);
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

/// Whether a position is further from that of the broad phase than it allowed for.
#[inline(always)]
fn is_beyond(now: Vec4, reference: Vec4) -> bool {
    (now - reference).truncate().length_squared() > reference.w
}

kernel!(
    /// Whether any of these positions [is](is_beyond).
    fn any_beyond<L: Lanes>(now: &[Vec4], reference: &[Vec4]) -> bool {
        let (eights, others) = now.as_chunks::<LANES>();
        let (eights_reference, others_reference) = reference.as_chunks::<LANES>();
        let mut beyond = L::zero();
        for (now, reference) in eights.iter().zip(eights_reference) {
            let (now, _) = Vector::of(L::run(now, 0));
            let (reference, most) = Vector::of(L::run(reference, 0));
            beyond = beyond.or(most.lt((now - reference).length_squared()));
        }
        let others = others.iter().zip(others_reference);
        others.fold(beyond.any(), |any, (&now, &reference)| any | is_beyond(now, reference))
    }
);

/// Rounding of a coordinate of a box, relative: it is a sum of two rounded values.
const ROUNDED: f32 = 1e-6;

impl super::Bounds {
    /// Whether a box in the world is so far inside of all bounds that nothing in it touches one.
    fn contain(&self, low: Vec3, high: Vec3) -> bool {
        if self.has_plane_constraint() {
            return false;
        }
        // An empty box.
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
