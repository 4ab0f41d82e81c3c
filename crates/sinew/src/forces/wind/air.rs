//! Air with a velocity: drag and lift from the motion of each triangle relative to it (physics.md F5), so that a flag flutters, a feather drifts down and a
//! kite climbs.
//!
//! # The force
//!
//! With `v` the air's velocity minus the triangle's (the mean of its corners'), and `a = A n` its area vector,
//!
//! ```text
//! drag = ½ρ C_D |a·v| v                                 along v: dynamic pressure times silhouette
//! lift = ½ρ C_L |a·v| (v × n') × v / |v|                across v, with n' = ±n, whichever points downwind
//! ```
//!
//! with a third of the force on each corner. For a sheet at the angle of attack α (between sheet and wind) the drag is `½ρ C_D A v² sin α` and the lift `½ρ C_L
//! A v² sin α cos α`. The textbook formula uses only the *direction* of `(v × n) × v`. It gives the full `½ρ C_L A v²` for a sheet perpendicular to the wind,
//! where that direction is undefined and flips with every small motion. The vector itself has the missing factor `cos α`.
//! As `(v × n) × v = n v² - v (v·n)` and `|a·v| n' = (a·v) n`, the lift is even in `n`:
//!
//! ```text
//! lift = ½ρ C_L ((a·v)|v| n - (a·v)²/(A |v|) v)
//! ```
//!
//! so the winding of the triangle does not matter. A kite whose lower face is turned to the wind has an `n'` that points downwind and up, and is lifted.
//!
//! # Stability
//!
//! The force is computed at the start of a substep of `h` and held constant, so light sheets in strong wind could be thrown back and forth. With `f` the force
//! on triangle `t`, every corner `i` gets the impulses of all its `n_i` triangles, and by Cauchy and Schwarz the energy of the velocity change is
//!
//! ```text
//! ½ Σ_i w_i (Σ_t h f_t/3)²  ≤  ½ Σ_i w_i n_i Σ_t h² f_t²/9  =  ½ h² Σ_t g_t f_t²        g_t = Σ n_i w_i / 9 over its corners
//! ```
//!
//! while the force does the work `-h Σ_t f_t·v_t` on the motion relative to the air. That motion gains no energy if for each triangle `h g f² ≤ 2 f·v`. With `x
//! = h g |drag|/|v|` and `y = h g |lift|/|v|` that reads `x² + y² ≤ 2x`, which
//!
//! ```text
//! x ≤ 1        and        y² ≤ ½ x (2 - x)
//! ```
//!
//! ensure, with half of the drag's dissipation left over, so that oscillations caused by lift die out. The first condition also prevents overshoot: for a sheet
//! that moves as a whole, `g` is exactly the inverse effective mass of its triangles together, and `x = 1` brings it to the velocity of the air and not beyond.
//! Neither condition is active where the substep is short enough for the plain formula, so the terminal speed is exact to round-off.

use core::f32::consts::PI;

use glam::{Vec3, Vec4};

use super::gusts::{CurlNoise, VectorField, at_one_place};
use super::surfaces::{Motion, PackedSurfaces, SurfaceForce};
use crate::forces::region::{Extent, Region, WorldPoint};
use crate::lanes::{InstructionSet, LANES, Lanes, Vector, kernel};
use crate::particles::Particles;

/// Air with a velocity, everywhere or in a region. Still air (velocity zero) slows things down.
///
/// Where several flows overlap, they form one body of air: the velocities add up, each weighted by its region, and density and coefficients are those of the
/// densest. So a fan may blow in a breeze, and a breeze in still air.
///
/// A triangle represents a thin sheet with air on both sides. On a closed body the lee side is affected as well; for those, halve the coefficients.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AirFlow {
    /// Velocity of the air, m/s.
    pub velocity: Vec3,
    /// Density of the air, kg/m³. Default 1.225: at sea level and 15 °C.
    pub density: f32,
    /// Drag coefficient `C_D` of a sheet perpendicular to the flow, 0 or more. Default 1.28, that of a flat plate. Without drag there is no lift either.
    pub drag: f32,
    /// Lift coefficient `C_L`, of `½ρ C_L A v² sin α cos α`, 0 or more. Default 1.28, equal to the drag.
    pub lift: f32,
    /// Strength of gusts: the standard deviation of each component of the velocity, as a share of the speed (turbulence intensity, 0.1 over water, 0.3 in a
    /// town). Default 0: a steady flow.
    pub gusts: f32,
    /// Size of the largest eddies, metres. Default 4.
    pub gust_length: f32,
    /// Time in which the eddies change, in addition to being carried along, seconds. Default 2.
    pub gust_period: f32,
    /// Where the air is. Default everywhere. Where the region fades, density and velocity both fade.
    pub region: Region,
    /// Whether it acts on loose particles (of no triangle) with a radius too, as balls with a drag coefficient of 0.47. Default true.
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

    /// The same flow with gusts of the given share of its speed.
    pub fn with_gusts(self, gusts: f32) -> Self {
        Self { gusts, ..self }
    }

    /// The same flow, in a region only.
    pub fn within(self, region: Region) -> Self {
        Self { region, ..self }
    }

    /// The velocity that this flow contributes at a position and time, m/s: a pure function of both, free of divergence where the region is at full strength.
    pub fn at(&self, position: Vec3, time: f64) -> Vec3 {
        at_one_place(position, Current::of(self, time)) * self.region.share(position)
    }

    /// Whether every number is finite and in range. An invalid flow does nothing.
    pub fn is_valid(&self) -> bool {
        let not_negative = |x: f32| x.is_finite() && x >= 0.0;
        self.velocity.is_finite()
            && [self.density, self.drag, self.lift, self.gusts].into_iter().all(not_negative)
            && [self.gust_length, self.gust_period].into_iter().all(|x| x.is_finite() && x > 0.0)
            && self.region.is_valid()
    }
}

