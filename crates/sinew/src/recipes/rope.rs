//! Ropes: a chain of particles, each connected to the next (physics.md B3). Also a pendulum (one segment), a bridge, a leash.

use glam::{DVec3, Vec3};

use super::blueprint::Blueprint;
use super::fault::{RecipeFault, check_mass, check_particles, ensure};
use super::limits::{LENGTHS, MAX_PARTICLES, is_compliance};
use crate::constraints::{Bound, Distance};
use crate::particles::ParticleSeed;

/// A rope to build. The default hangs 1 m down from the origin: 20 segments, 0.1 kg, 1 cm radius, nothing pinned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RopeSpec {
    /// Position of the start and of particle 0, metres, up to 1e6 on each axis. Default the origin.
    pub from: Vec3,
    /// Position of the end and of the last particle, metres; must differ from `from`. Default 1 m below the origin.
    pub to: Vec3,
    /// Number of segments, 1 to 16 777 215. Default 20. The rope has one more particle than that.
    pub segments: u32,
    /// Mass of the whole rope, kg, 1e-9 to 1e12. Default 0.1. A segment's mass is shared by its two ends, so the two end particles have half the mass of the
    /// others: that is a uniform rope, with its centre of mass in the middle, and the load below any particle is right. (`mass/(n+1)` each would make the ends
    /// too heavy.)
    pub mass: f32,
    /// Radius of every particle, metres, 0 or more. Default 0.01.
    pub radius: f32,
    /// Extra length, as a share of the gap between the ends, 0 to 100. Default 0. A slack rope starts as an arc that sags towards -y (a vertical one towards
    /// +x), with all segments at their rest length, so it starts without a jolt.
    pub slack: f32,
    /// Bound on the length of each segment. Default [`Bound::Equal`]. [`Bound::AtMost`] lets the rope crumple as thread does.
    pub bound: Bound,
    /// Compliance of each segment, m/N, 0 or more. Default 0: it does not stretch. A rope of `n` segments has the stiffness `1/(n·compliance)`, N/m.
    pub compliance: f32,
    /// Share of the velocity lost per second, 0 to 1. Default 0.
    pub drag: f32,
    /// Whether particle 0 is pinned. Default false.
    pub pin_start: bool,
    /// Whether the last particle is pinned. Default false.
    pub pin_end: bool,
}

impl Default for RopeSpec {
    fn default() -> Self {
        Self {
            from: Vec3::ZERO,
            to: Vec3::NEG_Y,
            segments: 20,
            mass: 0.1,
            radius: 0.01,
            slack: 0.0,
            bound: Bound::Equal,
            compliance: 0.0,
            drag: 0.0,
            pin_start: false,
            pin_end: false,
        }
    }
}

/// Builds a rope: `segments + 1` particles from start to end, and as many distances as segments, in the same order.
pub fn rope(spec: &RopeSpec) -> Result<Blueprint, RecipeFault> {
    check(spec)?;
    let (from, to) = (spec.from.as_dvec3(), spec.to.as_dvec3());
    let length = (to - from).length() * (1.0 + f64::from(spec.slack));
    let piece = (length / f64::from(spec.segments)) as f32;
    let share = spec.mass / spec.segments as f32;
    let seed = |(i, position): (u32, Vec3)| {
        let end = i == 0 || i == spec.segments;
        ParticleSeed::at(position)
            .with_mass(if end { 0.5 * share } else { share })
            .with_radius(spec.radius)
            .with_drag(spec.drag)
    };
    let tie = |i| {
        let tie = Distance::new(i, i + 1, piece).with_bound(spec.bound);
        tie.with_compliance(spec.compliance)
    };
    let places = (0..=spec.segments).zip(line(spec, from, to));
    let mut body = Blueprint {
        particles: places.map(seed).collect(),
        distances: (0..spec.segments).map(tie).collect(),
        ..Blueprint::default()
    };
    for (end, pinned) in [(0, spec.pin_start), (spec.segments, spec.pin_end)] {
        if pinned {
            // Both ends exist, so this does not fail.
            let _ = body.pin(end);
        }
    }
    Ok(body)
}

fn check(spec: &RopeSpec) -> Result<(), RecipeFault> {
    let near = |p: Vec3| p.is_finite() && p.abs().max_element() <= *LENGTHS.end();
    let gap = (spec.to.as_dvec3() - spec.from.as_dvec3()).length() as f32;
    ensure(near(spec.from) && near(spec.to), RecipeFault::Ends)?;
    ensure(LENGTHS.contains(&gap), RecipeFault::Apart)?;
    let segments = u64::from(spec.segments);
    ensure((1..MAX_PARTICLES).contains(&segments), RecipeFault::Segments)?;
    check_mass(spec.mass)?;
    ensure((0.0..=100.0).contains(&spec.slack), RecipeFault::Slack)?;
    ensure(spec.slack == 0.0 || spec.segments > 1, RecipeFault::SlackOfOne)?;
    ensure(is_compliance(spec.compliance), RecipeFault::Compliance)?;
    check_particles(spec.radius, spec.drag)
}

