//! What is summed up afresh in every substep: acceleration and damping. Most worlds have one gravity and still air, so what all particles share is
//! one number, and the columns are read and cleared only in substeps in which something wrote to them.
//!
//! That changes no bit: a column that nobody wrote to holds zeros, and adding zero is exact.

use glam::{Vec3, Vec4};

use super::Particles;

/// What all particles have in common, as far as somebody looked: what a step needs to know to leave columns unread.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ColumnSummary {
    /// Whether gravity acts on all alike, and no force of a game's own on any.
    pub(crate) plain: bool,
    /// Whether none has a charge.
    pub(crate) neutral: bool,
    /// The damping that all have, 1/s, if it is one.
    pub(crate) damping: Option<f32>,
    /// How often properties had been [changed](Particles::edits) when somebody looked.
    seen: Option<u64>,
}

impl Particles {
    /// Looks at the columns that seldom differ, if one was written to since. To be called when a step begins; whoever writes to them later takes it
    /// back.
    pub(crate) fn revalidate(&mut self) {
        if self.column_summary.seen == Some(self.edits()) {
            return;
        }
        // Without a way out in the middle the compiler takes eight at a time.
        let first = self.damping.first().copied().unwrap_or(0.0);
        let even = self.damping.iter().fold(true, |even, &rate| even & (rate == first));
        let plain = self.gravity_scale.iter().fold(true, |plain, &scale| plain & (scale == 1.0));
        let free = self.external.iter().fold(true, |free, &force| free & (force == Vec3::ZERO));
        let plain = plain && free;
        let neutral = self.charge.iter().fold(true, |neutral, &charge| neutral & (charge == 0.0));
        let (damping, seen) = (even.then_some(first), Some(self.edits()));
        self.column_summary = ColumnSummary { plain, neutral, damping, seen };
    }

    /// Starts the sums afresh: no acceleration, and the damping `air` (1/s) alone.
    pub(crate) fn clear_sums(&mut self, air: f32) {
        if self.acceleration_dirty {
            self.acceleration.fill(Vec4::ZERO);
        }
        if self.medium_dirty {
            self.medium.fill(0.0);
        }
        (self.acceleration_dirty, self.medium_dirty) = (false, false);
        (self.common, self.air) = (Vec3::ZERO, air);
        self.drift.clear();
    }

    /// Acceleration of particle `i` as summed up so far in this substep, m/s².
    #[inline]
    pub fn acceleration(&self, i: usize) -> Vec3 {
        let common = if self.position[i].w > 0.0 { self.common } else { Vec3::ZERO };
        if self.acceleration_dirty { self.acceleration[i].truncate() + common } else { common }
    }

    /// Adds a force, N, for this substep: for force laws of the caller's own, between `accumulate_forces` and `integrate`.
    /// Forces add up; pinned particles do not notice.
    #[inline]
    pub fn add_force(&mut self, i: usize, force: Vec3) {
        self.note_write(i);
        self.acceleration_dirty = true;
        self.acceleration[i] += (force * self.position[i].w).extend(0.0);
    }

    /// Adds an acceleration, m/s², for this substep: a force that is proportional to mass, as gravity is.
    #[inline]
    pub fn add_acceleration(&mut self, i: usize, acceleration: Vec3) {
        self.note_write(i);
        self.acceleration_dirty = true;
        self.acceleration[i] += acceleration.extend(0.0);
    }

    /// Adds an acceleration, m/s², to every particle that can move.
    pub(crate) fn accelerate_all(&mut self, acceleration: Vec3) {
        self.common += acceleration;
    }

    /// Drags particle `i` towards `velocity` (m/s) in this substep, at the rate `rate` (1/s, finite): what a medium does that may be moving. Media
    /// add up.
    pub fn drag_towards(&mut self, i: usize, rate: f32, velocity: Vec3) {
        self.note_write(i);
        self.medium_dirty = true;
        self.medium[i] += rate;
        if velocity != Vec3::ZERO && self.drift.is_empty() {
            self.drift.resize(self.len(), Vec3::ZERO);
        }
        if let Some(drift) = self.drift.get_mut(i) {
            *drift += velocity * rate;
        }
    }

    /// At which rate particle `i` loses velocity in this substep, 1/s: its own damping, and that of the media that it is in.
    #[inline]
    pub(crate) fn rate(&self, i: usize) -> f32 {
        self.damping[i] + (self.air + self.medium[i])
    }
}
