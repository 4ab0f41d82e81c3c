//! The plugins: one for the simulation, and a group that most games add.

use bevy::app::PluginGroupBuilder;
use bevy::ecs::schedule::{InternedScheduleLabel, ScheduleLabel};
use bevy::prelude::*;

use crate::attach;
use crate::breaking::{self, Breakables, Broke};
use crate::changes::any_body_may_have_moved;
use crate::commands;
use crate::components::{self, AirDrag, Charge, CreationCounter, Drag, Electric, Gravity};
use crate::components::{
    ContactEnded, ContactImpulse, ContactStarted, MeshFollow, Toggled, TopologyChanged, TubeMesh,
    WatchedContacts, Weighs,
};
use crate::config::SolverConfig;
use crate::disabling;
use crate::messages::Refused;
use crate::recipes;
use crate::schedule::{
    self, PhaseSteps, SinewClock, SinewControl, SinewSystems, SinewTick, TickTime,
};
use crate::show::{mesh, tube};
use crate::step::{
    bodies, body_colliders, colliders, contact_cache, contact_shape, controls, environment,
    extract, gather, hulls, ignored, layout, links, motion, pins, representation, scatter, shares,
    sleep, teleports, touching, weights,
};
use crate::threads::{self, SinewWorkers};
use crate::world::{SinewWorld, load_deferred};

/// The simulation, the gizmos, and the interpolation of transforms between ticks for bodies with [`Interpolate`](crate::Interpolate). Dragging with the mouse
/// is a separate plugin, [`MouseDragPlugin`](crate::MouseDragPlugin).
///
/// Parts can be left out as from any plugin group: `SinewPlugins.build().disable::<SinewGizmoPlugin>()`.
pub struct SinewPlugins;

impl PluginGroup for SinewPlugins {
    fn build(self) -> PluginGroupBuilder {
        let group = PluginGroupBuilder::start::<Self>().add(SinewPlugin::default());
        #[cfg(feature = "gizmos")]
        let group = group.add(crate::show::SinewGizmoPlugin);
        #[cfg(feature = "interpolation")]
        let group = group.add(EasePlugin);
        group
    }
}

/// Interpolates the transforms of bodies with [`Interpolate`](crate::Interpolate) between ticks, through `bevy_transform_interpolation`.
#[cfg(feature = "interpolation")]
pub struct EasePlugin;

#[cfg(feature = "interpolation")]
impl Plugin for EasePlugin {
    fn build(&self, app: &mut App) {
        use crate::components::DrawnTransform;
        use crate::show::ease;
        use bevy_transform_interpolation::TransformEasingSystems as Easing;
        use bevy_transform_interpolation::prelude::TransformInterpolationPlugin;
        // After the ends of a tick are noted: an end without a start would undo what the game does with a new body before the next tick.
        // What is new has been played up to there, too, so that the game can teleport it before the next tick.
        app.add_systems(
            FixedLast,
            (ease::opt_in, ease::record_played.run_if(anything_eased))
                .chain()
                .after(Easing::UpdateEnd),
        )
        .add_observer(ease::opt_out);
        app.add_systems(
            SinewTick,
            ease::note_tick.after(SinewSystems::Extract).run_if(anything_eased),
        )
        .init_resource::<crate::carry::Jumps>()
        .add_systems(
            SinewTick,
            (
                ease::follow_jumps.run_if(ease::any_jump),
                ease::start_at_particles.run_if(anything_eased),
            )
                .chain()
                .after(attach::resolve::resolve_attachments)
                .before(layout::lay_out),
        )
        .add_systems(
            RunFixedMainLoop,
            ease::ease_played
                .after(Easing::Ease)
                .before(Easing::UpdateEasingTick)
                .run_if(schedule::is_time_scaled),
        )
        .add_systems(FixedFirst, ease::forget_drawn.run_if(any_with_component::<DrawnTransform>))
        .add_systems(
            RunFixedMainLoop,
            ease::note_drawn.after(Easing::Ease).after(ease::ease_played).run_if(anything_eased),
        );
        // A game may have added the plugin for its own transforms; its settings then apply.
        if app.is_plugin_added::<TransformInterpolationPlugin>() {
            return;
        }
        app.add_plugins(TransformInterpolationPlugin::default());
        // Scheduling a dozen systems on threads takes tens of microseconds in every tick, so they are skipped where nothing is interpolated.
        let sets = (Easing::Reset, Easing::UpdateStart).run_if(anything_eased);
        app.configure_sets(FixedFirst, sets)
            .configure_sets(FixedLast, Easing::UpdateEnd.run_if(anything_eased))
            .configure_sets(RunFixedMainLoop, Easing::Ease.run_if(anything_eased));
    }
}

/// Run condition: whether any transform is interpolated, by this crate or by the game.
#[cfg(feature = "interpolation")]
fn anything_eased(
    eased: Query<
        (),
        Or<(
            With<bevy_transform_interpolation::TranslationEasingState>,
            With<bevy_transform_interpolation::RotationEasingState>,
            With<bevy_transform_interpolation::ScaleEasingState>,
        )>,
    >,
) -> bool {
    !eased.is_empty()
}

/// The simulation. It works with `MinimalPlugins` and with `DefaultPlugins`; without a renderer nothing is drawn, and there are no errors.
pub struct SinewPlugin {
    tick: InternedScheduleLabel,
}

