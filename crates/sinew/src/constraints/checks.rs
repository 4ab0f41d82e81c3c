//! Checks that every constraint's tests share: they catch a wrong sign, lost momentum, or a NaN in a degenerate case.

use glam::{Vec3, Vec4};

use super::correction::GradientAt;
use super::equation::{Equation, Points, error as equation_error, project as project_equation};
use super::softness::SubstepContext;
pub(crate) use crate::test_random::Random;

/// A substep of 1/60 s with eight sweeps.
const CONTEXT: SubstepContext = SubstepContext { h: 1.0 / 60.0, sweeps: 8 };

/// The particles of a constraint under test: current positions and inverse masses, and positions at the start of the substep.
#[derive(Clone, Debug)]
pub(crate) struct Particles {
    pub(crate) now: Vec<Vec4>,
    pub(crate) starts: Vec<Vec4>,
    lambda: f32,
}

/// Particles at rest at these positions. Masses in kg; a missing mass is 1 kg, and an infinite one pins the particle.
pub(crate) fn points_of(positions: &[Vec3], masses: &[f32]) -> Particles {
    let inverse = |i: usize| masses.get(i).map_or(1.0, |mass| 1.0 / mass);
    let now: Vec<_> = positions.iter().enumerate().map(|(i, p)| p.extend(inverse(i))).collect();
    Particles { starts: now.clone(), now, lambda: 0.0 }
}

impl Particles {
    pub(crate) fn points(&self) -> Points<'_> {
        Points {
            now: &self.now,
            starts: &self.starts,
            origin: Vec3::ZERO,
            gradient_at: GradientAt::Current,
        }
    }

    pub(crate) fn positions(&self) -> Vec<Vec3> {
        self.now.iter().map(|q| q.truncate()).collect()
    }

    /// Applies one projection, as the solver does, and returns the constraint's error before it, metres.
    pub(crate) fn project(&mut self, equation: &dyn Equation) -> f32 {
        let mut gradients = vec![Vec3::ZERO; self.now.len()];
        let mut moves = Vec::new();
        let mut lambda = self.lambda;
        let error = project_equation(
            equation,
            &self.points(),
            &mut gradients,
            CONTEXT,
            &mut lambda,
            |i, d| {
                moves.push((i, d));
            },
        );
        self.lambda = lambda;
        for (i, d) in moves {
            self.now[i] += d.extend(0.0);
        }
        error
    }

    /// Error of a hard constraint, metres.
    pub(crate) fn error(&self, equation: &dyn Equation) -> f32 {
        equation_error(equation, &self.points(), &mut vec![Vec3::ZERO; self.now.len()])
    }

    /// `Σ mᵢ‖pᵢ - qᵢ‖²` over the free particles, in f64: the cost that a constraint minimises.
    pub(crate) fn cost(&self, from: &[Vec3]) -> f64 {
        let of = |(q, p): (&Vec4, &Vec3)| {
            (q.truncate() - p).as_dvec3().length_squared() / f64::from(q.w)
        };
        self.now.iter().zip(from).filter(|(q, _)| q.w > 0.0).map(of).sum()
    }
}

/// Value and gradients of a constraint at these positions, with all masses 1 kg.
pub(crate) fn evaluate(equation: &dyn Equation, positions: &[Vec3]) -> (f32, Vec<Vec3>) {
    let mut gradients = vec![Vec3::ZERO; positions.len()];
    let value = equation.evaluate(&points_of(positions, &[]).points(), &mut gradients);
    (value, gradients)
}

