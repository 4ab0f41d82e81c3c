//! The Selected body section.

use bevy::math::Vec3;
use bevy::prelude::Entity;
use bevy_egui::egui::{Button, Label, RichText, Ui, vec2};
use bevy_sinew::{Representation, RigidIntegrator, Sleep};

use super::solver::choice;
use crate::keys;
use crate::params::PanelParams;
use crate::selection::contacts;
use crate::style::{GOOD, WARN};
use crate::widgets::{colored_value, grouped, prefix, short, value, vector_value};

/// The most contacts that are listed.
const LISTED: usize = 4;

/// Writes `Representation` and `Sleep` of the body, and despawns a constraint.
pub(crate) fn selected(ui: &mut Ui, panel: &mut PanelParams) {
    let Some(body) = panel.selection.body else {
        let text = "Click a body, or set the resource Selection.";
        ui.add(Label::new(RichText::new(text).weak().small()).wrap());
        return;
    };
    let title = RichText::new(panel.selected.title(body)).strong();
    let said = panel.keys.deselect.map_or(String::new(), |key| {
        format!("{} or a click on empty space clears the selection.", keys::name(key))
    });
    ui.add(Label::new(title).truncate()).on_hover_text(said);
    let Some(readout) = panel.selected.readout(&panel.world, body) else {
        let text = "It was despawned. Going back in time restores it.";
        ui.add(Label::new(RichText::new(text).weak().small()).wrap());
        return;
    };

    let number = format!("{:.4}", readout.mass);
    value(ui, "Mass", "Sum of the masses of its particles.", &number, "kg");
    vector_value(ui, "Centre", "m", "Centre of mass, x y z in the world.", readout.centre);
    let hint = "Velocity of the centre of mass, x y z.";
    vector_value(ui, "Velocity", "m/s", hint, readout.velocity);
    if readout.particles > 1 {
        let hint = "Angular velocity about the centre of mass, x y z.";
        vector_value(ui, "Spin", "rad/s", hint, readout.spin);
        let hint = "Angular momentum about the centre of mass: inertia × spin, x y z.";
        vector_value(ui, "Ang. mom.", "kg·m²/s", hint, readout.angular_momentum);
        let inertia = readout.inertia;
        let diagonal = Vec3::new(inertia.x_axis.x, inertia.y_axis.y, inertia.z_axis.z);
        let hint = format!(
            "Moments of inertia about axes through the centre of mass along x, y and z; products xy {}, xz {}, yz {} kg·m².",
            short(inertia.x_axis.y.into()),
            short(inertia.x_axis.z.into()),
            short(inertia.y_axis.z.into()),
        );
        vector_value(ui, "Inertia", "kg·m²", &hint, diagonal);
    }
    energy(ui, "Kinetic", "Kinetic energy: sum of ½mv² over all particles.", readout.kinetic);
    if readout.particles > 1 {
        let hint = "Kinetic energy of the translation: ½Mv².";
        energy(ui, "  translation", hint, readout.of_centre);
        energy(ui, "  rotation", "Kinetic energy of the rotation: ½ω·Iω.", readout.of_spin);
        let inner = readout.kinetic - readout.of_centre - readout.of_spin;
        let hint = "The rest: particles that move relative to each other.";
        energy(
            ui,
            "  internal",
            hint,
            if inner.abs() < 1e-6 * readout.kinetic { 0.0 } else { inner },
        );
    }
    solved(ui, panel, body);
    touching(ui, panel, body);
    sleep(ui, panel, body);
    if let Some(now) = readout.representation {
        represented(ui, panel, body, now);
    }
    let number = grouped(readout.particles as u64);
    value(ui, "Particles", "Particles of the body.", &number, "");
    if readout.constraints > 0 {
        let number = grouped(readout.constraints as u64);
        value(ui, "Constraints", "Springs and constraints of the body.", &number, "");
        cut(ui, panel);
    }
}

fn energy(ui: &mut Ui, label: &str, hint: &str, joules: f64) {
    let (scale, unit) = prefix(joules);
    let number = format!("{:.3}", joules / scale);
    value(ui, label, hint, &number, &format!("{unit}J"));
}

