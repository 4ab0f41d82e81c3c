//! Key bindings of the panel.

use bevy::prelude::*;
use bevy_egui::input::EguiWantsInput;
use bevy_sinew::{PhaseSteps, SinewControl};

use crate::recording::Recording;
use crate::state::PanelState;

/// Key bindings that are active while the panel is shown and egui does not use the keyboard, as it does for a text field; `None` disables one. The panel lists
/// them. A resource that may be changed at any time.
#[derive(Resource, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Resource, Default, Clone, PartialEq)]
pub struct PanelKeys {
    /// Pauses and resumes simulated time. Default F2.
    pub pause: Option<KeyCode>,
    /// Goes back by one recorded tick, and pauses. Default F3.
    pub back: Option<KeyCode>,
    /// Simulates one tick while paused. Default F4.
    pub step: Option<KeyCode>,
    /// Shows the state after the next phase of a tick while paused. Default F6.
    pub half_step: Option<KeyCode>,
    /// Clears the selection. Default Escape.
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
    /// One line for the screen that lists the keys of the Time section; empty if all are disabled.
    pub(crate) fn line(&self) -> String {
        let keys = [
            (self.pause, "pause"),
            (self.back, "back"),
            (self.step, "step"),
            (self.half_step, "half-step"),
        ];
        let said =
            keys.into_iter().filter_map(|(key, what)| Some(format!("{} {what}", name(key?))));
        said.collect::<Vec<_>>().join(", ")
    }
}

/// Name of a key for the screen: `N`, `Space`, `F3`.
pub(crate) fn name(key: KeyCode) -> String {
    let name = format!("{key:?}");
    let short = name.strip_prefix("Key").or_else(|| name.strip_prefix("Digit"));
    short.map_or(name.clone(), Into::into)
}

/// Applies the key bindings.
pub(crate) fn apply(
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
