//! Position Verlet: from positions and accelerations to the next positions, and from corrected positions back to velocities.
//!
//! # The formula
//!
//! The lectures' Verlet step is `q = p + c (p - p_old) + h² a` with the damping `c = (1 - drag)^h`. With `v = (p - p_old)/l`, the mean
//! velocity over the last step of length `l` (see [`particles`](crate::particles)), and a step that may change, it is
//!
//! ```text
//! τ = (l + h)/2             the time between the middles of the last step and of this one
//! u = e^(-λτ) v + τ a       the mean velocity of this step; λ = -ln(1 - drag)
//! q = p + h u
//! ```
//!
//! - For `l = h` it is the lectures' formula to the letter (physics.md I1, I2).
//! - Under constant acceleration the mean velocity of a step is the velocity at its middle, so `u = v + τ a` is exact whatever the
//!   step sizes: time-corrected Verlet (I3). The lectures' rescaling of `p_old` keeps `v` but forgets that it is `l/2` old.
//! - For `l = 0`, a velocity that is true now, it is the exact start `q = p + h v + ½ h² a` (I1); the naive `p_old = p - h v` errs by ½ a h t.
//! - Without acceleration `v(t) = v₀ (1 - drag)^t` holds at the middle of every step, whatever `h` (I2). `1 - e^(-λτ)` is computed as such,
//!   so that small drags do not drown in the round-off of a factor close to 1.
//!
//! Constraints then move the particles from `q` to `q'`, and the velocity follows: `v = u + (q' - q)/h`. Written this way, and not as
//! `(q' - p)/h`, a particle that no constraint touched keeps every bit of `u`, however far from the origin it is.

use glam::Vec3;

use crate::particles::Particles;

/// Predicts the next position of every particle that can move, from its acceleration, over a substep of `h` seconds.
///
/// Afterwards [`Particles::start`] is where the substep began, and the velocity is the mean one of this substep. A particle of infinite
/// mass stays where it is.
pub(crate) fn predict(particles: &mut Particles, h: f32) {
    // Neighbours mostly share their damping, so the last exponential is kept.
    let mut last = (0.0, 0.0);
    for i in 0..particles.len() {
        let packed = particles.position[i];
        let p = packed.truncate();
        particles.start[i] = p;
        if packed.w == 0.0 {
            particles.velocity[i] = Vec3::ZERO.extend(h);
            continue;
        }
        let v = particles.velocity[i];
        let tau = (v.w + h) * 0.5;
        let exponent = (particles.damping[i] + particles.medium[i]) * tau;
        if exponent != last.0 {
            last = (exponent, -libm::expm1f(-exponent));
        }
        let v = v.truncate();
        let u = v - v * last.1 + particles.acceleration[i] * tau;
        particles.velocity[i] = u.extend(h);
        particles.position[i] = (p + u * h).extend(packed.w);
    }
}

