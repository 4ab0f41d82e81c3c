//! The panel without a screen: the plugin in an app of `MinimalPlugins`, and the layout in an egui context that is not painted.

use bevy::ecs::system::RunSystemOnce;
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_egui::egui::{self, Rect, pos2};
use bevy_sinew::prelude::*;
use bevy_sinew::{Charge, SinewClock, TickTime};

use super::*;

/// Height of the screen, points: enough for all sections, because a widget that is scrolled out of sight cannot be clicked.
const HEIGHT: f32 = 2400.0;

pub(crate) fn app(plugin: SinewPanelPlugin) -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, SinewPlugins, plugin));
    app.insert_resource(TimeUpdateStrategy::ManualDuration(core::time::Duration::from_secs_f64(
        1.0 / 64.0,
    )));
    app.world_mut().spawn((RigidBox::new(Vec3::ONE), Transform::from_xyz(0.0, 3.0, 0.0)));
    app.world_mut().spawn((Wind::default(), Name::new("Breeze")));
    app.finish();
    app
}

/// Draws the panel once, on a screen 1280 points wide, and returns the output and the covered rectangle.
fn draw_once(app: &mut App, ctx: &egui::Context, side: PanelSide) -> (egui::FullOutput, Rect) {
    draw_with(app, ctx, side, Vec::new())
}

/// Like [`draw_once`], after events of a pointer or a keyboard.
pub(crate) fn draw_with(
    app: &mut App,
    ctx: &egui::Context,
    side: PanelSide,
    events: Vec<egui::Event>,
) -> (egui::FullOutput, Rect) {
    let (ctx, screen) = (ctx.clone(), Rect::from_min_max(pos2(0.0, 0.0), pos2(1280.0, HEIGHT)));
    let draw = move |mut params: PanelParams| {
        let input =
            egui::RawInput { screen_rect: Some(screen), events: events.clone(), ..default() };
        let mut covered = Rect::NOTHING;
        let output = ctx.run_ui(input, |root| {
            let ctx = root.ctx().clone();
            style(&ctx);
            covered = dock(&ctx, side, |ui| {
                show(ui, &mut params);
                ui.min_rect()
            });
        });
        (output, covered)
    };
    app.world_mut().run_system_once(draw).expect("the panel's parameters are there")
}

/// Position of a text in the panel: the middle of the first shape that contains it.
pub(crate) fn find_text(output: &egui::FullOutput, text: &str) -> Option<egui::Pos2> {
    fn find(shape: &egui::Shape, text: &str) -> Option<egui::Pos2> {
        match shape {
            egui::Shape::Text(shape) if shape.galley.text().contains(text) => {
                Some(shape.pos + shape.galley.size() * 0.5)
            }
            egui::Shape::Vec(shapes) => shapes.iter().find_map(|shape| find(shape, text)),
            _ => None,
        }
    }
    output.shapes.iter().find_map(|clipped| find(&clipped.shape, text))
}

/// Presses and releases the pointer at a position, with a frame of the app after each event.
pub(crate) fn click(app: &mut App, ctx: &egui::Context, at: egui::Pos2) {
    let button = |pressed| egui::Event::PointerButton {
        pos: at,
        button: egui::PointerButton::Primary,
        pressed,
        modifiers: egui::Modifiers::NONE,
    };
    for event in [egui::Event::PointerMoved(at), button(true), button(false)] {
        draw_with(app, ctx, PanelSide::Right, vec![event]);
        app.update();
    }
}

/// Clicks on the widget with a text.
pub(crate) fn click_text(app: &mut App, ctx: &egui::Context, text: &str) {
    // The first frame only measures the layout.
    draw_with(app, ctx, PanelSide::Right, Vec::new());
    let (output, _) = draw_with(app, ctx, PanelSide::Right, Vec::new());
    let at = find_text(&output, text).unwrap_or_else(|| panic!("no \"{text}\" in the panel"));
    click(app, ctx, at);
}

