//! Angles in lanes, from operations that are exact on every machine: `+ - × ÷`, comparisons and selections.

use super::Lanes;

/// tan(π/8): the polynomial holds up to here; above, the angle is measured from 45°.
const EIGHTH: f32 = 0.414_213_56;

/// `atan t = t + t z (P₀ + P₁ z + P₂ z² + P₃ z³)`, `z = t²`, for `|t| ≤ tan(π/8)`, with a relative error of 2.1e-8 before rounding.
///
/// Fitted for this file: Remez exchange on the relative error of the whole expression, five extrema of alternating sign in `z`, in f64, then rounded to f32.
const P: [f32; 4] = [-0.333_329_5, 0.199_777_1, -0.138_776_8, 0.080_537_23];

/// π/4 cut off after ten bits, so that four times it is exact, and the remainder.
const QUARTER: f32 = 0.785_156_25;
const REST: f32 = 2.419_134e-4;

/// The angle of `(x, y)` from the x axis, radians, -π to π: `atan2` with an absolute error of at most 2e-7 rad, and the same relative error for small angles.
///
/// The smaller of `‖x‖` and `‖y‖` over the larger is at most 1, an angle up to 45°. Above 22.5° it is measured from 45° by `tan(a - 45°) = (t - 1)/(t + 1)`, as
/// the single division `(less - more)/(less + more)`. Then the angle is mirrored at 45°, at the y axis and at the x axis, according to sizes and signs. Until
/// the end it is kept as a small angle and a multiple of 45°, so that only one sum is rounded. The angle of the origin is 0. The sign of `y = -0` is ignored:
/// the angle on the negative x axis is +π.
#[inline(always)]
pub(crate) fn atan2<L: Lanes>(y: L, x: L) -> L {
    let (x_size, y_size) = (x.abs(), y.abs());
    let steep = x_size.lt(y_size);
    let less = steep.select(x_size, y_size);
    let more = steep.select(y_size, x_size);
    let far = (more * L::splat(EIGHTH)).lt(less);
    let t = far.select(less - more, less) / far.select(less + more, more);
    let z = t * t;
    let [p0, p1, p2, p3] = P;
    let series = ((L::splat(p3) * z + L::splat(p2)) * z + L::splat(p1)) * z + L::splat(p0);
    let mut small = more.same(L::zero()).select(L::zero(), t + t * (z * series));
    let mut count = far.and(L::splat(1.0));
    small = steep.select(-small, small);
    count = steep.select(L::splat(2.0) - count, count);
    let behind = x.lt(L::zero());
    small = behind.select(-small, small);
    count = behind.select(L::splat(4.0) - count, count);
    let angle = count * L::splat(QUARTER) + (count * L::splat(REST) + small);
    y.lt(L::zero()).select(-angle, angle)
}

#[cfg(test)]
mod tests {
    use core::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI};

    use super::super::{InstructionSet, LANES, Work, with};
    use super::*;

    struct Angles {
        y: [f32; LANES],
        x: [f32; LANES],
    }

    impl Work for Angles {
        type Output = [f32; LANES];

        #[inline(always)]
        fn run<L: Lanes>(self) -> [f32; LANES] {
            atan2(L::load(&self.y), L::load(&self.x)).array()
        }
    }

    fn of(set: InstructionSet, y: [f32; LANES], x: [f32; LANES]) -> [f32; LANES] {
        with(set, Angles { y, x })
    }

    #[test]
    fn it_agrees_with_libm_all_the_way_round_and_with_itself_on_every_machine() {
        let (mut worst, mut relative) = (0.0_f64, 0.0_f64);
        let turns = 200_000;
        for i in (0..turns).step_by(LANES) {
            let angle = |k: usize| {
                f64::from((i + k) as u32) / f64::from(turns as u32) * core::f64::consts::TAU
            };
            let size = 10.0_f64.powi((i % 25) as i32 - 12);
            let y: [f32; LANES] = core::array::from_fn(|k| (libm::sin(angle(k)) * size) as f32);
            let x: [f32; LANES] = core::array::from_fn(|k| (libm::cos(angle(k)) * size) as f32);
            let found = of(InstructionSet::Scalar, y, x);
            for set in [InstructionSet::Simd128, InstructionSet::Avx2] {
                assert_eq!(of(set, y, x).map(f32::to_bits), found.map(f32::to_bits), "{set:?}");
            }
            for k in 0..LANES {
                let truth = libm::atan2(f64::from(y[k]), f64::from(x[k]));
                let off = (f64::from(found[k]) - truth).abs();
                worst = worst.max(off);
                relative = relative.max(off / truth.abs().max(1e-30));
            }
        }
        println!("off by {worst:.2e} rad, {relative:.2e} of the angle");
        assert!(worst < 2e-7 && relative < 2e-7, "{worst} {relative}");
    }

    #[test]
    fn small_angles_have_all_their_digits_and_the_axes_are_exact() {
        for small in [1e-30_f32, 1e-12, 1e-7, 1e-3, 0.1, 0.4142, 0.4143] {
            let found = of(InstructionSet::best(), [small; LANES], [1.0; LANES])[0];
            let truth = libm::atanf(small);
            assert!((found - truth).abs() <= 2e-7 * truth, "{small}: {found} {truth}");
        }
        let y = [0.0, 0.0, 1.0, -1.0, 0.0, 2.0, -2.0, -0.0];
        let x = [0.0, 1.0, 0.0, 0.0, -1.0, 2.0, 2.0, 1.0];
        let expected = [0.0, 0.0, FRAC_PI_2, -FRAC_PI_2, PI, FRAC_PI_4, -FRAC_PI_4, 0.0];
        assert_eq!(of(InstructionSet::best(), y, x), expected);
    }

    #[test]
    fn what_is_not_a_number_has_no_angle_and_what_is_infinite_is_not_taken_for_one() {
        let y = [f32::NAN, 1.0, f32::INFINITY, 1.0, 0.0, f32::NEG_INFINITY, f32::NAN, f32::MAX];
        let x = [1.0, f32::NAN, f32::INFINITY, 1e-45, 1e-45, 1.0, f32::NAN, f32::MIN_POSITIVE];
        let found = of(InstructionSet::best(), y, x);
        assert!(found[0].is_nan() && found[1].is_nan() && found[6].is_nan());
        assert!(found[3] == FRAC_PI_2 && found[4] == 0.0 && found[7] == FRAC_PI_2, "{found:?}");
    }
}
