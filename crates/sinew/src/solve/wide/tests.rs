//! Each wide kernel against its scalar twin.

mod kept;
mod limits;
mod strided;

use glam::{Vec3, Vec4};

use super::super::constraint_ref::{Local, SolveMode, project_constraint, project_distance};
use super::{BatchRange, ConstraintBatches};
use crate::constraints::{
    Angle, Area, Bend, Bound, Cone, Constraint, ConstraintKind, Distance, GradientAt, Hinge,
    Softness, SubstepContext, Tetrahedron,
};
use crate::lanes::InstructionSet;
use crate::particles::Places;
use crate::test_random::Random;

const SETS: [InstructionSet; 3] = InstructionSet::ALL;
const CONTEXT: SubstepContext = SubstepContext { h: 1.0 / 120.0, sweeps: 6 };
const SOFT: [Softness; 7] = [
    Softness::Hard,
    Softness::Compliant { compliance: 1e-4, damping: 0.0 },
    Softness::Compliant { compliance: 3e-4, damping: 20.0 },
    Softness::Compliant { compliance: 0.0, damping: 0.0 },
    Softness::Frequency { hertz: 6.0, ratio: 0.7 },
    Softness::Frequency { hertz: 30.0, ratio: 0.0 },
    Softness::Share(0.4),
];

/// Particles and multipliers.
#[derive(Clone, Debug)]
struct State {
    now: Vec<Vec4>,
    start: Vec<Vec4>,
    multipliers: Vec<f32>,
}

impl State {
    /// Particles at `places` that have moved a little since the start of the substep, with various masses, some of them pinned.
    fn at(places: &[Vec3], constraints: usize, random: &mut Random) -> Self {
        let masses = random.masses(places.len());
        let inverse = |i: usize| if i % 7 == 3 { 0.0 } else { 1.0 / masses[i] };
        let now: Vec<_> = places.iter().enumerate().map(|(i, p)| p.extend(inverse(i))).collect();
        let start = now.iter().map(|q| *q + (random.vector() * 0.01).extend(0.0)).collect();
        Self { now, start, multipliers: vec![0.0; constraints] }
    }

    fn places(&mut self) -> Places<'_> {
        let Self { now, start, .. } = self;
        let (origin, radius) = (&[Vec3::ZERO; 512][..now.len()], &[0.0; 512][..now.len()]);
        Places { first: 0, position: now, start, origin, radius, velocity: &mut [] }
    }

    fn bits(&self) -> Vec<u32> {
        let places = self.now.iter().flat_map(Vec4::to_array);
        places.chain(self.multipliers.iter().copied()).map(f32::to_bits).collect()
    }

    /// One sweep of the scalar kernels. Returns the largest error.
    fn one_by_one(&mut self, group: &Group, substep_context: SubstepContext) -> f32 {
        let mut multipliers = self.multipliers.clone();
        let mode = SolveMode {
            substep_context,
            gradient_at: GradientAt::Current,
            project_tethers: true,
            relaxation: None,
            single_sweep: false,
            violation: f32::INFINITY,
            instructions: InstructionSet::best(),
        };
        let (places, mut local) = (&mut self.places(), Local::default());
        let each = multipliers.iter_mut().enumerate().map(|(i, sum)| match group {
            Group::Constraints(constraint_batches) => {
                project_constraint(places, &constraint_batches[i], mode, sum, &mut local)
            }
            Group::Distances(distances) => {
                project_distance(places, &distances[i], substep_context, sum)
            }
        });
        let worst = each.fold(0.0, f32::max);
        self.multipliers = multipliers;
        worst
    }

    /// One sweep of the wide kernels.
    fn wide(&mut self, set: InstructionSet, group: &Group, substep_context: SubstepContext) -> f32 {
        let (constraint_batches, which) = group.wide();
        let mut multipliers = self.multipliers.clone();
        let worst = constraint_batches.sweep(
            &mut self.places(),
            &which,
            &mut multipliers,
            substep_context,
            set,
        );
        self.multipliers = multipliers;
        worst
    }
}

