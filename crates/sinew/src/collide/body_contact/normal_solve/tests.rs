//! Missing points do not affect the others, and what has been solved stays.

use super::super::turn::Symmetric;
use super::{ContactPatch, PatchSide, solve_normal_impulses};
use crate::constraints::checks::Random;
use crate::lanes::{InstructionSet, LANES, Lanes, Vector, Work, with};

/// Random numbers between two.
fn between<L: Lanes>(random: &mut Random, low: f32, high: f32) -> L {
    let half = 0.5 * (high - low);
    L::load(&core::array::from_fn(|_| low + half * (1.0 + random.number())))
}

fn stored<L: Lanes>(numbers: L) -> [f32; LANES] {
    let mut to = [0.0; LANES];
    numbers.store(&mut to);
    to
}

/// Solves two points, alone and beside two missing ones, and compares the bits.
struct Both<'a>(&'a mut Random);

impl Work for Both<'_> {
    /// The two results.
    type Output = ([[f32; LANES]; 2], [[f32; LANES]; 4]);

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let Self(random) = self;
        let mut some = |low, high| between::<L>(random, low, high);
        let (none, one) = (L::zero(), L::splat(1.0));
        let (t, u) = (Vector::new(one, none, none), Vector::new(none, one, none));
        let mut side = || {
            let along = Vector::new(some(1.0, 9.0), some(1.0, 9.0), some(1.0, 9.0));
            let across = Vector::new(some(-0.9, 0.9), some(-0.9, 0.9), some(-0.9, 0.9));
            PatchSide::of(&Symmetric { along, across }, t, u)
        };
        let (a, b) = (side(), side());
        let apart = (some(-1.0, 1.0), none);
        let patch =
            ContactPatch { weight: some(0.1, 3.0), a, b: Some(b), apart, regularisation: none };
        let c = [some(-1e-4, 1e-3), some(-1e-3, 1e-3)];
        let at = [(some(-1.0, 1.0), some(-1.0, 1.0)), (some(-1.0, 1.0), some(-1.0, 1.0))];
        let far = L::splat(-1e9);
        let missing_at = (some(-1.0, 1.0), some(-1.0, 1.0));
        let two = solve_normal_impulses(&patch, &c, &at, None);
        let four = solve_normal_impulses(
            &patch,
            &[c[0], c[1], far, far],
            &[at[0], at[1], missing_at, missing_at],
            None,
        );
        (two.map(stored), four.map(stored))
    }
}

#[test]
fn missing_points_do_not_change_the_impulses_of_others() {
    let mut random = Random::new(7);
    let mut pressed = [0; 3];
    for _ in 0..600 {
        let (two, four) = with(InstructionSet::Scalar, Both(&mut random));
        for (i, far) in four.iter().enumerate() {
            let wanted = two.get(i).map_or([0; LANES], |force| force.map(f32::to_bits));
            assert_eq!(far.map(f32::to_bits), wanted, "point {i}");
        }
        for lane in 0..LANES {
            pressed[two.iter().filter(|force| force[lane] > 0.0).count()] += 1;
        }
    }
    assert!(pressed.iter().all(|&times| times > 200), "{pressed:?}: of each kind some");
}

/// Solves two points `distance` metres from each other, which are as good as one.
struct AsOne<'a> {
    random: &'a mut Random,
    distance: f32,
}

impl Work for AsOne<'_> {
    /// The largest impulse, as a multiple of what one point alone needs.
    type Output = f32;

    #[inline(always)]
    fn run<L: Lanes>(self) -> f32 {
        let Self { random, distance } = self;
        let (none, one) = (L::zero(), L::splat(1.0));
        let (t, u) = (Vector::new(one, none, none), Vector::new(none, one, none));
        let round = Symmetric {
            along: Vector::new(one, one, one) * L::splat(1.6),
            across: Vector::new(none, none, none),
        };
        let side = || PatchSide::of(&round, t, u);
        let (weight, apart, regularisation) = (L::splat(0.4), (none, none), none);
        let patch = ContactPatch { weight, a: side(), b: Some(side()), apart, regularisation };
        let near = |x: f32, random: &mut Random| {
            L::load(&core::array::from_fn(|_| x + distance * random.number()))
        };
        let [x, y] = [0.0, 0.0].map(|_: f32| 0.4 * random.number());
        let mut at = || (near(x, random), near(y, random));
        let at = [at(), at()];
        let force = solve_normal_impulses(&patch, &[one, one], &at, None);
        let mut worst = 0.0_f32;
        for force in force {
            worst = stored(force).iter().fold(worst, |worst, force| worst.max(*force));
        }
        worst * 0.4
    }
}

/// A manifold had the same corner twice. The middle of the two, rounded, was as far from them as they were from each other, and the resulting tilt threw
/// boxes out of a heap at a kilometre a second.
#[test]
fn nearly_coincident_points_press_as_one() {
    let mut random = Random::new(3);
    for distance in [0.0, 1e-9, 1e-8, 3e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3] {
        for _ in 0..500 {
            let random = &mut random;
            let worst = with(InstructionSet::Scalar, AsOne { random, distance });
            assert!(worst < 1.01, "{distance} m from each other: {worst}");
        }
    }
}

/// Impulses of up to four points without any depth left, on a body that is pinned near the first two of them.
struct Kept<'a>(&'a mut Random);

impl Work for Kept<'_> {
    /// The impulses before and after.
    type Output = ([[f32; LANES]; 4], [[f32; LANES]; 4]);

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let Self(random) = self;
        let mut some = |low, high| between::<L>(random, low, high);
        let (none, one) = (L::zero(), L::splat(1.0));
        let (t, u) = (Vector::new(one, none, none), Vector::new(none, one, none));
        let along = Vector::new(one, some(1.0, 3.0), one);
        let a = PatchSide::of(&Symmetric { along, across: Vector::new(none, none, none) }, t, u);
        let apart = (none, none);
        let mut patch = ContactPatch { weight: none, a, b: None, apart, regularisation: none };
        let near = (some(-0.02, 0.02), some(-0.02, 0.02));
        let at = [near, (-near.0, none - near.1 * some(0.9, 1.1)), (near.0, near.1 + one), near];
        patch.regularisation = L::splat(1e-3) * some(0.0, 1.0);
        let far = L::splat(-1e9);
        let had = [some(1.0, 100.0), some(1.0, 100.0), some(0.0, 1.0), none];
        let after = solve_normal_impulses(&patch, &[none, none, none, far], &at, Some(&had));
        (had.map(stored), after.map(stored))
    }
}

/// Points on both sides of a pin may press with large impulses that cancel each other. Solved anew for their sums instead of for the change, they were smaller by
/// the regularisation, and the difference turned the body.
#[test]
fn impulses_stay_where_no_depth_is_left() {
    let mut random = Random::new(11);
    for _ in 0..500 {
        let (had, after) = with(InstructionSet::Scalar, Kept(&mut random));
        assert_eq!(had, after);
    }
}
