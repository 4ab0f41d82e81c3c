//! Debug lines, in layers: particles, constraints coloured by strain, springs and more. Colliders are in `wires`.

use bevy::gizmos::config::GizmoConfigStore;
use bevy::prelude::*;

use super::gizmo_config::SinewGizmoConfigGroup;
use super::layers::{distinct, draw_angles, draw_batches, draw_forces, draw_volumes};
use super::wires::draw_colliders;
use crate::components::{
    BodyParticles, ParticleRow, Pinned, Sleep, Spring, WatchedContacts, WorldCenterOfMass,
};
use crate::world::SinewWorld;

/// Draws particles, constraints, colliders and contacts as lines, as [`SinewGizmoConfigGroup`] selects. Does nothing in an app without gizmos.
#[derive(Default)]
pub struct SinewGizmoPlugin;

impl Plugin for SinewGizmoPlugin {
    fn build(&self, _: &mut App) {}

    /// In `finish`, so that the order of the plugins does not matter.
    fn finish(&self, app: &mut App) {
        // Without a renderer there is no store of gizmo configurations.
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
        app.add_systems(
            PostUpdate,
            (
                (watch, watch_forces),
                draw_particles.run_if(shows(|layers| layers.particles || layers.islands)),
                draw_strain.run_if(shows(|layers| layers.strain && !layers.batches)),
                draw_forces.run_if(shows(|layers| layers.forces)),
                draw_angles.run_if(shows(|layers| layers.angles)),
                draw_volumes.run_if(shows(|layers| layers.volumes)),
                draw_batches.run_if(shows(|layers| layers.batches)),
                draw_springs.run_if(shows(|layers| layers.springs)),
                draw_colliders.run_if(shows(|layers| layers.colliders)),
                draw_motion.run_if(shows(|layers| layers.previous || layers.velocities)),
                draw_contacts.run_if(shows(|layers| layers.contacts)),
                draw_boxes.run_if(shows(|layers| layers.sleepers || layers.bounds)),
            ),
        );
    }
}

/// Run condition: whether the lines and a layer are enabled.
fn shows(
    layer: fn(&SinewGizmoConfigGroup) -> bool,
) -> impl FnMut(Res<GizmoConfigStore>) -> bool + Clone {
    move |store| {
        let (config, layers) = store.config::<SinewGizmoConfigGroup>();
        config.enabled && layer(layers)
    }
}

/// Enables the listing of all contacts while they are drawn, and restores the game's own setting after that.
fn watch(
    store: Res<GizmoConfigStore>,
    mut watched: ResMut<WatchedContacts>,
    mut before: Local<Option<bool>>,
) {
    let wanted = shows(|layers| layers.contacts)(store);
    if wanted && before.is_none() {
        *before = Some(watched.all);
        watched.all = true;
    } else if !wanted && let Some(before) = before.take() {
        watched.all = before;
    }
}

/// Enables the recording of forces while they are drawn.
fn watch_forces(store: Res<GizmoConfigStore>, mut world: ResMut<SinewWorld>) {
    let wanted = shows(|layers| layers.forces)(store);
    if wanted != world.tables.forces.is_some() {
        world.bypass_change_detection().tables.forces = wanted.then(Box::default);
    }
}

fn draw_particles(
    mut gizmos: Gizmos<SinewGizmoConfigGroup>,
    world: Res<SinewWorld>,
    rows: Query<(&ParticleRow, Has<Pinned>)>,
) {
    let particles = world.particles();
    let by_island = gizmos.config_ext.islands;
    for (row, pinned) in &rows {
        let Some(i) = row.within(particles) else { continue };
        let radius = particles.radius(i).max(0.01);
        let color = match world.simulation().island_of(i).filter(|_| by_island && !pinned) {
            Some(island) => distinct(island as usize),
            None if pinned => Color::srgb(1.0, 0.6, 0.1),
            None => Color::srgb(0.4, 0.8, 1.0),
        };
        gizmos
            .sphere(Isometry3d::from_translation(particles.position(i)), radius, color)
            .resolution(8);
    }
}

