//! Ropes that collide by their segments: what they must stop, and what they carry; compared with the same ropes colliding by their particles.

use core::f32::consts::FRAC_1_SQRT_2;
use std::sync::Arc;

use crate::threads::Threads;
use sinew::glam::{Quat, Vec3};
use sinew::recipes::{Blueprint, BoxSpec, RopeSpec, box_3d, rope};
use sinew::{BodyContacts, Collider, Distance, Frame, InstructionSet, Shape, Simulation};

/// A quarter turn about x, which takes y to z.
const ACROSS: Quat = Quat::from_xyzw(FRAC_1_SQRT_2, 0.0, 0.0, FRAC_1_SQRT_2);

fn empty(substeps: u32) -> Simulation {
    let mut world = Simulation::default();
    world.settings.substeps = substeps;
    world
}

fn contacts() -> BodyContacts {
    BodyContacts { with_bodies: true, ..BodyContacts::default() }
}

/// A horizontal rope of 1.1 m and 200 g, 11 segments of 10 cm with a radius of 5 mm, centred at `middle`.
fn line(middle: Vec3, along: Vec3) -> RopeSpec {
    RopeSpec {
        from: middle - along * 0.55,
        to: middle + along * 0.55,
        segments: 11,
        mass: 0.2,
        radius: 0.005,
        drag: 0.3,
        ..RopeSpec::default()
    }
}

/// Adds a rope, colliding by its segments or by its particles, with additional mass at its ends, kg.
fn add(world: &mut Simulation, spec: &RopeSpec, segments: bool, load: [f32; 2]) {
    let mut body = rope(spec).unwrap();
    body.particles[0].mass += load[0];
    body.particles[spec.segments as usize].mass += load[1];
    let body = if segments { body.with_segments() } else { body };
    body.build_colliding(world, contacts()).unwrap();
}

/// A post of 1 cm diameter through the origin, along z.
fn post(world: &mut Simulation) {
    let post = Shape::capsule(0.005, 2.0).unwrap();
    world.colliders.push(Collider::fixed(post, Frame::new(Vec3::ZERO, ACROSS)));
}

fn run(world: &mut Simulation, seconds: f32, rate: f32) {
    for _ in 0..(seconds * rate).round() as u32 {
        world.step(1.0 / rate).unwrap();
    }
}

/// Heights of the lowest and of the highest of some rows, metres.
fn heights(world: &Simulation, rows: core::ops::Range<usize>) -> [f32; 2] {
    let height = |i: usize| world.particles.position(i).y;
    [rows.clone().map(height).fold(f32::MAX, f32::min), rows.map(height).fold(f32::MIN, f32::max)]
}

/// Root mean square speed, m/s.
fn speed(world: &Simulation) -> f32 {
    let particles = &world.particles;
    let sum: f32 = (0..particles.len()).map(|i| particles.velocity(i).length_squared()).sum();
    (sum / particles.len() as f32).sqrt()
}

/// Largest relative length error of a rod.
fn strain(world: &Simulation) -> f32 {
    let error = |d: &Distance| {
        let [a, b] = [d.a, d.b].map(|i| world.particles.position(i as usize));
        (a.distance(b) - d.rest).abs() / d.rest
    };
    world.distances().iter().map(error).fold(0.0, f32::max)
}

#[test]
fn a_coarse_rope_stays_on_a_thin_post_by_its_segments_and_falls_past_it_by_its_particles() {
    for (rate, substeps) in [(60.0, 10), (240.0, 4)] {
        for above in [0.02, 0.2, 1.0, 3.0] {
            for segments in [true, false] {
                let mut world = empty(substeps);
                post(&mut world);
                add(&mut world, &line(Vec3::Y * above, Vec3::X), segments, [0.0; 2]);
                run(&mut world, 8.0, rate);
                let [low, high] = heights(&world, 0..12);
                println!("{rate} Hz, {above} m, {segments}: {low} {high} {}", speed(&world));
                if segments {
                    assert!(low > -0.6 && high.abs() < 0.06, "{rate} {above}: {low} {high}");
                } else {
                    assert!(high < -10.0, "{rate} {above}: {high}");
                }
            }
        }
    }
}