/// The particles' positions, start to end: on a circle through both ends, at equal angles, so that the chords between neighbours are equal; on the straight
/// line if there is no slack.
///
/// With the half angle `β` of the arc, its radius is `R = D/(2 sin β)`. The point at `θ` in `[-β, β]` is at `R sin θ` along the rope and `R (cos θ - cos β) =
/// 2R sin((β+θ)/2) sin((β-θ)/2)` below it; the product form has no cancellation when the sag is small.
fn line(spec: &RopeSpec, from: DVec3, to: DVec3) -> impl Iterator<Item = Vec3> {
    let (n, gap) = (f64::from(spec.segments), (to - from).length());
    let along = (to - from) / gap;
    let below = sag_direction(along);
    let half = half_angle(n, f64::from(spec.slack));
    let radius = 0.5 * gap / libm::sin(half);
    let (segments, slack) = (spec.segments, spec.slack);
    (0..=segments).map(move |i| {
        let share = f64::from(i) / n;
        let point = if i == segments {
            to
        } else if i == 0 || slack == 0.0 {
            from + along * (gap * share)
        } else {
            let theta = half * (2.0 * share - 1.0);
            let sag = libm::sin(0.5 * (half + theta)) * libm::sin(0.5 * (half - theta));
            from.midpoint(to) + along * (radius * libm::sin(theta)) + below * (2.0 * radius * sag)
        };
        point.as_vec3()
    })
}

/// The direction downward and perpendicular to the rope; +x for a rope within 0.06° of vertical, where downward is undefined.
fn sag_direction(along: DVec3) -> DVec3 {
    let square = |v: DVec3| v - along * v.dot(along);
    let down = square(DVec3::NEG_Y);
    if down.length() > 1e-3 { down.normalize() } else { square(DVec3::X).normalize() }
}

/// Half the angle of the arc whose `n` equal chords have a total length of `1 + slack` times the gap between its ends: `n sin(β/n)/sin β = 1 + slack`. The left
/// side increases from 1 at 0 to infinity at π, so it is solved by bisection: 60 steps, to the last bit of an `f64`.
fn half_angle(n: f64, slack: f64) -> f64 {
    let (mut low, mut high) = (0.0, std::f64::consts::PI);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if n * libm::sin(middle / n) < (1.0 + slack) * libm::sin(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::super::blueprint::checks::assert_at_rest;
    use super::*;

    #[test]
    fn a_straight_rope_is_uniform_and_its_pieces_are_equal() {
        let spec = RopeSpec {
            from: Vec3::new(1.0, 2.0, 3.0),
            to: Vec3::new(4.0, 2.0, 7.0),
            segments: 10,
            mass: 2.0,
            ..RopeSpec::default()
        };
        let body = rope(&spec).unwrap();
        assert_at_rest(&body);
        assert_eq!((body.particles.len(), body.distances.len()), (11, 10));
        assert!((body.total_mass() - 2.0).abs() < 1e-6);
        assert_eq!(body.particles[0].mass, 0.1);
        assert_eq!(body.particles[5].mass, 0.2);
        assert_eq!((body.particles[0].position, body.particles[10].position), (spec.from, spec.to));
        assert!(body.distances.iter().all(|d| d.rest == 0.5));
    }

    #[test]
    fn a_slack_rope_starts_at_its_length_below_its_ends() {
        for (segments, slack) in [(2, 0.5), (7, 1e-4), (20, 0.5), (100, 0.01), (100, 50.0)] {
            for to in [Vec3::X, Vec3::NEG_Y, Vec3::new(2.0, 3.0, -1.0)] {
                let body = rope(&RopeSpec { to, segments, slack, ..RopeSpec::default() }).unwrap();
                assert_eq!(body.validate(), Ok(()));
                let ends = (body.particles[0].position, body.particles[segments as usize].position);
                assert_eq!(ends, (Vec3::ZERO, to));
                let length: f32 = body.distances.iter().map(|d| d.rest).sum();
                assert!((length / (to.length() * (1.0 + slack)) - 1.0).abs() < 1e-5);
                for d in &body.distances {
                    let [a, b] = [d.a, d.b].map(|i| body.particles[i as usize].position);
                    assert!(d.error(a, b) < 1e-5 * to.length(), "{segments} {slack} {to} {d:?}");
                }
                let middle = body.particles[segments as usize / 2].position;
                assert!(middle.y < 0.5 * to.y || to.x == 0.0 && middle.x > 0.0, "{middle}");
            }
        }
    }

    #[test]
    fn pins_bound_and_compliance_arrive() {
        let spec = RopeSpec {
            segments: 1,
            bound: Bound::AtMost,
            compliance: 0.25,
            pin_start: true,
            pin_end: true,
            ..RopeSpec::default()
        };
        let body = rope(&spec).unwrap();
        assert!(body.particles.iter().all(|p| p.mass == f32::INFINITY));
        let expected = Distance::new(0, 1, 1.0).with_bound(Bound::AtMost).with_compliance(0.25);
        assert_eq!(body.distances, [expected]);
    }

    #[test]
    fn each_fault_is_told_apart() {
        let refused = |change: fn(&mut RopeSpec)| {
            let mut spec = RopeSpec::default();
            change(&mut spec);
            rope(&spec).unwrap_err()
        };
        assert_eq!(refused(|s| s.to.x = f32::NAN), RecipeFault::Ends);
        assert_eq!(refused(|s| s.to = s.from), RecipeFault::Apart);
        assert_eq!(refused(|s| s.segments = 0), RecipeFault::Segments);
        assert_eq!(refused(|s| s.segments = u32::MAX), RecipeFault::Segments);
        assert_eq!(refused(|s| s.mass = 0.0), RecipeFault::Mass);
        assert_eq!(refused(|s| s.radius = f32::INFINITY), RecipeFault::Radius);
        assert_eq!(refused(|s| s.slack = -0.1), RecipeFault::Slack);
        assert_eq!(refused(|s| (s.slack, s.segments) = (0.1, 1)), RecipeFault::SlackOfOne);
        assert_eq!(refused(|s| s.compliance = f32::NAN), RecipeFault::Compliance);
        assert_eq!(refused(|s| s.drag = -1.0), RecipeFault::Drag);
    }
}
