//! How hard the solver tries.

use bevy::prelude::*;
use bevy_egui::egui::{Button, Slider, Ui, vec2};
use bevy_sinew::SolverConfig;

use crate::panel::PanelParams;
use crate::widgets::slider;

/// Writes `SolverConfig`.
pub(crate) fn solver(ui: &mut Ui, panel: &mut PanelParams) {
    let mut config = *panel.config;

    let rail = Slider::new(&mut config.substeps, 1..=64);
    let hint =
        "Parts that a tick is cut into: more make bodies stiffer, and cost time in proportion.";
    let mut changed = slider(ui, "Substeps", hint, rail);

    let rail = Slider::new(&mut config.max_sweeps, 1..=100).logarithmic(true);
    let hint = "The most rounds over all constraints in a substep.";
    changed |= slider(ui, "Max sweeps", hint, rail);

    let mut millimetres = config.tolerance * 1e3;
    let rail = Slider::new(&mut millimetres, 0.0..=10.0)
        .logarithmic(true)
        .smallest_positive(1e-3)
        .custom_formatter(|x, _| if x < 1.0 { format!("{x:.4}") } else { format!("{x:.2}") })
        .suffix(" mm");
    let hint = "Error at which a substep stops sweeping early.";
    if slider(ui, "Tolerance", hint, rail) {
        config.tolerance = millimetres * 1e-3;
        changed = true;
    }

    let tuned = config != SolverConfig::default();
    let size = vec2(ui.available_width(), 22.0);
    let reset = ui.add_enabled_ui(tuned, |ui| ui.add_sized(size, Button::new("Reset to defaults")));
    let reset = reset.inner;
    if reset.on_hover_text("10 substeps, 4 sweeps, 0.1 mm.").clicked() {
        config = SolverConfig::default();
        changed = true;
    }
    if changed {
        panel.config.set_if_neq(config);
    }
}
