//! Positional constraints: equations and inequalities between positions, enforced by moving the particles.
//!
//! Each constraint is the minimiser of `Σ mᵢ‖dᵢ‖²` subject to `C(p + d) = 0` (or `≥ 0`), in closed form, particle by particle.
//! For a scalar `C` that is `dᵢ = -wᵢ ∇ᵢC · C / Σ wⱼ‖∇ⱼC‖²` (lectures 4 and 5; Müller et al., *Position Based Dynamics*, 2007):
//! exact where `C` is linear along its gradient, one Newton step otherwise. An inequality that holds does nothing.
//!
//! Every file here holds one constraint: its data, its value and gradient, the derivation above the kernel, and its tests.
//! [`solve`](crate::solve) decides in which order the kernels run, and how often.

mod bounds;
mod distance;
mod pin;

pub use bounds::{InsideBox, Plane};
pub use distance::{Bound, Distance, DistanceFault};
pub use pin::Pin;

pub(crate) use bounds::Contacts;
pub(crate) use distance::{project, project_rod};

/// What is enforced on single particles. Distances are kept apart, in the [`Simulation`](crate::Simulation), because they are compiled
/// into a plan when they change; these may change at any step for free.
#[derive(Clone, Debug, Default)]
pub struct Constraints {
    /// Half-spaces that every particle stays in, such as the ground.
    pub planes: Vec<Plane>,
    /// Boxes that every particle stays inside.
    pub boxes: Vec<InsideBox>,
    /// Particles that are held at a point, or led along a path.
    pub pins: Vec<Pin>,
}
