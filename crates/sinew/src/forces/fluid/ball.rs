//! Buoyancy of loose particles: the weight of the fluid displaced by a partly submerged sphere.

use core::f32::consts::PI;

use glam::Vec3;

use super::Fluid;
use crate::forces::region::WorldPoint;
use crate::particles::Particles;

/// Adds `ρ V g` along `up` to each particle with a radius, and the fluid's drag to its damping, in proportion to the submerged share of its volume. Rows marked
/// in `carriers` float as hulls and are skipped; the slice is empty if there are no hulls.
pub(super) fn apply(particles: &mut Particles, fluid: &Fluid, gravity: Vec3, carriers: &[bool]) {
    let (rate, lift) = (fluid.rate(), fluid.up * fluid.weight(gravity));
    let (low, high) = fluid.region.extent.bounds();
    for i in 0..particles.len() {
        let radius = particles.radius[i];
        if radius == 0.0 || particles.position[i].w == 0.0 {
            continue;
        }
        if carriers.get(i).copied().unwrap_or(false) {
            continue;
        }
        // A cheap test against the bounding box of the fluid rejects most particles of a large world.
        let at = particles.origin[i] + particles.position[i].truncate();
        let reach = radius + at.abs() * 1e-6;
        if (at + reach).cmplt(low).any() || (at - reach).cmpgt(high).any() {
            continue;
        }
        let height = particles.height(i, fluid.up, fluid.level);
        let volume = cap_volume(height, radius);
        if volume > 0.0 {
            let middle = WorldPoint::of(particles, i).moved(fluid.up * -cap_drop(height, radius));
            let inside = fluid.region.share_at(middle);
            if inside > 0.0 {
                let share = volume / (4.0 / 3.0 * PI * radius * radius * radius);
                particles.push_force(i, lift * (volume * inside));
                particles.push_drag(i, rate * share * inside, fluid.current);
            }
        }
    }
}

/// Submerged volume, m³, of a ball of `radius` metres whose centre is `height` metres above the surface. A spherical cap of depth `d`, from 0 (just touching)
/// to `2r` (fully submerged), has `V = π d² (3r - d)/3`.
fn cap_volume(height: f32, radius: f32) -> f32 {
    let d = cap_depth(height, radius);
    PI * d * d * (3.0 * radius - d) / 3.0
}

/// Distance of the centroid of that volume below the centre of the ball, metres: `¾ (2r - d)²/(3r - d)`.
fn cap_drop(height: f32, radius: f32) -> f32 {
    let d = cap_depth(height, radius);
    let rest = 2.0 * radius - d;
    0.75 * rest * rest / (3.0 * radius - d)
}

fn cap_depth(height: f32, radius: f32) -> f32 {
    (radius - height).clamp(0.0, 2.0 * radius)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_submerged_volume_is_the_caps() {
        let whole = 4.0 / 3.0 * PI * 8.0;
        let share = |y: f32| cap_volume(y, 2.0) / whole;
        assert_eq!(share(2.0), 0.0);
        assert_eq!(share(5.0), 0.0);
        assert!((share(0.0) - 0.5).abs() < 1e-6);
        assert!((share(-2.0) - 1.0).abs() < 1e-6);
        assert!((share(-90.0) - 1.0).abs() < 1e-6);
        // At a depth of 0.6527 radii a quarter of the volume is submerged (physics.md F6).
        assert!((share(2.0 - 0.6527 * 2.0) - 0.25).abs() < 1e-4);
    }

    #[test]
    fn the_middle_of_what_is_under_is_the_caps_centroid() {
        assert_eq!(cap_drop(1.0, 1.0), 1.0, "just touching");
        assert!((cap_drop(0.0, 1.0) - 3.0 / 8.0).abs() < 1e-6, "half a ball");
        assert_eq!(cap_drop(-1.0, 1.0), 0.0, "wholly under");
    }
}
