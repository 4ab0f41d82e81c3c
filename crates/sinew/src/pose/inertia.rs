//! Motion of a compound as one rigid body: mass, barycentre, velocity, inertia, angular velocity (physics.md E2, E3).
//!
//! With `r` and `u` the position and the velocity of a particle relative to those of the barycentre,
//!
//! ```text
//! I = Σ m (r² 1 - r rᵀ)        L = Σ m r × u        ω = I⁻¹ L
//! ```
//!
//! `L` is the angular momentum about the barycentre. `ω` is also the least-squares fit: the derivative of `Σ m ‖u - ω × r‖²` by `ω` vanishes where `I ω = L`.
//! So a rigid spin is found exactly, and a deforming body gets the spin that explains most of its motion and has all of its angular momentum.
//!
//! On a line `I` has one eigenvalue 0, about the line (a flat compound has none), at a point three. The velocities do not determine a spin about such an axis,
//! and the pseudo-inverse, `ω = Σ e (e·L)/λ` over the eigenpairs with `λ > 0`, sets it to zero. The sums are as in [`pose`](super::pose): `f64`, one pass,
//! relative to the first particle.

use glam::{DMat3, DVec3, Mat3, Vec3};

use super::{MomentSums, counts, symmetric};
use crate::lanes::{InstructionSet, LANES, LaneArray, Lanes, Vector, kernel};

/// Eigenvalues of the inertia below this fraction of the greatest one count as zero: particles thinner than 1 in 30 000.
const LINE: f64 = 1e-9;

/// Motion of a compound of particles as a whole, in world axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Total mass of the particles that count, kg; zero if none has a mass that counts.
    pub mass: f32,
    /// The mass-weighted mean of the positions, m.
    pub barycentre: Vec3,
    /// The mass-weighted mean of the velocities, which is the velocity of the barycentre, m/s.
    pub velocity: Vec3,
    /// Angular velocity about the barycentre, rad/s. Zero about an axis on which all particles lie.
    pub angular_velocity: Vec3,
    /// Inertia tensor about the barycentre, kg·m², symmetric. That of the particles as points: eight particles at the corners of a box have three times the
    /// inertia of the solid box.
    pub inertia: Mat3,
}

/// The motion of a compound, from the position (m), the velocity (m/s) and the mass (kg) of each of its particles.
///
/// `points` is read once, twice if no mass counts, always in its own order, and summed in eights; nothing is allocated. Position and velocity must be of the
/// same instant. For particles of a simulation [`Simulation::motion`](crate::Simulation::motion) is faster.
///
/// A particle whose mass is zero, negative, infinite or NaN does not count: pass for a pinned one the mass that it would have unpinned. If no mass counts, all
/// particles count equally for the barycentre and the velocities, and `mass` and `inertia` are zero.
///
/// `None` if there is no particle, or if one that counts has a position or a velocity that is not finite (or that makes the result overflow `f32`): keep the
/// last result, and report the compound.
pub fn motion(points: impl Iterator<Item = (Vec3, Vec3, f32)> + Clone) -> Option<Motion> {
    let weighted = points.clone().filter(|&(_, _, mass)| counts(mass));
    match MassMoments::of(weighted) {
        Some(sums) => sums.motion(),
        None => MassMoments::of(points.map(|(p, v, _)| (p, v, 1.0)))?.motion_without_mass(),
    }
}

/// Means, and second moments about the barycentre.
pub(crate) struct MassMoments {
    mass: f64,
    barycentre: DVec3,
    velocity: DVec3,
    /// `Σ m r rᵀ`: its diagonal, and its off-diagonal elements `xy`, `yz` and `zx`.
    squares: DVec3,
    products: DVec3,
    /// `Σ m r × u`.
    angular_momentum: DVec3,
}

/// Eight points in lanes. Unused lanes have zero mass.
#[derive(Clone, Copy)]
struct WidePoint {
    position: [LaneArray; 3],
    velocity: [LaneArray; 3],
    mass: LaneArray,
}

/// Number of eights summed at a time: a buffer on the stack.
const EIGHTS: usize = 8;

