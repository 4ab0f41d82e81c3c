//! Velocities at the instant of the positions: of single particles, and of many as one rigid body.
//!
//! Verlet's velocity is the mean over the last substep, so it is true at the middle of it. To be true at the end it is advanced by half a substep with the
//! acceleration `a` last summed by [`accumulate_forces`](Simulation::accumulate_forces) and the phases after it. Constraints cancel part of that acceleration:
//! a particle at rest would get the velocity of half a substep's fall. So where the mean acceleration `A` of the last step was smaller, that is used: all of
//! `A` up to `|A| = |a|/2`, and a blend from there to `a` at `|A| = |a|`. From there on the particle is free, or something has hit it, and `a` is used.
//!
//! Under a constant acceleration the mean velocity of a step of `T` seconds, `D/T` for a displacement `D`, is the velocity at its middle, and `v` the velocity
//! at the middle of the last substep, `(T - h)/2` later. So `A = (v - D/T) / ((T - h)/2)`. In a step of one substep both instants coincide; there `v` is
//! compared with the velocity at the start of the step.

use glam::{DVec3, Vec3, Vec4};

use super::Simulation;
use crate::lanes::{LANES, LaneArray, Lanes, Number, Vector, kernel};
use crate::particles::Particles;
use crate::pose::{MassMoments, MomentSums, Motion, counts, motion};

/// Number of eights of particles summed at a time: a buffer on the stack.
const EIGHTS: usize = 32;

impl Simulation {
    /// Velocity of particle `i` at the instant of its position, m/s: the mean velocity of the last substep, advanced by half a substep.
    ///
    /// It is advanced by the acceleration last summed by [`accumulate_forces`](Self::accumulate_forces) and the phases after it; or, for a particle that
    /// constraints hold and so accelerates less, by the mean acceleration of the last step. What lies or hangs at rest has no velocity, and not that of half a
    /// substep's fall.
    #[inline]
    pub fn velocity_now(&self, i: usize) -> Vec3 {
        let particles = &self.particles;
        let (velocity, lag) = (particles.velocity(i), particles.lag(i));
        carried(velocity, lag, particles.acceleration(i), self.mean_acceleration(i))
    }

    /// Rigid-body motion of some particles, given as rows with the mass in kg that each counts with: [`motion`] of their positions and
    /// [velocities](Self::velocity_now), without losing precision far from the origin of the world. Particles with zero or non-finite mass do not count, and
    /// may be in any state; if none counts, all count equally, and `mass` and `inertia` are zero. `None` without particles, and where the result is not finite.
    ///
    /// # Panics
    /// If a row does not exist.
    pub fn motion(&self, points: impl Iterator<Item = (u32, f32)> + Clone) -> Option<Motion> {
        let weighted = points.clone().filter(|point| counts(point.1));
        let first = weighted.clone().next().or_else(|| points.clone().next())?.0;
        let near = self.particles.position(first as usize);
        let found = self.moments(weighted, near).map_or_else(
            || {
                motion(points.map(|(row, mass)| {
                    let i = row as usize;
                    (self.particles.relative_to(i, near), self.velocity_now(i), mass)
                }))
            },
            |moments| moments.motion(),
        )?;
        Some(Motion { barycentre: near + found.barycentre, ..found })
    }

    /// Sums over particles, with positions relative to a point; `None` without particles, and where the state at the start of the last step is not known.
    fn moments(&self, points: impl Iterator<Item = (u32, f32)>, near: Vec3) -> Option<MassMoments> {
        let (mut points, particles) = (points.peekable(), &self.particles);
        let &(first, _) = points.peek()?;
        let context = MotionContext {
            particles,
            began: Some(&self.scratch.checkpoint[..]).filter(|all| all.len() == particles.len())?,
            first: &self.scratch.first_velocity,
            step: self.scratch.length,
            near,
        };
        let i = first as usize;
        let about = [particles.relative_to(i, near), self.velocity_now(i)].map(Vec3::as_dvec3);
        let mut sums = MomentSums::NONE;
        while points.peek().is_some() {
            let (mut eights, mut count) = ([([first; LANES], [0.0; LANES]); EIGHTS], 0);
            for (row, mass) in points.by_ref().take(EIGHTS * LANES) {
                let (rows, masses) = &mut eights[count / LANES];
                (rows[count % LANES], masses[count % LANES]) = (row, mass);
                count += 1;
            }
            let eights = &eights[..count.div_ceil(LANES)];
            add_particles(eights, context, about, &mut sums, self.instructions);
        }
        Some(MassMoments::about(about[0], about[1], &sums))
    }

