//! Compounds whose particles no other constraint connects move as one rigid state within a step, and their particles follow.
//!
//! The report shows which ones: their rods are not swept.

use std::time::Instant;

use sinew::constraints::{Anchor, AnchorDistance};
use sinew::glam::{DVec3, Mat3, Quat, Vec3};
use sinew::pose::motion;
use sinew::recipes::{BoxLayout, BoxSpec, box_3d};
use sinew::{
    BodyContacts, BodySettings, Collider, Constraint, ConstraintKind, Control, Distance, Fluid,
    Frame, InstructionSet, Material, ParticleSeed, Pin, Plane, Region, Representation, Shape,
    Simulation, Spring, Wind,
};

pub(crate) const DT: f32 = 1.0 / 60.0;

/// A solid box of 1 × 2 × 3 m, scaled by `size`.
fn brick(size: f32) -> BoxSpec {
    let size = Vec3::new(1.0, 2.0, 3.0) * size;
    BoxSpec { size, mass: 1.7, layout: BoxLayout::Equimomental, ..BoxSpec::default() }
}

fn add(world: &mut Simulation, spec: &BoxSpec, at: Vec3, turned: Quat) -> usize {
    let contacts = BodyContacts { with_bodies: true, ..Default::default() };
    let blueprint = box_3d(spec).unwrap().transformed(turned, at);
    let first = blueprint.build_colliding(world, contacts).unwrap().start;
    let body = world.particles.body(first).unwrap() as usize;
    world.bodies[body].representation = Representation::Auto;
    first
}

fn throw(world: &mut Simulation, first: usize, velocity: Vec3, spin: Vec3) {
    let centre = (first..first + 8).map(|i| world.particles.position(i)).sum::<Vec3>() / 8.0;
    for i in first..first + 8 {
        let arm = world.particles.position(i) - centre;
        world.particles.set_velocity(i, velocity + spin.cross(arm));
    }
}

/// A world without gravity, with a box that was thrown.
fn thrown(spin: Vec3, substeps: u32) -> Simulation {
    let mut world = Simulation::default();
    world.forces.gravity = Vec3::ZERO;
    world.settings.substeps = substeps;
    let first = add(&mut world, &brick(1.0), Vec3::new(0.3, 5.1, -0.2), Quat::IDENTITY);
    throw(&mut world, first, Vec3::new(0.4, -0.1, 0.2), spin);
    world
}

fn as_particles(mut world: Simulation) -> Simulation {
    world.bodies.iter_mut().for_each(|body| body.representation = Representation::Particles);
    world
}

fn step(world: &mut Simulation, ticks: usize) {
    for _ in 0..ticks {
        world.step(DT).unwrap();
    }
}

/// Whether the island of a particle moved as one rigid state.
fn is_one_state(world: &Simulation, i: usize) -> bool {
    world.island_report(i).unwrap().sweeps == 0
}

/// Longest edge of the box whose rows start at `first`: from its lower to its upper particles along z.
fn long_axis(world: &Simulation, first: usize) -> Vec3 {
    world.particles.position(first + 4) - world.particles.position(first)
}

/// Bits of positions, velocities and their lags.
pub(crate) fn bits(world: &Simulation) -> Vec<[u32; 7]> {
    let of = |i: usize| {
        let (p, v) = (world.particles.position(i), world.particles.velocity(i));
        let [a, b, c] = p.to_array().map(f32::to_bits);
        let [d, e, f] = v.to_array().map(f32::to_bits);
        [a, b, c, d, e, f, world.particles.lag(i).to_bits()]
    };
    (0..world.particles.len()).map(of).collect()
}

/// One step, phase by phase, with a callback after `accumulate_forces`.
pub(crate) fn phases(world: &mut Simulation, mut between: impl FnMut(&mut Simulation, u32)) {
    let substeps = world.begin_step(DT).unwrap();
    for number in 0..substeps {
        world.begin_substep();
        world.accumulate_forces();
        between(world, number);
        world.apply_wind();
        world.apply_buoyancy();
        world.apply_electric();
        world.integrate();
        world.solve_constraints();
    }
    world.end_step();
}

