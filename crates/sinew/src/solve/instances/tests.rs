//! A body in an instance batch has the same bits as alone in a world.

use std::sync::Arc;

use glam::{Quat, Vec3};

use crate::constraints::{Angle, Bend};
use crate::recipes::{
    Blueprint, BoxSpec, RagdollSpec, RopeSpec, SoftLatticeSpec, box_3d, ragdoll, rope, soft_lattice,
};
use crate::solve::PlanInput;
use crate::threads::tests::Threads;
use crate::{
    Bound, Collider, Constraint, ConstraintKind, Distance, Frame, InstructionSet, IslandReport,
    Material, ParticleSeed, Plane, Shape, Simulation, Softness, Workers,
};

/// Adds body number `usize` of a series to a world.
type Build = fn(&mut Simulation, usize);

/// A world with the given bodies of a series: all of them, or one alone.
fn world(build: Build, bodies: impl IntoIterator<Item = usize>) -> Simulation {
    let mut world = Simulation::default();
    bodies.into_iter().for_each(|number| build(&mut world, number));
    world
}

fn place(world: &mut Simulation, body: &Blueprint, number: usize) {
    let k = number as f32;
    let turned = Quat::from_xyzw(0.1 * (k % 7.0), 0.2, -0.05 * (k % 11.0), 1.0).normalize();
    let at = Vec3::new(1.7 * k, 1.0 + 0.1 * k, 0.3 * k);
    let rows = body.transformed(turned, at).build(world).unwrap();
    let axis = Vec3::new(1.0, 0.3 * k, -0.2 * (k % 3.0));
    for row in rows {
        let arm = world.particles.position(row) - at;
        world.particles.set_velocity(row, axis.cross(arm) * (k % 5.0) + Vec3::X * 0.3);
    }
}

fn boxes(world: &mut Simulation, number: usize) {
    // Rest lengths may differ within a batch.
    let size = Vec3::new(0.5, 0.6, 0.7 + 0.01 * (number % 4) as f32);
    place(world, &box_3d(&BoxSpec { size, radius: 0.02, ..Default::default() }).unwrap(), number);
}

fn ropes(world: &mut Simulation, number: usize) {
    let spec = RopeSpec { segments: 24, pin_start: true, drag: 0.2, ..Default::default() };
    let from = world.particles.len() as u32;
    place(world, &rope(&spec).unwrap(), number);
    let tether = Distance::new(from, from + 24, 0.8).with_bound(Bound::AtMost);
    let soft = Distance::new(from + 2, from + 9, 0.2).with_softness(Softness::frequency(3.0, 0.2));
    let slack = Distance::new(from + 11, from + 14, 0.1).with_softness(Softness::Share(0.4));
    world.distances_mut().extend([tether, soft, slack]);
}

fn ragdolls(world: &mut Simulation, number: usize) {
    place(world, &ragdoll(&RagdollSpec::default()).unwrap(), number);
}

/// A strip with a constraint of each kind that has a wide kernel.
fn strips(world: &mut Simulation, number: usize) {
    let from = world.particles.len() as u32;
    let k = number as f32;
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::new(1.0, 1.0, 0.2 + 0.01 * k)];
    for corner in corners {
        let seed = ParticleSeed::at(corner + Vec3::new(3.0 * k, 1.2 + 0.05 * k, 0.0));
        world.particles.push(seed.with_radius(0.05).with_drag(0.1)).unwrap();
    }
    let soft = Softness::compliant(1e-3);
    let bend = Bend::of(corners).unwrap();
    let bend = Bend { softness: soft, ..bend };
    let angle = Angle { min: 1.8, max: 2.4, softness: Softness::Hard };
    let rows = [from, from + 1, from + 2, from + 3];
    world.constraints_mut().push(Constraint::new(rows, ConstraintKind::Bend(bend)));
    world
        .constraints_mut()
        .push(Constraint::new(rows[..3].iter().copied(), ConstraintKind::Angle(angle)));
    world.distances_mut().push(Distance::new(from, from + 1, 1.0));
    world.distances_mut().push(Distance::new(from + 2, from + 3, 0.9 + 0.01 * k));
}

/// The complete state of some rows as bits, and the report of their island.
fn bits(world: &Simulation, rows: core::ops::Range<usize>) -> (Vec<[u32; 7]>, IslandReport) {
    let number = |x: f32| if x.is_nan() { f32::NAN.to_bits() } else { x.to_bits() };
    let of = |row: usize| {
        let (seed, start) = (world.particles.seed(row), world.step_start(row));
        let [x, y, z] = seed.position.to_array().map(number);
        let [u, v, w] = seed.velocity.to_array().map(number);
        [x, y, z, u, v, w, number(start.length())]
    };
    let report = world.island_report(rows.start).copied().unwrap_or_default();
    (rows.map(of).collect(), report)
}

