//! Statics: finds the state of rest directly, without simulating the time until it is reached (physics.md F9).
//!
//! With full drag each step starts from zero velocity: each particle falls by `½ h² a` from rest, and constraints correct it. So the state descends the slope
//! of its energy, under its constraints, to a local minimum: a hanging chain becomes a catenary.

use glam::{Vec3, Vec4};

use super::{Simulation, StepFault};
use crate::collide::Frame;
use crate::particles::Particles;

/// Result of [`Simulation::relax`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Relaxed {
    /// Steps taken.
    pub steps: u32,
    /// Longest way of a particle in the last of them, metres.
    pub moved: f32,
    /// Whether that was within the tolerance.
    pub settled: bool,
}

impl Simulation {
    /// Walks to rest by steps of `dt` seconds, until no particle moves by more than `tolerance` metres in one, or `most` steps are taken. Afterwards every
    /// particle is at rest, and `time` has not advanced: gusts and whatever else depends on it act as they did at the start. Kinematic colliders are at the end
    /// of their step's motion throughout, and nothing sleeps meanwhile.
    ///
    /// A longer `dt` converges faster, by its square. Stiff springs need a short one: `ω h < 2`, as in any step.
    ///
    /// ```
    /// use sinew::{Simulation, glam::Vec3, recipes::{RopeSpec, rope}};
    ///
    /// // A rope of 1.5 m between two nails 1 m apart: it sags by 0.5026 m, as a catenary does.
    /// let mut world = Simulation::default();
    /// world.settings.max_sweeps = 50;
    /// let spec = RopeSpec { to: Vec3::X, segments: 20, slack: 0.5, pin_start: true, pin_end: true, ..Default::default() };
    /// rope(&spec)?.build(&mut world)?;
    /// let found = world.relax(0.2, 1e-5, 2000)?;
    /// let sag = -world.particles.position(10).y;
    /// assert!(found.settled && (sag / 0.50345 - 1.0).abs() < 5e-3, "{found:?} {sag}");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// A `dt` that is not positive and finite, or so short that 1/h² overflows for a substep `h`, is refused and nothing changes.
    pub fn relax(&mut self, dt: f32, tolerance: f32, most: u32) -> Result<Relaxed, StepFault> {
        self.walk_to_rest(dt, tolerance, most)
    }

    /// Relaxes some particles alone: all others stay where they are, as if pinned, and keep their masses and velocities. Rows that do not exist are ignored.
    ///
    /// # Errors
    /// As [`relax`](Self::relax).
    pub fn relax_rows(
        &mut self,
        rows: &[u32],
        dt: f32,
        tolerance: f32,
        most: u32,
    ) -> Result<Relaxed, StepFault> {
        let mut walks = vec![false; self.particles.len()];
        for &row in rows {
            if let Some(walks) = walks.get_mut(row as usize) {
                *walks = true;
            }
        }
        let mut held = Vec::new();
        for (i, _) in walks.iter().enumerate().filter(|(_, walks)| !**walks) {
            let Particles { position, velocity, rounding, .. } = &mut self.particles;
            held.push((i, position[i].w, velocity[i], rounding[i]));
            (position[i].w, velocity[i], rounding[i]) = (0.0, Vec4::ZERO, Vec4::ZERO);
        }
        self.particles.note_edit();
        let found = self.walk_to_rest(dt, tolerance, most);
        for (i, w, velocity, rounding) in held {
            self.particles.position[i].w = w;
            self.particles.velocity[i] = velocity;
            self.particles.rounding[i] = rounding;
        }
        self.particles.note_edit();
        found
    }

    fn walk_to_rest(&mut self, dt: f32, tolerance: f32, most: u32) -> Result<Relaxed, StepFault> {
        let (time, statics) = (self.time, core::mem::replace(&mut self.settings.statics, true));
        // Nothing may fall asleep on the way, and kinematic colliders stay at their end: otherwise each step would move them again.
        let sleep = core::mem::take(&mut self.sleep);
        let starts: Vec<Frame> = self.colliders.iter().map(|collider| collider.start).collect();
        self.colliders.iter_mut().for_each(|collider| collider.start = collider.end);
        let mut found = Relaxed { steps: 0, moved: f32::INFINITY, settled: false };
        let mut outcome = Ok(());
        while found.steps < most && !found.settled && outcome.is_ok() {
            outcome = self.step(dt).map(|_| ());
            self.time = time;
            found.steps += 1;
            found.moved =
                (0..self.particles.len()).map(|i| self.moved_in_step(i)).fold(0.0, f32::max);
            found.settled = found.moved <= tolerance;
        }
        (self.settings.statics, self.sleep) = (statics, sleep);
        for (collider, start) in self.colliders.iter_mut().zip(starts) {
            collider.start = start;
        }
        outcome?;
        for i in 0..self.particles.len() {
            self.particles.set_velocity(i, Vec3::ZERO);
        }
        Ok(found)
    }

