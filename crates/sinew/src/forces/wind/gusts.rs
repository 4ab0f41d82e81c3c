//! Gusts: a divergence-free turbulent velocity field made of waves with a parabolic profile.
//!
//! # Curl noise
//!
//! Air is nearly incompressible, so the velocity of a gust must be free of divergence: it is the curl of a potential. Take a wave `W` that travels along the
//! unit vector `k`, with the vector potential `ψ = s² (a × k) W(k·x/s)/s`, where `a` is a unit vector perpendicular to `k`. Its curl is
//!
//! ```text
//! ∇ × ψ = (k × (a × k)) W' = a W'(k·x/s)          and ∇·(a W') = (a·k) W''/s = 0
//! ```
//!
//! so a transverse wave (velocity `a` perpendicular to its direction `k`) has no divergence, and neither has a sum of them. Eight such waves in two octaves
//! cost eight dot products; lattice noise, the usual way, costs ten times as much and is free of divergence only as far as its derivatives are exact. `k` and
//! `a` are integers over their length (2² + 3² + 6² = 7²), so `a·k` is exactly zero.
//!
//! The smaller octave is weaker by the cube root of its size (Kolmogorov). A wave is carried along by the wind (Taylor's frozen turbulence) and in addition
//! travels along `k` by itself, about once per period, which makes the pattern change.

use glam::{Vec3, Vec4};

use crate::lanes::{InstructionSet, LANES, Lanes, Vector, Work, with};

/// A divergence-free turbulent velocity field at one instant. A pure function of position and time, so it has no state to save.
#[derive(Clone, Copy, Debug)]
pub(super) struct CurlNoise {
    /// Wave cycles per metre along each wave.
    turns: [Vec3; WAVES.len()],
    /// Phase of each wave, cycles in -1..1.
    run: [f32; WAVES.len()],
    /// Velocity amplitude of each wave, m/s.
    swing: [Vec3; WAVES.len()],
}

/// A wave: direction, velocity perpendicular to it, their common length; cycles per gust length, cycles per period, strength.
///
/// Densities and speeds are in no simple ratio, so the sum does not repeat within a scene.
struct Wave {
    k: [i8; 3],
    a: [i8; 3],
    length: i8,
    density: f32,
    speed: f32,
    strength: f32,
}

const fn wave(k: [i8; 3], a: [i8; 3], length: i8, [density, speed, strength]: [f32; 3]) -> Wave {
    Wave { k, a, length, density, speed, strength }
}

/// Strengths of the two octaves: in the ratio of the cube root of 2.2, and scaled so that each component of the velocity has a standard deviation of 1 on
/// average over the axes: 4 (0.94² + 0.724²) · 8/15 / 3 = 1, where 8/15 is the mean square of [`arch`].
const LARGE: f32 = 0.94;
const SMALL: f32 = 0.724;

const WAVES: [Wave; 8] = [
    wave([1, 2, 2], [2, -2, 1], 3, [1.0, 0.61, LARGE]),
    wave([-2, 1, 2], [1, -2, 2], 3, [1.13, -0.83, LARGE]),
    wave([2, -1, 2], [2, 2, -1], 3, [0.87, 0.47, LARGE]),
    wave([6, 2, -3], [2, 3, 6], 7, [1.21, -0.71, LARGE]),
    wave([2, 3, 6], [-6, -2, 3], 7, [2.1, 1.07, SMALL]),
    wave([6, -3, -2], [3, 2, 6], 7, [2.3, 1.31, SMALL]),
    wave([-3, 6, -2], [6, 2, -3], 7, [1.9, -1.19, SMALL]),
    wave([1, -2, 2], [2, 2, 1], 3, [2.47, -0.97, SMALL]),
];