#[test]
fn an_app_without_a_screen_runs_as_without_the_panel() {
    for plugin in [SinewPanelPlugin::default(), SinewPanelPlugin::embedded()] {
        let mut app = app(plugin);
        for _ in 0..5 {
            app.update();
        }
        assert!(!app.is_plugin_added::<EguiPlugin>());
        assert!(app.world().resource::<SinewClock>().tick > 2);
        // The panel was not drawn: no energies were summed up.
        assert!(app.world().resource::<PlotHistory>().is_empty());
    }
}

#[test]
fn without_sinew_the_plugin_does_nothing() {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, SinewPanelPlugin::default()));
    app.update();
    app.update();
}

#[test]
fn energies_are_sampled_once_a_tick_while_somebody_looks() {
    let mut app = app(SinewPanelPlugin::embedded());
    let ctx = egui::Context::default();
    app.update();
    let began = app.world().resource::<SinewClock>().tick;
    for _ in 0..8 {
        draw_once(&mut app, &ctx, PanelSide::Left);
        app.update();
    }
    let ticks = app.world().resource::<SinewClock>().tick - began;
    assert!(ticks >= 7);
    assert_eq!(app.world().resource::<PlotHistory>().len() as u64, ticks);

    app.insert_resource(SinewClock::default());
    app.world_mut().resource_mut::<SinewControl>().paused = true;
    app.update();
    assert!(app.world().resource::<PlotHistory>().is_empty());
}

#[test]
fn looking_changes_nothing() {
    let run = |looked: bool| {
        let mut app = app(SinewPanelPlugin::embedded());
        // Values that the sliders cannot show.
        app.insert_resource(SolverConfig {
            substeps: 100,
            max_sweeps: 200,
            tolerance: 0.5,
            ..default()
        });
        app.insert_resource(AirDrag(1.5));
        let ctx = egui::Context::default();
        for _ in 0..20 {
            app.update();
            if looked {
                draw_once(&mut app, &ctx, PanelSide::Right);
            }
        }
        let world = app.world_mut();
        let config = *world.resource::<SolverConfig>();
        let air = *world.resource::<AirDrag>();
        let mut particles: Vec<_> = world
            .query::<&Particle>()
            .iter(world)
            .map(|p| {
                (p.position.to_array().map(f32::to_bits), p.velocity.to_array().map(f32::to_bits))
            })
            .collect();
        particles.sort_unstable();
        assert!(!particles.is_empty());
        (config, air, particles)
    };
    assert_eq!(run(true), run(false));
}

#[test]
fn nothing_sticks_out_of_the_panel() {
    let mut app = app(SinewPanelPlugin::embedded());
    app.world_mut().spawn((Particle::default(), Charge(1e-6)));
    let mut bodies = app.world_mut().query_filtered::<Entity, With<RigidBox>>();
    let body = bodies.iter(app.world()).next().expect("it has a box");
    app.world_mut()
        .entity_mut(body)
        .insert(Name::new("a name that is far too long for a panel of this width"));
    app.world_mut().resource_mut::<Selection>().select(body);
    app.insert_resource(SolverConfig { substeps: 11, ..default() });
    let ctx = egui::Context::default();
    for side in [PanelSide::Left, PanelSide::Right] {
        let mut widths = Vec::new();
        for _ in 0..30 {
            app.update();
            let (_, covered) = draw_once(&mut app, &ctx, side);
            // The panel's width less its margins: one widget that is too wide pushes the edge of all below it.
            assert!(covered.width() <= DOCK_WIDTH - 28.0, "{covered}");
            widths.push(covered.width());
            let edges = match side {
                PanelSide::Left => 0.0..=DOCK_WIDTH,
                PanelSide::Right => 1280.0 - DOCK_WIDTH..=1280.0,
            };
            assert!(
                edges.contains(&covered.left()) && edges.contains(&covered.right()),
                "{covered}"
            );
        }
        assert!(widths.iter().all(|w| *w == widths[0]), "{widths:?}");
    }
}