#[test]
fn a_rope_thrown_over_the_edge_of_a_box_lies_about_it() {
    let half = 0.3;
    let run = |segments: bool| {
        let mut world = empty(10);
        world.colliders.push(Collider::fixed(Shape::half_space(), Frame::at(Vec3::Y * -1.0)));
        let cuboid = Shape::cuboid(Vec3::splat(half * 2.0)).unwrap();
        world.colliders.push(Collider::fixed(cuboid, Frame::IDENTITY));
        let mut body = rope(&line(Vec3::new(-0.2, 1.0, 0.0), Vec3::X)).unwrap();
        body.particles.iter_mut().for_each(|one| one.velocity = Vec3::Y * -10.0);
        let body = if segments { body.with_segments() } else { body };
        body.build_colliding(&mut world, contacts()).unwrap();
        // Penetration of a segment in the box, its thickness included.
        let deepest = |world: &Simulation| {
            let point = |n: u32| {
                let (i, share) = ((n / 20) as usize, (n % 20) as f32 / 20.0);
                let [a, b] = [i, i + 1].map(|i| world.particles.position(i));
                let beyond = a.lerp(b, share).abs() - half;
                // Over an edge, the segment is as far from the box as it is thick, and nearer to both planes that meet there.
                0.005 - beyond.max(Vec3::ZERO).length() - beyond.max_element().min(0.0)
            };
            (0..220).map(point).fold(0.0, f32::max)
        };
        let mut ever = 0.0_f32;
        for _ in 0..300 {
            world.step(1.0 / 60.0).unwrap();
            ever = ever.max(deepest(&world));
        }
        println!(
            "{segments}: {ever} {} {:?} {}",
            deepest(&world),
            heights(&world, 0..12),
            speed(&world)
        );
        (deepest(&world), ever, heights(&world, 0..12))
    };
    let (depth, ever, [low, high]) = run(true);
    assert!(depth < 0.001 && ever < 0.01, "{depth} {ever}");
    assert!(low < 0.2 && high > 0.3, "it hangs down at the side: {low} {high}");
    let (depth, ..) = run(false);
    assert!(depth > 0.01, "by its particles it cuts the corner: {depth}");
}

/// The orientation of each crossing between segments of two ropes: -1 or 1, seen along the shortest connection of their lines.
fn crossings(world: &Simulation) -> Vec<f32> {
    let at = |i: usize| world.particles.position(i);
    let pairs = (0..11).flat_map(|i| (12..23).map(move |j| (i, j)));
    let side = |(i, j): (usize, usize)| {
        let (u, v, r) = (at(i + 1) - at(i), at(j + 1) - at(j), at(j) - at(i));
        let n = u.cross(v) / u.cross(v).length_squared();
        let within = [r.cross(v).dot(n), r.cross(u).dot(n)];
        let crossed = within.iter().all(|share| (0.0..=1.0).contains(share));
        if crossed { r.dot(n).signum() } else { 0.0 }
    };
    pairs.map(side).collect()
}

/// A slack rope between two pins, and another rope that falls across it with a load at each end, kg.
fn crossed(substeps: u32, drop: f32, load: f32, segments: bool) -> Simulation {
    let mut world = empty(substeps);
    let held = RopeSpec { slack: 0.1, pin_start: true, pin_end: true, ..line(Vec3::ZERO, Vec3::X) };
    add(&mut world, &held, segments, [0.0; 2]);
    add(&mut world, &line(Vec3::new(0.0, drop, 0.02), Vec3::Z), segments, [load; 2]);
    world
}

#[test]
fn one_rope_holds_up_another_that_lies_across_it() {
    let mut alone = empty(20);
    let held = RopeSpec { slack: 0.1, pin_start: true, pin_end: true, ..line(Vec3::ZERO, Vec3::X) };
    add(&mut alone, &held, true, [0.0; 2]);
    run(&mut alone, 6.0, 60.0);
    let [slack, _] = heights(&alone, 0..12);
    for drop in [0.0, 0.1, 0.5] {
        let mut world = crossed(20, drop, 0.1, true);
        let mut was = crossings(&world);
        for _ in 0..360 {
            world.step(1.0 / 60.0).unwrap();
            let now = crossings(&world);
            assert!(was.iter().zip(&now).all(|(was, now)| was * now >= 0.0), "they pass");
            was = now;
        }
        let [low, high] = heights(&world, 12..24);
        let [pulled, _] = heights(&world, 0..12);
        println!("{drop}: {low} {high}, {slack} -> {pulled}, strain {}", strain(&world));
        assert!(high > pulled - 0.03 && low > -1.1, "{drop}: {low} {high}");
        assert!(pulled < slack - 0.005, "{drop}: it pulls the other one down: {slack} {pulled}");
        assert!(strain(&world) < 0.02, "{}", strain(&world));
    }
    let mut world = crossed(20, 0.1, 0.1, false);
    run(&mut world, 6.0, 60.0);
    assert!(heights(&world, 12..24)[1] < -10.0, "by their particles one falls past the other");
}

