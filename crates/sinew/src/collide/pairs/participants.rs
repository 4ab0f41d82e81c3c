//! The particles that take part, their positions when the neighbour list was built, and their margins (skin).

use glam::{DVec3, Vec3, Vec4};

use super::super::filter::ContactFilter;
use super::super::nearby::Nearby;
use crate::particles::Particles;

/// The participants, in the order of their rows.
#[derive(Clone, Debug, Default)]
pub(super) struct Participants {
    /// Their rows, ascending.
    pub(super) rows: Vec<u32>,
    /// Body of each.
    pub(super) body: Vec<u32>,
    /// Radius of each, metres.
    pub(super) radius: Vec<f32>,
    /// Position of each in the rest shape of its body, metres; NaN where there is none. Empty if no particle has one.
    pub(super) rest: Vec<Vec3>,
    /// `[x y z m]`: position when the neighbour list was built, metres from its own origin, and margin: the list stays complete as long as the particle is
    /// within this distance of that position, metres.
    pub(super) home: Vec<Vec4>,
    /// Whether it has infinite mass.
    pub(super) pinned: Vec<bool>,
    /// The origin that `home` is relative to, metres.
    pub(super) origin: Vec<Vec3>,
    /// The same position relative to the origin of the first participant, metres; NaN for a particle that takes no part this time.
    pub(super) place: Vec<DVec3>,
    /// Its displacement in this substep relative to the mean, metres; empty where no displacement exceeds the margin.
    pub(super) path: Vec<Vec3>,
    /// Runs of consecutive participants of one body: end and body of each.
    pub(super) runs: Vec<(usize, u32)>,
    /// Whether no particle moves further in a step than the greatest allowed margin.
    pub(super) slow: bool,
    /// Whether a particle was too fast for the neighbour list to last longer than this substep.
    pub(super) expired: bool,
    /// Length of the step, seconds.
    dt: f32,
}

/// The margin as a share of the radius: minimum and maximum.
///
/// A wider one adds pairs that are tested in vain in each substep; a narrower one is exceeded sooner, and a rebuild costs as much as testing in about five
/// substeps. The minimum applies to particles at rest, which are the most frequent case.
const MARGIN: [f32; 2] = [0.15, 0.4];

/// Squares of larger coordinates overflow `f32`, metres.
const FAR: f64 = 1e15;

impl Participants {
    /// Collects the participants of a step of `dt` seconds from the bodies that are near others.
    pub(super) fn collect(
        &mut self,
        particles: &Particles,
        nearby: &Nearby,
        rest: &[Vec3],
        excluded: &[bool],
        dt: f32,
    ) {
        for column in [&mut self.rows, &mut self.body] {
            column.clear();
        }
        self.radius.clear();
        self.rest.clear();
        self.runs.clear();
        self.expired = false;
        self.dt = dt;
        let columns = particles.body.iter().zip(&particles.radius);
        for (row, (&body, &radius)) in columns.enumerate() {
            let loose = excluded.get(row) != Some(&true);
            // False for a NaN radius, too.
            if !(nearby.to_particles().has_particle(row, body) && loose && radius > 0.0) {
                continue;
            }
            self.rows.push(row as u32);
            self.body.push(body);
            self.radius.push(radius);
            match self.runs.last_mut() {
                Some((end, of)) if *of == body => *end += 1,
                _ => self.runs.push((self.rows.len(), body)),
            }
        }
        if !rest.is_empty() {
            let place = |&row: &u32| rest.get(row as usize).copied().unwrap_or(Vec3::NAN);
            self.rest.extend(self.rows.iter().map(place));
        }
    }

    /// The highest row; there is at least one participant.
    pub(super) fn last(&self) -> usize {
        self.rows.last().map_or(usize::MAX, |&row| row as usize)
    }

    /// Records positions and computes margins; `within` a substep, also displacements.
    pub(super) fn place(&mut self, particles: &Particles, within: bool) {
        self.home.clear();
        self.pinned.clear();
        self.origin.clear();
        self.place.clear();
        self.path.clear();
        (self.slow, self.expired) = (true, false);
        let finite = |row: &u32| particles.position[*row as usize].is_finite();
        let first = self.rows.iter().copied().find(finite).unwrap_or(self.rows[0]);
        let zero = particles.origin[first as usize];
        for (&row, &radius) in self.rows.iter().zip(&self.radius) {
            let i = row as usize;
            let (position, origin) = (particles.position[i], particles.origin[i]);
            let place = (origin - zero).as_dvec3() + position.truncate().as_dvec3();
            let reached = particles.velocity[i].truncate().length() * self.dt;
            let [least, most] = MARGIN;
            let margin = reached.max(least * radius).min(most * radius);
            self.slow &= reached <= most * radius;
            self.home.push(position.truncate().extend(margin));
            self.pinned.push(position.w == 0.0);
            self.origin.push(origin);
            let neighbours = place.abs().max_element() < FAR;
            self.place.push(if neighbours { place } else { DVec3::NAN });
        }
        if within {
            self.follow(particles);
        }
    }

    /// Distance from its recorded position that the margin of each may reach before candidates must be found again, metres: twice the margin, or the margin
    /// alone where a particle is so fast that the candidates would not last for another step anyway.
    pub(super) fn allowances(&self) -> impl Iterator<Item = f32> {
        let share = if self.slow && !self.expired { 2.0 } else { 1.0 };
        self.home.iter().map(move |home| share * home.w)
    }

    /// Widens the margin of each to its displacement in this substep.
    fn follow(&mut self, particles: &Particles) {
        let path = |&row: &u32| {
            let i = row as usize;
            (particles.position[i] - particles.start[i]).truncate()
        };
        let (mut sum, mut count) = (DVec3::ZERO, 0.0);
        for path in self.rows.iter().map(path).filter(|path| path.is_finite()) {
            sum += path.as_dvec3();
            count += 1.0;
        }
        let mean = if count > 0.0 { (sum / count).as_vec3() } else { Vec3::ZERO };
        for (row, home) in self.rows.iter().zip(&mut self.home) {
            let path = path(row) - mean;
            self.path.push(path);
            // Slightly more, so that rounding does not trigger another rebuild at once.
            let length = path.length() * 1.001;
            if length > home.w {
                home.w = length;
                self.expired = true;
            }
        }
        if !self.expired {
            self.path.clear();
        }
    }

    /// `p_i - p_j` when the list was built, metres, at the precision of their own origins.
    #[inline(always)]
    pub(super) fn separation(&self, i: usize, j: usize) -> Vec3 {
        (self.home[i] - self.home[j]).truncate() + (self.origin[i] - self.origin[j])
    }

    /// The least allowed distance of a pair, metres; `None` if the two may not touch.
    ///
    /// Two particles of one body may be as close as they are in its rest shape: mesh neighbours closer than their radii are kept apart by their rods. Two that
    /// coincide in the rest shape (a seam) never touch.
    #[inline(always)]
    pub(super) fn reach(&self, filter: &ContactFilter, i: usize, j: usize) -> Option<f32> {
        let apart = self.radius[i] + self.radius[j];
        let (a, b) = (self.body[i], self.body[j]);
        if !filter.rows_may_touch((a, self.rows[i]), (b, self.rows[j])) {
            return None;
        }
        if a != b || self.rest.is_empty() {
            return Some(apart);
        }
        let rest = (self.rest[i] - self.rest[j]).length();
        if rest < apart { (rest > 0.0).then_some(rest) } else { Some(apart) }
    }
}