#[test]
fn each_plot_is_a_click_away_fits_and_has_its_unit() {
    let mut app = app(SinewPanelPlugin::embedded());
    let ctx = egui::Context::default();
    for (plot, curve, unit) in [
        ("Momentum", "p along x", "kg·m/s"),
        ("Ang. mom.", "L about x", "kg·m²/s"),
        ("Error, mm", "Largest error", "mm"),
        ("Strain, %", "Largest strain", "%"),
        ("Tick, ms", "Scatter", "ms"),
        ("Energy", "Kinetic", "J"),
    ] {
        click_text(&mut app, &ctx, plot);
        for _ in 0..3 {
            app.update();
            let (output, covered) = draw_once(&mut app, &ctx, PanelSide::Right);
            assert!(covered.width() <= DOCK_WIDTH - 28.0, "{plot}: {covered}");
            for text in [curve, unit] {
                assert!(find_text(&output, text).is_some(), "{plot} has no {text}");
            }
        }
    }
    let history = app.world().resource::<PlotHistory>();
    let last = *history.last().unwrap();
    // A crate that falls from rest, in a breeze along x.
    assert!(last.momentum.y < -0.1 && last.momentum.x > 0.1, "{last:?}");
    assert!(last.parts.iter().all(|&part| part > 0.0), "{last:?}");
    assert_eq!(last.phases, [0.0; 6]);
}

#[test]
fn phases_are_measured_only_while_somebody_looks_at_them() {
    let mut app = app(SinewPanelPlugin::embedded());
    let ctx = egui::Context::default();
    let measured = |app: &App| app.world().resource::<TickTime>().by_phase;
    click_text(&mut app, &ctx, "Tick, ms");
    app.update();
    assert!(!measured(&app));
    click_text(&mut app, &ctx, "Measured");
    draw_once(&mut app, &ctx, PanelSide::Right);
    app.update();
    assert!(measured(&app));
    draw_once(&mut app, &ctx, PanelSide::Right);
    app.update();
    assert!(app.world().resource::<PlotHistory>().last().unwrap().phases[5] > 0.0);
    // Hidden.
    (0..3).for_each(|_| app.update());
    assert!(!measured(&app));
    // Measuring that a game has switched on itself stays on.
    app.world_mut().resource_mut::<TickTime>().by_phase = true;
    (0..3).for_each(|_| app.update());
    assert!(measured(&app));
}

/// The assets and resources of a window and a renderer that egui needs, without either.
fn add_pretended_screen(app: &mut App) {
    fn init_assets_of<A: Asset>(app: &mut App, _: &Handle<A>) {
        app.init_asset::<A>();
    }
    app.add_plugins((AssetPlugin::default(), WindowPlugin::default(), InputPlugin));
    app.init_asset::<Image>();
    init_assets_of(app, &EGUI_SHADER_HANDLE);
}

#[test]
fn docked_it_waits_for_a_camera_and_goes_with_its_key() {
    let mut app = App::new();
    app.add_plugins(MinimalPlugins);
    add_pretended_screen(&mut app);
    app.add_plugins((SinewPlugins, SinewPanelPlugin::default()));
    assert!(app.is_plugin_added::<EguiPlugin>());
    app.insert_resource(TimeUpdateStrategy::ManualDuration(core::time::Duration::from_millis(20)));
    app.finish();
    let looked = |app: &App| !app.world().resource::<PlotHistory>().is_empty();

    app.update();
    app.update();
    assert!(!looked(&app));

    app.world_mut().spawn(Camera::default());
    for _ in 0..4 {
        app.update();
    }
    assert!(looked(&app));

    let mut keys = ButtonInput::<KeyCode>::default();
    keys.press(KeyCode::F1);
    app.insert_resource(keys);
    app.world_mut().run_system_once(toggle).unwrap();
    assert!(!app.world().resource::<SinewPanel>().shown);
    app.insert_resource(PlotHistory::default());
    app.update();
    app.insert_resource(PlotHistory::default());
    for _ in 0..4 {
        app.update();
    }
    assert!(!looked(&app));
}
