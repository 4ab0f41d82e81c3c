//! Determinism: the result depends on positions and the order of rows, and not on the order of triangles, on instruction sets, on the place in the world, or on
//! unrelated objects.

use core::sync::atomic::{AtomicUsize, Ordering};
use std::sync::Arc;

use glam::Vec3;

use super::{ALONE, DT, Sheet, bits, body, colliding, empty, particle};
use crate::collide::filter::ContactFilter;
use crate::collide::nearby::Nearby;
use crate::collide::triangles::Triangles;
use crate::collide::{BodyContacts, ContactParticipant};
use crate::islands::Islands;
use crate::lanes::InstructionSet;
use crate::particles::{ParticleSeed, Particles};
use crate::simulation::Simulation;
use crate::threads::Workers;
use crate::threads::tests::Threads;

/// A free sheet that folds up around balls that are shot at it, with an unrelated particle before the rows for which `is_after_unrelated` returns true. Returns
/// the rows of the others.
fn scene(is_after_unrelated: impl Fn(usize) -> bool) -> (Simulation, Vec<usize>) {
    let mut world = empty(9.81);
    let mut rows = Vec::new();
    let others = body(&mut world, BodyContacts { surface: false, ..colliding(false) });
    let mut count = 0;
    let mut add_unrelated = |world: &mut Simulation, number: usize| {
        if is_after_unrelated(number) {
            count += 1;
            // As light as the others, and far away: they fall side by side.
            let at = Vec3::new(300.0 + count as f32, 0.0, 40.0);
            particle(world, ParticleSeed::at(at).with_radius(0.01), others);
        }
    };
    for i in 0..6 {
        add_unrelated(&mut world, i);
        let at = Vec3::new(0.11 * i as f32 - 0.3, 0.15, 0.04 * i as f32 - 0.1);
        let seed = ParticleSeed::at(at).with_mass(0.03).with_radius(0.015);
        let velocity = Vec3::new(0.1, -2.0 - 5.0 * i as f32, 0.2);
        rows.push(particle(&mut world, seed.with_velocity(velocity), others));
    }
    let sheet = Sheet { contacts: colliding(true), radius: 0.01, ..Sheet::flat(5, 0.15, 0.0) };
    let own = sheet.build(&mut world, |_, _| false);
    rows.extend(own);
    add_unrelated(&mut world, 100);
    (world, rows)
}

fn run(world: &mut Simulation, steps: u32) {
    for _ in 0..steps {
        world.step(DT).unwrap();
    }
}

#[test]
fn neither_the_order_of_triangles_nor_which_way_round_they_are_makes_a_difference() {
    let (mut world, rows) = scene(|_| false);
    let (mut other, _) = scene(|_| false);
    other.forces.surfaces.reverse();
    for (i, triangle) in other.forces.surfaces.iter_mut().enumerate() {
        triangle.rotate_left(i % 3);
        if i % 2 == 0 {
            triangle.swap(0, 1);
        }
    }
    let again = other.forces.surfaces[..7].to_vec();
    other.forces.surfaces.extend(again);
    run(&mut world, 40);
    run(&mut other, 40);
    assert!(bits(&world, &rows) == bits(&other, &rows));
}

#[test]
fn unrelated_particles_change_no_bit_wherever_their_rows_are() {
    let [one, two, three] = [|_: usize| false, |i: usize| i.is_multiple_of(2), |i: usize| i == 100]
        .map(|which| {
            let (mut world, rows) = scene(which);
            run(&mut world, 30);
            bits(&world, &rows)
        });
    assert!(one == two && one == three, "a bit has changed");
}

#[test]
fn all_instructions_give_the_same_bits() {
    let results =
        [InstructionSet::Scalar, InstructionSet::Simd128, InstructionSet::Avx2].map(|set| {
            let (mut world, rows) = scene(|_| false);
            world.instructions = set;
            run(&mut world, 40);
            bits(&world, &rows)
        });
    assert!(results[0] == results[1] && results[0] == results[2]);
}

/// Searches are cut into tasks where they are large, as those of these sheets are. The first one has collisions with itself.
#[test]
fn any_number_of_threads_gives_the_same_bits() {
    #[derive(Debug)]
    struct Counted(Threads, AtomicUsize);

    impl Workers for Counted {
        fn run(&self, work: &(dyn Fn() + Sync)) {
            self.1.fetch_add(1, Ordering::Relaxed);
            self.0.run(work);
        }
    }

    let run_with = |threads: usize| {
        let mut world = empty(9.81);
        let mut rows = Vec::new();
        for (k, height) in [0.0, 0.012, 0.03].into_iter().enumerate() {
            let contacts = colliding(k == 0);
            let sheet = Sheet { radius: 0.004, contacts, ..Sheet::flat(24, 0.02, height) };
            rows.extend(sheet.build(&mut world, |i, j| k == 0 && i % 24 == 0 && j % 24 == 0));
        }
        // One after the other, those in the middle faster, so that lists are refreshed and rebuilt.
        for (number, &row) in rows.iter().enumerate() {
            let [i, j] = [number % 25, number / 25 % 25].map(|k| k as f32 / 24.0 - 0.5);
            let speed = -2.0 * (0.4 - i * i - j * j) * (number / 625) as f32;
            world.particles.set_velocity(row, Vec3::new(0.0, speed, 0.3 * i));
        }
        let workers = Arc::new(Counted(Threads(threads), AtomicUsize::new(0)));
        world.workers = (threads > 0).then(|| workers.clone() as Arc<dyn Workers>);
        // What integration and constraints take.
        let before = {
            let mut apart = world.clone();
            apart.forces.surfaces.clear();
            run(&mut apart, 12);
            workers.1.swap(0, Ordering::Relaxed)
        };
        run(&mut world, 12);
        (bits(&world, &rows), workers.1.load(Ordering::Relaxed), before)
    };
    let (alone, ..) = run_with(0);
    for threads in [1, 2, 3, 8] {
        let (bits, calls, before) = run_with(threads);
        assert!(bits == alone, "{threads} threads");
        assert!(calls > before + 12 * 10, "{calls} calls, {before} without triangles");
    }
}