/// Asserts that every gradient agrees with central differences of the value, to 2e-3 of the largest gradient.
///
/// The differences are of f32 values, whose round-off (about 1e-7 of the value) is divided by the step. So the step is large, 2 % of the extent, and Richardson
/// extrapolation with half of it removes the quadratic error. What remains is about 1e-5 each. The value must be smooth over that distance. Inside the range of
/// a limit there is nothing to check, and the assertion fails.
#[track_caller]
pub(crate) fn assert_gradients(equation: &dyn Equation, positions: &[Vec3]) {
    let (value, gradients) = evaluate(equation, positions);
    assert!(value.is_finite() && value != 0.0, "nothing to check: the value is {value}");
    let largest = gradients.iter().map(|g| g.length()).fold(0.0, f32::max);
    assert!(largest > 0.0, "no gradient, but a value of {value}");
    // A single particle has no extent; 1 m is used.
    let step = 0.02 * Some(extent(positions)).filter(|&extent| extent > 0.0).unwrap_or(1.0);
    for i in 0..positions.len() {
        for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
            let at = |distance: f32| {
                let mut moved = positions.to_vec();
                moved[i] += axis * distance;
                f64::from(evaluate(equation, &moved).0)
            };
            let slope = |h: f32| (at(h) - at(-h)) / (2.0 * f64::from(h));
            let measured = ((4.0 * slope(0.5 * step) - slope(step)) / 3.0) as f32;
            let claimed = gradients[i].dot(axis);
            assert!(
                (claimed - measured).abs() <= 2e-3 * largest,
                "particle {i} along {axis}: the gradient is {claimed}, the value changes by {measured}"
            );
        }
    }
}

/// Asserts that one projection keeps momentum and angular momentum: `Σ mᵢdᵢ` and `Σ mᵢ qᵢ×dᵢ` vanish to 2e-5 of the sum of their magnitudes. Masses must be
/// finite.
#[track_caller]
pub(crate) fn assert_momentum_kept(equation: &dyn Equation, positions: &[Vec3], masses: &[f32]) {
    let particles = points_of(positions, masses);
    let mut gradients = vec![Vec3::ZERO; positions.len()];
    let mut moves = vec![Vec3::ZERO; positions.len()];
    let points = particles.points();
    project_equation(equation, &points, &mut gradients, CONTEXT, &mut 0.0, |i, d| moves[i] = d);
    assert!(moves.iter().any(|d| *d != Vec3::ZERO), "nothing to check: nothing moved");
    let (mut linear, mut angular, mut size) = (Vec3::ZERO.as_dvec3(), Vec3::ZERO.as_dvec3(), 0.0);
    let middle = positions.iter().sum::<Vec3>() / positions.len() as f32;
    for (i, d) in moves.iter().enumerate() {
        let push = d.as_dvec3() / f64::from(particles.now[i].w);
        linear += push;
        angular += (positions[i] - middle).as_dvec3().cross(push);
        size += push.length();
    }
    let arm = f64::from(extent(positions));
    assert!(linear.length() <= 2e-5 * size, "momentum {linear} of {size}");
    assert!(angular.length() <= 2e-5 * size * arm, "angular momentum {angular} of {}", size * arm);
    assert!(equation.is_internal(), "it keeps momenta: say so, and the solver does, too");
}

/// Asserts that a hundred projections bring a hard constraint to within `tolerance` metres, from a larger error.
#[track_caller]
pub(crate) fn assert_kept(
    equation: &dyn Equation,
    positions: &[Vec3],
    masses: &[f32],
    tolerance: f32,
) {
    let mut particles = points_of(positions, masses);
    let before = particles.error(equation);
    assert!(before > tolerance, "nothing to check: it is off by {before}");
    for _ in 0..100 {
        particles.project(equation);
    }
    let after = particles.error(equation);
    let value = evaluate(equation, &particles.positions()).0;
    assert!(value.is_finite(), "off by {before} before, and now by {value}");
    assert!(after <= tolerance, "off by {before} before and by {after} after");
}

/// Asserts that the displacement is the least: it is along `w∇C` as measured by finite differences (see [`assert_gradients`]), and every feasible configuration
/// near the result has a greater cost `Σ m‖d‖²`. The violation must be small compared with the shape, 10 % say: Newton steps are the least only as far as the
/// constraint surface is flat.
#[track_caller]
pub(crate) fn assert_least(equation: &dyn Equation, positions: &[Vec3], masses: &[f32]) {
    assert_gradients(equation, positions);
    let mut best = points_of(positions, masses);
    let gradients = evaluate(equation, positions).1;
    best.project(equation);
    // Along w∇C, with one λ for all particles.
    let (mut along, mut squares) = (0.0, 0.0);
    for (i, gradient) in gradients.iter().enumerate() {
        let wanted = *gradient * best.now[i].w;
        along += wanted.dot(best.now[i].truncate() - positions[i]);
        squares += wanted.length_squared();
    }
    let lambda = along / squares;
    for (i, gradient) in gradients.iter().enumerate() {
        let (moved, wanted) = (best.now[i].truncate() - positions[i], *gradient * best.now[i].w);
        let off = (moved - wanted * lambda).length();
        assert!(off <= 1e-4 * lambda.abs() * squares.sqrt(), "particle {i} moved by {moved}");
    }
    for _ in 0..20 {
        best.project(equation);
    }
    let least = best.cost(positions);
    assert!(least > 0.0, "nothing to check: nothing moved");
    let mut random = Random::new(7);
    let reach = (least as f32).sqrt() / best.now.len() as f32;
    for attempt in 0..40 {
        let mut other = best.clone();
        for q in other.now.iter_mut().filter(|q| q.w > 0.0) {
            *q += (random.vector() * reach * q.w.sqrt()).extend(0.0);
        }
        for _ in 0..20 {
            other.project(equation);
        }
        let cost = other.cost(positions);
        assert!(cost >= least * (1.0 - 1e-3), "attempt {attempt} costs {cost}, not {least}");
    }
}

