//! The gallery without a window: runs every scene under `MinimalPlugins`, and writes a contact sheet and a GIF for each, and a summary table.

use std::fs;
use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use bevy::asset::AssetPlugin;
use bevy::gltf::GltfPlugin;
use bevy::image::{CompressedImageFormatSupport, CompressedImageFormats, ImageLoader, ImagePlugin};
use bevy::mesh::MeshPlugin;
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy::world_serialization::WorldSerializationPlugin;
use bevy_sinew::prelude::*;
use bevy_sinew::{Refusal, Refused, SinewClock, TickTime};
use cpu_time::ProcessTime;
use indicatif::{ProgressBar, ProgressStyle};
use sinew_draw::{self as draw, Image};
use sinew_examples::assets_folder;
use sinew_scenes::{Lesson, OnStage, Scene, ScenesPlugin};

use crate::Options;
use crate::stage::{self, Textures};

/// Size of a frame on the contact sheet and in the GIF, pixels.
const SHEET_FRAME: (usize, usize) = (480, 300);
const FILM_FRAME: (usize, usize) = (400, 250);
/// Frames on a contact sheet.
const SHEET_FRAMES: usize = 6;
/// Wall-clock time after which waiting for an asset ends with an error.
const MAX_WAIT: Duration = Duration::from_secs(30);

