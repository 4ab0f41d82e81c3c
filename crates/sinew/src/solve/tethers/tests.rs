//! Tethers are as long as the path over the cloth, require no more than its rods do, and follow tears and pins.

use glam::{Quat, Vec3};

use super::*;
use crate::lanes::Columns;
use crate::recipes::{Blueprint, ClothSpec, RopeSpec, cloth_grid, rope};
use crate::solve::rod_graph::RodGraph;
use crate::test_random::Random;
use crate::threads::ExecutionContext;
use crate::{Distance, GradientAt, InstructionSet, ParticleSeed, Simulation};

/// A square metre of cloth of 20 × 20 cells, pinned at some particles, in a world that has begun a step.
fn cloth(pins: &[u32], shaped: impl Fn(Vec3) -> Vec3) -> Simulation {
    let mut cloth = cloth_grid(&ClothSpec::default()).unwrap();
    for particle in &mut cloth.particles {
        particle.position = shaped(particle.position);
    }
    let Blueprint { particles, distances, .. } = &mut cloth;
    let at = |row: u32| particles[row as usize].position;
    distances.iter_mut().for_each(|d| d.rest = at(d.a).distance(at(d.b)));
    for &pin in pins {
        particles[pin as usize] = particles[pin as usize].pinned();
    }
    let mut world = Simulation::default();
    cloth.build(&mut world).unwrap();
    world.begin_step(1.0 / 60.0).unwrap();
    world
}

/// All tethers: row of the particle, row of its pin, and length.
fn tethers(world: &Simulation) -> Vec<(usize, usize, f32)> {
    let plan = world.plan();
    let own = plan.tethers.of(&plan.islands.list[0]).unwrap();
    let each = own.each.iter().enumerate();
    let all = each.flat_map(|(row, tethers)| tethers.map(|(pin, length)| (row, pin, length)));
    all.filter(|one| one.2.is_finite())
        .map(|(row, pin, length)| (row, own.pins[pin as usize] as usize, length))
        .collect()
}

#[test]
fn in_flat_cloth_they_are_straight_lines() {
    let world = cloth(&[0, 20], |p| p);
    let all = tethers(&world);
    assert_eq!(all.len(), 2 * (441 - 2));
    for (row, pin, length) in all {
        let straight = world.particles.position(row).distance(world.particles.position(pin));
        assert!((length - straight).abs() < 1e-5, "{row} to {pin}: {length} for {straight}");
    }
}

/// Tethers are bounds that the rods imply: where all rods have their rest lengths, no tether is shorter than the distance of the particle from its pin.
#[test]
fn none_requires_more_than_the_rods_do() {
    let dome = |p: Vec3| Vec3::new(p.x, p.y, 0.8 - 1.6 * (p.x * p.x + p.y * p.y));
    let pleats = |p: Vec3| Vec3::new(p.x, p.y, 0.1 * (9.0 * p.x).abs().fract());
    let shapes: [&dyn Fn(Vec3) -> Vec3; 2] = [&dome, &pleats];
    for shape in shapes {
        for pins in [&[0, 20][..], &[220], &[0, 5, 220, 440]] {
            let world = cloth(pins, shape);
            let (mut taut, all) = (0, tethers(&world));
            for &(row, pin, length) in &all {
                let far = world.particles.position(row).distance(world.particles.position(pin));
                assert!(far <= length * (1.0 + 1e-6), "{row} to {pin}: {length} for {far}");
                taut += usize::from(length < 1.3 * far);
            }
            assert!(2 * taut > all.len(), "{taut} of {} are of any use", all.len());
        }
    }
}

