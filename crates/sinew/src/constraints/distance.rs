//! Equidistance: two particles stay a fixed distance apart (physics.md C1), or no farther (a rope), or no nearer (a strut; C2).

use glam::{Vec3, Vec4};

/// "Particles `a` and `b` stay `rest` metres apart."
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distance {
    /// Row of the first particle.
    pub a: u32,
    /// Row of the second particle, another one than `a`.
    pub b: u32,
    /// Length to keep, metres, not negative. Zero makes the particles coincide.
    pub rest: f32,
    /// Inverse stiffness, m/N: 0 (the default of [`Distance::new`]) is hard, larger is softer. A compliant distance behaves
    /// like a spring of stiffness `1/compliance`, whatever the number of sweeps and substeps (Macklin et al., *XPBD*, 2016).
    pub compliance: f32,
    /// Whether the length is kept both ways, or only one.
    pub bound: Bound,
}

/// Which way a distance is enforced.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Bound {
    /// Exactly the rest length: a rod.
    #[default]
    Equal,
    /// The rest length or less: a rope or a tether.
    AtMost,
    /// The rest length or more: a strut.
    AtLeast,
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
    /// NaN, infinite or negative compliance.
    #[error("its compliance is not a finite number of metres per newton")]
    Compliance,
}

impl Distance {
    /// A hard rod of `rest` metres between two particles.
    pub fn new(a: u32, b: u32, rest: f32) -> Self {
        Self { a, b, rest, compliance: 0.0, bound: Bound::Equal }
    }

    /// The same with a compliance, m/N.
    pub fn with_compliance(self, compliance: f32) -> Self {
        Self { compliance, ..self }
    }

    /// The same as an inequality.
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
        } else if !(self.compliance.is_finite() && self.compliance >= 0.0) {
            Some(DistanceFault::Compliance)
        } else {
            None
        }
    }

    /// How far the distance is from being kept, metres, not negative; 0 for an inequality that holds.
    pub fn error(&self, position_a: Vec3, position_b: Vec3) -> f32 {
        let value = length(position_a - position_b) - self.rest;
        if self.bound.holds(value) { 0.0 } else { value.abs() }
    }
}

impl Bound {
    /// Whether the constraint asks for nothing when its value (length less rest length) is `value`.
    #[inline]
    pub(crate) fn holds(self, value: f32) -> bool {
        match self {
            Bound::Equal => false,
            Bound::AtMost => value <= 0.0,
            Bound::AtLeast => value >= 0.0,
        }
    }
}

/// Projects one hard rod onto its constraint and returns how far it was from being kept, in metres.
///
/// `C = ‖d‖ - L` with `d = a - b`; its gradients are `±n`, `n = d/‖d‖`. So `Σ wⱼ‖∇ⱼC‖² = w_a + w_b` and the minimiser is
/// `Δa = -w_a λ n`, `Δb = +w_b λ n` with `λ = C/(w_a + w_b)`: the lectures' closed form with `w = 1/m`. It is exact, because
/// `C` is linear along its own gradient, and it keeps the barycentre: `m_a Δa + m_b Δb = 0`.
///
/// The kernel that everything waits for: written as `d · C/(‖d‖ (w_a + w_b))`, it takes one square root and one division.
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
    // Both pinned, or in the same place: rare, and not worth a branch above.
    project(positions, a as u32, b as u32, rest, 0.0, Bound::Equal, &mut 0.0)
}

/// Keeps the inverse mass in the fourth lane out of arithmetic on positions.
const XYZ: Vec4 = Vec4::new(1.0, 1.0, 1.0, 0.0);

