//! What a pointer grabs, how it holds it, and what it ignores. The pointer here has a ray in the world, but no window.

use bevy::camera::visibility::RenderLayers;
use bevy::picking::backend::ray::{RayId, RayMap};
use bevy::picking::backend::{HitData, PointerHits};
use bevy::picking::pointer::{PointerAction, PointerButton, PointerId};
use bevy::picking::{Pickable, PickingSystems};
use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{
    BodyConstraints, CreationOrder, Grab, MouseDrag, ParticleOf, SinewSnapshot, WorldCenterOfMass,
};
use sinew_tests::pointer::{self, Aim, act, aim};

fn app() -> App {
    pointer::app(())
}

fn input(app: &mut App, action: PointerAction) {
    act(app, action, Vec2::splat(50.0));
    app.update();
}

/// Presses at the pointer. Returns the grab.
fn press(app: &mut App) -> Option<Grab> {
    input(app, PointerAction::Press(PointerButton::Primary));
    app.world().resource::<MouseDrag>().grabbed.clone()
}

fn run(app: &mut App, ticks: usize) {
    (0..ticks).for_each(|_| app.update());
}

/// The grabbed point now.
fn anchor_at(app: &App, grab: &Grab) -> Vec3 {
    let place =
        |(one, share): &(Entity, f32)| app.world().get::<Particle>(*one).unwrap().position * *share;
    grab.anchor.iter().map(place).sum()
}

/// Number of particles, bodies and constraints.
fn count(app: &mut App) -> usize {
    app.world_mut().query::<&CreationOrder>().iter(app.world()).count()
}

#[test]
fn a_click_on_a_face_grabs_the_crate_at_that_point() {
    let mut app = app();
    app.world_mut().spawn(RigidBox::new(Vec3::splat(2.0)).with_mass(20.0));
    run(&mut app, 2);
    let before = count(&mut app);
    aim(&mut app, 0.3, 0.2);
    let grab = press(&mut app).expect("its face is under the pointer");
    let caught = Vec3::new(0.3, 0.2, 1.0);
    assert!(grab.target.distance(caught) < 1e-3, "{}", grab.target);
    assert!(anchor_at(&app, &grab).distance(caught) < 1e-3, "{}", anchor_at(&app, &grab));
    // The body follows by that point, and turns no more than it must.
    aim(&mut app, 2.3, 1.2);
    run(&mut app, 240);
    let held = anchor_at(&app, &grab);
    assert!(held.distance(Vec3::new(2.3, 1.2, 1.0)) < 0.02, "{held}");
    assert_eq!(count(&mut app), before + 3, "a constraint along each axis holds it");
    input(&mut app, PointerAction::Release(PointerButton::Primary));
    assert_eq!(app.world().resource::<MouseDrag>().grabbed, None);
    run(&mut app, 2);
    assert_eq!(count(&mut app), before, "nothing of it is left");
}

#[test]
fn a_press_in_a_pause_holds_nothing_and_changes_no_state() {
    let mut app = app();
    app.world_mut().spawn(RigidBox::new(Vec3::splat(2.0)));
    run(&mut app, 2);
    app.world_mut().resource_mut::<SinewControl>().pause();
    run(&mut app, 2);
    let hash = |app: &App| SinewSnapshot::capture(app.world()).hash();
    let before = hash(&app);
    assert!(press(&mut app).is_some(), "it is caught all the same");
    run(&mut app, 2);
    assert_eq!(hash(&app), before);
    // It is held from the first simulated tick on.
    let there = count(&mut app);
    app.world_mut().resource_mut::<SinewControl>().step();
    run(&mut app, 1);
    assert_eq!(count(&mut app), there + 3);
    app.world_mut().resource_mut::<SinewControl>().unpause();
    input(&mut app, PointerAction::Release(PointerButton::Primary));
    run(&mut app, 2);
    assert_eq!(count(&mut app), there);
}

#[test]
fn every_kind_of_body_is_grabbed_at_its_visible_surface() {
    let spawns: [(&str, fn(&mut World) -> Entity); 5] = [
        ("a box", |w| w.spawn(RigidBox::default()).id()),
        ("a cloth", |w| w.spawn(Cloth::grid(1.0, 1.0, 3, 3)).id()),
        ("a soft body", |w| w.spawn(SoftBody::cuboid(Vec3::ONE, UVec3::splat(3))).id()),
        ("a figure", |w| w.spawn((Ragdoll::default(), Transform::from_xyz(0.0, -1.2, 0.0))).id()),
        ("a ball", |w| w.spawn((Particle::at(Vec3::ZERO), Radius(0.3))).id()),
    ];
    for (name, spawn) in spawns {
        let mut app = app();
        let body = spawn(app.world_mut());
        run(&mut app, 2);
        aim(&mut app, 0.06, 0.05);
        let grab = press(&mut app).unwrap_or_else(|| panic!("{name} is under the pointer"));
        let shares: f32 = grab.anchor.iter().map(|one| one.1).sum();
        assert!((shares - 1.0).abs() < 1e-4, "{name}: {shares}");
        let owner = |one: Entity| app.world().get::<ParticleOf>(one).map_or(one, |of| of.0);
        assert!(grab.anchor.iter().all(|&(one, _)| owner(one) == body), "{name}");
        let off = anchor_at(&app, &grab) - grab.target;
        assert!(off.truncate().length() < 0.35, "{name}: {off}");
    }
}

