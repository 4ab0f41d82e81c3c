//! Who takes part, where each was when it was looked at, and how far it may go before it must be looked at again.

use glam::{DVec3, Vec3, Vec4};

use super::super::filter::ContactFilter;
use super::super::nearby::Nearby;
use crate::particles::Particles;

/// Those that take part, in the order of their rows.
#[derive(Clone, Debug, Default)]
pub(super) struct Participants {
    /// Their rows, ascending.
    pub(super) rows: Vec<u32>,
    /// Of each its body.
    pub(super) body: Vec<u32>,
    /// Metres.
    pub(super) radius: Vec<f32>,
    /// In the rest shape of its body, metres; NaN where there is none. Empty if nobody has any.
    pub(super) rest: Vec<Vec3>,
    /// `[x y z m]`: where it was when it was looked at, metres from its own origin, and its margin: how far from there it stays within what was
    /// found.
    pub(super) home: Vec<Vec4>,
    /// Whether nothing moves it.
    pub(super) pinned: Vec<bool>,
    /// What `home` is relative to, metres.
    pub(super) origin: Vec<Vec3>,
    /// Where it was then from the origin of the first, metres; NaN for who takes no part this time.
    pub(super) place: Vec<DVec3>,
    /// How it got there in this substep, less what all did, metres; empty where that is within the margins of all.
    pub(super) path: Vec<Vec3>,
    /// Consecutive ones of one body: where they end, and whose they are.
    pub(super) runs: Vec<(usize, u32)>,
    /// Whether nobody goes farther in a step than its margin may be.
    pub(super) calm: bool,
    /// Whether somebody was too fast for what was found to last longer than this substep.
    pub(super) expired: bool,
    /// Length of the step, seconds.
    dt: f32,
}

/// The margin as a share of the radius: at least, and at most.
///
/// A wider one finds more pairs to be asked in vain in each substep, a narrower one is outrun sooner, and looking again costs as much as some five
/// substeps of asking. What lies still is asked most.
const MARGIN: [f32; 2] = [0.15, 0.4];

/// Squares of more are no `f32`, metres.
const FAR: f64 = 1e15;

impl Participants {
    /// Takes who takes part in a step of `dt` seconds, of the bodies that are near others, and keeps its memory.
    pub(super) fn take(
        &mut self,
        particles: &Particles,
        nearby: &Nearby,
        rest: &[Vec3],
        solid: &[bool],
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
            let loose = !solid.get(row).copied().unwrap_or(false);
            // A radius of no number takes no part, either.
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

    /// The highest row of all. There is one.
    pub(super) fn last(&self) -> usize {
        self.rows.last().map_or(usize::MAX, |&row| row as usize)
    }

    /// Notes where everybody is; `within` a substep, also how they got there.
    pub(super) fn place(&mut self, particles: &Particles, within: bool) {
        self.home.clear();
        self.pinned.clear();
        self.origin.clear();
        self.place.clear();
        self.path.clear();
        (self.calm, self.expired) = (true, false);
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
            self.calm &= reached <= most * radius;
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

    /// How far from where it is the margin of each may reach, metres, before it must be asked again who is about: as far again, where nobody is so fast that this
    /// would not last for another step.
    pub(super) fn allowances(&self) -> impl Iterator<Item = f32> {
        let share = if self.calm && !self.expired { 2.0 } else { 1.0 };
        self.home.iter().map(move |home| share * home.w)
    }

    /// Widens the margin of each to where it was when the substep began.
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
            // A little more, so that rounding does not ask for another look at once.
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

    /// `p_i - p_j` when they were looked at, metres, with the digits of their own origins.
    #[inline(always)]
    pub(super) fn separation(&self, i: usize, j: usize) -> Vec3 {
        (self.home[i] - self.home[j]).truncate() + (self.origin[i] - self.origin[j])
    }

    /// The distance that two may not come below, metres; `None` if they may touch.
    ///
    /// Two of one body may be as near as they are in its rest shape: mesh neighbours closer than their radii are held by their rods. Two that are at
    /// one place there (a seam) never touch.
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
