//! Key and pointer events in a world without a window.

use bevy::asset::AssetPlugin;
use bevy::input::keyboard::{Key, KeyboardInput};
use bevy::input::{ButtonState, InputPlugin};
use bevy_egui::egui;
use bevy_sinew::prelude::*;
use bevy_sinew::{BodyParticles, SinewSnapshot, TubeMesh, WindSurface};
use sinew_panel::style;
use sinew_scenes::{InScene, ScenesPlugin, Skin};
use sinew_tests::pointer::{self, act, aim};

use super::*;

/// The playground, emptied and without gravity. The pointer's ray points along -z from 10 m away.
fn app() -> App {
    let mut app = pointer::app(|app: &mut App| {
        app.add_plugins((AssetPlugin::default(), InputPlugin)).init_asset::<Mesh>();
        app.add_plugins(ScenesPlugin);
        add(app);
    });
    let scene = sinew_scenes::find(SCENE).unwrap();
    sinew_scenes::load(app.world_mut(), scene);
    let mut all = app.world_mut().query_filtered::<Entity, With<InScene>>();
    let all: Vec<Entity> = all.iter(app.world()).collect();
    for entity in all {
        app.world_mut().try_despawn(entity).ok();
    }
    app.insert_resource(bevy_sinew::Gravity(Vec3::ZERO));
    app.insert_resource(bevy_sinew::AirDrag(0.0));
    run(&mut app, 2);
    app
}

fn run(app: &mut App, ticks: usize) {
    (0..ticks).for_each(|_| app.update());
}

fn press(app: &mut App, key: KeyCode, state: ButtonState) {
    app.world_mut().write_message(KeyboardInput {
        key_code: key,
        logical_key: Key::Unidentified(bevy::input::keyboard::NativeKey::Unidentified),
        state,
        text: None,
        repeat: false,
        window: Entity::PLACEHOLDER,
    });
    app.update();
}

/// Presses and releases a key, with the pointer over (x, y).
fn key(app: &mut App, key: KeyCode, x: f32, y: f32) {
    aim(app, x, y);
    press(app, key, ButtonState::Pressed);
    press(app, key, ButtonState::Released);
}

fn button(app: &mut App, action: PointerAction, x: f32, y: f32) {
    aim(app, x, y);
    act(app, action, Vec2::splat(50.0));
    app.update();
}

const DOWN: PointerAction = PointerAction::Press(PointerButton::Primary);
const UP: PointerAction = PointerAction::Release(PointerButton::Primary);

/// All entities with this name.
fn named(app: &mut App, name: &str) -> Vec<Entity> {
    let mut all = app.world_mut().query::<(Entity, &Name)>();
    all.iter(app.world()).filter(|(_, its)| its.as_str() == name).map(|(one, _)| one).collect()
}

fn place(app: &App, entity: Entity) -> Vec3 {
    app.world().get::<Transform>(entity).unwrap().translation
}

fn message(app: &App) -> &str {
    &app.world().resource::<Tools>().message
}

/// A crate of 1 m with this name, centred at a point in the plane z = 0.
fn crate_at(app: &mut App, name: &'static str, x: f32, y: f32) -> Entity {
    let body = (RigidBox::new(Vec3::ONE).with_mass(2.0), Transform::from_xyz(x, y, 0.0));
    let body = app.world_mut().spawn((InScene, Name::new(name), body)).id();
    run(app, 2);
    body
}

