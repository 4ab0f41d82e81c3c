//! Wind pressure on triangles (physics.md F5), with gusts that travel downwind.

use core::ops::Range;

use glam::{Vec3, Vec4};

use super::gusts::{VectorField, arch, at_one_place, fraction};
use super::surfaces::{Motion, PackedSurfaces, SurfaceForce};
use crate::forces::region::{Extent, Region, WorldPoint};
use crate::lanes::{InstructionSet, LANES, Lanes, Vector, kernel};
use crate::particles::Particles;

/// A wind that presses on surfaces, everywhere or in a region.
///
/// A triangle whose area projected along the wind is `A` gets the force `A ‖w‖` along `w`, whichever side faces the wind, a third of it on each corner. `w` is
/// a pressure; the motion of the cloth has no effect on it. For drag relative to moving air, use [`AirFlow`](super::AirFlow).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wind {
    /// Direction of the wind, and its dynamic pressure in pascal (N/m²): ½ρv², so 10 m/s of air is 61 Pa, 3 m/s is 5.5 Pa.
    pub pressure: Vec3,
    /// Strength of gusts as a share of the pressure. Default 0: a steady wind.
    pub gusts: f32,
    /// Distance between gusts along the wind, metres. Default 2.
    pub gust_length: f32,
    /// Time between gusts at one place, seconds. Default 1.3.
    pub gust_period: f32,
    /// Where it blows. Default everywhere. Where the region fades, the pressure fades.
    pub region: Region,
}

impl Wind {
    /// A steady wind of the given direction and pressure (Pa), everywhere.
    pub fn steady(pressure: Vec3) -> Self {
        let region = Region::EVERYWHERE;
        Self { pressure, gusts: 0.0, gust_length: 2.0, gust_period: 1.3, region }
    }

    /// The same wind with gusts of the given share.
    pub fn with_gusts(self, gusts: f32) -> Self {
        Self { gusts, ..self }
    }

    /// The same wind, in a region only.
    pub fn within(self, region: Region) -> Self {
        Self { region, ..self }
    }

    /// The pressure at a position and time, Pa: a pure function of both, so gusts have no state to save.
    pub fn at(&self, position: Vec3, time: f64) -> Vec3 {
        at_one_place(position, Gusts::of(self, time)) * self.region.share(position)
    }

    /// Whether every number is finite, and gust length and period are positive. An invalid wind does nothing.
    pub fn is_valid(&self) -> bool {
        self.pressure.is_finite()
            && self.gusts.is_finite()
            && self.gust_length.is_finite()
            && self.gust_length > 0.0
            && self.gust_period.is_finite()
            && self.gust_period > 0.0
            && self.region.is_valid()
    }
}

/// The winds at each triangle in a step: `[x y z k]`, the pressure in Pa and `1/(6 ‖w‖)`, which [`apply`] needs. `k` is 0 where there is no wind.
#[derive(Clone, Debug, Default)]
pub(crate) struct Pressures {
    winds: Vec<Sampled>,
    /// The values of the winds that are not uniform, one wind after another, for all triangles.
    each: Vec<Vec4>,
}

#[derive(Clone, Debug)]
enum Sampled {
    Everywhere(Vec4),
    /// A range of `each`.
    Each(Range<usize>),
}

impl Pressures {
    pub(crate) fn clear(&mut self) {
        self.winds.clear();
        self.each.clear();
    }

    /// Whether there is no wind.
    pub(crate) fn is_empty(&self) -> bool {
        self.winds.is_empty()
    }