    /// Mean acceleration of particle `i` over the last step, m/s², by forces and constraints; `None` where it is not known.
    fn mean_acceleration(&self, i: usize) -> Option<Vec3> {
        let began = self.scratch.checkpoint.get(i)?;
        let of = |v: Vec4| Vector::<f32>::of(v.to_array());
        let (v, h) = of(self.particles.velocity[i]);
        let gone = of(self.particles.position[i] - *began).0;
        let first = self.scratch.first_velocity.get(i).map(|first| of(*first));
        let (mean, is_known) = mean_acceleration((v, h), gone, self.scratch.length, first);
        is_known.any().then(|| mean.into())
    }
}

/// A mean velocity over a substep of `lag` seconds, m/s, advanced by half of it with the acceleration `a`, m/s², or with the `mean` one of the step, where that
/// is known and smaller.
#[inline]
pub(super) fn carried(velocity: Vec3, lag: f32, a: Vec3, mean: Option<Vec3>) -> Vec3 {
    let is_known = f32::same(if mean.is_some() { 0.0 } else { 1.0 }, 0.0);
    let [v, a, mean] = [velocity, a, mean.unwrap_or_default()].map(Vector::<f32>::splat);
    carry(v, lag, a, (mean, is_known)).into()
}

/// [`carried`] in lanes, with a mask where the mean acceleration is known.
#[inline(always)]
fn carry<N: Number>(
    v: Vector<N>,
    lag: N,
    a: Vector<N>,
    (mean, is_known): (Vector<N>, N),
) -> Vector<N> {
    let half = N::splat(0.5) * lag;
    let free = v + a * half;
    let (size, square) = (mean.length(), a.length_squared());
    let less = is_known.and((size * size).lt(square));
    if !less.any() {
        return free;
    }
    let held = (N::splat(2.0) - N::splat(2.0) * size / square.sqrt()).min(N::splat(1.0));
    (free + (mean - a) * (half * held)).or_else(less, free)
}

/// Mean acceleration over a step of `step` seconds in which a particle moved by `gone`, by the formulas above, with a mask where it is known. `(v, h)` is the
/// mean velocity of the last substep and its length; `first` is the same at the start of the step, in a step of one substep.
#[inline(always)]
fn mean_acceleration<N: Number>(
    (v, h): (Vector<N>, N),
    gone: Vector<N>,
    step: f32,
    first: Option<(Vector<N>, N)>,
) -> (Vector<N>, N) {
    let (step, half) = (N::splat(step), N::splat(0.5));
    let (from, apart) = match first {
        Some((first, lag)) => (first, step - half * (h - lag)),
        None => (gone / step, half * (step - h)),
    };
    let mean = (v - from) / apart;
    // Zero times NaN or infinity is not zero.
    let none = mean * N::zero();
    (mean, N::zero().lt(h).and((none.x + none.y + none.z).same(N::zero())))
}

/// What the velocities of particles at the instant of their positions depend on.
#[derive(Clone, Copy)]
struct MotionContext<'a> {
    particles: &'a Particles,
    /// Positions at the start of the last step, and velocities if that step had one substep.
    began: &'a [Vec4],
    first: &'a [Vec4],
    /// Length of that step, seconds.
    step: f32,
    /// Positions are taken relative to this point: far out, world coordinates are too coarse to show how a body is turned.
    near: Vec3,
}