/// Runs the bodies together in one world and each in a world of its own, and compares them after each tick.
fn compare(build: Build, count: usize, tune: fn(&mut Simulation)) {
    let mut together = world(build, 0..count);
    let mut alone: Vec<_> = (0..count).map(|number| world(build, [number])).collect();
    tune(&mut together);
    alone.iter_mut().for_each(tune);
    for tick in 0..60 {
        together.step(1.0 / 60.0).unwrap();
        for (number, alone) in alone.iter_mut().enumerate() {
            alone.step(1.0 / 60.0).unwrap();
            let size = alone.particles.len();
            let own = bits(&together, number * size..(number + 1) * size);
            assert_eq!(own, bits(alone, 0..size), "tick {tick}, {number} of {count}");
        }
    }
}

const BUILDS: [Build; 4] = [boxes, ropes, ragdolls, strips];

#[test]
fn bodies_in_batches_have_the_bits_that_they_have_alone() {
    for build in BUILDS {
        for count in [3, 8, 9, 17] {
            compare(build, count, |_| {});
        }
    }
}

#[test]
fn bits_are_the_same_on_the_ground_between_walls_and_with_other_settings() {
    for build in BUILDS {
        compare(build, 9, |world| {
            world.boundaries.planes.push(Plane::ground(0.4));
            world
                .boundaries
                .planes
                .push(Plane::new(Vec3::X * 1.1, Vec3::new(1.0, 0.2, 0.0)).unwrap());
            world.settings.substeps = 4;
        });
        compare(build, 8, |world| {
            world.settings.keep_spin = false;
            world.settings.max_sweeps = 30;
            world.settings.tolerance = 1e-6;
            world.settings.substeps = 2;
        });
        // A case that instance batches do not take.
        compare(build, 8, |world| {
            let sheet = Plane::new(Vec3::Y * 0.3, Vec3::Y).unwrap();
            world.boundaries.plane_constraint = Some(sheet);
        });
    }
}

fn jellies(world: &mut Simulation, number: usize) {
    let spec = SoftLatticeSpec { radius: 0.05, ..Default::default() };
    place(world, &soft_lattice(&spec).unwrap(), number);
}

/// A ball that some bodies fall on, a ground with its own drag that all reach, a thin kinematic wall, and a sensor.
fn crowd(world: &mut Simulation) {
    let fixed = |shape: Result<Shape, crate::ShapeFault>, at: Vec3| {
        Collider::fixed(shape.unwrap(), Frame::at(at))
    };
    let ball = fixed(Shape::sphere(0.6), Vec3::new(3.5, 0.2, 0.3));
    let rough =
        Material { drag: crate::PlanarDrag { along: 0.2, across: 0.0 }, ..Default::default() };
    let ground = fixed(Shape::cuboid(Vec3::new(60.0, 0.5, 60.0)), Vec3::ZERO);
    let wall = fixed(Shape::cuboid(Vec3::new(0.02, 3.0, 8.0)), Vec3::new(6.0, 1.0, 0.0));
    let from_here = Frame::at(Vec3::new(6.05, 1.0, 0.0));
    let watched = fixed(Shape::sphere(1.0), Vec3::new(8.0, 0.5, 2.0));
    world.colliders.extend([
        ball.with_material(Material::default().with_restitution(0.8)),
        ground.with_material(rough),
        wall.moving_to(from_here),
        Collider { sensor: true, ..watched },
    ]);
}

#[test]
fn bits_are_the_same_among_colliders() {
    for build in [boxes, ropes, strips, jellies] {
        for count in [3, 9, 17] {
            compare(build, count, crowd);
        }
        // Phase by phase, where the momentum drift is stored for later or removed at once.
        compare(build, 9, |world| {
            crowd(world);
            world.forces.winds.push(crate::Wind::steady(Vec3::X * 3.0));
            world.boundaries.planes.push(Plane::ground(0.3));
        });
    }
}

/// One particle of each body is far from its place, so rods fling others farther than the skin and through whatever is there.
fn torn(world: &mut Simulation, number: usize, build: Build) {
    let row = world.particles.len() + 1;
    build(world, number);
    let at = world.particles.position(row);
    world.particles.set_position(row, at + Vec3::new(0.5, 2.5, 0.0));
}