#[test]
fn each_key_spawns_its_toy_on_what_the_pointer_is_over_and_else_in_front_of_the_camera() {
    for (i, toy) in Toy::ALL.into_iter().enumerate() {
        let mut app = app();
        let (tool, bound) = TOOLS[i];
        assert_eq!(tool, Tool::Spawn(toy));
        key(&mut app, bound, 0.0, 0.0);
        run(&mut app, 2);
        let [body] = named(&mut app, toy.name())[..] else { panic!("{toy:?}: one") };
        assert!(place(&app, body).with_y(0.0).distance(Vec3::Z * 5.0) < 1e-3, "{toy:?}");
        let members = app.world().get::<BodyParticles>(body).unwrap();
        assert!(!members.is_empty(), "{toy:?} is built");
        app.world_mut().despawn(body);

        let wall = (Collider::cuboid(Vec3::ONE), Transform::default());
        app.world_mut().spawn((InScene, wall));
        run(&mut app, 2);
        key(&mut app, bound, 0.2, 0.1);
        run(&mut app, 1);
        let [body] = named(&mut app, toy.name())[..] else { panic!("{toy:?}: one") };
        let off = place(&app, body) - Vec3::new(0.2, 0.1, 0.5);
        assert!(off.with_y(0.0).length() < 0.05 && off.y > 0.0, "{toy:?}: {off}");
    }
}

#[test]
fn a_pin_holds_a_crate_by_the_point_that_was_pressed_and_the_same_lets_it_go() {
    let mut app = app();
    let body = crate_at(&mut app, "crate", 0.0, 0.0);
    key(&mut app, KeyCode::KeyP, 0.3, 0.2);
    assert!(message(&app).starts_with("Pinned"), "{}", message(&app));
    app.insert_resource(bevy_sinew::Gravity::default());
    run(&mut app, 90);
    let pinned = Vec3::new(0.3, 0.2, 0.5);
    let local = app.world().get::<Transform>(body).unwrap().transform_point(pinned);
    assert!(local.distance(pinned) < 0.01, "{local}");
    key(&mut app, KeyCode::KeyP, 0.3, 0.2);
    assert_eq!(message(&app), "Unpinned.");
    run(&mut app, 60);
    assert!(place(&app, body).y < -3.0, "{}", place(&app, body));
    assert!(named(&mut app, "pin").is_empty());
}

#[test]
fn a_rod_keeps_two_crates_apart_and_together_and_a_rope_holds_one_at_a_wall() {
    let mut app = app();
    let (a, b) = (crate_at(&mut app, "a", -1.5, 0.0), crate_at(&mut app, "b", 1.5, 0.0));
    key(&mut app, KeyCode::KeyT, -1.5, 0.0);
    assert_eq!(message(&app), "First end set; now the second.");
    key(&mut app, KeyCode::KeyT, 1.5, 0.0);
    assert!(message(&app).starts_with("Added a rod of 3.00"), "{}", message(&app));
    assert_eq!(named(&mut app, "rod").len(), 1);
    run(&mut app, 3);
    app.world_mut().get_mut::<LinearVelocity>(b).unwrap().0 = Vec3::new(1.0, 2.0, 0.0);
    let ends = |app: &App| {
        [a, b].map(|one| app.world().get::<Transform>(one).unwrap().transform_point(Vec3::Z * 0.5))
    };
    for _ in 0..60 {
        run(&mut app, 1);
        let [from, to] = ends(&app);
        assert!((from.distance(to) - 3.0).abs() < 0.05, "{}", from.distance(to));
    }
    // A tie whose ends are on the same body is rejected.
    let at = place(&app, a);
    key(&mut app, KeyCode::KeyY, at.x, at.y);
    key(&mut app, KeyCode::KeyY, at.x + 0.1, at.y);
    assert_eq!(message(&app), "Both ends are on the same body.");

    let hung = crate_at(&mut app, "hung", 4.0, 4.0);
    let wall = (Collider::cuboid(Vec3::ONE), Transform::from_xyz(4.0, 6.0, 0.0));
    app.world_mut().spawn((InScene, wall));
    run(&mut app, 2);
    key(&mut app, KeyCode::KeyY, 4.0, 6.0);
    key(&mut app, KeyCode::KeyY, 4.0, 4.0);
    assert!(message(&app).starts_with("Added a rope of 2.00"), "{}", message(&app));
    app.insert_resource(bevy_sinew::Gravity::default());
    run(&mut app, 120);
    let low = place(&app, hung).y;
    assert!(low > 3.0, "it hangs: {low}");
}

