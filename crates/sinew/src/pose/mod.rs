//! Motion of a compound of particles as a whole: its transform here ([`pose`], shape matching), its mass, barycentre, velocity, angular velocity and inertia in
//! [`motion`] (physics.md E1 to E3). All of them are computed from the particles; none is stored.
//!
//! # The transform
//!
//! Particle `i` has the rest position `rᵢ` in the compound's own frame and is now at `pᵢ`. The rigid transform `x = R r + t` minimises `Σ mᵢ ‖R rᵢ + t - pᵢ‖²`.
//!
//! For a given `R` the sum is least where its derivative by `t` vanishes: `t = p̄ - R r̄`, with the mass-weighted means `p̄` and `r̄`. (The lecture's `p̄ - r̄`
//! is the case `r̄ = 0`.) The rest, with `a = p - p̄` and `b = r - r̄`, is `Σ m ‖R b - a‖² = Σ m (‖b‖² + ‖a‖²) - 2 Σ m a·R b`, and `Σ m a·R b = tr(Rᵀ M)` with
//!
//! ```text
//! M = Σ m a bᵀ = Σ m (p - p̄)(r - r̄)ᵀ
//! ```
//!
//! so `R` is the rotation with the greatest `tr(Rᵀ M)`: the one nearest to `M` (`rotation.rs` finds it). The lecture
//! writes `Σ m r ⊗ p`, which is `Mᵀ`: its nearest rotation, applied to column vectors as here, is `Rᵀ`.
//!
//! If the particles are the rest shape turned by `Q` and stretched, `p = Q S r` with `S` symmetric and positive, then
//! `M = Q S C` with `C = Σ m b bᵀ`. The result is exactly `Q` where `S` and `C` commute: no stretch, or one along the
//! principal axes, or a shape with equal moments such as a cube. Otherwise `R` is still the least-squares answer.
//!
//! # The sums
//!
//! Everything is `f64` until the end. Products of two `f32` are then exact, and no size from 1e-38 m to 1e38 m overflows or underflows, so nothing needs
//! scaling beforehand; the conversion costs nothing beside the loads. It also allows one pass over the particles: with `a' = p - p₀` and `b' = r - r₀`,
//! relative to the first particle (a difference without round-off, so particles that coincide give exactly zero, wherever they are), `M = Σ m a' b'ᵀ - (Σ m) ā'
//! b̄'ᵀ`. The cancellation is limited by the first particle's share of the mass: it costs 6 of 16 digits if that is a millionth.
//!
//! Only `+ - × ÷ √` in a fixed order, on scalar types (glam's `DVec3`, `DMat3`, `DQuat` are scalar everywhere; its `Quat`
//! is not): the same bits on every machine.

#[cfg(test)]
mod degenerate_tests;
mod inertia;
mod moments;
mod normals;
pub(crate) mod rotation;
pub(crate) mod symmetric;
#[cfg(test)]
mod tests;

pub(crate) use inertia::spin as pseudo_solve;
pub(crate) use inertia::{MassMoments, PointMasses};
pub use inertia::{Motion, motion};
pub(crate) use moments::MomentSums;
pub use normals::normals;

use glam::{DMat3, DQuat, DVec3, Quat, Vec3};

/// A rigid transform from the rest frame of a compound to the world: a point at `r` goes to `rotation * r + translation`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Position of the rest frame's origin, metres.
    pub translation: Vec3,
    /// Rotation of the rest frame; a unit quaternion.
    pub rotation: Quat,
}

impl Pose {
    /// No translation and no rotation.
    pub const IDENTITY: Self = Self { translation: Vec3::ZERO, rotation: Quat::IDENTITY };

    /// Transforms a point at `rest`, metres. The same bits on every machine, unlike `Quat * Vec3`.
    pub fn point(self, rest: Vec3) -> Vec3 {
        turned(self.rotation, rest) + self.translation
    }
}

impl Default for Pose {
    fn default() -> Self {
        Self::IDENTITY
    }
}

