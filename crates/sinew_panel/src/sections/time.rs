//! The Time section: pause, single step, speed, the clock, and the recording.

use bevy_egui::egui::{Button, Label, RichText, Slider, Ui, vec2};

use bevy_sinew::{PhaseStep, PhaseSystems};

use crate::params::PanelParams;
use crate::recording::{RecordWhen, Replay};
use crate::style::{GOOD, WARN};
use crate::widgets::{grouped, number, row, slider, value};

/// Width of the button for half-steps, points.
const HALF_STEP_WIDTH: f32 = 34.0;

/// Hint on what does not go back, for the controls that go back.
const NOT_RESTORED: &str = "Bodies, settings and gravity are restored. Other state of the game is not, unless it is registered (RegisterState). \
    Input is not replayed.";

/// Writes `SinewControl`, `PhaseSteps`, `Recording` and `RecordingConfig`.
pub(crate) fn time(ui: &mut Ui, panel: &mut PanelParams) {
    let paused = panel.control.paused;
    ui.horizontal(|ui| {
        let width =
            (ui.available_width() - HALF_STEP_WIDTH - 3.0 * ui.spacing().item_spacing.x) / 3.0;
        let width = width.floor();
        let size = vec2(width, 24.0);
        let can = panel.recording.can_go_back();
        let back = ui.add_enabled(can, Button::new("⏮  Back").min_size(size));
        let hint = format!("Goes back by one recorded tick and pauses. {NOT_RESTORED}");
        let back = back.on_hover_text(hint).on_disabled_hover_text("No earlier tick is recorded.");
        if back.clicked() {
            panel.recording.go_back();
        }
        let pause = Button::new(if paused { "▶  Run" } else { "⏸  Pause" }).min_size(size);
        if ui.add(pause).on_hover_text("Pauses and resumes simulated time.").clicked() {
            panel.control.paused = !paused;
        }
        let step = ui.add_enabled(paused, Button::new("⏭  Step").min_size(size));
        let hint = "Simulates one tick.";
        let step = step.on_hover_text(hint).on_disabled_hover_text("Pause first, then step.");
        if step.clicked() {
            panel.control.step();
        }
        half_step(ui, panel);
    });
    let keys = panel.keys.line();
    if let Some(phase) = panel.phases.shown() {
        shown(ui, phase);
    } else if !keys.is_empty() {
        ui.add(Label::new(RichText::new(keys).weak().small()).truncate());
    }
    let mut speed = panel.control.relative_speed;
    let hint = "Simulated seconds for each second of the game. The game's clock is not changed.";
    if number(ui, "Speed", hint, &mut speed, 1.0, |value| {
        Slider::new(value, 0.05..=4.0)
            .logarithmic(true)
            .custom_formatter(|x, _| format!("{x:.2}"))
            .prefix("× ")
    }) {
        panel.control.relative_speed = speed;
    }
    let tick = grouped(panel.clock.tick);
    value(ui, "Tick", "Ticks simulated since the clock was set to zero.", &tick, "");
    let seconds = format!("{:.3}", panel.clock.seconds);
    value(ui, "Time", "Seconds simulated; gusts of wind depend on it.", &seconds, "s");
    recorded(ui, panel);
}

/// The button that shows the state after the next phase.
fn half_step(ui: &mut Ui, panel: &mut PanelParams) {
    let size = vec2(ui.available_width(), 24.0);
    let button = ui.add_enabled(panel.control.paused, Button::new("½").min_size(size));
    let hint = "Half-step: shows the state at the end of the next phase, with its particles, meshes and lines. The tick is simulated as a whole, and its end is what is saved. Step, Run and Back leave this mode.";
    let button = button.on_hover_text(hint);
    if button.on_disabled_hover_text("Pause first, then step by phases.").clicked() {
        panel.phases.step(&mut panel.control);
    }
}

/// The line that names the phase that is shown.
fn shown(ui: &mut Ui, shown: PhaseStep) {
    let PhaseStep { substep, substeps, phase, next } = shown;
    let next = next.map_or("end of the tick", name_of);
    let text = format!("Substep {substep}/{substeps}: {}, next {next}", name_of(phase));
    let hint = "The view shows the state at the end of the first phase named; the next half-step shows the second.";
    note(ui, RichText::new(text).color(GOOD).small(), hint);
}

/// Short name of a phase.
fn name_of(phase: PhaseSystems) -> &'static str {
    match phase {
        PhaseSystems::AccumulateForces => "forces",
        PhaseSystems::Wind => "wind",
        PhaseSystems::Buoyancy => "buoyancy",
        PhaseSystems::Electric => "electric",
        PhaseSystems::Integrate => "integrate",
        _ => "constraints",
    }
}

/// The recording: whether it is on, its size, and the tick in it that the simulation is at.
fn recorded(ui: &mut Ui, panel: &mut PanelParams) {
    let mut on = panel.recording_config.when != RecordWhen::Never;
    let hint = "Records the state of the last ticks, to go back to. Of a large scene only every few ticks are recorded, to limit time and memory.";
    let ticks = grouped(panel.recording.len() as u64);
    let megabytes = panel.recording.bytes() as f64 * 1e-6;
    let size = RichText::new(format!("{ticks} ticks, {megabytes:.1} MB")).monospace();
    if row(ui, "Record", hint, |ui| ui.checkbox(&mut on, size).on_hover_text(hint).changed()) {
        panel.recording_config.when = if on { RecordWhen::Shown } else { RecordWhen::Never };
        if !on {
            panel.recording.clear();
        }
    }
    let (first, last) = {
        let mut ticks = panel.recording.ticks();
        let Some(first) = ticks.next() else { return problem(ui, panel) };
        (first, ticks.next_back().unwrap_or(first))
    };
    let mut tick = panel.clock.tick;
    let rail = Slider::new(&mut tick, first.tick..=last.tick.max(first.tick + 1));
    let hint = format!("Goes to a recorded tick and pauses. {NOT_RESTORED}");
    if slider(ui, "Go to tick", &hint, rail) {
        panel.recording.go_to(tick);
    }
    if panel.control.paused && panel.clock.tick < last.tick {
        let back = last.seconds - panel.clock.seconds;
        let text =
            format!("{back:.3} s before the last tick. Other state of the game was not restored.");
        note(ui, RichText::new(text).weak().small(), NOT_RESTORED);
    }
    match panel.recording.replay() {
        Replay::None => {}
        Replay::Same(ticks) => {
            let ticks = grouped(ticks);
            let text = RichText::new(format!("Replayed {ticks} ticks: identical."));
            note(
                ui,
                text.color(GOOD).small(),
                "Compared with the recording by a hash of all state.",
            );
        }
        Replay::Differs(tick) => {
            let tick = grouped(tick);
            let text = RichText::new(format!(
                "Differs from tick {tick} on; later recorded ticks dropped."
            ));
            let hint = "Something changed since: a setting, a body, or the game's behaviour.";
            note(ui, text.color(WARN).small(), hint);
        }
    }
    problem(ui, panel);
}

fn problem(ui: &mut Ui, panel: &PanelParams) {
    if let Some(problem) = panel.recording.problem() {
        let text = RichText::new(format!("Recording: {problem}.")).color(WARN).small();
        ui.add(Label::new(text).wrap());
    }
}

fn note(ui: &mut Ui, text: RichText, hint: &str) {
    ui.add(Label::new(text).wrap()).on_hover_text(hint);
}