impl MassMoments {
    /// `None` without points.
    fn of(points: impl Iterator<Item = (Vec3, Vec3, f32)>) -> Option<Self> {
        let mut points = points.peekable();
        let &(position, velocity, _) = points.peek()?;
        let (position, velocity) = (position.as_dvec3(), velocity.as_dvec3());
        let mut sums = MomentSums::NONE;
        while points.peek().is_some() {
            let none = WidePoint {
                position: position.as_vec3().to_array().map(|x| [x; LANES]),
                velocity: velocity.as_vec3().to_array().map(|x| [x; LANES]),
                mass: [0.0; LANES],
            };
            let (mut eights, mut count) = ([none; EIGHTS], 0);
            for (p, v, m) in points.by_ref().take(EIGHTS * LANES) {
                let (eight, lane) = (&mut eights[count / LANES], count % LANES);
                for axis in 0..3 {
                    (eight.position[axis][lane], eight.velocity[axis][lane]) = (p[axis], v[axis]);
                }
                eight.mass[lane] = m;
                count += 1;
            }
            let eights = &eights[..count.div_ceil(LANES)];
            add_eights(eights, [position, velocity], &mut sums, InstructionSet::best());
        }
        Some(Self::about(position, velocity, &sums))
    }

    /// From sums of positions relative to one point, and of velocities relative to one velocity.
    pub(crate) fn about(position: DVec3, velocity: DVec3, sums: &MomentSums<f64>) -> Self {
        let [first, squares, products, momentum, angular] =
            [sums.first, sums.squares, sums.products, sums.momentum, sums.angular].map(DVec3::from);
        let share = 1.0 / sums.mass;
        let (mean, drift) = (first * share, momentum * share);
        Self {
            mass: sums.mass,
            barycentre: position + mean,
            velocity: velocity + drift,
            squares: squares - first * mean,
            products: products - first * DVec3::new(mean.y, mean.z, mean.x),
            angular_momentum: angular - mean.cross(momentum),
        }
    }

    /// The motion; `None` if it is not finite.
    pub(crate) fn motion(&self) -> Option<Motion> {
        let found = Motion {
            mass: self.mass as f32,
            inertia: DMat3::from_cols_array_2d(&self.inertia()).as_mat3(),
            ..self.motion_without_mass()?
        };
        (found.mass.is_finite() && found.inertia.is_finite()).then_some(found)
    }

    /// The motion of particles without mass, summed with equal weights.
    pub(crate) fn motion_without_mass(&self) -> Option<Motion> {
        let found = Motion {
            mass: 0.0,
            barycentre: self.barycentre.as_vec3(),
            velocity: self.velocity.as_vec3(),
            angular_velocity: spin(self.inertia(), self.angular_momentum).as_vec3(),
            inertia: Mat3::ZERO,
        };
        let finite = found.barycentre.is_finite()
            && found.velocity.is_finite()
            && found.angular_velocity.is_finite();
        finite.then_some(found)
    }

    fn inertia(&self) -> [[f64; 3]; 3] {
        let (DVec3 { x: xx, y: yy, z: zz }, DVec3 { x: xy, y: yz, z: xz }) =
            (self.squares, self.products);
        [[yy + zz, -xy, -xz], [-xy, xx + zz, -yz], [-xz, -yz, xx + yy]]
    }
}

kernel!(
    /// Adds points to sums about a position and a velocity.
    fn add_eights<L: Lanes>(eights: &[WidePoint], about: [DVec3; 2], sums: &mut MomentSums<f64>) {
        let [position, velocity] = about;
        let (position, velocity) = (Vector::double(position), Vector::double(velocity));
        let mut own = MomentSums::<L::Doubles>::none();
        for eight in eights {
            let [x, y, z] = &eight.position;
            let p = Vector::new(L::load(x), L::load(y), L::load(z)).widen();
            let [x, y, z] = &eight.velocity;
            let v = Vector::new(L::load(x), L::load(y), L::load(z)).widen();
            own.add(L::load(&eight.mass).widen(), p - position, v - velocity);
        }
        sums.add_lanes(&own);
    }
);

/// Mass, barycentre and inertia about it of points without velocities.
pub(crate) struct PointMasses {
    /// Kilograms.
    pub(crate) mass: f64,
    /// Metres, from the point that positions are measured from.
    pub(crate) barycentre: DVec3,
    /// kg·m².
    pub(crate) inertia: [[f64; 3]; 3],
}

