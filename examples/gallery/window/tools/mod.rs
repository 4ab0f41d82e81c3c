//! The tools of the playground: keys that act at the pointer, and a bar of buttons for the same tools.
//!
//! A key acts at once where the pointer is. A button arms its tool: every press in the view uses it until it is disarmed.
//!
//! | file | what it holds |
//! |---|---|
//! | `aim` | what is under the pointer, and an anchor to tie something there |
//! | `work` | what each tool does |
//! | `cut` | cutting cloth, ropes and springs, and their meshes |
//! | `file` | saving and loading |
//! | `bar` | the buttons |

mod aim;
mod bar;
mod cut;
mod file;
#[cfg(test)]
mod tests;
mod work;

use std::path::PathBuf;

use bevy::camera::Camera;
use bevy::picking::backend::ray::RayMap;
use bevy::picking::pointer::{PointerAction, PointerButton, PointerId, PointerInput};
use bevy::prelude::*;
use bevy_egui::input::EguiWantsInput;
use bevy_sinew::{MouseDrag, RegisterState};
use sinew_panel::{Recording, Selection};
use sinew_scenes::{OnStage, Toy};

pub(super) use bar::bar;

use aim::PickedPoint;
use work::Hook;

/// The scene that has the tools.
const SCENE: &str = "playground";

/// A tool that acts at the pointer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Tool {
    /// Spawns a body where the pointer is.
    Spawn(Toy),
    /// Pins a point of a body where it is, or removes the pin.
    Pin,
    /// Places the first and the second end of a rod or of a rope.
    Rod,
    Rope,
    /// Cuts what is near the pointer.
    Cut,
    /// Shoots a ball from the camera.
    Shoot,
    /// Removes a body.
    Remove,
    Save,
    Load,
}

/// Each tool with its key.
const TOOLS: [(Tool, KeyCode); 14] = [
    (Tool::Spawn(Toy::Crate), KeyCode::Digit1),
    (Tool::Spawn(Toy::Ball), KeyCode::Digit2),
    (Tool::Spawn(Toy::Rope), KeyCode::Digit3),
    (Tool::Spawn(Toy::Cloth), KeyCode::Digit4),
    (Tool::Spawn(Toy::Jelly), KeyCode::Digit5),
    (Tool::Spawn(Toy::Ragdoll), KeyCode::Digit6),
    (Tool::Pin, KeyCode::KeyP),
    (Tool::Rod, KeyCode::KeyT),
    (Tool::Rope, KeyCode::KeyY),
    (Tool::Cut, KeyCode::KeyX),
    (Tool::Shoot, KeyCode::KeyF),
    (Tool::Remove, KeyCode::Delete),
    (Tool::Save, KeyCode::F5),
    (Tool::Load, KeyCode::F9),
];

impl Tool {
    fn name(self) -> &'static str {
        match self {
            Self::Spawn(toy) => toy.name(),
            Self::Pin => "Pin",
            Self::Rod => "Rod",
            Self::Rope => "Tie",
            Self::Cut => "Cut",
            Self::Shoot => "Shoot",
            Self::Remove => "Remove",
            Self::Save => "Save",
            Self::Load => "Load",
        }
    }

    fn hint(self) -> &'static str {
        match self {
            Self::Spawn(_) => {
                "Spawns one at the pointer, or in front of the camera if nothing is there."
            }
            Self::Pin => "Pins a point of a body. On a pin: removes it.",
            Self::Rod => "Connects two points by a rod: click both.",
            Self::Rope => "Connects two points by a rope: click both.",
            Self::Cut => "Cuts cloth, ropes and rods under the pointer while it is pressed.",
            Self::Shoot => "Shoots a ball of 4 kg from the camera.",
            Self::Remove => "Removes the body or the pin under the pointer.",
            Self::Save => "Saves everything to the file.",
            Self::Load => "Loads everything from the file. An invalid file changes nothing.",
        }
    }

    /// Whether it repeats while the key or the button is down.
    fn repeats(self) -> bool {
        self == Self::Cut
    }

    /// Whether it needs no place and acts as soon as its button is clicked.
    fn is_immediate(self) -> bool {
        matches!(self, Self::Save | Self::Load)
    }
}