#[test]
fn a_box_hangs_on_a_rope_over_a_post() {
    for segments in [true, false] {
        let mut world = empty(20);
        post(&mut world);
        let spec = RopeSpec { pin_start: true, ..line(Vec3::Y * 0.03, Vec3::X) };
        add(&mut world, &spec, segments, [0.0; 2]);
        let hung = box_3d(&BoxSpec { size: Vec3::splat(0.2), mass: 1.0, ..BoxSpec::default() });
        let mut hung: Blueprint = hung.unwrap();
        hung.parts[0].shape = Shape::cuboid(Vec3::splat(0.2)).ok();
        hung.particles.iter_mut().for_each(|one| one.drag = 0.5);
        let place = Vec3::new(0.75, 0.0, 0.0);
        let placed = hung.transformed(Quat::IDENTITY, place);
        let rows = placed.build_colliding(&mut world, contacts()).unwrap();
        let corner = rows.clone().min_by(|&a, &b| {
            let gap = |i: usize| world.particles.position(i).distance(world.particles.position(11));
            gap(a).total_cmp(&gap(b))
        });
        let corner = corner.unwrap();
        let gap = world.particles.position(corner).distance(world.particles.position(11));
        world.distances_mut().push(Distance::new(11, corner as u32, gap));
        run(&mut world, 10.0, 60.0);
        let [low, high] = heights(&world, rows);
        println!("{segments}: {low} {high} {} {}", speed(&world), strain(&world));
        if segments {
            // Half of the rope, the connection, and the box about its diagonal.
            assert!(low > -1.1 && high > -0.75, "{low} {high}");
            assert!(strain(&world) < 0.02, "{}", strain(&world));
        } else {
            assert!(low < -1.25, "it hangs on the pin alone: {low}");
        }
    }
}

#[test]
fn a_rope_thicker_than_its_segments_are_long_lies_still() {
    for (radius, placed) in [(0.04, true), (0.0275, true), (0.02, true), (0.04, false)] {
        let mut world = empty(10);
        world.colliders.push(Collider::fixed(Shape::half_space(), Frame::IDENTITY));
        // Twenty segments of 5.5 cm, in an arc.
        let spec = RopeSpec { to: Vec3::X, slack: 0.1, radius, ..RopeSpec::default() };
        let body = rope(&spec).unwrap().with_segments().transformed(ACROSS, Vec3::Y * 0.1);
        let own = BodyContacts { with_itself: true, ..contacts() };
        body.build_colliding(&mut world, own).unwrap();
        if !placed {
            (0..21).for_each(|i| world.particles.set_rest(i, None));
        }
        run(&mut world, 1.0, 60.0);
        let mut fastest = 0.0_f32;
        for _ in 0..60 {
            world.step(1.0 / 60.0).unwrap();
            fastest = fastest.max(speed(&world));
        }
        println!("{radius} {placed}: {fastest} m/s, strain {}", strain(&world));
        if placed {
            assert!(fastest < 1e-3 && strain(&world) < 1e-3, "{radius}: {fastest}");
        } else {
            // Without rest positions, the rope is pressed apart.
            assert!(strain(&world) > 0.05, "{}", strain(&world));
        }
    }
}

#[test]
fn a_rope_of_one_segment_lies_on_the_floor_and_a_pinned_one_carries_another() {
    let mut world = empty(10);
    world.colliders.push(Collider::fixed(Shape::half_space(), Frame::at(Vec3::Y * -1.0)));
    add(&mut world, &RopeSpec { segments: 1, ..line(Vec3::Z * 3.0, Vec3::X) }, true, [0.0; 2]);
    let held = RopeSpec { pin_start: true, pin_end: true, ..line(Vec3::ZERO, Vec3::X) };
    add(&mut world, &RopeSpec { segments: 1, ..held }, true, [0.0; 2]);
    add(&mut world, &line(Vec3::Y * 0.2, Vec3::Z), true, [0.0; 2]);
    run(&mut world, 6.0, 60.0);
    let [low, high] = heights(&world, 0..2);
    assert!((low + 0.995).abs() < 1e-4 && (high + 0.995).abs() < 1e-4, "{low} {high}");
    let [low, high] = heights(&world, 4..16);
    assert!(low > -0.7 && high.abs() < 0.06, "{low} {high}");
}

#[test]
fn ropes_that_hit_each_other_keep_their_momentum() {
    let mut world = empty(10);
    world.forces.gravity = Vec3::ZERO;
    let free = |middle: Vec3, along: Vec3| RopeSpec { drag: 0.0, ..line(middle, along) };
    add(&mut world, &free(Vec3::ZERO, Vec3::X), true, [0.0; 2]);
    let mut body = rope(&free(Vec3::new(0.1, 0.3, 0.05), Vec3::Z)).unwrap();
    body.particles.iter_mut().for_each(|one| one.velocity = Vec3::Y * -3.0);
    body.with_segments().build_colliding(&mut world, contacts()).unwrap();
    let sums = |world: &Simulation| {
        (0..24).fold((Vec3::ZERO, Vec3::ZERO), |(p, l), i| {
            let momentum = world.particles.velocity(i) * world.particles.mass(i);
            (p + momentum, l + world.particles.position(i).cross(momentum))
        })
    };
    let before = sums(&world);
    run(&mut world, 0.5, 60.0);
    let after = sums(&world);
    println!("{before:?} {after:?}");
    let hit = world.particles.velocity(5).length();
    assert!(hit > 0.2, "they met: {hit}");
    assert!((after.0 - before.0).length() < 1e-4, "{before:?} {after:?}");
    assert!((after.1 - before.1).length() < 5e-4, "{before:?} {after:?}");
}