/// The pose that a game reads is that of the rigid state, without the fit to its particles, which takes a hundred times as long.
#[test]
fn its_pose_is_that_of_its_particles() {
    let mut world = thrown(Vec3::new(3.0, 5.0, -4.0), 10);
    assert_eq!(world.rigid_pose(0), None, "before the first step");
    for tick in 0..300 {
        step(&mut world, 1);
        let found = world.rigid_pose(0).unwrap();
        for (&row, &rest) in
            world.body_colliders()[0].rows.iter().zip(&*world.body_colliders()[0].rest)
        {
            let off = (found.point(rest) - world.particles.position(row as usize)).length();
            assert!(off < 1e-6 * 8.0, "tick {tick}: {off} m");
        }
    }
    let mut world = as_particles(world);
    step(&mut world, 1);
    assert_eq!(world.rigid_pose(0), None, "as particles it has none");
    assert_eq!(world.rigid_pose(1), None, "there is no other");
}

/// The same for its motion: thrown, and at rest on the ground, where both have no velocity.
#[test]
fn its_motion_is_that_of_its_particles() {
    for spin in 0..12 {
        let spin = Vec3::new(3.0, 5.0, -4.0) + Vec3::new(0.3, -0.2, 0.1) * spin as f32;
        let mut world = thrown(spin, 10);
        assert_eq!(world.rigid_motion(0), None, "before the first step");
        world.forces.gravity = Vec3::Y * -9.81;
        world.boundaries.planes.push(Plane::ground(0.0));
        let mut last: Option<[Vec3; 2]> = None;
        for tick in 0..300 {
            step(&mut world, 1);
            let found = world.rigid_motion(0).unwrap();
            let near = world.particles.position(0);
            let points = (0..world.particles.len()).map(|i| {
                let mass = 1.0 / world.particles.inverse_mass(i);
                (world.particles.position(i) - near, world.velocity_now(i), mass)
            });
            let fitted = motion(points).unwrap();
            let size = 1.0 + fitted.velocity.length() + fitted.angular_velocity.length();
            let off = [
                found.barycentre - near - fitted.barycentre,
                found.velocity - fitted.velocity,
                found.angular_velocity - fitted.angular_velocity,
            ];
            let off = off.map(|off| off.length() / size);
            // The velocities of particles in contact lack half a substep's acceleration by it, each by itself: a twentieth of what a tick adds, or some more
            // where that was in the last substeps. In flight and at rest contacts add nothing.
            let now = [found.velocity, found.angular_velocity];
            let [v, w] = last.replace(now).unwrap_or(now);
            let change = found.velocity - v;
            let by_contacts = change.length().min((change - world.forces.gravity * DT).length());
            let by_contacts = (by_contacts + (found.angular_velocity - w).length()) / size;
            let most = 1e-4 + 0.2 * by_contacts;
            let place = format!("{spin} rad/s, tick {tick}");
            assert!(off[0] < 1e-5 && off[1].max(off[2]) < most, "{place}: {off:?}, {most}");
            assert!((found.mass / fitted.mass - 1.0).abs() < 1e-5, "{place}");
            let inertia = found.inertia - fitted.inertia;
            let inertia = inertia.abs_diff_eq(Mat3::ZERO, 1e-4 * found.mass);
            assert!(inertia, "{place}: {:?} {:?}", found.inertia, fitted.inertia);
        }
        let mut world = as_particles(world);
        step(&mut world, 1);
        assert_eq!(world.rigid_motion(0), None, "as particles it has none");
    }
}

