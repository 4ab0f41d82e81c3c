//! How the solver fared in the last tick, and the lines that show it in the world.

use std::any::TypeId;

use bevy_egui::egui::Ui;
use bevy_sinew::SinewGizmoConfigGroup;

use crate::panel::PanelParams;
use crate::style::{GOOD, WARN};
use crate::widgets::{colored_value, grouped, row, value};

/// Only reads.
pub(crate) fn report(ui: &mut Ui, panel: &PanelParams) {
    let simulation = panel.world.simulation();
    let report = panel.world.report();
    let count = |n: usize| grouped(n as u64);

    let number = count(panel.world.particles().len());
    value(ui, "Particles", "Particles that the solver works on.", &number, "");
    let number = count(simulation.distances().len());
    value(ui, "Distances", "Distance constraints that the solver holds.", &number, "");
    let number = count(simulation.constraints().len());
    let hint = "All other constraints: angles, volumes, shapes and a game's own.";
    value(ui, "Other laws", hint, &number, "");
    let number = count(simulation.colours());
    let hint = "Groups of constraints that share no particle: each is solved side by side.";
    value(ui, "Colours", hint, &number, "");
    value(ui, "Substeps", "Parts of the last tick.", &grouped(report.substeps.into()), "");
    let hint = "Rounds over all constraints, summed over the substeps.";
    value(ui, "Sweeps", hint, &grouped(report.sweeps.into()), "");
    let number = grouped(report.most_sweeps.into());
    value(ui, "Most in a substep", "The most rounds that one substep took.", &number, "");
    let (answer, color) = if report.converged { ("yes", GOOD) } else { ("no", WARN) };
    let hint = "Whether every substep met the tolerance before its sweeps were spent.";
    colored_value(ui, None, "Converged", hint, answer, "", Some(color));
    let number = format!("{:.3}", report.error * 1e3);
    value(ui, "Largest error", "Largest error left in any hard constraint.", &number, "mm");
    let number = format!("{:.3}", report.strain * 1e2);
    let hint = "Largest error left in a hard distance, as a share of its length.";
    value(ui, "Strain", hint, &number, "%");
    let number = format!("{:.3}", panel.state.milliseconds);
    let hint = "Time that the substeps of a tick take on this machine, smoothed.";
    value(ui, "Tick time", hint, &number, "ms");
    let frozen = report.frozen.len();
    let color = (frozen > 0).then_some(WARN);
    let hint = "Particles that turned non-finite in the last tick and were put back.";
    colored_value(ui, None, "Frozen", hint, &count(frozen), "", color);
    let too_fast = report.too_fast.len();
    let color = (too_fast > 0).then_some(WARN);
    let hint = "Particles that were slowed down to the most speed in the last tick.";
    colored_value(ui, None, "Too fast", hint, &count(too_fast), "", color);
}

/// Whether there are gizmos to switch on and off.
pub(crate) fn has_lines(panel: &PanelParams) -> bool {
    let group = TypeId::of::<SinewGizmoConfigGroup>();
    panel.gizmos.as_ref().is_some_and(|store| store.get_config_dyn(&group).is_some())
}

/// Writes `enabled` of `SinewGizmoConfigGroup`.
pub(crate) fn lines(ui: &mut Ui, panel: &mut PanelParams) {
    let Some(store) = &mut panel.gizmos else { return };
    let group = TypeId::of::<SinewGizmoConfigGroup>();
    let Some(mut on) = store.get_config_dyn(&group).map(|(config, _)| config.enabled) else {
        return;
    };
    let hint = "Draws particles, springs and distances; red means 2 % of strain or more.";
    let changed = row(ui, "Lines", hint, |ui| {
        ui.checkbox(&mut on, "Particles and strain").on_hover_text(hint).changed()
    });
    if changed && let Some((config, _)) = store.get_config_mut_dyn(&group) {
        config.enabled = on;
    }
}