#[test]
fn a_rope_is_grabbed_near_the_pointer_but_not_behind_a_wall() {
    let mut app = app();
    app.world_mut().spawn(Rope { pin_end: true, ..Rope::between(-Vec3::X, Vec3::X) });
    run(&mut app, 2);
    aim(&mut app, 0.0, 0.2);
    assert!(press(&mut app).is_some(), "2 degrees are 35 cm here");
    input(&mut app, PointerAction::Release(PointerButton::Primary));
    aim(&mut app, 0.0, 0.8);
    assert_eq!(press(&mut app), None, "that is too far off");
    let wall = Collider::cuboid(Vec3::new(4.0, 4.0, 0.1));
    app.world_mut().spawn((wall, Transform::from_xyz(0.0, 0.0, 2.0)));
    run(&mut app, 2);
    aim(&mut app, 0.0, 0.0);
    assert_eq!(press(&mut app), None, "a wall is in front of it");
}

#[test]
fn a_press_on_an_entity_in_front_grabs_nothing() {
    let mut app = app();
    app.world_mut().spawn(RigidBox::default());
    let button = app.world_mut().spawn_empty().id();
    // As a UI backend reports it: in every frame.
    app.add_systems(
        PreUpdate,
        (move |mut hits: MessageWriter<PointerHits>, cameras: Query<Entity, With<Camera>>| {
            let data = HitData::new(cameras.single().unwrap(), 0.0, None, None);
            hits.write(PointerHits::new(PointerId::Mouse, vec![(button, data)], 0.5));
        })
        .in_set(PickingSystems::Backend),
    );
    run(&mut app, 2);
    assert_eq!(press(&mut app), None);
    // A decoration that is drawn over everything, but lets presses through.
    app.world_mut().entity_mut(button).insert(Pickable::IGNORE);
    assert!(press(&mut app).is_some());
}

/// Found by driving the gallery's window: a click on a rope grabbed a lantern elsewhere, by a ray of the camera that egui draws with, which is a kilometre
/// away, so that anything within forty metres of its ray was near enough.
#[test]
fn a_camera_without_render_layers_grabs_nothing() {
    let mut app = app();
    let body = app.world_mut().spawn(RigidBox::default()).id();
    app.world_mut().spawn((RigidBox::default(), Transform::from_xyz(20.0, 0.0, 0.0)));
    let above = Camera { order: 1, ..default() };
    let above = app.world_mut().spawn((above, RenderLayers::none())).id();
    app.add_systems(
        PreUpdate,
        (move |mut rays: ResMut<RayMap>| {
            let ray = Ray3d::new(Vec3::new(5.0, 0.0, 1000.0), Dir3::NEG_Z);
            rays.map.insert(RayId::new(above, PointerId::Mouse), ray);
        })
        .after(RayMap::repopulate)
        .before(PickingSystems::Backend),
    );
    run(&mut app, 2);
    let grab = press(&mut app).expect("the crate in the middle");
    assert!(
        grab.anchor
            .iter()
            .all(|&(one, _)| { app.world().get::<ParticleOf>(one).is_some_and(|of| of.0 == body) })
    );
}

#[test]
fn a_hit_of_another_backend_on_the_bodys_mesh_does_not_block_a_grab() {
    let mut app = app();
    let body = app.world_mut().spawn(RigidBox::default()).id();
    // Its mesh, a child of the body that is nearer than the shape.
    let skin = app.world_mut().spawn(ChildOf(body)).id();
    app.add_systems(
        PreUpdate,
        (move |mut hits: MessageWriter<PointerHits>, cameras: Query<Entity, With<Camera>>| {
            let data = HitData::new(cameras.single().unwrap(), 1.0, None, None);
            hits.write(PointerHits::new(PointerId::Mouse, vec![(skin, data)], 0.0));
        })
        .in_set(PickingSystems::Backend),
    );
    run(&mut app, 2);
    assert!(press(&mut app).is_some());
}

