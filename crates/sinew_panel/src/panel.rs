//! The panel itself: what it reads and writes, and the order of its sections.

use bevy::ecs::system::SystemParam;
use bevy::gizmos::config::GizmoConfigStore;
use bevy::prelude::*;
use bevy_egui::egui::Ui;
use bevy_sinew::{
    AirDrag, AirFlow, Charge, CreationOrder, Electric, Fluid, Gravity, SinewClock, SinewControl,
    SinewWorld, SolverConfig, TickTime, Wind,
};

use crate::history::{EnergyHistory, EnergySample};
use crate::keys::PanelKeys;
use crate::recording::{Recording, RecordingConfig};
use crate::sections;
use crate::selection::{Selected, Selection};
use crate::settings::PanelSettings;
use crate::widgets::section;

/// Everything that [`show`] reads and writes, for a system of a game to ask for.
///
/// A system that has it cannot ask for the same resources a second time: it finds them in the public fields.
#[derive(SystemParam)]
pub struct PanelParams<'w, 's> {
    /// Pause, single steps and speed.
    pub control: ResMut<'w, SinewControl>,
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
    /// The energies of the last seconds.
    pub history: Res<'w, EnergyHistory>,
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

/// What the panel remembers. Never part of the simulation's state.
#[derive(Resource)]
pub(crate) struct PanelState {
    /// Gravity before it was switched off.
    pub(crate) gravity: Option<Vec3>,
    /// Duration of a tick's substeps, smoothed.
    pub(crate) milliseconds: f32,
    /// The last tick that was looked at.
    tick: u64,
    /// Somebody looks at the plot: worth summing up the energies.
    energy: bool,
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
            energy: false,
            shown: false,
            was_shown: false,
            settings_path: PanelSettings::default_path().to_string_lossy().into_owned(),
            settings_said: None,
        }
    }
}

/// Draws the sections into any `Ui`, such as a side panel of a game's own. See the [crate docs](crate) for an example.
///
/// It takes the width that is there; 260 points and more look well.
pub fn show(ui: &mut Ui, panel: &mut PanelParams) {
    panel.state.shown = true;
    section(ui, "Time", |ui| sections::time(ui, panel));
    section(ui, "Selected body", |ui| sections::selected(ui, panel));
    section(ui, "Solver", |ui| sections::solver(ui, panel));
    section(ui, "World", |ui| sections::surroundings(ui, panel));
    section(ui, "Report", |ui| sections::report(ui, panel));
    let open = section(ui, "Energy", |ui| sections::energy(ui, &panel.history));
    panel.state.energy |= open;
    if sections::has_lines(panel) {
        section(ui, "View", |ui| sections::lines(ui, panel));
    }
    section(ui, "Settings", |ui| sections::files(ui, panel));
}

/// Follows the ticks: the time they took, and their energies while somebody looks.
pub(crate) fn sample(
    clock: Res<SinewClock>,
    took: Res<TickTime>,
    mut world: ResMut<SinewWorld>,
    mut history: ResMut<EnergyHistory>,
    mut state: ResMut<PanelState>,
) {
    history.rewind(clock.tick);
    if clock.tick == state.tick {
        return;
    }
    let milliseconds = took.substeps.as_secs_f32() * 1e3;
    // A clock that went back is another world.
    let share = if clock.tick < state.tick || state.milliseconds == 0.0 { 1.0 } else { 0.05 };
    state.milliseconds += (milliseconds - state.milliseconds) * share;
    state.tick = clock.tick;
    if state.energy {
        // Reading the ledger sums up forces in the solver's scratch: no change that anybody should hear of.
        let ledger = world.bypass_change_detection().ledger();
        history.push(clock.tick, EnergySample::new(clock.seconds, &ledger));
    }
}

/// Asks anew each frame whether somebody looks.
pub(crate) fn forget_who_looked(mut state: ResMut<PanelState>) {
    state.was_shown = state.shown;
    (state.energy, state.shown) = (false, false);
}
