//! The same bits whatever computes them: any instruction set, any number of threads, debug or release.
//!
//! Ten scenes run for 600 ticks, with a hash of all positions and velocities after each. The last hash of each scene is listed below. A deliberate change of
//! the solver's results has to update it; a build that computes something else fails the test. Run with `SINEW_HASHES=show` to print the new ones.

use std::sync::Arc;

use crate::threads::Threads;
use sinew::glam::{Quat, Vec3};
use sinew::recipes::{
    Blueprint, BoxSpec, ClothMaterial, ClothSpec, RagdollSpec, RopeSpec, box_3d, cloth_grid,
    ragdoll, rope,
};
use sinew::{
    AirFlow, BodyContacts, BodySettings, Collider, Distance, Fluid, Frame, InstructionSet,
    Material, ParticleSeed, Plane, Representation, Shape, Simulation, Sleep, Softness, Spring,
    Wind, Workers,
};

const TICKS: usize = 600;

/// The final hash of each scene.
const HASHES: [(&str, fn() -> Simulation, u64); 10] = [
    ("a flag in the wind over the ground", flag, 0x42f3_9bde_e729_a05e),
    ("ropes, tethers and springs", ropes, 0x061a_5ad0_147b_e0c3),
    ("bricks that tumble", bricks, 0x2a42_1822_b58e_2836),
    ("ragdolls that fall", ragdolls, 0xdc96_3fae_9e2c_a200),
    ("charges and balls that float", charges, 0x9320_ef2c_54d0_1f6a),
    ("a large cloth", large, 0xd284_20b0_3f09_2047),
    ("boxes and balls poured onto a ramp", heap, 0x6989_f647_4863_1819),
    ("cloth and a figure on a ball and on stairs", drape, 0x287d_6341_c5d8_0f81),
    ("cloth on ropes, with a crate", tied, 0x7d2a_f19b_ca20_e064),
    ("rigid states among particles", states, 0x0b7f_0560_eb8a_3b33),
];

