//! The distance between two particles: exact (physics.md C1), an upper limit (a rope), or a lower limit (a strut; C2).

use glam::{Vec3, Vec4};

use super::equation::{Bound, Equation, Points, change, unfinished};
use super::softness::{Softness, SubstepContext};

/// Keeps particles `a` and `b` at the distance `rest`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distance {
    /// Row of the first particle.
    pub a: u32,
    /// Row of the second particle; must differ from `a`.
    pub b: u32,
    /// Length to keep, metres, 0 or more. Zero makes the particles coincide.
    pub rest: f32,
    /// How stiff the constraint is. Hard from [`Distance::new`].
    pub softness: Softness,
    /// Whether the length is kept exactly, or only as an upper or lower limit.
    pub bound: Bound,
}

/// What is wrong with a distance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DistanceFault {
    /// `a` and `b` are the same particle.
    #[error("both its ends are the same particle")]
    SameParticle,
    /// One of the ends is not a row of the simulation.
    #[error("one of its particles does not exist")]
    MissingParticle,
    /// NaN, infinite or negative rest length.
    #[error("its rest length is not a finite length")]
    Rest,
    /// NaN, infinite or negative compliance, damping, frequency or share.
    #[error("its softness is not a finite number in range")]
    Softness,
}

impl Distance {
    /// A hard rod of `rest` metres between two particles.
    pub fn new(a: u32, b: u32, rest: f32) -> Self {
        Self { a, b, rest, softness: Softness::Hard, bound: Bound::Equal }
    }

    /// The same distance with a compliance, m/N.
    pub fn with_compliance(self, compliance: f32) -> Self {
        Self { softness: Softness::compliant(compliance), ..self }
    }

    /// The same distance with another softness.
    pub fn with_softness(self, softness: Softness) -> Self {
        Self { softness, ..self }
    }

    /// The same distance as an inequality.
    pub fn with_bound(self, bound: Bound) -> Self {
        Self { bound, ..self }
    }

    /// Why this distance cannot be enforced among `particles` rows, or `None` if it can.
    pub fn fault(&self, particles: usize) -> Option<DistanceFault> {
        if self.a == self.b {
            Some(DistanceFault::SameParticle)
        } else if self.a.max(self.b) as usize >= particles {
            Some(DistanceFault::MissingParticle)
        } else if !(self.rest.is_finite() && self.rest >= 0.0) {
            Some(DistanceFault::Rest)
        } else if !self.softness.is_valid() {
            Some(DistanceFault::Softness)
        } else {
            None
        }
    }

    /// Violation of the distance, metres, 0 or more; 0 for an inequality that holds.
    pub fn error(&self, position_a: Vec3, position_b: Vec3) -> f32 {
        let value = length(position_a - position_b) - self.rest;
        if self.bound.holds(value) { 0.0 } else { value.abs() }
    }
}

/// Particles `a`, then `b`. The solver uses dedicated kernels for distances; this implementation is for code that handles constraints of any kind.
impl Equation for Distance {
    fn evaluate(&self, points: &Points, gradients: &mut [Vec3]) -> f32 {
        let (n, len) = direction(points.at(0) - points.at(1));
        gradients.copy_from_slice(&[n, -n]);
        len - self.rest
    }

    fn bound(&self) -> Bound {
        self.bound
    }

    fn softness(&self) -> Softness {
        self.softness
    }

    fn is_internal(&self) -> bool {
        true
    }

    fn is_length(&self) -> bool {
        true
    }
}

/// Projects one hard rod and returns its error before the projection, metres.
///
/// `C = ‖d‖ - L` with `d = a - b`; its gradients are `±n`, `n = d/‖d‖`. So `Σ wⱼ‖∇ⱼC‖² = w_a + w_b` and the minimiser is
/// `Δa = -w_a λ n`, `Δb = +w_b λ n` with `λ = C/(w_a + w_b)`: the closed form with `w = 1/m`. It is exact, because
/// `C` is linear along its own gradient, and it keeps the barycentre: `m_a Δa + m_b Δb = 0`.
///
/// This is the hottest kernel of the solver. Written as `d · C/(‖d‖ (w_a + w_b))`, it takes one square root and one division.
#[inline]
pub(crate) fn project_rod(positions: &mut [Vec4], a: u32, b: u32, rest: f32) -> f32 {
    let (a, b) = (a as usize, b as usize);
    let (pa, pb) = (positions[a], positions[b]);
    let d = (pa - pb) * XYZ;
    let len = length4(d);
    let value = len - rest;
    let divisor = len * (pa.w + pb.w);
    if divisor > 0.0 {
        let scale = value / divisor;
        positions[a] = pa - d * (pa.w * scale);
        positions[b] = pb + d * (pb.w * scale);
        return value.abs();
    }
    // Both pinned or coincident: rare, so kept out of the hot path.
    project_degenerate(positions, a, b, rest)
}