/// Projects any distance, hard or soft, both ways or one, and returns how far it was from being kept, in metres.
///
/// With a compliance α the multiplier is summed over the sweeps of a substep in `lambda`, and each sweep solves for its
/// change: `Δλ = (C - α̃ λ)/(w_a + w_b + α̃)`, `α̃ = α/h²` (XPBD, eq. 18, with the sign of λ turned). An inequality only ever
/// pushes one way, so its sum is held on that side of zero. With α = 0 this is the formula of [`project_rod`].
///
/// Coincident particles have no direction: they are pushed apart along the x axis, `a` towards +x.
#[inline]
pub(crate) fn project(
    positions: &mut [Vec4],
    a: u32,
    b: u32,
    rest: f32,
    scaled_compliance: f32,
    bound: Bound,
    lambda: &mut f32,
) -> f32 {
    let (pa, pb) = (positions[a as usize], positions[b as usize]);
    let d = pa.truncate() - pb.truncate();
    let len = length(d);
    let value = len - rest;
    let weights = pa.w + pb.w;
    if weights == 0.0 || (*lambda == 0.0 && bound.holds(value)) {
        return 0.0;
    }
    let asked = (value - scaled_compliance * *lambda) / (weights + scaled_compliance);
    let change = match bound {
        Bound::Equal => asked,
        Bound::AtMost => (asked + *lambda).max(0.0) - *lambda,
        Bound::AtLeast => (asked + *lambda).min(0.0) - *lambda,
    };
    // The sum matters to soft constraints alone; a hard inequality projects afresh in each sweep.
    *lambda = if scaled_compliance > 0.0 { *lambda + change } else { 0.0 };
    let n = if len > 0.0 { d / len } else { Vec3::X };
    positions[a as usize] -= (n * (pa.w * change)).extend(0.0);
    positions[b as usize] += (n * (pb.w * change)).extend(0.0);
    if bound.holds(value) { 0.0 } else { value.abs() }
}

/// `‖d‖`, with the products and sums in a fixed order and no fused operations, so that it is the same on every machine.
#[inline]
fn length(d: Vec3) -> f32 {
    (d.x * d.x + d.y * d.y + d.z * d.z).sqrt()
}

/// The same of a vector whose fourth lane does not count.
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

    fn hard(positions: &mut [Vec4], rest: f32, bound: Bound) -> f32 {
        match bound {
            Bound::Equal => project_rod(positions, 0, 1, rest),
            _ => project(positions, 0, 1, rest, 0.0, bound, &mut 0.0),
        }
    }

    #[test]
    fn the_kernel_of_hard_rods_agrees_with_the_general_one() {
        for (wa, wb, rest) in [(1.0, 1.0, 0.5), (0.25, 3.0, 2.0), (0.0, 1.0, 1.0), (1.0, 0.0, 0.0)]
        {
            let mut one = pair(Vec3::new(0.3, -1.0, 2.0), Vec3::new(1.0, 0.5, -0.2), wa, wb);
            let mut other = one;
            let fast = project_rod(&mut one, 0, 1, rest);
            let slow = project(&mut other, 0, 1, rest, 0.0, Bound::Equal, &mut 0.0);
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
        // Move along the constraint surface from the found minimiser: every way is uphill.
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
        // Two free particles of 1 kg: the soft minimiser of Σ½m d² /h² + C²/2α has λ = C/(w_a + w_b + α̃), in any number of sweeps.
        for sweeps in [1, 2, 10] {
            let mut p = pair(Vec3::ZERO, Vec3::X * 2.0, 1.0, 1.0);
            let (alpha, mut lambda) = (0.5, 0.0);
            for _ in 0..sweeps {
                project(&mut p, 0, 1, 1.0, alpha, Bound::Equal, &mut lambda);
            }
            assert!((lambda - 1.0 / 2.5).abs() < 1e-6, "{sweeps}: {lambda}");
            assert!((p[0].x - 0.4).abs() < 1e-6, "{sweeps}: {}", p[0].x);
        }
    }

    #[test]
    fn faults_are_told_apart() {
        let good = Distance::new(0, 1, 1.0);
        assert_eq!(good.fault(2), None);
        assert_eq!(Distance::new(1, 1, 1.0).fault(2), Some(DistanceFault::SameParticle));
        assert_eq!(good.fault(1), Some(DistanceFault::MissingParticle));
        assert_eq!(Distance::new(0, 1, f32::NAN).fault(2), Some(DistanceFault::Rest));
        assert_eq!(good.with_compliance(-1.0).fault(2), Some(DistanceFault::Compliance));
    }
}
