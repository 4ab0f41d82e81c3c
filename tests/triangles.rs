//! Bodies that collide by the triangles of their surface: a body with this contact shape gets it, a body without triangles is refused, and no state is kept
//! outside of components.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{BodyContacts, Refusal};
use bevy_sinew::{ContactShape, ParticleBody};

use crate::support::{app, heard, particles_of, position, tick};

#[test]
fn a_coarse_cloth_holds_a_marble_by_its_triangles_and_bodies_without_are_refused_once() {
    let run = |shape: ContactShape| {
        let mut app = app();
        let flat = Quat::from_rotation_x(-core::f32::consts::FRAC_PI_2);
        let cloth =
            Cloth { radius: 0.01, ..Cloth::grid(0.8, 0.8, 4, 4) }.pinned(ClothPins::Corners);
        let contacts = BodyContacts::default().shaped(shape);
        app.world_mut().spawn((cloth, contacts, Transform::from_rotation(flat)));
        let marble = (Particle::at(Vec3::new(0.07, 0.3, 0.11)), Mass(0.01), Radius(0.02));
        let marble = app.world_mut().spawn(marble).id();
        tick(&mut app, 90);
        assert_eq!(heard(&app), []);
        position(&app, marble).y
    };
    assert!(run(ContactShape::Triangles) > -0.4);
    assert!(run(ContactShape::Particles) < -2.0);
    assert!(run(ContactShape::Auto) > -0.4, "the default for this cloth");

    let mut app = app();
    let shaped = BodyContacts::default().shaped(ContactShape::Triangles);
    let rope = app.world_mut().spawn((Rope::default(), shaped)).id();
    let late = app.world_mut().spawn((ParticleBody, shaped)).id();
    tick(&mut app, 5);
    assert_eq!(
        heard(&app),
        [(rope, Refusal::NoTriangles)],
        "a body that is not built yet is not refused: {late}"
    );
}

#[test]
fn triangles_switched_on_or_torn_out_while_time_runs_hold_and_release() {
    let mut app = app();
    let flat = Quat::from_rotation_x(-core::f32::consts::FRAC_PI_2);
    let cloth = Cloth { radius: 0.01, ..Cloth::grid(0.8, 0.8, 4, 4) }.pinned(ClothPins::Corners);
    let corners = BodyContacts::default().shaped(ContactShape::Particles);
    let cloth = (cloth, corners, Transform::from_rotation(flat));
    let cloth = app.world_mut().spawn(cloth).id();
    let marble = (Particle::at(Vec3::new(0.07, 0.3, 0.11)), Mass(0.01), Radius(0.02));
    let marble = app.world_mut().spawn(marble).id();
    tick(&mut app, 5);
    app.world_mut().get_mut::<BodyContacts>(cloth).unwrap().shape = ContactShape::Triangles;
    tick(&mut app, 120);
    assert!(position(&app, marble).y > -0.4, "it was caught");
    // The particle nearest to it is torn out, and its triangles go with it.
    let at = position(&app, marble);
    let of = |app: &App, particle: Entity| position(app, particle).distance(at);
    let nearest = particles_of(&app, cloth)
        .into_iter()
        .min_by(|&a, &b| of(&app, a).total_cmp(&of(&app, b)))
        .unwrap();
    app.world_mut().despawn(nearest);
    tick(&mut app, 120);
    assert!(position(&app, marble).y < -1.0, "it fell through the hole");
}
