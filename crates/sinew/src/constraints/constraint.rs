//! A constraint on any particles, and its kinds: all that the solver has besides the distance.

use std::sync::Arc;

use smallvec::SmallVec;

use super::anchor::AnchorDistance;
use super::angle::Angle;
use super::area::Area;
use super::bend::Bend;
use super::collinear::Collinear;
use super::cone::Cone;
use super::coplanar::Coplanar;
use super::equation::Equation;
use super::fault::ConstraintFault;
use super::hinge::Hinge;
use super::patch::Patch;
use super::rigid::Rigid;
use super::softness::Softness;
use super::tetrahedron::Tetrahedron;
use super::volume::Volume;

/// The rows of the particles that a constraint binds, in the constraint's own order.
pub type Rows = SmallVec<[u32; 5]>;

/// A constraint of any kind, and the particles that it binds.
#[derive(Clone, Debug, PartialEq)]
pub struct Constraint {
    /// Rows of the particles, in the order that the kind defines.
    pub rows: Rows,
    /// What is kept between them.
    pub kind: ConstraintKind,
}

/// Access to the parameters of one kind of constraint.
pub(crate) trait FromKind: Sized {
    /// The parameters of this kind, or `None` if `kind` is another one.
    fn from_kind(kind: &ConstraintKind) -> Option<&Self>;
}

/// Defines the constraint kinds from one table: a name, the type that holds the parameters, and the rank in a sweep.
macro_rules! kinds {
    ($($(#[$doc:meta])* $name:ident($of:ident), rank $rank:literal;)*) => {
        /// What a constraint keeps between its particles. Immutable data, cheap to clone, shared by bodies of the same shape.
        #[derive(Clone, Debug)]
        pub enum ConstraintKind {
            $($(#[$doc])* $name($of),)*
            /// A user-defined equation.
            Custom(Arc<dyn Equation>),
        }

        impl ConstraintKind {
            /// Why this kind cannot bind `particles` particles, or `None` if it can.
            pub fn fault(&self, particles: usize) -> Option<ConstraintFault> {
                if !self.equation().softness().is_valid() {
                    return Some(ConstraintFault::Softness);
                }
                match self {
                    $(Self::$name(kind) => kind.fault(particles),)*
                    Self::Custom(_) => (particles == 0).then_some(ConstraintFault::Count),
                }
            }

            /// The equation of this kind.
            pub fn equation(&self) -> &dyn Equation {
                match self {
                    $(Self::$name(kind) => kind,)*
                    Self::Custom(kind) => kind.as_ref(),
                }
            }

            /// Position in a sweep, lowest first: user-defined kinds come first, rigid shapes and anchors last.
            pub(crate) fn rank(&self) -> u32 {
                match self {
                    $(Self::$name(_) => $rank,)*
                    Self::Custom(_) => 0,
                }
            }
        }

        $(impl $of {
            /// The same constraint with another softness.
            pub fn with_softness(mut self, softness: Softness) -> Self {
                self.softness = softness;
                self
            }
        }

        impl FromKind for $of {
            fn from_kind(kind: &ConstraintKind) -> Option<&Self> {
                match kind {
                    ConstraintKind::$name(own) => Some(own),
                    _ => None,
                }
            }
        })*

        /// Two user-defined kinds are equal only if they are the same object.
        impl PartialEq for ConstraintKind {
            fn eq(&self, other: &Self) -> bool {
                match (self, other) {
                    $((Self::$name(a), Self::$name(b)) => a == b,)*
                    (Self::Custom(a), Self::Custom(b)) => Arc::ptr_eq(a, b),
                    _ => false,
                }
            }
        }
    };
}

kinds! {
    /// Keeps particles in one plane.
    Coplanar(Coplanar), rank 1;
    /// Keeps particles on one line.
    Collinear(Collinear), rank 1;
    /// Keeps the volume of a closed mesh.
    Volume(Volume), rank 2;
    /// Keeps the total area of several triangles.
    Patch(Patch), rank 2;
    /// Isometric bending.
    Bend(Bend), rank 3;
    /// Keeps the area of a triangle.
    Area(Area), rank 4;
    /// Keeps the volume of a tetrahedron.
    Tetrahedron(Tetrahedron), rank 5;
    /// Limits the angle at a joint of three particles.
    Angle(Angle), rank 6;
    /// Limits the signed angle about an axis of two particles; also twist, and bending by the dihedral angle.
    Hinge(Hinge), rank 7;
    /// Limits a direction to a cone about an axis fixed in a parent.
    Cone(Cone), rank 8;
    /// Keeps a rigid shape.
    Rigid(Rigid), rank 9;
    /// Keeps the distance of two points that particles carry.
    Anchors(AnchorDistance), rank 10;
}

impl Constraint {
    /// A constraint between the particles in these rows.
    pub fn new(rows: impl IntoIterator<Item = u32>, kind: ConstraintKind) -> Self {
        Self { rows: rows.into_iter().collect(), kind }
    }

    /// Why this constraint cannot be enforced among `particles` rows, or `None` if it can.
    pub fn fault(&self, particles: usize) -> Option<ConstraintFault> {
        if self.rows.iter().any(|&row| row as usize >= particles) {
            return Some(ConstraintFault::MissingParticle);
        }
        // Quadratic for the few particles that most constraints have; sorted for a mesh.
        let twice = if self.rows.len() <= 8 {
            self.rows.iter().enumerate().any(|(i, row)| self.rows[..i].contains(row))
        } else {
            let mut sorted = self.rows.clone();
            sorted.sort_unstable();
            sorted.windows(2).any(|pair| pair[0] == pair[1])
        };
        if twice {
            return Some(ConstraintFault::SameParticle);
        }
        self.kind.fault(self.rows.len())
    }
}

impl ConstraintKind {
    /// A user-defined kind of constraint.
    pub fn custom(equation: impl Equation + 'static) -> Self {
        Self::Custom(Arc::new(equation))
    }

    /// How many of its first particles form the first of the two sides that it ties together. 1 for most kinds.
    pub(crate) fn first_side(&self) -> usize {
        match self {
            Self::Anchors(kind) => kind.a.weights.len(),
            _ => 1,
        }
    }
}
