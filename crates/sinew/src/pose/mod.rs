//! What a game reads back from a compound of particles: its transform here ([`pose`]), its mass, barycentre, velocity,
//! angular velocity and inertia in [`motion`] (physics.md E1 to E3). The particles know none of these: they emerge.
//!
//! # The transform
//!
//! Particle `i` rests at `rᵢ` in the compound's own frame and is now at `pᵢ`. Wanted: the rigid transform `x = R r + t` with
//! the least `Σ mᵢ ‖R rᵢ + t - pᵢ‖²`.
//!
//! For a given `R` the sum is least where its derivative by `t` vanishes: `t = p̄ - R r̄`, with the mass-weighted means `p̄`
//! and `r̄`. (The lecture's `p̄ - r̄` is the case `r̄ = 0`.) What is left, with `a = p - p̄` and `b = r - r̄`, is
//! `Σ m ‖R b - a‖² = Σ m (‖b‖² + ‖a‖²) - 2 Σ m a·R b`, and `Σ m a·R b = tr(Rᵀ M)` with
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
//! Everything is `f64` until the end. Products of two `f32` are then exact, no size from 1e-38 m to 1e38 m overflows or
//! vanishes, so nothing needs scaling beforehand, and the conversion is free beside the loads. That also allows one pass
//! over the particles: with `a' = p - p₀` and `b' = r - r₀`, relative to the first particle (a difference without
//! round-off, so particles that coincide give exactly zero, wherever they are), `M = Σ m a' b'ᵀ - (Σ m) ā' b̄'ᵀ`. What
//! cancels there is at most the share of the first particle in the mass: 6 of 16 digits if it has a millionth of it.
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

pub(crate) use inertia::MassMoments;
pub(crate) use inertia::spin as pseudo_solve;
pub use inertia::{Motion, motion};
pub(crate) use moments::MomentSums;
pub use normals::normals;
pub(crate) use symmetric::WORST;

use glam::{DMat3, DQuat, DVec3, Quat, Vec3};

/// A rigid transform from the rest frame of a compound to the world: a point at `r` goes to `rotation * r + translation`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Where the origin of the rest frame is now, metres.
    pub translation: Vec3,
    /// How the rest frame is turned; a unit quaternion.
    pub rotation: Quat,
}

impl Pose {
    /// The rest frame where it was: no translation, no rotation.
    pub const IDENTITY: Self = Self { translation: Vec3::ZERO, rotation: Quat::IDENTITY };

    /// Where this pose puts a point at `rest`, metres. The same bits on every machine, unlike `Quat * Vec3`.
    pub fn point(self, rest: Vec3) -> Vec3 {
        let axis = Vec3::new(self.rotation.x, self.rotation.y, self.rotation.z);
        let across = axis.cross(rest) * 2.0;
        rest + across * self.rotation.w + axis.cross(across) + self.translation
    }
}

impl Default for Pose {
    fn default() -> Self {
        Self::IDENTITY
    }
}

/// The rigid transform that best carries the rest positions onto the current ones: least `Σ m ‖R r + t - p‖²`.
///
/// `points` yields, for each particle, its position now (m, world), its rest position (m, compound's frame) and its weight,
/// normally its mass in kg. It is read once, twice if no weight counts, always in its own order; nothing is allocated:
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
/// **Weights** are positive and finite. A particle whose weight is zero, negative, infinite or NaN does not count, so give
/// a pinned particle the mass that it would have if it were let go. If no weight counts, all particles count equally.
///
/// **`previous`** is the rotation of the last call (any rotation will do, the identity for instance; one that is zero or not
/// finite is taken for the identity). It makes the answer cheap, and decides wherever the particles do not:
/// - one particle, or all in one place: `previous` is kept;
/// - on a line: `previous`, turned by the shortest arc that aims it along the line, so without twist. (A line led around a
///   cone comes back twisted by the solid angle all the same; any rule that depends on directions continuously does that.)
///   A line that is reversed exactly turns about an axis across it that is arbitrary, but always the same;
/// - mirrored so that several rotations are equally good: the one nearest to `previous`.
///
/// Elsewhere the result depends on it by round-off only. The quaternion returned is in `previous`'s hemisphere, so
/// two successive ones can be interpolated. A line, here, is thinner than 1 in 30 000 of its length.
///
/// The result is a proper rotation whatever the particles are, mirrored, flat or crushed; it is never a reflection.
///
/// `None` if there is no particle, or one that counts has a position or a rest position that is not finite (or that brings
/// the result outside `f32`): keep the last pose, and report the compound.
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
    /// `M`, kg·m²: how the positions go with the rest positions.
    moments: DMat3,
}

impl MatchedMoments {
    /// `None` if there is nothing to sum.
    fn sum(mut points: impl Iterator<Item = (Vec3, Vec3, f64)>) -> Option<Self> {
        let (now, rest, mut mass) = points.next()?;
        let (now, rest) = (now.as_dvec3(), rest.as_dvec3());
        // The first particle adds nothing but its mass: it is the origin.
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
        // With the rotation as it was rounded, and as `Pose::point` applies it, so that the barycentre is met.
        let axis = Vec3::new(rotation.x, rotation.y, rotation.z).as_dvec3();
        let across = axis.cross(self.rest) * 2.0;
        let rest = self.rest + across * f64::from(rotation.w) + axis.cross(across);
        let translation = (self.now - rest).as_vec3();
        translation.is_finite().then_some(Pose { translation, rotation })
    }
}

/// `a bᵀ`.
#[inline]
fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// The quaternion brought to length 1, or the identity if it has no direction.
fn unit(q: Quat) -> DQuat {
    let q = DQuat::from_xyzw(q.x.into(), q.y.into(), q.z.into(), q.w.into());
    let length = q.length();
    if length.is_finite() && length > 0.0 { q * (1.0 / length) } else { DQuat::IDENTITY }
}