#[test]
fn a_rope_that_is_cut_is_two_and_a_rod_that_is_cut_is_none() {
    let mut app = app();
    let rope = Rope { pin_end: true, ..Rope::between(-Vec3::X, Vec3::X) };
    let rope = app.world_mut().spawn((InScene, Name::new("rope"), rope, Skin::default())).id();
    run(&mut app, 2);
    let rods =
        |app: &mut App| app.world_mut().query::<&DistanceConstraint>().iter(app.world()).count();
    assert_eq!(rods(&mut app), 20);
    // Away from the rope nothing is cut.
    key(&mut app, KeyCode::KeyX, 0.05, 0.5);
    assert_eq!(rods(&mut app), 20);
    key(&mut app, KeyCode::KeyX, 0.05, 0.0);
    assert_eq!(rods(&mut app), 19);
    let mut tubes = app.world_mut().query::<&TubeMesh>();
    let mut lengths: Vec<usize> = tubes.iter(app.world()).map(|t| t.particles.len()).collect();
    lengths.sort_unstable();
    assert_eq!(lengths, [10, 11]);
    // The new piece can be cut like the old one.
    key(&mut app, KeyCode::KeyX, 0.55, 0.0);
    let mut tubes = app.world_mut().query::<&TubeMesh>();
    assert_eq!(tubes.iter(app.world()).map(|tube| tube.particles.len()).sum::<usize>(), 21);
    assert_eq!(tubes.iter(app.world()).count(), 3);
    app.world_mut().despawn(rope);
    run(&mut app, 2);

    crate_at(&mut app, "a", -1.5, 3.0);
    crate_at(&mut app, "b", 1.5, 3.0);
    key(&mut app, KeyCode::KeyT, -1.5, 3.0);
    key(&mut app, KeyCode::KeyT, 1.5, 3.0);
    run(&mut app, 3);
    assert_eq!(named(&mut app, "rod").len(), 1);
    key(&mut app, KeyCode::KeyX, 0.2, 3.0);
    assert_eq!(message(&app), "Cut 1 thread.");
    assert!(named(&mut app, "rod").is_empty());
    // A crate is rigid and cannot be cut.
    let before = rods(&mut app);
    key(&mut app, KeyCode::KeyX, -1.5, 3.0);
    assert_eq!(rods(&mut app), before);
}

#[test]
fn a_cloth_that_is_cut_across_falls_apart_where_the_pointer_went() {
    let mut app = app();
    let cloth = Cloth::grid(1.0, 1.0, 20, 20).pinned(ClothPins::TopEdge);
    let cloth = app.world_mut().spawn((InScene, cloth, Skin::default())).id();
    run(&mut app, 2);
    let drawn = |app: &App| {
        let mesh = &app.world().get::<Mesh3d>(cloth).unwrap().0;
        let meshes = app.world().resource::<Assets<Mesh>>();
        meshes.get(mesh).unwrap().indices().unwrap().len() / 3
    };
    assert_eq!(drawn(&app), 800);
    aim(&mut app, -0.7, 0.03);
    press(&mut app, KeyCode::KeyX, ButtonState::Pressed);
    for i in 0..=70 {
        aim(&mut app, -0.7 + 0.02 * i as f32, 0.03);
        app.update();
    }
    press(&mut app, KeyCode::KeyX, ButtonState::Released);
    let left = drawn(&app);
    assert!((640..780).contains(&left), "{left} triangles are left");
    assert_eq!(app.world().get::<WindSurface>(cloth).unwrap().triangles.len(), left);
    app.insert_resource(bevy_sinew::Gravity::default());
    run(&mut app, 90);
    let members: Vec<Entity> = app.world().get::<BodyParticles>(cloth).unwrap().iter().collect();
    let height = |one: &Entity| app.world().get::<Particle>(*one).unwrap().position.y;
    assert!(height(&members[0]) > 0.45, "the upper edge is held");
    assert!(height(members.last().unwrap()) < -2.0, "the lower half has fallen");
}