/// Asserts that projection leaves finite positions for degenerate input: coincident, collinear, coplanar, mirrored, huge and tiny shapes, or two particles in
/// one place; with all particles free, one pinned, or all pinned; and with very different masses.
#[track_caller]
pub(crate) fn assert_survives(equation: &dyn Equation, positions: &[Vec3]) {
    let count = positions.len();
    let alike = |f: &dyn Fn(Vec3) -> Vec3| positions.iter().map(|p| f(*p)).collect::<Vec<_>>();
    let mut sets = vec![
        ("as given", positions.to_vec()),
        ("coincident at the origin", vec![Vec3::ZERO; count]),
        ("coincident elsewhere", vec![Vec3::new(3.0, -7.0, 0.1); count]),
        ("collinear along x", alike(&|p| Vec3::X * p.x)),
        ("collinear aslant", alike(&|p| Vec3::new(1.0, 2.0, -0.5) * p.x)),
        ("evenly collinear", (0..count).map(|i| Vec3::Y * i as f32).collect()),
        ("coplanar", alike(&|p| Vec3::new(p.x, p.y, 0.0))),
        ("mirrored", alike(&|p| Vec3::new(-p.x, p.y, p.z))),
    ];
    // Squares overflow from 2e19 m on and underflow below 1e-19 m; at scales in between, values that are higher powers of a length do.
    for (name, scale) in [
        ("1e-30", 1e-30),
        ("1e-18", 1e-18),
        ("1e-15", 1e-15),
        ("1e-12", 1e-12),
        ("1e-9", 1e-9),
        ("1e-6", 1e-6),
        ("1e6", 1e6),
        ("1e9", 1e9),
        ("1e12", 1e12),
        ("1e18", 1e18),
    ] {
        sets.push((name, alike(&|p| p * scale)));
    }
    for i in 0..count.min(6) {
        for j in 0..i {
            let mut set = positions.to_vec();
            set[i] = set[j];
            sets.push(("two in one place", set.clone()));
            set[i] += Vec3::splat(1e-20);
            sets.push(("two hardly apart", set));
        }
    }
    let one_pinned: Vec<f32> =
        (0..count).map(|i| if i == 0 { f32::INFINITY } else { 1.0 }).collect();
    let apart: Vec<f32> = (0..count).map(|i| if i % 2 == 0 { 1e-6 } else { 1e6 }).collect();
    for masses in [vec![1.0; count], one_pinned, vec![f32::INFINITY; count], apart] {
        for (name, set) in &sets {
            let mut particles = points_of(set, &masses);
            for sweep in 0..8 {
                let error = particles.project(equation);
                let finite = particles.now.iter().all(|q| q.is_finite()) && error.is_finite();
                assert!(finite, "{name}, masses {masses:?}, sweep {sweep}: {:?}", particles.now);
            }
            let energy =
                super::equation_energy(equation, &particles.points(), &mut vec![Vec3::ZERO; count]);
            assert!(!energy.is_nan(), "{name}");
            for (q, p) in particles.now.iter().zip(set).filter(|(q, _)| q.w == 0.0) {
                assert_eq!(q.truncate(), *p, "{name}: a pinned particle moved");
            }
        }
    }
}

/// An equation that is never satisfied and whose corrections are too small for f32. With a tolerance of 0, an island that holds it is swept the maximum number
/// of times. (A soft constraint has no error of its own that would ask for sweeps.)
#[derive(Debug)]
pub(crate) struct Restless;

