//! The gallery in a window: an orbit camera, a panel, and every scene live.

#[cfg(target_os = "linux")]
mod drive;
mod film;
mod screenshots;
mod sky;
mod stage;
mod tools;
mod ui;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::process::ExitCode;

use bevy::asset::AssetPlugin;
use bevy::gizmos::config::GizmoConfigStore;
use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy::window::WindowResolution;
use bevy_sinew::{MouseDragPlugin, SinewGizmoConfigGroup, SinewPlugins};
use sinew_examples::assets_folder;
use sinew_panel::{Recording, Selection};
use sinew_scenes::{Scene, ScenesPlugin};

use crate::Options;

/// The current scene, and the one that is to be loaded.
#[derive(Resource)]
struct SceneChoice {
    current: &'static Scene,
    /// Whether a scene has been loaded yet.
    loaded_any: bool,
    /// The scene to load, or to reload, before the next frame.
    requested: Option<&'static Scene>,
    /// Values of its sliders for that; `None`: their defaults.
    values: Option<Vec<f32>>,
}

/// Opens the window and runs until it is closed. Returns `Err` with the reason if no window can be opened.
///
/// Bevy panics if it finds no display or no GPU. That is not a bug of this program, so the panic is caught, but only while the app is built: a later panic is a
/// bug and must be visible.
pub(crate) fn run(options: &Options, scenes: &[&'static Scene]) -> Result<ExitCode, String> {
    let first = *scenes.first().ok_or("there is no scene to show")?;
    if cfg!(target_os = "linux") && !display_named() {
        return Err("neither DISPLAY nor WAYLAND_DISPLAY is set".into());
    }
    let (shots, driven) = (options.screenshots.clone(), options.drive.clone());
    let for_pictures = shots.is_some() || driven.is_some();
    let films = options.films.clone().map(|folder| film::Job::Films {
        folder,
        fps: options.fps,
        seconds: options.seconds,
    });
    let job = films
        .or_else(|| options.stills.clone().map(film::Job::Stills))
        .or_else(|| options.thumbnails.clone().map(film::Job::Thumbnails));
    let opened = catch_unwind(AssertUnwindSafe(|| open(first, for_pictures, job.as_ref())));
    let mut app = opened.map_err(|_| "Bevy could not open a window, see above")?;
    if let Some(layers) = crate::layers_of(options.lines.iter().map(String::as_str))
        && !options.lines.is_empty()
    {
        app.add_systems(Startup, move |mut store: ResMut<GizmoConfigStore>| {
            let (config, shown) = store.config_mut::<SinewGizmoConfigGroup>();
            config.enabled = true;
            *shown = layers;
        });
    }
    if let Some(job) = job {
        film::add(&mut app, job, scenes.to_vec());
    } else if let Some(folder) = shots {
        screenshots::add(&mut app, folder, scenes.to_vec());
    }
    if let Some(folder) = driven {
        #[cfg(target_os = "linux")]
        drive::add(&mut app, folder);
        #[cfg(not(target_os = "linux"))]
        return Err(format!("{}: --drive needs an X server", folder.display()));
    }
    match app.run() {
        AppExit::Success => Ok(ExitCode::SUCCESS),
        AppExit::Error(code) => Ok(ExitCode::from(code.get())),
    }
}

fn display_named() -> bool {
    let named = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    named("DISPLAY") || named("WAYLAND_DISPLAY")
}

/// The app with its window: with the panel, or for pictures of the scenes without it.
fn open(first: &'static Scene, for_screenshots: bool, job: Option<&film::Job>) -> App {
    let resolution = match job.map(film::Job::window) {
        Some([width, height]) => {
            // Physical pixels, whatever the scale factor of the screen.
            WindowResolution::new(width, height).with_scale_factor_override(1.0)
        }
        None => WindowResolution::new(1280, 800),
    };
    let window = Window { title: "Sinew gallery".into(), resolution, ..default() };
    let for_pictures = for_screenshots || job.is_some();
    let mut app = App::new();
    app.add_plugins((
        DefaultPlugins
            .set(WindowPlugin { primary_window: Some(window), ..default() })
            .set(AssetPlugin { file_path: assets_folder(), ..default() })
            // A picture must not be taken before its shaders are compiled.
            .set(RenderPlugin { synchronous_pipeline_compilation: for_pictures, ..default() }),
        SinewPlugins,
        MouseDragPlugin,
        ScenesPlugin,
    ));
    stage::add(&mut app);
    if job.is_some() {
        // A change of scene clears these resources of the panel, which is not drawn.
        app.init_resource::<Recording>().init_resource::<Selection>();
    } else {
        ui::add(&mut app);
        tools::add(&mut app);
    }
    app.insert_resource(SceneChoice {
        current: first,
        loaded_any: false,
        requested: Some(first),
        values: None,
    })
    .add_systems(First, change_scene);
    app
}

/// Loads the requested scene, and moves the camera to its viewpoint.
fn change_scene(world: &mut World) {
    let Some(scene) = world.resource_mut::<SceneChoice>().requested.take() else { return };
    let mut choice = world.resource_mut::<SceneChoice>();
    let moved = !choice.loaded_any || choice.current.name != scene.name;
    choice.loaded_any = true;
    choice.current = scene;
    // A restart keeps the values of the sliders.
    let values = world.resource_mut::<SceneChoice>().values.clone();
    match values {
        Some(values) => sinew_scenes::load_with(world, scene, &values),
        None => sinew_scenes::load(world, scene),
    }
    world.resource_mut::<Recording>().clear();
    world.resource_mut::<Selection>().clear();
    stage::aim(world, scene, moved);
}
