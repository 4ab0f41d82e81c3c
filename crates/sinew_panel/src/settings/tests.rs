//! Round trips of settings through a file, and files that are rejected.

use bevy::prelude::*;
use bevy_egui::egui;
use bevy_sinew::prelude::*;
use bevy_sinew::{Integrator, Order};

use super::*;
use crate::recording::RecordWhen;
use crate::state::PanelState;
use crate::tests::{app, click_text, draw_with, find_text};
use crate::{PanelSide, SinewPanelPlugin};

fn unusual() -> PanelSettings {
    PanelSettings {
        solver: SolverConfig {
            substeps: 17,
            tolerance: 0.000_123,
            integrator: Integrator::Leapfrog,
            order: Order::Jacobi,
            keep_spin: false,
            max_speed: 0.0,
            ..default()
        },
        gravity: [0.1, -1.62, 1e-20],
        air_drag: 0.3,
        electric_constant: 1e3,
        electric_softening: 0.01,
        speed: 0.25,
        recording: RecordingConfig {
            when: RecordWhen::Never,
            max_microseconds: 250,
            max_ticks: 7,
            max_bytes: 1 << 20,
        },
    }
}

#[test]
fn what_was_written_is_read_bit_for_bit() {
    for settings in [PanelSettings::default(), unusual()] {
        let text = settings.to_ron().unwrap();
        assert_eq!(PanelSettings::from_ron(&text), Ok(settings), "{text}");
    }
}

#[test]
fn files_that_are_something_else_broken_or_out_of_range_are_refused() {
    let text = unusual().to_ron().unwrap();
    let refused = |text: &str| PanelSettings::from_ron(text).expect_err(text);
    for foreign in ["", "(", "\"hello\"", "[1, 2]", "(entities: {})", "not RON at all"] {
        assert_eq!(refused(foreign), SettingsFault::Foreign, "{foreign}");
    }
    // Truncated at any place.
    for end in (20..text.trim_end().len()).step_by(7) {
        let fault = refused(&text[..end]);
        assert!(matches!(fault, SettingsFault::Broken(_)), "{end}: {fault}");
    }
    let changed = |from: &str, to: &str| {
        assert!(text.contains(from), "{from} in {text}");
        refused(&text.replace(from, to))
    };
    assert_eq!(changed("sinew_panel: 1", "sinew_panel: 2"), SettingsFault::Version(2));
    assert_eq!(changed("substeps: 17", "substeps: 0"), SettingsFault::Number("substeps"));
    assert_eq!(changed("speed: 0.25", "speed: NaN"), SettingsFault::Number("speed"));
    assert_eq!(changed("speed: 0.25", "speed: -1.0"), SettingsFault::Number("speed"));
    assert_eq!(changed("-1.62", "inf"), SettingsFault::Number("gravity"));
    assert!(matches!(changed("substeps: 17", "substeps: 17.5"), SettingsFault::Broken(_)));
    assert!(matches!(changed("substeps: 17", "substips: 17"), SettingsFault::Broken(_)));
    assert!(matches!(changed("Jacobi", "Yacobi"), SettingsFault::Broken(_)));
    // A missing setting gets its default, as in the file of an older panel.
    let older = text.replace("speed: 0.25,", "").replace("order: Jacobi,", "");
    let read = PanelSettings::from_ron(&older).unwrap();
    assert_eq!((read.speed, read.solver.order), (1.0, Order::default()));
    assert_eq!((read.solver.substeps, read.air_drag), (17, 0.3));
}

#[test]
fn the_buttons_save_and_load_and_a_broken_file_changes_nothing() {
    let mut app = app(SinewPanelPlugin::embedded());
    let ctx = egui::Context::default();
    let folder = std::env::temp_dir().join(format!("sinew_panel_{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("settings.ron");
    let use_path = |app: &mut App, path: &Path| {
        let text = path.to_string_lossy().into_owned();
        app.world_mut().resource_mut::<PanelState>().settings_path = text;
    };
    let now = |app: &App| {
        let world = app.world();
        (
            *world.resource::<SolverConfig>(),
            *world.resource::<Gravity>(),
            *world.resource::<AirDrag>(),
        )
    };
    use_path(&mut app, &path);
    let tuned = SolverConfig { substeps: 33, ..default() };
    app.insert_resource(tuned);
    app.insert_resource(Gravity(Vec3::new(0.0, -3.0, 0.0)));
    click_text(&mut app, &ctx, "Save settings");
    let (output, _) = draw_with(&mut app, &ctx, PanelSide::Right, Vec::new());
    assert!(find_text(&output, "Saved").is_some());
    let saved = now(&app);

    app.insert_resource(SolverConfig::default());
    app.insert_resource(Gravity::default());
    click_text(&mut app, &ctx, "Load settings");
    assert_eq!(now(&app), saved);
    assert_eq!(saved.0, tuned);

    let text = std::fs::read_to_string(&path).unwrap();
    for (file, broken) in [("cut.ron", &text[..text.len() / 2]), ("foreign.ron", "(a: 1)")] {
        let path = folder.join(file);
        std::fs::write(&path, broken).unwrap();
        use_path(&mut app, &path);
        app.insert_resource(AirDrag(0.123));
        let before = now(&app);
        click_text(&mut app, &ctx, "Load settings");
        assert_eq!(now(&app), before);
        let (output, _) = draw_with(&mut app, &ctx, PanelSide::Right, Vec::new());
        assert!(find_text(&output, "nothing has changed").is_some(), "{file}");
    }
    use_path(&mut app, &folder.join("missing.ron"));
    click_text(&mut app, &ctx, "Load settings");
    let (output, _) = draw_with(&mut app, &ctx, PanelSide::Right, Vec::new());
    assert!(find_text(&output, "nothing has changed").is_some());
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn the_default_path_is_beside_the_program() {
    let path = PanelSettings::default_path();
    assert_eq!(path.file_name().unwrap(), "settings.ron");
    assert_eq!(path.parent(), std::env::current_exe().unwrap().parent());
}
