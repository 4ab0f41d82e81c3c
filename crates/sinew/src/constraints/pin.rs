//! Pins: a particle is held at a point, or led along a path that the game moves (physics.md C3).

use glam::Vec3;

/// "Particle `particle` is at `target`." A pinned particle must have infinite mass, so that no other constraint moves it.
///
/// Within a step of several substeps the particle is led in a straight line from where it is to `target`, so that what hangs on
/// it feels a steady motion rather than a jump in the first substep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pin {
    /// Row of the particle.
    pub particle: u32,
    /// Where it is to be at the end of the step, metres.
    pub target: Vec3,
}

impl Pin {
    /// Where the pin leads a particle that is now at `position`, with `remaining` substeps to go (this one included).
    ///
    /// The path is walked in equal parts of what is left; the last part is the target itself, to the bit.
    #[inline]
    pub(crate) fn lead(&self, position: Vec3, remaining: u32) -> Vec3 {
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
            let next = pin.lead(at, remaining);
            assert!(((next - at).length() - pin.target.length() / 4.0).abs() < 1e-6);
            at = next;
        }
        assert_eq!(at, pin.target);
    }
}