    /// Distance between the positions of particle `i` at the start and at the end of the last step, metres.
    fn moved_in_step(&self, i: usize) -> f32 {
        let began = self.scratch.checkpoint[i].truncate();
        (self.particles.position[i].truncate() - began).length()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collide::{Collider, Shape};
    use crate::particles::ParticleSeed;
    use crate::recipes::{BoxSpec, RopeSpec, box_3d, rope};
    use crate::rigid::Compound;

    /// A slack rope of 1.5 m between nails 1 m apart, at height `y`.
    fn hung(world: &mut Simulation, segments: u32, y: f32) {
        let spec = RopeSpec {
            to: Vec3::X,
            segments,
            slack: 0.5,
            pin_start: true,
            pin_end: true,
            ..Default::default()
        };
        let rope = rope(&spec).unwrap().transformed(glam::Quat::IDENTITY, Vec3::Y * y);
        rope.build(world).unwrap();
    }

    #[test]
    fn some_particles_walk_to_rest_and_the_others_keep_place_mass_and_velocity() {
        let mut world = Simulation::default();
        world.settings.max_sweeps = 50;
        hung(&mut world, 20, 0.0);
        let stone = ParticleSeed::at(Vec3::new(0.5, 9.0, 0.0)).with_mass(3.0);
        let stone = world.particles.push(stone.with_velocity(Vec3::X)).unwrap() as usize;
        let rows: Vec<u32> = (0..stone as u32).collect();
        let before = world.particles.states(stone..stone + 1).next();
        let found = world.relax_rows(&rows, 0.2, 1e-5, 2000).unwrap();
        let sag = -world.particles.position(10).y;
        assert!(found.settled && (sag / 0.50345 - 1.0).abs() < 5e-3, "{found:?} {sag}");
        assert_eq!(world.particles.states(stone..stone + 1).next(), before);
        assert_eq!(world.particles.mass(stone), 3.0);
        world.step(1.0 / 60.0).unwrap();
        assert!(
            world.particles.velocity(stone).x > 0.99 && world.particles.velocity(stone).y < 0.0
        );
    }

    #[test]
    fn what_lies_on_a_moved_collider_is_not_carried_on_and_on() {
        let mut world = Simulation::default();
        let floor = Shape::cuboid(Vec3::new(100.0, 1.0, 100.0)).unwrap();
        let to = Frame::at(Vec3::new(0.1, -0.5, 0.0));
        let from = Frame::at(Vec3::new(0.0, -0.5, 0.0));
        world.colliders.push(Collider::fixed(floor, from).moving_to(to));
        let cube = box_3d(&BoxSpec::default()).unwrap();
        let cube = cube.transformed(glam::Quat::IDENTITY, Vec3::Y * 0.5);
        cube.build_colliding(&mut world, Default::default()).unwrap();
        let began = world.particles.position(0).x;
        let found = world.relax(0.1, 1e-5, 200).unwrap();
        let went = world.particles.position(0).x - began;
        assert!(found.settled && went.abs() < 0.01, "{found:?}, {went}");
        assert_eq!(world.colliders[0].start, from, "it goes its way in the next step");
    }

    /// A rigid body kept its own velocity, and so fell freely during statics.
    #[test]
    fn a_rigid_body_walks_as_slowly_as_its_particles() {
        let fallen = |rigid: bool| {
            let mut world = Simulation::default();
            let cube = box_3d(&BoxSpec::default()).unwrap();
            cube.build_colliding(&mut world, Default::default()).unwrap();
            if rigid {
                let rest = (0..8).map(|i| world.particles.position(i)).collect();
                world.compounds_mut().push(Compound::new(0..8, rest));
            }
            world.relax(0.1, 0.0, 10).unwrap();
            world.particles.position(0).y
        };
        let (particles, rigid) = (fallen(false), fallen(true));
        let expected = 0.5 * 9.81 * 0.01 * 0.01 * 100.0;
        assert!((particles - rigid).abs() < 0.2 * expected, "{particles} {rigid} {expected}");
    }
}