impl SinewPlugin {
    /// Runs the tick in another schedule than `FixedPostUpdate`, such as that of a rollback plugin. The step is `Time::delta` in that schedule. Steps should
    /// have nearly equal lengths: ropes and cloth whip if one differs from the one before it by more than a fifth.
    pub fn in_schedule(schedule: impl ScheduleLabel) -> Self {
        Self { tick: schedule.intern() }
    }
}

impl Default for SinewPlugin {
    fn default() -> Self {
        Self::in_schedule(FixedPostUpdate)
    }
}

impl Plugin for SinewPlugin {
    fn build(&self, app: &mut App) {
        // For apps that do not register types automatically. The types of the state are registered with their list.
        app.register_type::<commands::RelaxWorld>()
            .register_type::<Refused>()
            .register_type::<ContactStarted>()
            .register_type::<ContactImpulse>()
            .register_type::<commands::RelaxFinished>()
            .register_type::<ContactEnded>()
            .init_resource::<CreationCounter>()
            .init_resource::<TopologyChanged>()
            .init_resource::<Toggled>()
            .init_resource::<SinewWorld>()
            .init_resource::<SinewClock>()
            .init_resource::<SinewControl>()
            .init_resource::<TickTime>()
            .init_resource::<PhaseSteps>()
            .init_resource::<schedule::FixedTick>()
            .init_resource::<SinewWorkers>()
            .init_resource::<components::Orphans>()
            .init_resource::<SolverConfig>()
            .init_resource::<Gravity>()
            .init_resource::<AirDrag>()
            .init_resource::<Electric>()
            .init_resource::<Breakables>()
            .init_resource::<WatchedContacts>()
            .register_type::<WatchedContacts>()
            .add_message::<Broke>()
            .add_message::<Refused>()
            .add_message::<ContactStarted>()
            .add_message::<ContactEnded>()
            .add_message::<ContactImpulse>()
            .add_message::<commands::RelaxFinished>();
        app.add_observer(shares::remove_from_particles::<Charge>)
            .add_observer(shares::remove_from_particles::<Drag>)
            .add_observer(touching::note_orphan)
            .add_observer(disabling::note_disabled)
            .add_observer(disabling::note_enabled);
        crate::state::add(app);
        links::register_ours(app);
        schedule::configure(app, self.tick);
        recipes::add(app);
        // Again before the gather: what observes a new body may disable it.
        let follow = || disabling::follow_disabling.run_if(disabling::any_toggled);
        app.add_systems(
            SinewTick,
            (
                follow().before(SinewSystems::Build),
                follow().after(SinewSystems::Build).before(SinewSystems::Gather),
            ),
        );
        app.add_systems(
            SinewTick,
            (
                (
                    shares::distribute,
                    teleports::follow_teleports.run_if(any_body_may_have_moved),
                    motion::follow_velocities.run_if(motion::any_velocity_changed),
                    commands::apply_pending,
                    motion::apply_impulses,
                    attach::resolve::resolve_attachments,
                    layout::lay_out,
                    threads::update_workers,
                    gather::gather_particles,
                    contact_shape::resolve_shapes,
                    bodies::gather_bodies,
                    sleep::gather_sleep.run_if(sleep::any_sleep_changed),
                    pins::gather_pins,
                )
                    .chain(),
                (
                    environment::gather_environment,
                    colliders::resize_bounding_boxes,
                    colliders::gather_colliders,
                    ignored::gather_ignored,
                    controls::gather_controls,
                    links::notice_links,
                    representation::compile_compounds,
                    links::collect_constraints,
                    links::compile_links,
                    body_colliders::compile_body_colliders,
                    contact_cache::gather_contact_cache,
                    weights::gather_weights.run_if(any_with_component::<Weighs>),
                    hulls::compile_hulls,
                    breaking::gather_breakables,
                    (load_deferred, commands::run_relax).chain().run_if(commands::any_relax),
                )
                    .chain(),
            )
                .chain()
                .in_set(SinewSystems::Gather),
        );
        app.add_systems(
            SinewTick,
            (
                sleep::note_sleepers,
                scatter::scatter,
                colliders::store_motion,
                controls::drop_tick_forces,
                sleep::keep_sleep,
                contact_cache::keep_contact_cache,
                touching::write_contact_messages,
                breaking::break_constraints,
            )
                .chain()
                .in_set(SinewSystems::Scatter),
        );
        app.add_systems(
            SinewTick,
            (
                extract::extract_poses,
                extract::extract_motion,
                extract::extract_particles,
                extract::extract_particle_velocities,
                extract::extract_reports,
            )
                .chain()
                .in_set(SinewSystems::Extract),
        );
        app.add_systems(Last, links::note_gone);
        // Before transforms are propagated and bounds are computed, which read what is written here. If there is nothing to write, evaluating a condition takes
        // a tenth of the time of running a system on a thread.
        app.add_systems(
            PostUpdate,
            (
                mesh::deform_meshes.run_if(any_with_component::<MeshFollow>),
                tube::draw_tubes.run_if(any_with_component::<TubeMesh>),
            )
                .chain()
                .before(bevy::transform::TransformSystems::Propagate),
        );
        app.add_systems(
            PostUpdate,
            extract::show_poses
                .after(bevy::transform::TransformSystems::Propagate)
                .run_if(schedule::is_shown),
        );
    }
}
