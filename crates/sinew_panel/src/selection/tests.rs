//! Selection by the pointer, the values shown, and that showing them changes nothing.

use bevy::ecs::system::RunSystemOnce;
use bevy::prelude::*;
use bevy_egui::egui;
use bevy_sinew::prelude::*;
use bevy_sinew::{ContactStarted, RigidIntegrator, SinewSnapshot, SleepingDisabled};
use sinew_tests::pointer::{self, act, aim};

use super::*;
use crate::recording::{RecordWhen, Recording, RecordingConfig};
use crate::tests::{click_text, draw_with, find_text};
use crate::{PanelSide, SinewPanelPlugin};

fn app() -> App {
    pointer::app(SinewPanelPlugin::embedded())
}

/// A frame in which the panel is drawn.
fn frame(app: &mut App, ctx: &egui::Context) -> egui::FullOutput {
    let (output, _) = draw_with(app, ctx, PanelSide::Right, Vec::new());
    app.update();
    output
}

fn input(app: &mut App, ctx: &egui::Context, action: PointerAction, at: Vec2) {
    act(app, action, at);
    frame(app, ctx);
}

/// Clicks where a ray through (x, y) along −z hits; the pointer moves by `moved` pixels meanwhile.
fn click_at(app: &mut App, ctx: &egui::Context, x: f32, y: f32, moved: f32) {
    aim(app, x, y);
    let (button, at) = (PointerButton::Primary, Vec2::splat(50.0));
    input(app, ctx, PointerAction::Press(button), at);
    input(app, ctx, PointerAction::Release(button), at + Vec2::X * moved);
}

fn selected(app: &App) -> Option<Entity> {
    app.world().resource::<Selection>().body
}

fn readout(app: &mut App) -> Readout {
    let read = |selection: Res<Selection>, selected: Selected, world: Res<SinewWorld>| {
        selected.readout(&world, selection.body?)
    };
    app.world_mut().run_system_once(read).unwrap().expect("something is selected")
}

#[test]
fn a_press_selects_and_a_click_into_the_void_or_the_key_does_not() {
    let ctx = egui::Context::default();
    let mut app = app();
    let crate_ = app.world_mut().spawn(RigidBox::new(Vec3::splat(2.0))).id();
    let at = Transform::from_xyz(4.0, -1.0, 0.0);
    let rope = Rope::between(Vec3::new(0.0, 0.0, 0.0), Vec3::new(0.0, 2.0, 0.0));
    let rope = app.world_mut().spawn((rope, at)).id();
    let ball = (Particle::at(Vec3::new(-4.0, 0.0, 0.0)), Radius(0.3), Mass(2.0));
    let ball = app.world_mut().spawn(ball).id();
    (0..3).for_each(|_| _ = frame(&mut app, &ctx));
    for (x, body) in [(0.3, crate_), (4.0, rope), (-4.0, ball)] {
        click_at(&mut app, &ctx, x, 0.2, 0.0);
        assert_eq!(selected(&app), Some(body), "at {x}");
        assert_eq!(app.world().resource::<WatchedContacts>().body, Some(body));
    }
    // Turning the camera is a press on empty space and a move.
    click_at(&mut app, &ctx, 40.0, 40.0, 30.0);
    assert_eq!(selected(&app), Some(ball));
    click_at(&mut app, &ctx, 40.0, 40.0, 2.0);
    assert_eq!(selected(&app), None);

    click_at(&mut app, &ctx, 0.3, 0.2, 0.0);
    assert_eq!(selected(&app), Some(crate_));
    let mut keys = ButtonInput::<KeyCode>::default();
    keys.press(KeyCode::Escape);
    app.insert_resource(keys);
    frame(&mut app, &ctx);
    assert_eq!(selected(&app), None);
    app.insert_resource(ButtonInput::<KeyCode>::default());

    // A despawned body is shown as gone, and a hidden panel selects nothing.
    click_at(&mut app, &ctx, 0.3, 0.2, 0.0);
    app.world_mut().despawn(crate_);
    let output = frame(&mut app, &ctx);
    assert!(find_text(&output, "It was despawned").is_some());
    app.world_mut().resource_mut::<Selection>().clear();
    aim(&mut app, 4.0, 0.2);
    act(&mut app, PointerAction::Press(PointerButton::Primary), Vec2::splat(50.0));
    app.update();
    assert_eq!(selected(&app), None);
}

