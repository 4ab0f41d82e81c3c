//! The Solver section.

use bevy::prelude::*;
use bevy_egui::egui::{Button, ComboBox, Slider, Ui, vec2};
use bevy_sinew::{GradientAt, Integrator, Order, SolverConfig};

use crate::params::PanelParams;
use crate::widgets::{number, row};

/// Writes `SolverConfig`.
pub(crate) fn solver(ui: &mut Ui, panel: &mut PanelParams) {
    let mut config = *panel.config;

    let default = SolverConfig::default();

    let hint =
        "Parts that a tick is cut into: more make bodies stiffer, and cost time in proportion.";
    let mut changed =
        number(ui, "Substeps", hint, &mut config.substeps, default.substeps, |value| {
            Slider::new(value, 1..=64)
        });
    let hint = "The most rounds over all constraints in a substep.";
    changed |=
        number(ui, "Max sweeps", hint, &mut config.max_sweeps, default.max_sweeps, |value| {
            Slider::new(value, 1..=100).logarithmic(true)
        });
    let mut millimetres = config.tolerance * 1e3;
    let hint = "Error at which a substep stops sweeping early.";
    if number(ui, "Tolerance", hint, &mut millimetres, default.tolerance * 1e3, |value| {
        Slider::new(value, 0.0..=10.0)
            .logarithmic(true)
            .smallest_positive(1e-3)
            .custom_formatter(|x, _| if x < 1.0 { format!("{x:.4}") } else { format!("{x:.2}") })
            .suffix(" mm")
    }) {
        config.tolerance = millimetres * 1e-3;
        changed = true;
    }

    let hint = "How a step through time is made. Verlet keeps energy; explicit Euler is there to be compared with.";
    let integrators = [
        (Integrator::Verlet, "Verlet"),
        (Integrator::Leapfrog, "Leapfrog"),
        (Integrator::SemiImplicitEuler, "Semi-implicit Euler"),
        (Integrator::ExplicitEuler, "Explicit Euler"),
    ];
    changed |= choice(ui, "Integrator", hint, &mut config.integrator, &integrators);
    let hint = "Along which gradients rods are corrected. Bodies such as boxes ask for their own.";
    let gradients =
        [(GradientAt::Current, "Current positions"), (GradientAt::StepStart, "Start of the step")];
    changed |= choice(ui, "Gradient at", hint, &mut config.gradient_at, &gradients);
    let hint = "In which order constraints are enforced.";
    let orders = [
        (Order::GaussSeidel, "Gauss–Seidel"),
        (Order::MostViolatedFirst, "Most violated first"),
        (Order::Jacobi, "Jacobi"),
    ];
    changed |= choice(ui, "Order", hint, &mut config.order, &orders);
    let hint = "What nothing holds keeps its angular momentum, though corrections to the nearest point lose it.";
    changed |= row(ui, "Keep spin", hint, |ui| ui.checkbox(&mut config.keep_spin, "").changed());
    let hint = "Holds hard distances over many of them at once: what hangs to its pins, large grid cloth within, and ropes as chains. They do not stretch.";
    changed |= row(ui, "Long range", hint, |ui| ui.checkbox(&mut config.long_range, "").changed());
    let hint = "Large cloth takes its sweeps as smaller substeps of its own: as taut, at half of the work.";
    changed |= row(ui, "Microsteps", hint, |ui| ui.checkbox(&mut config.microsteps, "").changed());
    let hint = "Forgets velocities, so that everything walks to rest.";
    changed |= row(ui, "Statics", hint, |ui| ui.checkbox(&mut config.statics, "").changed());
    let hint = "Other threads help. They change how long it takes, and nothing else.";
    changed |= row(ui, "Threads", hint, |ui| ui.checkbox(&mut config.threads, "").changed());

    let tuned = config != SolverConfig::default();
    let size = vec2(ui.available_width(), 22.0);
    let reset = ui.add_enabled_ui(tuned, |ui| ui.add_sized(size, Button::new("Reset to defaults")));
    let reset = reset.inner;
    if reset
        .on_hover_text("10 substeps, 4 sweeps, 0.1 mm, Verlet, nearest point, cascade, threads.")
        .clicked()
    {
        config = SolverConfig::default();
        changed = true;
    }
    if changed {
        panel.config.set_if_neq(config);
    }
}

/// A drop-down of a few names. Returns whether the choice changed.
pub(super) fn choice<T: Copy + PartialEq>(
    ui: &mut Ui,
    label: &str,
    hint: &str,
    chosen: &mut T,
    names: &[(T, &str)],
) -> bool {
    row(ui, label, hint, |ui| {
        let mut changed = false;
        let name = names.iter().find(|(value, _)| value == chosen).map_or("", |(_, name)| name);
        ComboBox::from_id_salt(label).selected_text(name).show_ui(ui, |ui| {
            for &(value, name) in names {
                changed |= ui.selectable_value(chosen, value, name).changed();
            }
        });
        changed
    })
}
