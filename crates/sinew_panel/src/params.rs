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

/// System parameter with everything that [`show`](crate::show) reads and writes.
///
/// A system with this parameter must not request the same resources a second time; they are available as public fields.
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
    /// Drag of the air.
    pub air: ResMut<'w, AirDrag>,
    /// Coulomb's constant and its softening.
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
    /// The solver's particles and its report.
    pub world: Res<'w, SinewWorld>,
    /// Configuration of the lines, if the app has gizmos.
    pub gizmos: Option<ResMut<'w, GizmoConfigStore>>,
    /// Energies, momenta, errors and durations of the last seconds.
    pub history: Res<'w, PlotHistory>,
    /// The recorded ticks.
    pub recording: ResMut<'w, Recording>,
    /// When ticks are recorded, and the limits of that.
    pub recording_config: ResMut<'w, RecordingConfig>,
    /// The key bindings.
    pub keys: Res<'w, PanelKeys>,
    /// The selected body.
    pub selection: ResMut<'w, Selection>,
    pub(crate) selected: Selected<'w, 's>,
    pub(crate) commands: Commands<'w, 's>,
    pub(crate) state: ResMut<'w, PanelState>,
}
