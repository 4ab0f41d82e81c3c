//! Lines that mark the selected body in the game's view. They only read the simulation.

use bevy::gizmos::config::{GizmoConfigGroup, GizmoConfigStore};
use bevy::prelude::*;
use bevy_sinew::SinewWorld;

use crate::selection::{Selected, Selection, contacts};
use crate::state::PanelState;

/// Configures the lines at the selected body, through Bevy's `GizmoConfigStore`. On by default.
#[derive(Default, Reflect, GizmoConfigGroup)]
pub struct SinewPanelGizmos;

/// Adds the lines if the app has gizmos.
pub(crate) fn add(app: &mut App) {
    if !app.world().contains_resource::<GizmoConfigStore>() {
        return;
    }
    app.init_gizmo_group::<SinewPanelGizmos>();
    let store = app.world_mut().resource_mut::<GizmoConfigStore>().into_inner();
    let (config, _) = store.config_mut::<SinewPanelGizmos>();
    // Drawn in front of the body and of what hides it.
    config.depth_bias = -1.0;
    config.line.width = 3.0;
    app.add_systems(PostUpdate, draw.run_if(resource_exists::<SinewWorld>));
}

/// Colours of the axes at the centre of mass.
const AXES: [Color; 3] =
    [Color::srgb(0.95, 0.35, 0.3), Color::srgb(0.4, 0.85, 0.4), Color::srgb(0.35, 0.6, 1.0)];
const VELOCITY: Color = Color::srgb(0.3, 0.9, 0.95);
const CONTACT: Color = Color::srgb(1.0, 0.85, 0.2);
const CUT: Color = Color::srgb(1.0, 0.15, 0.1);

/// Draws a cross at the centre of mass, the velocity, the contacts with their normals, and the constraint that would be cut.
fn draw(
    mut gizmos: Gizmos<SinewPanelGizmos>,
    selection: Res<Selection>,
    selected: Selected,
    world: Res<SinewWorld>,
    state: Res<PanelState>,
) {
    let Some(body) = selection.body.filter(|_| state.was_shown) else { return };
    let Some(readout) = selected.readout(&world, body) else { return };
    let centre = readout.centre;
    for (axis, color) in Vec3::AXES.into_iter().zip(AXES) {
        gizmos.line(centre - axis * 0.15, centre + axis * 0.15, color);
    }
    if readout.velocity.length() > 0.01 {
        gizmos.arrow(centre, centre + readout.velocity * 0.25, VELOCITY);
    }
    for (_, impact) in contacts(&world, body) {
        let tip = impact.point + impact.normal * 0.15;
        gizmos.line(impact.point, tip, CONTACT);
        gizmos.sphere(Isometry3d::from_translation(impact.point), 0.02, CONTACT).resolution(8);
    }
    if let Some(nearest) = selected.nearest(&selection) {
        gizmos.line(nearest.ends[0], nearest.ends[1], CUT);
    }
}