impl CurlNoise {
    /// Eddies of `size` metres that change within `period` seconds and are carried along at `wind` m/s. Each component of their velocity has the standard
    /// deviation `strength`, m/s. `time` in seconds. `size` and `period` are positive.
    pub(super) fn new(strength: f32, size: f32, period: f32, wind: Vec3, time: f64) -> Self {
        let unit = |v: [i8; 3], length: i8| Vec3::from(v.map(f32::from)) / f32::from(length);
        Self {
            turns: WAVES.each_ref().map(|w| unit(w.k, w.length) * (w.density / size)),
            run: WAVES.each_ref().map(|w| {
                let carried = unit(w.k, w.length).as_dvec3().dot(wind.as_dvec3());
                let rate = carried * f64::from(w.density) / f64::from(size);
                fraction(time * (rate + f64::from(w.speed) / f64::from(period)))
            }),
            swing: WAVES.each_ref().map(|w| unit(w.a, w.length) * (w.strength * strength)),
        }
    }

    /// The velocity at eight positions, m/s.
    #[inline(always)]
    pub(super) fn at<L: Lanes>(&self, position: Vector<L>) -> Vector<L> {
        let mut sum = Vector::splat(Vec3::ZERO);
        for i in 0..WAVES.len() {
            let turn = position.dot(Vector::splat(self.turns[i])) - L::splat(self.run[i]);
            sum += Vector::splat(self.swing[i]) * arch(turn);
        }
        sum
    }
}

/// The fractional part, computed in f64, so that gusts are as smooth after a day as in the first second. In -1..1, also for values beyond the range of `i64`;
/// NaN stays NaN.
pub(super) fn fraction(turns: f64) -> f32 {
    (turns - turns as i64 as f64).clamp(-1.0, 1.0) as f32
}

/// A smooth wave of period 1 between -1 and 1, made of parabolas: a tenth of the time of a sine, and the same bits on every machine. Beyond 2²² cycles hardly
/// any fraction bits are left; the result is then no wave, but still at most 1.
#[inline(always)]
pub(super) fn arch<L: Lanes>(turn: L) -> L {
    // Adding 1.5·2²³ leaves no fraction bits, so this rounds to the nearest whole cycle without a branch.
    let no_fraction = L::splat(12_582_912.0);
    let whole = (turn + no_fraction) - no_fraction;
    // From -1 to 1, where 4 t (1 - |t|) is one full wave.
    let t = L::splat(2.0) * (turn - whole).max(L::splat(-0.5)).min(L::splat(0.5));
    L::splat(4.0) * t * (L::splat(1.0) - t.abs())
}

/// Evaluates a vector field, which works on eight positions, at a single one.
pub(super) fn at_one_place(position: Vec3, work: impl VectorField) -> Vec3 {
    with(InstructionSet::Simd128, OnePlace { position, work })
}

/// A vector field over space.
pub(super) trait VectorField {
    /// The vectors at eight positions.
    fn at<L: Lanes>(&self, position: Vector<L>) -> Vector<L>;
}

struct OnePlace<F> {
    position: Vec3,
    work: F,
}

