//! The Report section, on the solver's last tick, and the View section, with the layers of debug lines.

use std::any::TypeId;

use bevy::color::ColorToPacked;
use bevy_egui::egui::{Color32, Grid, Ui};
use bevy_sinew::SinewGizmoConfigGroup;

use crate::params::PanelParams;
use crate::style::{GOOD, WARN};
use crate::widgets::{colored_value, grouped, row, value};

/// Draws the report. It only reads.
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

/// Whether the app has the gizmos of Sinew.
pub(crate) fn has_lines(panel: &PanelParams) -> bool {
    let group = TypeId::of::<SinewGizmoConfigGroup>();
    panel.gizmos.as_ref().is_some_and(|store| store.get_config_dyn(&group).is_some())
}

/// Writes `enabled` and the layers of `SinewGizmoConfigGroup`.
pub(crate) fn lines(ui: &mut Ui, panel: &mut PanelParams) {
    let Some(store) = &mut panel.gizmos else { return };
    let group = TypeId::of::<SinewGizmoConfigGroup>();
    let found = store.get_config_dyn(&group).and_then(|(config, layers)| {
        Some((config.enabled, *layers.downcast_ref::<SinewGizmoConfigGroup>()?))
    });
    let Some((was_on, before)) = found else { return };
    let (mut on, mut layers) = (was_on, before);
    let hint = "Draws the layers below into the game's view.";
    row(ui, "Lines", hint, |ui| ui.checkbox(&mut on, "Shown").on_hover_text(hint));
    ui.add_enabled_ui(on, |ui| checkboxes(ui, &mut layers));
    if (on, layers) == (was_on, before) {
        return;
    }
    if let Some((config, own)) = store.get_config_mut_dyn(&group) {
        config.enabled = on;
        if let Some(own) = own.downcast_mut::<SinewGizmoConfigGroup>() {
            *own = layers;
        }
    }
}

/// One checkbox for each layer, in two columns.
fn checkboxes(ui: &mut Ui, layers: &mut SinewGizmoConfigGroup) {
    let ahead = SinewGizmoConfigGroup::VELOCITY_SECONDS;
    let velocities = format!("The way of each particle in the next {ahead} s.");
    let long = SinewGizmoConfigGroup::METRES_PER_IMPULSE;
    let contacts =
        format!("Contacts along their normals, {long} m for each N·s; slows the solver a little.");
    let strong = SinewGizmoConfigGroup::METRES_PER_ACCELERATION;
    let forces = format!(
        "What accelerates each particle, by kinds, {strong} m for each m/s²: gravity; springs, attractors and the game's own; wind and air; fluids; charges and fields. After a half-step their sum. Slows the solver."
    );
    let all: [(&mut bool, &str, &str); 14] = [
        (&mut layers.particles, "Particles", "Balls of their radius, orange if pinned."),
        (&mut layers.strain, "Strain", "Distances: green where they hold, red from 2 % on."),
        (&mut layers.springs, "Springs", "Springs, yellow."),
        (&mut layers.colliders, "Colliders", "Outlines: sensors green, set aside red."),
        (&mut layers.previous, "Last tick", "From where each particle was a tick ago."),
        (&mut layers.velocities, "Velocities", &velocities),
        (&mut layers.contacts, "Contacts", &contacts),
        (&mut layers.forces, "Forces", &forces),
        (&mut layers.angles, "Angles", "Angles, hinges, cones and bends, magenta."),
        (&mut layers.volumes, "Volumes", "What keeps its area or its volume, teal."),
        (&mut layers.batches, "Batches", "Distances: a colour for what is solved side by side."),
        (&mut layers.islands, "Islands", "A colour for what is solved together."),
        (&mut layers.sleepers, "Sleepers", "Violet boxes around what sleeps."),
        (&mut layers.bounds, "Bounds", "Boxes around bodies, and their centres of mass."),
    ];
    Grid::new("sinew_layers").num_columns(2).min_col_width(ui.available_width() * 0.45).show(
        ui,
        |ui| {
            for (i, (layer, name, hint)) in all.into_iter().enumerate() {
                ui.checkbox(layer, name).on_hover_text(hint);
                if i % 2 == 1 {
                    ui.end_row();
                }
            }
        },
    );
    if layers.forces {
        legend(ui);
    }
}

/// The legend of the force arrows: each kind in its colour.
fn legend(ui: &mut Ui) {
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 8.0;
        for (kind, color) in SinewGizmoConfigGroup::FORCES {
            let [red, green, blue, _] = ColorToPacked::to_u8_array(color.to_srgba());
            let kind = format!("— {kind}");
            ui.colored_label(Color32::from_rgb(red, green, blue), kind);
        }
    });
}