    pub(crate) fn winds(&self) -> impl Iterator<Item = Pressure<'_>> {
        self.winds.iter().map(|wind| match wind {
            Sampled::Everywhere(w) => Pressure::Everywhere(*w),
            Sampled::Each(range) => Pressure::Each(&self.each[range.clone()]),
        })
    }

    /// Whether any wind blows on triangle `number`.
    pub(crate) fn acts_on(&self, number: usize) -> bool {
        self.winds().any(|wind| match wind {
            Pressure::Everywhere(w) => w.w != 0.0,
            Pressure::Each(of) => of[number].w != 0.0,
        })
    }

    /// Adds `wind` at the time `time`, seconds; nothing if it is invalid or zero.
    ///
    /// Gusts are sampled once a step, not once a substep: they change only over a good part of a second.
    pub(crate) fn sample(
        &mut self,
        particles: &Particles,
        surfaces: &[[u32; 3]],
        wind: &Wind,
        time: f64,
        instructions: InstructionSet,
    ) {
        if !wind.is_valid() || wind.pressure == Vec3::ZERO || surfaces.is_empty() {
            return;
        }
        let gusts = Gusts::of(wind, time);
        let region = (wind.region.extent != Extent::Everywhere).then_some(&wind.region);
        self.winds.push(if gusts.gusts == 0.0 && region.is_none() {
            let strength = wind.pressure.length();
            let k = if strength > 0.0 { 0.5 * THIRD / strength } else { 0.0 };
            Sampled::Everywhere(wind.pressure.extend(k))
        } else {
            let begin = self.each.len();
            sample_gusts(particles, surfaces, gusts, region, &mut self.each, instructions);
            Sampled::Each(begin..self.each.len())
        });
    }
}

/// Adds the force of winds on each triangle: `‖½ (p1-p0)×(p2-p0) · w‖ · w/‖w‖`, a third to each corner. With `only_particles` only on the triangles
/// of particles that do not move as rigid states.
pub(crate) fn apply(
    particles: &mut Particles,
    surfaces: &PackedSurfaces,
    pressures: &Pressures,
    only_particles: bool,
    instructions: InstructionSet,
) {
    for wind in pressures.winds() {
        surfaces.accelerate(particles, &wind, only_particles, instructions);
    }
}

/// A wind at each triangle of a list.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Pressure<'a> {
    /// The same value at all of them.
    Everywhere(Vec4),
    Each(&'a [Vec4]),
}

impl Pressure<'_> {
    /// Pressures at eight triangles, Pa, and their factors `1/(6 ‖w‖)`.
    #[inline(always)]
    pub(crate) fn of<L: Lanes>(&self, numbers: &[u32; LANES]) -> (Vector<L>, L) {
        Vector::of(match self {
            Self::Everywhere(w) => splat(*w),
            Self::Each(of) => L::rows(of, numbers),
        })
    }
}

impl SurfaceForce for Pressure<'_> {
    type Local<L: Lanes> = (Vector<L>, L);
    const NEEDS_MOTION: bool = false;

    #[inline(always)]
    fn at<L: Lanes>(&self, numbers: &[u32; LANES]) -> Option<Self::Local<L>> {
        blowing(self.of(numbers))
    }

    #[inline(always)]
    fn at_pairs<L: Lanes>(&self, first: usize) -> [Option<Self::Local<L>>; 2] {
        let (one, other) = match self {
            Self::Everywhere(w) => (splat(*w), splat(*w)),
            Self::Each(of) => L::pairs(of, first),
        };
        [blowing(Vector::of(one)), blowing(Vector::of(other))]
    }

    #[inline(always)]
    fn third<L: Lanes>(&self, (w, k): (Vector<L>, L), area: Vector<L>, _: &Motion<L>) -> Vector<L> {
        let force = w * (area.dot(w).abs() * k);
        // Zero where there is no wind, even if the area is not finite.
        let blows = L::zero().lt(k);
        Vector::new(blows.and(force.x), blows.and(force.y), blows.and(force.z))
    }
}

#[inline(always)]
fn splat<L: Lanes>(w: Vec4) -> [L; 4] {
    Vector::splat(w.truncate()).with(L::splat(w.w))
}

/// `None` if there is no wind at any of the eight.
#[inline(always)]
fn blowing<L: Lanes>((w, k): (Vector<L>, L)) -> Option<(Vector<L>, L)> {
    L::zero().lt(k).any().then_some((w, k))
}