/// Constraints of one colour.
#[derive(Clone, Debug)]
enum Group {
    Constraints(Vec<Constraint>),
    Distances(Vec<Distance>),
}

impl Group {
    fn wide(&self) -> (ConstraintBatches, BatchRange) {
        let mut constraint_batches = ConstraintBatches::default();
        let which = match self {
            Group::Constraints(constraints) => constraint_batches.add(constraints, false).unwrap(),
            Group::Distances(distances) => constraint_batches.add_distances(distances, false),
        };
        (constraint_batches, which)
    }
}

/// Asserts that scalar and wide sweeps from the same state agree to within `tolerance` of positions plus displacements, and of the multipliers; and that all
/// instruction sets agree to the bit.
#[track_caller]
fn assert_alike(name: &str, group: &Group, mut state: State, tolerance: f32) {
    for sweep in 0..4 {
        let before = state.clone();
        let (mut scalar, mut wide) = (before.clone(), before.clone());
        let truth = scalar.one_by_one(group, CONTEXT);
        let found = wide.wide(InstructionSet::Scalar, group, CONTEXT);
        for set in SETS {
            let mut other = before.clone();
            let error = other.wide(set, group, CONTEXT);
            assert_eq!(other.bits(), wide.bits(), "{name}: {set:?}");
            assert_eq!(error.to_bits(), found.to_bits(), "{name}: {set:?}");
        }
        for (i, (a, b)) in scalar.now.iter().zip(&wide.now).enumerate() {
            let way = (*a - before.now[i]).truncate().length();
            let most = tolerance * (a.truncate().length() + way) + 1e-37;
            let apart = (*a - *b).truncate().length();
            assert!(apart <= most && a.w == b.w, "{name}, {sweep}, particle {i}: {a} {b}");
        }
        for (i, (a, b)) in scalar.multipliers.iter().zip(&wide.multipliers).enumerate() {
            let most = 10.0 * tolerance * a.abs().max(before.multipliers[i].abs()) + 1e-7;
            assert!((a - b).abs() <= most, "{name}, {sweep}, sum {i}: {a} {b}");
        }
        let size = before.now.iter().map(|q| q.truncate().length()).fold(0.0, f32::max);
        let most = tolerance * (truth + size) + 1e-37;
        assert!((truth - found).abs() <= most, "{name}, {sweep}: error {truth}, found {found}");
        state = scalar;
    }
}

/// Rows of `count` constraints with `n` particles each: every row once, in scattered order.
fn rows(count: usize, n: usize) -> Vec<Vec<u32>> {
    // 11 is coprime to any number that it does not divide, so each row occurs once.
    let all = (count * n) as u32;
    assert!(!all.is_multiple_of(11));
    (0..count as u32)
        .map(|k| (0..n as u32).map(|i| ((k * n as u32 + i) * 11 + 2) % all).collect())
        .collect()
}

/// Twenty-one constraints: two full batches and a part of one.
fn constraint_batches(n: usize, kind: &dyn Fn(usize) -> ConstraintKind) -> Group {
    let rows = rows(21, n).into_iter().enumerate();
    Group::Constraints(rows.map(|(k, rows)| Constraint::new(rows, kind(k))).collect())
}

fn distances(of: &dyn Fn(usize) -> Distance) -> Group {
    let rows = rows(21, 2).into_iter().enumerate();
    Group::Distances(rows.map(|(k, rows)| Distance { a: rows[0], b: rows[1], ..of(k) }).collect())
}

const FOUR: [Vec3; 4] = [Vec3::ZERO, Vec3::X, Vec3::new(0.3, 0.8, 0.0), Vec3::new(0.6, -0.5, 0.2)];

fn bend(k: usize, softness: Softness) -> ConstraintKind {
    let mut places = FOUR;
    places[2].y += 0.01 * k as f32;
    places[3].z *= if k.is_multiple_of(3) { 0.0 } else { 1.0 };
    ConstraintKind::Bend(Bend::of(places).unwrap().with_softness(softness))
}

