//! A screenshot of every scene, for CI and the README.

use std::path::PathBuf;
use std::time::Duration;

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy::render::view::screenshot::{Screenshot, save_to_disk};
use bevy::time::TimeUpdateStrategy;
use bevy_panorbit_camera::PanOrbitCamera;
use bevy_sinew::SinewClock;
use sinew_scenes::Scene;

use super::SceneChoice;

/// Simulated time of a frame until the time of the picture.
const STRIDE: Duration = Duration::from_millis(125);
/// Frames of the panel alone at the time of the picture, in which textures reach the GPU and the panel gets its final layout.
const STILL: u32 = 4;
/// Most frames to wait for the time of the picture and for the file: a loading asset or a full disk must not hang CI.
const MAX_WAIT_FRAMES: u32 = 2_000;

/// Runs one scene after the other, then quits the app.
pub(super) fn add(app: &mut App, folder: PathBuf, scenes: Vec<&'static Scene>) {
    app.insert_resource(Series { folder, scenes, next: 0, state: State::Start, frames: 0 })
        .insert_resource(TimeUpdateStrategy::ManualDuration(STRIDE))
        .add_systems(Last, capture);
}

#[derive(Resource)]
struct Series {
    folder: PathBuf,
    scenes: Vec<&'static Scene>,
    next: usize,
    state: State,
    frames: u32,
}

enum State {
    Start,
    Playing,
    Still(u32),
    /// The scene is drawn once, which creates its pipelines and bins.
    Drawn,
    Saving(PathBuf),
}

/// Textures that are being loaded from files.
#[derive(SystemParam)]
pub(super) struct Textures<'w> {
    server: Res<'w, AssetServer>,
    materials: Res<'w, Assets<StandardMaterial>>,
}

impl Textures<'_> {
    pub(super) fn are_loading(&self) -> bool {
        let textures =
            self.materials.iter().filter_map(|(_, look)| look.base_color_texture.as_ref());
        let mut states = textures.filter_map(|texture| self.server.get_load_state(texture));
        states.any(|state| state.is_loading())
    }
}

fn capture(
    mut commands: Commands,
    mut series: ResMut<Series>,
    mut choice: ResMut<SceneChoice>,
    mut time: ResMut<TimeUpdateStrategy>,
    mut camera: Single<&mut Camera, With<PanOrbitCamera>>,
    clock: Res<SinewClock>,
    textures: Textures,
    mut exit: MessageWriter<AppExit>,
) {
    let series = &mut *series;
    let Some(scene) = series.scenes.get(series.next).copied() else {
        exit.write(AppExit::Success);
        return;
    };
    series.frames += 1;
    if series.frames > MAX_WAIT_FRAMES {
        error!("no picture of {} after {MAX_WAIT_FRAMES} frames", scene.name);
        exit.write(AppExit::error());
        return;
    }
    let next = match &series.state {
        State::Start => {
            if std::fs::create_dir_all(&series.folder).is_err() {
                error!("cannot create {}", series.folder.display());
                exit.write(AppExit::error());
                return;
            }
            choice.requested = Some(scene);
            choice.values = None;
            *time = TimeUpdateStrategy::ManualDuration(STRIDE);
            State::Playing
        }
        State::Playing if clock.seconds < f64::from(scene.moment) => return,
        State::Playing => {
            *time = TimeUpdateStrategy::ManualDuration(Duration::ZERO);
            State::Still(0)
        }
        State::Still(frames) if *frames < STILL => State::Still(frames + 1),
        State::Still(_) if textures.are_loading() => return,
        State::Still(_) => State::Drawn,
        State::Drawn => {
            let path = series.folder.join(format!("{}.png", scene.name));
            // Removed, so that an older picture is not mistaken for this one.
            let _ = std::fs::remove_file(&path);
            commands.spawn(Screenshot::primary_window()).observe(save_to_disk(path.clone()));
            State::Saving(path)
        }
        State::Saving(path) if !path.exists() => {
            camera.is_active = false;
            return;
        }
        State::Saving(path) => {
            println!("{}", path.display());
            series.next += 1;
            series.frames = 0;
            State::Start
        }
    };
    // A software renderer takes seconds for a frame: the scene is drawn once before its picture and once for it, and not while the file is written.
    camera.is_active = matches!(next, State::Drawn | State::Saving(_));
    series.state = next;
}
