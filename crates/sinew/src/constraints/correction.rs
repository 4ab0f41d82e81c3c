//! The direction in which constraints are corrected, where there is a choice.

/// The configuration at which the gradient of a hard distance or a rigid shape is taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum GradientAt {
    /// At the current positions: projects to the nearest point of the constraint (classic PBD). Robust, but rotation loses energy. The default.
    #[default]
    Current,
    /// At the positions at the start of the substep (SHAKE; Ryckaert et al., 1977). Keeps momentum, angular momentum and energy as well as Verlet does. It pays
    /// only if the sweeps nearly converge. Where a constraint rotates by 0.35 rad or more in a substep, its island uses [`Current`](Self::Current) for that
    /// substep.
    StepStart,
}

/// How an area or a volume of many triangles is corrected (physics.md C7, C8).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum SizeCorrection {
    /// Along its gradient: the least mass-weighted displacement, approached by Newton steps; may be soft. The default.
    #[default]
    Gradient,
    /// By uniform scaling about the barycentre: exact in one step, but not the least displacement.
    Scaling,
}
