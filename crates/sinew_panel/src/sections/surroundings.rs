//! The World section: gravity, air, winds, flows, fluids, and Coulomb's law if there are charges.

use bevy::prelude::*;
use bevy_egui::egui::{Label, RichText, Slider, Ui};
use bevy_sinew::{AirDrag, AirFlow, Electric, Fluid, Gravity, Wind};

use crate::params::PanelParams;
use crate::widgets::{number, row, vector};

/// Density of air, kg/m³, for the wind speed that belongs to a dynamic pressure.
const AIR: f32 = 1.225;

/// Writes `Gravity`, `AirDrag`, `Electric` and every `Wind`, `AirFlow` and `Fluid`.
pub(crate) fn surroundings(ui: &mut Ui, panel: &mut PanelParams) {
    gravity(ui, panel);

    let mut air = panel.air.0;
    let hint = "Fraction of their velocity that all particles lose per second.";
    if number(ui, "Air drag", hint, &mut air, AirDrag::default().0, |value| {
        Slider::new(value, 0.0..=1.0).fixed_decimals(2).suffix(" /s")
    }) {
        panel.air.0 = air;
    }

    let mut winds: Vec<_> = panel.winds.iter_mut().collect();
    winds.sort_by_key(|(_, order, ..)| **order);
    for (i, (entity, _, mut wind, name)) in winds.into_iter().enumerate() {
        let title = name.map_or_else(|| format!("Wind {}", i + 1), ToString::to_string);
        ui.push_id(entity.to_bits(), |ui| {
            if let Some(changed) = wind_sliders(ui, &title, &wind) {
                wind.set_if_neq(changed);
            }
        });
    }

    let mut flows: Vec<_> = panel.flows.iter_mut().collect();
    flows.sort_by_key(|(_, order, ..)| **order);
    for (i, (entity, _, mut flow, name)) in flows.into_iter().enumerate() {
        subtitle(ui, &name.map_or_else(|| format!("Air {}", i + 1), ToString::to_string));
        ui.push_id(entity.to_bits(), |ui| _ = flow.set_if_neq(air_flow_sliders(ui, *flow)));
    }
    let mut fluids: Vec<_> = panel.fluids.iter_mut().collect();
    fluids.sort_by_key(|(_, order, ..)| **order);
    for (i, (entity, _, mut fluid, name)) in fluids.into_iter().enumerate() {
        subtitle(ui, &name.map_or_else(|| format!("Fluid {}", i + 1), ToString::to_string));
        ui.push_id(entity.to_bits(), |ui| _ = fluid.set_if_neq(fluid_sliders(ui, *fluid)));
    }

    if !panel.charges.is_empty() {
        subtitle(ui, "Charges");
        let mut law = *panel.electric;
        let default = Electric::default();
        let hint = "Coulomb's constant K, N·m²/C²: the force of two charges is K·q·q/d².";
        let mut changed =
            number(ui, "Constant", hint, &mut law.constant, default.constant, |value| {
                Slider::new(value, 0.0..=1e12)
                    .logarithmic(true)
                    .smallest_positive(1.0)
                    .custom_formatter(|k, _| format!("{k:.2e}"))
            });
        let hint = "Distance within which the force of two charges is softened.";
        changed |= number(ui, "Softening", hint, &mut law.softening, default.softening, |value| {
            Slider::new(value, 0.0..=1.0).fixed_decimals(3).suffix(" m")
        });
        if changed {
            panel.electric.set_if_neq(law);
        }
    }
}

fn gravity(ui: &mut Ui, panel: &mut PanelParams) {
    let hint = "Gravitational acceleration, m/s².";
    let mut gravity = panel.gravity.0;
    let mut on = gravity != Vec3::ZERO;
    if row(ui, "Gravity", hint, |ui| {
        let size = format!("{:6.2} m/s²", gravity.length());
        ui.checkbox(&mut on, RichText::new(size).monospace()).on_hover_text("On or off.").changed()
    }) {
        if on {
            gravity = panel.state.gravity.take().unwrap_or_else(|| Gravity::default().0);
        } else {
            panel.state.gravity = Some(gravity);
            gravity = Vec3::ZERO;
        }
        panel.gravity.0 = gravity;
    }
    let Vec3 { x, y, z } = &mut gravity;
    if vector(ui, "", hint, [x, y, z], Gravity::default().0.to_array(), 0.05) {
        panel.gravity.0 = gravity;
    }
}

fn subtitle(ui: &mut Ui, title: &str) {
    ui.add_space(4.0);
    ui.add(Label::new(RichText::new(title).strong()).truncate());
}