/// A wind acts on surfaces. In a world without surfaces, a wind made all boxes step substep by substep.
#[test]
fn a_wind_without_surfaces_changes_nothing() {
    let mut still = thrown(Vec3::new(3.0, 5.0, -4.0), 10);
    let mut windy = still.clone();
    windy.forces.winds.push(Wind::steady(Vec3::X * 50.0));
    windy.begin_step(DT).unwrap();
    assert!(windy.is_undisturbed());
    windy.take_substeps();
    windy.end_step();
    step(&mut still, 1);
    assert_eq!(bits(&windy), bits(&still));
}

#[test]
fn momenta_and_energy_are_kept() {
    for substeps in [4, 10, 40] {
        for spin in [Vec3::new(3.0, 5.0, -4.0), Vec3::Y * 6.0, Vec3::new(0.05, 0.0, 0.02)] {
            let mut world = thrown(spin, substeps);
            let before = world.ledger();
            step(&mut world, 1);
            let middle = world.ledger();
            step(&mut world, 1800);
            assert!(is_one_state(&world, 0));
            let after = world.ledger();
            // Values that are read back have the rounding of the fastest particle.
            let off = (after.momentum - before.momentum).length() / 1.7;
            let most = 2e-6 * (0.46 + 1.1 * f64::from(spin.length()));
            assert!(off < most, "{substeps} substeps, {spin}: momentum off by {off} m/s");
            let off = (after.angular_momentum - before.angular_momentum).length()
                / before.angular_momentum.length();
            assert!(off < 2e-5, "{substeps} substeps, {spin}: angular momentum off by {off}");
            // Verlet's oscillation is of second order, and does not grow.
            let swing = f64::from(spin.length() * DT / substeps as f32).powi(2) + 1e-5;
            let off = after.kinetic / middle.kinetic - 1.0;
            assert!(off.abs() < swing, "{substeps} substeps, {spin}: energy off by {off}");
        }
    }
}

#[test]
fn the_middle_axis_flips_every_3_903_seconds() {
    for substeps in [4, 10, 40] {
        let spin = Vec3::new(0.06, 6.0, 0.0);
        let mut world = thrown(spin, substeps);
        let (mut last, mut flips) = (0.0_f32, Vec::new());
        let corner = |world: &Simulation| {
            (world.particles.position(2) - world.particles.position(0)).normalize().y
        };
        for tick in 1..1800 {
            step(&mut world, 1);
            let now = corner(&world);
            if last * now < 0.0 {
                flips.push((tick as f32 - now / (now - last)) * DT);
            }
            last = now;
        }
        assert!(flips.len() > 5, "{flips:?}");
        for pair in flips.windows(2) {
            let period = pair[1] - pair[0];
            assert!((period / 3.903 - 1.0).abs() < 0.01, "{substeps} substeps: {period}");
        }
    }
}

#[test]
fn it_is_the_motion_of_the_particles() {
    for substeps in [4, 10, 40] {
        let mut world = thrown(Vec3::new(2.0, 3.0, 1.0), substeps);
        world.forces.gravity = Vec3::Y * -9.81;
        world.forces.drag = 0.2;
        let mut rods = as_particles(world.clone());
        step(&mut world, 30);
        step(&mut rods, 30);
        assert!(is_one_state(&world, 0) && !is_one_state(&rods, 0));
        for i in 0..8 {
            let off = (world.particles.position(i) - rods.particles.position(i)).length();
            assert!(off < 2e-3, "{substeps} substeps, particle {i}: {off} m");
        }
        let spread = |world: &Simulation| long_axis(world, 0).length();
        assert!((spread(&world) - 3.0_f32.sqrt()).abs() < 1e-5, "{}", spread(&world));
    }
}

#[test]
fn a_fall_is_the_exact_parabola() {
    let mut world = thrown(Vec3::new(1.0, 2.0, 0.5), 10);
    world.forces.gravity = Vec3::Y * -9.81;
    let centre = |world: &Simulation| {
        (0..8).map(|i| world.particles.position(i).as_dvec3()).sum::<DVec3>() / 8.0
    };
    let before = centre(&world);
    step(&mut world, 120);
    let fallen = centre(&world) - before - DVec3::new(0.8, -0.2, 0.4);
    assert!((fallen.y / (-0.5 * 9.81 * 4.0) - 1.0).abs() < 2e-6, "{fallen}");
}