#[test]
fn neither_instructions_nor_threads_change_a_bit() {
    let run = |set: InstructionSet, threads: Option<usize>| {
        let mut world = crossed(10, 0.1, 0.05, true);
        post(&mut world);
        add(&mut world, &line(Vec3::new(0.3, 0.3, 0.3), Vec3::X), true, [0.0; 2]);
        world.instructions = set;
        world.workers = threads.map(|count| Arc::new(Threads(count)) as _);
        run(&mut world, 3.0, 60.0);
        let bits = |i: usize| {
            let vectors = [world.particles.position(i), world.particles.velocity(i)];
            vectors.map(|vector| vector.to_array().map(f32::to_bits))
        };
        (0..world.particles.len()).map(bits).collect::<Vec<_>>()
    };
    let first = run(InstructionSet::Avx2, None);
    assert!(first == run(InstructionSet::Simd128, None), "128 bits");
    assert!(first == run(InstructionSet::Avx2, Some(2)), "two threads");
}

/// A contact at a pin has no lever about the pin: a line between two posts, pinned in their middles, threw its load away, to values that were not finite.
#[test]
fn a_line_that_is_pinned_in_posts_or_on_them_hangs_still() {
    for (radius, pieces) in [(0.03, 11), (0.03, 40), (0.06, 11), (0.06, 40)] {
        for deep in [0.0, 0.5, 1.0, 1.1] {
            let mut world = Simulation::default();
            let (ends, middle) = ([-0.8, 0.8], Vec3::Y * 1.3);
            for x in ends {
                let post = Shape::cylinder(radius, 2.6).unwrap();
                world.colliders.push(Collider::fixed(post, Frame::at(Vec3::X * x)));
            }
            // Its ends are `deep` of a post's radius from the post's axis, towards the other post.
            let reach = 0.8 - deep * radius;
            let spec = RopeSpec {
                from: middle - Vec3::X * reach,
                to: middle + Vec3::X * reach,
                segments: pieces,
                mass: 0.4,
                radius: 0.018,
                slack: 0.1,
                drag: 0.3,
                pin_start: true,
                pin_end: true,
                ..RopeSpec::default()
            };
            let spec =
                RopeSpec { from: spec.from - Vec3::Y * 0.2, to: spec.to - Vec3::Y * 0.2, ..spec };
            rope(&spec).unwrap().with_segments().build_colliding(&mut world, contacts()).unwrap();
            world.settings.substeps = 20;
            run(&mut world, 6.0, 60.0);
            let name = format!("{radius} m, {pieces} pieces, {deep}");
            // A segment shorter than the thickness of the post has its free end in the post, too, and jitters between its rod and the contact.
            let still = if pieces == 11 { 0.05 } else { 0.2 };
            println!("{name}: {} m/s, {}", speed(&world), strain(&world));
            assert!(speed(&world) < still, "{name}: {} m/s", speed(&world));
            assert!(strain(&world) < 0.1, "{name}: {}", strain(&world));
            let [low, _] = heights(&world, 0..world.particles.len());
            assert!(low > 0.6, "{name}: {low}");
        }
    }
}

/// Segments are processed eight at a time, and only those with contacts.
#[test]
fn distant_bodies_change_no_bit_of_a_rope() {
    let thrown = |others: usize| {
        let mut world = empty(10);
        post(&mut world);
        for n in 0..others {
            let far = Vec3::new(40.0 + 5.0 * n as f32, 0.3, 0.0);
            add(&mut world, &line(far, Vec3::X), true, [0.0, 0.3]);
            let cube = box_3d(&BoxSpec::default()).unwrap();
            let cube = cube.transformed(Quat::IDENTITY, far - Vec3::Y);
            cube.build_colliding(&mut world, contacts()).unwrap();
        }
        let first = world.particles.len();
        add(&mut world, &line(Vec3::new(0.1, 0.3, 0.0), Vec3::X), true, [0.0, 0.3]);
        let mut places = Vec::new();
        for _ in 0..30 {
            run(&mut world, 0.1, 60.0);
            places.extend((first..first + 12).map(|i| world.particles.position(i)));
        }
        places
    };
    let alone = thrown(0);
    assert!(alone.iter().all(|place| place.is_finite()));
    for others in 1..5 {
        assert!(thrown(others) == alone, "{others} others");
    }
}
