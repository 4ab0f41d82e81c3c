//! Pins: hold a particle at a point, or move it kinematically towards a target set by the game (physics.md C3).

use glam::Vec3;

/// Places a particle at a target position. The particle must have infinite mass, so that no other constraint moves it.
///
/// Within a step of several substeps the particle moves in a straight line from its position to `target`, so that attached particles see a steady motion rather
/// than a jump in the first substep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pin {
    /// Row of the particle.
    pub particle: u32,
    /// Position of the particle at the end of the step, metres.
    pub target: Vec3,
}

impl Pin {
    /// The next position of a particle that is now at `position`, with `remaining` substeps to go (this one included).
    ///
    /// Each substep covers an equal part of the remaining path; the last ends exactly on the target.
    #[inline]
    pub(crate) fn step_towards_target(&self, position: Vec3, remaining: u32) -> Vec3 {
        if remaining <= 1 || !position.is_finite() {
            self.target
        } else {
            position + (self.target - position) / remaining as f32
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_path_is_walked_evenly_and_ends_on_the_target() {
        let pin = Pin { particle: 0, target: Vec3::new(0.3, 0.7, -0.1) };
        let mut at = Vec3::ZERO;
        for remaining in (1..=4).rev() {
            let next = pin.step_towards_target(at, remaining);
            assert!(((next - at).length() - pin.target.length() / 4.0).abs() < 1e-6);
            at = next;
        }
        assert_eq!(at, pin.target);
    }
}