/// Boxes that fall on a floor, on each other, and next to each other.
fn falling(count: u32) -> Simulation {
    let mut world = Simulation::default();
    let bouncy = Material::default().with_restitution(0.5);
    let floor = Collider::fixed(Shape::half_space(), Frame::IDENTITY);
    world.colliders.push(floor.with_material(bouncy));
    for i in 0..count {
        let turned = Quat::from_euler(Default::default(), 0.7 * i as f32, 1.3 * i as f32, 0.4);
        let at = Vec3::new(0.1 * (i % 3) as f32, 0.6 + 0.5 * i as f32, 0.05 * (i % 2) as f32);
        let first = add(&mut world, &brick(0.15), at, turned);
        throw(&mut world, first, Vec3::new(0.3, -0.5, 0.1), Vec3::new(1.0, 2.0, i as f32));
    }
    let ball = ParticleSeed::at(Vec3::new(0.1, 12.0, 0.0)).with_radius(0.1).with_mass(0.4);
    let row = world.particles.push(ball).unwrap();
    world.bodies.push(BodySettings::default());
    world.contacts.push(BodyContacts { with_bodies: true, material: bouncy, ..Default::default() });
    world.particles.set_body(row as usize, Some(count));
    world
}

#[test]
fn bits_do_not_depend_on_instructions_nor_on_how_a_step_is_taken() {
    let (mut world, mut other, mut parts) = (falling(13), falling(13), falling(13));
    other.instructions = InstructionSet::Simd128;
    let (mut free, mut touching) = (0, 0);
    for tick in 0..240 {
        world.step(DT).unwrap();
        other.step(DT).unwrap();
        phases(&mut parts, |_, _| {});
        free += usize::from((0..104).all(|i| is_one_state(&world, i)));
        touching += usize::from(!world.contact_cache.is_empty());
        assert_eq!(bits(&world), bits(&other), "tick {tick}, instructions");
        assert_eq!(bits(&world), bits(&parts), "tick {tick}, phases");
    }
    assert_eq!(free, 240);
    assert!(touching > 100);
}

#[test]
fn what_is_far_away_changes_no_bit() {
    let mut world = falling(9);
    let mut crowd = falling(9);
    let rows = world.particles.len();
    for i in 0..5 {
        let first = add(
            &mut crowd,
            &brick(0.2),
            Vec3::new(50.0 + 3.0 * i as f32, 1.0, 0.0),
            Quat::IDENTITY,
        );
        throw(&mut crowd, first, Vec3::ZERO, Vec3::X * (40.0 * i as f32));
    }
    for tick in 0..180 {
        world.step(DT).unwrap();
        crowd.step(DT).unwrap();
        assert_eq!(bits(&world), bits(&crowd)[..rows], "tick {tick}");
    }
}

#[test]
fn what_is_restored_goes_on_to_the_same_bits() {
    let mut world = falling(9);
    step(&mut world, 50);
    let mut restored = falling(9);
    let rows = 0..world.particles.len();
    let states: Vec<_> = world.particles.states(rows).collect();
    restored.particles.load(0, states.into_iter());
    restored.contact_cache = world.contact_cache.clone();
    for tick in 0..120 {
        world.step(DT).unwrap();
        restored.step(DT).unwrap();
        assert_eq!(bits(&world), bits(&restored), "tick {tick}");
    }
}

