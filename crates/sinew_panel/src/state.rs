//! What the panel remembers from frame to frame.

use std::path::{Path, PathBuf};

use bevy::prelude::*;

/// What is plotted over time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Plotted {
    #[default]
    Energy,
    Momentum,
    AngularMomentum,
    Error,
    Strain,
    Time,
}

/// What the panel remembers. Never part of the simulation's state.
#[derive(Resource)]
pub(crate) struct PanelState {
    /// Gravity before it was switched off.
    pub(crate) gravity: Option<Vec3>,
    /// Duration of a tick's substeps, smoothed.
    pub(crate) milliseconds: f32,
    /// The last tick that was looked at.
    pub(crate) tick: u64,
    /// Somebody looks at the plots: worth summing up the energies.
    pub(crate) plots: bool,
    /// What is plotted.
    pub(crate) plot: Plotted,
    /// Whether the time of each phase is plotted.
    pub(crate) by_phase: bool,
    /// Whether the panel has asked for phases to be measured.
    pub(crate) measured: bool,
    /// Somebody looks at the panel.
    pub(crate) shown: bool,
    /// Somebody did in the last frame.
    pub(crate) was_shown: bool,
    /// Where settings are saved.
    pub(crate) settings_path: String,
    /// How that went.
    pub(crate) settings_said: Option<Result<String, String>>,
}

impl Default for PanelState {
    fn default() -> Self {
        Self {
            gravity: None,
            milliseconds: 0.0,
            tick: 0,
            plots: false,
            plot: Plotted::default(),
            by_phase: false,
            measured: false,
            shown: false,
            was_shown: false,
            settings_path: default_settings_path().to_string_lossy().into_owned(),
            settings_said: None,
        }
    }
}

/// `settings.ron` beside the program, or in the working directory where that is not known.
pub(crate) fn default_settings_path() -> PathBuf {
    let program = std::env::current_exe().unwrap_or_default();
    program.parent().unwrap_or(Path::new("")).join("settings.ron")
}
