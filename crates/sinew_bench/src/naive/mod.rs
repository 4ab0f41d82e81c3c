//! The naive reference: position based dynamics as a textbook presents it. Particles and constraints are arrays of structs, everything runs sequentially,
//! constraints in the given order. It is written well, without redundant bounds checks and without allocations in a step; it lacks only the optimisations of
//! Sinew.
//!
//! It is made from a [`Simulation`], so that masses, rest lengths and positions are the same numbers.

pub mod charges;
mod fold;

pub use fold::Fold;

use sinew::glam::Vec3;
use sinew::{Bound, ConstraintKind, Distance, Simulation, Softness};

use crate::measure::{TICK, World, stretch_of};
use crate::row::Stretch;

/// A particle of the naive world.
#[derive(Clone, Copy, Debug)]
pub struct Particle {
    /// Position, metres.
    pub position: Vec3,
    /// Position a substep ago, metres.
    pub previous: Vec3,
    /// Inverse mass, 1/kg; zero for a pinned particle.
    pub inverse_mass: f32,
}

/// A hard distance constraint between two particles.
#[derive(Clone, Copy, Debug)]
struct Rod {
    a: u32,
    b: u32,
    rest: f32,
    bound: Bound,
}

/// A half space that particles stay out of.
#[derive(Clone, Copy, Debug)]
struct Floor {
    normal: Vec3,
    offset: f32,
    friction: f32,
}

/// A world of particles, rods, folds and floors.
#[derive(Clone, Debug)]
pub struct Naive {
    particles: Vec<Particle>,
    rods: Vec<Rod>,
    folds: Vec<Fold>,
    floors: Vec<Floor>,
    gravity: Vec3,
    substeps: u32,
    sweeps: u32,
    tolerance: f32,
    /// The distances over which the stretch is measured.
    distances: Vec<Distance>,
}

impl Naive {
    /// Copies a simulation of particles at rest: hard distances, bending constraints of four particles, planes.
    pub fn of(world: &Simulation) -> Self {
        let particles = (0..world.particles.len()).map(|i| {
            let position = world.particles.position(i);
            let inverse_mass = world.particles.inverse_mass(i);
            Particle { position, previous: position, inverse_mass }
        });
        let rods = world.distances().iter().map(|d| {
            debug_assert!(d.softness == Softness::Hard, "the naive rods are hard");
            Rod { a: d.a, b: d.b, rest: d.rest, bound: d.bound }
        });
        let folds = world.constraints().iter().filter_map(|c| {
            let rows = [0, 1, 2, 3].map(|i| c.rows.get(i).copied().unwrap_or(0));
            match &c.kind {
                ConstraintKind::Hinge(law) => Some(Fold::dihedral(rows, law)),
                ConstraintKind::Bend(law) => Some(Fold::isometric(rows, law)),
                _ => None,
            }
        });
        let floors = world.boundaries.planes.iter().map(|plane| Floor {
            normal: plane.normal,
            offset: plane.offset,
            friction: plane.friction,
        });
        Self {
            particles: particles.collect(),
            rods: rods.collect(),
            folds: folds.collect(),
            floors: floors.collect(),
            gravity: world.forces.gravity,
            substeps: world.settings.substeps,
            sweeps: world.settings.max_sweeps,
            tolerance: world.settings.tolerance,
            distances: world.distances().to_vec(),
        }
    }

    fn substep(&mut self, h: f32) {
        let fall = self.gravity * (h * h);
        for p in &mut self.particles {
            if p.inverse_mass > 0.0 {
                let next = p.position + (p.position - p.previous) + fall;
                p.previous = p.position;
                p.position = next;
            }
        }
        for _ in 0..self.sweeps {
            let mut worst = 0.0_f32;
            // Soft constraints first, as in Sinew: the constraints that are solved last have the smallest residual.
            for fold in &self.folds {
                fold.project(&mut self.particles, h);
            }
            for rod in &self.rods {
                worst = worst.max(rod.project(&mut self.particles));
            }
            for floor in &self.floors {
                worst = worst.max(floor.project(&mut self.particles));
            }
            if worst < self.tolerance {
                break;
            }
        }
    }
}