fn hinge(k: usize, softness: Softness) -> ConstraintKind {
    let middle = k as f32 * 0.6 - 6.0;
    let half = if k.is_multiple_of(2) { 0.0 } else { 0.2 };
    ConstraintKind::Hinge(
        Hinge::between((middle - half).max(-6.2), (middle + half).min(6.2)).with_softness(softness),
    )
}

fn area(k: usize, softness: Softness) -> ConstraintKind {
    ConstraintKind::Area(Area { rest: 0.05 * k as f32, softness })
}

fn tetrahedron(k: usize, softness: Softness) -> ConstraintKind {
    ConstraintKind::Tetrahedron(Tetrahedron { rest: 0.05 * (k as f32 - 7.0), softness })
}

fn angle(k: usize, softness: Softness) -> ConstraintKind {
    let min = k as f32 * 0.12;
    let max = if k.is_multiple_of(2) { min } else { min + 0.5 };
    ConstraintKind::Angle(Angle::between(min, max).with_softness(softness))
}

fn cone(k: usize, softness: Softness) -> ConstraintKind {
    let axis = Vec3::new(1.0, 0.3 * k as f32 - 3.0, 0.5);
    ConstraintKind::Cone(Cone { axis, max: 0.03 * (k % 12) as f32, softness })
}

/// Every kind with a wide kernel, its number of particles, and the tolerance against its scalar twin.
fn every() -> Vec<(&'static str, usize, fn(usize, Softness) -> ConstraintKind, f32)> {
    vec![
        ("bend", 4, bend, 2e-6),
        ("area", 3, area, 2e-6),
        ("tetrahedron", 4, tetrahedron, 2e-6),
        ("angle", 3, angle, 5e-6),
        ("hinge", 4, hinge, 5e-6),
        ("cone of four", 4, cone, 5e-6),
        ("cone of five", 5, cone, 5e-6),
    ]
}

#[test]
fn every_kind_matches_its_scalar_twin_at_any_softness() {
    for (name, n, kind, tolerance) in every() {
        let mut random = Random::new(71);
        for round in 0..6 {
            let places = random.positions(21 * n);
            for soft in SOFT {
                let group = constraint_batches(n, &|k| kind(k, soft));
                let state = State::at(&places, 21, &mut random);
                assert_alike(&format!("{name} {soft:?} {round}"), &group, state, tolerance);
            }
            let mixed = constraint_batches(n, &|k| kind(k, SOFT[k % SOFT.len()]));
            let state = State::at(&places, 21, &mut random);
            assert_alike(&format!("{name}, mixed, {round}"), &mixed, state, tolerance);
        }
    }
}

#[test]
fn every_distance_matches_its_scalar_twin_at_any_softness_and_bound() {
    let mut random = Random::new(72);
    let bounds = [Bound::Equal, Bound::AtMost, Bound::AtLeast];
    for round in 0..6 {
        let places = random.positions(42);
        for bound in bounds {
            for soft in SOFT {
                let one = |k: usize| Distance::new(0, 1, 0.1 * k as f32).with_softness(soft);
                let group = distances(&|k| one(k).with_bound(bound));
                let state = State::at(&places, 21, &mut random);
                assert_alike(&format!("{soft:?} {bound:?} {round}"), &group, state, 2e-6);
            }
        }
        let group = distances(&|k| {
            let one = Distance::new(0, 1, 0.1 * k as f32).with_softness(SOFT[k % 7]);
            one.with_bound(bounds[k % 3])
        });
        assert_alike("mixed", &group, State::at(&places, 21, &mut random), 2e-6);
    }
}