#[test]
fn a_slit_is_gone_around_and_what_is_cut_off_is_free_in_the_same_step() {
    let mut world = cloth(&[0], |p| p);
    let crosses = |d: &Distance, rows: core::ops::Range<u32>| {
        let (above, below) = (d.a.min(d.b) / 21, d.a.max(d.b) / 21);
        let column = (d.a % 21).min(d.b % 21);
        above < 10 && below >= 10 && rows.contains(&column)
    };
    world.distances_mut().retain(|d| !crosses(d, 0..20));
    world.begin_step(1.0 / 60.0).unwrap();
    // The lower left corner hangs by the right edge only.
    let corner = tethers(&world).into_iter().find(|one| one.0 == 440 - 20).unwrap();
    assert!(corner.2 > 1.9, "{}", corner.2);
    world.distances_mut().retain(|d| !crosses(d, 0..21));
    world.begin_step(1.0 / 60.0).unwrap();
    let plan = world.plan();
    let lower = &plan.islands.list[plan.islands.of[440] as usize];
    assert!(lower.free && plan.tethers.of(lower).is_none());
    world.particles.position[0].w = 1.0;
    world.begin_step(1.0 / 60.0).unwrap();
    let plan = world.plan();
    assert!(plan.islands.list.iter().all(|island| plan.tethers.of(island).is_none()));
}

/// The rods of a cloth with `side` particles on each side, with both diagonals; some rods occur twice.
fn rods_of_cloth(side: u32) -> Vec<(u32, u32, f32, bool)> {
    let mut rods = Vec::new();
    for a in 0..side * side {
        let (row, column) = (a / side, a % side);
        for (down, right) in [(0, 1_i32), (1, -1), (1, 0), (1, 1)] {
            let (row, column) = (row + down, column.wrapping_add_signed(right));
            if row < side && column < side {
                let uneven = 1.0 + 0.02 * (a % 7) as f32;
                let rest = uneven * ((down + right.unsigned_abs()) as f32).sqrt();
                rods.extend([(a, row * side + column, rest, false)]);
                rods.extend((a % 11 == 0).then_some((row * side + column, a, 0.9 * rest, false)));
            }
        }
    }
    rods
}

/// After each of many changes (rods torn, put back, made longer, of no length) the updated distances from pins equal those computed from scratch.
#[test]
fn what_a_tear_leaves_of_distances_is_what_a_new_reckoning_gives() {
    let side = 24;
    let whole = rods_of_cloth(side);
    let last = side * side - 1;
    for pins in [&[0][..], &[0, side - 1], &[side / 2 * side, 3], &[0, 5, last - side, last]] {
        let (mut rods, mut gone) = (whole.clone(), Vec::new());
        let mut known =
            PinFields::of(&RodGraph::shortest(last as usize + 1, &rods), pins.to_vec(), None);
        let (mut random, mut moved) = (Random::new(7), 0);
        let mut any = |below: usize| random.below(below);
        for round in 0..150 {
            for _ in 0..=any(3) {
                let at = any(rods.len());
                match round % 8 {
                    6 => rods.extend(gone.pop()),
                    7 => rods[at].2 *= [0.0, 0.5, 1.5][any(3)],
                    _ => gone.push(rods.swap_remove(at)),
                }
            }
            let graph = RodGraph::shortest(last as usize + 1, &rods);
            let anew = PinFields::of(&graph, pins.to_vec(), None);
            let before = known.lengths();
            known = PinFields::of(&graph, pins.to_vec(), Some(known));
            assert!(known == anew, "round {round}, pins {pins:?}");
            moved += usize::from(known.lengths() != before);
        }
        assert!(moved > 100, "{moved}");
    }
}

