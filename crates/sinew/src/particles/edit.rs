//! Impulses, teleports and reversal of several particles at once, as a game applies them (physics.md I6 to I8): between two steps, or at any time for all
//! particles that constraints connect.
//!
//! The state of a particle is a position and the mean velocity of the last substep (see [`particles`](super)). An impulse changes only the velocity, whichever
//! instant that belongs to: with `v = (p - p_old)/l` that is the lectures' edit of `p_old`. A teleport changes only the position, for which the lectures move
//! `p` and `p_old` by the same. Running a motion backwards swaps the two.
//!
//! All methods ignore rows that do not exist, and all but `teleport` ignore pinned rows. A non-finite argument changes nothing, and neither does a call with a
//! row that is not finite.

use glam::{DQuat, DVec3, Quat, Vec3};

use super::total_mass::TotalMass;
use super::{Particles, snap};

impl Particles {
    /// Sets the position of particle `i` in the rest shape of its body, metres, in any coordinates common to the whole body. Contacts of the body with itself
    /// let two particles come as near to each other as they are there. With `None`, the default, the particle has no rest position and keeps its distance by
    /// its radius.
    pub fn set_rest(&mut self, i: usize, place: Option<Vec3>) {
        self.note_edit();
        if place.is_some() && self.rest.is_empty() {
            self.rest.resize(self.len(), Vec3::NAN);
        }
        if let Some(rest) = self.rest.get_mut(i) {
            *rest = place.filter(|place| place.is_finite()).unwrap_or(Vec3::NAN);
        }
    }

    /// Position of particle `i` in the rest shape of its body, metres, if [set](Self::set_rest).
    pub fn rest(&self, i: usize) -> Option<Vec3> {
        self.rest.get(i).copied().filter(|place| place.is_finite())
    }

    /// Applies an impulse, N·s, to `rows` together, at their barycentre: all velocities change by the same, the total momentum by exactly the impulse.
    pub fn apply_impulse(&mut self, rows: &[u32], impulse: Vec3) {
        self.kick(rows, impulse, Vec3::ZERO, None);
    }

    /// Applies an angular impulse, N·m·s (= kg·m²/s), to `rows` together, about their barycentre: velocities change as those of a rigid body, angular momentum
    /// by exactly the impulse, momentum not at all.
    ///
    /// Rows on a line cannot turn about it: that component of the angular impulse is lost. A single particle cannot turn at all.
    pub fn apply_angular_impulse(&mut self, rows: &[u32], angular_impulse: Vec3) {
        self.kick(rows, Vec3::ZERO, angular_impulse, None);
    }

    /// Applies an impulse, N·s, to `rows` together, at a point of the world, metres: the impulse at the barycentre, and the angular impulse of its lever arm.
    /// The point need not be on any of them.
    pub fn apply_impulse_at(&mut self, rows: &[u32], impulse: Vec3, point: Vec3) {
        self.kick(rows, impulse, Vec3::ZERO, Some(point));
    }

    /// Turns `rows` about their barycentre by `rotation` (of any length but zero) and then moves them by `translation`, metres. Velocities stay bit for bit, so
    /// a body that moved north keeps moving north.
    ///
    /// Pinned rows are moved, too; if all are pinned, each has the same weight in the barycentre. The whole metres of a translation add no round-off, however
    /// many they are.
    pub fn teleport(&mut self, rows: &[u32], translation: Vec3, rotation: Quat) {
        let [x, y, z, w] = rotation.to_array().map(f64::from);
        let turn = DQuat::from_xyzw(x, y, z, w);
        let length = turn.length();
        let whole = TotalMass::of(self, rows).or_else(|| TotalMass::weighing(self, rows, |_| 1.0));
        let Some(whole) = whole else { return };
        if !(translation.is_finite() && length.is_finite() && length > 0.0) {
            return;
        }
        let turn = turn * (1.0 / length);
        let metres = snap(translation);
        let rest = (translation - metres).as_dvec3();
        // All arms first: the barycentre is stored relative to the first row, which moves as well.
        let moves: Vec<(usize, Vec3)> = present(self, rows)
            .map(|i| {
                let arm = whole.arm(self, i);
                (i, (turn * arm - arm + rest).as_vec3())
            })
            .collect();
        for (i, by) in moves {
            self.note_moved(i);
            self.origin[i] += metres;
            self.position[i] += by.extend(0.0);
            self.start[i] += by.extend(0.0);
        }
    }

    /// Sets the velocities of `rows` to those of one rigid body: the barycentre moves with `velocity`, m/s, and the rows turn about it with `angular_velocity`,
    /// rad/s, both true at this instant.
    pub fn set_motion(&mut self, rows: &[u32], velocity: Vec3, angular_velocity: Vec3) {
        let Some(whole) = TotalMass::of(self, rows) else { return };
        if !(velocity.is_finite() && angular_velocity.is_finite()) {
            return;
        }
        for i in moving(self, rows) {
            let turn = angular_velocity.as_dvec3().cross(whole.arm(self, i));
            self.set_velocity(i, (velocity.as_dvec3() + turn).as_vec3());
        }
    }

    /// Reverses the motion of `rows`: swaps the present and the previous position. Motion without damping, contacts and corrections of positions then returns
    /// to its start within round-off, with a constant step and Verlet or leapfrog integration.
    ///
    /// The swap itself goes back by one substep: after N substeps, N - 1 more lead back to the start. A row that is listed twice is reversed twice.
    pub fn reverse(&mut self, rows: &[u32]) {
        for i in moving(self, rows) {
            let (v, lag) = (self.velocity(i), self.lag(i));
            if v.is_finite() {
                self.displace(i, -v * lag);
                self.velocity[i] = (-v).extend(lag);
            }
        }
    }

    fn kick(&mut self, rows: &[u32], impulse: Vec3, turn: Vec3, point: Option<Vec3>) {
        let Some(whole) = TotalMass::of(self, rows) else { return };
        let lever = point.map_or(DVec3::ZERO, |point| whole.arm_of(self, point));
        let (impulse, turn) = (impulse.as_dvec3(), turn.as_dvec3());
        let answer = whole.response(impulse, turn + lever.cross(impulse));
        let rows = moving(self, rows);
        if rows.iter().all(|&i| answer.at(whole.arm(self, i)).is_finite()) {
            for i in rows {
                self.note_moved(i);
                let change = answer.at(whole.arm(self, i));
                self.velocity[i] += change.extend(0.0);
            }
        }
    }
}

/// The rows that exist.
fn present<'a>(particles: &Particles, rows: &'a [u32]) -> impl Iterator<Item = usize> + use<'a> {
    let len = particles.len();
    rows.iter().map(|&row| row as usize).filter(move |&i| i < len)
}

/// The rows that exist and are not pinned.
fn moving(particles: &Particles, rows: &[u32]) -> Vec<usize> {
    present(particles, rows).filter(|&i| particles.position[i].w > 0.0).collect()
}
