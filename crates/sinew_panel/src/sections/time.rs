//! Pause, single step, speed, and the clock.

use bevy_egui::egui::{Button, Slider, Ui, vec2};

use crate::panel::PanelParams;
use crate::widgets::{grouped, slider, value};

/// Writes `SinewControl`.
pub(crate) fn time(ui: &mut Ui, panel: &mut PanelParams) {
    let paused = panel.control.paused;
    ui.horizontal(|ui| {
        let width = (ui.available_width() - ui.spacing().item_spacing.x) / 2.0;
        let size = vec2(width, 24.0);
        let pause = Button::new(if paused { "▶  Run" } else { "⏸  Pause" }).min_size(size);
        if ui.add(pause).on_hover_text("Stops and starts simulated time.").clicked() {
            panel.control.paused = !paused;
        }
        let step = ui.add_enabled(paused, Button::new("⏭  Step").min_size(size));
        let hint = "Simulates one tick.";
        let step = step.on_hover_text(hint).on_disabled_hover_text("Pause first, then step.");
        if step.clicked() {
            panel.control.single_steps = panel.control.single_steps.saturating_add(1);
        }
    });
    let mut speed = panel.control.relative_speed;
    let rail = Slider::new(&mut speed, 0.05..=4.0)
        .logarithmic(true)
        .custom_formatter(|x, _| format!("{x:.2}"))
        .prefix("× ");
    let hint = "Simulated seconds for each second of the game, whose own clock is left alone.";
    if slider(ui, "Speed", hint, rail) {
        panel.control.relative_speed = speed;
    }
    let tick = grouped(panel.clock.tick);
    value(ui, "Tick", "Ticks simulated since the clock was set to zero.", &tick, "");
    let seconds = format!("{:.3}", panel.clock.seconds);
    value(ui, "Time", "Seconds simulated; gusts of wind depend on it.", &seconds, "s");
}
