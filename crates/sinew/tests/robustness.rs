//! Guarantees that must hold for any input.

use sinew::glam::Vec3;
use sinew::recipes::{BoxSpec, ClothSpec, RagdollSpec, box_3d, cloth_grid, ragdoll};
use sinew::{BodyCollider, Bound, Distance, ParticleSeed, Pin, Plane, Simulation, Spring, Wind};

fn on_the_ground() -> Simulation {
    let mut world = Simulation::default();
    world.boundaries.planes.push(Plane::ground(0.0));
    world
}

/// Largest relative length error of a rod. The joint limits are inequalities and are not counted.
fn longest_error_of_bones(world: &Simulation) -> f32 {
    let place = |row: u32| world.particles.position(row as usize);
    let bones = world.distances().iter().filter(|d| d.bound == Bound::Equal);
    bones.map(|d| d.error(place(d.a), place(d.b)) / d.rest).fold(0.0, f32::max)
}

/// A short rod between two particles 5 m apart threw them at 1.2 km/s, and later at the maximum speed of 500 m/s.
#[test]
fn what_is_violated_closes_at_a_bounded_speed_and_keeps_its_momenta() {
    for substeps in [1, 4, 10, 40] {
        // Bodies of the same topology are solved side by side.
        for count in [1, 5] {
            let mut world = Simulation::default();
            world.forces.gravity = Vec3::ZERO;
            world.settings.substeps = substeps;
            for i in 0..count {
                for x in [0.0, 5.0] {
                    let seed = ParticleSeed::at(Vec3::new(x, 0.0, 9.0 * i as f32));
                    world.particles.push(seed.with_mass(1.0 + x)).unwrap();
                }
                world.distances_mut().push(Distance::new(2 * i, 2 * i + 1, 0.01));
            }
            for _ in 0..30 {
                assert!(world.step(1.0 / 60.0).unwrap().too_fast.is_empty());
                let velocity = |i: u32| world.particles.velocity(i as usize);
                for i in 0..count {
                    let apart = (velocity(2 * i) - velocity(2 * i + 1)).length();
                    assert!(apart < 2.01, "{substeps} substeps, {count}: {apart} m/s");
                    let momentum = velocity(2 * i) + velocity(2 * i + 1) * 6.0;
                    assert!(momentum.length() < 1e-3, "{substeps} substeps: {momentum}");
                }
            }
            let left = world.report().error;
            assert!(left < 1e-4, "{substeps} substeps: {left}");
        }
    }
}

#[test]
fn nothing_ends_a_step_beyond_the_most_speed() {
    let mut world = Simulation::default();
    world.particles.push(ParticleSeed::at(Vec3::ZERO)).unwrap();
    world.particles.set_velocity(0, Vec3::Y * 1e5);
    world.step(1.0 / 600.0).unwrap();
    assert_eq!(world.report().too_fast, [0]);
    assert!((world.particles.velocity(0).length() - 500.0).abs() < 1e-2);
    world.settings.max_speed = 0.0;
    world.particles.set_velocity(0, Vec3::Y * 1e5);
    world.step(1.0 / 600.0).unwrap();
    assert!(world.report().too_fast.is_empty() && world.particles.velocity(0).y > 9e4);
}

#[test]
fn a_box_lands_tumbles_and_keeps_its_distances_within_half_a_percent() {
    let mut world = on_the_ground();
    let turned = sinew::glam::Quat::from_xyzw(0.18, 0.36, 0.54, 0.74).normalize();
    box_3d(&BoxSpec::default())
        .unwrap()
        .transformed(turned, Vec3::Y * 3.0)
        .build(&mut world)
        .unwrap();
    let mut worst = 0.0_f32;
    for _ in 0..300 {
        worst = worst.max(world.step(1.0 / 60.0).unwrap().strain);
    }
    assert!(worst < 0.005, "{worst}");
    let lowest = (0..8).map(|i| world.particles.position(i).y).fold(f32::MAX, f32::min);
    assert!(lowest > -1e-3 && lowest < 1e-3, "{lowest}");
    let centre = (0..8).map(|i| world.particles.position(i)).sum::<Vec3>() / 8.0;
    assert!((centre.y - 0.5).abs() < 0.01, "it lies on a face: {centre}");
}

