//! The contact cache: stacks on slopes stay where they are, and no manifold is kept beyond its validity.

use super::super::contact_cache::{CachedManifold, ContactKey, Other};
use super::*;
use crate::collide::manifold::{Manifold, ManifoldScratch, Point, collide};
use crate::simulation::Sleep;

/// Plates of 1 × 0.2 × 1 m on each other on a slope of `degrees`.
fn stack(plates: usize, degrees: f32) -> Simulation {
    let mut world = world();
    let turned = turn(Vec3::Z, -degrees.to_radians());
    let frame = Frame::new(Vec3::ZERO, turned);
    world.colliders.push(Collider::fixed(Shape::half_space(), frame).with_material(rough(0.5)));
    *world.contacts =
        vec![
            BodyContacts { material: rough(0.5), with_bodies: true, ..Default::default() };
            plates
        ];
    for k in 0..plates {
        let at = frame.point(Vec3::Y * (0.1 + 0.2 * k as f32));
        let first = add_box(&mut world, Vec3::new(1.0, 0.2, 1.0), 3.0, at, turned);
        world.bodies.push(Default::default());
        (first..first + 8).for_each(|i| world.particles.set_body(i, Some(k as u32)));
    }
    world
}

/// The greatest displacement of a body collider in `seconds`, metres.
fn creep(world: &mut Simulation, seconds: f32) -> f32 {
    let places = |world: &Simulation| -> Vec<Vec3> {
        (0..world.particles.len() / 8).map(|k| centre(world, 8 * k)).collect()
    };
    let before = places(world);
    step(world, seconds);
    let now = places(world);
    before.iter().zip(now).map(|(a, b)| (*a - b).length()).fold(0.0, f32::max)
}

#[test]
fn stacks_on_slopes_do_not_creep() {
    for (plates, degrees) in [(1, 26.0), (3, 10.0), (3, 26.0), (10, 18.0)] {
        let mut world = stack(plates, degrees);
        step(&mut world, 3.0);
        let gone = creep(&mut world, 6.0);
        // The limit for a scene at rest is a millimetre a minute.
        assert!(gone < 1e-4, "{plates} plates at {degrees}° went {gone} m in 6 s");
    }
}

#[test]
fn a_world_restored_with_its_contact_cache_continues_bit_for_bit() {
    let mut world = stack(3, 20.0);
    step(&mut world, 1.0);
    let (mut restored, mut blank) = (world.clone(), world.clone());
    // Lays everything out afresh.
    restored.body_colliders_mut();
    blank.contact_cache.clear();
    for now in [&mut world, &mut restored, &mut blank] {
        step(now, 1.0);
    }
    assert_eq!(world.particles.position, restored.particles.position);
    assert_eq!(world.contact_cache, restored.contact_cache);
    assert_ne!(world.particles.position, blank.particles.position);
}

#[test]
fn cached_manifolds_are_found_by_id_and_not_by_position() {
    let mut world = stack(3, 20.0);
    step(&mut world, 1.0);
    let mut parts = world.clone();
    parts.contact_cache.clear();
    for solid in world.body_colliders() {
        parts.contact_cache.add(solid.id, world.contact_cache.of(solid.id));
        // Manifolds of another id are not taken.
        parts.contact_cache.add(solid.id + 1, world.contact_cache.of(solid.id));
    }
    assert!(world.contact_cache.len() >= 3 && !world.contact_cache.is_empty());
    assert_eq!(parts.contact_cache, world.contact_cache);
}

#[test]
fn a_box_falls_when_the_block_beneath_it_shrinks() {
    let mut world = world();
    set_material(&mut world, rough(0.5));
    let block = |half: f32| Shape::cuboid(Vec3::new(4.0, half * 2.0, 4.0)).unwrap();
    world.colliders.push(Collider::fixed(block(0.5), Frame::IDENTITY));
    let first = add_box(&mut world, Vec3::ONE, 1.0, Vec3::Y * 1.0, Quat::IDENTITY);
    step(&mut world, 2.0);
    assert!((centre(&world, first).y - 1.0).abs() < 1e-3 && world.contact_cache.len() == 1);
    world.colliders[0].shape = block(0.4);
    step(&mut world, 2.0);
    let y = centre(&world, first).y;
    assert!((y - 0.9).abs() < 1e-3, "{y}");
}

