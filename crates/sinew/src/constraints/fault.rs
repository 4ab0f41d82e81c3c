//! Why a constraint cannot be enforced.

/// What is wrong with a constraint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ConstraintFault {
    /// The same particle is listed twice.
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
    /// The lower limit is above the upper one.
    #[error("its lower limit is above its upper one")]
    Limits,
    /// A triangle refers to a particle that the constraint does not have.
    #[error("one of its triangles names a particle that it does not have")]
    Triangle,
    /// NaN, infinite or negative compliance, damping, frequency or share.
    #[error("its softness is not a finite number in range")]
    Softness,
}