#[test]
fn a_shot_hits_what_the_pointer_is_over_and_a_body_is_taken_away() {
    let mut app = app();
    let body = crate_at(&mut app, "crate", 0.0, 0.0);
    key(&mut app, KeyCode::KeyF, 0.0, 0.0);
    run(&mut app, 70);
    assert!(place(&app, body).z < -0.5, "{}", place(&app, body));
    for _ in 0..30 {
        key(&mut app, KeyCode::KeyF, 3.0, 3.0);
    }
    assert!(named(&mut app, "shot").len() <= 24);
    let at = place(&app, body);
    key(&mut app, KeyCode::Delete, at.x, at.y);
    assert_eq!(message(&app), "Removed.");
    assert!(app.world().get_entity(body).is_err());
    key(&mut app, KeyCode::Delete, 20.0, 20.0);
    assert_eq!(message(&app), "No body there.");
}

/// The number of meshes, and how many of them have a look.
fn seen(app: &mut App) -> [usize; 2] {
    let mut meshes = app.world_mut().query::<(&Mesh3d, Option<&sinew_scenes::Look>)>();
    let all: Vec<bool> = meshes.iter(app.world()).map(|(_, look)| look.is_some()).collect();
    [all.len(), all.iter().filter(|look| **look).count()]
}

#[test]
fn all_of_it_is_saved_and_comes_back_in_another_run_as_it_was_and_looks_as_it_did() {
    let path = std::env::temp_dir().join(format!("playground-{}.ron", std::process::id()));
    let mut first = app();
    first.world_mut().resource_mut::<Tools>().path.clone_from(&path);
    sinew_scenes::load(first.world_mut(), sinew_scenes::find(SCENE).unwrap());
    run(&mut first, 5);
    for (i, (tool, bound)) in TOOLS.into_iter().take(6).enumerate() {
        assert_eq!(tool, Tool::Spawn(Toy::ALL[i]));
        key(&mut first, bound, -3.0 + i as f32, 4.0);
    }
    key(&mut first, KeyCode::KeyP, -2.1, 2.0);
    assert!(message(&first).starts_with("Pinned"), "{}", message(&first));
    run(&mut first, 5);
    let hash = |app: &App| SinewSnapshot::capture(app.world()).hash();
    key(&mut first, KeyCode::F5, 0.0, 0.0);
    assert!(message(&first).starts_with("Saved"), "{}", message(&first));
    // Two frames have passed since it was written: one for pressing the key, one for releasing it.
    let mut second = app();
    second.world_mut().resource_mut::<Tools>().path.clone_from(&path);
    second.world_mut().resource_mut::<SinewControl>().paused = true;
    press(&mut second, KeyCode::F9, ButtonState::Pressed);
    assert!(message(&second).starts_with("Loaded"), "{}", message(&second));
    let text = std::fs::read_to_string(&path).unwrap();
    let saved = SinewSnapshot::from_ron(&text, second.world()).unwrap();
    assert_eq!(hash(&second), saved.hash());
    press(&mut second, KeyCode::F9, ButtonState::Released);
    run(&mut second, 3);
    let [drawn, dressed] = seen(&mut second);
    assert_eq!([drawn, dressed], seen(&mut first), "and all of it is drawn");
    assert_eq!(drawn, dressed);

    // A broken file changes nothing; the next scene despawns what came from the file.
    std::fs::write(&path, &text[..text.len() / 2]).unwrap();
    second.world_mut().resource_mut::<SinewControl>().pause();
    run(&mut second, 2);
    let before = hash(&second);
    key(&mut second, KeyCode::F9, 0.0, 0.0);
    assert!(message(&second).starts_with("Not loaded"), "{}", message(&second));
    assert_eq!(hash(&second), before);
    std::fs::remove_file(&path).unwrap();
    sinew_scenes::load(second.world_mut(), sinew_scenes::find("square").unwrap());
    run(&mut second, 2);
    let mut particles = second.world_mut().query::<&Particle>();
    assert_eq!(particles.iter(second.world()).count(), 12);
}

