//! The gallery operated automatically: real pointer and key events go through the X server, the window and egui like those of a user, and the result of each is
//! checked in the app.
//!
//! | file | what it holds |
//! |---|---|
//! | `hand` | pointer and keys: events that the X server generates on request |
//! | `script` | the steps of the script, and the checks of their results |
//!
//! The script runs in a thread of its own and sends closures to the app, one executed in each frame, so that it reads from top to bottom like a session of a
//! user.

mod hand;
mod script;

use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::Duration;

use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_egui::{EguiFullOutput, EguiPostUpdateSet, egui};
use sinew_panel::RecordingConfig;

/// Time for which the script waits for an answer, seconds: an app that is stuck must not hang CI.
const MAX_WAIT: Duration = Duration::from_secs(60);

/// A closure that runs on the world between two frames.
type Request = Box<dyn FnOnce(&mut World) + Send>;

/// The pending closures of the script. One runs in each frame.
#[derive(Resource)]
struct Requests(Mutex<Receiver<Request>>);

/// The texts that egui drew in the last frame, and their rectangles: the script finds a button by its text.
#[derive(Resource, Default)]
struct Texts(Vec<(String, egui::Rect)>);

/// Starts the script, which writes its pictures to a folder.
pub(super) fn add(app: &mut App, folder: PathBuf) {
    let (sender, requests) = channel();
    app.insert_resource(Requests(Mutex::new(requests)))
        .init_resource::<Texts>()
        // One tick a frame, however long a software renderer takes for it.
        .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs_f64(1.0 / 64.0)))
        .add_systems(PostStartup, draw_plainly)
        .add_systems(Last, run_request)
        .add_systems(
            PostUpdate,
            read_texts.after(EguiPostUpdateSet::EndPass).before(EguiPostUpdateSet::ProcessOutput),
        );
    std::thread::spawn(move || {
        let app = AppHandle(sender);
        let exit = match script::play(&app, &folder) {
            Ok(count) => {
                println!("gallery: driven by pointer and keys, {count} checks passed");
                AppExit::Success
            }
            Err(fault) => {
                eprintln!("gallery: driven by pointer and keys: {fault}");
                // The state of the window at the failure.
                let _ = script::photograph(&app, &folder, "failed");
                AppExit::error()
            }
        };
        let _ = app.run(move |world| world.write_message(exit));
    });
}

/// Turns off what a software renderer spends most of its time on: multisampling and shadows, which are not needed here, and the ground, which is only shown in
/// pictures.
fn draw_plainly(
    mut commands: Commands,
    cameras: Query<Entity, With<Camera>>,
    meshes: Query<(&Name, &mut Visibility), With<Mesh3d>>,
    mut lights: Query<&mut DirectionalLight>,
    mut recording: ResMut<RecordingConfig>,
) {
    cameras.iter().for_each(|camera| _ = commands.entity(camera).insert(Msaa::Off));
    show_ground(false)(meshes);
    lights.iter_mut().for_each(|mut light| light.shadow_maps_enabled = false);
    // Records every tick even on a busy machine: Back goes back by exactly one.
    recording.max_microseconds = u32::MAX;
}

/// Shows the ground or hides it.
fn show_ground(shown: bool) -> impl Fn(Query<(&Name, &mut Visibility), With<Mesh3d>>) {
    move |mut meshes| {
        for (name, mut visibility) in &mut meshes {
            if name.as_str() == "stage ground" {
                *visibility = if shown { Visibility::Inherited } else { Visibility::Hidden };
            }
        }
    }
}

/// Runs one closure of the script.
fn run_request(world: &mut World) {
    let request = {
        let requests = world.resource::<Requests>().0.lock();
        requests.ok().and_then(|requests| requests.try_recv().ok())
    };
    if let Some(request) = request {
        request(world);
    }
}

/// Collects the visible texts and their rectangles.
fn read_texts(outputs: Query<&EguiFullOutput>, mut texts: ResMut<Texts>) {
    fn read(shape: &egui::Shape, clip: egui::Rect, texts: &mut Vec<(String, egui::Rect)>) {
        match shape {
            egui::Shape::Text(text) => {
                let rect = egui::Rect::from_min_size(text.pos, text.galley.size());
                if clip.contains(rect.center()) {
                    texts.push((text.galley.text().trim().to_owned(), rect));
                }
            }
            egui::Shape::Vec(shapes) => shapes.iter().for_each(|shape| read(shape, clip, texts)),
            _ => {}
        }
    }
    texts.0.clear();
    for output in outputs.iter().filter_map(|output| output.0.as_ref()) {
        for clipped in &output.shapes {
            read(&clipped.shape, clipped.clip_rect, &mut texts.0);
        }
    }
}

/// The script's connection to the app.
struct AppHandle(Sender<Request>);

impl AppHandle {
    /// Runs a closure on the world between two frames, and returns its result.
    fn run<T: Send + 'static>(
        &self,
        request: impl FnOnce(&mut World) -> T + Send + 'static,
    ) -> Result<T, String> {
        let (result, results) = channel();
        let sent = self.0.send(Box::new(move |world| {
            let _ = result.send(request(world));
        }));
        sent.map_err(|_| "the app has exited".to_owned())?;
        results.recv_timeout(MAX_WAIT).map_err(|_| "the app did not answer in time".to_owned())
    }

    /// Lets frames pass.
    fn frames(&self, count: usize) -> Result<(), String> {
        (0..count).try_for_each(|_| self.run(|_| ()))
    }

    /// Lets frames pass until a condition holds, at most 240.
    fn until(&self, what: &str, is: fn(&mut World) -> bool) -> Result<(), String> {
        for _ in 0..240 {
            if self.run(is)? {
                return Ok(());
            }
        }
        Err(format!("timed out waiting for: {what}"))
    }
}