#[test]
fn the_numbers_are_those_of_the_body() {
    let ctx = egui::Context::default();
    let mut app = app();
    // Thrown with a spin about a principal axis, without contacts: a box of particles at its corners has the moment m/4 (a² + b²) about c.
    app.insert_resource(AirDrag(0.0));
    let (size, spin) = (Vec3::new(0.4, 0.6, 0.8), Vec3::new(0.0, 0.0, 3.0));
    let motion = (LinearVelocity(Vec3::new(1.0, 2.0, -1.0)), AngularVelocity(spin));
    let thrown = app.world_mut().spawn((RigidBox::new(size).with_mass(6.0), motion)).id();
    app.world_mut().resource_mut::<Selection>().select(thrown);
    (0..20).for_each(|_| _ = frame(&mut app, &ctx));
    let read = readout(&mut app);
    let close = |a: f64, b: f64| (a - b).abs() <= 2e-3 * b.abs();
    assert_eq!((read.particles, read.constraints), (8, 28));
    assert!(close(read.mass.into(), 6.0));
    assert!(read.velocity.distance(Vec3::new(1.0, 2.0, -1.0)) < 1e-3, "{}", read.velocity);
    assert!(read.spin.distance(spin) < 0.01, "{}", read.spin);
    let about_z = 6.0 / 4.0 * (0.4 * 0.4 + 0.6 * 0.6);
    assert!(close(read.inertia.z_axis.z.into(), about_z), "{}", read.inertia);
    assert!(close(read.angular_momentum.z.into(), about_z * 3.0), "{}", read.angular_momentum);
    assert!(close(read.of_centre, 0.5 * 6.0 * 6.0), "{}", read.of_centre);
    assert!(close(read.of_spin, 0.5 * about_z * 9.0), "{}", read.of_spin);
    assert!(close(read.kinetic, read.of_centre + read.of_spin), "{read:?}");
    assert!(read.centre.distance(Vec3::new(1.0, 2.0, -1.0) * 20.0 / 64.0) < 0.1, "{}", read.centre);
    let output = frame(&mut app, &ctx);
    for text in ["RigidBox", "6.0000", "kg·m²/s", "rad/s", "Cut the nearest rod"] {
        assert!(find_text(&output, text).is_some(), "{text}");
    }
}

#[test]
fn looking_at_a_body_and_its_contacts_changes_no_bit() {
    let ctx = egui::Context::default();
    let run = |looked: bool| {
        let mut app = app();
        app.insert_resource(Gravity::default());
        app.world_mut().spawn(Ground);
        let stack = [0.2, 0.61, 1.1].map(|y| {
            let body = (RigidBox::new(Vec3::splat(0.4)), Transform::from_xyz(0.0, y, 0.0));
            app.world_mut().spawn((body, Sleep::default())).id()
        });
        let mut touched = 0;
        for i in 0..90 {
            if looked {
                // From one body to the next, and to none.
                let body = (i % 40 < 30).then(|| stack[i / 40]);
                app.world_mut().resource_mut::<Selection>().body = body;
                frame(&mut app, &ctx);
                let world = app.world().resource::<SinewWorld>();
                touched += body.map_or(0, |body| contacts(world, body).count());
            } else {
                app.update();
            }
        }
        let told = app.world().resource::<Messages<ContactStarted>>().len();
        (SinewSnapshot::capture(app.world()).hash(), touched, told)
    };
    let ((seen, touched, told), (unseen, ..)) = (run(true), run(false));
    assert!(touched > 40, "{touched}");
    assert_eq!((seen, told), (unseen, 0));
}