impl PointMasses {
    /// Sums positions, metres, and masses, kg, in two passes.
    pub(crate) fn of(points: impl Iterator<Item = (DVec3, f64)> + Clone) -> Self {
        let (mut mass, mut first) = (0.0, DVec3::ZERO);
        for (p, m) in points.clone() {
            mass += m;
            first += p * m;
        }
        let barycentre = first / mass;
        let mut inertia = [[0.0; 3]; 3];
        for (p, m) in points {
            let r = p - barycentre;
            let (square, r) = (r.length_squared(), r.to_array());
            for (row, x) in inertia.iter_mut().zip(r) {
                row.iter_mut().zip(r).for_each(|(entry, y)| *entry -= m * x * y);
            }
            (0..3).for_each(|axis| inertia[axis][axis] += m * square);
        }
        Self { mass, barycentre, inertia }
    }
}

/// `ω` with `I ω = L`, and zero along the null space of `I`.
pub(crate) fn spin(inertia: [[f64; 3]; 3], angular_momentum: DVec3) -> DVec3 {
    if let Some((w, _)) = symmetric::solve(&inertia, angular_momentum) {
        return w;
    }
    let (values, vectors) = symmetric::eigen(inertia);
    let top = values.iter().fold(0.0_f64, |top, &value| top.max(value));
    let mut w = DVec3::ZERO;
    for (value, vector) in values.into_iter().zip(vectors) {
        if value > LINE * top {
            let e = DVec3::from_array(vector);
            w += e * (e.dot(angular_momentum) / value);
        }
    }
    w
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_random::Random;

    fn spinning(
        points: &[(Vec3, f32)],
        about: Vec3,
        velocity: Vec3,
        w: Vec3,
    ) -> Vec<(Vec3, Vec3, f32)> {
        let turn = |p: Vec3| (w.as_dvec3().cross((p - about).as_dvec3())).as_vec3();
        points.iter().map(|&(p, m)| (p, velocity + turn(p), m)).collect()
    }

    fn read(points: &[(Vec3, Vec3, f32)]) -> Option<Motion> {
        motion(points.iter().copied())
    }

    #[test]
    fn a_rigid_spin_and_drift_are_read_back() {
        let mut random = Random::new(7);
        for round in 0..1000 {
            let points: Vec<_> = (0..8 + round % 200)
                .map(|_| (random.direction() * 2.0, random.number() + 1.5))
                .collect();
            let mass: f64 = points.iter().map(|&(_, m)| f64::from(m)).sum();
            let about = points.iter().map(|&(p, m)| p.as_dvec3() * f64::from(m)).sum::<DVec3>();
            let (mass, about) = (mass as f32, (about / mass).as_vec3());
            let (velocity, w) = (random.direction(), random.direction() * 10.0);
            let found = read(&spinning(&points, about, velocity, w)).unwrap();
            assert!((found.mass - mass).abs() < 1e-6 * mass);
            assert!((found.barycentre - about).length() < 1e-6);
            assert!((found.velocity - velocity).length() < 1e-5);
            assert!((found.angular_velocity - w).length() < 2e-5, "{} {w}", found.angular_velocity);
        }
    }

    #[test]
    fn a_spin_is_read_back_far_from_the_origin_and_in_fast_flight() {
        // On the grid of `f32` there, so that any error is in the sums.
        let corner = |i: u8| Vec3::new((i & 1).into(), (i >> 1 & 1).into(), (i >> 2).into()) - 0.5;
        let points: Vec<_> = (0..8).map(|i| (corner(i), 1.0)).collect();
        let (offset, velocity) =
            (Vec3::new(65536.0, -32768.0, 1024.0), Vec3::new(1024.0, 0.0, -512.0));
        let mut points = spinning(&points, Vec3::ZERO, velocity, Vec3::new(1.0, -2.0, 4.0));
        for (p, _, _) in &mut points {
            *p += offset;
        }
        let found = read(&points).unwrap();
        assert_eq!((found.barycentre, found.velocity), (offset, velocity));
        assert_eq!(found.angular_velocity, Vec3::new(1.0, -2.0, 4.0));
    }

    #[test]
    fn the_corners_of_a_box_have_three_times_its_inertia() {
        let half = Vec3::new(1.0, 2.0, 3.0);
        let sign = |bit: u8| f32::from(bit & 1) * 2.0 - 1.0;
        let corners = (0..8)
            .map(|i| (half * Vec3::new(sign(i), sign(i >> 1), sign(i >> 2)), Vec3::ZERO, 0.5));
        let found = motion(corners).unwrap();
        let solid = |a: f32, b: f32| 4.0 * (4.0 * a * a + 4.0 * b * b) / 12.0;
        let solid = Vec3::new(solid(2.0, 3.0), solid(1.0, 3.0), solid(1.0, 2.0));
        assert_eq!(found.mass, 4.0);
        assert!((found.inertia - Mat3::from_diagonal(solid * 3.0)).abs_diff_eq(Mat3::ZERO, 1e-4));
    }

    #[test]
    fn the_barycentre_is_weighted_by_mass_and_the_weightless_do_not_count() {
        let points = [
            (Vec3::X, Vec3::Y, 3.0),
            (-Vec3::X, -Vec3::Y, 1.0),
            (Vec3::splat(f32::NAN), Vec3::ZERO, 0.0),
            (Vec3::splat(9.0), Vec3::ONE, f32::INFINITY),
            (Vec3::splat(9.0), Vec3::ONE, f32::NAN),
            (Vec3::splat(9.0), Vec3::ONE, -1.0),
        ];
        let found = read(&points).unwrap();
        assert_eq!(
            (found.mass, found.barycentre, found.velocity),
            (4.0, Vec3::X * 0.5, Vec3::Y * 0.5)
        );

        let pinned = points[..2].iter().map(|&(p, v, _)| (p, v, f32::INFINITY));
        let found = motion(pinned).unwrap();
        assert_eq!((found.mass, found.barycentre, found.inertia), (0.0, Vec3::ZERO, Mat3::ZERO));
        assert!((found.angular_velocity - Vec3::Z).length() < 1e-7);
    }

    #[test]
    fn a_plate_spins_about_any_axis_and_a_rod_about_any_but_its_own() {
        let mut random = Random::new(11);
        for _ in 0..1000 {
            let (along, w) = (random.direction(), random.direction() * 10.0);
            let across = along.cross(random.direction());
            let plate = [along + across, along - across, -along - across, -along + across]
                .map(|p| (p, 1.0));
            let found = read(&spinning(&plate, Vec3::ZERO, Vec3::ONE, w)).unwrap();
            assert!((found.angular_velocity - w).length() < 1e-3, "{} {w}", found.angular_velocity);

            let rod = [-3.0, -1.0, 0.0, 4.0].map(|x| (along * x, 2.0));
            let found = read(&spinning(&rod, Vec3::ZERO, Vec3::ZERO, w)).unwrap();
            let direction = along.normalize();
            let expected = w - direction * direction.dot(w);
            assert!(
                (found.angular_velocity - expected).length() < 1e-4,
                "{} {expected}",
                found.angular_velocity
            );
        }
    }

    #[test]
    fn one_particle_or_many_in_one_place_do_not_spin() {
        let at = Vec3::new(0.1, 0.2, 0.3);
        for n in 1..5 {
            let points: Vec<_> = (0..n).map(|i| (at, Vec3::X * i as f32, 0.1)).collect();
            let found = read(&points).unwrap();
            assert_eq!(
                (found.barycentre, found.angular_velocity, found.inertia),
                (at, Vec3::ZERO, Mat3::ZERO)
            );
        }
    }

    #[test]
    fn what_is_not_finite_or_not_there_has_no_motion() {
        assert_eq!(read(&[]), None);
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let good = (Vec3::X, Vec3::Y, 1.0);
            assert_eq!(read(&[good, (Vec3::Y, Vec3::Z * bad, 1.0)]), None);
            assert_eq!(read(&[(Vec3::Y * bad, Vec3::Z, 1.0), good]), None);
        }
        // Finite particles whose inertia overflows `f32`.
        assert_eq!(read(&[(Vec3::X * 1e30, Vec3::X, 1.0), (Vec3::ZERO, Vec3::X, 1.0)]), None);
    }
}