#[test]
fn a_box_that_is_moved_rests_where_it_is_put() {
    let mut world = world();
    floor(&mut world, rough(0.5));
    let first = add_box(&mut world, Vec3::ONE, 1.0, Vec3::Y * 0.5, Quat::IDENTITY);
    step(&mut world, 1.0);
    // A hand's breadth up and turned: none of its old corners is below. Not about its diagonal, or it would stand on an edge until rounding tips it over.
    let (middle, turned) = (centre(&world, first), turn(Vec3::new(1.0, 0.0, 0.6), 1.2));
    for i in first..first + 8 {
        let arm = world.particles.position(i) - middle;
        world.particles.set_position(i, Vec3::Y * 0.9 + turned * arm);
        world.particles.set_velocity(i, Vec3::ZERO);
    }
    step(&mut world, 4.0);
    let y = centre(&world, first).y;
    assert!((y - 0.5).abs() < 2e-3 && speed(&world) < 1e-3, "{y} {}", speed(&world));
}

#[test]
fn sleeping_bodies_keep_their_contact_cache() {
    let mut world = stack(3, 20.0);
    *world.sleep = vec![Sleep::allowed(); 3];
    step(&mut world, 3.0);
    assert!(world.sleep.iter().all(|sleep| sleep.asleep));
    let before = world.contact_cache.clone();
    step(&mut world, 1.0);
    assert_eq!(world.contact_cache, before);
    *world.sleep = vec![Sleep::default(); 3];
    assert!(creep(&mut world, 1.0) < 1e-4);
}

#[test]
fn stacks_on_a_mesh_slope_do_not_creep() {
    let mut world = stack(3, 15.0);
    let frame = world.colliders[0].start;
    // A mesh of two triangles, which gives two manifolds.
    let corner = |x: f32, z: f32| Vec3::new(4.0 * x, 0.0, 4.0 * z);
    let corners = vec![corner(-1., -1.), corner(1., -1.), corner(1., 1.), corner(-1., 1.)];
    let sheet = Shape::mesh(corners, vec![[0, 2, 1], [0, 3, 2]]).unwrap();
    world.colliders[0] = Collider::fixed(sheet, frame).with_material(rough(0.5));
    step(&mut world, 3.0);
    let gone = creep(&mut world, 6.0);
    assert!(gone < 1e-4, "{gone}");
}

#[test]
fn a_box_falls_when_the_one_triangle_beneath_it_is_lowered() {
    // The manifolds of one mesh must not be used for another.
    let triangle = |y: f32| {
        let corners = [[-9.0, -9.0], [0.0, 9.0], [9.0, -9.0]].map(|[x, z]| Vec3::new(x, y, z));
        // Another triangle far away, so that the box is within the bounds of both meshes.
        let far = [Vec3::new(20.0, 0.0, 0.0), Vec3::new(20.0, 1.0, 0.0), Vec3::new(20.0, 0.0, 1.0)];
        Shape::mesh([corners, far].concat(), vec![[0, 1, 2], [3, 4, 5]]).unwrap()
    };
    let mut world = world();
    set_material(&mut world, rough(0.5));
    world.colliders.push(Collider::fixed(triangle(0.0), Frame::IDENTITY));
    let first = add_box(&mut world, Vec3::ONE, 1.0, Vec3::Y * 0.5, Quat::IDENTITY);
    step(&mut world, 1.0);
    assert!((centre(&world, first).y - 0.5).abs() < 2e-3);
    world.colliders[0].shape = triangle(-0.1);
    step(&mut world, 2.0);
    let y = centre(&world, first).y;
    assert!((y - 0.4).abs() < 2e-3, "{y}");
}

/// A heightfield of waves 12 cm high, in cells of 25 cm.
fn waves() -> Shape {
    let height = |i: usize| 0.06 * libm::sinf(0.7 * (i % 49) as f32) * libm::cosf((i / 49) as f32);
    let heights: Vec<f32> = (0..49 * 49).map(height).collect();
    Shape::height_field(49, 49, &heights, Vec3::new(12.0, 1.0, 12.0)).unwrap()
}

