//! The gallery: every scene of Sinew, interactive in a window, or rendered headless.
//!
//! `cargo run --example gallery` opens a window. Where that is not possible it acts as with `--headless`: it runs every scene without a GPU and writes a
//! contact sheet, an animated GIF and a summary table.

mod headless;
mod stage;
mod thumbnails;
mod window;

use std::path::PathBuf;
use std::process::ExitCode;

use bevy::reflect::structs::{GetField, Struct};
use bevy_sinew::SinewGizmoConfigGroup;
use clap::Parser;
use sinew_scenes::Scene;

/// Every scene of Sinew, in a window or as pictures.
#[derive(Parser, Debug)]
#[command(name = "gallery", version, about)]
struct Options {
    /// Run without a window, and write pictures and a table.
    #[arg(long)]
    headless: bool,
    /// The folder for the pictures.
    #[arg(long, value_name = "DIR", default_value = "gallery_out")]
    out: PathBuf,
    /// Only this scene (the window opens with it).
    #[arg(long, value_name = "NAME")]
    scene: Option<String>,
    /// How long to run each scene, seconds; by default a time that suits the scene.
    #[arg(long, value_name = "S")]
    seconds: Option<f32>,
    /// Frames a second of the animations.
    #[arg(long, value_name = "N", default_value_t = 15)]
    fps: u32,
    /// Open a window, save a screenshot of every scene to this folder, and quit.
    #[arg(long, value_name = "DIR")]
    screenshots: Option<PathBuf>,
    /// Open a window, record every scene (--seconds, --fps) as an animated GIF into this folder, and quit.
    #[arg(long, value_name = "DIR", conflicts_with = "screenshots")]
    films: Option<PathBuf>,
    /// Open a window, draw every scene without the panel into this folder (640 × 400), and quit.
    #[arg(long, value_name = "DIR", conflicts_with_all = ["screenshots", "films"])]
    stills: Option<PathBuf>,
    /// Open a window, draw the thumbnails of the list of scenes on this sheet (PNG, the names beside it as .txt), and quit; with --scene only that one is
    /// redrawn.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["screenshots", "films", "stills"])]
    thumbnails: Option<PathBuf>,
    /// Open a window, operate it with real pointer and key events (X11), write pictures to this folder, and quit; fails if a result is not the expected one.
    #[arg(long, value_name = "DIR", conflicts_with_all = ["screenshots", "films", "stills", "thumbnails"])]
    drive: Option<PathBuf>,
    /// In a window: show these debug lines at the start, by their names in `SinewGizmoConfigGroup` (`contacts,forces`), instead of none.
    #[arg(long, value_name = "LAYERS", value_delimiter = ',')]
    lines: Vec<String>,
    /// List the scenes and quit.
    #[arg(long)]
    list: bool,
}

impl Options {
    /// Whether an option needs pictures that only Bevy's renderer draws.
    fn draws_in_a_window(&self) -> bool {
        self.screenshots.is_some()
            || self.films.is_some()
            || self.stills.is_some()
            || self.thumbnails.is_some()
            || self.drive.is_some()
    }
}

fn main() -> ExitCode {
    let options = Options::parse();
    if options.list {
        for scene in sinew_scenes::ALL {
            println!("{:<10} {}: {}", scene.name, scene.heading.title(), scene.about);
        }
        return ExitCode::SUCCESS;
    }
    let scenes = match chosen(&options) {
        Ok(scenes) => scenes,
        Err(message) => {
            eprintln!("gallery: {message}");
            return ExitCode::from(2);
        }
    };
    if !options.headless {
        match window::run(&options, &scenes) {
            Ok(code) => return code,
            Err(reason) if options.draws_in_a_window() => {
                eprintln!("gallery: cannot draw pictures without a window: {reason}");
                return ExitCode::FAILURE;
            }
            Err(reason) => println!("No window ({reason}); rendering pictures instead."),
        }
    }
    headless::run(&options, &scenes)
}

/// The scenes that the options select, after checking their numbers.
fn chosen(options: &Options) -> Result<Vec<&'static Scene>, String> {
    if options.seconds.is_some_and(|s| !(s > 0.0 && s <= 3600.0)) {
        return Err("--seconds must be more than 0 and at most 3600".into());
    }
    if !(1..=60).contains(&options.fps) {
        return Err("--fps must be between 1 and 60".into());
    }
    if let Some(name) = options.lines.iter().find(|name| layers_of([name.as_str()]).is_none()) {
        return Err(format!("unknown layer of debug lines \"{name}\""));
    }
    match &options.scene {
        None => Ok(sinew_scenes::ALL.iter().collect()),
        Some(name) => match sinew_scenes::find(name) {
            Some(scene) => Ok(vec![scene]),
            None => {
                let names: Vec<_> = sinew_scenes::ALL.iter().map(|scene| scene.name).collect();
                Err(format!("unknown scene \"{name}\"; the scenes are {}", names.join(", ")))
            }
        },
    }
}

/// The debug lines of these names, all others off; `None` if a name is unknown.
fn layers_of<'a>(names: impl IntoIterator<Item = &'a str>) -> Option<SinewGizmoConfigGroup> {
    let mut layers = SinewGizmoConfigGroup::default();
    for i in 0..layers.field_len() {
        *layers.field_at_mut(i)?.try_downcast_mut::<bool>()? = false;
    }
    for name in names {
        *layers.get_field_mut::<bool>(name)? = true;
    }
    Some(layers)
}