#[test]
fn another_button_or_none_grabs_nothing() {
    let mut app = app();
    app.world_mut().spawn(RigidBox::default());
    run(&mut app, 2);
    input(&mut app, PointerAction::Press(PointerButton::Secondary));
    assert_eq!(app.world().resource::<MouseDrag>().grabbed, None);
    app.world_mut().resource_mut::<MouseDrag>().button = None;
    assert_eq!(press(&mut app), None);
}

#[test]
fn light_and_heavy_bodies_follow_equally_fast() {
    let way = |mass: f32| {
        let mut app = app();
        let body = app.world_mut().spawn(RigidBox::default().with_mass(mass)).id();
        run(&mut app, 2);
        press(&mut app).expect("it is there");
        aim(&mut app, 1.0, 0.0);
        run(&mut app, 12);
        app.world().get::<WorldCenterOfMass>(body).unwrap().position
    };
    let (light, heavy) = (way(0.1), way(1000.0));
    assert!(light.x > 0.3, "{light}");
    assert!((light - heavy).length() < 0.02, "{light} {heavy}");
}

#[test]
fn a_grabbed_crate_hangs_from_the_pointer_and_is_not_turned_by_the_grab() {
    let mut app = app();
    let body = app.world_mut().spawn(RigidBox::default().with_mass(20.0)).id();
    run(&mut app, 2);
    aim(&mut app, 0.2, 0.3);
    let grab = press(&mut app).expect("its face is there");
    run(&mut app, 60);
    let speed = app.world().get::<LinearVelocity>(body).unwrap().0.length();
    let spin = app.world().get::<AngularVelocity>(body).unwrap().0.length();
    assert!(speed < 1e-3 && spin < 1e-3, "{speed} {spin}");
    app.insert_resource(Gravity(Vec3::NEG_Y * 9.81));
    app.insert_resource(AirDrag(0.9));
    run(&mut app, 300);
    // It sags by g/ω² = 5 cm.
    let held = anchor_at(&app, &grab);
    assert!((held - grab.target).length() < 0.1, "{held}");
    let middle = app.world().get::<WorldCenterOfMass>(body).unwrap().position;
    assert!(middle.y < held.y, "it hangs from the hand");
}

#[test]
fn a_grab_ends_when_its_body_is_despawned() {
    let mut app = app();
    let body = app.world_mut().spawn(RigidBox::default()).id();
    run(&mut app, 2);
    press(&mut app).expect("it is there");
    run(&mut app, 2);
    app.world_mut().despawn(body);
    run(&mut app, 5);
    assert_eq!(count(&mut app), 0);
    assert!(app.world_mut().query::<&BodyConstraints>().iter(app.world()).next().is_none());
}

/// Index of the ball that a press grabs. Each ball is given by its place relative to the pointer, which points along -z, and its radius, metres; a wall is at
/// the given depth.
fn taken_of(balls: &[(Vec3, f32)], wall: Option<f32>) -> Option<usize> {
    let mut app = app();
    let eye = Vec3::Z * 10.0;
    let world = app.world_mut();
    let spawn = |&(place, radius): &(Vec3, f32)| {
        world.spawn((Particle::at(eye + place), Radius(radius))).id()
    };
    let all: Vec<Entity> = balls.iter().map(spawn).collect();
    if let Some(depth) = wall {
        let place = Transform::from_xyz(0.0, 0.0, eye.z - depth);
        app.world_mut().spawn((Collider::cuboid(Vec3::new(4.0, 4.0, 0.1)), place));
    }
    app.insert_resource(Aim(Ray3d::new(eye, Dir3::NEG_Z)));
    run(&mut app, 2);
    let grab = press(&mut app)?;
    assert_eq!(grab.anchor.len(), 1, "{grab:?}");
    all.iter().position(|&one| one == grab.anchor[0].0)
}

#[test]
fn the_pointer_grabs_the_nearest_particle_under_it() {
    let near = (Vec3::new(0.01, 0.0, -2.0), 0.0);
    let far = (Vec3::new(0.0, 0.0, -6.0), 0.0);
    let behind = (Vec3::Z, 0.9);
    let aside = (Vec3::new(1.0, 0.0, -2.0), 0.1);
    assert_eq!(taken_of(&[behind, far, aside, near], None), Some(3));
    assert_eq!(taken_of(&[behind, aside], None), None);
    assert_eq!(taken_of(&[far], None), Some(0));
    assert_eq!(taken_of(&[far], Some(5.0)), None, "something stands before it");
    let ball = (Vec3::new(0.4, 0.0, -2.0), 0.5);
    assert_eq!(taken_of(&[ball], None), Some(0), "a ball is as wide as it is");
    let beside = (Vec3::new(0.55, 0.0, -2.0), 0.5);
    assert_eq!(taken_of(&[beside], None), Some(0), "and as near beside the pointer");
}