/// A thousand boxes that lay on a terrain took seventeen times as long as on a plane, because the manifolds of all triangles were computed again in each step.
#[test]
fn manifolds_of_triangles_are_kept_while_a_body_lies() {
    let mut world = world();
    set_material(&mut world, rough(0.5));
    world.colliders.push(Collider::fixed(waves(), Frame::IDENTITY));
    for n in 0..9 {
        let at = Vec3::new((n % 3) as f32 - 1.1, 0.5, (n / 3) as f32 - 0.8);
        add_box(&mut world, Vec3::splat(0.4), 1.0, at, turn(Vec3::Y, n as f32));
    }
    step(&mut world, 4.0);
    let poses = |world: &Simulation| -> Vec<_> {
        world.contact_cache.contacts.iter().map(|one| (one.key, one.seen_from)).collect()
    };
    let before = poses(&world);
    step(&mut world, 0.5);
    let after = poses(&world);
    let kept = before.iter().filter(|pose| after.contains(pose)).count();
    assert!(before.len() > 18 && kept > 3 * before.len() / 4, "{kept} of {}", before.len());
}

/// Whatever a body slides onto has a manifold in time.
#[test]
fn bodies_that_slide_over_triangles_do_not_sink_in_between() {
    let mut deepest = 0.0_f32;
    for speed in [0.02, 0.1, 0.5, 2.0] {
        let mut world = world();
        set_material(&mut world, rough(0.0));
        world.colliders.push(Collider::fixed(waves(), Frame::IDENTITY));
        for n in 0..4 {
            let at = Vec3::new(n as f32 - 1.5, 0.3, 0.3 * n as f32 - 0.8);
            let first =
                add_box(&mut world, Vec3::new(0.5, 0.2, 0.3), 1.0, at, turn(Vec3::Y, n as f32));
            throw(&mut world, first, Vec3::new(0.3, 0.0, 1.0).normalize() * speed, Vec3::ZERO);
        }
        for _ in 0..240 {
            world.step(1.0 / 60.0).unwrap();
            // Particles are at 1/√3 of the way to the corners.
            for first in (0..world.particles.len()).step_by(8) {
                let middle = centre(&world, first);
                for i in first..first + 8 {
                    let corner = middle + (world.particles.position(i) - middle) * 3.0_f32.sqrt();
                    deepest = deepest.max(-world.colliders[0].shape.nearest(corner).distance);
                }
            }
        }
    }
    assert!(deepest < 4e-3, "{deepest}");
}

/// The manifold of a floor has the number of one of its triangles. A body that slides leaves that triangle and keeps what it knows of friction.
#[test]
fn a_body_slides_over_a_floor_of_triangles_as_over_a_plane() {
    let slide = |floor: Shape, speed: f32, size: Vec3| {
        let mut world = world();
        set_material(&mut world, rough(0.3));
        world.colliders.push(Collider::fixed(floor, Frame::IDENTITY).with_material(rough(0.3)));
        let first =
            add_box(&mut world, size, 1.0, Vec3::new(-2.0, 0.5 * size.y, 0.3), turn(Vec3::Y, 0.3));
        let from = centre(&world, first);
        throw(&mut world, first, Vec3::X * speed, Vec3::ZERO);
        step(&mut world, 2.0);
        centre(&world, first) - from
    };
    for (speed, size) in [(0.5, Vec3::splat(0.5)), (2.0, Vec3::splat(0.5)), (4.0, Vec3::ONE)] {
        let [on_plane, on_tiles] = [Shape::half_space(), tiles([81, 81], [0.1, 0.1], 0.0)]
            .map(|floor| slide(floor, speed, size));
        let off = on_plane.distance(on_tiles) / on_plane.length();
        println!("{speed} m/s: {on_plane} and {on_tiles}");
        assert!(off < 0.01, "{speed} m/s: {on_plane} and {on_tiles}");
    }
}

