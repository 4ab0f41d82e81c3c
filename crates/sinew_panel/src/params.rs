//! What the panel reads and writes.

use bevy::ecs::system::SystemParam;
use bevy::gizmos::config::GizmoConfigStore;
use bevy::prelude::*;
use bevy_sinew::{
    AirDrag, AirFlow, Charge, CreationOrder, Electric, Fluid, Gravity, PhaseSteps, SinewClock,
    SinewControl, SinewWorld, SolverConfig, Wind,
};

use crate::history::PlotHistory;
use crate::keys::PanelKeys;
use crate::recording::{Recording, RecordingConfig};
use crate::selection::{Selected, Selection};
use crate::state::PanelState;

/// Everything that [`show`](crate::show) reads and writes, for a system of a game to ask for.
///
/// A system that has it cannot ask for the same resources a second time: it finds them in the public fields.
#[derive(SystemParam)]
pub struct PanelParams<'w, 's> {
    /// Pause, single steps and speed.
    pub control: ResMut<'w, SinewControl>,
    /// Half-steps through the phases of a tick.
    pub phases: ResMut<'w, PhaseSteps>,
    /// Ticks and seconds.
    pub clock: Res<'w, SinewClock>,
    /// The solver's settings.
    pub config: ResMut<'w, SolverConfig>,
    /// Gravity.
    pub gravity: ResMut<'w, Gravity>,
    /// The air's drag.
    pub air: ResMut<'w, AirDrag>,
    /// The law of charges.
    pub electric: ResMut<'w, Electric>,
    /// Every wind.
    pub winds:
        Query<'w, 's, (Entity, &'static CreationOrder, &'static mut Wind, Option<&'static Name>)>,
    /// Every flow of air.
    pub flows: Query<
        'w,
        's,
        (Entity, &'static CreationOrder, &'static mut AirFlow, Option<&'static Name>),
    >,
    /// Every fluid.
    pub fluids:
        Query<'w, 's, (Entity, &'static CreationOrder, &'static mut Fluid, Option<&'static Name>)>,
    /// Every charge.
    pub charges: Query<'w, 's, (), With<Charge>>,
    /// The solver's columns and its report.
    pub world: Res<'w, SinewWorld>,
    /// The switch of the lines.
    pub gizmos: Option<ResMut<'w, GizmoConfigStore>>,
    /// Energies, momenta, errors and times of the last seconds.
    pub history: Res<'w, PlotHistory>,
    /// The ticks of the last seconds.
    pub recording: ResMut<'w, Recording>,
    /// When and how much is recorded.
    pub recording_config: ResMut<'w, RecordingConfig>,
    /// The keys, which stand in the panel.
    pub keys: Res<'w, PanelKeys>,
    /// What is selected.
    pub selection: ResMut<'w, Selection>,
    pub(crate) selected: Selected<'w, 's>,
    pub(crate) commands: Commands<'w, 's>,
    pub(crate) state: ResMut<'w, PanelState>,
}
