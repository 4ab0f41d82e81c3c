//! Control forces: named, user-driven forces on a particle or on a compound as a whole (physics.md F2), such as an engine, a thruster or a hand.
//!
//! On a compound the force acts at its barycentre, as `F/M` on every particle, or at a given point with its lever arm. A torque is distributed as a rigid body
//! would take it; `total_mass.rs` of [`particles`](crate::particles) derives that.

use glam::{DVec3, Vec3};

use crate::particles::{Particles, TotalMass};

/// A force and a torque on a set of particles, applied in every substep until it is changed or removed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Control {
    /// The user's name for it. The simulation does not use it.
    pub name: String,
    /// The rows that it acts on together. Pinned particles and missing rows are ignored.
    pub rows: Vec<u32>,
    /// The total force, N, in world axes. (A thruster that turns with its body has to set it anew each step, from the body's [`pose`](crate::pose::pose).)
    pub force: Vec3,
    /// The total torque, N·m. Collinear particles cannot be turned about their line, nor a single particle at all: that part of the torque is lost.
    pub torque: Vec3,
    /// The point at which the force acts, metres, in world space. Default `None`: the barycentre, so that the force causes no rotation.
    pub point: Option<Vec3>,
}

impl Control {
    /// A force on `rows` together at their barycentre, N.
    pub fn force(name: impl Into<String>, rows: impl Into<Vec<u32>>, force: Vec3) -> Self {
        Self { name: name.into(), rows: rows.into(), force, ..Self::default() }
    }

    /// A torque on `rows` together, N·m.
    pub fn torque(name: impl Into<String>, rows: impl Into<Vec<u32>>, torque: Vec3) -> Self {
        Self { name: name.into(), rows: rows.into(), torque, ..Self::default() }
    }

    /// The same with the force acting at `point`, metres, in world space.
    pub fn at(self, point: Vec3) -> Self {
        Self { point: Some(point), ..self }
    }

    /// Whether force and torque are zero.
    pub(crate) fn is_idle(&self) -> bool {
        self.force == Vec3::ZERO && self.torque == Vec3::ZERO
    }

    /// Whether every number is finite. An invalid control does nothing.
    pub fn is_valid(&self) -> bool {
        self.force.is_finite() && self.torque.is_finite() && self.point.is_none_or(Vec3::is_finite)
    }
}

