//! The steps of the automatic session, and the checks of their results.

use std::path::Path;
use std::thread::sleep;
use std::time::Duration;

use bevy::ecs::system::RunSystemOnce;
use bevy::gizmos::config::GizmoConfigStore;
use bevy::prelude::*;
use bevy::render::view::screenshot::{Screenshot, save_to_disk};
use bevy_egui::egui;
use bevy_panorbit_camera::PanOrbitCamera;
use bevy_sinew::{
    BodyParticles, DistanceConstraint, MouseDrag, Particle, PhaseSteps, PhaseSystems, SinewClock,
    SinewControl, SinewGizmoConfigGroup, SolverConfig, WorldCenterOfMass,
};
use sinew_panel::{DOCK_WIDTH, Recording, Replay, Selection};
use sinew_scenes::OnStage;

use super::hand::{Hand, Key, LEFT, WHEEL_DOWN, WHEEL_UP};
use super::{AppHandle, Texts, show_ground};
use crate::window::SceneChoice;
use crate::window::tools::Tools;

/// The file that settings are saved to, in the folder of the pictures. Its name is typed, and its letters are also commands: R restarts, N steps and B goes
/// back.
const FILE: &str = "brand.new";

/// Frames from an event to its effect: the window receives it, egui processes it, the panel reacts.
const AFTER: usize = 3;

/// Runs the session; returns the number of checks.
pub(super) fn play(app: &AppHandle, folder: &Path) -> Result<usize, String> {
    // A typed name without a folder is relative to the current folder.
    let folder = std::fs::create_dir_all(folder).and_then(|()| folder.canonicalize());
    let folder = &folder.map_err(|fault| fault.to_string())?;
    std::env::set_current_dir(folder).map_err(|fault| fault.to_string())?;
    app.until("the first scene", |world| world.contains_resource::<OnStage>())?;
    app.frames(5)?;
    let session = Session { hand: Hand::at("Sinew gallery")?, app, checks: Default::default() };
    session.draw_view(false)?;
    session.choose_a_scene()?;
    session.move_its_slider()?;
    session.pause_and_step()?;
    session.go_by_phases()?;
    session.go_back_and_scrub()?;
    session.select_and_drag(folder)?;
    session.cut(folder)?;
    session.tune_save_and_load(folder)?;
    session.plot_and_draw_lines(folder)?;
    session.play_save_and_load(folder)?;
    Ok(session.checks.get())
}

/// Takes a picture of the window.
pub(super) fn photograph(app: &AppHandle, folder: &Path, name: &str) -> Result<(), String> {
    let path = folder.join(format!("{name}.png"));
    let _ = std::fs::remove_file(&path);
    let to = path.clone();
    app.run(|world| world.run_system_once(show_ground(true)).map_err(|fault| fault.to_string()))??;
    app.frames(1)?;
    app.run(move |world| {
        world.spawn(Screenshot::primary_window()).observe(save_to_disk(to));
    })?;
    app.frames(1)?;
    app.run(|world| world.run_system_once(show_ground(false)).map_err(|fault| fault.to_string()))??;
    for _ in 0..200 {
        if path.exists() {
            return Ok(());
        }
        app.frames(1)?;
        sleep(Duration::from_millis(5));
    }
    Err(format!("no picture {name}"))
}

/// A session of a simulated user.
struct Session<'a> {
    hand: Hand,
    app: &'a AppHandle,
    checks: std::cell::Cell<usize>,
}

