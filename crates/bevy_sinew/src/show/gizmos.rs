//! Lines for whoever debugs: particles, constraints coloured by strain, springs; colliders are in `wires`.

use bevy::gizmos::config::{GizmoConfigGroup, GizmoConfigStore};
use bevy::prelude::*;

use super::wires::draw_colliders;
use crate::components::{ParticleRow, Pinned, Spring};
use crate::world::SinewWorld;

/// Configures the lines of [`SinewGizmoPlugin`]: switch them on through Bevy's `GizmoConfigStore`. Off by default.
#[derive(Default, Reflect, GizmoConfigGroup)]
pub struct SinewGizmoConfigGroup;

/// Draws particles and what connects them, and colliders. Does nothing in an app without gizmos.
#[derive(Default)]
pub struct SinewGizmoPlugin;

impl Plugin for SinewGizmoPlugin {
    fn build(&self, _: &mut App) {}

    /// Not while building, so that the order of the plugins does not matter.
    fn finish(&self, app: &mut App) {
        // Without a renderer there is no store of gizmo configurations, and nobody to see a line.
        if !app.world().contains_resource::<GizmoConfigStore>() {
            return;
        }
        app.init_gizmo_group::<SinewGizmoConfigGroup>();
        let (config, _) = app
            .world_mut()
            .resource_mut::<GizmoConfigStore>()
            .into_inner()
            .config_mut::<SinewGizmoConfigGroup>();
        config.enabled = false;
        config.depth_bias = -0.5;
        app.add_systems(PostUpdate, (draw, draw_colliders).run_if(switched_on));
    }
}

fn switched_on(store: Res<GizmoConfigStore>) -> bool {
    store.config::<SinewGizmoConfigGroup>().0.enabled
}

fn draw(
    mut gizmos: Gizmos<SinewGizmoConfigGroup>,
    world: Res<SinewWorld>,
    springs: Query<&Spring>,
    rows: Query<(&ParticleRow, Has<Pinned>)>,
) {
    let particles = world.particles();
    for distance in world.simulation().distances() {
        let (a, b) =
            (particles.position(distance.a as usize), particles.position(distance.b as usize));
        let strain = if distance.rest > 0.0 { distance.error(a, b) / distance.rest } else { 0.0 };
        // Green where it holds, red from 2 % on.
        let hue = 120.0 * (1.0 - (strain / 0.02).min(1.0));
        gizmos.line(a, b, Color::hsl(hue, 0.9, 0.5));
    }
    for (row, pinned) in &rows {
        let Some(i) = row.get().filter(|&i| i < particles.len()) else { continue };
        let radius = particles.radius(i).max(0.01);
        let color = if pinned { Color::srgb(1.0, 0.6, 0.1) } else { Color::srgb(0.4, 0.8, 1.0) };
        gizmos
            .sphere(Isometry3d::from_translation(particles.position(i)), radius, color)
            .resolution(8);
    }
    for spring in &springs {
        let place = |entity| {
            let row = rows.get(entity).ok()?.0.get()?;
            (row < particles.len()).then(|| particles.position(row))
        };
        if let (Some(a), Some(b)) = (place(spring.a), place(spring.b)) {
            gizmos.line(a, b, Color::srgb(0.9, 0.9, 0.2));
        }
    }
}