/// The sliders of one wind. Returns the new wind if the user changed it.
fn wind_sliders(ui: &mut Ui, title: &str, wind: &Wind) -> Option<Wind> {
    subtitle(ui, title);
    // A wind of zero pressure has no direction. The last one is remembered, so that the wind rises again in the direction it had.
    let memory = ui.id().with("sinew_wind");
    let mut direction = WindDirection::of(wind.pressure);
    if direction.strength > 0.0 {
        ui.data_mut(|data| data.insert_temp(memory, (direction.heading, direction.tilt)));
    } else if let Some((heading, tilt)) = ui.data(|data| data.get_temp::<(f32, f32)>(memory)) {
        direction = WindDirection { heading, tilt, ..direction };
    }
    let mut wind = *wind;

    let speed = (2.0 * direction.strength / AIR).sqrt();
    let hint = format!("Dynamic pressure: ½ρv², now a breeze of {speed:.1} m/s.");
    let default = Wind::default();
    let usual = WindDirection::of(default.pressure);
    let mut aimed =
        number(ui, "Pressure", &hint, &mut direction.strength, usual.strength, |value| {
            Slider::new(value, 0.0..=200.0)
                .logarithmic(true)
                .smallest_positive(0.1)
                .custom_formatter(|x, _| format!("{x:.1}"))
                .suffix(" Pa")
        });
    let hint = "Direction in which the wind blows, about the vertical: 0° along x, 90° along −z.";
    aimed |= number(ui, "Heading", hint, &mut direction.heading, usual.heading, |value| {
        Slider::new(value, -180.0..=180.0).fixed_decimals(0).suffix(" °")
    });
    let hint = "Angle of the wind above the horizontal.";
    aimed |= number(ui, "Tilt", hint, &mut direction.tilt, usual.tilt, |value| {
        Slider::new(value, -90.0..=90.0).fixed_decimals(0).suffix(" °")
    });
    if aimed {
        wind.pressure = direction.pressure();
        ui.data_mut(|data| data.insert_temp(memory, (direction.heading, direction.tilt)));
    }

    let hint = "Amplitude of gusts, relative to the pressure.";
    let gusty = number(ui, "Gusts", hint, &mut wind.gusts, default.gusts, |value| {
        Slider::new(value, 0.0..=1.0).fixed_decimals(2)
    });
    (aimed || gusty).then_some(wind)
}

/// The sliders of a flow of air. Returns the flow as edited.
fn air_flow_sliders(ui: &mut Ui, mut flow: AirFlow) -> AirFlow {
    let default = AirFlow::default();
    let Vec3 { x, y, z } = &mut flow.velocity;
    let hint = "Velocity of the air, m/s.";
    vector(ui, "Velocity", hint, [x, y, z], default.velocity.to_array(), 0.05);
    let hint = "Amplitude of gusts, relative to the speed.";
    number(ui, "Gusts", hint, &mut flow.gusts, default.gusts, |value| {
        Slider::new(value, 0.0..=1.0).fixed_decimals(2)
    });
    flow
}

/// The sliders of a fluid. Returns the fluid as edited.
fn fluid_sliders(ui: &mut Ui, mut fluid: Fluid) -> Fluid {
    let default = Fluid::default();
    let Vec3 { x, y, z } = &mut fluid.current;
    let hint = "Velocity of the fluid, m/s.";
    vector(ui, "Current", hint, [x, y, z], default.current.to_array(), 0.05);
    let hint = "Fraction of its velocity that a submerged particle loses per second.";
    number(ui, "Drag", hint, &mut fluid.drag, default.drag, |value| {
        Slider::new(value, 0.0..=1.0).fixed_decimals(2).suffix(" /s")
    });
    fluid
}

/// A pressure as a magnitude, Pa, and a direction, degrees.
#[derive(Clone, Copy, Debug)]
struct WindDirection {
    strength: f32,
    heading: f32,
    tilt: f32,
}

impl WindDirection {
    fn of(pressure: Vec3) -> Self {
        let strength = pressure.length();
        let (mut heading, mut tilt) = (0.0, 0.0);
        if strength > 0.0 {
            tilt = (pressure.y / strength).clamp(-1.0, 1.0).asin().to_degrees();
            if pressure.xz() != Vec2::ZERO {
                // Adding 0.0 turns a negative zero into a positive one.
                heading = (-pressure.z).atan2(pressure.x).to_degrees() + 0.0;
            }
        }
        Self { strength, heading, tilt }
    }

    fn pressure(self) -> Vec3 {
        let (sin_heading, cos_heading) = self.heading.to_radians().sin_cos();
        let (sin_tilt, cos_tilt) = self.tilt.to_radians().sin_cos();
        self.strength * Vec3::new(cos_heading * cos_tilt, sin_tilt, -sin_heading * cos_tilt)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_aim_leads_back_to_its_pressure() {
        for pressure in [
            Vec3::X * 5.0,
            Vec3::NEG_X,
            Vec3::Z * 61.0,
            Vec3::Y * 3.0,
            Vec3::new(1.0, -2.0, 3.0),
            Vec3::ZERO,
        ] {
            let back = WindDirection::of(pressure).pressure();
            assert!(back.distance(pressure) <= 1e-5 * (1.0 + pressure.length()), "{pressure}");
        }
        assert_eq!(WindDirection::of(Vec3::NEG_Z).heading, 90.0);
    }
}
