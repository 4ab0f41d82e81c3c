//! The order of the panel's sections, and the sampling of its plots.

use bevy::prelude::*;
use bevy_egui::egui::Ui;
use bevy_sinew::{SinewClock, SinewWorld, TickTime};

use crate::history::{PlotHistory, PlotSample};
use crate::params::PanelParams;
use crate::sections;
use crate::state::{PanelState, Plotted};
use crate::widgets::section;

/// Draws the sections into a `Ui`, such as a side panel of a game. See the [crate docs](crate) for an example.
///
/// It fills the available width, which should be at least 260 points.
pub fn show(ui: &mut Ui, panel: &mut PanelParams) {
    panel.state.shown = true;
    section(ui, "Time", |ui| sections::time(ui, panel));
    section(ui, "Selected body", |ui| sections::selected(ui, panel));
    section(ui, "Solver", |ui| sections::solver(ui, panel));
    section(ui, "World", |ui| sections::surroundings(ui, panel));
    section(ui, "Report", |ui| sections::report(ui, panel));
    let open = section(ui, "Plots", |ui| sections::plots(ui, panel));
    panel.state.plots |= open;
    if sections::has_lines(panel) {
        section(ui, "View", |ui| sections::lines(ui, panel));
    }
    section(ui, "Settings", |ui| sections::files(ui, panel));
}

/// Samples the last tick: its duration always, the plotted values while the plots are shown.
pub(crate) fn sample(
    clock: Res<SinewClock>,
    took: Res<TickTime>,
    mut world: ResMut<SinewWorld>,
    mut history: ResMut<PlotHistory>,
    mut state: ResMut<PanelState>,
) {
    history.rewind(clock.tick);
    if clock.tick == state.tick {
        return;
    }
    let milliseconds = took.substeps.as_secs_f32() * 1e3;
    // After a clock that went back the average starts afresh.
    let share = if clock.tick < state.tick || state.milliseconds == 0.0 { 1.0 } else { 0.05 };
    state.milliseconds += (milliseconds - state.milliseconds) * share;
    state.tick = clock.tick;
    if state.plots {
        // Computing the ledger sums up forces in the solver's scratch memory; that is not a change of the world.
        let world = world.bypass_change_detection();
        let ledger = world.ledger();
        history.push(clock.tick, PlotSample::new(clock.seconds, &ledger, world.report(), &took));
    }
}

/// Resets the flags of what is shown, which [`show`] sets in each frame, and switches the measuring of phases on while they are plotted.
pub(crate) fn reset_shown(mut state: ResMut<PanelState>, took: Option<ResMut<TickTime>>) {
    let by_phase = state.plots && state.by_phase && state.plot == Plotted::Time;
    if by_phase != state.measured
        && let Some(mut took) = took
    {
        (took.by_phase, state.measured) = (by_phase, by_phase);
    }
    state.was_shown = state.shown;
    (state.plots, state.shown) = (false, false);
}
