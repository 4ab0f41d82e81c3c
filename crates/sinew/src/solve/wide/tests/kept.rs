//! What every wide kernel conserves, whichever constraints share a batch.

use glam::DVec3;

use super::*;

/// The linear and the angular momentum of a displacement and the sum of its sizes, by mass, without pinned particles.
fn momenta(before: &State, after: &State) -> (DVec3, DVec3, f64) {
    let (mut linear, mut angular, mut size) = (DVec3::ZERO, DVec3::ZERO, 0.0);
    for (q, p) in before.now.iter().zip(&after.now).filter(|(q, _)| q.w > 0.0) {
        let way = (*p - *q).truncate().as_dvec3() / f64::from(q.w);
        linear += way;
        angular += q.truncate().as_dvec3().cross(way);
        size += way.length();
    }
    (linear, angular, size)
}

#[test]
fn both_momenta_are_conserved_by_every_kind_and_every_distance() {
    let mut random = Random::new(76);
    let mut groups: Vec<_> = every()
        .into_iter()
        .flat_map(|(name, n, kind, _)| {
            SOFT.map(|soft| (name, n, constraint_batches(n, &|k| kind(k, soft))))
        })
        .collect();
    let rod = |k: usize| Distance::new(0, 1, 0.1 * k as f32);
    groups.push(("distance", 2, distances(&|k| rod(k).with_softness(SOFT[k % 7]))));
    for (name, n, group) in groups {
        let mut state = State::at(&random.positions(21 * n), 21, &mut random);
        // No pins: they would take up momentum.
        state.now.iter_mut().filter(|q| q.w == 0.0).for_each(|q| q.w = 1.0);
        let before = state.clone();
        state.wide(InstructionSet::best(), &group, CONTEXT);
        let (linear, angular, size) = momenta(&before, &state);
        assert!(size > 0.01, "{name}: nothing moved");
        assert!(linear.length() < 1e-5 * size, "{name}: {linear} of {size}");
        assert!(angular.length() < 2e-5 * size, "{name}: {angular} of {size}");
    }
}

#[test]
fn cones_of_four_and_of_five_particles_go_together() {
    let mut random = Random::new(77);
    let Group::Constraints(mut mixed) = constraint_batches(5, &|k| cone(k, SOFT[k % 7])) else {
        return;
    };
    mixed.iter_mut().step_by(3).for_each(|c| {
        c.rows.remove(3);
    });
    let state = State::at(&random.positions(105), 21, &mut random);
    assert_alike("cones", &Group::Constraints(mixed), state, 5e-6);
}

#[test]
fn those_that_share_particles_go_one_after_the_other() {
    let mut random = Random::new(78);
    let chain = |k: u32| Constraint::new(k..k + 4, bend(k as usize, SOFT[k as usize % 7]));
    let chain: Vec<_> = (0..12).map(chain).collect();
    let mut constraint_batches = ConstraintBatches::default();
    let which = constraint_batches.add(&chain, true).unwrap();
    let state = State::at(&random.positions(15), 12, &mut random);
    let (mut scalar, mut wide) = (state.clone(), state);
    let group = Group::Constraints(chain);
    for _ in 0..3 {
        scalar.one_by_one(&group, CONTEXT);
        let mut multipliers = wide.multipliers.clone();
        constraint_batches.sweep(
            &mut wide.places(),
            &which,
            &mut multipliers,
            CONTEXT,
            InstructionSet::best(),
        );
        wide.multipliers = multipliers;
    }
    for (a, b) in scalar.now.iter().zip(&wide.now) {
        assert!(a.abs_diff_eq(*b, 2e-5), "{a} {b}");
    }
}

#[test]
fn slices_that_begin_later_give_the_same_bits() {
    for (name, n, kind, _) in every() {
        let mut random = Random::new(79);
        let group = constraint_batches(n, &|k| kind(k, SOFT[k % 7]));
        let Group::Constraints(mut later) = group.clone() else { return };
        later.iter_mut().flat_map(|c| &mut c.rows).for_each(|row| *row += 1000);
        let mut state = State::at(&random.positions(21 * n), 21, &mut random);
        let mut shifted = state.clone();
        state.wide(InstructionSet::best(), &group, CONTEXT);
        let mut all = ConstraintBatches::default();
        let which = all.add(&later, false).unwrap();
        let mut multipliers = shifted.multipliers.clone();
        let mut places = shifted.places();
        places.first = 1000;
        all.sweep(&mut places, &which, &mut multipliers, CONTEXT, InstructionSet::best());
        shifted.multipliers = multipliers;
        assert_eq!(shifted.bits(), state.bits(), "{name}");
    }
}

#[test]
fn what_has_no_wide_kernel_or_not_the_same_is_refused_and_leaves_nothing() {
    let mut constraint_batches = ConstraintBatches::default();
    let one = Constraint::new(0..4, bend(0, Softness::Hard));
    let other = Constraint::new(4..8, hinge(0, Softness::Hard));
    assert_eq!(constraint_batches.add(&[], false), None);
    assert_eq!(constraint_batches.add(&[one.clone(), other], false), None);
    let line = ConstraintKind::Collinear(crate::constraints::Collinear::default());
    assert_eq!(constraint_batches.add(&[Constraint::new(0..3, line)], false), None);
    assert!(constraint_batches.bends.is_empty() && constraint_batches.hinges.is_empty());
    let first = constraint_batches.add(core::slice::from_ref(&one), false).unwrap();
    constraint_batches.truncate(&Default::default());
    assert_eq!(
        constraint_batches.add(core::slice::from_ref(&one), false),
        Some(first),
        "cleared, it begins anew"
    );
}
