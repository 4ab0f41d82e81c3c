//! Pictures of the scenes without the panel, drawn by Bevy: animations for the README, stills for the guide, and thumbnails for the list of scenes.

use std::path::PathBuf;
use std::time::Duration;

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy::render::view::screenshot::{Screenshot, ScreenshotCaptured};
use bevy::time::TimeUpdateStrategy;
use bevy_panorbit_camera::PanOrbitCamera;
use bevy_sinew::SinewClock;
use sinew_draw as draw;
use sinew_scenes::Scene;

use super::SceneChoice;
use super::screenshots::Textures;
use crate::thumbnails;

/// What to draw.
#[derive(Clone)]
pub(super) enum Job {
    /// An animation of each scene into a folder.
    Films {
        /// The folder; files are called `NAME.gif`.
        folder: PathBuf,
        /// Frames a second.
        fps: u32,
        /// Length of each, seconds; `None`: the length that the scene suggests.
        seconds: Option<f32>,
    },
    /// A picture of each scene into a folder, as `NAME.png`.
    Stills(PathBuf),
    /// One tile of each scene, on one sheet.
    Thumbnails(PathBuf),
}

impl Job {
    /// Size of the window, pixels: a multiple of the size of the picture.
    pub(super) fn window(&self) -> [u32; 2] {
        let [width, height] = self.size();
        [width, height].map(|side| (side * self.factor()) as u32)
    }

    fn size(&self) -> [usize; 2] {
        match self {
            Self::Films { .. } => [400, 250],
            Self::Stills(_) => [640, 400],
            Self::Thumbnails(_) => thumbnails::TILE,
        }
    }

    /// Pixels of the window for a pixel of the picture, each way: supersampling in addition to 4× multisampling, so that ropes are smooth.
    fn factor(&self) -> usize {
        match self {
            Self::Films { .. } | Self::Stills(_) | Self::Thumbnails(_) => 2,
        }
    }

    fn frames(&self, scene: &Scene) -> usize {
        match self {
            Self::Films { fps, seconds, .. } => {
                (seconds.unwrap_or(scene.seconds) * *fps as f32).ceil().max(1.0) as usize
            }
            Self::Stills(_) | Self::Thumbnails(_) => 1,
        }
    }

    /// Simulated time from one frame to the next.
    fn stride(&self) -> Duration {
        match self {
            Self::Films { fps, .. } => Duration::from_secs_f64(1.0 / f64::from(*fps)),
            Self::Stills(_) | Self::Thumbnails(_) => Duration::from_millis(125),
        }
    }

    /// Simulated time of the first frame, seconds.
    fn begin(&self, scene: &Scene) -> f64 {
        match self {
            // After the first tick: before it recipes have built nothing, and a page shows the first frame until the whole file is loaded.
            Self::Films { .. } => f64::MIN_POSITIVE,
            Self::Stills(_) | Self::Thumbnails(_) => f64::from(scene.moment),
        }
    }
}

/// Frames without simulated time before the first picture, in which assets reach the GPU.
const STILL: u32 = 5;
/// Frames that are drawn and discarded before the first picture.
const DRAWN: u32 = 2;
/// Most frames to wait for assets, for the time of the picture or for a picture, each.
const MAX_WAIT_FRAMES: u32 = 2_000;

/// Runs one scene after the other, then quits the app.
pub(super) fn add(app: &mut App, job: Job, scenes: Vec<&'static Scene>) {
    app.insert_resource(Filming {
        job,
        scenes,
        next: 0,
        state: State::Start,
        waited: 0,
        tiles: Vec::new(),
    })
    .init_resource::<Shots>()
    .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::ZERO))
    .add_systems(Last, capture);
}