/// The rigid transform that best maps the rest positions to the current ones: least `Σ m ‖R r + t - p‖²`.
///
/// `points` yields the current position (m, world), the rest position (m, compound's frame) and the weight of each particle, normally its mass in kg. It is
/// read once, twice if no weight counts, always in its own order; nothing is allocated:
///
/// ```
/// # use glam::{Quat, Vec3};
/// # use sinew::pose::pose;
/// # let (positions, rest, masses) = ([Vec3::X, Vec3::Z], [Vec3::ZERO, Vec3::Y], [1.0, 1.0]);
/// # let (rows, last) = ([1_usize, 0], Quat::IDENTITY);
/// let points = rows.iter().zip(&rest).map(|(&row, &rest)| (positions[row], rest, masses[row]));
/// let found = pose(points, last);
/// # assert!(found.is_some());
/// ```
///
/// **Weights** are positive and finite. A particle whose weight is zero, negative, infinite or NaN does not count, so pass for a pinned particle the mass that
/// it would have unpinned. If no weight counts, all particles count equally.
///
/// **`previous`** is the result of the last call (any rotation will do, for instance the identity; zero or a non-finite one counts as the identity). It speeds
/// up the computation, and decides where the particles do not:
/// - one particle, or several that coincide: `previous` is kept;
/// - on a line: `previous`, turned by the shortest arc that aligns it with the line, so without twist. (A line moved around a cone comes back twisted by the
///   solid angle all the same; any rule that depends continuously on directions does that.) A line that is exactly reversed turns about an arbitrary
///   perpendicular axis, which is always the same;
/// - mirrored so that several rotations are equally good: the nearest of them to `previous`.
///
/// Otherwise the result depends on it only by round-off. The returned quaternion is in the hemisphere of `previous`, so that two successive results can be
/// interpolated. Particles count as on a line if they are thinner than 1 in 30 000 of its length.
///
/// The result is a proper rotation for any particles, mirrored, flat or crushed; never a reflection.
///
/// `None` if there is no particle, or if one that counts has a position or a rest position that is not finite (or that makes the result overflow `f32`): keep
/// the last pose, and report the compound.
pub fn pose(
    points: impl Iterator<Item = (Vec3, Vec3, f32)> + Clone,
    previous: Quat,
) -> Option<Pose> {
    let weighted = points.clone().filter(|&(_, _, mass)| counts(mass));
    let pairs = MatchedMoments::sum(weighted.map(|(p, r, mass)| (p, r, f64::from(mass))))
        .or_else(|| MatchedMoments::sum(points.map(|(p, r, _)| (p, r, 1.0))))?;
    pairs.pose(previous)
}

/// Whether a particle of this mass counts in an average.
#[inline]
pub(crate) fn counts(mass: f32) -> bool {
    mass > 0.0 && mass.is_finite()
}

/// Means of the positions and the rest positions, and the moments between them.
struct MatchedMoments {
    now: DVec3,
    rest: DVec3,
    /// `M`, kg·m²: the covariance of positions and rest positions.
    moments: DMat3,
}

impl MatchedMoments {
    /// `None` if there is nothing to sum.
    fn sum(mut points: impl Iterator<Item = (Vec3, Vec3, f64)>) -> Option<Self> {
        let (now, rest, mut mass) = points.next()?;
        let (now, rest) = (now.as_dvec3(), rest.as_dvec3());
        // The first particle is the origin, so it adds only its mass.
        let (mut first_a, mut first_b, mut moments) = (DVec3::ZERO, DVec3::ZERO, DMat3::ZERO);
        for (p, r, m) in points {
            let (a, b) = ((p.as_dvec3() - now) * m, r.as_dvec3() - rest);
            mass += m;
            first_a += a;
            first_b += b * m;
            moments += outer(a, b);
        }
        let share = 1.0 / mass;
        let (mean_a, mean_b) = (first_a * share, first_b * share);
        Some(Self {
            now: now + mean_a,
            rest: rest + mean_b,
            moments: moments - outer(first_a, mean_b),
        })
    }

    fn pose(&self, previous: Quat) -> Option<Pose> {
        if !(self.now.is_finite() && self.rest.is_finite()) {
            return None;
        }
        let rotation = rotation::nearest(self.moments, unit(previous)).as_quat();
        // With the rounded rotation, applied as `Pose::point` does, so that the barycentre is mapped exactly.
        let axis = Vec3::new(rotation.x, rotation.y, rotation.z).as_dvec3();
        let across = axis.cross(self.rest) * 2.0;
        let rest = self.rest + across * f64::from(rotation.w) + axis.cross(across);
        let translation = (self.now - rest).as_vec3();
        translation.is_finite().then_some(Pose { translation, rotation })
    }
}

/// A vector rotated by a unit quaternion. The same bits on every machine, unlike `Quat * Vec3`.
#[inline]
pub(crate) fn turned(rotation: Quat, v: Vec3) -> Vec3 {
    let axis = Vec3::new(rotation.x, rotation.y, rotation.z);
    let across = axis.cross(v) * 2.0;
    v + across * rotation.w + axis.cross(across)
}

/// `a bᵀ`.
#[inline]
pub(crate) fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// The quaternion normalised, or the identity if it has no direction.
fn unit(q: Quat) -> DQuat {
    let q = DQuat::from_xyzw(q.x.into(), q.y.into(), q.z.into(), q.w.into());
    let length = q.length();
    if length.is_finite() && length > 0.0 { q * (1.0 / length) } else { DQuat::IDENTITY }
}
