//! Buoyancy of loose particles: the weight of the fluid that a partly submerged sphere pushes aside (physics.md F6, F7).

use core::f32::consts::PI;

use glam::Vec3;

use crate::particles::{Particles, rate_of_drag};

/// A fluid that fills the half-space below a plane. A particle with a radius floats in it as a ball of that radius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fluid {
    /// Unit normal of the surface, out of the fluid.
    pub up: Vec3,
    /// `up · x` of the points on the surface, metres.
    pub level: f32,
    /// Density, kg/m³; water has 1000.
    pub density: f32,
    /// Share of its velocity that a wholly submerged particle loses per second, 0 to 1; in proportion while it is partly submerged.
    pub drag: f32,
}

impl Fluid {
    /// Water with its surface at y = `level` metres: 1000 kg/m³, a drag of 0.8.
    pub fn water(level: f32) -> Self {
        Self { up: Vec3::Y, level, density: 1000.0, drag: 0.8 }
    }

    /// Whether every number is finite and in range. An invalid fluid carries nothing.
    pub fn is_valid(&self) -> bool {
        (self.up.length_squared() - 1.0).abs() < 1e-3
            && self.level.is_finite()
            && self.density.is_finite()
            && self.density >= 0.0
            && (0.0..=1.0).contains(&self.drag)
    }

    /// The volume in m³ of a ball of `radius` metres at `position` that lies below the surface.
    ///
    /// The part below is a spherical cap of height `d`, with `d` from 0 (just touching) to `2r` (wholly under): `V = π d² (3r - d)/3`.
    pub fn submerged_volume(&self, position: Vec3, radius: f32) -> f32 {
        let d = (self.level - self.up.dot(position) + radius).clamp(0.0, 2.0 * radius);
        PI * d * d * (3.0 * radius - d) / 3.0
    }
}

/// Adds `-ρ V g` to each particle with a radius, and to its damping the fluid's, by the submerged share of its volume.
///
/// Rates of damping add up where shares do not, so the fluid's drag is turned into a rate first.
pub(crate) fn apply(particles: &mut Particles, fluids: &[Fluid], gravity: Vec3) {
    for fluid in fluids.iter().filter(|fluid| fluid.is_valid()) {
        let rate = rate_of_drag(fluid.drag);
        for i in 0..particles.len() {
            let radius = particles.radius[i];
            if radius == 0.0 || particles.position[i].w == 0.0 {
                continue;
            }
            let volume = fluid.submerged_volume(particles.position(i), radius);
            if volume > 0.0 {
                let share = volume / (4.0 / 3.0 * PI * radius * radius * radius);
                particles.add_force(i, gravity * (-fluid.density * volume));
                particles.medium[i] += rate * share;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_submerged_volume_is_the_caps() {
        let water = Fluid::water(0.0);
        let whole = 4.0 / 3.0 * PI * 8.0;
        let share = |y: f32| water.submerged_volume(Vec3::Y * y, 2.0) / whole;
        assert_eq!(share(2.0), 0.0);
        assert_eq!(share(5.0), 0.0);
        assert!((share(0.0) - 0.5).abs() < 1e-6);
        assert!((share(-2.0) - 1.0).abs() < 1e-6);
        assert!((share(-90.0) - 1.0).abs() < 1e-6);
        // Depth over radius 0.6527 is where a quarter is under (physics.md F6).
        assert!((share(2.0 - 0.6527 * 2.0) - 0.25).abs() < 1e-4);
    }
}