#[test]
fn five_kilometres_away_it_is_the_same_to_the_bit() {
    let run_at = |offset: Vec3| {
        let (mut world, rows) = scene(|_| false);
        for origin in &mut world.particles.origin {
            *origin += offset;
        }
        run(&mut world, 30);
        rows.iter().map(|&i| world.particles.velocity(i).to_array().map(f32::to_bits)).collect()
    };
    let [here, there]: [Vec<[u32; 3]>; 2] =
        [Vec3::ZERO, Vec3::new(5000.0, -3000.0, 4000.0)].map(run_at);
    assert!(here == there);
}

/// Two sheets that fall on one that is pinned at its corners, and come to rest on it.
fn sheets(_: impl Fn(usize) -> bool) -> (Simulation, Vec<usize>) {
    let mut world = empty(9.81);
    world.forces.drag = 4.0;
    let held = Sheet { radius: 0.01, ..Sheet::flat(6, 0.1, 0.0) };
    let mut rows = held.build(&mut world, |i, j| (i == 0 || i == 6) && (j == 0 || j == 6));
    for height in [0.15, 0.25] {
        let loose = Sheet { radius: 0.01, ..Sheet::flat(5, 0.1, height) };
        rows.extend(loose.build(&mut world, |_, _| false));
    }
    (world, rows)
}

/// The neighbour list lasts for some steps, and gives the result of a world that starts without one.
#[test]
fn no_result_depends_on_earlier_steps() {
    let scenes = [|| scene(|_| false), || sheets(|_| false)];
    for (number, scene) in scenes.into_iter().enumerate() {
        let (mut world, rows) = scene();
        for step in 0..190 {
            let (mut other, _) = scene();
            other.particles = world.particles.clone();
            // The upper two ignore each other for a while.
            let upper = [1, 2].map(ContactParticipant::Body);
            world.ignored = if (130..160).contains(&step) { vec![upper] } else { Vec::new() };
            other.ignored = world.ignored.clone();
            run(&mut world, 1);
            run(&mut other, 1);
            assert!(bits(&world, &rows) == bits(&other, &rows), "scene {number}, step {step}");
        }
    }
}

#[test]
fn the_list_lasts_until_a_member_exceeds_its_margin_or_is_replaced() {
    let (mut world, _) = sheets(|_| false);
    run(&mut world, 1);
    let (particles, surfaces) = (&mut world.particles, &world.forces.surfaces);
    particles.velocity.fill(glam::Vec4::ZERO);
    let nearby = Nearby::everywhere(&world.contacts);
    let mut filter = ContactFilter::default();
    let update = |filter: &mut ContactFilter, particles: &Particles, ignored: &[_]| {
        filter.update(particles, &world.contacts, ignored, &Islands::default(), (&[], &[]));
    };
    update(&mut filter, particles, &[]);
    let mut triangles = Triangles::default();
    let mut looks = |particles: &Particles, filter: &ContactFilter| {
        triangles.broad_phase(particles, surfaces, (filter, &nearby), &[], DT, ALONE);
        triangles.rebuilds + triangles.refreshes
    };
    assert_eq!(looks(particles, &filter), 1);
    assert_eq!(looks(particles, &filter), 0);
    // All move by a metre; one moves a little, then too far; one is pinned.
    particles.position.iter_mut().for_each(|place| place.x += 1.0);
    assert_eq!(looks(particles, &filter), 0);
    // So far that coordinates are rounded too much.
    particles.position.iter_mut().for_each(|place| place.x += 20.0);
    assert_eq!((looks(particles, &filter), looks(particles, &filter)), (1, 0));
    particles.position[60].y += 0.002;
    assert_eq!(looks(particles, &filter), 0);
    particles.position[60].y += 0.05;
    assert_eq!((looks(particles, &filter), looks(particles, &filter)), (1, 0));
    particles.position[60].w = 0.0;
    assert_eq!((looks(particles, &filter), looks(particles, &filter)), (1, 0));
    // A thicker member.
    particles.radius[60] = 0.02;
    assert_eq!((looks(particles, &filter), looks(particles, &filter)), (1, 0));
    // Two sheets that must not touch.
    update(&mut filter, particles, &[]);
    assert_eq!(looks(particles, &filter), 0);
    update(&mut filter, particles, &[[1, 2].map(ContactParticipant::Body)]);
    assert_eq!((looks(particles, &filter), looks(particles, &filter)), (1, 0));
    particles.position[60].x = f32::NAN;
    assert_eq!(looks(particles, &filter), 0);
    particles.position[61].y += 0.05;
    assert_eq!((looks(particles, &filter), looks(particles, &filter)), (1, 0));
    particles.position[70..90].iter_mut().for_each(|place| place.y += 0.05);
    assert_eq!(
        (looks(particles, &filter), looks(particles, &filter)),
        (1, 1),
        "a list that is built where a member is not finite has no candidates of it"
    );
}
