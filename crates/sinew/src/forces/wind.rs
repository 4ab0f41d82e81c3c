//! Wind pressure on triangles, as the lectures give it (physics.md F5), with gusts that travel downwind.

use glam::Vec3;

use crate::particles::Particles;

/// A wind that blows everywhere.
///
/// The lectures' law: a triangle that shows the area `A` to the wind feels the force `A ‖w‖` along `w`, whichever side it shows, and a third
/// of it acts on each corner. `w` is a pressure, and the motion of the cloth does not matter to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wind {
    /// Direction of the wind, and its dynamic pressure in pascal (N/m²): ½ρv², so 10 m/s of air is 61 Pa, 3 m/s is 5.5 Pa.
    pub pressure: Vec3,
    /// How much gusts add and take, as a share of the pressure; default 0: a steady wind.
    pub gusts: f32,
    /// Distance between gusts along the wind, metres; default 2.
    pub gust_length: f32,
    /// Time between gusts at one place, seconds; default 1.3.
    pub gust_period: f32,
}

impl Wind {
    /// A steady wind of the given direction and pressure (Pa).
    pub fn steady(pressure: Vec3) -> Self {
        Self { pressure, gusts: 0.0, gust_length: 2.0, gust_period: 1.3 }
    }

    /// The same with gusts of the given share.
    pub fn with_gusts(self, gusts: f32) -> Self {
        Self { gusts, ..self }
    }

    /// The pressure at a place and time, Pa: a pure function of both, so that nothing about gusts needs to be saved.
    pub fn at(&self, position: Vec3, time: f64) -> Vec3 {
        Gusts::of(self, time).pressure(position)
    }

    /// Whether every number is finite and the gusts have a length and a period. An invalid wind does not blow.
    pub fn is_valid(&self) -> bool {
        self.pressure.is_finite()
            && self.gusts.is_finite()
            && self.gust_length.is_finite()
            && self.gust_length > 0.0
            && self.gust_period.is_finite()
            && self.gust_period > 0.0
    }
}

/// Appends the pressure of `wind` on each triangle at the time `time` (seconds), Pa. Nothing for a wind that does not blow.
///
/// Gusts are looked up once a step, not once a substep: they take a good part of a second to pass, and cost four times the force itself.
pub(crate) fn sample(
    particles: &Particles,
    surfaces: &[[u32; 3]],
    wind: &Wind,
    time: f64,
    pressures: &mut Vec<Vec3>,
) {
    if !wind.is_valid() || wind.pressure == Vec3::ZERO {
        return;
    }
    let gusts = Gusts::of(wind, time);
    pressures.extend(surfaces.iter().map(|corners| {
        // A triangle that names a row that is not there is left in the lee.
        if corners.iter().any(|&i| i as usize >= particles.len()) {
            return Vec3::ZERO;
        }
        let [p0, p1, p2] = corners.map(|i| particles.position(i as usize));
        gusts.pressure((p0 + p1 + p2) * THIRD)
    }));
}

/// Adds the force of a wind on each triangle: `‖½ (p1-p0)×(p2-p0) · w‖ · w/‖w‖`, a third to each corner. `pressures` holds the
/// [`sample`] of one wind after the other.
pub(crate) fn apply(particles: &mut Particles, surfaces: &[[u32; 3]], pressures: &[Vec3]) {
    if surfaces.is_empty() || !pressures.len().is_multiple_of(surfaces.len()) {
        return;
    }
    for pressures in pressures.chunks_exact(surfaces.len()) {
        for (corners, &w) in surfaces.iter().zip(pressures) {
            let strength = w.length();
            // The second for whoever exchanged triangles since the winds were sampled.
            if strength == 0.0 || corners.iter().any(|&i| i as usize >= particles.len()) {
                continue;
            }
            let [a, b, c] = corners.map(|i| i as usize);
            let [p0, p1, p2] = [a, b, c].map(|i| particles.position(i));
            let area = (p1 - p0).cross(p2 - p0) * 0.5;
            let third = w * (area.dot(w).abs() / strength * THIRD);
            for i in [a, b, c] {
                particles.add_force(i, third);
            }
        }
    }
}

