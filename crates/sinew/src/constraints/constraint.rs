//! The kinds of constraints there are beside the distance, and which particles one binds.

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

/// The rows of the particles that a constraint binds, in its own order.
pub type Rows = SmallVec<[u32; 5]>;

/// A constraint of any kind: what must hold, and between which particles.
#[derive(Clone, Debug, PartialEq)]
pub struct Constraint {
    /// Rows of the particles, in the order that the kind asks for.
    pub rows: Rows,
    /// What must hold between them.
    pub kind: ConstraintKind,
}

/// What holds the numbers of a kind of constraint.
pub(crate) trait FromKind: Sized {
    /// Those of a constraint, if it is of this kind.
    fn from_kind(kind: &ConstraintKind) -> Option<&Self>;
}

/// Makes the kinds of one table: a name, which is that of the type that holds its numbers, and its place in a sweep.
macro_rules! kinds {
    ($($(#[$doc:meta])* $name:ident($of:ident), rank $rank:literal;)*) => {
        /// What must hold between the particles of a constraint. Immutable data, cheap to clone, shared by bodies of the same shape.
        #[derive(Clone, Debug)]
        pub enum ConstraintKind {
            $($(#[$doc])* $name($of),)*
            /// A game's own.
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

            /// The equation that it is.
            pub fn equation(&self) -> &dyn Equation {
                match self {
                    $(Self::$name(kind) => kind,)*
                    Self::Custom(kind) => kind.as_ref(),
                }
            }

            /// Where it stands in a sweep: a game's own first, what is rigid last.
            pub(crate) fn rank(&self) -> u32 {
                match self {
                    $(Self::$name(_) => $rank,)*
                    Self::Custom(_) => 0,
                }
            }
        }

        $(impl $of {
            /// The same, as hard as that.
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

        /// Two kinds of a game's own are the same only if they are the same object.
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
    /// In one plane.
    Coplanar(Coplanar), rank 1;
    /// On one line.
    Collinear(Collinear), rank 1;
    /// The volume of a closed mesh.
    Volume(Volume), rank 2;
    /// The area of many triangles together.
    Patch(Patch), rank 2;
    /// Isometric bending.
    Bend(Bend), rank 3;
    /// The area of a triangle.
    Area(Area), rank 4;
    /// The volume of a tetrahedron.
    Tetrahedron(Tetrahedron), rank 5;
    /// The angle at a joint of three particles.
    Angle(Angle), rank 6;
    /// The signed angle about an axis of two particles; also twist, and bending by the dihedral angle.
    Hinge(Hinge), rank 7;
    /// A cone about an axis fixed in a parent.
    Cone(Cone), rank 8;
    /// A rigid shape.
    Rigid(Rigid), rank 9;
    /// Two points that particles carry.
    Anchors(AnchorDistance), rank 10;
}

impl Constraint {
    /// A constraint between some particles, named by their rows.
    pub fn new(rows: impl IntoIterator<Item = u32>, kind: ConstraintKind) -> Self {
        Self { rows: rows.into_iter().collect(), kind }
    }

    /// Why this constraint cannot be enforced among `particles` rows, or `None` if it can.
    pub fn fault(&self, particles: usize) -> Option<ConstraintFault> {
        if self.rows.iter().any(|&row| row as usize >= particles) {
            return Some(ConstraintFault::MissingParticle);
        }
        // Quadratic for the few that most have; sorted for a mesh.
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
    /// A kind of constraint of a game's own.
    pub fn custom(equation: impl Equation + 'static) -> Self {
        Self::Custom(Arc::new(equation))
    }

    /// How many of its first particles are one of two things that it ties: what it pulls at. Of most kinds one.
    pub(crate) fn first_side(&self) -> usize {
        match self {
            Self::Anchors(kind) => kind.a.weights.len(),
            _ => 1,
        }
    }
}
