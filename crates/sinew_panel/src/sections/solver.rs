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

    let hint = "Substeps of a tick. More make bodies stiffer, and cost time in proportion.";
    let mut changed =
        number(ui, "Substeps", hint, &mut config.substeps, default.substeps, |value| {
            Slider::new(value, 1..=64)
        });
    let hint = "Maximum number of sweeps over all constraints in a substep.";
    changed |=
        number(ui, "Max sweeps", hint, &mut config.max_sweeps, default.max_sweeps, |value| {
            Slider::new(value, 1..=100).logarithmic(true)
        });
    let mut millimetres = config.tolerance * 1e3;
    let hint = "Residual below which a substep stops sweeping early.";
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

    let hint = "Time integration. Verlet conserves energy; explicit Euler is for comparison only.";
    let integrators = [
        (Integrator::Verlet, "Verlet"),
        (Integrator::Leapfrog, "Leapfrog"),
        (Integrator::SemiImplicitEuler, "Semi-implicit Euler"),
        (Integrator::ExplicitEuler, "Explicit Euler"),
    ];
    changed |= choice(ui, "Integrator", hint, &mut config.integrator, &integrators);
    let hint = "Positions at which the gradients of hard distances are evaluated. Bodies such as boxes override it.";
    let gradients =
        [(GradientAt::Current, "Current positions"), (GradientAt::StepStart, "Start of the step")];
    changed |= choice(ui, "Gradient at", hint, &mut config.gradient_at, &gradients);
    let hint = "Order in which constraints are solved.";
    let orders = [
        (Order::GaussSeidel, "Gauss–Seidel"),
        (Order::MostViolatedFirst, "Most violated first"),
        (Order::Jacobi, "Jacobi"),
    ];
    changed |= choice(ui, "Order", hint, &mut config.order, &orders);
    let hint = "Restores the angular momentum that free and hanging bodies lose by corrections along current gradients.";
    changed |= row(ui, "Keep spin", hint, |ui| ui.checkbox(&mut config.keep_spin, "").changed());
    let hint = "Solves hard distances over long ranges as well: tethers to pins, spans within large grid cloth, a direct solver for ropes. Cloth and ropes then do not stretch.";
    changed |= row(ui, "Long range", hint, |ui| ui.checkbox(&mut config.long_range, "").changed());
    let hint =
        "Large cloth replaces its sweeps by smaller substeps: equally stiff at half the work.";
    changed |= row(ui, "Microsteps", hint, |ui| ui.checkbox(&mut config.microsteps, "").changed());
    let hint =
        "Discards velocities in every substep, so that everything converges to static equilibrium.";
    changed |= row(ui, "Statics", hint, |ui| ui.checkbox(&mut config.statics, "").changed());
    let hint = "Solves on several threads. The results do not change.";
    changed |= row(ui, "Threads", hint, |ui| ui.checkbox(&mut config.threads, "").changed());

    let tuned = config != SolverConfig::default();
    let size = vec2(ui.available_width(), 22.0);
    let reset = ui.add_enabled_ui(tuned, |ui| ui.add_sized(size, Button::new("Reset to defaults")));
    let reset = reset.inner;
    let hint = format!(
        "{} substeps, {} sweeps, {} mm, {}, gradients at: {}, {}.",
        default.substeps,
        default.max_sweeps,
        default.tolerance * 1e3,
        name_of(&default.integrator, &integrators),
        name_of(&default.gradient_at, &gradients).to_lowercase(),
        name_of(&default.order, &orders),
    );
    if reset.on_hover_text(hint).clicked() {
        config = SolverConfig::default();
        changed = true;
    }
    if changed {
        panel.config.set_if_neq(config);
    }
}

/// The name of a value; empty if it has none.
fn name_of<'a, T: PartialEq>(value: &T, names: &[(T, &'a str)]) -> &'a str {
    names.iter().find(|(own, _)| own == value).map_or("", |(_, name)| name)
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
        ComboBox::from_id_salt(label).selected_text(name_of(chosen, names)).show_ui(ui, |ui| {
            for &(value, name) in names {
                changed |= ui.selectable_value(chosen, value, name).changed();
            }
        });
        changed
    })
}
