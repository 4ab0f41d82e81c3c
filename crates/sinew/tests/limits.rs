//! Limits of joints push back into their range and never pull, however soft and damped they are.
//!
//! The damping of a soft limit used to act as long as the joint was beyond it, in both directions: at critical damping it held back what left the limit until
//! that stood still on it.

use sinew::constraints::{Angle, Cone, Hinge};
use sinew::glam::Vec3;
use sinew::{Constraint, ConstraintKind, Distance, ParticleSeed, Simulation, Softness};

#[derive(Clone, Copy, Debug)]
enum Kind {
    Angle,
    Hinge,
    Cone,
}

/// Whether the limit is the upper or the lower end of the range.
#[derive(Clone, Copy, Debug, PartialEq)]
enum End {
    Upper,
    Lower,
}

/// Some weightless bars of 1 m and 1 kg, each on a joint of its own at an angle of 1.5 rad, where its range ends, that move out of it at `speed`, m/s.
fn bars(count: usize, (kind, end): (Kind, End), softness: Softness, speed: f32) -> Simulation {
    let mut world = Simulation::default();
    world.forces.gravity = Vec3::ZERO;
    let outwards: f32 = if end == End::Upper { 1.0 } else { -1.0 };
    let (min, max) = if end == End::Upper { (0.2, 1.5) } else { (1.5, 2.9) };
    let angle = 1.5 + 0.1 * outwards;
    let (sine, cosine) = angle.sin_cos();
    for _ in 0..count {
        let mut push = |seed| world.particles.push(seed).unwrap();
        let [from, joint, axis] =
            [Vec3::X, Vec3::ZERO, Vec3::Z].map(|at| push(ParticleSeed::at(at).pinned()));
        let velocity = Vec3::new(-sine, cosine, 0.0) * (speed * outwards);
        let bar = ParticleSeed::at(Vec3::new(cosine, sine, 0.0)).with_velocity(velocity);
        let bar = push(bar);
        world.distances_mut().push(Distance::new(joint, bar, 1.0));
        let (rows, kind) = match kind {
            Kind::Angle => {
                let own = Angle::between(min, max).with_softness(softness);
                (vec![from, joint, bar], ConstraintKind::Angle(own))
            }
            Kind::Hinge => {
                let own = Hinge::between(min, max).with_softness(softness);
                (vec![from, joint, axis, bar], ConstraintKind::Hinge(own))
            }
            Kind::Cone => {
                let own = Cone::about(Vec3::ZERO, Vec3::X, Vec3::Z, Vec3::X, max).unwrap();
                let own = ConstraintKind::Cone(own.with_softness(softness));
                (vec![joint, from, axis, bar], own)
            }
        };
        world.constraints_mut().push(Constraint::new(rows, kind));
    }
    world
}

#[test]
fn a_soft_and_damped_limit_lets_go_of_what_leaves_it() {
    let soft = [
        Softness::frequency(2.0, 0.0),
        Softness::frequency(2.0, 1.0),
        Softness::frequency(2.0, 3.0),
        Softness::frequency(6.0, 1.0),
        Softness::spring(20.0, 5.0),
        Softness::spring(20.0, 30.0),
    ];
    let limits = [
        (Kind::Angle, End::Upper),
        (Kind::Angle, End::Lower),
        (Kind::Hinge, End::Upper),
        (Kind::Hinge, End::Lower),
        (Kind::Cone, End::Upper),
    ];
    for limit in limits {
        for (softness, count) in soft.into_iter().flat_map(|soft| [(soft, 1), (soft, 9)]) {
            for speed in [1.0, 0.0, -0.5] {
                for substeps in [4, 10, 40] {
                    let mut world = bars(count, limit, softness, speed);
                    world.settings.substeps = substeps;
                    let (mut most, mut inwards) = (f32::MIN, 0.0);
                    for _ in 0..60 {
                        world.step(1.0 / 60.0).unwrap();
                        let bar = world.particles.position(3);
                        let across = Vec3::new(bar.y, -bar.x, 0.0);
                        let sign = if limit.1 == End::Upper { 1.0 } else { -1.0 };
                        inwards = world.particles.velocity(3).dot(across) * sign;
                        most = most.max(inwards);
                        let range = if limit.1 == End::Upper { 0.3..1.5 } else { 1.5..2.8 };
                        if range.contains(&bar.y.atan2(bar.x)) {
                            break;
                        }
                    }
                    assert!(
                        inwards > 0.95 * most && most > 0.0,
                        "{limit:?}, {softness:?}, {count}, {speed} m/s, {substeps}: \
                         {inwards} of {most} m/s"
                    );
                }
            }
        }
    }
}

/// A range of a single angle is no limit: it is kept from both sides, and its damping brings it to rest.
#[test]
fn a_single_angle_is_damped_in_both_directions() {
    for softness in [Softness::frequency(2.0, 1.0), Softness::spring(160.0, 25.0)] {
        let mut world = bars(1, (Kind::Hinge, End::Upper), softness, 0.0);
        let ConstraintKind::Hinge(own) = &mut world.constraints_mut()[0].kind else { return };
        own.min = own.max;
        for _ in 0..90 {
            world.step(1.0 / 60.0).unwrap();
        }
        let bar = world.particles.position(3);
        assert!((bar.y.atan2(bar.x) - 1.5).abs() < 1e-3, "{bar}");
    }
}
