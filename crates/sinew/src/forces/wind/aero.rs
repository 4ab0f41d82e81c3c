//! Air with a velocity: drag and lift from the motion of each triangle relative to it (physics.md F5), so that a flag flutters, a feather floats
//! down and a kite climbs.
//!
//! # The law
//!
//! With `v` the air's velocity minus the triangle's (the mean of its corners'), and `a = A n` its area vector,
//!
//! ```text
//! drag = ½ρ C_D |a·v| v                                 along v: dynamic pressure times silhouette
//! lift = ½ρ C_L |a·v| (v × n') × v / |v|                across v, with n' = ±n, whichever points downwind
//! ```
//!
//! and a third of it on each corner. For a sheet at the angle of attack α (between sheet and wind) drag is `½ρ C_D A v² sin α`, lift
//! `½ρ C_L A v² sin α cos α`. The textbook's lift has the *direction* of `(v × n) × v`; that one is `½ρ C_L A v²` at full strength on a sheet that
//! stands square to the wind, where it has no direction, and flips about with every tremor. The vector itself carries the missing `cos α`.
//! As `(v × n) × v = n v² - v (v·n)` and `|a·v| n' = (a·v) n`, the lift is even in `n`:
//!
//! ```text
//! lift = ½ρ C_L ((a·v)|v| n - (a·v)²/(A |v|) v)
//! ```
//!
//! and it does not matter which way round the triangle is. A kite that turns its lower face to the wind has an `n'` that points downwind and up,
//! and is lifted.
//!
//! # Why it cannot blow up
//!
//! The force is taken at the start of a substep of `h` and held, and light things in strong wind would be thrown back and forth. With `f` the
//! force of triangle `t`, every corner `i` gets the impulses of all its `n_i` triangles, and by Cauchy and Schwarz the energy of the change is
//!
//! ```text
//! ½ Σ_i w_i (Σ_t h f_t/3)²  ≤  ½ Σ_i w_i n_i Σ_t h² f_t²/9  =  ½ h² Σ_t g_t f_t²        g_t = Σ n_i w_i / 9 over its corners
//! ```
//!
//! while the force does the work `-h Σ_t f_t·v_t` on the motion relative to the air. That motion does not gain energy if for each triangle
//! `h g f² ≤ 2 f·v`. With `x = h g |drag|/|v|` and `y = h g |lift|/|v|` that reads `x² + y² ≤ 2x`, which
//!
//! ```text
//! x ≤ 1        and        y² ≤ ½ x (2 - x)
//! ```
//!
//! ensure, with half of what drag takes left over, so that what lift makes swing comes to rest. The first also says that no sheet overshoots:
//! for one that moves as a whole, `g` is exactly how much its triangles yield together, and `x = 1` takes it to the velocity of the air and not
//! beyond. Neither does anything where the substep is short enough for the law itself, so the terminal speed is the law's to round-off.

use glam::Vec3;

use super::air::Current;
use super::gusts::at_one_place;
use crate::forces::region::Region;

/// Air that flows with a velocity, everywhere or in a region. Still air, velocity zero, slows things down.
///
/// Where several overlap there is air once: their velocities add up, each by the share of its region, and density and coefficients are those of
/// the densest. So a fan may blow in a breeze, and a breeze in still air.
///
/// A triangle stands for a sheet, of which both sides are in the air. On a closed body the lee side feels the wind as well: give its air half
/// the coefficients.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AirFlow {
    /// Velocity of the air, m/s.
    pub velocity: Vec3,
    /// Density of the air, kg/m³. Default 1.225: at sea level and 15 °C.
    pub density: f32,
    /// Drag coefficient `C_D` of a sheet that stands square to the flow, 0 or more. Default 1.28, that of a flat plate. Without
    /// drag there is no lift either.
    pub drag: f32,
    /// Lift coefficient `C_L`, of `½ρ C_L A v² sin α cos α`, 0 or more. Default 1.28, as the drag.
    pub lift: f32,
    /// How much gusts add and take: the standard deviation of each component of the velocity, as a share of the speed (the
    /// meteorologists' intensity of turbulence, 0.1 over water, 0.3 in a town). Default 0: a steady flow.
    pub gusts: f32,
    /// Size of the largest eddies, metres. Default 4.
    pub gust_length: f32,
    /// Time in which the eddies change besides being carried along, seconds. Default 2.
    pub gust_period: f32,
    /// Where the air is. Default everywhere. Where the region fades, both density and velocity do.
    pub region: Region,
    /// Whether loose particles (those of no triangle) with a radius feel it too, as balls with a drag coefficient of 0.47. Default true.
    pub on_particles: bool,
}

impl Default for AirFlow {
    fn default() -> Self {
        Self {
            velocity: Vec3::ZERO,
            density: 1.225,
            drag: 1.28,
            lift: 1.28,
            gusts: 0.0,
            gust_length: 4.0,
            gust_period: 2.0,
            region: Region::EVERYWHERE,
            on_particles: true,
        }
    }
}

impl AirFlow {
    /// A steady flow of the given velocity, m/s, everywhere.
    pub fn steady(velocity: Vec3) -> Self {
        Self { velocity, ..Self::default() }
    }

    /// The same with gusts of the given share of its speed.
    pub fn with_gusts(self, gusts: f32) -> Self {
        Self { gusts, ..self }
    }

    /// The same, in a region only.
    pub fn within(self, region: Region) -> Self {
        Self { region, ..self }
    }

    /// The velocity that this flow adds at a place and time, m/s: a pure function of both, without divergence where the region is in full.
    pub fn at(&self, position: Vec3, time: f64) -> Vec3 {
        at_one_place(position, Current::of(self, time)) * self.region.share(position)
    }

    /// Whether every number is finite and in range. Invalid air is not there.
    pub fn is_valid(&self) -> bool {
        let not_negative = |x: f32| x.is_finite() && x >= 0.0;
        self.velocity.is_finite()
            && [self.density, self.drag, self.lift, self.gusts].into_iter().all(not_negative)
            && [self.gust_length, self.gust_period].into_iter().all(|x| x.is_finite() && x > 0.0)
            && self.region.is_valid()
    }
}
