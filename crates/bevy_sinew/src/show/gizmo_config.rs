//! Configuration of the debug lines: which layers are drawn, their colours and their lengths.

use bevy::gizmos::config::GizmoConfigGroup;
use bevy::prelude::*;

/// Configuration of the lines of [`SinewGizmoPlugin`](crate::SinewGizmoPlugin). The group is disabled by default: enable it through Bevy's `GizmoConfigStore`,
/// and select its layers here.
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
    /// Particles as balls of their radius: blue, or orange if pinned. Default on.
    pub particles: bool,
    /// Distances as lines, coloured by strain: from green (none) to red (2 % or more). Default on.
    pub strain: bool,
    /// Springs as yellow lines. Default on.
    pub springs: bool,
    /// Outlines of colliders: grey, green for sensors, blue for rigid parts, red if set aside. Default on.
    pub colliders: bool,
    /// A line from the position of each particle at the start of the last tick to its current one. Default off.
    pub previous: bool,
    /// The velocity of each particle, as its displacement in [`VELOCITY_SECONDS`](Self::VELOCITY_SECONDS). Default off.
    pub velocities: bool,
    /// Contacts of the last tick: a line along the normal, with a length proportional to the impulse ([`METRES_PER_IMPULSE`](Self::METRES_PER_IMPULSE)). Sets
    /// [`WatchedContacts::all`](crate::WatchedContacts::all). Default off.
    pub contacts: bool,
    /// Accelerations of each particle: an arrow for each kind of force ([`METRES_PER_ACCELERATION`](Self::METRES_PER_ACCELERATION)), in the colours of
    /// [`FORCES`](Self::FORCES); in a [phase step](crate::PhaseSteps) their sum so far, white. Default off.
    pub forces: bool,
    /// Angles, hinges, cones and bends, magenta. Default off.
    pub angles: bool,
    /// Constraints on areas and volumes, teal. Default off.
    pub volumes: bool,
    /// Distances coloured by batch (those that are solved side by side) instead of by strain. Default off.
    pub batches: bool,
    /// Particles coloured by island (those that are solved together). Default off.
    pub islands: bool,
    /// A violet box around each sleeping body. Default off.
    pub sleepers: bool,
    /// The bounding box of each body, and its centre of mass. Default off.
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
    /// Time for which a velocity is drawn, seconds.
    pub const VELOCITY_SECONDS: f32 = 0.1;
    /// Length of the arrow of an acceleration, m/(m/s²): 0.2 m for gravity.
    pub const METRES_PER_ACCELERATION: f32 = 0.02;
    /// The kinds of forces and their colours, in the order of the [phases](crate::PhaseSystems) that sum them up: gravity; springs, attractors and custom
    /// forces; wind and air flow; buoyancy, drag and currents of fluids; charges and electric fields.
    pub const FORCES: [(&str, Color); 5] = [
        ("gravity", Color::srgb(0.95, 0.95, 0.95)),
        ("springs, own", Color::srgb(1.0, 0.5, 0.2)),
        ("wind", Color::srgb(0.3, 0.9, 0.95)),
        ("fluid", Color::srgb(0.25, 0.5, 1.0)),
        ("electric", Color::srgb(1.0, 0.85, 0.2)),
    ];
    /// Length of the line of a contact, m/(N·s), in addition to 0.05 m.
    pub const METRES_PER_IMPULSE: f32 = 0.1;
}