#[test]
fn forces_on_single_particles_are_a_force_and_a_torque() {
    for substeps in [4, 10] {
        let mut world = thrown(Vec3::new(0.5, 1.0, -0.7), substeps);
        world.forces.gravity = Vec3::Y * -2.0;
        let mut rods = as_particles(world.clone());
        let push = |world: &mut Simulation, _: u32| {
            world.particles.add_force(3, Vec3::new(1.0, -0.5, 2.0));
            world.particles.drag_towards(5, 0.8, Vec3::new(3.0, 0.0, 1.0));
        };
        for _ in 0..60 {
            phases(&mut world, push);
            phases(&mut rods, push);
        }
        assert!(is_one_state(&world, 0) && !is_one_state(&rods, 0));
        for i in 0..8 {
            let off = (world.particles.position(i) - rods.particles.position(i)).length();
            assert!(off < 5e-3, "{substeps} substeps, particle {i}: {off} m");
            let off = (world.particles.velocity(i) - rods.particles.velocity(i)).length();
            assert!(off < 2e-2, "{substeps} substeps, particle {i}: {off} m/s");
        }
    }
}

/// Adds a skin of six triangles to a box of eight particles whose rows start at `first`.
fn cover(world: &mut Simulation, first: usize) {
    let corners = [[0, 1, 2], [1, 3, 2], [4, 5, 6], [5, 7, 6], [0, 1, 4], [2, 3, 7]];
    let first = first as u32;
    world.forces.surfaces.extend(corners.map(|corners| corners.map(|row| first + row)));
}

fn spring(a: u32, b: u32, stiffness: f32) -> Spring {
    Spring { a, b, rest: 0.5, stiffness, damping: 0.1 }
}

/// Bodies with every kind of force on them, and some without.
fn pushed(count: u32) -> Simulation {
    let mut world = falling(count);
    (0..count as usize).filter(|number| number % 4 != 1).for_each(|i| cover(&mut world, 8 * i));
    // A triangle between two boxes.
    world.forces.surfaces.push([40, 41, 49]);
    world.forces.winds.push(Wind::steady(Vec3::new(1.0, 0.0, 2.0)).with_gusts(0.5));
    world.forces.springs.push(spring(3, 12, 30.0));
    world.particles.set_external_force(17, Vec3::Y * 2.0);
    world.particles.scale_gravity(26, 0.25);
    let rows: Vec<u32> = (32..40).collect();
    world
        .forces
        .controls
        .push(Control { torque: Vec3::X, ..Control::force("push", rows, Vec3::Z) });
    world
}

#[test]
fn forces_of_all_kinds_are_the_same_to_the_bit_at_once_and_phase_by_phase() {
    let (mut world, mut parts) = (pushed(13), pushed(13));
    for tick in 0..120 {
        world.step(DT).unwrap();
        phases(&mut parts, |_, _| {});
        assert_eq!(bits(&world), bits(&parts), "tick {tick}");
        let now = |world: &Simulation| {
            let rows = 0..world.particles.len();
            rows.map(|i| world.velocity_now(i).to_array().map(f32::to_bits)).collect::<Vec<_>>()
        };
        assert_eq!(now(&world), now(&parts), "tick {tick}");
        assert!((0..104).all(|i| is_one_state(&world, i)), "tick {tick}");
    }
}

#[test]
fn what_acts_on_one_body_changes_no_bit_of_another() {
    // All of them have air drag, which is summed differently where forces act on single particles.
    let damped = |mut world: Simulation| {
        world.forces.drag = 0.3;
        world
    };
    let (mut alone, mut beside) = (damped(falling(9)), damped(falling(9)));
    alone.forces.springs.push(spring(0, 5, 2.0));
    let far = add(&mut beside, &brick(0.2), Vec3::new(90.0, 1.0, 0.0), Quat::IDENTITY) as u32;
    beside.forces.springs.extend([spring(0, 5, 2.0), spring(far, far + 3, 3.0)]);
    beside.particles.set_external_force(far as usize, Vec3::Z);
    let rows = alone.particles.len();
    for tick in 0..120 {
        step(&mut alone, 1);
        phases(&mut beside, |world, _| world.particles.add_force(far as usize + 1, Vec3::X));
        assert_eq!(bits(&alone), bits(&beside)[..rows], "tick {tick}");
    }
}

