//! How hard the solver tries: configuration, as a resource that may be edited live.

use bevy::prelude::*;
use sinew::SolverSettings;

/// Settings of the solver for the whole world. Values outside their range are clamped to it.
#[derive(Resource, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Resource, Default, Clone, PartialEq)]
pub struct SolverConfig {
    /// Substeps in a tick, 1 to 256. Default 10.
    pub substeps: u32,
    /// The most sweeps over all constraints in a substep, 1 to 1000. Default 4.
    pub max_sweeps: u32,
    /// Error in metres at which a substep stops sweeping early, 0 or more. Default 1e-4.
    pub tolerance: f32,
}

impl Default for SolverConfig {
    fn default() -> Self {
        let settings = SolverSettings::default();
        Self {
            substeps: settings.substeps,
            max_sweeps: settings.max_sweeps,
            tolerance: settings.tolerance,
        }
    }
}

impl From<SolverConfig> for SolverSettings {
    fn from(config: SolverConfig) -> Self {
        Self {
            substeps: config.substeps,
            max_sweeps: config.max_sweeps,
            tolerance: config.tolerance,
        }
    }
}