/// Pushed in twelve directions, because in only some of them the figure ends on its head, with the whole body above it: in two of these the neck was shortened
/// by 2.5 % while the settings of a ragdoll allowed 12 sweeps.
#[test]
fn a_ragdoll_collapses_and_its_bones_keep_their_lengths_within_one_percent() {
    let body = ragdoll(&RagdollSpec::default()).unwrap();
    let body = body.transformed(sinew::glam::Quat::IDENTITY, Vec3::Y * 0.5);
    for direction in 0..12 {
        let mut world = on_the_ground();
        body.build(&mut world).unwrap();
        let (sin, cos) = libm::sincosf(0.4 * direction as f32);
        world.particles.add_impulse(0, Vec3::new(14.0 * cos, 0.0, 14.0 * sin));
        let mut worst = 0.0_f32;
        for _ in 0..360 {
            world.step(1.0 / 60.0).unwrap();
            worst = worst.max(longest_error_of_bones(&world));
        }
        assert!(worst < 0.01, "direction {direction}: {worst}");
        let highest =
            (0..world.particles.len()).map(|i| world.particles.position(i).y).fold(0.0, f32::max);
        assert!(highest < 0.9, "direction {direction}, it has collapsed: {highest}");
    }
}

#[test]
fn stiff_cloth_on_two_corners_stays_finite_and_close_to_its_size() {
    let mut world = Simulation::default();
    let spec = ClothSpec { columns: 63, rows: 63, ..Default::default() };
    let mut cloth = cloth_grid(&spec).unwrap();
    let [left, right, ..] = spec.corners();
    cloth.pin(left).unwrap();
    cloth.pin(right).unwrap();
    cloth.build(&mut world).unwrap();
    world.settings.max_sweeps = 1;
    for _ in 0..240 {
        world.step(1.0 / 60.0).unwrap();
    }
    let lowest =
        (0..world.particles.len()).map(|i| world.particles.position(i).y).fold(0.0, f32::min);
    assert!(lowest.is_finite() && lowest > -1.0 && lowest < -0.3, "{lowest}");
}

#[test]
fn a_step_of_no_length_or_no_number_is_refused_and_changes_nothing() {
    let mut world = on_the_ground();
    world.particles.push(ParticleSeed::at(Vec3::Y).with_velocity(Vec3::X)).unwrap();
    for dt in [0.0, -1.0, f32::NAN, f32::INFINITY, 1e-40] {
        assert!(world.step(dt).is_err(), "{dt}");
        assert_eq!(world.particles.position(0), Vec3::Y);
        assert_eq!(world.time, 0.0);
    }
}

#[test]
fn settings_out_of_range_are_clamped() {
    let mut world = on_the_ground();
    for x in [0.0, 1.0] {
        world.particles.push(ParticleSeed::at(Vec3::new(x, 1.0, 0.0))).unwrap();
    }
    world.distances_mut().push(Distance::new(0, 1, 0.9));
    world.settings.substeps = 0;
    world.settings.max_sweeps = 0;
    world.settings.tolerance = f32::NAN;
    let report = world.step(1.0 / 60.0).unwrap();
    assert_eq!((report.substeps, report.sweeps), (1, 1));
}

#[test]
fn a_particle_that_turns_non_finite_is_put_back_and_reported() {
    let mut world = on_the_ground();
    world.particles.push(ParticleSeed::at(Vec3::Y)).unwrap();
    world.particles.push(ParticleSeed::at(Vec3::Y * 2.0)).unwrap();
    world.particles.set_external_force(0, Vec3::X * f32::MAX);
    let frozen = world.step(10.0).unwrap().frozen.clone();
    assert_eq!(frozen, [0]);
    assert_eq!(world.particles.position(0), Vec3::Y);
    assert!(world.particles.position(1).is_finite());
}

#[test]
fn a_faulty_distance_changes_no_bit_of_the_rest() {
    let run = |faulty: bool| {
        let mut world = on_the_ground();
        box_3d(&BoxSpec::default())
            .unwrap()
            .transformed(sinew::glam::Quat::IDENTITY, Vec3::Y * 2.0)
            .build(&mut world)
            .unwrap();
        if faulty {
            world.distances_mut().insert(3, Distance::new(2, 2, 1.0));
            world.distances_mut().push(Distance::new(0, 99, 1.0));
            world.distances_mut().push(Distance::new(0, 1, f32::NAN));
        }
        for _ in 0..120 {
            world.step(1.0 / 60.0).unwrap();
        }
        (0..8).map(|i| world.particles.seed(i)).collect::<Vec<_>>()
    };
    assert_eq!(run(true), run(false));
}

#[test]
fn the_same_world_gives_the_same_bits_twice() {
    let run = || {
        let mut world = on_the_ground();
        let body = ragdoll(&RagdollSpec::default()).unwrap();
        body.build(&mut world).unwrap();
        for _ in 0..240 {
            world.step(1.0 / 60.0).unwrap();
        }
        (0..world.particles.len()).map(|i| world.particles.position(i)).collect::<Vec<_>>()
    };
    assert_eq!(run(), run());
}

