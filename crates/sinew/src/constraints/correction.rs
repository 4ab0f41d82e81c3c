//! Along what constraints are corrected, where there is a choice.

/// Along which gradient a hard distance or a rigid shape is corrected.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum GradientAt {
    /// To the nearest point: along the gradient where the particles are now, as the lectures show it. Robust; bleeds spin.
    #[default]
    Current,
    /// Along the gradient at the start of the substep (SHAKE; Ryckaert et al., 1977), which keeps momentum, angular momentum and energy as
    /// Verlet does. It needs a nearly converged loop to pay. Where something turns by 0.35 rad or more in a substep the island goes back to
    /// [`Current`](Self::Current), for that substep.
    StepStart,
}

/// How an area or a volume of many triangles is corrected (physics.md C7, C8).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum SizeCorrection {
    /// Along its gradient: the least mass-weighted displacement, approached by Newton steps, and soft if it is asked to be. The default.
    #[default]
    Gradient,
    /// By scaling everything about the barycentre, as the lectures do: right at once, but not the least.
    Scaling,
}