kernel!(
    fn sample_gusts<L: Lanes>(
        particles: &Particles,
        surfaces: &[[u32; 3]],
        gusts: Gusts,
        // `None` for everywhere.
        region: Option<&Region>,
        pressures: &mut Vec<Vec4>,
    ) {
        for eight in surfaces.chunks(LANES) {
            // A triangle with a missing row is left without wind.
            let mut middles = [Vec4::ZERO; LANES];
            for (middle, corners) in middles.iter_mut().zip(eight) {
                // Not with `map`, which is not inlined in a kernel.
                let [a, b, c] = *corners;
                let corners = [a as usize, b as usize, c as usize];
                if corners.iter().all(|&i| i < particles.len()) {
                    let share = region.map_or(1.0, |region| {
                        region.share_at(WorldPoint::middle(particles, corners))
                    });
                    let [a, b, c] = corners;
                    let sum = particles.position(a) + particles.position(b) + particles.position(c);
                    *middle = (sum * THIRD).extend(share);
                }
            }
            let (middle, share) = Vector::<L>::of(L::run(&middles, 0));
            let pressure = gusts.at(middle) * share;
            let strength = pressure.length();
            let k = L::zero().lt(strength).and(L::splat(0.5 * THIRD) / strength);
            let mut found = [Vec4::ZERO; LANES];
            L::put_run(&mut found, 0, pressure.with(k));
            pressures.extend_from_slice(&found[..eight.len()]);
        }
    }
);

const THIRD: f32 = 1.0 / 3.0;

/// The waves of a wind's gusts at one instant.
///
/// Three travel downwind and modulate the pressure; two more sway it sideways by as much, which keeps a flag from settling edge-on to the wind. The ratios of
/// their speeds and densities are far from simple fractions, so the sum does not repeat within a scene.
struct Gusts {
    steady: Vec3,
    /// Sway amplitude: a horizontal unit vector across the wind, times the strength of the gusts, Pa.
    sway: Vec3,
    /// Unit vector along the wind over the gust length, 1/m.
    along: Vec3,
    /// One over the gust length, for the height: 1/m.
    height: f32,
    gusts: f32,
    /// Phase of each wave, cycles in -1..1.
    run: [f32; 5],
}

/// Of each wave: speed, density, slant with height, strength.
const WAVES: [[f32; 4]; 5] = [
    [1.0, 1.0, 0.21, 0.5],
    [1.71, 2.3, -0.4, 0.3],
    [3.07, 1.13, 0.9, 0.2],
    [0.83, 1.37, 0.33, 0.6],
    [2.23, 1.9, -0.57, 0.4],
];

impl Gusts {
    fn of(wind: &Wind, time: f64) -> Self {
        let strength = wind.pressure.length();
        let along = wind.pressure.normalize_or_zero();
        let turns = time / f64::from(wind.gust_period);
        Self {
            steady: wind.pressure,
            sway: level_across(along) * (strength * wind.gusts),
            along: along / wind.gust_length,
            height: 1.0 / wind.gust_length,
            gusts: wind.gusts,
            run: WAVES.map(|[speed, ..]| fraction(turns * f64::from(speed))),
        }
    }

    /// One of the waves, at eight positions given in gust lengths along the wind and up.
    #[inline(always)]
    fn wave<L: Lanes>(&self, i: usize, place: L, height: L) -> L {
        let [_, density, slant, strength] = WAVES[i];
        let turn = L::splat(self.run[i]) - place * L::splat(density) + height * L::splat(slant);
        L::splat(strength) * arch(turn)
    }
}

impl VectorField for Gusts {
    /// The pressure, Pa.
    #[inline(always)]
    fn at<L: Lanes>(&self, position: Vector<L>) -> Vector<L> {
        let steady = Vector::splat(self.steady);
        if self.gusts == 0.0 {
            return steady;
        }
        let place = position.dot(Vector::splat(self.along));
        let height = position.y * L::splat(self.height);
        let push =
            self.wave(0, place, height) + self.wave(1, place, height) + self.wave(2, place, height);
        let sway = self.wave(3, place, height) + self.wave(4, place, height);
        steady * (L::splat(1.0) + L::splat(self.gusts) * push) + Vector::splat(self.sway) * sway
    }
}