/// State of the tools.
#[derive(Resource)]
pub(super) struct Tools {
    /// The tool that a press in the view uses, instead of dragging.
    armed: Option<Tool>,
    /// Actions to carry out in this frame, and their rays.
    actions: Vec<(Tool, Ray3d)>,
    /// The tool that was clicked in the bar and needs no place.
    clicked: Option<Tool>,
    /// The first end of a rod or a rope, and the marker at it.
    first: Option<(PickedPoint, Entity)>,
    /// Number of bodies spawned so far: it selects the colour of the next.
    spawned: usize,
    /// Path of the file to save to and load from.
    pub(super) path: PathBuf,
    /// Message about the last action.
    message: String,
}

impl Default for Tools {
    fn default() -> Self {
        let program = std::env::current_exe().unwrap_or_default();
        let folder = program.parent().map(PathBuf::from).unwrap_or_default();
        Self {
            armed: None,
            actions: Vec::new(),
            clicked: None,
            first: None,
            spawned: 0,
            path: folder.join("playground.ron"),
            message: String::new(),
        }
    }
}

impl Tools {
    /// Whether a press in the view uses a tool.
    pub(super) fn is_armed(&self) -> bool {
        self.armed.is_some()
    }
}

/// Adds the tools. They work with any pointer that has a ray, with a window or without.
pub(super) fn add(app: &mut App) {
    app.init_resource::<Tools>()
        .init_resource::<Recording>()
        .init_resource::<Selection>()
        .register_state::<Hook>()
        .add_systems(Update, (listen, work::work).chain());
}

/// Whether the current scene has the tools.
pub(super) fn is_on(stage: Option<&OnStage>) -> bool {
    stage.is_some_and(|stage| stage.scene.name == SCENE)
}

/// Reads keys, and presses of the pointer while a tool is armed.
fn listen(
    mut commands: Commands,
    mut tools: ResMut<Tools>,
    mut drag: ResMut<MouseDrag>,
    mut inputs: MessageReader<PointerInput>,
    mut down: Local<bool>,
    stage: Option<Res<OnStage>>,
    keys: Option<Res<ButtonInput<KeyCode>>>,
    egui: Option<Res<EguiWantsInput>>,
    rays: Res<RayMap>,
    cameras: Query<(Entity, &GlobalTransform), (With<Camera>, Without<Camera2d>)>,
) {
    if !is_on(stage.as_deref()) {
        inputs.clear();
        *down = false;
        put_away(&mut commands, &mut tools, &mut drag);
        return;
    }
    let (no_keys, no_pointer) = egui.map_or((false, false), |egui| {
        (egui.wants_keyboard_input(), egui.wants_any_pointer_input())
    });
    let Ok((camera, frame)) = cameras.single() else { return };
    let own = rays.iter().find(|(id, _)| id.pointer == PointerId::Mouse && id.camera == camera);
    let pointed = own.map(|(_, ray)| *ray);
    // A key that is pressed while the pointer is outside acts at the centre of the view.
    let ray = pointed.unwrap_or(Ray3d::new(frame.translation(), frame.forward()));

    let mut pressed = false;
    for input in inputs.read() {
        match input.action {
            PointerAction::Press(PointerButton::Primary) if !no_pointer => {
                (*down, pressed) = (true, true);
            }
            PointerAction::Release(PointerButton::Primary) | PointerAction::Cancel => *down = false,
            _ => {}
        }
    }
    let armed = tools.armed.filter(|tool| pressed || (*down && tool.repeats()));
    if let Some((tool, ray)) = armed.zip(pointed) {
        tools.actions.push((tool, ray));
    }
    if let Some(tool) = tools.clicked.take() {
        tools.actions.push((tool, ray));
    }
    if let Some(keys) = keys.filter(|_| !no_keys) {
        for (tool, key) in TOOLS {
            if keys.just_pressed(key) || (tool.repeats() && keys.pressed(key)) {
                tools.actions.push((tool, ray));
            }
        }
        if keys.just_pressed(KeyCode::Escape) {
            put_away(&mut commands, &mut tools, &mut drag);
        }
    }
    // An armed tool disables dragging.
    let button = tools.armed.is_none().then_some(PointerButton::Primary);
    if drag.button != button {
        drag.button = button;
    }
}

/// Disarms the tool and discards pending actions, so that the pointer drags again.
fn put_away(commands: &mut Commands, tools: &mut Tools, drag: &mut MouseDrag) {
    if tools.armed.take().is_some() {
        drag.button = Some(PointerButton::Primary);
    }
    if let Some((_, mark)) = tools.first.take() {
        commands.entity(mark).try_despawn();
    }
    tools.actions.clear();
    tools.clicked = None;
}
