//! Planar drag (physics.md F8): where a particle touches a plane, its velocity is split along and across the plane, and each component is damped at its own
//! rate. Coulomb friction, which needs no drag and can stick, is in [`collide`](crate::collide).

use glam::Vec3;

use crate::particles::{Particles, drag_of_rate, rate_of_drag};

/// Shares of the velocity that a particle loses per second while it touches a plane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlanarDrag {
    /// Share of the velocity along the plane, 0 to 1. Default 0.
    pub along: f32,
    /// Share of the velocity across the plane, in either direction, 0 to 1: how sticky it is. Default 0.
    pub across: f32,
}

impl PlanarDrag {
    /// Whether both values are in range. If not, the plane is skipped.
    pub fn is_valid(self) -> bool {
        (0.0..=1.0).contains(&self.along) && (0.0..=1.0).contains(&self.across)
    }
}

/// Distance to a plane within which a particle counts as touching it, metres: a resting particle is slightly above or below.
const TOUCH: f32 = 1e-3;

impl PlanarDrag {
    /// The shares of the velocity along and across the plane that are lost in `h` seconds: `1 - (1 - drag)^h`.
    pub(crate) fn lost_in(self, h: f32) -> [f32; 2] {
        [self.along, self.across].map(|drag| drag_of_rate(rate_of_drag(drag) * h))
    }

    /// Damps the velocities of particles that touch a plane with this drag over a substep of `h` seconds: `v_t ← v_t (1 - along)^h`, `v_n ← v_n (1 -
    /// across)^h`. Rows flagged in `excluded` belong to bodies with collision shapes of their own and are skipped.
    pub(crate) fn apply(
        self,
        particles: &mut Particles,
        (normal, offset): (Vec3, f32),
        excluded: &[bool],
        h: f32,
    ) {
        let lost = self.lost_in(h);
        for i in 0..particles.len() {
            let above = particles.height(i, normal, offset) - particles.radius[i];
            let is_excluded = excluded.get(i).is_some_and(|&excluded| excluded);
            if above > TOUCH || is_excluded || particles.position[i].w == 0.0 {
                continue;
            }
            let velocity = particles.velocity[i].truncate();
            let towards: Vec3 = normal * velocity.dot(normal);
            let taken = (velocity - towards) * lost[0] + towards * lost[1];
            particles.velocity[i] -= taken.extend(0.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constraints::boundaries::Plane;
    use crate::particles::ParticleSeed;
    use crate::simulation::Simulation;

    #[test]
    fn each_part_of_the_velocity_loses_its_own_share_where_the_plane_is_touched() {
        let mut particles = Particles::default();
        for y in [0.05, 0.5] {
            let seed = ParticleSeed::at(Vec3::Y * y).with_velocity(Vec3::new(4.0, 2.0, 0.0));
            particles.push(seed.with_radius(0.05)).unwrap();
        }
        let drag = PlanarDrag { along: 0.75, across: 0.5 };
        drag.apply(&mut particles, (Vec3::Y, 0.0), &[], 0.5);
        let expected = Vec3::new(4.0 * 0.25_f32.sqrt(), 2.0 * 0.5_f32.sqrt(), 0.0);
        assert!(particles.velocity(0).abs_diff_eq(expected, 1e-5), "{}", particles.velocity(0));
        assert_eq!(particles.velocity(1), Vec3::new(4.0, 2.0, 0.0), "it does not touch");
    }

    #[test]
    fn a_block_that_slides_on_it_slows_down_by_its_share_per_second() {
        let mut world = Simulation::default();
        let drag = PlanarDrag { along: 0.6, across: 0.0 };
        world.boundaries.planes.push(Plane { drag, ..Plane::ground(0.0).with_friction(0.0) });
        let seed = ParticleSeed::at(Vec3::ZERO).with_velocity(Vec3::X * 3.0);
        world.particles.push(seed).unwrap();
        for _ in 0..120 {
            world.step(1.0 / 60.0).unwrap();
        }
        let exact = 3.0 * 0.4_f32 * 0.4;
        let speed = world.particles.velocity(0).x;
        assert!((speed / exact - 1.0).abs() < 1e-3, "{speed} is not {exact}");
    }

    #[test]
    fn all_the_drag_there_is_stops_it_at_once_and_a_broken_one_skips_the_plane() {
        let mut particles = Particles::default();
        particles.push(ParticleSeed::at(Vec3::ZERO).with_velocity(Vec3::ONE)).unwrap();
        let drag = PlanarDrag { along: 1.0, across: 1.0 };
        drag.apply(&mut particles, (Vec3::Y, 0.0), &[], 0.01);
        assert_eq!(particles.velocity(0), Vec3::ZERO);
        let drag = PlanarDrag { along: f32::NAN, across: 0.0 };
        assert!(!Plane { drag, ..Plane::ground(0.0) }.is_valid());
    }
}
