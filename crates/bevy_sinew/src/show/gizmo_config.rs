//! Which lines are drawn for whoever debugs, and in which colours and lengths.

use bevy::gizmos::config::GizmoConfigGroup;
use bevy::prelude::*;

/// Configures the lines of [`SinewGizmoPlugin`](crate::SinewGizmoPlugin): switch them on through Bevy's `GizmoConfigStore`, and choose their layers. Off by default.
///
/// ```
/// # use bevy::gizmos::config::GizmoConfigStore;
/// # use bevy::prelude::*;
/// # use bevy_sinew::SinewGizmoConfigGroup;
/// fn show_contacts(mut store: ResMut<GizmoConfigStore>) {
///     let (config, layers) = store.config_mut::<SinewGizmoConfigGroup>();
///     config.enabled = true;
///     layers.contacts = true;
/// }
/// ```
#[derive(Reflect, GizmoConfigGroup, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Default, Clone, PartialEq)]
pub struct SinewGizmoConfigGroup {
    /// Particles as balls of their radius: blue, or orange if they are pinned. Default on.
    pub particles: bool,
    /// Distances as lines, green where they hold to red from 2 % of strain on. Default on.
    pub strain: bool,
    /// Springs as yellow lines. Default on.
    pub springs: bool,
    /// Outlines of colliders: grey, green if they are sensors, blue of rigid parts, red if they are set aside. Default on.
    pub colliders: bool,
    /// From where each particle was when the last tick began to where it is. Default off.
    pub previous: bool,
    /// The way of each particle in the next [`VELOCITY_SECONDS`](Self::VELOCITY_SECONDS), at its velocity. Default off.
    pub velocities: bool,
    /// Contacts of the last tick: a line along the normal, as long as its impulse is hard: [`METRES_PER_IMPULSE`](Self::METRES_PER_IMPULSE). Asks for the
    /// contacts of all bodies ([`WatchedContacts::all`](crate::WatchedContacts::all)). Default off.
    pub contacts: bool,
    /// What accelerates each particle, an arrow for each kind, as long as it is strong ([`METRES_PER_ACCELERATION`](Self::METRES_PER_ACCELERATION)), in the
    /// colours of [`FORCES`](Self::FORCES); in a [half-step](crate::PhaseSteps) their sum so far, white. Default off.
    pub forces: bool,
    /// Angles, hinges, cones and bends, magenta. Default off.
    pub angles: bool,
    /// What keeps its area or its volume, teal. Default off.
    pub volumes: bool,
    /// Distances in a colour for each group that is solved side by side, instead of for their strain. Default off.
    pub batches: bool,
    /// Particles in a colour for each island: for what is solved together. Default off.
    pub islands: bool,
    /// Bodies that sleep as a violet box around their particles. Default off.
    pub sleepers: bool,
    /// The box around the particles of each body, and its centre of mass. Default off.
    pub bounds: bool,
}

impl Default for SinewGizmoConfigGroup {
    fn default() -> Self {
        Self {
            particles: true,
            strain: true,
            springs: true,
            colliders: true,
            previous: false,
            velocities: false,
            contacts: false,
            forces: false,
            angles: false,
            volumes: false,
            batches: false,
            islands: false,
            sleepers: false,
            bounds: false,
        }
    }
}

impl SinewGizmoConfigGroup {
    /// How far ahead a velocity is drawn, seconds.
    pub const VELOCITY_SECONDS: f32 = 0.1;
    /// Length of the arrow of an acceleration, m/(m/s²): 0.2 m for gravity.
    pub const METRES_PER_ACCELERATION: f32 = 0.02;
    /// The kinds of forces, by the [phases](crate::PhaseSystems) that sum them up, and their colours: gravity; springs, attractors and the game's own; wind and moving
    /// air; buoyancy, drag and currents of fluids; charges and their fields.
    pub const FORCES: [(&str, Color); 5] = [
        ("gravity", Color::srgb(0.95, 0.95, 0.95)),
        ("springs, own", Color::srgb(1.0, 0.5, 0.2)),
        ("wind", Color::srgb(0.3, 0.9, 0.95)),
        ("fluid", Color::srgb(0.25, 0.5, 1.0)),
        ("electric", Color::srgb(1.0, 0.85, 0.2)),
    ];
    /// Length of the line of a contact, m/(N·s), besides the 0.05 m that each has.
    pub const METRES_PER_IMPULSE: f32 = 0.1;
}
