//! Meshes against each other, and against themselves.

use glam::Vec3;

use super::{DT, Sheet, body, colliding, empty, entangled, particle};
use crate::collide::{BodyContacts, Collider, Frame, Shape};
use crate::constraints::Distance;
use crate::particles::ParticleSeed;

#[test]
fn edges_that_cross_in_the_air_keep_apart() {
    for surface in [true, false] {
        // Two upright strips fly at each other crosswise: no corner comes near a triangle.
        let mut world = empty(0.0);
        let contacts = BodyContacts { surface, ..colliding(false) };
        let strip = |along: Vec3, across: Vec3, height: f32| Sheet {
            cells: [3, 1],
            corner: Vec3::Y * height - along * 0.6 - across * 0.2,
            axes: [along, across],
            size: 0.4,
            contacts,
            ..Sheet::flat(1, 0.4, 0.0)
        };
        let upright = Vec3::Y;
        let low = strip(Vec3::X, upright, -0.3).build(&mut world, |_, _| false);
        let high = strip(Vec3::Z, upright, 0.3).build(&mut world, |_, _| false);
        for (rows, speed) in [(&low, 1.5), (&high, -1.5)] {
            for &row in rows {
                world.particles.set_velocity(row, Vec3::Y * speed);
            }
        }
        for _ in 0..60 {
            world.step(DT).unwrap();
            assert!(!surface || entangled(&world) == 0);
        }
        let height = |rows: &[usize]| {
            rows.iter().map(|&row| world.particles.position(row).y).sum::<f32>() / rows.len() as f32
        };
        let apart = height(&high) - height(&low);
        println!("surface {surface}: {apart:.3} m apart after a second");
        assert_eq!(apart > 0.0, surface, "{apart}");
    }
}

#[test]
fn a_coarse_cloth_dropped_over_another_hangs_on_it() {
    let mut world = empty(9.81);
    world.forces.drag = 0.5;
    let pinned = Sheet { radius: 0.01, ..Sheet::flat(4, 0.25, 0.0) };
    pinned.build(&mut world, |i, j| (i == 0 || i == 4) && (j == 0 || j == 4));
    let (sin, cos) = (0.5, 0.75_f32.sqrt());
    let axes = [Vec3::new(cos, 0.0, sin), Vec3::new(-sin, 0.1, cos).normalize()];
    let corner = (axes[0] + axes[1]) * -0.3 + Vec3::Y * 0.3;
    let loose = Sheet { axes, corner, radius: 0.01, ..Sheet::flat(3, 0.2, 0.0) };
    let rows = loose.build(&mut world, |_, _| false);
    let mut least = f32::MAX;
    for step in 0..240 {
        world.step(DT).unwrap();
        if step % 8 == 0 {
            assert_eq!(entangled(&world), 0, "step {step}");
        }
        least = rows.iter().map(|&row| world.particles.position(row).y).fold(least, f32::min);
    }
    println!("never below {least:.3} m");
    assert!(least > -0.6, "{least}");
}

#[test]
fn a_coarse_cloth_crumples_on_the_floor_and_not_through_itself() {
    for surface in [true, false] {
        let mut world = empty(9.81);
        let floor = Frame::at(Vec3::ZERO);
        world.colliders.push(Collider::fixed(Shape::half_space(), floor));
        let contacts = BodyContacts { surface, ..colliding(true) };
        // It stands on an edge, slightly tilted, and folds up as it falls.
        let axes = [Vec3::new(0.98, 0.0, 0.199), Vec3::new(0.1, 0.99, 0.09)];
        let corner = Vec3::new(-0.4, 0.03, 0.0);
        let sheet = Sheet { contacts, corner, axes, radius: 0.01, ..Sheet::flat(6, 0.15, 0.0) };
        let rows = sheet.build(&mut world, |_, _| false);
        for (k, &row) in rows.iter().enumerate() {
            let wave = (k / 7) as f32 * 2.1;
            world.particles.set_velocity(row, Vec3::new(0.0, 0.0, libm::sinf(wave)));
        }
        let mut most = 0;
        for _ in 0..240 {
            world.step(DT).unwrap();
            most = most.max(entangled(&world));
        }
        println!("surface {surface}: {most} edges through triangles at most");
        assert_eq!(most == 0, surface);
    }
}

#[test]
fn the_two_sides_of_a_fold_that_are_squeezed_do_not_pass() {
    // A sheet folded flat, and a heavy ball shot at it from above: the contacts of both layers and of the floor conflict.
    let mut world = empty(9.81);
    world.colliders.push(Collider::fixed(Shape::half_space(), Frame::at(Vec3::NEG_Y * 0.01)));
    let own = body(&mut world, colliding(true));
    let rest = [[0.0, 0.0], [0.3, 0.0], [0.6, 0.0], [0.0, 0.3], [0.3, 0.3], [0.6, 0.3]];
    let rows = rest.map(|[x, z]: [f32; 2]| {
        let upper = x > 0.5;
        let at = Vec3::new(if upper { 0.02 } else { x }, if upper { 0.06 } else { 0.0 }, z);
        let row = particle(&mut world, ParticleSeed::at(at).with_mass(0.01).with_radius(0.01), own);
        world.particles.set_rest(row, Some(Vec3::new(x, 0.0, z)));
        row as u32
    });
    let [a, b, c, d, e, f] = rows;
    world.forces.surfaces.extend([[a, b, d], [b, e, d], [b, c, e], [c, f, e]]);
    for (i, j) in [(a, b), (b, c), (d, e), (e, f), (a, d), (b, e), (c, f), (b, d), (c, e)] {
        let length = (world.particles.rest[i as usize] - world.particles.rest[j as usize]).length();
        world.distances_mut().push(Distance::new(i, j, length));
    }
    let other = body(&mut world, colliding(false));
    let seed = ParticleSeed::at(Vec3::new(0.12, 0.5, 0.13)).with_mass(5.0).with_radius(0.03);
    let ball = particle(&mut world, seed.with_velocity(Vec3::NEG_Y * 20.0), other);
    for step in 0..120 {
        world.step(DT).unwrap();
        assert_eq!(entangled(&world), 0, "step {step}");
    }
    assert!(world.particles.position(ball).y > -0.05);
}