/// Drag coefficient of a ball for Reynolds numbers from a few hundred to some 200 000: anything from a pea to a football in a breeze.
const BALL: f32 = 0.47;

const THIRD: f32 = 1.0 / 3.0;

/// The air at each triangle and each loose particle, sampled once a step: gusts change only over a good part of a second.
#[derive(Clone, Debug, Default)]
pub(crate) struct Air {
    /// For each triangle of the surfaces, padded to a multiple of eight: velocity, m/s, and `½ρ`, kg/m³, which is 0 where there is no air. Empty if there is no
    /// air at all.
    triangles: Vec<Vec4>,
    /// The response of each triangle: `C_D`, `C_L` and `g`.
    responses: Vec<Vec4>,
    balls: Vec<(u32, BallAir)>,
    /// Number of triangles at each particle.
    triangle_count: Vec<u32>,
}

impl Air {
    /// Whether there is air at any triangle.
    pub(crate) fn is_at_triangles(&self) -> bool {
        !self.triangles.is_empty()
    }
}

/// The air at a ball, and the ball's response.
#[derive(Clone, Copy, Debug, Default)]
struct BallAir {
    velocity: Vec3,
    /// `½ρ`, kg/m³; 0 where there is no air.
    density: f32,
    /// `C_D` times the silhouette, m².
    drag: f32,
    /// Inverse effective mass, 1/kg: `g` of the derivation.
    inverse_mass: f32,
}

/// Response of eight triangles to the air, in the order in which they are packed: `C_D`, `C_L`, and `g` of the derivation, 1/kg.
#[derive(Clone, Copy)]
struct AirResponse<L> {
    drag: L,
    lift: L,
    inverse_mass: L,
}

/// Samples the air at the time `time`, seconds.
pub(crate) fn sample(
    particles: &Particles,
    surfaces: &[[u32; 3]],
    flows: &[AirFlow],
    time: f64,
    air: &mut Air,
    instructions: InstructionSet,
) {
    let Air { triangles, responses, balls, triangle_count } = air;
    triangles.clear();
    responses.clear();
    balls.clear();
    if !flows.iter().any(AirFlow::is_valid) {
        return;
    }
    let there = |corners: &[u32; 3]| corners.iter().all(|&i| (i as usize) < particles.len());
    triangle_count.clear();
    triangle_count.resize(particles.len(), 0);
    for &i in surfaces.iter().filter(|corners| there(corners)).flatten() {
        triangle_count[i as usize] += 1;
    }
    // A triangle with a missing row is left without air: its response `g` is zero.
    let weighted =
        |&i: &u32| triangle_count[i as usize] as f32 * particles.inverse_mass(i as usize);
    let inverse_mass = |corners: &[u32; 3]| corners.iter().map(weighted).sum::<f32>() / 9.0;
    responses.extend(surfaces.iter().map(|corners| {
        Vec4::new(0.0, 0.0, if there(corners) { inverse_mass(corners) } else { 0.0 }, 0.0)
    }));
    responses.resize(surfaces.len().next_multiple_of(LANES), Vec4::ZERO);
    triangles.resize(responses.len(), Vec4::ZERO);
    let loose = |&i: &usize| {
        triangle_count[i] == 0 && particles.radius(i) > 0.0 && particles.inverse_mass(i) > 0.0
    };
    if flows.iter().any(|flow| flow.is_valid() && flow.on_particles) {
        balls.extend((0..particles.len()).filter(loose).map(|i| {
            (i as u32, BallAir { inverse_mass: particles.inverse_mass(i), ..BallAir::default() })
        }));
    }
    for flow in flows.iter().filter(|flow| flow.is_valid()) {
        let current = Current::of(flow, time);
        blend(particles, surfaces, current, triangles, responses, instructions);
        for (i, local_air) in balls.iter_mut().filter(|_| flow.on_particles) {
            local_air.blend(&current, particles, *i as usize);
        }
    }
}

