//! Drag as people give it, a share of the velocity lost per second, and as it adds up, a rate.

/// The damping rate λ in 1/s with `(1 - drag)^t = e^(-λ t)`: rates of several media add up, shares do not.
/// A drag of 1 gives infinity: all velocity is forgotten in every step (the lectures' statics).
pub fn rate_of_drag(drag: f32) -> f32 {
    -libm::log1pf(-drag)
}

/// The share of the velocity lost per second at the damping rate `rate` (1/s): the inverse of [`rate_of_drag`].
pub fn drag_of_rate(rate: f32) -> f32 {
    -libm::expm1f(-rate)
}