#[test]
fn every_instruction_set_gives_the_same_bits_in_every_scene() {
    for (name, scene, expected) in HASHES {
        let best = run(scene, InstructionSet::Avx2, None);
        same(name, "128 bits", &run(scene, InstructionSet::Simd128, None), &best);
        let last = best.last().copied().unwrap_or_default();
        if std::env::var_os("SINEW_HASHES").is_some() {
            println!("{name}: {last:#018x}");
        } else {
            assert_eq!(last, expected, "{name}: {last:#018x} is not what it was");
        }
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits_in_every_scene() {
    for (name, scene, _) in HASHES {
        let alone = run(scene, InstructionSet::best(), None);
        for threads in [2, 3, 8] {
            let together = run(scene, InstructionSet::best(), Some(threads));
            same(name, &format!("{threads} threads"), &together, &alone);
        }
    }
}

/// A clone has none of the caches that the original keeps from step to step, and continues with the same bits.
#[test]
fn memory_that_is_kept_from_step_to_step_changes_no_bit() {
    for (name, scene, _) in HASHES {
        let mut kept = scene();
        let mut copied = scene();
        for tick in 0..TICKS / 6 {
            kept.step(1.0 / 60.0).unwrap();
            copied = copied.clone();
            copied.step(1.0 / 60.0).unwrap();
            for i in 0..kept.particles.len() {
                let of = |world: &Simulation| (world.particles.seed(i), world.velocity_now(i));
                assert_eq!(of(&kept), of(&copied), "{name}, tick {tick}, particle {i}");
            }
        }
    }
}

/// The part of the velocities that rounding had taken was not part of a [state](sinew::ParticleState), so that a restored world went on with other last bits.
#[test]
fn a_world_that_is_saved_and_loaded_goes_on_with_the_same_bits() {
    for (name, scene, _) in HASHES {
        let mut world = scene();
        for _ in 0..50 {
            world.step(1.0 / 60.0).unwrap();
        }
        let mut loaded = scene();
        let rows = world.particles.len();
        assert_eq!(loaded.particles.load(0, world.particles.states(0..rows)), rows);
        loaded.contact_cache = world.contact_cache.clone();
        loaded.time = world.time;
        *loaded.sleep = world.sleep.to_vec();
        for tick in 0..TICKS / 10 {
            world.step(1.0 / 60.0).unwrap();
            loaded.step(1.0 / 60.0).unwrap();
            let states = |world: &Simulation| world.particles.states(0..rows).collect::<Vec<_>>();
            for (i, (one, other)) in states(&world).iter().zip(&states(&loaded)).enumerate() {
                assert_eq!(one, other, "{name}, tick {tick}, particle {i}");
            }
        }
    }
}

#[test]
fn a_step_taken_at_once_has_the_bits_of_its_phases_one_by_one() {
    let mut at_once = 0;
    for (name, scene, _) in HASHES {
        let (mut whole, mut phases) = (scene(), scene());
        for tick in 0..TICKS / 4 {
            whole.step(1.0 / 60.0).unwrap();
            let substeps = phases.begin_step(1.0 / 60.0).unwrap();
            at_once += usize::from(tick == 0 && phases.is_undisturbed());
            for _ in 0..substeps {
                phases.begin_substep();
                phases.accumulate_forces();
                phases.apply_wind();
                phases.apply_buoyancy();
                phases.apply_electric();
                phases.integrate();
                phases.solve_constraints();
            }
            phases.end_step();
            for i in 0..whole.particles.len() {
                let of = |world: &Simulation| (world.particles.seed(i), world.velocity_now(i));
                assert_eq!(of(&whole), of(&phases), "{name}, tick {tick}, particle {i}");
            }
            assert_eq!(whole.report(), phases.report(), "{name}, tick {tick}");
            assert_eq!(whole.time, phases.time);
        }
    }
    assert!(at_once >= 3, "only {at_once} scenes were taken at once");
}

/// Adding, removing and tearing bodies does not recompile those that come before them, and gives the bits of a plan that is compiled afresh each time.
#[test]
fn bodies_that_stay_compiled_have_the_bits_of_compiling_afresh() {
    let mut worlds = [(); 2].map(|()| {
        let mut world = sheet(30, 30, 1.0);
        let spec = ClothSpec { columns: 24, rows: 24, ..ClothSpec::default() };
        for n in 1..4 {
            let mut cloth = cloth_grid(&spec).unwrap();
            cloth.pin(24).unwrap();
            let cloth = cloth.transformed(Quat::IDENTITY, Vec3::X * 2.0 * n as f32);
            cloth.build_colliding(&mut world, BodyContacts::default()).unwrap();
        }
        world
    });
    let cord = RopeSpec { segments: 12, ..RopeSpec::default() };
    let crate_of_wood = box_3d(&BoxSpec::default()).unwrap();
    for tick in 0..60_usize {
        for world in &mut worlds {
            let place = Vec3::new(tick as f32, 4.0, 1.0);
            match tick % 6 {
                0 => {
                    let one =
                        if tick % 4 == 0 { rope(&cord).unwrap() } else { crate_of_wood.clone() };
                    let one = one.transformed(Quat::IDENTITY, place);
                    one.build_colliding(world, BodyContacts::default()).unwrap();
                }
                1 => {
                    world.remove_distance(31 * tick + 4000);
                }
                2 => {
                    // More changes than are tracked one by one, in the second cloth or the third.
                    let mut list = world.distances().to_vec();
                    list.drain(90 * tick + 3000..90 * tick + 3030);
                    world.replace_distances_from(0, list);
                }
                3 => {
                    // A new body attached to an old one, and a removal.
                    let last = world.particles.len() as u32 - 1;
                    let apart = world.particles.separation(last as usize, 1500).length();
                    world.extend_distances([Distance::new(1500, last, apart)]);
                    world.remove_distance(tick);
                }
                _ => {}
            }
        }
        worlds[1].distances_mut();
        for world in &mut worlds {
            world.step(1.0 / 60.0).unwrap();
        }
        let [one, other] = &worlds;
        assert_eq!(one.particles.len(), other.particles.len());
        for i in 0..one.particles.len() {
            let of =
                |world: &Simulation| [world.particles.position(i), world.particles.velocity(i)];
            let bits = |[p, v]: [Vec3; 2]| {
                (p.to_array().map(f32::to_bits), v.to_array().map(f32::to_bits))
            };
            assert_eq!(bits(of(one)), bits(of(other)), "particle {i} in tick {tick}");
        }
    }
}

fn same(name: &str, how: &str, found: &[u64], expected: &[u64]) {
    let tick = found.iter().zip(expected).position(|(a, b)| a != b);
    assert_eq!(tick, None, "{name} with {how}: other bits from this tick on");
}

/// The hash after each tick.
fn run(scene: fn() -> Simulation, set: InstructionSet, threads: Option<usize>) -> Vec<u64> {
    let mut world = scene();
    world.instructions = set;
    world.workers = threads.map(|count| Arc::new(Threads(count)) as Arc<dyn Workers>);
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    let mut note = |number: f32| {
        hash = (hash ^ u64::from(number.to_bits())).wrapping_mul(0x0100_0000_01b3);
        hash
    };
    (0..TICKS)
        .map(|_| {
            world.step(1.0 / 60.0).unwrap();
            let mut last = 0;
            for i in 0..world.particles.len() {
                let (p, v) = (world.particles.position(i), world.particles.velocity(i));
                assert!(p.is_finite() && v.is_finite(), "particle {i}");
                for number in p.to_array().into_iter().chain(v.to_array()) {
                    last = note(number);
                }
            }
            last
        })
        .collect()
}

fn flag() -> Simulation {
    let mut world = Simulation::default();
    let spec = ClothSpec { columns: 24, rows: 16, ..Default::default() };
    let mut cloth = cloth_grid(&spec).unwrap();
    let [left, _, below, _] = spec.corners();
    cloth.pin(left).unwrap();
    cloth.pin(below).unwrap();
    cloth.build(&mut world).unwrap();
    let level = world.particles.position(below as usize).y;
    world.boundaries.planes.push(Plane::ground(level - 0.3));
    world.forces.winds.push(Wind::steady(Vec3::new(20.0, 2.0, 9.0)).with_gusts(0.4));
    world.forces.air_flows.push(AirFlow::steady(Vec3::new(4.0, 0.0, 1.0)).with_gusts(0.3));
    world
}

fn ropes() -> Simulation {
    let mut world = Simulation::default();
    for i in 0..12 {
        let from = Vec3::new(i as f32 * 0.3, 2.0, 0.0);
        let spec = RopeSpec {
            from,
            to: from + Vec3::new(0.9, 0.2, 0.4),
            segments: 20 + i,
            ..Default::default()
        };
        let mut blueprint = rope(&RopeSpec { pin_start: true, ..spec }).unwrap();
        if i % 3 == 0 {
            blueprint.pin(20 + i).unwrap();
        }
        let rows = blueprint.build(&mut world).unwrap();
        let (first, last) = (rows.start as u32, rows.end as u32 - 1);
        let tether = Distance::new(first, last, 0.8).with_bound(sinew::Bound::AtMost);
        world.distances_mut().push(tether);
        let soft = Distance::new(first + 2, first + 9, 0.3);
        world.distances_mut().push(soft.with_softness(Softness::frequency(3.0, 0.2)));
        if i > 0 {
            let spring = Spring { a: first - 1, b: last, rest: 0.2, stiffness: 3.0, damping: 0.05 };
            world.forces.springs.push(spring);
        }
    }
    world.forces.drag = 0.1;
    world
}

fn bricks() -> Simulation {
    let mut world = Simulation::default();
    let brick = box_3d(&BoxSpec { size: Vec3::new(0.1, 0.2, 0.3), ..Default::default() }).unwrap();
    scatter(&brick, 30, &mut world);
    world.boundaries.planes.push(Plane::ground(0.0));
    world
}

fn ragdolls() -> Simulation {
    let mut world = Simulation::default();
    scatter(&ragdoll(&RagdollSpec::default()).unwrap(), 6, &mut world);
    world.boundaries.planes.push(Plane::ground(-1.0));
    world.settings.substeps = 6;
    world
}

fn charges() -> Simulation {
    let mut world = Simulation::default();
    let mut random = random();
    for i in 0..400 {
        let at = Vec3::new(random(), random(), random()) * 2.0;
        let charge = if i % 2 == 0 { 4e-7 } else { -3e-7 };
        let seed = ParticleSeed::at(at).with_charge(charge).with_radius(0.02).with_mass(0.03);
        world.particles.push(seed.with_drag(0.3)).unwrap();
    }
    scatter(&box_3d(&BoxSpec::default()).unwrap(), 5, &mut world);
    world.forces.electric.constant = 8.99e9;
    world.forces.electric.softening = 0.05;
    world.forces.fluids.push(Fluid::water(0.5));
    world.settings.substeps = 3;
    world.boundaries.planes.push(Plane::ground(-2.0));
    world
}

/// Enough constraints for its clusters to be swept in parallel.
fn large() -> Simulation {
    let mut world = sheet(100, 90, 10.0);
    world.settings.substeps = 4;
    world.settings.max_sweeps = 2;
    world
}

/// A cloth of this many particles, pinned at its corners.
fn sheet(columns: u32, rows: u32, width: f32) -> Simulation {
    let mut world = Simulation::default();
    let material = ClothMaterial { bend_compliance: None, ..Default::default() };
    let (columns, rows) = (columns - 1, rows - 1);
    let height = width * (rows + 1) as f32 / (columns + 1) as f32;
    let spec = ClothSpec { columns, rows, width, height, material, ..Default::default() };
    let mut cloth = cloth_grid(&spec).unwrap();
    for corner in spec.corners() {
        cloth.pin(corner).unwrap();
    }
    cloth.build(&mut world).unwrap();
    world
}

/// Solids of particles, colliding with each other and with a rotated box, balls among them, all of them bouncing.
fn heap() -> Simulation {
    let mut world = Simulation::default();
    let mut random = random();
    let ramp = Frame::new(Vec3::new(0.0, -0.4, 0.0), Quat::from_xyzw(0.1, 0.0, 0.05, 1.0));
    let ramp = Collider::fixed(Shape::cuboid(Vec3::new(4.0, 0.6, 4.0)).unwrap(), ramp);
    world.colliders.push(ramp.with_material(Material::default().with_restitution(0.4)));
    world.colliders.push(Collider::fixed(Shape::half_space(), Frame::at(Vec3::NEG_Y)));
    let contacts = BodyContacts { with_bodies: true, events: true, ..Default::default() };
    let brick = box_3d(&BoxSpec { size: Vec3::new(0.3, 0.2, 0.4), ..Default::default() }).unwrap();
    for i in 0..19 {
        let turned = Quat::from_xyzw(random(), random(), random(), 1.0).normalize();
        let at = Vec3::new(random(), 0.4 + i as f32 * 0.25, random());
        brick.transformed(turned, at).build_colliding(&mut world, contacts).unwrap();
        world.bodies[i].representation = Representation::Particles;
    }
    let balls = world.bodies.len() as u32;
    world.bodies.push(BodySettings::default());
    world.contacts.push(BodyContacts { with_itself: true, ..contacts });
    for i in 0..40 {
        let at = Vec3::new(random() * 2.0, 1.0 + i as f32 * 0.2, random() * 2.0);
        let seed = ParticleSeed::at(at).with_radius(0.08).with_mass(0.5);
        let row = world.particles.push(seed).unwrap();
        world.particles.set_body(row as usize, Some(balls));
    }
    world.settings.substeps = 5;
    world
}

/// The same as rigid states, except for every fifth; some of them high above in free flight, two of those on a rope.
fn states() -> Simulation {
    let mut world = heap();
    let brick = box_3d(&BoxSpec { size: Vec3::new(0.1, 0.2, 0.3), ..Default::default() }).unwrap();
    let first = world.particles.len() as u32;
    let mut random = random();
    for i in 0..21 {
        let turned = Quat::from_xyzw(random(), random(), random(), 1.0).normalize();
        let at = Vec3::new(0.5 * i as f32, 40.0, 0.0);
        let contacts = BodyContacts { with_bodies: true, ..Default::default() };
        let rows = brick.transformed(turned, at).build_colliding(&mut world, contacts).unwrap();
        rows.for_each(|row| {
            world.particles.set_velocity(row, Vec3::new(random(), random(), random()));
        });
    }
    let apart = world.particles.separation(first as usize, first as usize + 8).length();
    world.distances_mut().push(Distance::new(first, first + 8, apart));
    for (body, settings) in world.bodies.iter_mut().enumerate() {
        let is_state = body % 5 != 4;
        settings.representation =
            if is_state { Representation::Auto } else { Representation::Particles };
    }
    world
}

/// A sheet that folds onto itself over a ball, and a figure that falls down stairs and may sleep there.
fn drape() -> Simulation {
    let mut world = Simulation::default();
    world.colliders.push(Collider::fixed(Shape::sphere(0.3).unwrap(), Frame::IDENTITY));
    for step in 0..4 {
        let at = Vec3::new(1.5 + 0.4 * step as f32, -0.3 * step as f32, 0.0);
        let stair = Shape::cuboid(Vec3::new(0.4, 1.0, 2.0)).unwrap();
        world.colliders.push(Collider::fixed(stair, Frame::at(at - Vec3::Y * 0.5)));
    }
    world.colliders.push(Collider::fixed(Shape::half_space(), Frame::at(Vec3::NEG_Y * 1.5)));
    let contacts = BodyContacts { with_bodies: true, with_itself: true, ..Default::default() };
    let material = ClothMaterial { radius: 0.02, ..Default::default() };
    let spec = ClothSpec { columns: 20, rows: 16, material, ..Default::default() };
    let flat = Quat::from_xyzw(1.0, 0.0, 0.0, -1.0).normalize();
    let sheet = cloth_grid(&spec).unwrap().transformed(flat, Vec3::new(0.1, 0.5, 0.0));
    sheet.build_colliding(&mut world, contacts).unwrap();
    let figure = ragdoll(&RagdollSpec::default()).unwrap();
    let figure = figure.transformed(Quat::from_xyzw(0.0, 0.3, 0.2, 1.0).normalize(), Vec3::X * 1.6);
    figure.build_colliding(&mut world, BodyContacts { with_itself: false, ..contacts }).unwrap();
    world.sleep.resize(world.bodies.len(), Sleep { allowed: true, ..Sleep::default() });
    world.settings.substeps = 5;
    world
}

/// Adds copies of a body at random positions and orientations, and throws them.
fn scatter(blueprint: &Blueprint, count: usize, world: &mut Simulation) {
    let mut random = random();
    for i in 0..count {
        let turned = Quat::from_xyzw(random(), random(), random(), 1.0).normalize();
        let at = Vec3::new(random() * 3.0, 1.0 + i as f32 * 0.2, random() * 3.0);
        let rows = blueprint.transformed(turned, at).build(world).unwrap();
        let thrown = Vec3::new(random(), random() * 2.0, random()) * 2.0;
        rows.for_each(|row| world.particles.set_velocity(row, thrown));
    }
}

/// Random numbers from -0.5 to 0.5, the same each time.
fn random() -> impl FnMut() -> f32 {
    let mut state = 12_345_u32;
    move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / 16_777_216.0 - 0.5
    }
}

/// Level cloth on three ropes, with a crate on a fourth, over a ball; some of these were created before the cloth, and a ragdoll between them.
fn tied() -> Simulation {
    let mut world = Simulation::default();
    let contacts = BodyContacts { with_bodies: true, ..BodyContacts::default() };
    let at = Frame { translation: Vec3::new(0.1, 0.2, 0.0), ..Frame::IDENTITY };
    world.colliders.push(Collider::fixed(Shape::sphere(0.5).unwrap(), at));
    world.boundaries.planes.push(Plane::ground(-2.0));
    let add = |world: &mut Simulation, body: &Blueprint, turn: Quat, at: Vec3| {
        body.transformed(turn, at).build_colliding(world, contacts).unwrap()
    };
    let crate_of_wood =
        box_3d(&BoxSpec { size: Vec3::splat(0.2), mass: 0.5, ..BoxSpec::default() });
    let crate_of_wood =
        add(&mut world, &crate_of_wood.unwrap(), Quat::IDENTITY, Vec3::new(1.2, 0.5, 1.0));
    let spec = ClothSpec { columns: 30, rows: 30, width: 2.0, height: 2.0, ..ClothSpec::default() };
    let figure = ragdoll(&RagdollSpec::default()).unwrap();
    add(&mut world, &figure, Quat::IDENTITY, Vec3::new(3.0, 0.0, 0.0));
    let level = Quat::from_xyzw(1.0, 0.0, 0.0, -1.0).normalize();
    let cloth = add(&mut world, &cloth_grid(&spec).unwrap(), level, Vec3::Y);
    for (number, corner) in spec.corners().into_iter().enumerate() {
        let row = cloth.start + corner as usize;
        let from = world.particles.position(row);
        let hangs = number > 0;
        let to = if hangs { from * 1.3 + Vec3::Y } else { Vec3::new(1.2, 0.6, 1.0) };
        let spec = RopeSpec { from, to, pin_end: hangs, segments: 12, ..RopeSpec::default() };
        let rows = add(&mut world, &rope(&spec).unwrap(), Quat::IDENTITY, Vec3::ZERO);
        world.extend_distances([Distance::new(row as u32, rows.start as u32, 0.0)]);
        if !hangs {
            let [last, corner] = [rows.end - 1, crate_of_wood.start];
            let apart = world.particles.separation(last, corner).length();
            world.extend_distances([Distance::new(last as u32, corner as u32, apart)]);
        }
    }
    world.forces.winds.push(Wind::steady(Vec3::new(0.0, 0.3, 0.4)));
    world
}

/// The lanes beyond the last particle of a cloth held data of another cloth that the same worker had swept before. Its tethers found those particles far from
/// their pin, and the cloth was swept once more, or less often. With threads it was random which cloth that was.
#[test]
fn what_was_swept_before_changes_no_bit_of_cloth() {
    let hung = |at: f32, rows: u32, world: &mut Simulation| {
        let side = ClothSpec { width: 1.0, height: 1.0, ..ClothSpec::default() };
        let spec = ClothSpec { columns: 24, rows, ..side };
        let mut cloth = cloth_grid(&spec).unwrap();
        spec.corners()[..2].iter().for_each(|&corner| cloth.pin(corner).unwrap());
        let place = Vec3::new(at, 2.5, 0.0);
        cloth.transformed(Quat::IDENTITY, place).build(world).unwrap()
    };
    let run = |before: &[f32]| {
        let mut world = Simulation::default();
        world.settings.substeps = 4;
        world.settings.max_sweeps = 2;
        for &at in before {
            hung(at, 40, &mut world);
        }
        let own = hung(0.0, 24, &mut world);
        for _ in 0..30 {
            world.step(1.0 / 60.0).unwrap();
        }
        own.map(|i| world.particles.position(i).to_array().map(f32::to_bits)).collect::<Vec<_>>()
    };
    let alone = run(&[]);
    for before in [&[3.0][..], &[-6.0], &[5.0, 3.0]] {
        assert!(run(before) == alone, "{before:?}");
    }
}