/// With a tolerance for the rounding of a mesh's coordinates that was twenty times as large, boxes of 2 cm fell through it a kilometre from its origin.
#[test]
fn boxes_stand_on_coplanar_triangles_of_any_size_and_far_from_the_origin_of_a_mesh() {
    for size in [0.02_f32, 0.5] {
        for (cells, far, tilt) in [0.3_f32, 5.0].into_iter().flat_map(|cells| {
            [(0.0, 0.3), (1e3, 0.0), (1e3, 0.3), (5e3, 0.0)].map(|(far, tilt)| (cells, far, tilt))
        }) {
            let mut world = world();
            set_material(&mut world, rough(0.5));
            let slope = turn(Vec3::Z, tilt);
            let floor = Collider::fixed(
                tiles([81, 81], [cells * size; 2], far),
                Frame::new(Vec3::ZERO, slope),
            );
            world.colliders.push(floor.with_material(rough(0.5)));
            let tower = [0.5, 1.5].map(|height| {
                let at = slope * Vec3::new(far + 0.13 * size, height * size, 0.07 * size);
                add_box(&mut world, Vec3::splat(size), 1.0, at, slope * turn(Vec3::Y, 0.3))
            });
            step(&mut world, 1.0);
            let from = centre(&world, tower[1]);
            step(&mut world, 2.0);
            let to = centre(&world, tower[1]);
            let (gone, height) = (to.distance(from), (slope.inverse() * to).y / size);
            let case = format!("{size} m on {cells} cells at {far} m, slope {tilt}");
            // On a slope at a kilometre the height of a corner is rounded by 60 µm.
            let most = if far * tilt > 0.0 { 2e-4 } else { 1e-5 };
            assert!(gone < most && (height - 1.5).abs() < 0.01, "{case}: {gone}, {height}");
            assert_eq!(world.contact_cache.contacts.len(), 2, "{case}");
        }
    }
}

/// The points of a manifold are fixed to the two. Where a box leans on the rim of another and slides, it soon touches there with other points, which are
/// higher or lower: this box was thrown out of a rim in which it was half a millimetre deep already.
#[test]
fn a_manifold_sliding_over_a_rim_keeps_the_right_height() {
    let half = Vec3::splat(0.25);
    let shape = Shape::cuboid(half * 2.0).unwrap();
    let (size, reach) = (half.length(), 0.02);
    let content_hashes = [shape.content_hash(); 2];
    let key = ContactKey { a: 0, other: Other::BodyCollider(1), nth: 0 };
    let find = |frame: &Frame| {
        let mut found = None;
        let mut keep = |manifold: &Manifold| found = Some(*manifold);
        collide(&shape, &shape, frame, 2.0 * reach, &mut ManifoldScratch::default(), &mut keep);
        found.map(|manifold| CachedManifold {
            key,
            content_hashes,
            manifold,
            seen_from: *frame,
            reach: 2.0 * reach,
            friction_anchor: Default::default(),
        })
    };
    let height = |cached: &CachedManifold, here: &Frame| {
        let of = |point: &Point| cached.manifold.normal.dot(here.point(point.on_a) - point.on_b);
        cached.manifold.points().iter().map(of).fold(f32::INFINITY, f32::min)
    };
    let (mut slid, mut slides) = (0.0_f32, 0);
    for (lean, degrees) in [(0.03, 20.0), (0.06, 35.0), (0.09, 50.0_f32)] {
        let rotation = turn(Vec3::Y, degrees.to_radians()) * turn(Vec3::new(0.6, 0.0, 0.8), lean);
        for (dx, dz) in [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.7, -0.7), (0.7, 0.7)] {
            let at = |way: f32| Vec3::new(0.15 + dx * way, 0.51, 0.1 + dz * way);
            let frame = |way: f32| Frame::new(at(way), rotation);
            let Some(cached) = find(&frame(0.0)).filter(|cached| cached.manifold.slope > 0.0)
            else {
                continue;
            };
            for n in 0..2000 {
                let here = frame(1e-5 * n as f32);
                if cached.staleness(&here, (size, size), 0.0).is_none() {
                    break;
                }
                let now = find(&here).expect("it is as near as before");
                let wrong = (height(&cached, &here) - height(&now, &here)).abs();
                assert!(wrong < 2e-4 * size, "{wrong} m after {n} steps, {lean}, {dx} {dz}");
                slid = slid.max(1e-5 * n as f32);
            }
            slides += 1;
        }
    }
    assert!(slides > 5 && slid > 1e-3, "{slides} {slid}");
}