/// Masks the inverse mass in the fourth lane out of arithmetic on positions.
const XYZ: Vec4 = Vec4::new(1.0, 1.0, 1.0, 0.0);

/// Handles a hard rod between coincident particles, or between pinned ones.
#[cold]
fn project_degenerate(positions: &mut [Vec4], a: usize, b: usize, rest: f32) -> f32 {
    let weights = positions[a].w + positions[b].w;
    if weights == 0.0 {
        return 0.0;
    }
    let change = Vec3::X * (rest / weights);
    positions[a] += (change * positions[a].w).extend(0.0);
    positions[b] -= (change * positions[b].w).extend(0.0);
    rest
}

/// Projects one hard rod along its direction at the start of the substep (SHAKE), and returns its error before the projection, metres.
///
/// If the force of a rod acts along the rod at the *start* of the step, Verlet conserves angular momentum and energy. Required is the multiple `s` of
/// `d = p_b - p_a`, the rod at the start, with `‖d* - s (w_a + w_b) d‖ = L` for `d* = q_b - q_a`. To first order in `s`, `‖d*‖² - 2 s (w_a + w_b) d*·d = L²`:
///
/// ```text
/// s = (‖d*‖² - L²) / (2 (w_a + w_b) d*·d)        q_a += w_a s d,  q_b -= w_b s d
/// ```
///
/// This is a Newton step without a square root (only the returned error, a length, takes one). Where the rod has turned too far for it, or has no direction, it
/// is projected to the nearest point instead.
#[inline]
pub(crate) fn project_rod_from_start(
    positions: &mut [Vec4],
    starts: &[Vec4],
    a: u32,
    b: u32,
    rest: f32,
) -> f32 {
    let (pa, pb) = (positions[a as usize], positions[b as usize]);
    let now = (pb - pa).truncate();
    let start = (starts[b as usize] - starts[a as usize]).truncate();
    let square = now.length_squared();
    let along = now.dot(start);
    // A third of its value for a rod that has not turned: 70°, far beyond the angle at which the island falls back to the nearest point.
    if along <= rest * rest * (1.0 / 3.0) {
        return project_rod(positions, a, b, rest);
    }
    let weights = pa.w + pb.w;
    if weights > 0.0 {
        let s = (square - rest * rest) / (2.0 * weights * along);
        positions[a as usize] = pa + (start * (pa.w * s)).extend(0.0);
        positions[b as usize] = pb - (start * (pb.w * s)).extend(0.0);
        return (square.sqrt() - rest).abs();
    }
    0.0
}

/// Projects any distance, hard or soft, equality or inequality. Returns the error before the projection, metres; for a soft distance, what
/// it [counts as](unfinished).
///
/// A soft distance accumulates its multiplier over the sweeps of a substep in `lambda`. A hard equality uses the formula of [`project_rod`].
///
/// Coincident particles have no direction: they are pushed apart along the x axis, `a` towards +x.
#[inline]
pub(crate) fn project(
    positions: &mut [Vec4],
    starts: &[Vec4],
    distance: &Distance,
    substep_context: SubstepContext,
    lambda: &mut f32,
) -> f32 {
    let Distance { a, b, rest, softness, bound } = *distance;
    let (a, b) = (a as usize, b as usize);
    let (pa, pb) = (positions[a], positions[b]);
    let d = pa.truncate() - pb.truncate();
    let (n, len) = direction(d);
    let value = len - rest;
    let weights = pa.w + pb.w;
    if weights == 0.0 || (*lambda == 0.0 && bound.holds(value)) {
        return 0.0;
    }
    let moved = n.dot(d - (starts[a] - starts[b]).truncate());
    let change = change((softness, bound), substep_context, (value, weights, moved), lambda);
    positions[a] -= (n * (pa.w * change)).extend(0.0);
    positions[b] += (n * (pb.w * change)).extend(0.0);
    match (softness.is_hard(), bound.holds(value)) {
        (true, true) => 0.0,
        (true, false) => value.abs(),
        (false, _) => unfinished(softness, value.abs(), (change * weights).abs()),
    }
}

