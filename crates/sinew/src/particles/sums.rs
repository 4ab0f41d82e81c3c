//! Sums that start afresh in every substep: acceleration and damping. Most worlds have uniform gravity and still air, so the part that all particles share is
//! kept as one value, and the columns are read and cleared only in substeps in which something wrote to them.
//!
//! That changes no bit: a column that was not written to holds zeros, and adding zero is exact.

use glam::{Vec3, Vec4};

use super::Particles;

/// Summary of columns that are mostly uniform, valid as of the last [`revalidate`](Particles::revalidate): it lets a step leave them unread.
#[derive(Clone, Debug, Default)]
pub(crate) struct ColumnSummary {
    /// Rows with a gravity scale other than 1 or an external force, ascending.
    pub(crate) nonuniform: Vec<u32>,
    /// Whether no particle has a charge.
    pub(crate) neutral: bool,
    /// The damping of all particles, 1/s, if it is the same.
    pub(crate) damping: Option<f32>,
    /// [Edits](Particles::edits) of the particles when the columns were last read.
    as_of: Option<u64>,
}

impl Particles {
    /// Lists row `i` as one whose gravity and external force are summed separately.
    pub(super) fn note_nonuniform(&mut self, i: usize) {
        let (row, nonuniform) = (i as u32, &mut self.column_summary.nonuniform);
        // Mostly all rows are written, in ascending order.
        if nonuniform.last().is_none_or(|&last| last < row) {
            nonuniform.push(row);
        } else if let Err(at) = nonuniform.binary_search(&row) {
            nonuniform.insert(at, row);
        }
        self.note_pushed(i);
    }

    /// Discards the summary, except the nonuniform rows that still exist.
    pub(super) fn forget_summary(&mut self) {
        let (rows, summary) = (self.len(), &mut self.column_summary);
        if summary.nonuniform.last().is_some_and(|&row| row as usize >= rows) {
            let nonuniform = summary.nonuniform.partition_point(|&row| (row as usize) < rows);
            summary.nonuniform.truncate(nonuniform);
        }
        (summary.neutral, summary.damping, summary.as_of) = (false, None, None);
    }

    /// Reads the columns that are mostly uniform again, if one was written to since. To be called when a step begins; later writes discard the summary.
    pub(crate) fn revalidate(&mut self) {
        if self.column_summary.as_of == Some(self.edits()) {
            return;
        }
        // Without an early exit the compiler vectorises the loop.
        let first = self.damping.first().copied().unwrap_or(0.0);
        let even = self.damping.iter().fold(true, |even, &rate| even & (rate == first));
        let mut nonuniform = core::mem::take(&mut self.column_summary.nonuniform);
        nonuniform.clear();
        let is_nonuniform =
            |&i: &usize| self.gravity_scale[i] != 1.0 || self.external[i] != Vec3::ZERO;
        nonuniform.extend((0..self.len()).filter(is_nonuniform).map(|row| row as u32));
        let neutral = self.charge.iter().fold(true, |neutral, &charge| neutral & (charge == 0.0));
        let (damping, as_of) = (even.then_some(first), Some(self.edits()));
        self.column_summary = ColumnSummary { nonuniform, neutral, damping, as_of };
    }

    /// Clears the sums: no acceleration, and the damping `rate` (1/s) of all particles.
    pub(crate) fn clear_sums(&mut self, rate: f32) {
        if self.acceleration_dirty {
            self.acceleration.fill(Vec4::ZERO);
        }
        if self.medium_dirty {
            self.medium.fill(0.0);
        }
        (self.acceleration_dirty, self.medium_dirty) = (false, false);
        (self.uniform_acceleration, self.uniform_damping) = (Vec3::ZERO, rate);
        self.drift.clear();
    }

    /// Acceleration of particle `i` summed so far in this substep, m/s².
    #[inline]
    pub fn acceleration(&self, i: usize) -> Vec3 {
        let uniform = if self.position[i].w > 0.0 { self.uniform_acceleration } else { Vec3::ZERO };
        if self.acceleration_dirty { self.acceleration[i].truncate() + uniform } else { uniform }
    }

    /// Adds a force, N, for this substep: for a force law of the caller's, between `accumulate_forces` and `integrate`. Forces add up; pinned particles are not
    /// affected.
    #[inline]
    pub fn add_force(&mut self, i: usize, force: Vec3) {
        self.note_pushed(i);
        self.push_force(i, force);
    }

    /// [`add_force`](Self::add_force) for the crate's own force laws, whose rows are known.
    #[inline]
    pub(crate) fn push_force(&mut self, i: usize, force: Vec3) {
        self.push_acceleration(i, force * self.position[i].w);
    }

    /// Adds an acceleration, m/s², for this substep: a force proportional to mass, as gravity is.
    #[inline]
    pub fn add_acceleration(&mut self, i: usize, acceleration: Vec3) {
        self.note_pushed(i);
        self.push_acceleration(i, acceleration);
    }

    /// [`add_acceleration`](Self::add_acceleration) for the crate's own force laws.
    #[inline]
    pub(crate) fn push_acceleration(&mut self, i: usize, acceleration: Vec3) {
        self.note_write(i);
        self.acceleration_dirty = true;
        self.acceleration[i] += acceleration.extend(0.0);
    }

    /// Adds an acceleration, m/s², to every particle that is not pinned.
    pub(crate) fn accelerate_all(&mut self, acceleration: Vec3) {
        self.uniform_acceleration += acceleration;
    }

    /// Drags particle `i` towards `velocity` (m/s) in this substep, at the rate `rate` (1/s, finite): the effect of a medium, which may be moving. Media add
    /// up.
    pub fn drag_towards(&mut self, i: usize, rate: f32, velocity: Vec3) {
        self.note_pushed(i);
        self.push_drag(i, rate, velocity);
    }

    /// [`drag_towards`](Self::drag_towards) for the crate's own media.
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

    /// Rate at which particle `i` loses velocity in this substep, 1/s: its own damping, and that of the media it is in.
    #[inline]
    pub(crate) fn rate(&self, i: usize) -> f32 {
        self.damping[i] + (self.uniform_damping + self.medium[i])
    }
}
