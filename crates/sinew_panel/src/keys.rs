//! The keys of the panel.

use bevy::prelude::*;
use bevy_egui::input::EguiWantsInput;
use bevy_sinew::{PhaseSteps, SinewControl};

use crate::recording::Recording;
use crate::state::PanelState;

/// The keys that work while the panel is shown and egui does not want the keyboard, as where somebody types a number; `None` switches one off. The panel
/// names them. A resource that may be changed at any time.
#[derive(Resource, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Resource, Default, Clone, PartialEq)]
pub struct PanelKeys {
    /// Stops and starts simulated time. Default F2.
    pub pause: Option<KeyCode>,
    /// Goes back by one recorded tick, and pauses. Default F3.
    pub back: Option<KeyCode>,
    /// Simulates one tick while paused. Default F4.
    pub step: Option<KeyCode>,
    /// Shows the next phase of a tick while paused. Default F6.
    pub half_step: Option<KeyCode>,
    /// Selects nothing. Default Escape.
    pub deselect: Option<KeyCode>,
}

impl Default for PanelKeys {
    fn default() -> Self {
        Self {
            pause: Some(KeyCode::F2),
            back: Some(KeyCode::F3),
            step: Some(KeyCode::F4),
            half_step: Some(KeyCode::F6),
            deselect: Some(KeyCode::Escape),
        }
    }
}

impl PanelKeys {
    /// What the keys of time do, as a line for a screen; empty where there is none.
    pub(crate) fn line(&self) -> String {
        let keys = [
            (self.pause, "pauses"),
            (self.back, "goes back"),
            (self.step, "steps"),
            (self.half_step, "by a phase"),
        ];
        let said =
            keys.into_iter().filter_map(|(key, what)| Some(format!("{} {what}", name(key?))));
        said.collect::<Vec<_>>().join(", ")
    }
}

/// What a key is called on a screen: `N`, `Space`, `F3`.
pub(crate) fn name(key: KeyCode) -> String {
    let name = format!("{key:?}");
    let short = name.strip_prefix("Key").or_else(|| name.strip_prefix("Digit"));
    short.map_or(name.clone(), Into::into)
}

/// Does what the keys say.
pub(crate) fn press(
    keys: Option<Res<ButtonInput<KeyCode>>>,
    egui: Option<Res<EguiWantsInput>>,
    state: Res<PanelState>,
    bound: Res<PanelKeys>,
    mut control: ResMut<SinewControl>,
    mut phases: ResMut<PhaseSteps>,
    mut recording: ResMut<Recording>,
) {
    let Some(keys) = keys else { return };
    if !state.shown || egui.is_some_and(|egui| egui.wants_keyboard_input()) {
        return;
    }
    let pressed = |key: Option<KeyCode>| key.is_some_and(|key| keys.just_pressed(key));
    if pressed(bound.pause) {
        control.paused = !control.paused;
    }
    if pressed(bound.back) {
        recording.go_back();
    }
    if pressed(bound.step) && control.paused {
        control.step();
    }
    if pressed(bound.half_step) && control.paused {
        phases.step(&mut control);
    }
}
