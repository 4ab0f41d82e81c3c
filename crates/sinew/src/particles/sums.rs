//! What is summed up afresh in every substep: acceleration and damping. Most worlds have one gravity and still air, so what all particles share is
//! one number, and the columns are read and cleared only in substeps in which something wrote to them.
//!
//! That changes no bit: a column that nobody wrote to holds zeros, and adding zero is exact.

use glam::{Vec3, Vec4};

use super::Particles;

/// What all particles have in common, as far as somebody looked: what a step needs to know to leave columns unread.
#[derive(Clone, Debug, Default)]
pub(crate) struct ColumnSummary {
    /// Rows on which gravity acts otherwise than on all, or a force of a game's own, ascending.
    pub(crate) singular: Vec<u32>,
    /// Whether none has a charge.
    pub(crate) neutral: bool,
    /// The damping that all have, 1/s, if it is one.
    pub(crate) damping: Option<f32>,
    /// How often properties had been [changed](Particles::edits) when somebody looked.
    seen: Option<u64>,
}

impl Particles {
    /// Has gravity and the game's own force on row `i` be summed up by themselves from now on.
    pub(super) fn note_singular(&mut self, i: usize) {
        let (row, singular) = (i as u32, &mut self.column_summary.singular);
        // Mostly all are written, one after the other.
        if singular.last().is_none_or(|&last| last < row) {
            singular.push(row);
        } else if let Err(at) = singular.binary_search(&row) {
            singular.insert(at, row);
        }
        self.note_pushed(i);
    }

    /// Nothing is known of what all rows have in common; of those that there still are it is known which differ.
    pub(super) fn forget_summary(&mut self) {
        let (rows, summary) = (self.len(), &mut self.column_summary);
        if summary.singular.last().is_some_and(|&row| row as usize >= rows) {
            let singular = summary.singular.partition_point(|&row| (row as usize) < rows);
            summary.singular.truncate(singular);
        }
        (summary.neutral, summary.damping, summary.seen) = (false, None, None);
    }

    /// Looks at the columns that seldom differ, if one was written to since. To be called when a step begins; whoever writes to them later takes it
    /// back.
    pub(crate) fn revalidate(&mut self) {
        if self.column_summary.seen == Some(self.edits()) {
            return;
        }
        // Without a way out in the middle the compiler takes eight at a time.
        let first = self.damping.first().copied().unwrap_or(0.0);
        let even = self.damping.iter().fold(true, |even, &rate| even & (rate == first));
        let mut singular = core::mem::take(&mut self.column_summary.singular);
        singular.clear();
        let is_singular =
            |&i: &usize| self.gravity_scale[i] != 1.0 || self.external[i] != Vec3::ZERO;
        singular.extend((0..self.len()).filter(is_singular).map(|row| row as u32));
        let neutral = self.charge.iter().fold(true, |neutral, &charge| neutral & (charge == 0.0));
        let (damping, seen) = (even.then_some(first), Some(self.edits()));
        self.column_summary = ColumnSummary { singular, neutral, damping, seen };
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
        self.note_pushed(i);
        self.push_force(i, force);
    }

    /// The same for force laws of ours, of which it is known on which rows they act.
    #[inline]
    pub(crate) fn push_force(&mut self, i: usize, force: Vec3) {
        self.push_acceleration(i, force * self.position[i].w);
    }

    /// Adds an acceleration, m/s², for this substep: a force that is proportional to mass, as gravity is.
    #[inline]
    pub fn add_acceleration(&mut self, i: usize, acceleration: Vec3) {
        self.note_pushed(i);
        self.push_acceleration(i, acceleration);
    }

    /// The same for force laws of ours.
    #[inline]
    pub(crate) fn push_acceleration(&mut self, i: usize, acceleration: Vec3) {
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
        self.note_pushed(i);
        self.push_drag(i, rate, velocity);
    }

    /// The same for media of ours.
    pub(crate) fn push_drag(&mut self, i: usize, rate: f32, velocity: Vec3) {
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