impl World for Naive {
    fn tick(&mut self) {
        let h = TICK / self.substeps as f32;
        (0..self.substeps).for_each(|_| self.substep(h));
    }

    fn stretch(&self) -> Option<Stretch> {
        stretch_of(&self.distances, |i| self.particles[i].position)
    }
}

impl Rod {
    /// Projects the distance in closed form; returns its error before that, metres.
    #[inline]
    fn project(&self, particles: &mut [Particle]) -> f32 {
        let (a, b) = (self.a as usize, self.b as usize);
        let (pa, pb) = (particles[a], particles[b]);
        let d = pa.position - pb.position;
        let length = d.length();
        let error = length - self.rest;
        let slack = match self.bound {
            Bound::Equal => false,
            Bound::AtMost => error <= 0.0,
            Bound::AtLeast => error >= 0.0,
        };
        let weights = pa.inverse_mass + pb.inverse_mass;
        if slack || weights == 0.0 || length == 0.0 {
            return 0.0;
        }
        let along = d * (error / (length * weights));
        particles[a].position = pa.position - along * pa.inverse_mass;
        particles[b].position = pb.position + along * pb.inverse_mass;
        error.abs()
    }
}

impl Floor {
    /// Projects every particle out of the half space, with Coulomb friction along the floor; returns the largest depth, metres.
    fn project(&self, particles: &mut [Particle]) -> f32 {
        let mut worst = 0.0_f32;
        for p in particles.iter_mut().filter(|p| p.inverse_mass > 0.0) {
            let depth = self.offset - p.position.dot(self.normal);
            if depth > 0.0 {
                p.position += self.normal * depth;
                let way = p.position - p.previous;
                let along = way - self.normal * way.dot(self.normal);
                let length = along.length();
                if length > 0.0 {
                    p.position -= along * (self.friction * depth / length).min(1.0);
                }
                worst = worst.max(depth);
            }
        }
        worst
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::{Ours, TICKS};
    use crate::scenes::{bending, bodies, cloth, ropes};

    /// Runs both for 4 s. Returns the mean stretch of Sinew and of the reference, and the distance between their centres of mass, metres.
    fn compared(mut world: Simulation) -> [f64; 3] {
        // The reference has neither.
        world.settings.long_range = false;
        world.settings.microsteps = false;
        let (mut naive, mut ours) = (Naive::of(&world), Ours(world));
        for _ in 0..TICKS {
            naive.tick();
            ours.tick();
        }
        let count = naive.particles.len();
        let there: Vec3 = naive.particles.iter().map(|p| p.position).sum();
        let here: Vec3 = (0..count).map(|i| ours.0.particles.position(i)).sum();
        let apart = f64::from((there - here).length()) / count as f64;
        [ours.stretch().unwrap().mean, naive.stretch().unwrap().mean, apart]
    }

    #[test]
    fn a_naive_cloth_swings_as_ours_does() {
        let [ours, naive, apart] = compared(cloth::world(&cloth::sheet(16), 10, 1));
        assert!(ours < 0.02 && naive < 0.02, "{ours} {naive}");
        assert!(apart < 0.1, "{apart}");
    }

    #[test]
    fn naive_ropes_swing_as_ours_do() {
        let [ours, naive, apart] = compared(ropes::many(2, 10, 4));
        assert!(ours < 0.05 && naive < 0.05, "{ours} {naive}");
        assert!(apart < 0.1, "{apart}");
    }

    #[test]
    fn naive_folds_bend_as_ours_do() {
        for bending in [bending::Bending::Dihedral, bending::Bending::Isometric] {
            let [ours, naive, apart] = compared(bending::world(16, bending, 10, 1));
            assert!(ours < 0.02 && naive < 0.02, "{ours} {naive}");
            assert!(apart < 0.1, "{apart}");
        }
    }

    #[test]
    fn naive_boxes_stand_as_ours_do() {
        let [ours, naive, apart] = compared(bodies::boxes(4));
        assert!(ours < 1e-3 && naive < 1e-3, "{ours} {naive}");
        assert!(apart < 1e-2, "{apart}");
    }
}
