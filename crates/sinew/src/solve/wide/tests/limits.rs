//! The early-out for limits, which needs no angle: never taken where a correction is needed, and nearly always where none is.

use super::*;
use crate::constraints::checks::evaluate;
use crate::constraints::{Cones, Equation, FromKind, Hinges, Wide};
use crate::lanes::{LANES, Lanes, Vector, Work, with};

/// Whether `is_kept` of a wide constraint is true in all lanes.
struct EarlyOut<'a, W, const N: usize>(&'a W, &'a [Vec3; N]);

impl<W: Wide<N>, const N: usize> Work for EarlyOut<'_, W, N> {
    type Output = bool;

    #[inline(always)]
    fn run<L: Lanes>(self) -> bool {
        let mut points = [Vector::<L>::splat(Vec3::ZERO); N];
        for (point, place) in points.iter_mut().zip(self.1) {
            *point = Vector::splat(*place);
        }
        self.0.is_kept(&points).all()
    }
}

/// Whether a limit passes the early-out, and whether it is satisfied according to the scalar equation.
fn early_out<W: Wide<N, Kind: FromKind>, const N: usize>(
    constraint: &Constraint,
    places: &[Vec3; N],
) -> (bool, bool) {
    let kind = W::Kind::from_kind(&constraint.kind).unwrap();
    let wide = W::of([kind; LANES], [constraint.rows.len(); LANES]);
    let equation: &dyn Equation = match &constraint.kind {
        ConstraintKind::Cone(kind) => kind,
        ConstraintKind::Hinge(kind) => kind,
        _ => unreachable!("a limit"),
    };
    (with(InstructionSet::best(), EarlyOut(&wide, places)), evaluate(equation, places).0 == 0.0)
}

#[test]
fn the_early_out_of_limits_is_never_wrong_and_seldom_missed() {
    let mut random = Random::new(5);
    let (mut kept, mut early) = ([0, 0], [0, 0]);
    for k in 0..20_000 {
        // Some are far too small or too large to be squared, some nearly flat.
        let size = [1.0, 1.0, 1.0, 1e-3, 1e-13, 1e11][k % 6];
        let flat = if k % 5 == 0 { 1e-4 } else { 1.0 };
        let places: [Vec3; 5] = core::array::from_fn(|_| {
            let v = random.vector() * size;
            Vec3::new(v.x, v.y, v.z * flat)
        });
        let (wide, low) = (3.1 * random.number().abs(), 3.0 * random.number());
        let rows = |n: u32| (0..n).collect();
        let cone = Cone { axis: random.vector(), max: wide, softness: Softness::Hard };
        let cone = Constraint { rows: rows(5), kind: ConstraintKind::Cone(cone) };
        let hinge = Hinge::between(low, low + wide);
        let hinge = Constraint { rows: rows(4), kind: ConstraintKind::Hinge(hinge) };
        let [a, b, c, d, _] = places;
        let each =
            [early_out::<Cones, 5>(&cone, &places), early_out::<Hinges, 4>(&hinge, &[a, b, c, d])];
        for (which, (is_early, is_kept)) in each.into_iter().enumerate() {
            assert!(is_kept || !is_early, "{which} at {places:?}, {cone:?} {hinge:?}");
            let counts = size == 1.0 && flat == 1.0;
            kept[which] += u32::from(counts && is_kept);
            early[which] += u32::from(counts && is_early);
        }
    }
    for which in 0..2 {
        assert!(kept[which] > 1500 && early[which] > kept[which] * 99 / 100, "{kept:?} {early:?}");
    }
}