/// Two cloths go through tears, new ties and changed pins. After each change their tethers equal those of a new world that has the same rods and pins.
#[test]
fn after_tears_and_other_pins_tethers_are_those_of_a_world_that_was_always_so() {
    let mut world = cloth(&[0, 20], |p| p);
    let second = cloth_grid(&ClothSpec::default()).unwrap();
    second.transformed(Quat::IDENTITY, 3.0 * Vec3::X).build(&mut world).unwrap();
    let (mut random, mut different) = (Random::new(11), 0);
    let mut any = |below: usize| random.below(below);
    let lengths = |world: &Simulation| -> Vec<Vec<[(u32, f32); 2]>> {
        let plan = world.plan();
        let each = plan.islands.list.iter().map(|island| plan.tethers.of(island));
        each.map(|own| own.map_or(Vec::new(), |own| own.each.clone())).collect()
    };
    for round in 0..80 {
        let before = lengths(&world);
        match round % 10 {
            4 => {
                let pin = 441 + any(441);
                let seed = world.particles.seed(pin);
                let is_free = world.particles.inverse_mass(pin) > 0.0;
                let seed = if is_free { seed.pinned() } else { seed.with_mass(0.01) };
                world.particles.set(pin, seed).unwrap();
            }
            7 => {
                let (a, b) = (any(441) as u32, 441 + any(441) as u32);
                let last = world.distances().len();
                world.insert_distance(last, Distance::new(a, b, 2.0));
            }
            8 => world.distances_mut().retain(|d| (d.a < 441) == (d.b < 441)),
            _ => (0..=any(2)).for_each(|_| {
                let at = any(world.distances().len());
                world.remove_distance(at);
            }),
        }
        world.begin_step(1.0 / 60.0).unwrap();
        let mut anew = Simulation::default();
        anew.particles = world.particles.clone();
        anew.distances_mut().extend(world.distances().iter().copied());
        anew.begin_step(1.0 / 60.0).unwrap();
        assert!(lengths(&world) == lengths(&anew), "round {round}");
        different += usize::from(lengths(&world) != before);
    }
    assert!(different > 40, "{different}");
}

/// Relative stretch of a rope of a hundred pieces with a weight of twice its own at its end, two seconds after it was hung up straight.
fn hung(gradient_at: GradientAt) -> f32 {
    let mut world = Simulation::default();
    world.settings.gradient_at = gradient_at;
    for n in 0..=100_u32 {
        let at = Vec3::Y * (-0.05 * n as f32);
        let mass = if n == 100 { 2.0 } else { 0.01 };
        let seed = ParticleSeed::at(at).with_mass(mass);
        world.particles.push(if n == 0 { seed.pinned() } else { seed }).unwrap();
    }
    world.distances_mut().extend((0..100).map(|n| Distance::new(n, n + 1, 0.05)));
    (0..120).for_each(|_| {
        world.step(1.0 / 60.0).unwrap();
    });
    -world.particles.position(100).y / 5.0 - 1.0
}

#[test]
fn a_weight_on_a_long_rope_hangs_by_its_hook() {
    let longer = hung(GradientAt::Current);
    assert!(longer.abs() < 1e-3, "{longer}");
    // Without tethers, where energy is to be kept, the rope is as long as the sweeps leave it.
    let swept = hung(GradientAt::StepStart);
    assert!(swept > 0.05, "{swept}");
}

/// With gradients at the start of the substep, sweeps leave a long rope stretched by some hundredths. In the substeps in which a rod turned too fast for such
/// gradients, tethers and chains closed all of that at once: the rope whipped at 354 m/s, with the energy of a fall by 2430 m; a cloth of 1 m gained 7 m.
#[test]
fn a_whip_that_falls_back_to_the_nearest_points_gains_no_energy() {
    let spec =
        RopeSpec { to: Vec3::X * 10.0, segments: 200, pin_start: true, ..Default::default() };
    let spread = Quat::from_rotation_x(core::f32::consts::FRAC_PI_2);
    let mut sheet = cloth_grid(&ClothSpec::default()).unwrap();
    [0, 20].into_iter().for_each(|row| sheet.pin(row).unwrap());
    for body in [rope(&spec).unwrap(), sheet.transformed(spread, Vec3::ZERO)] {
        for measured in [false, true] {
            let mut world = Simulation::default();
            world.settings.gradient_at = GradientAt::StepStart;
            body.build(&mut world).unwrap();
            if measured {
                world.measure_loads([0], []);
            }
            let (begin, weight) = (world.ledger().energy(), 9.81 * f64::from(body.total_mass()));
            let (mut fallbacks, mut gained) = (0, 0.0_f64);
            for _ in 0..120 {
                fallbacks += world.step(1.0 / 60.0).unwrap().islands[0].fallbacks;
                gained = gained.max((world.ledger().energy() - begin) / weight);
            }
            assert!(fallbacks > 0 && gained < 5e-3, "{fallbacks} fallbacks: {gained} m");
        }
    }
}

