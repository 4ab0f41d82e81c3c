//! Rendering: meshes that follow particles, and debug lines. The simulation reads nothing of it.

#[cfg(feature = "interpolation")]
pub(crate) mod ease;
#[cfg(feature = "gizmos")]
mod gizmo_config;
#[cfg(feature = "gizmos")]
pub(crate) mod gizmos;
#[cfg(feature = "gizmos")]
mod layers;
pub(crate) mod mesh;
pub(crate) mod tube;
#[cfg(feature = "gizmos")]
mod wires;

#[cfg(feature = "gizmos")]
pub use gizmo_config::SinewGizmoConfigGroup;
#[cfg(feature = "gizmos")]
pub use gizmos::SinewGizmoPlugin;

use bevy::ecs::system::SystemParam;
use bevy::math::{Mat3A, Vec3A};
use bevy::prelude::*;

use crate::frames::Frames;
use crate::schedule::{FixedTick, SinewControl};
use crate::world::SinewWorld;

/// The transform from the world into an entity's own frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    /// Origin of the frame, metres. Positions are first taken relative to it, so that they keep their precision kilometres from the world's origin.
    origin: Vec3,
    linear: Mat3A,
}

impl Frame {
    /// The current frame of an entity, computed on demand; `None` if its transform has no inverse.
    pub(crate) fn of(frames: &Frames, entity: Entity) -> Option<Self> {
        let transform = frames.matrix(entity)?.affine();
        let (origin, linear) = (transform.translation.into(), transform.matrix3.inverse());
        let valid = Vec3::is_finite(origin) && linear.is_finite();
        valid.then_some(Self { origin, linear })
    }

    /// The position at which a row is drawn, in the frame: at the end of the last tick, or interpolated.
    #[inline]
    pub(crate) fn place(&self, world: &SinewWorld, row: u32, ease: Option<Ease>) -> Vec3A {
        let i = row as usize;
        let drawn = match ease {
            Some(Ease { share, time_scaled: true }) => match world.played_at(i, share) {
                Some(place) => place - self.origin,
                None => world.simulation.particles.relative_to(i, self.origin),
            },
            Some(Ease { share, time_scaled: false }) => {
                let now = world.simulation.particles.relative_to(i, self.origin);
                let before = world.simulation.step_start(i) - self.origin;
                before + (now - before) * share
            }
            None => world.simulation.particles.relative_to(i, self.origin),
        };
        self.linear * Vec3A::from(drawn)
    }
}

/// Interpolation between two fixed ticks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ease {
    /// Fraction of the fixed tick that has passed since it began, 0 to 1.
    pub(crate) share: f32,
    /// Whether that differs from the fraction of the simulation's tick.
    pub(crate) time_scaled: bool,
}

/// Parameters of the interpolation between two ticks.
#[derive(SystemParam)]
pub(crate) struct Easing<'w> {
    control: Res<'w, SinewControl>,
    fixed_tick: Res<'w, FixedTick>,
    time: Res<'w, Time<Fixed>>,
}

impl Easing<'_> {
    /// Whether time passes.
    pub(crate) fn running(&self) -> bool {
        self.control.running()
    }

    /// The interpolation of an entity, if it has one (`eased`). A paused world is not interpolated.
    pub(crate) fn now(&self, eased: bool) -> Option<Ease> {
        let ease = || Ease {
            share: self.time.overstep_fraction(),
            time_scaled: self.fixed_tick.time_scaled,
        };
        (eased && self.running()).then(ease)
    }
}