#[test]
fn the_wind_on_its_skin_is_that_on_its_particles() {
    for (turned, gusts) in [(0.0, 0.0), (0.7, 0.4)] {
        let blown = |representation| {
            let mut world = thrown(Vec3::new(0.5, 1.0, -0.7), 10);
            world.forces.winds.push(Wind::steady(Vec3::new(3.0, 1.0, 2.0)).with_gusts(gusts));
            // A part of a second wind, which rotates the box: its region ends within the box.
            let corner = Region::sphere(Vec3::new(0.8, 6.1, 1.3), 1.2);
            world.forces.winds.push(Wind::steady(Vec3::new(0.0, 4.0, -1.0)).within(corner));
            world.particles.teleport(
                &[0, 1, 2, 3, 4, 5, 6, 7],
                Vec3::ZERO,
                Quat::from_rotation_x(turned),
            );
            cover(&mut world, 0);
            world.bodies[0].representation = representation;
            step(&mut world, 60);
            world
        };
        let (world, rods) = (blown(Representation::Auto), blown(Representation::Particles));
        assert!(is_one_state(&world, 0) && !is_one_state(&rods, 0));
        let speed = world.particles.velocity(0).length();
        assert!(speed > 4.0, "it is blown along: {speed}");
        for i in 0..8 {
            let off = (world.particles.position(i) - rods.particles.position(i)).length();
            assert!(off < 5e-3, "{turned}, particle {i}: {off} m");
            let off = (world.velocity_now(i) - rods.velocity_now(i)).length();
            assert!(off < 2e-2, "{turned}, particle {i}: {off} m/s");
        }
    }
}

/// When the masses of its particles change, the barycentre, about which the wind rotates the body, moves in the body's frame.
#[test]
fn the_wind_turns_a_body_about_its_centre_when_what_it_weighs_has_changed() {
    let blown = |representation| {
        let mut world = thrown(Vec3::ZERO, 10);
        world.forces.winds.push(Wind::steady(Vec3::new(4.0, 2.0, 3.0)));
        cover(&mut world, 0);
        world.bodies[0].representation = representation;
        step(&mut world, 10);
        for i in 0..3 {
            let seed = world.particles.seed(i);
            let (velocity, lag) = (world.particles.velocity(i), world.particles.lag(i));
            world.particles.set(i, seed.with_mass(4.0 * seed.mass)).unwrap();
            world.particles.set_body(i, Some(0));
            assert_eq!((velocity, lag), (world.particles.velocity(i), world.particles.lag(i)));
        }
        step(&mut world, 50);
        world
    };
    let (world, rods) = (blown(Representation::Auto), blown(Representation::Particles));
    assert!(is_one_state(&world, 0) && !is_one_state(&rods, 0));
    let turn = |world: &Simulation| long_axis(world, 0).normalize();
    assert!(turn(&world).distance(turn(&thrown(Vec3::ZERO, 10))) > 0.1, "it turns");
    for i in 0..8 {
        let off = (world.particles.position(i) - rods.particles.position(i)).length();
        assert!(off < 5e-3, "particle {i}: {off} m");
    }
}

/// The acceleration of a particle enters its present velocity, so it has to include the wind on the skin.
#[test]
fn what_lies_in_a_wind_reports_no_velocity() {
    let mut world = Simulation::default();
    world.colliders.push(Collider::fixed(Shape::half_space(), Frame::IDENTITY));
    let spec = BoxSpec { mass: 30.0, ..BoxSpec::default() };
    let first = add(&mut world, &spec, Vec3::Y * 0.5, Quat::IDENTITY);
    cover(&mut world, first);
    world.forces.winds.push(Wind::steady(Vec3::new(20.0, 0.0, 5.0)));
    step(&mut world, 120);
    assert!(is_one_state(&world, first));
    let pressed = world.particles.acceleration(first) - world.forces.gravity;
    assert!(pressed.length() > 0.1, "{pressed}");
    let fastest = (first..first + 8).map(|i| world.velocity_now(i).length()).fold(0.0, f32::max);
    assert!(fastest < 1e-3, "{fastest} m/s");
}

