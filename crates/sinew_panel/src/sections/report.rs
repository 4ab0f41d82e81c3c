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
    value(ui, "Particles", "Particles in the solver.", &number, "");
    let number = count(simulation.distances().len());
    value(ui, "Distances", "Distance constraints in the solver.", &number, "");
    let number = count(simulation.constraints().len());
    let hint = "All other constraints: angles, volumes, shapes and those of the game.";
    value(ui, "Others", hint, &number, "");
    let number = count(simulation.colours());
    let hint = "Groups of constraints without common particles (graph colouring); each group is solved in parallel.";
    value(ui, "Colours", hint, &number, "");
    value(ui, "Substeps", "Substeps of the last tick.", &grouped(report.substeps.into()), "");
    let hint = "Sweeps over all constraints, summed over the substeps.";
    value(ui, "Sweeps", hint, &grouped(report.sweeps.into()), "");
    let number = grouped(report.most_sweeps.into());
    value(ui, "Most in a substep", "Largest number of sweeps in one substep.", &number, "");
    let (answer, color) = if report.converged { ("yes", GOOD) } else { ("no", WARN) };
    let hint = "Whether every substep reached the tolerance within its maximum number of sweeps.";
    colored_value(ui, None, "Converged", hint, answer, "", Some(color));
    let number = format!("{:.3}", report.error * 1e3);
    value(ui, "Largest error", "Largest residual of any hard constraint.", &number, "mm");
    let number = format!("{:.3}", report.strain * 1e2);
    let hint = "Largest residual of a hard distance, relative to its length.";
    value(ui, "Strain", hint, &number, "%");
    let number = format!("{:.3}", panel.state.milliseconds);
    let hint = "Time of a tick's substeps on this machine, smoothed.";
    value(ui, "Tick time", hint, &number, "ms");
    let frozen = report.frozen.len();
    let color = (frozen > 0).then_some(WARN);
    let hint = "Particles whose state became non-finite in the last tick and was reset.";
    colored_value(ui, None, "Frozen", hint, &count(frozen), "", color);
    let too_fast = report.too_fast.len();
    let color = (too_fast > 0).then_some(WARN);
    let hint = "Particles that were limited to the maximum speed in the last tick.";
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
    let velocities =
        format!("Displacement of each particle in the next {ahead} s at its velocity.");
    let long = SinewGizmoConfigGroup::METRES_PER_IMPULSE;
    let contacts =
        format!("Contacts along their normals, {long} m for each N·s; slows the solver a little.");
    let strong = SinewGizmoConfigGroup::METRES_PER_ACCELERATION;
    let forces = format!(
        "Accelerations of each particle by kind, {strong} m for each m/s²: gravity; springs, attractors and forces of the game; wind and air; fluids; charges and fields. After a half-step only their sum. Slows the solver."
    );
    let all: [(&mut bool, &str, &str); 14] = [
        (&mut layers.particles, "Particles", "Balls of their radius, orange if pinned."),
        (&mut layers.strain, "Strain", "Distances: green without strain, red from 2 % on."),
        (&mut layers.springs, "Springs", "Springs, yellow."),
        (&mut layers.colliders, "Colliders", "Outlines: sensors green, refused ones red."),
        (&mut layers.previous, "Last tick", "Lines from the positions of the last tick."),
        (&mut layers.velocities, "Velocities", &velocities),
        (&mut layers.contacts, "Contacts", &contacts),
        (&mut layers.forces, "Forces", &forces),
        (&mut layers.angles, "Angles", "Angles, hinges, cones and bends, magenta."),
        (&mut layers.volumes, "Volumes", "Area and volume constraints, teal."),
        (&mut layers.batches, "Batches", "Distances, coloured by batch (solved in parallel)."),
        (&mut layers.islands, "Islands", "Bodies, coloured by island."),
        (&mut layers.sleepers, "Sleepers", "Violet boxes around sleeping bodies."),
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