#[test]
fn the_report_tells_convergence_from_a_spent_budget() {
    let mut world = on_the_ground();
    world.particles.push(ParticleSeed::at(Vec3::Y)).unwrap();
    assert!(world.step(1.0 / 60.0).unwrap().converged);
    // Two contradictory rods between one pair.
    world.particles.push(ParticleSeed::at(Vec3::Y * 2.0)).unwrap();
    world.distances_mut().push(Distance::new(0, 1, 1.0));
    world.distances_mut().push(Distance::new(0, 1, 2.0));
    let report = world.step(1.0 / 60.0).unwrap();
    assert!(!report.converged);
    assert_eq!(report.most_sweeps, 4);
    assert!(report.error > 0.3, "{}", report.error);
}

#[test]
fn springs_triangles_and_pins_on_rows_that_are_not_there_do_nothing() {
    let mut world = on_the_ground();
    world.particles.push(ParticleSeed::at(Vec3::Y)).unwrap();
    world.forces.springs.push(Spring { a: 0, b: 7, rest: 1.0, stiffness: 1.0, damping: 0.0 });
    world.forces.springs.push(Spring { a: 0, b: 0, rest: 1.0, stiffness: 1.0, damping: 0.0 });
    world.forces.surfaces.push([0, 1, 2]);
    world.forces.winds.push(Wind::steady(Vec3::X));
    world.boundaries.pins.push(Pin { particle: 3, target: Vec3::ZERO });
    world.step(1.0 / 60.0).unwrap();
    assert!((world.particles.position(0).y - 1.0 + 0.5 * 9.81 / 3600.0).abs() < 1e-6);
    assert_eq!(world.ledger().elastic, 0.0);
}

#[test]
fn particles_that_are_cleared_away_take_their_distances_out_of_the_plan() {
    let mut world = on_the_ground();
    box_3d(&BoxSpec::default()).unwrap().build(&mut world).unwrap();
    world.step(1.0 / 60.0).unwrap();
    world.particles.resize(3);
    world.step(1.0 / 60.0).unwrap();
    world.particles.clear();
    world.step(1.0 / 60.0).unwrap();
    assert!(world.particles.is_empty());
}

#[test]
fn a_particle_that_is_put_nowhere_goes_back_to_where_it_last_was() {
    let mut world = on_the_ground();
    world.particles.push(ParticleSeed::at(Vec3::Y)).unwrap();
    world.step(1.0 / 60.0).unwrap();
    world.particles.set_position(0, Vec3::NAN);
    assert_eq!(world.step(1.0 / 60.0).unwrap().frozen, [0]);
    assert_eq!(world.particles.position(0), Vec3::Y);
}

#[test]
fn a_rod_to_a_particle_that_turns_non_finite_leaves_both_their_masses() {
    let mut world = Simulation::default();
    world.particles.push(ParticleSeed::at(Vec3::ZERO).with_mass(2.0)).unwrap();
    world.particles.push(ParticleSeed::at(Vec3::X).with_mass(4.0)).unwrap();
    world.distances_mut().push(Distance::new(0, 1, 1.0));
    world.particles.set_external_force(0, Vec3::X * f32::MAX);
    world.step(10.0).unwrap();
    world.particles.set_external_force(0, Vec3::ZERO);
    assert_eq!((world.particles.mass(0), world.particles.mass(1)), (2.0, 4.0));
    assert!(world.step(1.0 / 60.0).unwrap().frozen.is_empty());
}

#[test]
fn a_poisoned_sheet_leaves_every_bit_of_the_sheets_solved_after_it() {
    // Sheets of an odd number of particles, whose last groups of eight are not full: what the poisoned sheet left in the solver's scratch is beyond their last
    // rows.
    let sheets = |poison: bool| {
        let mut world = Simulation::default();
        for (columns, rows) in [(14, 14), (12, 14), (12, 12), (10, 12), (8, 10)] {
            let spec = ClothSpec { columns, rows, ..Default::default() };
            cloth_grid(&spec).unwrap().build(&mut world).unwrap();
        }
        if poison {
            (0..225).for_each(|row| world.particles.set_position(row, Vec3::NAN));
        }
        world.settings.tolerance = 0.0;
        for _ in 0..5 {
            world.step(1.0 / 60.0).unwrap();
        }
        (225..world.particles.len()).map(|i| world.particles.seed(i)).collect::<Vec<_>>()
    };
    assert!(sheets(true) == sheets(false));
}

/// Found by fuzzing: the row was used before it was checked, if any particle had a rest position.
#[test]
fn a_body_collider_whose_particles_are_not_there_touches_nothing() {
    let mut world = on_the_ground();
    world.particles.push(ParticleSeed::at(Vec3::Y)).unwrap();
    world.particles.set_rest(0, Some(Vec3::ZERO));
    world.body_colliders_mut().push(BodyCollider::segment([7, 8], 1.0, 0.1, 1).unwrap());
    for _ in 0..3 {
        world.step(1e-2).unwrap();
    }
    assert!((world.particles.position(0).y - 1.0).abs() < 0.01);
}