#[test]
fn it_floats_as_its_particles_do() {
    let pool = |representation| {
        let mut world = thrown(Vec3::new(0.2, 0.0, 0.1), 10);
        world.forces.gravity = Vec3::Y * -9.81;
        world.forces.fluids.push(Fluid::water(4.5));
        (0..8).for_each(|i| world.particles.scale_gravity(i, 1.0));
        world.bodies[0].representation = representation;
        step(&mut world, 60);
        world
    };
    let (world, rods) = (pool(Representation::Auto), pool(Representation::Particles));
    for i in 0..8 {
        let off = (world.particles.position(i) - rods.particles.position(i)).length();
        assert!(off < 5e-3, "particle {i}: {off} m");
    }
}

#[test]
fn an_impulse_between_two_phases_is_taken_and_particles_are_current() {
    let mut world = thrown(Vec3::new(0.5, 1.0, -0.7), 10);
    let mut beside = world.clone();
    let before = world.ledger().momentum;
    let mut last = world.particles.position(0);
    phases(&mut world, |world, number| {
        let now = world.particles.position(0);
        if number > 0 {
            let gone = (now - last) / (DT / 10.0);
            assert!((gone - world.particles.velocity(0)).length() < 1e-3, "{gone}");
        }
        last = now;
        if number == 4 {
            world.particles.add_impulse(2, Vec3::X * 0.3);
        }
    });
    let gained = world.ledger().momentum - before;
    assert!((gained - DVec3::X * 0.3).length() < 1e-6, "{gained}");
    assert!(!is_one_state(&world, 0), "it went on as particles");
    step(&mut world, 1);
    assert!(is_one_state(&world, 0), "and is one again");
    let turned = |world: &mut Simulation| world.ledger().angular_momentum;
    let arm = {
        step(&mut beside, 2);
        turned(&mut world) - turned(&mut beside)
    };
    assert!(arm.length() > 0.1, "off its centre it turns the body, too: {arm}");
}

/// An impulse on several particles together was lost between two phases: the change of their velocities was not recorded.
#[test]
fn impulses_on_all_particles_between_two_phases_are_taken() {
    let rows = [0, 1, 2, 3, 4, 5, 6, 7];
    let (push, turn) = (Vec3::new(0.3, -0.1, 0.2), Vec3::new(0.1, 0.2, -0.3));
    for between in [0, 4, 9] {
        let mut world = thrown(Vec3::new(0.5, 1.0, -0.7), 10);
        let before = world.ledger();
        phases(&mut world, |world, number| {
            if number == between {
                world.particles.apply_impulse(&rows, push);
                world.particles.apply_angular_impulse(&rows, turn);
            }
        });
        let now = world.ledger();
        let gained = now.momentum - before.momentum;
        assert!((gained - push.as_dvec3()).length() < 1e-5, "{between}: {gained}");
        let centre = (0..8).map(|i| world.particles.position(i).as_dvec3()).sum::<DVec3>() / 8.0;
        let own = |momentum: DVec3, of: DVec3| of - centre.cross(momentum);
        let spun =
            own(now.momentum, now.angular_momentum) - own(before.momentum, before.angular_momentum);
        // The centre keeps moving within the step.
        assert!((spun - turn.as_dvec3()).length() < 0.02, "{between}: {spun}");
    }
}

