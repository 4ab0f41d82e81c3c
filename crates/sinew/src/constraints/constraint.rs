//! The kinds of constraints there are beside the distance, and which particles one binds.

use std::sync::Arc;

use smallvec::SmallVec;

use super::{
    AnchorDistance, Angle, Area, Bend, Collinear, Cone, Coplanar, Equation, Hinge, Patch, Rigid,
    Tetrahedron, Volume,
};

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

/// What must hold between the particles of a constraint. Immutable data, cheap to clone, shared by bodies of the same shape.
#[derive(Clone, Debug)]
pub enum ConstraintKind {
    /// The angle at a joint of three particles.
    Angle(Angle),
    /// The signed angle about an axis of two particles; also twist, and bending by the dihedral angle.
    Hinge(Hinge),
    /// A cone about an axis fixed in a parent.
    Cone(Cone),
    /// The area of a triangle.
    Area(Area),
    /// The area of many triangles together.
    Patch(Patch),
    /// The volume of a tetrahedron.
    Tetrahedron(Tetrahedron),
    /// The volume of a closed mesh.
    Volume(Volume),
    /// Isometric bending.
    Bend(Bend),
    /// In one plane.
    Coplanar(Coplanar),
    /// On one line.
    Collinear(Collinear),
    /// A rigid shape.
    Rigid(Rigid),
    /// Two points that particles carry.
    Anchors(AnchorDistance),
    /// A game's own.
    Custom(Arc<dyn Equation>),
}

/// What is wrong with a constraint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ConstraintFault {
    /// The same particle is named twice.
    #[error("it names the same particle twice")]
    SameParticle,
    /// One of its particles is not a row of the simulation.
    #[error("one of its particles does not exist")]
    MissingParticle,
    /// Fewer or more particles than its kind binds.
    #[error("its kind binds another number of particles")]
    Count,
    /// NaN, infinite, or out of its range.
    #[error("one of its numbers is not finite or out of range")]
    Number,
    /// A smallest angle above the largest.
    #[error("its lower limit is above its upper one")]
    Limits,
    /// A triangle that names a particle that the constraint does not have.
    #[error("one of its triangles names a particle that it does not have")]
    Triangle,
    /// NaN, infinite or negative compliance, damping, frequency or share.
    #[error("its softness is not a finite number in range")]
    Softness,
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

    /// Why this kind cannot bind `particles` particles, or `None` if it can.
    pub fn fault(&self, particles: usize) -> Option<ConstraintFault> {
        if !self.equation().softness().is_valid() {
            return Some(ConstraintFault::Softness);
        }
        match self {
            Self::Angle(kind) => kind.fault(particles),
            Self::Hinge(kind) => kind.fault(particles),
            Self::Cone(kind) => kind.fault(particles),
            Self::Area(kind) => kind.fault(particles),
            Self::Patch(kind) => kind.fault(particles),
            Self::Tetrahedron(kind) => kind.fault(particles),
            Self::Volume(kind) => kind.fault(particles),
            Self::Bend(kind) => kind.fault(particles),
            Self::Coplanar(kind) => kind.fault(particles),
            Self::Collinear(kind) => kind.fault(particles),
            Self::Rigid(kind) => kind.fault(particles),
            Self::Anchors(kind) => kind.fault(particles),
            Self::Custom(_) => (particles == 0).then_some(ConstraintFault::Count),
        }
    }

    /// The equation that it is.
    pub fn equation(&self) -> &dyn Equation {
        match self {
            Self::Angle(kind) => kind,
            Self::Hinge(kind) => kind,
            Self::Cone(kind) => kind,
            Self::Area(kind) => kind,
            Self::Patch(kind) => kind,
            Self::Tetrahedron(kind) => kind,
            Self::Volume(kind) => kind,
            Self::Bend(kind) => kind,
            Self::Coplanar(kind) => kind,
            Self::Collinear(kind) => kind,
            Self::Rigid(kind) => kind,
            Self::Anchors(kind) => kind,
            Self::Custom(kind) => kind.as_ref(),
        }
    }

    /// How many of its first particles are one of two things that it ties: what it pulls at. Of most kinds one.
    pub(crate) fn first_side(&self) -> usize {
        match self {
            Self::Anchors(kind) => kind.a.weights.len(),
            _ => 1,
        }
    }

    /// Where it stands in a sweep: limits and shapes first, what is rigid last.
    pub(crate) fn rank(&self) -> u32 {
        match self {
            Self::Custom(_) => 0,
            Self::Coplanar(_) | Self::Collinear(_) => 1,
            Self::Volume(_) | Self::Patch(_) => 2,
            Self::Bend(_) => 3,
            Self::Area(_) => 4,
            Self::Tetrahedron(_) => 5,
            Self::Angle(_) => 6,
            Self::Hinge(_) => 7,
            Self::Cone(_) => 8,
            Self::Rigid(_) => 9,
            Self::Anchors(_) => 10,
        }
    }
}

/// Two kinds of a game's own are the same only if they are the same object.
impl PartialEq for ConstraintKind {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Angle(a), Self::Angle(b)) => a == b,
            (Self::Hinge(a), Self::Hinge(b)) => a == b,
            (Self::Cone(a), Self::Cone(b)) => a == b,
            (Self::Area(a), Self::Area(b)) => a == b,
            (Self::Patch(a), Self::Patch(b)) => a == b,
            (Self::Tetrahedron(a), Self::Tetrahedron(b)) => a == b,
            (Self::Volume(a), Self::Volume(b)) => a == b,
            (Self::Bend(a), Self::Bend(b)) => a == b,
            (Self::Coplanar(a), Self::Coplanar(b)) => a == b,
            (Self::Collinear(a), Self::Collinear(b)) => a == b,
            (Self::Rigid(a), Self::Rigid(b)) => a == b,
            (Self::Anchors(a), Self::Anchors(b)) => a == b,
            (Self::Custom(a), Self::Custom(b)) => Arc::ptr_eq(a, b),
            _ => false,
        }
    }
}