/// The unit vector along a difference of positions, and its length, metres. The direction of a zero vector is +x.
#[inline]
pub(super) fn direction(d: Vec3) -> (Vec3, f32) {
    let length = length(d);
    (if length > 0.0 { d / length } else { Vec3::X }, length)
}

/// `‖d‖`, with the products and sums in a fixed order and no fused operations, so that it is the same on every machine.
#[inline]
fn length(d: Vec3) -> f32 {
    (d.x * d.x + d.y * d.y + d.z * d.z).sqrt()
}

/// The same for the first three lanes of a vector.
#[inline]
fn length4(d: Vec4) -> f32 {
    let square = d * d;
    (square.x + square.y + square.z).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pair(a: Vec3, b: Vec3, wa: f32, wb: f32) -> [Vec4; 2] {
        [a.extend(wa), b.extend(wb)]
    }

    const CONTEXT: SubstepContext = SubstepContext { h: 1.0, sweeps: 1 };

    fn hard(positions: &mut [Vec4], rest: f32, bound: Bound) -> f32 {
        if bound == Bound::Equal {
            project_rod(positions, 0, 1, rest)
        } else {
            any(positions, rest, bound)
        }
    }

    fn any(positions: &mut [Vec4], rest: f32, bound: Bound) -> f32 {
        let distance = Distance::new(0, 1, rest).with_bound(bound);
        project(positions, &[Vec4::ZERO; 2], &distance, CONTEXT, &mut 0.0)
    }

    #[test]
    fn the_kernel_of_hard_rods_agrees_with_the_general_one() {
        for (wa, wb, rest) in [(1.0, 1.0, 0.5), (0.25, 3.0, 2.0), (0.0, 1.0, 1.0), (1.0, 0.0, 0.0)]
        {
            let mut one = pair(Vec3::new(0.3, -1.0, 2.0), Vec3::new(1.0, 0.5, -0.2), wa, wb);
            let mut other = one;
            let fast = project_rod(&mut one, 0, 1, rest);
            let slow = any(&mut other, rest, Bound::Equal);
            assert_eq!(fast, slow);
            assert!(one[0].abs_diff_eq(other[0], 1e-6) && one[1].abs_diff_eq(other[1], 1e-6));
        }
    }

    #[test]
    fn unequal_masses_share_the_correction_as_the_lectures_say() {
        let (ma, mb) = (2.0, 3.0);
        let (pa, pb) = (Vec3::new(0.0, 1.0, 0.0), Vec3::new(3.0, 1.0, 4.0));
        let mut p = pair(pa, pb, 1.0 / ma, 1.0 / mb);
        let error = hard(&mut p, 2.0, Bound::Equal);
        let n = (pa - pb) / 5.0;
        assert_eq!(error, 3.0);
        assert!(p[0].truncate().abs_diff_eq(pa - n * (mb / (ma + mb) * 3.0), 1e-6));
        assert!(p[1].truncate().abs_diff_eq(pb + n * (ma / (ma + mb) * 3.0), 1e-6));
        let barycentre = p[0].truncate() * ma + p[1].truncate() * mb;
        assert!(barycentre.abs_diff_eq(pa * ma + pb * mb, 1e-5));
        assert_eq!(p[0].w, 1.0 / ma, "the inverse mass in the fourth lane stays");
    }

    #[test]
    fn no_smaller_weighted_displacement_reaches_the_constraint() {
        // Moves along the constraint surface from the minimiser: the cost rises in every direction.
        let (pa, pb) = (Vec3::ZERO, Vec3::new(1.5, 0.2, -0.4));
        let (ma, mb) = (1.0_f32, 4.0_f32);
        let mut p = pair(pa, pb, 1.0 / ma, 1.0 / mb);
        hard(&mut p, 1.0, Bound::Equal);
        let (qa, qb) = (p[0].truncate(), p[1].truncate());
        let cost =
            |a: Vec3, b: Vec3| ma * (a - pa).length_squared() + mb * (b - pb).length_squared();
        let best = cost(qa, qb);
        for step in [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z] {
            let a = qa + step * 0.01;
            let b = a + (qb - a).normalize();
            assert!(cost(a, b) >= best - 1e-6, "{step}");
            assert!(cost(qa + step * 0.01, qb + step * 0.01) >= best - 1e-6, "{step}");
        }
    }

    #[test]
    fn a_rope_pulls_and_a_strut_pushes_and_neither_does_the_other() {
        let mut p = pair(Vec3::ZERO, Vec3::X, 1.0, 1.0);
        assert_eq!(hard(&mut p, 2.0, Bound::AtMost), 0.0);
        assert_eq!(p, pair(Vec3::ZERO, Vec3::X, 1.0, 1.0));
        assert_eq!(hard(&mut p, 0.5, Bound::AtLeast), 0.0);
        assert_eq!(p, pair(Vec3::ZERO, Vec3::X, 1.0, 1.0));
        hard(&mut p, 0.5, Bound::AtMost);
        assert!((p[1].x - p[0].x - 0.5).abs() < 1e-6);
        hard(&mut p, 2.0, Bound::AtLeast);
        assert!((p[1].x - p[0].x - 2.0).abs() < 1e-6);
    }

    #[test]
    fn coincident_particles_part_along_x_and_two_pinned_ones_stay() {
        let mut p = pair(Vec3::Y, Vec3::Y, 1.0, 1.0);
        hard(&mut p, 1.0, Bound::Equal);
        assert_eq!(p[0].truncate(), Vec3::new(0.5, 1.0, 0.0));
        assert_eq!(p[1].truncate(), Vec3::new(-0.5, 1.0, 0.0));
        let mut p = pair(Vec3::Y, Vec3::Z, 0.0, 0.0);
        hard(&mut p, 9.0, Bound::Equal);
        assert_eq!(p, pair(Vec3::Y, Vec3::Z, 0.0, 0.0));
    }

    #[test]
    fn many_sweeps_of_a_soft_distance_agree_with_one_exact_solve() {
        // Two free particles of 1 kg: the soft minimiser of Σ½m d² /h² + C²/2α has λ = C/(w_a + w_b + α̃), at any number of sweeps.
        for sweeps in [1, 2, 10] {
            let mut p = pair(Vec3::ZERO, Vec3::X * 2.0, 1.0, 1.0);
            let (soft, mut lambda) = (Distance::new(0, 1, 1.0).with_compliance(0.5), 0.0);
            for _ in 0..sweeps {
                project(&mut p, &[Vec4::ZERO; 2], &soft, CONTEXT, &mut lambda);
            }
            assert!((lambda - 1.0 / 2.5).abs() < 1e-6, "{sweeps}: {lambda}");
            assert!((p[0].x - 0.4).abs() < 1e-6, "{sweeps}: {}", p[0].x);
        }
    }

    #[test]
    fn a_rod_corrected_along_its_start_keeps_the_angular_momentum_of_the_step() {
        let starts = [Vec4::ZERO, Vec4::X];
        let mut p = pair(Vec3::new(0.0, -0.05, 0.0), Vec3::new(1.02, 0.1, 0.03), 1.0, 0.5);
        let momentum = |p: &[Vec4; 2]| {
            (0..2).map(|i| starts[i].truncate().cross(p[i].truncate()) / p[i].w).sum::<Vec3>()
        };
        let before = momentum(&p);
        for _ in 0..4 {
            project_rod_from_start(&mut p, &starts, 0, 1, 1.0);
        }
        assert!(momentum(&p).abs_diff_eq(before, 1e-6));
        assert!((p[0].truncate().distance(p[1].truncate()) - 1.0).abs() < 1e-6);
        let mut far = pair(Vec3::ZERO, Vec3::Y * 1.5, 1.0, 1.0);
        project_rod_from_start(&mut far, &starts, 0, 1, 1.0);
        assert!((far[1].y - far[0].y - 1.0).abs() < 1e-6, "turned too far: the nearest point");
    }

    #[test]
    fn faults_are_told_apart() {
        let good = Distance::new(0, 1, 1.0);
        assert_eq!(good.fault(2), None);
        assert_eq!(Distance::new(1, 1, 1.0).fault(2), Some(DistanceFault::SameParticle));
        assert_eq!(good.fault(1), Some(DistanceFault::MissingParticle));
        assert_eq!(Distance::new(0, 1, f32::NAN).fault(2), Some(DistanceFault::Rest));
        assert_eq!(good.with_compliance(-1.0).fault(2), Some(DistanceFault::Softness));
    }
}