/// Makes the velocities agree with the positions that the constraints left, at the end of a substep of `h` seconds.
pub(crate) fn derive_velocities(particles: &mut Particles, h: f32) {
    for i in 0..particles.len() {
        let u = particles.velocity[i].truncate();
        let predicted = particles.start[i] + u * h;
        let corrected = particles.position[i].truncate() - predicted;
        particles.velocity[i] = (u + corrected / h).extend(h);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particles::{ParticleSeed, drag_of_rate, rate_of_drag};

    const G: Vec3 = Vec3::new(0.0, -9.81, 0.0);

    fn thrown(velocity: Vec3, drag: f32) -> Particles {
        let mut particles = Particles::default();
        let seed = ParticleSeed::at(Vec3::ZERO).with_velocity(velocity).with_drag(drag);
        particles.push(seed).unwrap();
        particles
    }

    fn advance(particles: &mut Particles, h: f32, acceleration: Vec3) {
        particles.acceleration.fill(acceleration);
        predict(particles, h);
        derive_velocities(particles, h);
    }

    #[test]
    fn a_thrown_particle_stays_on_the_exact_parabola_with_any_steps() {
        let v0 = Vec3::new(3.0, 4.0, 0.0);
        let steps = [1.0 / 30.0, 1.0 / 60.0, 1.0 / 144.0];
        let mut particles = thrown(v0, 0.0);
        let (mut t, mut seed) = (0.0_f64, 7_u32);
        while t < 2.0 {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let h = steps[(seed >> 16) as usize % 3];
            advance(&mut particles, h, G);
            t += f64::from(h);
        }
        let exact = v0.as_dvec3() * t + G.as_dvec3() * (0.5 * t * t);
        let error = (particles.position(0).as_dvec3() - exact).length();
        assert!(error < 1e-5 * exact.length(), "{error} of {exact}");
    }

    #[test]
    fn the_lectures_formula_is_this_one_at_a_constant_step() {
        let (h, drag) = (1.0_f64 / 60.0, 0.3_f64);
        let c = (1.0 - drag).powf(h);
        // Started with p_old = p - v h, as the state (v, l = h) says.
        let (mut p, mut p_old) = (0.0_f64, -2.0 * h);
        let mut particles = thrown(Vec3::Y * 2.0, drag as f32);
        particles.velocity[0].w = h as f32;
        for _ in 0..60 {
            let q = (1.0 + c) * p - c * p_old + h * h * f64::from(G.y);
            (p_old, p) = (p, q);
            advance(&mut particles, h as f32, G);
        }
        assert!((f64::from(particles.position(0).y) - p).abs() < 1e-5 * p.abs());
    }

    #[test]
    fn damping_loses_its_share_per_second_to_round_off_at_any_step() {
        for h in [1.0 / 30.0, 1.0 / 240.0, 1.0 / 1200.0] {
            for drag in [0.015_f32, 0.5, 0.98] {
                let mut particles = thrown(Vec3::X * 10.0, drag);
                let steps = (2.0 / h) as u32;
                for _ in 0..steps {
                    advance(&mut particles, h, Vec3::ZERO);
                }
                let t = (f64::from(steps) - 0.5) * f64::from(h);
                let exact = 10.0 * (1.0 - f64::from(drag)).powf(t);
                let error = (f64::from(particles.velocity(0).x) - exact).abs() / exact;
                assert!(error < 1e-5, "h {h} drag {drag}: {error}");
            }
        }
    }

    #[test]
    fn terminal_speed_is_the_one_at_which_damping_takes_what_gravity_gives() {
        let (h, drag) = (1.0 / 240.0, 0.8);
        let mut particles = thrown(Vec3::ZERO, drag);
        for _ in 0..240 * 20 {
            advance(&mut particles, h, G);
        }
        let lost = drag_of_rate(rate_of_drag(drag) * h);
        let exact = G.y * h / lost;
        assert!((particles.velocity(0).y / exact - 1.0).abs() < 1e-4);
    }

    #[test]
    fn swapping_the_two_positions_runs_the_motion_backwards() {
        let mut particles = thrown(Vec3::new(1.0, 5.0, 0.0), 0.0);
        let h = 1.0 / 60.0;
        for _ in 0..120 {
            advance(&mut particles, h, G);
        }
        let previous = particles.position(0) - particles.velocity(0) * h;
        particles.set_position(0, previous);
        particles.velocity[0] = (-particles.velocity(0)).extend(h);
        for _ in 0..119 {
            advance(&mut particles, h, G);
        }
        assert!(particles.position(0).length() < 1e-4, "{}", particles.position(0));
    }

    #[test]
    fn gravity_is_not_lost_far_from_the_origin() {
        // 1200 substeps a second add 6.8e-6 m each: less than the spacing of f32 at 200 m, which swallowed it in `p - p_old`.
        let mut particles = Particles::default();
        particles.push(ParticleSeed::at(Vec3::Y * 200.0)).unwrap();
        for _ in 0..1200 {
            advance(&mut particles, 1.0 / 1200.0, G);
        }
        assert!((particles.velocity(0).y + 9.81 * (1.0 - 0.5 / 1200.0)).abs() < 1e-3);
        assert!((particles.position(0).y - 195.095).abs() < 0.01);
    }
}
