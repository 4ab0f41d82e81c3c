//! What holds particles together: each constraint and each spring is an entity of its own, to add, change or despawn at run time.
//!
//! | file | what it keeps |
//! |---|---|
//! | `pairs` | two particles: [`DistanceConstraint`], [`Spring`] |
//! | `joints` | angles: [`AngleConstraint`], [`HingeConstraint`], [`ConeConstraint`] |
//! | `sizes` | areas and volumes: [`AreaConstraint`], [`PatchConstraint`], [`TetrahedronConstraint`], [`VolumeConstraint`] |
//! | `shapes` | [`BendConstraint`], [`CoplanarConstraint`], [`CollinearConstraint`], [`RigidConstraint`] |
//! | `break_at` | at what force or strain one breaks: [`BreakAt`] |
//! | `any` | any kind, without a component of its own: [`AnyConstraint`] |
//!
//! Distances and springs are so many that they have lists of their own. All others come in by one door, [`ParticleConstraint`], and so do a game's.

/// What each component of a kind of the solver's has beside its fields, of which `particles` and `softness` are two: [`ParticleConstraint`], by the other
/// numbers of its kind.
macro_rules! solved_as {
    ($component:ident, |$this:ident| $kind:ident { $($numbers:tt)* }) => {
        impl $component {
            /// The same, as hard as that.
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

/// A constraint as a component: it names particles, and says what must hold between them. Implement it for a component of your own and
/// [register](crate::RegisterParticleConstraint) that, and it is solved like the rest.
///
/// Particles, value and gradient are all that it takes; the value and the gradient are those of a [`sinew::Equation`], whose documentation says
/// what to check. Add, change or despawn the component at run time and the next tick knows. Nothing is asked again in between: neither `particles`
/// nor `kind` is called in a tick in which no particle, spring or constraint came, went or changed. So let them depend on the component alone.
///
/// A constraint that cannot act (a particle is gone, is named twice, or a number of the kind is out of range) is set aside, with one
/// [`Refused`](crate::Refused) message, and the rest goes on bit for bit as if it were not there. One whose particle is itself set aside waits for
/// it, silently. Constraints are solved in the order in which their entities were created ([`CreationOrder`](crate::CreationOrder), which comes with
/// a registered component), whatever their types; several on one entity in the order in which their types were registered.
///
/// A registered component is part of the [state](crate::StateTypes): it is captured and put back with the rest, onto other entities if the fields
/// that name its particles are marked `#[entities]`. To have it written to files, too, derive `Reflect` and call
/// [`register_state`](crate::RegisterState::register_state).
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
    /// The particles that it binds, each once, in the order that its kind asks for.
    fn particles(&self) -> &[Entity];

    /// What must hold between them.
    fn kind(&self) -> ConstraintKind;

    /// What is wrong with it beside what [`sinew::Constraint::fault`] finds: the numbers of a kind of one's own, which nobody else can check.
    /// Nothing by default.
    fn fault(&self) -> Option<ConstraintFault> {
        None
    }
}

/// Hands the components of this folder that are a [`ParticleConstraint`] to a macro, after what is said first: they are saved and solved alike.
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