#[test]
fn bits_are_the_same_when_flung_among_colliders() {
    let builds: [Build; 3] = [
        |world, number| torn(world, number, boxes),
        |world, number| torn(world, number, ropes),
        |world, number| torn(world, number, strips),
    ];
    for build in builds {
        compare(build, 9, |world| {
            crowd(world);
            world.settings.max_sweeps = 12;
        });
    }
}

#[test]
fn bits_are_the_same_with_lane_compaction() {
    for build in [ropes, ragdolls] {
        for count in [10, 27] {
            compare(build, count, |world| {
                world.boundaries.planes.push(Plane::ground(0.4).with_friction(0.3));
                world.settings.substeps = 3;
            });
            compare(build, count, |world| {
                world.boundaries.planes.push(Plane::ground(0.4));
                world.forces.winds.push(crate::Wind::steady(Vec3::X * 3.0));
                world.settings.gradient_at = crate::GradientAt::StepStart;
            });
        }
    }
}

#[test]
fn identical_bodies_are_solved_with_their_own_settings() {
    let mut together = world(ragdolls, 0..20);
    let mut alone: Vec<_> = (0..20).map(|number| world(ragdolls, [number])).collect();
    for (together, alone) in together.bodies.iter_mut().zip(&mut alone).skip(8).take(8) {
        together.max_sweeps = Some(3);
        alone.bodies[0].max_sweeps = Some(3);
    }
    for tick in 0..30 {
        together.step(1.0 / 60.0).unwrap();
        for (number, alone) in alone.iter_mut().enumerate() {
            alone.step(1.0 / 60.0).unwrap();
            let size = alone.particles.len();
            let own = bits(&together, number * size..(number + 1) * size);
            assert_eq!(own, bits(alone, 0..size), "tick {tick}, body {number}");
        }
    }
}

#[test]
fn bits_are_the_same_phase_by_phase() {
    for build in BUILDS {
        compare(build, 9, |world| {
            world.forces.winds.push(crate::Wind::steady(Vec3::X * 3.0));
            world.boundaries.planes.push(Plane::ground(0.4));
        });
    }
}

/// When one of eight bodies slept, the others of its batch were solved one by one, so a crowd of ragdolls took longer the more of them lay still.
#[test]
fn bits_are_the_same_when_some_bodies_sleep() {
    let put_to_sleep = |world: &mut Simulation, body: usize, size: usize| {
        world.sleep[body] = crate::Sleep { asleep: true, still: 9.0, ..crate::Sleep::allowed() };
        for row in body * size..(body + 1) * size {
            world.particles.set_velocity(row, Vec3::ZERO);
        }
    };
    for (build, tune) in [
        (ropes as Build, (|_| {}) as fn(&mut Simulation)),
        (ragdolls, |_| {}),
        (ragdolls, |world| world.boundaries.planes.push(Plane::ground(0.4))),
        (strips, |world| world.forces.winds.push(crate::Wind::steady(Vec3::X * 3.0))),
        (jellies, crowd),
    ] {
        let mut together = world(build, 0..20);
        let mut alone: Vec<_> = (0..20).map(|number| world(build, [number])).collect();
        let size = alone[0].particles.len();
        // So far apart that no body wakes another.
        let part = |world: &mut Simulation, rows: core::ops::Range<usize>, number: usize| {
            for row in rows {
                let at = world.particles.position(row) + Vec3::Z * 8.0 * number as f32;
                world.particles.set_position(row, at);
            }
        };
        for (number, alone) in alone.iter_mut().enumerate() {
            part(&mut together, number * size..(number + 1) * size, number);
            part(alone, 0..size, number);
        }
        tune(&mut together);
        alone.iter_mut().for_each(tune);
        together.sleep.resize(20, crate::Sleep::allowed());
        let sleepers = [1, 7, 8, 10, 11, 12, 13, 14, 15];
        for (number, alone) in alone.iter_mut().enumerate() {
            alone.sleep.resize(1, crate::Sleep::allowed());
            if sleepers.contains(&number) {
                put_to_sleep(&mut together, number, size);
                put_to_sleep(alone, 0, size);
            }
        }
        for tick in 0..30 {
            together.step(1.0 / 60.0).unwrap();
            for (number, alone) in alone.iter_mut().enumerate() {
                alone.step(1.0 / 60.0).unwrap();
                let own = bits(&together, number * size..(number + 1) * size);
                assert_eq!(own, bits(alone, 0..size), "tick {tick}, body {number}");
                assert_eq!(together.sleep[number].asleep, alone.sleep[0].asleep);
            }
        }
        let asleep = sleepers.iter().filter(|&&number| together.sleep[number].asleep).count();
        assert!(asleep > 0, "no body of {size} particles is left asleep");
    }
}