/// Adds drag and lift for a substep of `h` seconds, from the air last [sampled](sample).
pub(crate) fn apply(
    particles: &mut Particles,
    surfaces: &PackedSurfaces,
    air: &Air,
    h: f32,
    instructions: InstructionSet,
) {
    if air.is_at_triangles() {
        surfaces.accelerate(particles, &AirForce { air, h }, false, instructions);
    }
    for &(i, local_air) in &air.balls {
        let i = i as usize;
        if local_air.density > 0.0 && i < particles.len() {
            let held = 0.5 * (particles.lag(i).max(h) + h);
            let force = local_air.on_ball(local_air.velocity - particles.velocity(i), held);
            if force.is_finite() {
                particles.push_force(i, force);
            }
        }
    }
}

/// A flow at one instant.
#[derive(Clone, Copy)]
pub(super) struct Current<'a> {
    flow: &'a AirFlow,
    /// Its gusts, if it has any.
    noise: Option<CurlNoise>,
}

impl<'a> Current<'a> {
    pub(super) fn of(flow: &'a AirFlow, time: f64) -> Self {
        let strength = flow.gusts * flow.velocity.length();
        let noise = (strength > 0.0).then(|| {
            CurlNoise::new(strength, flow.gust_length, flow.gust_period, flow.velocity, time)
        });
        Self { flow, noise }
    }

    /// The share of the flow at a place.
    #[inline]
    fn share(&self, place: WorldPoint) -> f32 {
        let everywhere = self.flow.region.extent == Extent::Everywhere;
        if everywhere { 1.0 } else { self.flow.region.share_at(place) }
    }
}

impl VectorField for Current<'_> {
    /// The velocity, m/s.
    #[inline(always)]
    fn at<L: Lanes>(&self, position: Vector<L>) -> Vector<L> {
        let steady = Vector::splat(self.flow.velocity);
        match &self.noise {
            Some(noise) => steady + noise.at(position),
            None => steady,
        }
    }
}

kernel!(
    /// Adds a flow's velocity at each triangle, and takes its density and coefficients if it is denser than the air so far.
    fn blend<L: Lanes>(
        particles: &Particles,
        surfaces: &[[u32; 3]],
        current: Current<'_>,
        triangles: &mut [Vec4],
        responses: &mut [Vec4],
    ) {
        let flow = current.flow;
        // Steady air everywhere needs no position.
        let same = current.noise.is_none() && flow.region.extent == Extent::Everywhere;
        let eights = triangles.chunks_exact_mut(LANES).zip(responses.chunks_exact_mut(LANES));
        for (corners, (local_air, responses)) in surfaces.chunks(LANES).zip(eights) {
            let mut middles = [Vec4::ZERO; LANES];
            for ((middle, corners), response) in middles.iter_mut().zip(corners).zip(&*responses) {
                if response.z > 0.0 && same {
                    *middle = Vec4::W;
                } else if response.z > 0.0 {
                    let place = WorldPoint::middle(particles, corners.map(|i| i as usize));
                    *middle = place.relative_to(Vec3::ZERO).extend(current.share(place));
                }
            }
            let (middle, share) = Vector::<L>::of(L::run(&middles, 0));
            let blows = L::zero().lt(share);
            let (velocity, density) = Vector::of(L::run(local_air, 0));
            let faster = velocity + current.at(middle) * share;
            let other = L::splat(0.5 * flow.density) * share;
            let denser = density.lt(other).and(blows);
            let [drag, lift, inverse_mass, rest] = L::run(responses, 0);
            let drag = denser.select(L::splat(flow.drag), drag);
            let lift = denser.select(L::splat(flow.lift), lift);
            let density = denser.select(other, density);
            L::put_run(local_air, 0, faster.or_else(blows, velocity).with(density));
            L::put_run(responses, 0, [drag, lift, inverse_mass, rest]);
        }
    }
);

/// The force of the air on triangles in a substep of `h` seconds.
struct AirForce<'a> {
    air: &'a Air,
    h: f32,
}