#[test]
fn contacts_say_whom_it_touches_and_how_hard() {
    let ctx = egui::Context::default();
    let mut app = app();
    app.insert_resource(Gravity::default());
    let ground = app.world_mut().spawn((Ground, Name::new("floor"))).id();
    let at = Transform::from_xyz(0.0, 0.2, 0.0);
    // A sleeping body is not solved and has no contacts to show.
    let body = (RigidBox::new(Vec3::splat(0.4)).with_mass(5.0), SleepingDisabled, at);
    let body = app.world_mut().spawn(body).id();
    app.world_mut().resource_mut::<Selection>().select(body);
    (0..60).for_each(|_| _ = frame(&mut app, &ctx));
    let world = app.world().resource::<SinewWorld>();
    let all: Vec<_> = contacts(world, body).collect();
    assert_eq!(all.iter().map(|one| one.0).collect::<Vec<_>>(), [Some(ground)]);
    // The impulse of a tick carries the weight: m g h, with h the duration of a tick.
    let carried = 5.0 * 9.81 / 64.0;
    assert!((all[0].1.impulse - carried).abs() < 0.05 * carried, "{:?}", all[0]);
    let output = frame(&mut app, &ctx);
    assert!(find_text(&output, "floor").is_some());
}

#[test]
fn what_is_nearest_to_the_click_is_cut_and_only_that() {
    let ctx = egui::Context::default();
    let mut app = app();
    let rope = Rope { segments: 8, ..Rope::between(Vec3::ZERO, Vec3::X * 4.0) };
    let rope = app.world_mut().spawn(rope).id();
    (0..2).for_each(|_| _ = frame(&mut app, &ctx));
    let rods = |app: &App| {
        let list = app.world().get::<BodyConstraints>(rope).unwrap();
        let rods = list.iter().filter_map(|one| app.world().get::<DistanceConstraint>(one));
        rods.map(|rod| (rod.a, rod.b)).collect::<Vec<_>>()
    };
    let before = rods(&app);
    click_at(&mut app, &ctx, 2.7, 0.0, 0.0);
    let find = |selection: Res<Selection>, selected: Selected| selected.nearest(&selection);
    let nearest = app.world_mut().run_system_once(find).unwrap().expect("a rope has rods");
    let [a, b] = nearest.ends.map(|end| end.x);
    // A rope is grabbed at a particle: the one at 2.5 m.
    assert!((a - 2.5).abs() < 0.01 || (b - 2.5).abs() < 0.01, "{nearest:?}");
    let rod = app.world().get::<DistanceConstraint>(nearest.constraint).unwrap();
    let cut = (rod.a, rod.b);
    click_text(&mut app, &ctx, "Cut the nearest rod");
    let after = rods(&app);
    assert_eq!(after.len(), before.len() - 1);
    assert!(!after.contains(&cut));
    assert_eq!(selected(&app), Some(rope), "a click on the panel selects nothing else");
}

#[test]
fn it_sleeps_wakes_and_changes_what_it_moves_as() {
    let ctx = egui::Context::default();
    let mut app = app();
    let body = app.world_mut().spawn((RigidBox::new(Vec3::ONE), Sleep::default())).id();
    app.world_mut().resource_mut::<Selection>().select(body);
    (0..60).for_each(|_| _ = frame(&mut app, &ctx));
    let output = frame(&mut app, &ctx);
    assert!(find_text(&output, "asleep").is_some());
    click_text(&mut app, &ctx, "Wake");
    let still = app.world().get::<Sleep>(body).unwrap();
    assert!(!still.asleep && still.still < 0.2, "{still:?}");
    assert_eq!(readout(&mut app).representation, Some(Representation::default()));
    app.world_mut().entity_mut(body).insert(Representation::Rigid(RigidIntegrator::Verlet));
    let output = frame(&mut app, &ctx);
    assert!(find_text(&output, "Rigid, Verlet").is_some());
}

#[test]
fn a_body_that_came_back_under_another_id_is_still_selected() {
    let ctx = egui::Context::default();
    let mut app = app();
    let mut config = app.world_mut().resource_mut::<RecordingConfig>();
    (config.when, config.max_microseconds) = (RecordWhen::Always, u32::MAX);
    let body = app.world_mut().spawn((RigidBox::new(Vec3::ONE), Name::new("box"))).id();
    (0..5).for_each(|_| _ = frame(&mut app, &ctx));
    app.world_mut().despawn(body);
    (0..3).for_each(|_| _ = frame(&mut app, &ctx));
    // As in a game that kept the old id.
    app.world_mut().resource_mut::<Recording>().go_to(3);
    app.world_mut().resource_mut::<Selection>().select(body);
    app.update();
    frame(&mut app, &ctx);
    let now = selected(&app).expect("it is there again");
    assert_ne!(now, body);
    assert_eq!(app.world().get::<Name>(now).map(Name::as_str), Some("box"));
}