/// Draws the bar with these events; returns its texts and their centres.
fn draw_bar(
    app: &mut App,
    ctx: &egui::Context,
    events: Vec<egui::Event>,
) -> Vec<(String, egui::Pos2)> {
    fn texts(shape: &egui::Shape, found: &mut Vec<(String, egui::Pos2)>) {
        match shape {
            egui::Shape::Text(text) => {
                let middle = text.pos + text.galley.size() * 0.5;
                found.push((text.galley.text().to_owned(), middle));
            }
            egui::Shape::Vec(shapes) => shapes.iter().for_each(|shape| texts(shape, found)),
            _ => {}
        }
    }
    let screen = egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(1280.0, 800.0));
    let input = egui::RawInput { screen_rect: Some(screen), events, ..default() };
    let mut tools = app.world_mut().resource_mut::<Tools>();
    let output = ctx.run_ui(input, |root| {
        style(root.ctx());
        let side = sinew_panel::PanelSide::Left;
        sinew_panel::dock(&root.ctx().clone(), side, |ui| {
            bar(ui, &mut tools);
            assert!(ui.min_rect().width() <= sinew_panel::DOCK_WIDTH - 28.0, "it is too wide");
        });
    });
    let mut found = Vec::new();
    output.shapes.iter().for_each(|clipped| texts(&clipped.shape, &mut found));
    found
}

/// Clicks the button whose text starts like this.
fn click(app: &mut App, ctx: &egui::Context, text: &str) {
    draw_bar(app, ctx, Vec::new());
    let all = draw_bar(app, ctx, Vec::new());
    let found = all.iter().find(|(its, _)| its.starts_with(text));
    let pos = found.unwrap_or_else(|| panic!("no {text} in {all:?}")).1;
    let button = |pressed| egui::Event::PointerButton {
        pos,
        button: egui::PointerButton::Primary,
        pressed,
        modifiers: egui::Modifiers::NONE,
    };
    for event in [egui::Event::PointerMoved(pos), button(true), button(false)] {
        draw_bar(app, ctx, vec![event]);
    }
    app.update();
}

#[test]
fn a_button_takes_a_tool_in_hand_and_a_press_works_instead_of_dragging_until_it_is_put_away() {
    let ctx = egui::Context::default();
    let mut app = app();
    let body = crate_at(&mut app, "crate", 0.0, 0.0);
    let grabbed = |app: &App| app.world().resource::<MouseDrag>().grabbed.is_some();
    button(&mut app, DOWN, 0.1, 0.1);
    assert!(grabbed(&app), "without a tool it drags");
    button(&mut app, UP, 0.1, 0.1);

    click(&mut app, &ctx, "Pin");
    assert!(app.world().resource::<Tools>().is_armed());
    button(&mut app, DOWN, 0.1, 0.1);
    assert!(!grabbed(&app));
    button(&mut app, UP, 0.1, 0.1);
    assert_eq!(named(&mut app, "pin").len(), 1);

    click(&mut app, &ctx, "Remove");
    press(&mut app, KeyCode::Escape, ButtonState::Pressed);
    press(&mut app, KeyCode::Escape, ButtonState::Released);
    button(&mut app, DOWN, 0.2, 0.2);
    assert!(grabbed(&app), "it drags again");
    button(&mut app, UP, 0.2, 0.2);
    assert!(app.world().get_entity(body).is_ok(), "and removes nothing");

    // Other scenes have no tools.
    click(&mut app, &ctx, "Shoot");
    sinew_scenes::load(app.world_mut(), sinew_scenes::find("square").unwrap());
    run(&mut app, 2);
    button(&mut app, DOWN, 9.0, 9.0);
    button(&mut app, UP, 9.0, 9.0);
    key(&mut app, KeyCode::Digit1, 0.0, 0.0);
    assert!(named(&mut app, "shot").is_empty() && named(&mut app, "Box").is_empty());
    assert!(!app.world().resource::<Tools>().is_armed());
}