/// The solver's residuals in the body's island.
fn solved(ui: &mut Ui, panel: &PanelParams, body: Entity) {
    let row = panel.selected.row(body);
    let Some(report) = row.and_then(|row| panel.world.simulation().island_report(row)) else {
        return;
    };
    let color = Some(if report.converged { GOOD } else { WARN });
    let number = format!("{:.4}", report.error * 1e3);
    let hint = "Largest residual of a hard constraint of the body and of all bodies connected to it (its island); green if within the tolerance.";
    colored_value(ui, None, "Error", hint, &number, "mm", color);
    let number = format!("{:.3}", report.strain * 1e2);
    let hint = "Largest residual of a hard distance, relative to its length.";
    value(ui, "Strain", hint, &number, "%");
    let hint = "Sweeps over its constraints, summed over the substeps of the tick.";
    value(ui, "Sweeps", hint, &grouped(report.sweeps.into()), "");
}

/// The contacts of the body, largest impulse first.
fn touching(ui: &mut Ui, panel: &PanelParams, body: Entity) {
    let mut all: Vec<_> = contacts(&panel.world, body).collect();
    all.sort_by(|a, b| b.1.impulse.total_cmp(&a.1.impulse));
    let hint =
        "Contacts with bodies, particles and colliders in the last tick. A sleeping body has none.";
    value(ui, "Contacts", hint, &grouped(all.len() as u64), "");
    for (other, impact) in all.iter().take(LISTED) {
        let name = other.map_or("despawned".into(), |other| panel.selected.title(other));
        let number = format!("{:.4}", impact.impulse);
        let hint = format!(
            "Impulse along the normal in the last tick. At {} {} {} m, with {name}.",
            short(impact.point.x.into()),
            short(impact.point.y.into()),
            short(impact.point.z.into()),
        );
        // As much of the name as fits beside the number.
        let short_name: String = name.chars().take(22).collect();
        value(ui, &format!("  {short_name}"), &hint, &number, "N·s");
    }
}

fn sleep(ui: &mut Ui, panel: &mut PanelParams, body: Entity) {
    let (answer, color, asleep) = match panel.selected.sleep(body) {
        None => ("awake, never sleeps".into(), None, false),
        Some(sleep) if sleep.asleep => ("asleep".into(), Some(GOOD), true),
        Some(sleep) => (format!("awake, at rest for {:.2} s", sleep.still), None, false),
    };
    let hint = "A body with the component Sleep is not simulated once it has been at rest for half a second.";
    colored_value(ui, None, "Sleep", hint, &answer, "", color);
    if asleep && ui.button("Wake").on_hover_text("Wakes the body.").clicked() {
        panel.commands.entity(body).entry::<Sleep>().and_modify(|mut one| one.wake());
    }
}

fn represented(ui: &mut Ui, panel: &mut PanelParams, body: Entity, now: Representation) {
    let mut chosen = now;
    let names = [
        (Representation::Particles, "Particles"),
        (Representation::Auto, "Auto"),
        (Representation::Rigid(RigidIntegrator::Leapfrog), "Rigid, leapfrog"),
        (Representation::Rigid(RigidIntegrator::Verlet), "Rigid, Verlet"),
        (Representation::Rigid(RigidIntegrator::Euler), "Rigid, Euler"),
    ];
    let hint = "How the body is simulated. Changing it keeps position, rotation and momenta.";
    if choice(ui, "Simulated as", hint, &mut chosen, &names) {
        panel.commands.entity(body).insert(chosen);
    }
}

/// The button that despawns the rod or spring nearest to the clicked point.
fn cut(ui: &mut Ui, panel: &mut PanelParams) {
    let Some(nearest) = panel.selected.nearest(&panel.selection) else { return };
    let what = if nearest.is_spring { "spring" } else { "rod" };
    let [a, b] = nearest.ends;
    let text = format!("Cut the nearest {what}: {} m", short(a.distance(b).into()));
    let size = vec2(ui.available_width(), 22.0);
    let hint = format!(
        "Despawns the {what} nearest to the clicked point, stretched by {:.2} %. No break message is sent.",
        nearest.strain * 100.0
    );
    if ui.add_sized(size, Button::new(text)).on_hover_text(hint).clicked() {
        panel.commands.entity(nearest.constraint).try_despawn();
    }
}