#[test]
fn what_happens_to_one_does_not_change_the_others() {
    let harm: [fn(&mut Simulation, usize); 4] = [
        // Pinned; NaN; flung so that it turns too fast; two particles at one point.
        |world, row| world.particles.position[row].w = 0.0,
        |world, row| world.particles.set_position(row, Vec3::NAN),
        |world, row| world.particles.set_velocity(row, Vec3::new(300.0, -50.0, 80.0)),
        |world, row| {
            let next = world.particles.position(row + 1);
            world.particles.set_position(row, next);
        },
    ];
    for build in BUILDS {
        for harm in harm {
            let (mut healthy, mut harmed) = (world(build, 0..11), world(build, 0..11));
            let mut alone = world(build, [4]);
            let size = alone.particles.len();
            harm(&mut harmed, 4 * size + 2);
            harm(&mut alone, 2);
            for tick in 0..20 {
                for world in [&mut healthy, &mut harmed, &mut alone] {
                    world.step(1.0 / 60.0).unwrap();
                }
                for number in 0..11 {
                    let rows = number * size..(number + 1) * size;
                    let own = bits(&harmed, rows.clone());
                    let expected =
                        if number == 4 { bits(&alone, 0..size) } else { bits(&healthy, rows) };
                    assert_eq!(own, expected, "tick {tick}, body {number}");
                }
            }
        }
    }
}

#[test]
fn bodies_of_other_kinds_in_between_and_other_settings_of_one_change_nothing() {
    fn mixed(world: &mut Simulation, number: usize) {
        BUILDS[[0, 0, 0, 0, 1, 0, 0, 0, 0, 2, 2, 2, 3, 0][number % 14]](world, number);
    }
    let mut together = world(mixed, 0..28);
    let mut alone: Vec<_> = (0..28).map(|number| world(mixed, [number])).collect();
    let before: usize = alone[..6].iter().map(|world| world.particles.len()).sum();
    let body = together.particles.body(before).unwrap() as usize;
    together.bodies[body].max_sweeps = Some(2);
    alone[6].bodies[0].max_sweeps = Some(2);
    for tick in 0..30 {
        together.step(1.0 / 60.0).unwrap();
        let mut first = 0;
        for (number, alone) in alone.iter_mut().enumerate() {
            alone.step(1.0 / 60.0).unwrap();
            let rows = first..first + alone.particles.len();
            first = rows.end;
            let own = bits(alone, 0..alone.particles.len());
            assert_eq!(bits(&together, rows), own, "tick {tick}, body {number}");
        }
    }
}

#[test]
fn instructions_and_threads_do_not_matter() {
    for build in BUILDS {
        let run = |instructions, workers: Option<Arc<dyn Workers>>| {
            let mut world = world(build, 0..100);
            (world.instructions, world.workers) = (instructions, workers);
            world.boundaries.planes.push(Plane::ground(0.6));
            for _ in 0..20 {
                world.step(1.0 / 60.0).unwrap();
            }
            bits(&world, 0..world.particles.len())
        };
        let best = run(InstructionSet::best(), None);
        assert_eq!(run(InstructionSet::Scalar, None), best);
        assert_eq!(run(InstructionSet::Simd128, None), best);
        assert_eq!(run(InstructionSet::best(), Some(Arc::new(Threads(3)))), best);
    }
}

#[test]
fn eight_of_a_kind_make_a_batch_and_what_is_different_does_not() {
    let instance_batches = |build: Build, count: usize| {
        let world = world(build, 0..count);
        let mut plan = crate::solve::Plan::default();
        let (distances, constraints) = (world.distances(), world.constraints());
        plan.compile(PlanInput { distances, constraints, particles: world.particles.len() });
        let sizes = plan.instance_batches.all.iter().map(|batch| batch.islands.len());
        sizes.collect::<Vec<_>>()
    };
    for build in BUILDS {
        assert_eq!(instance_batches(build, 2), []);
        assert_eq!(instance_batches(build, 21), [8, 8, 5]);
    }
    // A single body is left over: identical ones are compacted with the other batches, others are better off alone.
    for build in [ropes, ragdolls] {
        assert_eq!(instance_batches(build, 17), [8, 8, 1]);
    }
    for build in [boxes, strips] {
        assert_eq!(instance_batches(build, 17), [8, 8]);
    }
    fn other(world: &mut Simulation, number: usize) {
        boxes(world, number);
        if number == 4 {
            world.distances_mut()[4 * 28 + 3].bound = Bound::AtMost;
        }
    }
    assert_eq!(instance_batches(other, 9), [4, 4]);
}