#[derive(Resource)]
struct Filming {
    job: Job,
    scenes: Vec<&'static Scene>,
    next: usize,
    state: State,
    /// Frames without progress.
    waited: u32,
    tiles: Vec<(&'static str, draw::Image)>,
}

enum State {
    Start,
    /// The scene is spawned and its assets are loading; simulated time stands still.
    Loading,
    /// Everything has been loaded for this many frames.
    Still(u32),
    /// Simulating up to the first frame.
    Playing,
    /// The scene has been drawn this many times, which creates its pipelines and bins.
    Drawn(u32),
    /// This many pictures have been requested.
    Capturing(usize),
}

/// The captured pictures, in the order of their requests.
#[derive(Resource, Default)]
struct Shots(Vec<Option<draw::Image>>);

impl Shots {
    fn missing(&self) -> usize {
        self.0.iter().filter(|shot| shot.is_none()).count()
    }
}

/// Meshes and textures that are being loaded from files.
#[derive(SystemParam)]
struct Loading<'w, 's> {
    textures: Textures<'w>,
    meshes: Res<'w, Assets<Mesh>>,
    drawn: Query<'w, 's, &'static Mesh3d>,
}

impl Loading<'_, '_> {
    fn is_over(&self) -> bool {
        !self.textures.are_loading()
            && self.drawn.iter().all(|mesh| self.meshes.get(&mesh.0).is_some())
    }
}

fn capture(
    mut commands: Commands,
    mut filming: ResMut<Filming>,
    mut shots: ResMut<Shots>,
    mut choice: ResMut<SceneChoice>,
    mut time: ResMut<TimeUpdateStrategy>,
    mut camera: Single<&mut Camera, With<PanOrbitCamera>>,
    clock: Res<SinewClock>,
    loading: Loading,
    mut exit: MessageWriter<AppExit>,
) {
    let filming = &mut *filming;
    let mut failed = |message: String| {
        error!("{message}");
        exit.write(AppExit::error());
    };
    let Some(scene) = filming.scenes.get(filming.next).copied() else {
        if let Job::Thumbnails(file) = &filming.job
            && let Err(reason) = thumbnails::write(file, &filming.tiles)
        {
            failed(format!("cannot write {}: {reason}", file.display()));
            return;
        }
        exit.write(AppExit::Success);
        return;
    };
    filming.waited += 1;
    if filming.waited > MAX_WAIT_FRAMES {
        failed(format!("no progress on {} after {MAX_WAIT_FRAMES} frames", scene.name));
        return;
    }
    let frames = filming.job.frames(scene);
    let mut stride = Duration::ZERO;
    let next = match filming.state {
        State::Start => {
            choice.requested = Some(scene);
            choice.values = None;
            shots.0.clear();
            State::Loading
        }
        State::Loading if loading.is_over() => State::Still(0),
        State::Loading => State::Loading,
        State::Still(n) if n < STILL => State::Still(n + 1),
        State::Still(_) => State::Playing,
        State::Playing if clock.seconds < filming.job.begin(scene) => {
            stride = filming.job.stride();
            State::Playing
        }
        State::Playing => State::Drawn(0),
        State::Drawn(n) if n < DRAWN => State::Drawn(n + 1),
        State::Drawn(_) => State::Capturing(0),
        State::Capturing(requested) if requested < frames => {
            let factor = filming.job.factor();
            shots.0.push(None);
            commands.spawn(Screenshot::primary_window()).observe(
                move |captured: On<ScreenshotCaptured>, mut shots: ResMut<Shots>| {
                    let image = image_of(&captured.image).map(|image| image.shrunk(factor));
                    if let Some(shot) = shots.0.get_mut(requested) {
                        *shot = image;
                    }
                },
            );
            stride = filming.job.stride();
            filming.waited = 0;
            State::Capturing(requested + 1)
        }
        State::Capturing(requested) if shots.missing() > 0 => State::Capturing(requested),
        State::Capturing(_) => {
            let film: Vec<draw::Image> = shots.0.drain(..).flatten().collect();
            match &filming.job {
                Job::Films { folder, fps, .. } => {
                    let path = folder.join(format!("{}.gif", scene.name));
                    // In hundredths of a second, the unit of GIF.
                    let delay = (100.0 / *fps as f32).round().max(2.0) as u16;
                    let written = std::fs::create_dir_all(folder)
                        .and_then(|()| draw::write_gif(&path, &film, delay));
                    if let Err(reason) = written {
                        failed(format!("cannot write {}: {reason}", path.display()));
                        return;
                    }
                    println!("{}", path.display());
                }
                Job::Stills(folder) => {
                    let path = folder.join(format!("{}.png", scene.name));
                    let written = std::fs::create_dir_all(folder).and_then(|()| {
                        film.iter().try_for_each(|still| draw::write_png(&path, still))
                    });
                    if let Err(reason) = written {
                        failed(format!("cannot write {}: {reason}", path.display()));
                        return;
                    }
                    println!("{}", path.display());
                }
                Job::Thumbnails(_) => {
                    println!("{}", scene.name);
                    filming.tiles.extend(film.into_iter().map(|tile| (scene.name, tile)));
                }
            }
            filming.next += 1;
            filming.waited = 0;
            State::Start
        }
    };
    *time = TimeUpdateStrategy::ManualDuration(stride);
    // A software renderer is slow: only frames that are used are drawn.
    camera.is_active = match next {
        State::Drawn(_) => true,
        State::Capturing(requested) => requested < frames || shots.missing() > 0,
        _ => false,
    };
    filming.state = next;
}

/// Converts a captured image for the crate that writes files; `None` for a format that the CPU cannot read.
fn image_of(image: &Image) -> Option<draw::Image> {
    let pixels = image.clone().try_into_dynamic().ok()?.into_rgba8();
    let (width, height) = (pixels.width() as usize, pixels.height() as usize);
    let pixels = pixels.into_raw().as_chunks::<4>().0.to_vec();
    Some(draw::Image { width, height, pixels })
}
