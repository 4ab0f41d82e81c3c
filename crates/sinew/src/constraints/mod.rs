//! Positional constraints: equations and inequalities between positions, enforced by moving the particles.
//!
//! Each constraint is the minimiser of `Σ mᵢ‖dᵢ‖²` subject to `C(p + d) = 0` (or `≥ 0`), in closed form, particle by particle.
//! For a scalar `C` that is `dᵢ = -wᵢ ∇ᵢC · C / Σ wⱼ‖∇ⱼC‖²` (lectures 4 and 5; Müller et al., *Position Based Dynamics*, 2007):
//! exact where `C` is linear along its gradient, one Newton step otherwise. An inequality that holds does nothing.
//!
//! | file | what it keeps |
//! |---|---|
//! | [`Distance`] | two particles at a distance, or nearer, or farther: the constraint that bodies are mostly made of, with dedicated kernels |
//! | [`Constraint`] | any other [`ConstraintKind`] between any particles; each kind is an [`Equation`], in a file of its own |
//! | [`Boundaries`] | constraints on every particle, or on a single one: planes, boxes, pins, the plane of a 2D world |
//! | [`Softness`] | how stiff any of them is |
//!
//! Every file holds a constraint's data, its value and gradient, the derivation above the kernel, and its tests. [`solve`](crate::solve) determines in which
//! order and how often the kernels run.

mod anchor;
mod angle;
mod area;
mod bend;
mod boundaries;
#[cfg(test)]
pub(crate) mod checks;
mod collinear;
mod cone;
mod constraint;
mod coplanar;
mod correction;
mod distance;
mod equation;
mod fault;
mod hinge;
mod patch;
mod pin;
mod planar_drag;
mod rigid;
mod softness;
mod tetrahedron;
mod towards;
mod volume;
mod wide;

pub use anchor::{Anchor, AnchorDistance, affine_weights};
pub use angle::Angle;
pub use area::Area;
pub use bend::Bend;
pub use boundaries::{Boundaries, InsideBox, Plane};
pub use collinear::Collinear;
pub use cone::Cone;
pub use constraint::{Constraint, ConstraintKind, Rows};
pub use coplanar::Coplanar;
pub use correction::{GradientAt, SizeCorrection};
pub use distance::{Distance, DistanceFault};
pub use equation::{Bound, Equation, Points};
pub use fault::ConstraintFault;
pub use hinge::Hinge;
pub use patch::Patch;
pub use pin::Pin;
pub use planar_drag::PlanarDrag;
pub use rigid::Rigid;
pub use softness::Softness;
pub use tetrahedron::Tetrahedron;
pub use volume::Volume;

pub(crate) use angle::Angles;
pub(crate) use area::Areas;
pub(crate) use bend::Bends;
pub(crate) use cone::Cones;
pub(crate) use constraint::FromKind;
pub(crate) use distance::{project, project_rod, project_rod_from_start};
pub(crate) use equation::{
    Solved, energy as equation_energy, error as equation_error, project as project_equation,
    solve as solve_equation,
};
pub(crate) use hinge::Hinges;
pub(crate) use softness::SubstepContext;
pub(crate) use tetrahedron::Tetrahedra;
pub(crate) use wide::Wide;