/// Three of twenty-one constraints are degenerate, two of them in one batch and one in the last lane that is used; the others are sound.
#[test]
fn degenerate_constraints_match_their_scalar_twins_and_spoil_no_neighbour() {
    let spoil: [(&str, fn(usize, Vec3) -> Vec3); 8] = [
        ("coincident", |_, _| Vec3::new(3.0, -7.0, 0.1)),
        ("at the origin", |_, _| Vec3::ZERO),
        ("collinear", |i, _| Vec3::Y * i as f32),
        ("flat", |_, p| Vec3::new(p.x, p.y, 0.0)),
        ("tiny", |_, p| p * 1e-9),
        ("huge", |_, p| p * 1e9),
        ("two in one place", |i, p| if i < 2 { Vec3::X } else { p }),
        ("the last two in one place", |i, p| if i > 1 { Vec3::X } else { p }),
    ];
    for (name, n, kind, tolerance) in every() {
        let mut random = Random::new(73);
        for (context, spoil) in spoil {
            for soft in SOFT {
                let group = constraint_batches(n, &|k| kind(k, soft));
                let Group::Constraints(constraints) = &group else { return };
                let mut places = random.positions(21 * n);
                for k in [0, 5, 20] {
                    for (i, &row) in constraints[k].rows.iter().enumerate() {
                        places[row as usize] = spoil(i, places[row as usize]);
                    }
                }
                let state = State::at(&places, 21, &mut random);
                let title = format!("{name}, {context}, {soft:?}");
                let mut wide = state.clone();
                for _ in 0..4 {
                    wide.wide(InstructionSet::best(), &group, CONTEXT);
                    assert!(wide.now.iter().all(|q| q.is_finite()), "{title}");
                    assert!(wide.multipliers.iter().all(|sum| sum.is_finite()), "{title}");
                }
                // From a nanometre it is thrown far, and the accumulated multiplier cancels to few digits.
                let times = if context == "tiny" { 5000.0 } else { 20.0 };
                assert_alike(&title, &group, state, times * tolerance);
            }
        }
    }
}

#[test]
fn a_particle_that_is_not_a_number_stops_its_own_constraint_and_no_other() {
    for (name, n, kind, _) in every() {
        for bad in [f32::NAN, f32::INFINITY, 1e30] {
            let mut random = Random::new(74);
            for soft in SOFT {
                let group = constraint_batches(n, &|k| kind(k, soft));
                let Group::Constraints(constraints) = &group else { return };
                let sound = State::at(&random.positions(21 * n), 21, &mut random);
                let (mut spoilt, mut sound, hit) = (sound.clone(), sound, &constraints[9].rows);
                spoilt.now[hit[n - 1] as usize].x = bad;
                let before = spoilt.clone();
                spoilt.wide(InstructionSet::best(), &group, CONTEXT);
                sound.wide(InstructionSet::best(), &group, CONTEXT);
                for row in 0..21 * n {
                    let expected =
                        if hit.contains(&(row as u32)) { before.now[row] } else { sound.now[row] };
                    let same = expected.to_array().map(f32::to_bits)
                        == spoilt.now[row].to_array().map(f32::to_bits);
                    // A particle that is merely far away may be moved, but must stay finite.
                    assert!(same || (bad == 1e30 && spoilt.now[row].is_finite()), "{name} {bad}");
                }
                assert!(spoilt.multipliers.iter().all(|sum| sum.is_finite()), "{name} {bad}");
            }
        }
    }
}

#[test]
fn what_is_measured_is_the_largest_error_of_the_hard_ones_alone() {
    for (name, n, kind, _) in every() {
        let mut random = Random::new(75);
        let mut state = State::at(&random.positions(21 * n), 21, &mut random);
        let group = constraint_batches(n, &|k| kind(k, SOFT[if k == 12 { 0 } else { 1 + k % 2 }]));
        let Group::Constraints(constraints) = &group else { return };
        let (constraint_batches, which) = group.wide();
        let found = constraint_batches.measure(&mut state.places(), &which, InstructionSet::best());
        let (mut local, before) = (Local::default(), state.clone());
        let expected = super::super::constraint_ref::constraint_error(
            &state.places(),
            &constraints[12],
            &mut local,
        );
        assert!((found - expected).abs() <= 1e-5 * expected, "{name}: {found} {expected}");
        assert_eq!(before.bits(), state.bits());
        assert!(expected > 0.0);
    }
}