impl<F: VectorField> Work for OnePlace<F> {
    type Output = Vec3;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Vec3 {
        let found = self.work.at(Vector::<L>::splat(self.position));
        let mut places = [Vec4::ZERO; LANES];
        L::put_run(&mut places, 0, found.with(L::zero()));
        places[0].truncate()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_random::Random;

    impl VectorField for CurlNoise {
        #[inline(always)]
        fn at<L: Lanes>(&self, position: Vector<L>) -> Vector<L> {
            CurlNoise::at(self, position)
        }
    }

    struct Wave;

    impl VectorField for Wave {
        #[inline(always)]
        fn at<L: Lanes>(&self, Vector { x, y, z }: Vector<L>) -> Vector<L> {
            Vector { x: arch(x), y, z }
        }
    }

    fn arch_of(turn: f32) -> f32 {
        at_one_place(Vec3::X * turn, Wave).x
    }

    /// Positions over a few hundred metres, and times over an hour.
    fn places(n: u32) -> impl Iterator<Item = (Vec3, f64)> {
        let mut random = Random::new(5);
        (0..n).map(move |_| (random.vector() * 200.0, f64::from(random.fraction()) * 3600.0))
    }

    fn noise(time: f64) -> CurlNoise {
        CurlNoise::new(2.0, 3.0, 1.5, Vec3::new(4.0, 0.0, 1.0), time)
    }

    #[test]
    fn curl_noise_has_no_divergence() {
        // The parabolas are exactly quadratic between their joints, so central differences have only round-off, except for the few that straddle a joint.
        let h = 0.01;
        let (mut divergence, mut gradient) = (0.0_f64, 0.0_f64);
        for (p, t) in places(2000) {
            let noise = noise(t);
            let slope = |e: Vec3| {
                (at_one_place(p + e * h, noise) - at_one_place(p - e * h, noise)) / (2.0 * h)
            };
            let (x, y, z) = (slope(Vec3::X), slope(Vec3::Y), slope(Vec3::Z));
            divergence += f64::from(x.x + y.y + z.z).abs();
            gradient += f64::from(x.length() + y.length() + z.length());
        }
        assert!(divergence < 2e-3 * gradient, "{divergence} of {gradient}");
    }

    #[test]
    fn curl_noise_varies_around_zero_by_its_strength_and_never_beyond_seven_times_it() {
        let n = 40_000;
        let (mut sum, mut squares, mut most) = (Vec3::ZERO, Vec3::ZERO, 0.0_f32);
        for (p, t) in places(n) {
            let v = at_one_place(p, noise(t));
            sum += v;
            squares += v * v;
            most = most.max(v.length());
        }
        let (mean, variance) = (sum / n as f32, squares / n as f32);
        assert!(mean.length() < 0.05, "{mean}");
        let deviation = variance.to_array().map(f32::sqrt);
        assert!(deviation.iter().all(|s| (s / 2.0 - 1.0).abs() < 0.15), "{deviation:?}");
        assert!(most > 4.0 && most < 2.0 * 4.0 * (LARGE + SMALL), "{most}");
    }

    #[test]
    fn eddies_are_carried_along_by_the_wind_and_change_on_the_way() {
        // With a period so long that the eddies hardly change, the present velocity here appears downwind later.
        let wind = Vec3::new(4.0, 0.0, 1.0);
        let (dt, p) = (2.0, Vec3::new(0.3, 1.0, -0.7));
        let frozen = |t| CurlNoise::new(1.0, 3.0, 1e6, wind, t);
        let carried = at_one_place(p + wind * dt as f32, frozen(10.0 + dt));
        assert!(carried.abs_diff_eq(at_one_place(p, frozen(10.0)), 1e-4));
        assert!(
            !at_one_place(p + wind * dt as f32, noise(10.0 + dt))
                .abs_diff_eq(at_one_place(p, noise(10.0)), 0.1)
        );
    }

    #[test]
    fn gusts_are_as_smooth_after_a_year_as_in_the_first_second() {
        let year = 3.2e7;
        for i in 0..1000 {
            let t = year + f64::from(i) * 0.001;
            let change =
                at_one_place(Vec3::ONE, noise(t + 0.001)) - at_one_place(Vec3::ONE, noise(t));
            // A wave has slope 4, strength 2 and at most 5 cycles a second; there are eight of them.
            assert!(change.length() < 0.3, "{change}");
        }
        assert!(at_one_place(Vec3::ONE, noise(f64::MAX)).length() < 14.0);
    }

    #[test]
    fn a_wave_of_parabolas_is_close_to_a_sine_and_repeats() {
        for i in -4000..4000 {
            let turn = i as f32 * 0.00731;
            let sine = libm::sinf(turn * core::f32::consts::TAU);
            assert!((arch_of(turn) - sine).abs() < 0.06, "{turn}");
        }
        for far in [5e6, 1e9, 3e9, 1e30, f32::MAX] {
            assert!(arch_of(far).abs() <= 1.0 && arch_of(-far).abs() <= 1.0, "{far}");
        }
    }
}
