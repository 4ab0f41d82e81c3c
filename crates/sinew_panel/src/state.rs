//! State that the panel keeps from frame to frame.

use std::path::{Path, PathBuf};

use bevy::prelude::*;

/// Choice of what is plotted over time.
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

/// State of the panel; never part of the simulation's state.
#[derive(Resource)]
pub(crate) struct PanelState {
    /// Gravity before it was switched off.
    pub(crate) gravity: Option<Vec3>,
    /// Duration of a tick's substeps, milliseconds, smoothed.
    pub(crate) milliseconds: f32,
    /// The last tick that was sampled.
    pub(crate) tick: u64,
    /// Whether the plots were drawn in this frame; only then are the energies summed up.
    pub(crate) plots: bool,
    /// What is plotted.
    pub(crate) plot: Plotted,
    /// Whether the duration of each phase is plotted.
    pub(crate) by_phase: bool,
    /// Whether the panel has switched on the measuring of phases.
    pub(crate) measured: bool,
    /// Whether the panel was drawn in this frame.
    pub(crate) shown: bool,
    /// Whether it was drawn in the last frame.
    pub(crate) was_shown: bool,
    /// Path that settings are saved to and loaded from.
    pub(crate) settings_path: String,
    /// Result of the last save or load, as shown.
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

/// `settings.ron` beside the executable, or in the working directory if that is not known.
pub(crate) fn default_settings_path() -> PathBuf {
    let program = std::env::current_exe().unwrap_or_default();
    program.parent().unwrap_or(Path::new("")).join("settings.ron")
}