fn draw_strain(mut gizmos: Gizmos<SinewGizmoConfigGroup>, world: Res<SinewWorld>) {
    let particles = world.particles();
    for distance in world.simulation().distances() {
        let (a, b) =
            (particles.position(distance.a as usize), particles.position(distance.b as usize));
        let strain = if distance.rest > 0.0 { distance.error(a, b) / distance.rest } else { 0.0 };
        // Green without strain, red from 2 % on.
        let hue = 120.0 * (1.0 - (strain / 0.02).min(1.0));
        gizmos.line(a, b, Color::hsl(hue, 0.9, 0.5));
    }
}

fn draw_springs(
    mut gizmos: Gizmos<SinewGizmoConfigGroup>,
    world: Res<SinewWorld>,
    springs: Query<&Spring>,
    rows: Query<&ParticleRow>,
) {
    let particles = world.particles();
    let place = |entity| Some(particles.position(rows.get(entity).ok()?.within(particles)?));
    for spring in &springs {
        if let (Some(a), Some(b)) = (place(spring.a), place(spring.b)) {
            gizmos.line(a, b, Color::srgb(0.9, 0.9, 0.2));
        }
    }
}

/// Draws previous positions and velocities.
fn draw_motion(mut gizmos: Gizmos<SinewGizmoConfigGroup>, world: Res<SinewWorld>) {
    let SinewGizmoConfigGroup { previous, velocities, .. } = *gizmos.config_ext;
    let simulation = world.simulation();
    for i in 0..world.particles().len() {
        let now = world.particles().position(i);
        if previous {
            gizmos.line(simulation.step_start(i), now, Color::srgb(0.85, 0.85, 0.85));
        }
        if velocities {
            let ahead = simulation.velocity_now(i) * SinewGizmoConfigGroup::VELOCITY_SECONDS;
            if ahead.length_squared() > 1e-8 && ahead.is_finite() {
                gizmos.arrow(now, now + ahead, Color::srgb(0.3, 0.9, 0.95));
            }
        }
    }
}

/// Draws contacts and their impulses; sensors green.
fn draw_contacts(mut gizmos: Gizmos<SinewGizmoConfigGroup>, world: Res<SinewWorld>) {
    for impact in &world.report().impacts {
        let long = 0.05 + SinewGizmoConfigGroup::METRES_PER_IMPULSE * impact.impulse;
        let color =
            if impact.sensor { Color::srgb(0.3, 0.9, 0.5) } else { Color::srgb(1.0, 0.85, 0.2) };
        let at = Isometry3d::from_translation(impact.point);
        gizmos.sphere(at, 0.02, color).resolution(8);
        gizmos.arrow(impact.point, impact.point + impact.normal * long.min(2.0), color);
    }
}

/// Draws the boxes around bodies.
fn draw_boxes(
    mut gizmos: Gizmos<SinewGizmoConfigGroup>,
    world: Res<SinewWorld>,
    bodies: Query<(&BodyParticles, &WorldCenterOfMass, Option<&Sleep>)>,
    rows: Query<&ParticleRow>,
) {
    let particles = world.particles();
    let SinewGizmoConfigGroup { sleepers, bounds, .. } = *gizmos.config_ext;
    for (members, centre, sleep) in &bodies {
        let asleep = sleepers && sleep.is_some_and(|sleep| sleep.asleep);
        if !asleep && !bounds {
            continue;
        }
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for row in members.iter().filter_map(|one| rows.get(one).ok()?.within(particles)) {
            let (place, radius) = (particles.position(row), particles.radius(row));
            (low, high) = (low.min(place - radius), high.max(place + radius));
        }
        if !(low.cmple(high).all() && low.is_finite() && high.is_finite()) {
            continue;
        }
        let color = if asleep { Color::srgb(0.7, 0.45, 1.0) } else { Color::srgb(0.6, 0.65, 0.7) };
        let size = Transform::from_translation((low + high) * 0.5).with_scale(high - low);
        gizmos.cube(size, color);
        if bounds {
            gizmos.axes(Transform::from_translation(centre.position), 0.1);
        }
    }
}