/// Adds the accelerations of the controls.
pub(crate) fn apply(particles: &mut Particles, controls: &[Control]) {
    for control in controls.iter().filter(|control| control.is_valid() && !control.is_idle()) {
        let Some(whole) = TotalMass::of(particles, &control.rows) else { continue };
        let lever = control.point.map_or(DVec3::ZERO, |point| whole.arm_of(particles, point));
        let force = control.force.as_dvec3();
        let answer = whole.response(force, control.torque.as_dvec3() + lever.cross(force));
        for &row in &control.rows {
            let i = row as usize;
            if i < particles.len() && particles.position[i].w > 0.0 {
                let acceleration = answer.at(whole.arm(particles, i));
                if acceleration.is_finite() {
                    particles.push_acceleration(i, acceleration);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constraints::{Distance, GradientAt};
    use crate::particles::ParticleSeed;
    use crate::simulation::Simulation;

    /// A box of eight particles of different masses, 2 × 1 × 3 m, with all its pair distances, without gravity.
    fn crate_of_wood() -> Simulation {
        let mut world = Simulation::default();
        world.forces.gravity = Vec3::ZERO;
        world.settings.substeps = 4;
        for i in 0..8_u32 {
            let bit = |n: u32| (i >> n & 1) as f32 - 0.5;
            let at = Vec3::new(2.0 * bit(0), bit(1), 3.0 * bit(2));
            let mass = 1.0 + (i % 3) as f32;
            world.particles.push(ParticleSeed::at(at).with_mass(mass)).unwrap();
        }
        for a in 0..8 {
            for b in a + 1..8 {
                let length = world.particles.separation(a, b).length();
                world.distances_mut().push(Distance::new(a as u32, b as u32, length));
            }
        }
        world
    }

    const ALL: [u32; 8] = [0, 1, 2, 3, 4, 5, 6, 7];

    /// Total force on the particles, and torque about their barycentre.
    fn total_load(world: &mut Simulation) -> (DVec3, DVec3) {
        world.begin_substep();
        world.accumulate_forces();
        let particles = &world.particles;
        let (mut mass, mut first) = (0.0, DVec3::ZERO);
        for i in 0..particles.len() {
            mass += f64::from(particles.mass(i));
            first += particles.position(i).as_dvec3() * f64::from(particles.mass(i));
        }
        let (mut force, mut torque) = (DVec3::ZERO, DVec3::ZERO);
        for i in 0..particles.len() {
            let f = particles.acceleration(i).as_dvec3() * f64::from(particles.mass(i));
            force += f;
            torque += (particles.position(i).as_dvec3() - first / mass).cross(f);
        }
        (force, torque)
    }

    #[test]
    fn a_force_on_a_compound_accelerates_all_of_it_by_force_over_mass() {
        let mut world = crate_of_wood();
        let force = Vec3::new(30.0, -4.0, 12.0);
        world.forces.controls.push(Control::force("engine", ALL, force));
        world.begin_substep();
        world.accumulate_forces();
        // 1 + 2 + 3 + 1 + 2 + 3 + 1 + 2 kg.
        for i in 0..8 {
            assert!(world.particles.acceleration(i).abs_diff_eq(force / 15.0, 1e-6));
        }
        for _ in 0..120 {
            world.step(1.0 / 60.0).unwrap();
        }
        let velocity = world.velocity_now(3);
        assert!(velocity.abs_diff_eq(force / 15.0 * 2.0, 2e-4), "F = m a: {velocity}");
    }

    #[test]
    fn a_torque_is_felt_as_itself_and_as_no_force_and_a_force_at_a_point_with_its_lever() {
        let torque = Vec3::new(5.0, -3.0, 8.0);
        let mut world = crate_of_wood();
        world.forces.controls.push(Control::torque("wheel", ALL, torque));
        let (force, turn) = total_load(&mut world);
        assert!(force.length() < 2e-6 && (turn - torque.as_dvec3()).length() < 5e-6);

        let (push, point) = (Vec3::new(0.0, 7.0, 2.0), Vec3::new(4.0, 0.5, 0.0));
        world.forces.controls[0] = Control { torque, ..Control::force("oar", ALL, push).at(point) };
        let centre =
            (0..8).map(|i| world.particles.position(i) * world.particles.mass(i)).sum::<Vec3>()
                / 15.0;
        let (force, turn) = total_load(&mut world);
        let expected = (torque + (point - centre).cross(push)).as_dvec3();
        assert!((force - push.as_dvec3()).length() < 5e-6, "{force}");
        assert!((turn - expected).length() < 2e-5, "{turn} {expected}");
    }

    #[test]
    fn a_steady_torque_spins_a_box_up_to_angular_acceleration_times_time() {
        let mut world = crate_of_wood();
        for i in 0..8 {
            let at = world.particles.position(i);
            world.particles.set(i, ParticleSeed::at(at).with_mass(1.0)).unwrap();
        }
        // The gradient that keeps spin, with enough sweeps for it to converge.
        world.settings.gradient_at = GradientAt::StepStart;
        world.settings.max_sweeps = 40;
        // About its middle, along z: Σ m (x² + y²) = 8 (1 + 1/4) kg·m².
        world.forces.controls.push(Control::torque("motor", ALL, Vec3::Z * 10.0));
        for _ in 0..120 {
            world.step(1.0 / 60.0).unwrap();
        }
        let points = (0..8).map(|i| (world.particles.position(i), world.velocity_now(i), 1.0_f32));
        let spin = crate::pose::motion(points).unwrap().angular_velocity;
        assert!(spin.abs_diff_eq(Vec3::Z * 2.0, 0.002), "α t = 10/10 · 2 s: {spin}");
    }

    #[test]
    fn pinned_rows_missing_rows_and_broken_controls_are_left_out() {
        let mut particles = Particles::default();
        particles.push(ParticleSeed::at(Vec3::X).pinned()).unwrap();
        particles.push(ParticleSeed::at(Vec3::Y).with_mass(2.0)).unwrap();
        let push = Control::force("push", [0, 1, 9], Vec3::X * 6.0);
        apply(&mut particles, &[push.clone().at(Vec3::Y * 5.0)]);
        assert_eq!(particles.acceleration(0), Vec3::ZERO);
        assert_eq!(particles.acceleration(1), Vec3::X * 3.0, "one particle has no lever");
        let broken = [
            Control { force: Vec3::NAN, ..push.clone() },
            Control { torque: Vec3::INFINITY, ..push.clone() },
            push.clone().at(Vec3::NAN),
            Control { rows: vec![0, 9], ..push.clone() },
            Control { rows: vec![], ..push },
        ];
        apply(&mut particles, &broken);
        assert_eq!(particles.acceleration(1), Vec3::X * 3.0);
        assert!(broken[..3].iter().all(|control| !control.is_valid()));
    }
}
