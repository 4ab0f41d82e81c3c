//! Invalid triangles, and worlds with NaN.

use glam::Vec3;

use super::{DT, Sheet, bits, body, colliding, empty, particle};
use crate::collide::BodyContacts;
use crate::particles::ParticleSeed;
use crate::simulation::Simulation;

/// A ball that falls on a sheet.
fn falling() -> (Simulation, Vec<usize>) {
    let mut world = empty(9.81);
    let mut rows = Sheet::flat(3, 0.2, 0.0).build(&mut world, |i, j| i == 0 || j == 3);
    let own = body(&mut world, colliding(false));
    let ball = ParticleSeed::at(Vec3::new(0.03, 0.1, 0.06)).with_mass(0.01).with_radius(0.01);
    rows.push(particle(&mut world, ball, own));
    (world, rows)
}

#[test]
fn what_is_no_triangle_changes_no_bit() {
    let (mut good, rows) = falling();
    let (mut world, _) = falling();
    let [a, b] = [rows[0] as u32, rows[1] as u32];
    // Rows out of range, repeated corners, corners of two bodies, of no body.
    let ball = *rows.last().unwrap() as u32;
    let nobody = world.particles.push(ParticleSeed::at(Vec3::Y * 3.0).pinned()).unwrap();
    good.particles.push(ParticleSeed::at(Vec3::Y * 3.0).pinned()).unwrap();
    let wrong = [[a, b, 9999], [a, a, b], [b, b, b], [a, b, ball], [a, b, nobody], [u32::MAX; 3]];
    world.forces.surfaces.splice(3..3, wrong);
    for _ in 0..60 {
        good.step(DT).unwrap();
        world.step(DT).unwrap();
    }
    assert!(bits(&good, &rows) == bits(&world, &rows));
}

#[test]
fn triangles_without_area_stop_what_meets_their_line_and_are_no_nan() {
    let mut world = empty(9.81);
    let own = body(&mut world, colliding(true));
    let at = [0.0, 0.3, 1.0, 0.3].map(|x| Vec3::new(x, 0.0, 0.0));
    for at in at {
        particle(&mut world, ParticleSeed::at(at).with_radius(0.01).pinned(), own);
    }
    // A line, and a triangle with two corners at one place.
    world.forces.surfaces.extend([[0, 1, 2], [1, 2, 3]]);
    let other = body(&mut world, colliding(false));
    let mut balls = [0.1, 0.3, 0.8].map(|x| {
        particle(&mut world, ParticleSeed::at(Vec3::new(x, 0.1, 1e-4)).with_radius(0.01), other)
    });
    balls.rotate_left(1);
    for _ in 0..10 {
        world.step(DT).unwrap();
    }
    assert!(balls.iter().all(|&ball| world.particles.position(ball).is_finite()));
    assert!(world.report().frozen.is_empty());
}

#[test]
fn a_sheet_with_a_corner_that_is_no_number_still_holds_by_its_others() {
    let (mut world, rows) = falling();
    // A corner far from the ball, set by the game.
    world.particles.set_position(rows[12], Vec3::NAN);
    for _ in 0..60 {
        world.step(DT).unwrap();
    }
    let ball = world.particles.position(*rows.last().unwrap());
    assert!(ball.is_finite() && ball.y > -0.3, "{ball}");
}

#[test]
fn a_body_that_touches_none_or_is_pinned_everywhere_does_nothing() {
    let lone = |contacts: BodyContacts| {
        let mut world = empty(9.81);
        Sheet { contacts, ..Sheet::flat(3, 0.2, 0.0) }.build(&mut world, |_, _| true);
        let own = body(&mut world, BodyContacts { with_itself: false, surface: false, ..contacts });
        let ball = ParticleSeed::at(Vec3::new(0.03, 0.1, 0.06)).with_radius(0.01);
        let ball = particle(&mut world, ball, own);
        for _ in 0..30 {
            world.step(DT).unwrap();
        }
        world.particles.position(ball).y
    };
    assert!(lone(colliding(false)) > 0.01, "pinned everywhere, it holds");
    assert!(
        lone(BodyContacts { with_bodies: false, ..colliding(false) }) < -1.0,
        "collides with nothing"
    );
    assert!(lone(BodyContacts { with_bodies: false, ..colliding(true) }) < -1.0, "itself alone");
    let layers = crate::collide::Layers::NONE;
    assert!(lone(BodyContacts { layers, ..colliding(false) }) < -1.0, "other layers");
}

#[test]
fn neighbours_in_the_rest_shape_are_left_alone() {
    // Particles far thicker than their cells: nothing moves.
    let mut world = empty(0.0);
    let sheet = Sheet { contacts: colliding(true), radius: 0.05, ..Sheet::flat(8, 0.02, 0.0) };
    let rows = sheet.build(&mut world, |_, _| false);
    for _ in 0..10 {
        world.step(DT).unwrap();
    }
    let moved = rows.iter().map(|&row| world.particles.velocity(row).length()).fold(0.0, f32::max);
    assert!(moved < 1e-4, "{moved} m/s");
}