#[test]
fn what_is_tied_pinned_bent_or_asks_for_it_goes_as_particles() {
    let is_rigid = |change: fn(&mut Simulation)| {
        let mut world = thrown(Vec3::X, 10);
        let other = world.particles.push(ParticleSeed::at(Vec3::new(0.3, 9.0, 0.0))).unwrap();
        change(&mut world);
        step(&mut world, 1);
        assert!(world.particles.position(other as usize).is_finite());
        is_one_state(&world, 0)
    };
    assert!(is_rigid(|_| {}));
    assert!(!is_rigid(|world| world.distances_mut().push(Distance::new(3, 8, 4.0))));
    assert!(!is_rigid(|world| world.distances_mut()[5].rest *= 1.01));
    assert!(!is_rigid(|world| {
        // Attached at the middle of the box, at its present distance.
        let joint = AnchorDistance::joint(Anchor::new([0.125; 8]), Anchor::particle());
        let away = AnchorDistance { rest: 4.0, ..joint };
        world.constraints_mut().push(Constraint::new(0..9, ConstraintKind::Anchors(away)));
    }));
    assert!(!is_rigid(|world| world.measure_loads([3], [])), "its load is wanted");
    assert!(!is_rigid(|world| {
        let _ = world.remove_distance(7);
    }));
    assert!(!is_rigid(|world| {
        world.boundaries.pins.push(Pin { particle: 2, target: world.particles.position(2) });
    }));
    assert!(!is_rigid(|world| world.bodies[0].representation = Representation::Particles));
    assert!(!is_rigid(|world| world.settings.statics = true));
    assert!(!is_rigid(|world| world.particles.displace(4, Vec3::X * 0.2)));
    assert!(!is_rigid(|world| drop(world.body_colliders_mut().pop())));
    assert!(is_rigid(|world| world.contacts[0].disabled = true));
    assert!(is_rigid(|world| world.boundaries.planes.push(Plane::ground(-3.0))));
}

/// A number of boxes in free flight.
fn flying(count: u32) -> Simulation {
    let mut world = Simulation::default();
    for i in 0..count {
        let at = Vec3::new(3.0 * (i % 64) as f32, 400.0, 3.0 * (i / 64) as f32);
        let first = add(&mut world, &brick(0.3), at, Quat::IDENTITY);
        throw(&mut world, first, Vec3::X, Vec3::new(1.0, 0.5, 0.2));
    }
    world
}

/// A heap of `edge³` boxes that has settled.
fn heap(edge: u32) -> Simulation {
    let mut world = Simulation::default();
    world.colliders.push(Collider::fixed(Shape::half_space(), Frame::IDENTITY));
    for n in 0..edge * edge * edge {
        let (x, y, z) = (n % edge, n / (edge * edge), n / edge % edge);
        let aside = 0.25 * (y % 2) as f32;
        let at = Vec3::new(1.05 * x as f32 + aside, 0.6 + 1.1 * y as f32, 1.05 * z as f32 + aside);
        add(&mut world, &BoxSpec::default(), at, Quat::IDENTITY);
    }
    world
}

/// `cargo test --release -p sinew --test outside rigid_states::speed -- --ignored --nocapture`
#[test]
#[ignore = "measures"]
fn speed() {
    for (name, scene, warm, ticks) in
        [("4096 in free flight", flying(4096), 10, 60), ("1000 in a heap", heap(10), 120, 120)]
    {
        let mut both = [scene.clone(), as_particles(scene)];
        both.iter_mut().for_each(|world| step(world, warm));
        let mut least = [f64::INFINITY; 2];
        let mut sums = [0.0; 2];
        for _ in 0..ticks {
            for (i, world) in both.iter_mut().enumerate() {
                let began = Instant::now();
                step(world, 1);
                let took = began.elapsed().as_secs_f64() * 1e3;
                (least[i], sums[i]) = (least[i].min(took), sums[i] + took);
            }
        }
        let [auto, rods] = sums.map(|sum| sum / f64::from(ticks));
        println!(
            "{name}: {auto:.2} ms (least {:.2}), as particles {rods:.2} ms (least {:.2})",
            least[0], least[1]
        );
    }
}