#[test]
fn a_turned_world_has_the_same_tethers() {
    let turn = Quat::from_rotation_z(0.3);
    // Round-off decides which of two equally distant pins comes first.
    let by_pins = |world: &Simulation| {
        let mut all = tethers(world);
        all.sort_by_key(|&(row, pin, _)| (row, pin));
        all
    };
    let (one, other) = (cloth(&[0, 20], |p| p), cloth(&[0, 20], |p| turn * p));
    for (a, b) in by_pins(&one).into_iter().zip(by_pins(&other)) {
        assert!(a.0 == b.0 && a.1 == b.1 && (a.2 - b.2).abs() < 1e-5, "{a:?} {b:?}");
    }
}

/// Each span once: the rows of its ends, and its length.
fn spans(world: &Simulation) -> Vec<(u32, u32, f32)> {
    let plan = world.plan();
    let Some(own) = plan.tethers.spans_of(&plan.islands.list[0]) else { return Vec::new() };
    let mut all = own.listed();
    all.sort_by_key(|&(a, b, _)| (a, b));
    all.dedup();
    all
}

#[test]
fn spans_are_as_long_as_the_rods_between_their_ends_and_none_leads_over_a_gap() {
    let mut world = cloth(&[], |p| p);
    let all = spans(&world);
    // Rows and columns of 21 particles, four rods to a span.
    assert_eq!(all.len(), 2 * 21 * 17);
    for &(a, b, length) in &all {
        let straight = world.particles.separation(a as usize, b as usize).length();
        assert!((length - straight).abs() < 1e-5, "{a} to {b}: {length} for {straight}");
        assert!(b - a == 4 || b - a == 4 * 21, "{a} to {b}");
    }
    world.distances_mut().retain(|d| [d.a, d.b] != [210, 211]);
    world.begin_step(1.0 / 60.0).unwrap();
    let cut = spans(&world);
    // Row 10 begins with particle 210: only the span that begins there had that rod.
    assert_eq!(cut.len(), all.len() - 1);
    assert!(cut.iter().all(|span| span.0 != 210 || span.1 != 214));
}

#[test]
fn spans_pull_together_what_is_apart_keep_momentum_and_leave_what_is_slack() {
    let world = cloth(&[], |p| p);
    let plan = world.plan();
    let own = plan.tethers.spans_of(&plan.islands.list[0]).unwrap();
    let flat = &world.particles.position;
    for scale in [0.9, 1.1] {
        let scaled = |p: &Vec4| (p.truncate() * scale).extend(p.w);
        let before: Vec<Vec4> = flat.iter().map(scaled).collect();
        let after = InstructionSet::ALL.map(|instructions| {
            let mut position = before.clone();
            own.project(&mut position, 0, ExecutionContext { instructions, workers: None });
            position
        });
        assert!(after[0] == after[1] && after[1] == after[2], "the same bits");
        for instructions in InstructionSet::ALL {
            let (mut columns, mut position) = (Columns::default(), before.clone());
            columns.reset(Columns::half(2 * before.len()));
            columns.transpose_in(0, &before, instructions);
            own.project_columns(&mut columns, 0, instructions);
            columns.transpose_out(0, &mut position, instructions);
            assert!(position == after[0], "the same bits in columns");
        }
        let moved = |(p, q): (&Vec4, &Vec4)| (*q - *p).truncate();
        let all = || before.iter().zip(&after[0]);
        let far = all().map(|both| moved(both).length()).fold(0.0, f32::max);
        assert_eq!(far > 1e-3, scale > 1.0, "{far}");
        let momentum: Vec3 = all().map(|both| moved(both) / both.0.w).sum();
        assert!(momentum.length() < 1e-6, "{momentum}");
    }
}