/// Runs the scenes and writes the pictures. Succeeds only if all state stayed finite, every lesson agreed with its formula, and every file was written.
pub(crate) fn run(options: &Options, scenes: &[&'static Scene]) -> ExitCode {
    if let Err(error) = fs::create_dir_all(&options.out) {
        eprintln!("gallery: cannot create {}: {error}", options.out.display());
        return ExitCode::FAILURE;
    }
    let length = |scene: &Scene| options.seconds.unwrap_or(scene.seconds);
    let frames: f32 = scenes.iter().map(|scene| length(scene) * options.fps as f32).sum();
    let bar = ProgressBar::new(frames.ceil() as u64).with_style(
        ProgressStyle::with_template("{msg:>10} [{bar:40}] {percent:>3} % {elapsed} of {duration}")
            .unwrap_or_else(|_| ProgressStyle::default_bar())
            .progress_chars("=> "),
    );
    // A scene is a world of its own and writes its own pictures, so the scenes run in parallel, one on each core. The table lists them in order.
    let next = AtomicUsize::new(0);
    let finished = Mutex::new(Vec::new());
    let workers = std::thread::available_parallelism().map_or(1, usize::from).min(scenes.len());
    std::thread::scope(|scope| {
        for _ in 0..workers {
            scope.spawn(|| {
                while let Some(&scene) = scenes.get(next.fetch_add(1, Ordering::Relaxed)) {
                    bar.set_message(scene.name);
                    // Without a terminal, as in a log, the bar is hidden, and a line for each scene shows progress.
                    if bar.is_hidden() {
                        println!("running {} ...", scene.name);
                    }
                    let row = run_scene(scene, length(scene), options.fps, &options.out, &bar);
                    let mut finished = finished.lock().unwrap_or_else(PoisonError::into_inner);
                    finished.push((scene.name, row));
                }
            });
        }
    });
    let mut finished = finished.into_inner().unwrap_or_else(PoisonError::into_inner);
    let place = |name: &str| scenes.iter().position(|scene| scene.name == name);
    finished.sort_by_key(|(name, _)| place(name));
    let mut rows = Vec::new();
    let mut failed = false;
    for (name, row) in finished {
        match row {
            Ok(row) => rows.push(row),
            Err(error) => {
                failed = true;
                bar.suspend(|| eprintln!("gallery: {name}: {error}"));
            }
        }
    }
    bar.finish_and_clear();
    let table = table(&rows, workers == 1);
    print!("{table}");
    let summary = options.out.join("summary.txt");
    if let Err(error) = fs::write(&summary, &table) {
        eprintln!("gallery: cannot write {}: {error}", summary.display());
        failed = true;
    }
    println!("\nPictures: {}/*.png, *.gif", options.out.display());
    if failed || rows.iter().any(|row| !row.finite || agreement(row) == Some(false)) {
        ExitCode::FAILURE
    } else {
        ExitCode::SUCCESS
    }
}

/// The results of a scene.
struct Row {
    name: &'static str,
    particles: usize,
    constraints: usize,
    ticks: u64,
    /// Mean wall time of a tick's substeps, milliseconds, while other scenes run in parallel.
    milliseconds: f64,
    /// Processor time of the longest frame, the whole plugin included, milliseconds. It counts the whole process, so it is meaningful only where no other scene
    /// runs in parallel.
    longest: f64,
    /// Largest error of a hard constraint after any tick, metres, and largest strain, relative to the length.
    error: f32,
    strain: f32,
    /// Energy at the start and at the end, joules.
    energy: [f64; 2],
    /// The measured and the predicted number of its lesson when it was due; `None` before that and for a scene without a lesson.
    lesson: Option<[f64; 2]>,
    finite: bool,
}

/// Runs one scene and writes its pictures.
fn run_scene(
    scene: &'static Scene,
    seconds: f32,
    fps: u32,
    out: &Path,
    bar: &ProgressBar,
) -> Result<Row, String> {
    let mut app = headless_app();
    sinew_scenes::load(app.world_mut(), scene);
    wait_for_assets(&mut app)?;

    let mut row = Row {
        name: scene.name,
        particles: 0,
        constraints: 0,
        ticks: 0,
        milliseconds: 0.0,
        longest: 0.0,
        error: 0.0,
        strain: 0.0,
        energy: [0.0; 2],
        lesson: None,
        finite: true,
    };
    let films = (seconds * fps as f32).ceil().max(1.0) as usize;
    let sheets: Vec<usize> = (0..SHEET_FRAMES).map(|i| i * films / SHEET_FRAMES).collect();
    let (mut film, mut sheet) = (Vec::with_capacity(films), Vec::new());
    for frame in 0..films {
        let due = frame as f64 / f64::from(fps);
        while app.world().resource::<SinewClock>().seconds + 1e-9 < due {
            tick(&mut app, &mut row);
        }
        film.push(stage::photograph(app.world_mut(), scene, FILM_FRAME.0, FILM_FRAME.1));
        if sheets.contains(&frame) {
            let picture = stage::photograph(app.world_mut(), scene, SHEET_FRAME.0, SHEET_FRAME.1);
            sheet.push((format!("{due:.1} s"), picture));
        }
        bar.inc(1);
    }
    row.energy[1] = app.world_mut().resource_mut::<SinewWorld>().ledger().energy();
    row.finite &= row.energy.iter().all(|e| e.is_finite()) && all_finite(app.world_mut());
    if row.ticks > 0 {
        row.milliseconds /= row.ticks as f64;
    }
    write_pictures(scene, &film, &sheet, fps, out).map_err(|error| error.to_string())?;
    Ok(row)
}

/// The lesson of a scene, with the measured and the predicted number; `None` if it was not due.
fn lesson(row: &Row) -> Option<(Lesson, [f64; 2])> {
    sinew_scenes::find(row.name).and_then(|scene| scene.lesson).zip(row.lesson)
}

/// Whether the measured number of a scene's lesson agrees with the predicted one; `None` if it was not due.
fn agreement(row: &Row) -> Option<bool> {
    lesson(row).map(|(lesson, [measured, expected])| lesson.agrees(measured, expected))
}

/// The numbers of a scene's lesson and whether they agree, as a text; empty if it was not due.
fn verdict(row: &Row) -> String {
    let Some((lesson, [measured, expected])) = lesson(row) else { return String::new() };
    let agrees = if lesson.agrees(measured, expected) { "yes" } else { "NO" };
    let (number, unit) = (lesson.number, lesson.unit);
    format!("{number}: measured {measured:.3} {unit}, predicted {expected:.3} {unit}: {agrees}")
}

/// An app with everything that a scene needs and nothing that needs a GPU or a display.
fn headless_app() -> App {
    let mut app = App::new();
    app.add_plugins((
        MinimalPlugins,
        TransformPlugin,
        AssetPlugin { file_path: assets_folder(), ..default() },
        ImagePlugin::default(),
        MeshPlugin,
        WorldSerializationPlugin,
    ));
    // Compressed textures are not supported here; the resource keeps the loader from warning about that.
    app.insert_resource(CompressedImageFormatSupport(CompressedImageFormats::NONE));
    // Usually the renderer registers this loader, for the formats that the GPU supports.
    app.register_asset_loader(ImageLoader::new(CompressedImageFormats::NONE));
    app.add_plugins((GltfPlugin::default(), SinewPlugins, ScenesPlugin));
    let step = app.world().resource::<Time<Fixed>>().timestep();
    app.insert_resource(TimeUpdateStrategy::ManualDuration(step))
        .init_resource::<Textures>()
        .add_systems(PostUpdate, stage::request_textures);
    app.finish();
    app.cleanup();
    app
}

/// Waits for meshes and textures while the simulation is paused, so that every run starts from the same state.
fn wait_for_assets(app: &mut App) -> Result<(), String> {
    let began = std::time::Instant::now();
    app.world_mut().resource_mut::<SinewControl>().paused = true;
    loop {
        app.update();
        let world = app.world_mut();
        let mut waiting = world.query::<&Mesh3d>();
        let meshes = world.resource::<Assets<Mesh>>();
        let missing = waiting.iter(world).filter(|mesh| meshes.get(&mesh.0).is_none()).count();
        if missing == 0 && world.resource::<Textures>().ready() {
            break;
        }
        if began.elapsed() > MAX_WAIT {
            return Err(format!("timed out: {missing} meshes or some textures did not load"));
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    // One more update, so that meshes built from assets that have just arrived are drawn.
    app.update();
    app.world_mut().resource_mut::<SinewControl>().paused = false;
    Ok(())
}

/// Runs one tick and adds its measurements to the row.
fn tick(app: &mut App, row: &mut Row) {
    let began = ProcessTime::now();
    app.update();
    row.longest = row.longest.max(began.elapsed().as_secs_f64() * 1e3);
    let world = app.world_mut();
    let diverged = world
        .resource_mut::<Messages<Refused>>()
        .drain()
        .filter(|refused| refused.reason == Refusal::Diverged)
        .count();
    row.finite &= diverged == 0;
    row.milliseconds += world.resource::<TickTime>().substeps.as_secs_f64() * 1e3;
    let sinew = world.resource::<SinewWorld>();
    row.ticks += 1;
    row.particles = sinew.particles().len();
    let simulation = sinew.simulation();
    let constraints = simulation.distances().len() + simulation.constraints().len();
    row.constraints = constraints + simulation.forces.springs.len();
    row.error = row.error.max(sinew.report().error);
    row.strain = row.strain.max(sinew.report().strain);
    if row.lesson.is_none() {
        let stage = world.resource::<OnStage>();
        let due = stage.scene.lesson.is_some_and(|lesson| {
            world.resource::<SinewClock>().seconds + 1e-6 >= f64::from(lesson.after)
        });
        row.lesson = stage.reading.filter(|_| due);
    }
    let mut sinew = world.resource_mut::<SinewWorld>();
    if row.ticks == 1 {
        row.energy[0] = sinew.ledger().energy();
    }
}

/// Whether all particles, transforms and meshes are finite.
fn all_finite(world: &mut World) -> bool {
    let mut particles = world.query::<&Particle>();
    let mut transforms = world.query::<&Transform>();
    let is_finite = |p: &Particle| p.position.is_finite() && p.velocity.is_finite();
    let meshes = world.resource::<Assets<Mesh>>().iter().all(|(_, mesh)| {
        let positions = mesh.attribute(Mesh::ATTRIBUTE_POSITION).and_then(|list| list.as_float3());
        positions.is_none_or(|list| list.iter().flatten().all(|x| x.is_finite()))
    });
    meshes
        && particles.iter(world).all(is_finite)
        && transforms.iter(world).all(bevy::prelude::Transform::is_finite)
}

fn write_pictures(
    scene: &Scene,
    film: &[Image],
    sheet: &[(String, Image)],
    fps: u32,
    out: &Path,
) -> std::io::Result<()> {
    let picture = draw::contact_sheet(scene.title, scene.about, sheet, 3);
    draw::write_png(out.join(format!("{}.png", scene.name)), &picture)?;
    let delay = (100.0 / fps as f32).round().max(2.0) as u16;
    draw::write_gif(out.join(format!("{}.gif", scene.name)), film, delay)
}

fn table(rows: &[Row], alone: bool) -> String {
    let mut text = format!(
        "{:<10} {:>9} {:>11} {:>6} {:>8} {:>8} {:>10} {:>8} {:>11} {:>11}  finite  lesson\n",
        "scene",
        "particles",
        "constraints",
        "ticks",
        "ms/tick",
        "max ms",
        "error, mm",
        "strain",
        "J at start",
        "J at end"
    );
    for row in rows {
        text += &format!(
            "{:<10} {:>9} {:>11} {:>6} {:>8.3} {:>8} {:>10.3} {:>6.2} % {:>11.4} {:>11.4}  {:<6}  {}\n",
            row.name,
            row.particles,
            row.constraints,
            row.ticks,
            row.milliseconds,
            if alone { format!("{:.2}", row.longest) } else { String::new() },
            row.error * 1e3,
            row.strain * 100.0,
            row.energy[0],
            row.energy[1],
            if row.finite { "yes" } else { "NO" },
            verdict(row),
        );
    }
    text
}