impl Session<'_> {
    fn choose_a_scene(&self) -> Result<(), String> {
        self.click("Ropes, cloth, soft bodies")?;
        self.click("ropes")?;
        self.until("the scene that was clicked is on", |world| {
            let on = world.resource::<OnStage>().scene.name == "ropes";
            on && world.resource::<SceneChoice>().current.name == "ropes"
        })
    }

    fn move_its_slider(&self) -> Result<(), String> {
        let label = self.find("Lantern")?;
        let was = self.app.run(|world| world.resource::<OnStage>().values[0])?;
        // The slider's rail starts at the left edge, and the handle for 1.2 kg is at a third of it.
        self.drag([50.0, label.center().y], [100.0, label.center().y])?;
        let now = self.app.run(|world| world.resource::<OnStage>().values[0])?;
        self.check("the slider sets the mass of the lantern", now > was + 0.5)
    }

    fn pause_and_step(&self) -> Result<(), String> {
        self.key(Key::SPACE)?;
        self.until("Space pauses", |world| world.resource::<SinewControl>().paused)?;
        let tick = self.tick()?;
        self.app.frames(3)?;
        self.check("a paused world stands still", self.tick()? == tick)?;
        self.key(Key::N)?;
        self.check("N simulates one tick", self.tick()? == tick + 1)?;
        self.click("⏭  Step")?;
        self.check("the button Step simulates one tick", self.tick()? == tick + 2)?;
        self.click("▶  Run")?;
        self.until("the button Run runs", |world| !world.resource::<SinewControl>().paused)?;
        self.app.frames(20)?;
        self.click("⏸  Pause")?;
        self.until("the button Pause pauses", |world| world.resource::<SinewControl>().paused)
    }

    fn go_by_phases(&self) -> Result<(), String> {
        let tick = self.tick()?;
        let shown = |world: &mut World| world.resource::<PhaseSteps>().shown();
        self.click("½")?;
        let first = self.app.run(shown)?.ok_or("no phase is shown")?;
        let forces = PhaseSystems::AccumulateForces;
        self.check(
            "the button ½ shows the first phase",
            (first.substep, first.phase) == (1, forces),
        )?;
        self.find("Substep 1/10: forces, next wind")?;
        self.key(Key::H)?;
        let second = self.app.run(shown)?.ok_or("no second phase is shown")?;
        self.check("H shows the next one", second.phase == PhaseSystems::Wind)?;
        self.check("all of them are of one tick", self.tick()? == tick + 1)?;
        self.key(Key::N)?;
        self.check("a whole step leaves them", self.app.run(shown)?.is_none())?;
        self.check("for the next tick", self.tick()? == tick + 2)
    }

    fn go_back_and_scrub(&self) -> Result<(), String> {
        let tick = self.tick()?;
        self.key(Key::B)?;
        self.check("B goes back by a tick", self.tick()? == tick - 1)?;
        self.click("⏮  Back")?;
        self.check("the button Back goes back by a tick", self.tick()? == tick - 2)?;
        let row = self.find("Go to tick")?;
        let y = row.center().y;
        let rail = [row.left() + 92.0, DOCK_WIDTH - 14.0 - 84.0 - 16.0];
        self.drag([rail[1], y], [0.7 * rail[0] + 0.3 * rail[1], y])?;
        let scrubbed = self.tick()?;
        self.check("the scrubber goes to an earlier tick", scrubbed + 5 < tick)?;
        let first = self.app.run(|world| world.resource::<Recording>().ticks().next())?;
        let first = first.ok_or("nothing is recorded")?;
        self.check("and not before the recording", scrubbed >= first.tick)?;
        self.key(Key::SPACE)?;
        self.until("going on gives the hashes of the first pass", |world| {
            matches!(world.resource::<Recording>().replay(), Replay::Same(ticks) if ticks > 4)
        })?;
        let differs = self.app.run(|world| world.resource::<Recording>().replay())?;
        self.check("and no other", !matches!(differs, Replay::Differs(_)))
    }

    fn select_and_drag(&self, folder: &Path) -> Result<(), String> {
        // Picking needs the camera to be active.
        self.draw_view(true)?;
        // While paused, bodies stay where they were found.
        self.key(Key::SPACE)?;
        let line = self.body("slack line")?;
        let [x, y] = self.seen(line)?;
        self.press([x, y], true)?;
        self.press([x, y], false)?;
        let selected = self.app.run(|world| world.resource::<Selection>().body)?;
        self.check("a click selects the rope", selected == Some(line))?;

        let lantern = self.body("lantern")?;
        let [x, y] = self.seen(lantern)?;
        self.press([x, y], true)?;
        let held = |world: &mut World| world.resource::<MouseDrag>().grabbed.is_some();
        self.until("a press takes hold of the lantern", held)?;
        let selected = self.app.run(|world| world.resource::<Selection>().body)?;
        self.check("and selects it", selected == Some(lantern))?;
        let before = self.app.run(move |world| centre(world, lantern))?;
        self.key(Key::SPACE)?;
        for i in 1..=4 {
            self.hand.point(x, y - 30.0 * i as f32)?;
            self.app.frames(1)?;
        }
        self.app.frames(8)?;
        let after = self.app.run(move |world| centre(world, lantern))?;
        self.check("the lantern follows the pointer up", after.y > before.y + 0.3)?;
        photograph(self.app, folder, "dragged")?;
        self.press([x, y - 120.0], false)?;
        self.until("and is let go", |world| world.resource::<MouseDrag>().grabbed.is_none())?;
        self.key(Key::SPACE)?;
        // Empty sky above everything.
        self.press([800.0, 30.0], true)?;
        self.press([800.0, 30.0], false)?;
        let selected = self.app.run(|world| world.resource::<Selection>().body)?;
        self.check("a click into empty space deselects", selected.is_none())
    }

    fn cut(&self, folder: &Path) -> Result<(), String> {
        let line = self.body("slack line")?;
        let [x, y] = self.seen(line)?;
        self.press([x, y], true)?;
        self.press([x, y], false)?;
        self.draw_view(false)?;
        let rods = |world: &mut World| world.query::<&DistanceConstraint>().iter(world).count();
        let before = self.app.run(rods)?;
        self.scroll_to("Cut the nearest rod")?;
        photograph(self.app, folder, "selected")?;
        self.click("Cut the nearest rod")?;
        self.check("a rod of the selected rope is cut", self.app.run(rods)? == before - 1)?;
        self.hand.point(DOCK_WIDTH + 200.0, 30.0)?;
        self.key(Key::ESCAPE)?;
        let selected = self.app.run(|world| world.resource::<Selection>().body)?;
        self.check("Escape deselects", selected.is_none())
    }

    fn tune_save_and_load(&self, folder: &Path) -> Result<(), String> {
        let substeps = |world: &mut World| world.resource::<SolverConfig>().substeps;
        let tune = |share: f32| {
            let row = self.scroll_to("Max sweeps")?;
            // The row above is that of the substeps; their name also occurs in another section.
            let y = row.center().y - 24.0;
            let rail = [row.left() + 92.0, DOCK_WIDTH - 14.0 - 84.0 - 2.0 * 16.0];
            let x = rail[0] + share * (rail[1] - rail[0]);
            self.drag([x - 4.0, y], [x, y])
        };
        tune(0.3)?;
        let saved = self.app.run(substeps)?;
        self.check("the slider sets the substeps", (11..32).contains(&saved))?;

        let tick = self.tick()?;
        let button = self.scroll_to("Save settings")?;
        self.press([60.0, button.center().y - 26.0], true)?;
        self.press([60.0, button.center().y - 26.0], false)?;
        self.hand.key(Key::CONTROL, true)?;
        self.key(Key::A)?;
        self.hand.key(Key::CONTROL, false)?;
        for letter in FILE.chars() {
            self.key(Key::of(letter).ok_or("no such key")?)?;
        }
        photograph(self.app, folder, "typed")?;
        self.check("what is typed into a field is no command", self.tick()? == tick)?;
        let path = folder.join(FILE);
        let _ = std::fs::remove_file(&path);
        self.click("Save settings")?;
        self.check("Save writes the file that was named", path.exists())?;
        tune(0.8)?;
        let tuned = self.app.run(substeps)?;
        self.check("the slider sets the substeps again", tuned > saved + 10)?;
        self.scroll_to("Load settings")?;
        self.click("Load settings")?;
        self.check("Load brings back what was saved", self.app.run(substeps)? == saved)?;
        self.scroll_to("Reset to defaults")?;
        self.click("Reset to defaults")?;
        let is_default =
            |world: &mut World| *world.resource::<SolverConfig>() == SolverConfig::default();
        self.check("Reset brings back the defaults", self.app.run(is_default)?)
    }

    fn plot_and_draw_lines(&self, folder: &Path) -> Result<(), String> {
        self.key(Key::SPACE)?;
        for (plot, curve) in [
            ("Momentum", "p along x"),
            ("Ang. mom.", "L about x"),
            ("Error, mm", "Largest error"),
            ("Tick, ms", "Scatter"),
            ("Energy", "Gravitational"),
        ] {
            self.scroll_to("View")?;
            self.click(plot)?;
            self.app.frames(10)?;
            self.find(curve)?;
            self.check("a plot is a click away", true)?;
            let name: String = plot.chars().take_while(|c| c.is_alphabetic()).collect();
            photograph(self.app, folder, &format!("plot_{}", name.to_lowercase()))?;
        }
        self.scroll_to("Velocities")?;
        self.click("Shown")?;
        self.click("Velocities")?;
        self.click("Forces")?;
        self.find("— gravity")?;
        let layers = |world: &mut World| {
            let store = world.resource::<GizmoConfigStore>();
            let (config, layers) = store.config::<SinewGizmoConfigGroup>();
            config.enabled && layers.velocities && layers.forces
        };
        self.check("a layer of lines is a click away", self.app.run(layers)?)?;
        self.draw_view(true)?;
        self.app.frames(4)?;
        photograph(self.app, folder, "lines")
    }

    fn play_save_and_load(&self, folder: &Path) -> Result<(), String> {
        self.hand.point(150.0, 400.0)?;
        self.turn(WHEEL_UP, 60)?;
        self.click("Everything together")?;
        self.click("playground")?;
        self.until("the playground is on", |world| {
            world.resource::<OnStage>().scene.name == "playground"
        })?;
        let bodies = |world: &mut World| {
            world.query_filtered::<(), With<BodyParticles>>().iter(world).count()
        };
        self.app.frames(3)?;
        let at_first = self.app.run(bodies)?;
        self.hand.point(DOCK_WIDTH + 480.0, 560.0)?;
        self.app.frames(AFTER)?;
        self.key(Key::ONE)?;
        self.check("the key 1 makes a box", self.app.run(bodies)? == at_first + 1)?;

        self.key(Key::SPACE)?;
        let path = folder.join("playground.ron");
        let _ = std::fs::remove_file(&path);
        // Not the default path beside the program, where the user may have a file.
        let file = path.clone();
        self.app.run(move |world| world.resource_mut::<Tools>().path = file)?;
        self.key(Key::F5)?;
        self.check("F5 saves everything", path.exists())?;
        self.find("Saved playground.ron")?;
        // The positions of all particles, compared bit for bit.
        let places = |world: &mut World| {
            let mut all: Vec<[u32; 3]> = world
                .query::<&Particle>()
                .iter(world)
                .map(|particle| particle.position.to_array().map(f32::to_bits))
                .collect();
            all.sort_unstable();
            all
        };
        let saved = self.app.run(places)?;
        self.key(Key::SPACE)?;
        self.key(Key::ONE)?;
        self.app.frames(8)?;
        self.check("then there is another box", self.app.run(bodies)? == at_first + 2)?;
        self.key(Key::SPACE)?;
        self.check("and all has moved", self.app.run(places)? != saved)?;
        self.key(Key::F9)?;
        self.find("Loaded playground.ron")?;
        self.check("F9 brings back the bodies", self.app.run(bodies)? == at_first + 1)?;
        self.check("where they were", self.app.run(places)? == saved)?;
        self.app.run(|world| {
            let mut store = world.resource_mut::<GizmoConfigStore>();
            store.config_mut::<SinewGizmoConfigGroup>().0.enabled = false;
        })?;
        self.draw_view(true)?;
        photograph(self.app, folder, "playground")?;
        self.draw_view(false)?;
        // The simulation continues from there.
        self.key(Key::SPACE)?;
        self.app.frames(8)?;
        self.check("and from there it goes on", self.app.run(places)? != saved)
    }

    fn check(&self, what: &str, is: bool) -> Result<(), String> {
        self.checks.set(self.checks.get() + 1);
        if is { Ok(()) } else { Err(format!("check failed: {what}")) }
    }

    fn until(&self, what: &str, is: fn(&mut World) -> bool) -> Result<(), String> {
        self.checks.set(self.checks.get() + 1);
        self.app.until(what, is)
    }

    fn tick(&self) -> Result<u64, String> {
        self.app.run(|world| world.resource::<SinewClock>().tick)
    }

    /// Switches drawing of the scene on or off: it takes a software renderer the longest.
    fn draw_view(&self, drawn: bool) -> Result<(), String> {
        self.app.run(move |world| {
            let mut cameras = world.query_filtered::<&mut Camera, With<PanOrbitCamera>>();
            cameras.iter_mut(world).for_each(|mut camera| camera.is_active = drawn);
        })?;
        self.app.frames(2)
    }

    /// The body with this name.
    fn body(&self, name: &'static str) -> Result<Entity, String> {
        let found = self.app.run(move |world| {
            let mut all = world.query_filtered::<(Entity, &Name), With<BodyParticles>>();
            all.iter(world).find(|(_, its)| its.as_str() == name).map(|(body, _)| body)
        })?;
        found.ok_or_else(|| format!("there is no {name}"))
    }

    /// The pixel at which a particle in the middle of a body is seen.
    fn seen(&self, body: Entity) -> Result<[f32; 2], String> {
        let pixel = self.app.run(move |world| {
            let members = world.get::<BodyParticles>(body)?;
            let middle = members.iter().nth(members.len() / 2)?;
            let place = world.get::<Particle>(middle)?.position;
            let mut cameras =
                world.query_filtered::<(&Camera, &GlobalTransform), With<PanOrbitCamera>>();
            let (camera, frame) = cameras.single(world).ok()?;
            let within = camera.world_to_viewport(frame, place).ok()?;
            Some(within.to_array())
        })?;
        pixel.ok_or_else(|| "a body is not in view".to_owned())
    }

    /// The rectangle of the topmost text that starts like this, once it is stable.
    fn find(&self, text: &'static str) -> Result<egui::Rect, String> {
        let mut last = None;
        for _ in 0..40 {
            let found = self.app.run(move |world| place(world, text))?;
            // It must be at the same place in two frames: a panel that is being laid out or scrolled cannot be clicked yet.
            if let Some(place) = found.filter(|_| found == last) {
                return Ok(place);
            }
            last = found;
        }
        Err(format!("no \"{text}\" is visible"))
    }

    /// Scrolls the panel from the top until a text is visible.
    fn scroll_to(&self, text: &'static str) -> Result<egui::Rect, String> {
        self.hand.point(150.0, 400.0)?;
        let is_seen = move |world: &mut World| {
            place(world, text).filter(|place| place.center().y < 790.0).is_some()
        };
        self.turn(WHEEL_UP, 60)?;
        for _ in 0..60 {
            if self.app.run(is_seen)? {
                return self.find(text);
            }
            self.turn(WHEEL_DOWN, 3)?;
        }
        Err(format!("no \"{text}\" in the panel"))
    }

    fn turn(&self, wheel: u8, notches: usize) -> Result<(), String> {
        for _ in 0..notches {
            self.hand.button(wheel, true)?;
            self.hand.button(wheel, false)?;
        }
        self.app.frames(AFTER)
    }

    fn press(&self, at: [f32; 2], down: bool) -> Result<(), String> {
        self.hand.point(at[0], at[1])?;
        self.app.frames(AFTER - 1)?;
        self.hand.button(LEFT, down)?;
        self.app.frames(AFTER)
    }

    /// Clicks on the widget with this text.
    fn click(&self, text: &'static str) -> Result<(), String> {
        let at = self.find(text)?.center();
        self.press([at.x, at.y], true)?;
        self.press([at.x, at.y], false)
    }

    fn drag(&self, from: [f32; 2], to: [f32; 2]) -> Result<(), String> {
        self.press(from, true)?;
        self.press(to, false)
    }

    fn key(&self, key: Key) -> Result<(), String> {
        self.hand.key(key, true)?;
        self.app.frames(1)?;
        self.hand.key(key, false)?;
        self.app.frames(AFTER)
    }
}

/// The rectangle of the first text in the panel that starts like this.
fn place(world: &World, text: &str) -> Option<egui::Rect> {
    let texts = &world.resource::<Texts>().0;
    texts.iter().find(|(its, _)| its.starts_with(text)).map(|(_, place)| *place)
}

fn centre(world: &mut World, body: Entity) -> Vec3 {
    world.get::<WorldCenterOfMass>(body).map_or(Vec3::ZERO, |centre| centre.position)
}
