//! Conversions between drag, a fraction of the velocity lost per second, and damping rate, which adds up.

/// The damping rate λ in 1/s with `(1 - drag)^t = e^(-λ t)`: rates of several media add up, drags do not. A drag of 1 gives infinity: all velocity is lost in
/// every step (the lectures' statics).
pub fn rate_of_drag(drag: f32) -> f32 {
    -libm::log1pf(-drag)
}

/// The fraction of the velocity lost per second at the damping rate `rate` (1/s): the inverse of [`rate_of_drag`].
pub fn drag_of_rate(rate: f32) -> f32 {
    -libm::expm1f(-rate)
}