const THIRD: f32 = 1.0 / 3.0;

/// The waves that a wind's gusts are made of, at one instant.
///
/// Three run downwind and push, two more sway it sideways by as much, which is what keeps a flag from freezing edge-on to the wind. Their
/// speeds and densities are in irrational ratios, as far as such numbers go, so that their sum does not repeat within a scene.
struct Gusts {
    steady: Vec3,
    /// Level unit vector across the wind, times the strength of the gusts, Pa.
    sway: Vec3,
    /// Unit vector along the wind, per gust length: 1/m.
    along: Vec3,
    /// Per metre of height, the same.
    height: f32,
    gusts: f32,
    /// How far each wave has run, turns in -1..1.
    run: [f32; 5],
}

/// How fast, how dense, how slanted with height, and how strong each wave is.
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
            // Whole turns are dropped in f64, so that gusts are as smooth after a day as in the first second.
            run: WAVES.map(|[speed, ..]| {
                let run = turns * f64::from(speed);
                (run - run as i64 as f64).clamp(-1.0, 1.0) as f32
            }),
        }
    }

    #[inline]
    fn pressure(&self, position: Vec3) -> Vec3 {
        if self.gusts == 0.0 {
            return self.steady;
        }
        let place = position.dot(self.along);
        let height = position.y * self.height;
        let wave = |i: usize| {
            let [_, density, slant, strength] = WAVES[i];
            strength * arch(self.run[i] - place * density + height * slant)
        };
        let push = wave(0) + wave(1) + wave(2);
        let sway = wave(3) + wave(4);
        self.steady * (1.0 + self.gusts * push) + self.sway * sway
    }
}

/// A smooth wave of period 1 between -1 and 1, of parabolas instead of a sine: a tenth of the time, and the same bits on every machine.
/// Beyond 2²² turns hardly a fraction is left: what it gives there is no wave, but never more than 1.
#[inline]
fn arch(turn: f32) -> f32 {
    // Adding 1.5·2²³ leaves no bits for a fraction, so this rounds to the nearest whole turn without a branch.
    const NO_FRACTION: f32 = 12_582_912.0;
    let whole = (turn + NO_FRACTION) - NO_FRACTION;
    // From -1 to 1, where 4 t (1 - |t|) is one whole wave.
    let t = 2.0 * (turn - whole).clamp(-0.5, 0.5);
    4.0 * t * (1.0 - t.abs())
}

/// A unit vector across another one: horizontal, or along x where that one is vertical.
fn level_across(along: Vec3) -> Vec3 {
    along.cross(Vec3::Y).try_normalize().unwrap_or(Vec3::X)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particles::ParticleSeed;

    fn pushed(particles: &mut Particles, surfaces: &[[u32; 3]], wind: &Wind) -> Vec3 {
        let mut pressures = Vec::new();
        sample(particles, surfaces, wind, 0.0, &mut pressures);
        particles.acceleration.fill(Vec3::ZERO);
        apply(particles, surfaces, &pressures);
        particles.acceleration.iter().sum()
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
        // The lectures take the magnitude, so the lee side of a closed body feels the wind as well: front and back each sum to the silhouette.
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
    fn a_wave_of_parabolas_is_close_to_a_sine_and_repeats() {
        for i in -4000..4000 {
            let turn = i as f32 * 0.00731;
            let sine = libm::sinf(turn * core::f32::consts::TAU);
            assert!((arch(turn) - sine).abs() < 0.06, "{turn}");
        }
        for far in [5e6, 1e9, 3e9, 1e30, f32::MAX] {
            assert!(arch(far).abs() <= 1.0 && arch(-far).abs() <= 1.0, "{far}");
        }
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
