//! Constraints and springs between particles: each is an entity of its own, which can be added, changed or despawned at run time.
//!
//! | file | constraints |
//! |---|---|
//! | `pairs` | of two particles: [`DistanceConstraint`], [`Spring`] |
//! | `joints` | angles: [`AngleConstraint`], [`HingeConstraint`], [`ConeConstraint`] |
//! | `sizes` | areas and volumes: [`AreaConstraint`], [`PatchConstraint`], [`TetrahedronConstraint`], [`VolumeConstraint`] |
//! | `shapes` | [`BendConstraint`], [`CoplanarConstraint`], [`CollinearConstraint`], [`RigidConstraint`] |
//! | `break_at` | limits at which one breaks: [`BreakAt`] |
//! | `any` | any kind, without a component of its own: [`AnyConstraint`] |
//!
//! Distances and springs are so numerous that they have lists of their own. All others, custom ones included, are registered as a [`ParticleConstraint`].

/// Implements what the constraint components have in common: `with_softness`, and [`ParticleConstraint`] from the numbers of the solver's kind. The component
/// must have the fields `particles` and `softness`.
macro_rules! solved_as {
    ($component:ident, |$this:ident| $kind:ident { $($numbers:tt)* }) => {
        impl $component {
            /// Returns the same constraint with this softness.
            pub fn with_softness(self, softness: Softness) -> Self {
                Self { softness, ..self }
            }
        }

        impl $crate::components::ParticleConstraint for $component {
            fn particles(&self) -> &[Entity] {
                &self.particles
            }

            fn kind(&self) -> sinew::ConstraintKind {
                let $this = self;
                let softness = $this.softness.into();
                sinew::ConstraintKind::$kind($kind { softness, $($numbers)* })
            }
        }
    };
}
mod any;
mod break_at;
mod joints;
mod pairs;
mod shapes;
mod sizes;

pub use any::AnyConstraint;
pub use break_at::BreakAt;
pub use joints::{AngleConstraint, ConeConstraint, HingeConstraint};
pub use pairs::{Bound, DistanceConstraint, Spring};
pub use shapes::{BendConstraint, CollinearConstraint, CoplanarConstraint, RigidConstraint};
pub use sizes::{
    AreaConstraint, PatchConstraint, SizeCorrection, TetrahedronConstraint, VolumeConstraint,
};

use bevy::ecs::component::Mutable;
use bevy::prelude::*;
use sinew::{ConstraintFault, ConstraintKind};

/// A constraint as a component: it lists its particles, and defines what must hold between them. Implement it for a component of your own and
/// [register](crate::RegisterParticleConstraint) that; it is then solved like the constraints of this crate.
///
/// A constraint needs a value, which is zero where it holds, and its gradients with respect to the particles: see [`sinew::Equation`], which also explains how
/// to test them. Adding, changing or despawning the component takes effect in the next tick. The results are cached: neither `particles` nor `kind` is called
/// in a tick in which no particle, spring or constraint was added, removed or changed, so they must depend on the component alone.
///
/// A constraint that cannot act (a particle is gone, or is listed twice, or a number of the kind is out of range) is set aside, with one
/// [`Refused`](crate::Refused) message; the rest is solved bit for bit as if it did not exist. A constraint whose particle is set aside waits for it, without a
/// message. Constraints are solved in the order in which their entities were created ([`CreationOrder`](crate::CreationOrder), which is added to a registered
/// component), whatever their types; several on one entity in the order in which their types were registered.
///
/// A registered component is part of the [state](crate::StateTypes): it is captured and restored with the rest, onto other entities if the fields that hold its
/// particles are marked `#[entities]`. To have it written to files, too, derive `Reflect` and call [`register_state`](crate::RegisterState::register_state).
///
/// ```
/// use bevy::prelude::*;
/// use bevy_sinew::{ParticleConstraint, RegisterParticleConstraint};
/// use bevy_sinew::prelude::*;
/// use bevy_sinew::sinew::{Equation, ConstraintKind, Points};
///
/// /// Keeps a particle on a ball.
/// #[derive(Component, Clone)]
/// struct OnBall {
///     #[entities]
///     particle: Entity,
///     centre: Vec3,
///     radius: f32,
/// }
///
/// impl ParticleConstraint for OnBall {
///     fn particles(&self) -> &[Entity] {
///         core::slice::from_ref(&self.particle)
///     }
///
///     fn kind(&self) -> ConstraintKind {
///         ConstraintKind::custom(Ball { centre: self.centre, radius: self.radius })
///     }
/// }
///
/// /// `C = ‖p - centre‖ - radius`, metres; its gradient points outward and has the length 1.
/// #[derive(Debug)]
/// struct Ball {
///     centre: Vec3,
///     radius: f32,
/// }
///
/// impl Equation for Ball {
///     fn evaluate(&self, points: &Points, gradients: &mut [Vec3]) -> f32 {
///         let from_centre = points.relative_to(0, self.centre);
///         gradients[0] = from_centre.normalize_or(Vec3::Y);
///         from_centre.length() - self.radius
///     }
/// }
///
/// let mut app = App::new();
/// app.add_plugins((MinimalPlugins, SinewPlugins));
/// app.register_particle_constraint::<OnBall>();
/// let particle = app.world_mut().spawn(Particle::at(Vec3::Y)).id();
/// app.world_mut().spawn(OnBall { particle, centre: Vec3::ZERO, radius: 1.0 });
/// # app.finish();
/// # app.update();
/// ```
pub trait ParticleConstraint: Component<Mutability = Mutable> + Clone {
    /// The particles that it connects, each once, in the order that its kind requires.
    fn particles(&self) -> &[Entity];

    /// The solver's constraint: what must hold between the particles.
    fn kind(&self) -> ConstraintKind;

    /// Validation beyond that of [`sinew::Constraint::fault`]: of the numbers of a custom kind, for instance. `None` by default.
    fn fault(&self) -> Option<ConstraintFault> {
        None
    }
}

/// Passes the components of this folder that implement [`ParticleConstraint`] to a macro, after its own arguments.
macro_rules! for_each_constraint {
    ($then:ident!($($first:tt)*)) => {
        $then!($($first)*
            $crate::components::AngleConstraint,
            $crate::components::HingeConstraint,
            $crate::components::ConeConstraint,
            $crate::components::AreaConstraint,
            $crate::components::PatchConstraint,
            $crate::components::TetrahedronConstraint,
            $crate::components::VolumeConstraint,
            $crate::components::BendConstraint,
            $crate::components::CoplanarConstraint,
            $crate::components::CollinearConstraint,
            $crate::components::RigidConstraint,
            $crate::components::AnyConstraint,
        )
    };
}
pub(crate) use for_each_constraint;