/// A unit vector across `along`: horizontal, or along x where `along` is vertical.
fn level_across(along: Vec3) -> Vec3 {
    along.cross(Vec3::Y).try_normalize().unwrap_or(Vec3::X)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particles::ParticleSeed;

    fn pushed(particles: &mut Particles, surfaces: &[[u32; 3]], wind: &Wind) -> Vec3 {
        let (mut pressures, instructions) = (Pressures::default(), InstructionSet::best());
        pressures.sample(particles, surfaces, wind, 0.0, instructions);
        particles.clear_sums(0.0);
        let packed = PackedSurfaces::of(surfaces, particles);
        apply(particles, &packed, &pressures, false, instructions);
        (0..particles.len()).map(|i| particles.acceleration(i)).sum()
    }

    #[test]
    fn a_flat_sheet_feels_area_times_pressure_times_the_cosine_along_the_wind() {
        let mut sheet = Particles::default();
        for (x, y) in [(0.0, 0.0), (2.0, 0.0), (2.0, 3.0), (0.0, 3.0)] {
            sheet.push(ParticleSeed::at(Vec3::new(x, y, 0.0))).unwrap();
        }
        let surfaces = [[0, 1, 2], [0, 2, 3]];
        for degrees in [0.0_f64, 30.0, 60.0, 90.0, 120.0] {
            let angle = degrees.to_radians();
            let direction = Vec3::new(libm::sin(angle) as f32, 0.0, libm::cos(angle) as f32);
            let force = pushed(&mut sheet, &surfaces, &Wind::steady(direction * 5.0));
            let expected = direction * (6.0 * 5.0 * libm::cos(angle).abs() as f32);
            assert!(force.abs_diff_eq(expected, 1e-4), "{degrees}°: {force}");
        }
    }

    #[test]
    fn a_closed_body_feels_twice_its_silhouette_since_both_sides_show() {
        // The formula takes the magnitude, so the wind acts on the lee side of a closed body as well: front and back each sum to the silhouette.
        let corners: Vec<Vec3> = (0..8)
            .map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32))
            .collect();
        let faces =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let mut cube = Particles::default();
        for corner in corners {
            cube.push(ParticleSeed::at(corner)).unwrap();
        }
        let surfaces: Vec<[u32; 3]> =
            faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        let w = Vec3::new(3.0, 2.0, 1.0);
        let force = pushed(&mut cube, &surfaces, &Wind::steady(w));
        let silhouette = (w.x + w.y + w.z) / w.length();
        assert!((force.length() - 2.0 * silhouette * w.length()).abs() < 1e-4);
    }

    #[test]
    fn gusts_vary_in_place_and_time_around_the_steady_pressure() {
        let wind = Wind::steady(Vec3::X * 10.0).with_gusts(0.5);
        let samples: Vec<Vec3> = (0..4000)
            .map(|i| wind.at(Vec3::new(i as f32 * 0.37, 0.0, 0.0), f64::from(i) * 0.11))
            .collect();
        let mean = samples.iter().sum::<Vec3>() / samples.len() as f32;
        let most = samples.iter().map(|s| s.x).fold(0.0, f32::max);
        assert!(mean.abs_diff_eq(Vec3::X * 10.0, 0.3), "{mean}");
        assert!(most > 12.0 && most <= 15.0, "{most}");
        assert_eq!(samples[7], wind.at(Vec3::new(7.0 * 0.37, 0.0, 0.0), 7.0 * 0.11));
    }

    #[test]
    fn a_wind_in_a_region_blows_there_only_and_fades_towards_its_surface() {
        let tunnel = Region::boxed(Vec3::ZERO, Vec3::new(10.0, 4.0, 4.0)).with_fade(1.0);
        let wind = Wind::steady(Vec3::Z * 8.0).within(tunnel);
        let pressed = |x: f32| {
            let mut sheet = Particles::default();
            for corner in [Vec3::ZERO, Vec3::X, Vec3::Y] {
                let middle = Vec3::new(THIRD, THIRD, 0.0);
                sheet.push(ParticleSeed::at(corner - middle + Vec3::X * x)).unwrap();
            }
            pushed(&mut sheet, &[[0, 1, 2]], &wind).z
        };
        assert!((pressed(0.0) - 4.0).abs() < 1e-5);
        assert!((pressed(4.5) - 2.0).abs() < 1e-4, "half a metre deep: half of it");
        assert_eq!(pressed(5.1), 0.0);
        assert!((wind.at(Vec3::X * 4.5, 0.0).z - 4.0).abs() < 1e-5);
        assert!(!wind.within(Region::sphere(Vec3::ZERO, f32::NAN)).is_valid());
    }

    #[test]
    fn a_wind_with_a_broken_number_does_not_blow() {
        let mut sheet = Particles::default();
        for corner in [Vec3::ZERO, Vec3::X, Vec3::Y] {
            sheet.push(ParticleSeed::at(corner)).unwrap();
        }
        assert_eq!(pushed(&mut sheet, &[[0, 1, 2]], &Wind::steady(Vec3::NAN)), Vec3::ZERO);
    }
}
