//! Constraints on areas and volumes.

use bevy::prelude::*;
use sinew::constraints::{Area, Patch, Tetrahedron, Volume};

use super::super::order::CreationOrder;
use super::super::softness::Softness;
use crate::same::same_variants;

/// How an area or a volume of many triangles is corrected.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum SizeCorrection {
    /// Along its gradient: the least mass-weighted displacement. The default.
    #[default]
    Gradient,
    /// By scaling all particles about their centre of mass: exact in one step, but not the least displacement.
    Scaling,
}

/// Keeps the area of a triangle.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::{AreaConstraint};
/// # fn spawn(mut commands: Commands) {
/// let at = [Vec3::ZERO, Vec3::X, Vec3::Y];
/// let corners = at.map(|at| commands.spawn(Particle::at(at)).id());
/// commands.spawn(AreaConstraint::new(corners, 0.5));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, Clone, PartialEq)]
#[require(CreationOrder)]
pub struct AreaConstraint {
    /// The corners, in either winding.
    #[entities]
    pub particles: [Entity; 3],
    /// Area to keep, m², 0 or more.
    pub rest: f32,
    /// How hard it is; [`new`](Self::new) makes a hard one. A compliance is in m⁴/J.
    pub softness: Softness,
}

impl AreaConstraint {
    /// A hard constraint of `rest` square metres.
    pub fn new(particles: [Entity; 3], rest: f32) -> Self {
        Self { particles, rest, softness: Softness::Hard }
    }

    /// A constraint from the solver's kind: [`Area::of`] keeps an area as it is.
    pub fn from_kind(particles: [Entity; 3], kind: &Area) -> Self {
        Self { particles, rest: kind.rest, softness: kind.softness.into() }
    }
}

solved_as!(AreaConstraint, |this| Area { rest: this.rest });

/// Implements what the two constraints on many triangles have in common.
macro_rules! of_triangles {
    ($component:ident, $kind:ident) => {
        impl $component {
            /// A hard constraint of `rest` square or cubic metres, corrected along the gradient.
            pub fn new(
                particles: impl Into<Vec<Entity>>,
                triangles: impl Into<Vec<[u32; 3]>>,
                rest: f32,
            ) -> Self {
                Self {
                    particles: particles.into(),
                    triangles: triangles.into(),
                    rest,
                    correction: SizeCorrection::Gradient,
                    softness: Softness::Hard,
                }
            }

            /// A constraint from the solver's kind: the kind's `of` keeps an area or a volume as it is.
            pub fn from_kind(particles: impl Into<Vec<Entity>>, kind: &$kind) -> Self {
                Self::new(particles, kind.triangles.to_vec(), kind.rest)
                    .with_correction(kind.correction.into())
                    .with_softness(kind.softness.into())
            }

            /// Returns the same constraint with another correction.
            pub fn with_correction(self, correction: SizeCorrection) -> Self {
                Self { correction, ..self }
            }
        }

        solved_as!($component, |this| $kind {
            triangles: this.triangles.as_slice().into(),
            rest: this.rest,
            correction: this.correction.into()
        });
    };
}

/// Keeps the total area of many triangles: one may grow while another shrinks.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::PatchConstraint;
/// # fn example(mut commands: Commands) {
/// // A square of two triangles, which may shear but keeps its area of 1 m².
/// let at = [Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Z, Vec3::Z];
/// let corners = at.map(|at| commands.spawn(Particle::at(at)).id());
/// commands.spawn(PatchConstraint::new(corners, [[0, 1, 2], [0, 2, 3]], 1.0));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, Clone, PartialEq)]
#[require(CreationOrder)]
pub struct PatchConstraint {
    /// The particles, each once.
    #[entities]
    pub particles: Vec<Entity>,
    /// The triangles, as indices into `particles`, in either winding.
    pub triangles: Vec<[u32; 3]>,
    /// Area to keep, m², 0 or more.
    pub rest: f32,
    /// How it is corrected; [`new`](Self::new) uses the gradient.
    pub correction: SizeCorrection,
    /// How hard it is; [`new`](Self::new) makes a hard one. A compliance is in m⁴/J along the gradient, and in m/N for scaling.
    pub softness: Softness,
}

of_triangles!(PatchConstraint, Patch);

/// Keeps the signed volume of a tetrahedron; one that is inverted is turned back.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::{TetrahedronConstraint};
/// # fn spawn(mut commands: Commands) {
/// let at = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
/// let corners = at.map(|at| commands.spawn(Particle::at(at)).id());
/// commands.spawn(TetrahedronConstraint::new(corners, 1.0 / 6.0));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, Clone, PartialEq)]
#[require(CreationOrder)]
pub struct TetrahedronConstraint {
    /// The corners `[a, b, c, d]`; the volume is positive if `a`, `b`, `c` are counter-clockwise seen from `d`.
    #[entities]
    pub particles: [Entity; 4],
    /// Volume to keep, m³; negative if the corners have the other winding.
    pub rest: f32,
    /// How hard it is; [`new`](Self::new) makes a hard one. A compliance is in m⁶/J.
    pub softness: Softness,
}

impl TetrahedronConstraint {
    /// A hard constraint of `rest` cubic metres.
    pub fn new(particles: [Entity; 4], rest: f32) -> Self {
        Self { particles, rest, softness: Softness::Hard }
    }

    /// A constraint from the solver's kind: [`Tetrahedron::of`] keeps a volume as it is, including its sign.
    pub fn from_kind(particles: [Entity; 4], kind: &Tetrahedron) -> Self {
        Self { particles, rest: kind.rest, softness: kind.softness.into() }
    }
}

solved_as!(TetrahedronConstraint, |this| Tetrahedron { rest: this.rest });

/// Keeps the volume inside a closed mesh of particles: the pressure of a ball or a soft body.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::VolumeConstraint;
/// # use bevy_sinew::prelude::*;
/// # fn spawn(mut commands: Commands) {
/// let at = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
/// let corners = at.map(|at| commands.spawn(Particle::at(at)).id());
/// // Counter-clockwise seen from outside.
/// let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
/// commands.spawn(VolumeConstraint::new(corners, faces, 1.0 / 6.0));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, Clone, PartialEq)]
#[require(CreationOrder)]
pub struct VolumeConstraint {
    /// The particles, each once.
    #[entities]
    pub particles: Vec<Entity>,
    /// The triangles, as indices into `particles`, counter-clockwise seen from outside; with the other winding the volume is negative.
    pub triangles: Vec<[u32; 3]>,
    /// Volume to keep, m³. A value greater than the volume at rest acts as pressure.
    pub rest: f32,
    /// How it is corrected; [`new`](Self::new) uses the gradient.
    pub correction: SizeCorrection,
    /// How hard it is; [`new`](Self::new) makes a hard one. A compliance is in m⁶/J along the gradient, and in m/N for scaling.
    pub softness: Softness,
}

of_triangles!(VolumeConstraint, Volume);

same_variants!(SizeCorrection, sinew::constraints::SizeCorrection { Gradient, Scaling });
