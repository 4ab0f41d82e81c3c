//! Missed pairs: a body collider that is thrown out of its swept bounds within a step collides with shapes that are not among its pairs.

use super::*;

/// Obstacles with a face at x = 0.7 m.
fn obstacles() -> [Shape; 4] {
    let half = Vec3::new(0.1, 3.0, 3.0);
    let wall = Shape::cuboid(half * 2.0).unwrap();
    let mut vertices = Vec::new();
    let mut triangles = Vec::new();
    for n in 0..49 {
        vertices.push(Vec3::new(-0.1, (n / 7) as f32 - 3.0, (n % 7) as f32 - 3.0));
        if n / 7 < 6 && n % 7 < 6 {
            triangles.extend([[n, n + 1, n + 7], [n + 7, n + 1, n + 8]]);
        }
    }
    let corners = [-0.1, 0.1].map(|x| {
        [(-3.0, -3.0), (3.0, -3.0), (3.0, 3.0), (-3.0, 3.0)].map(|(y, z)| Vec3::new(x, y, z))
    });
    let hull = Shape::hull(&corners.concat()).unwrap();
    [wall, Shape::mesh(vertices, triangles).unwrap(), hull, Shape::half_space()]
}

#[test]
fn a_struck_body_does_not_pass_through_an_obstacle() {
    for (number, shape) in obstacles().into_iter().enumerate() {
        let mut world = world();
        world.forces.gravity = Vec3::ZERO;
        set_material(&mut world, rough(0.3));
        let frame = match number {
            // A half-space is solid below its plane; turned, towards greater x.
            3 => Frame::new(Vec3::X * 0.7, turn(Vec3::Z, core::f32::consts::FRAC_PI_2)),
            _ => Frame::at(Vec3::X * 0.8),
        };
        world.colliders.push(Collider::fixed(shape, frame));
        // 40 m/s are 0.67 m in a step; the struck box gets half of that, for nearly all of the step.
        let at = Vec3::new(0.28, 0.07, 0.03);
        let thrown = add_box(&mut world, Vec3::splat(0.2), 1.0, at, Quat::IDENTITY);
        let struck = add_box(&mut world, Vec3::splat(0.2), 1.0, Vec3::X * 0.5, Quat::IDENTITY);
        throw(&mut world, thrown, Vec3::X * 40.0, Vec3::ZERO);
        let mut fastest = 0.0_f32;
        for tick in 0..60 {
            world.step(1.0 / 60.0).unwrap();
            fastest = fastest.max(velocity(&world, struck).length());
            for i in 0..world.particles.len() {
                let x = world.particles.position(i).x;
                assert!(x < 0.72, "obstacle {number}, tick {tick}: {x}");
            }
            let contacts = &world.contact_cache.contacts;
            assert!(contacts.windows(2).all(|two| two[0].key < two[1].key));
        }
        assert!(fastest > 0.5, "it must have been struck: {fastest}");
    }
}

#[test]
fn a_struck_body_strikes_the_next_one() {
    // A row of boxes with gaps of 5 cm: within one step an impact passes from one to the next.
    let mut world = world();
    world.forces.gravity = Vec3::ZERO;
    set_material(&mut world, rough(0.0));
    let row: Vec<usize> = (0..6)
        .map(|k| {
            let at = Vec3::X * (0.25 * k as f32);
            add_box(&mut world, Vec3::splat(0.2), 1.0, at, Quat::IDENTITY)
        })
        .collect();
    throw(&mut world, row[0], Vec3::X * 40.0, Vec3::ZERO);
    for _ in 0..30 {
        world.step(1.0 / 60.0).unwrap();
        for two in row.windows(2) {
            let apart = centre(&world, two[1]).x - centre(&world, two[0]).x;
            assert!(apart > 0.18, "{apart}");
        }
    }
    // The sum of momenta is the initial one.
    let sum: f32 = row.iter().map(|&first| velocity(&world, first).x).sum();
    assert!((sum - 40.0).abs() < 0.01, "{sum}");
    assert!(row.iter().all(|&first| velocity(&world, first).x > 3.0));
}