impl Equation for Restless {
    fn evaluate(&self, _: &Points, gradients: &mut [Vec3]) -> f32 {
        gradients[0] = Vec3::X;
        1e-15
    }
}

/// The largest distance from the mean of the positions, metres.
pub(crate) fn extent(positions: &[Vec3]) -> f32 {
    let middle = positions.iter().sum::<Vec3>() / positions.len() as f32;
    positions.iter().map(|p| p.distance(middle)).fold(0.0, f32::max)
}

/// An octahedron whose triangles are subdivided into four `cuts` times and projected onto the unit sphere; outward winding.
pub(crate) fn sphere(cuts: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let mut places = vec![Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z];
    let mut triangles = vec![
        [0, 1, 2],
        [1, 3, 2],
        [3, 4, 2],
        [4, 0, 2],
        [1, 0, 5],
        [3, 1, 5],
        [4, 3, 5],
        [0, 4, 5],
    ];
    for _ in 0..cuts {
        let mut edges: Vec<[u32; 2]> = Vec::new();
        let mut finer = Vec::new();
        for [a, b, c] in triangles {
            let mut middle = |i: u32, j: u32| {
                let edge = [i.min(j), i.max(j)];
                let known = edges.iter().position(|e| *e == edge);
                let number = known.unwrap_or_else(|| {
                    edges.push(edge);
                    places.push((places[i as usize] + places[j as usize]).normalize());
                    edges.len() - 1
                });
                (places.len() - edges.len() + number) as u32
            };
            let (d, e, f) = (middle(a, b), middle(b, c), middle(c, a));
            finer.extend([[a, d, f], [d, b, e], [f, e, c], [d, e, f]]);
        }
        triangles = finer;
    }
    (places, triangles)
}

/// Tests that the checks themselves can fail.
mod tests {
    use super::*;

    /// A rod of length 1 between two particles, with optional faults: `sign` scales both gradients, `first` the first one.
    #[derive(Debug)]
    struct Rod {
        sign: f32,
        first: f32,
    }

    impl Equation for Rod {
        fn evaluate(&self, points: &Points, gradients: &mut [Vec3]) -> f32 {
            let d = points.at(0) - points.at(1);
            let n = d.normalize_or(Vec3::X);
            gradients[0] = n * (self.sign * self.first);
            gradients[1] = -n * self.sign;
            d.length() - 1.0
        }

        fn is_internal(&self) -> bool {
            true
        }
    }

    /// Keeps a particle on a sphere about the origin; it ties the particle to the world, so it does not keep momentum.
    #[derive(Debug)]
    struct OnBall(f32);

    impl Equation for OnBall {
        fn evaluate(&self, points: &Points, gradients: &mut [Vec3]) -> f32 {
            gradients[0] = points.relative_to(0, Vec3::ZERO).normalize_or(Vec3::X);
            points.relative_to(0, Vec3::ZERO).length() - self.0
        }
    }

    const PLACES: [Vec3; 2] = [Vec3::ZERO, Vec3::new(0.3, 0.9, 0.5)];

    #[test]
    fn a_correct_equation_passes_every_check() {
        let rod = Rod { sign: 1.0, first: 1.0 };
        assert_gradients(&rod, &PLACES);
        assert_gradients(&OnBall(2.0), &PLACES[1..]);
        assert_momentum_kept(&rod, &PLACES, &[1.0, 3.0]);
        assert_kept(&rod, &PLACES, &[1.0, 3.0], 1e-6);
        assert_least(&rod, &PLACES, &[1.0, 3.0]);
        assert_survives(&rod, &PLACES);
    }

    #[test]
    #[should_panic(expected = "the gradient is")]
    fn a_wrong_sign_is_found() {
        assert_gradients(&Rod { sign: -1.0, first: 1.0 }, &PLACES);
    }

    #[test]
    #[should_panic(expected = "momentum")]
    fn a_lopsided_push_is_found() {
        assert_momentum_kept(&Rod { sign: 1.0, first: 1.01 }, &PLACES, &[]);
    }

    #[test]
    #[should_panic(expected = "off by")]
    fn what_runs_away_is_found() {
        assert_kept(&Rod { sign: -1.0, first: 1.0 }, &PLACES, &[], 1e-3);
    }
}