kernel!(
    /// Adds particles of these rows and masses to sums about a position and a velocity.
    fn add_particles<L: Lanes>(
        eights: &[([u32; LANES], LaneArray)],
        context: MotionContext<'_>,
        about: [DVec3; 2],
        sums: &mut MomentSums<f64>,
    ) {
        let MotionContext { particles, began, first, step, near } = context;
        let [position, velocity] = about;
        let (position, velocity) = (Vector::double(position), Vector::double(velocity));
        let common = Vector::<L>::splat(particles.uniform_acceleration);
        let near = Vector::<L>::splat(near);
        let mut own = MomentSums::<L::Doubles>::none();
        for (rows, masses) in eights {
            let (q, w) = Vector::of(L::rows(&particles.position, rows));
            let (v, h) = Vector::of(L::rows(&particles.velocity, rows));
            let gone = q - Vector::of(L::rows(began, rows)).0;
            let mut a = common.or_else(L::zero().lt(w), Vector::splat(Vec3::ZERO));
            if particles.acceleration_dirty {
                a = Vector::of(L::rows(&particles.acceleration, rows)).0 + a;
            }
            let first =
                if first.is_empty() { None } else { Some(Vector::of(L::rows(first, rows))) };
            let now = carry(v, h, a, mean_acceleration((v, h), gone, step, first));
            let mut origins = [[0.0; LANES]; 3];
            for (lane, row) in rows.iter().enumerate() {
                let Vec3 { x, y, z } = particles.origin[*row as usize];
                (origins[0][lane], origins[1][lane], origins[2][lane]) = (x, y, z);
            }
            let [x, y, z] = &origins;
            let origin = Vector::new(L::load(x), L::load(y), L::load(z));
            let r = (origin - near) + q;
            own.add(L::load(masses).widen(), r.widen() - position, now.widen() - velocity);
        }
        sums.add_lanes(&own);
    }
);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recipes::{ClothSpec, cloth_grid};
    use crate::{InstructionSet, Wind};

    /// Sums in lanes equal those over the velocities of the particles one by one, with the same bits on each instruction set: for cloth that hangs in the wind,
    /// far out, after steps of one substep and of several, for all of it and for a part, with some particles that do not count.
    #[test]
    fn the_motion_of_many_is_that_of_their_velocities() {
        for substeps in [1, 4] {
            let mut world = Simulation::default();
            world.settings.substeps = substeps;
            world.forces.winds.push(Wind::steady(Vec3::new(1.0, 0.0, 3.0)));
            let mut cloth = cloth_grid(&ClothSpec::default()).unwrap();
            cloth.pin(0).unwrap();
            cloth
                .transformed(glam::Quat::IDENTITY, Vec3::new(900.0, 5.0, -70.0))
                .build(&mut world)
                .unwrap();
            let points = |every: usize| {
                (0..441).step_by(every).map(|row| {
                    (row, if row % 5 == 3 { f32::NAN } else { 0.01 + 1e-4 * row as f32 })
                })
            };
            for _ in 0..30 {
                world.step(1.0 / 60.0).unwrap();
                for every in [1, 3, 441] {
                    let near = world.particles.position(0);
                    let one_by_one = points(every).map(|(row, mass)| {
                        let i = row as usize;
                        (world.particles.relative_to(i, near), world.velocity_now(i), mass)
                    });
                    let wanted = motion(one_by_one).unwrap();
                    let sets = InstructionSet::ALL;
                    let [a, b, c] = sets.map(|instructions| {
                        world.instructions = instructions;
                        world.motion(points(every)).unwrap()
                    });
                    assert!(a == b && b == c, "{a:?} {b:?} {c:?}");
                    let off = [
                        a.barycentre - near - wanted.barycentre,
                        a.velocity - wanted.velocity,
                        a.angular_velocity - wanted.angular_velocity,
                    ];
                    // Far out the barycentre is rounded to a sixteenth of a millimetre.
                    assert!(
                        off[0].length() < 1e-4 && off[1].length() < 1e-5 && off[2].length() < 1e-5,
                        "{off:?}"
                    );
                    assert!((a.mass - wanted.mass).abs() < 1e-6 * wanted.mass);
                    assert!(a.inertia.abs_diff_eq(wanted.inertia, 1e-6 * wanted.mass));
                }
            }
        }
        let mut world = Simulation::default();
        world.particles.push(crate::ParticleSeed::at(Vec3::X)).unwrap();
        assert_eq!(world.motion([].into_iter()), None);
        let without = world.motion([(0, 0.0)].into_iter()).unwrap();
        assert_eq!((without.mass, without.barycentre), (0.0, Vec3::X));
    }
}