impl SurfaceForce for AirForce<'_> {
    /// The velocity of the air, m/s, and the triangles' response, without the time factor.
    type Local<L: Lanes> = (Vector<L>, AirResponse<L>);
    const NEEDS_MOTION: bool = true;

    #[inline(always)]
    fn at<L: Lanes>(&self, numbers: &[u32; LANES]) -> Option<Self::Local<L>> {
        let Air { triangles, responses, .. } = self.air;
        local_air(L::rows(triangles, numbers), L::rows(responses, numbers))
    }

    #[inline(always)]
    fn at_pairs<L: Lanes>(&self, first: usize) -> [Option<Self::Local<L>>; 2] {
        let Air { triangles, responses, .. } = self.air;
        let (flow, response) = (L::pairs(triangles, first), L::pairs(responses, first));
        [local_air(flow.0, response.0), local_air(flow.1, response.1)]
    }

    #[inline(always)]
    fn third<L: Lanes>(
        &self,
        (velocity, response): (Vector<L>, AirResponse<L>),
        twice_the_area: Vector<L>,
        motion: &Motion<L>,
    ) -> Vector<L> {
        let h = L::splat(self.h);
        // A force acts from the middle of the last substep to the middle of this one. The longer estimate is used, because not every integrator does that.
        let held = L::splat(0.5) * (motion.lag.max(h) + h);
        let relative = velocity - motion.sum * L::splat(THIRD);
        let response = AirResponse { inverse_mass: held * response.inverse_mass, ..response };
        let force = response.on_sheet(twice_the_area * L::splat(0.5), relative);
        // Speeds beyond 1e19 m/s overflow when squared: the force is dropped there. A triangle of no area has no force either.
        let largest = force.x.abs() + force.y.abs() + force.z.abs();
        let pushed = largest.lt(L::splat(f32::INFINITY));
        let third = force * L::splat(THIRD);
        Vector::new(pushed.and(third.x), pushed.and(third.y), pushed.and(third.z))
    }
}

/// The air at eight triangles and their response, from packed columns; `None` where there is no air.
#[inline(always)]
fn local_air<L: Lanes>(
    flow: [L; 4],
    [drag, lift, inverse_mass, _]: [L; 4],
) -> Option<(Vector<L>, AirResponse<L>)> {
    let (velocity, density) = Vector::of(flow);
    let response = AirResponse { drag: density * drag, lift: density * lift, inverse_mass };
    L::zero().lt(density).any().then_some((velocity, response))
}

impl<L: Lanes> AirResponse<L> {
    /// The force on sheets of the given area vectors (m²) from air that moves at `v` relative to them (m/s); N. Here `drag` and `lift` include the density, and
    /// `inverse_mass` the time for which the force is held.
    #[inline(always)]
    fn on_sheet(&self, area: Vector<L>, v: Vector<L>) -> Vector<L> {
        let one = L::splat(1.0);
        let (size, speed) = (area.length(), v.length());
        let facing = area.dot(v);
        let slowing = self.drag * facing.abs();
        let x = self.inverse_mass * slowing;
        let overshoots = one.lt(x);
        let force = v * (overshoots.select(slowing / x, slowing));
        let x = overshoots.select(one, x);
        let across = (area * speed - v * (facing / speed)) * (facing / size);
        let lift = across * self.lift;
        let y = lift * (self.inverse_mass / speed);
        let (room, taken) = (L::splat(0.5) * x * (L::splat(2.0) - x), y.length_squared());
        let lift = lift * room.lt(taken).select((room / taken).sqrt(), one);
        let exposed = L::zero().lt(size).and(L::zero().lt(speed));
        (force + lift).or_else(exposed, Vector::splat(Vec3::ZERO))
    }
}

impl BallAir {
    /// Adds a flow's velocity, and takes its density and coefficient if it is denser than the air so far.
    fn blend(&mut self, current: &Current, particles: &Particles, i: usize) {
        let place = WorldPoint::of(particles, i);
        let share = current.share(place);
        if share > 0.0 {
            self.velocity += at_one_place(place.relative_to(Vec3::ZERO), *current) * share;
            let density = 0.5 * current.flow.density * share;
            if density > self.density {
                let silhouette = PI * particles.radius(i) * particles.radius(i);
                (self.density, self.drag) = (density, BALL * silhouette);
            }
        }
    }

    /// The force on a ball from air that moves at `v` relative to it (m/s), held for `tau` seconds; N.
    #[inline]
    fn on_ball(&self, v: Vec3, tau: f32) -> Vec3 {
        let slowing = self.density * self.drag * v.length();
        let x = tau * self.inverse_mass * slowing;
        v * if x > 1.0 { slowing / x } else { slowing }
    }
}
