//! What the figure must be: at rest, symmetrical, as heavy and as tall as asked.

use super::*;
use crate::recipes::blueprint::checks::assert_at_rest;

fn adult() -> Blueprint {
    ragdoll(&RagdollSpec::default()).unwrap()
}

#[test]
fn it_stands_at_rest_as_heavy_and_tall_as_asked() {
    for (height, mass) in [(1.75, 75.0), (0.3, 2.0), (1e-6, 1e12), (1e6, 1e-9)] {
        let body = ragdoll(&RagdollSpec { height, mass }).unwrap();
        assert_at_rest(&body);
        assert!((body.total_mass() / mass - 1.0).abs() < 1e-5);
        let ends = |sign: f32| body.particles.iter().map(move |p| p.position.y + sign * p.radius);
        let (sole, top) = (ends(-1.0).fold(height, f32::min), ends(1.0).fold(0.0, f32::max));
        assert!(sole.abs() < 1e-6 * height && (top / height - 1.0).abs() < 1e-6, "{sole} {top}");
    }
    let body = adult();
    assert_eq!((body.particles.len(), body.parts.len()), (17, 11));
}

#[test]
fn its_centre_is_where_a_standing_adults_is() {
    // 0.55 to 0.57 of the height; and above the feet, or it could not stand.
    let moment = |p: &ParticleSeed| p.position * p.mass;
    let centre = adult().particles.iter().map(moment).sum::<Vec3>() / 75.0 / 1.75;
    assert!((0.55..0.57).contains(&centre.y), "{centre}");
    assert!(centre.z.abs() < 0.01 && centre.x.abs() < 1e-6, "{centre}");
}

#[test]
fn left_and_right_are_mirror_images() {
    let body = adult();
    for joint in FIGURE.map(|joint| joint.particle) {
        let [a, b] = [joint, joint.mirrored()].map(|j| body.particles[j.index() as usize]);
        let mirrored = Vec3::new(-a.position.x, a.position.y, a.position.z);
        assert_eq!((b.position, b.mass, b.radius), (mirrored, a.mass, a.radius), "{joint:?}");
        assert_eq!(joint.mirrored().mirrored(), joint);
    }
    let key = |a: u32, b: u32, d: &Distance| {
        (a.min(b), a.max(b), d.bound == Bound::Equal, d.bound == Bound::AtMost)
    };
    let other = |i: u32| FIGURE[i as usize].particle.mirrored().index();
    for d in &body.distances {
        let image = key(other(d.a), other(d.b), d);
        let twin = body.distances.iter().find(|e| key(e.a, e.b, e) == image).unwrap();
        assert!((twin.rest - d.rest).abs() < 1e-6, "{d:?} {twin:?}");
    }
}

#[test]
fn parts_agree_with_their_particles() {
    let body = adult();
    for part in &body.parts {
        for (i, a) in part.particles.iter().enumerate() {
            for (j, b) in part.particles.iter().enumerate() {
                let [a, b] = [a, b].map(|k| body.particles[*k as usize].position);
                let rest = gap(part.rest[i], part.rest[j]);
                assert!((gap(a, b) - rest).abs() < 1e-6, "{} {i} {j}", part.name);
            }
        }
    }
    let drawn = |name: &str| body.parts.iter().find(|p| p.name == name).unwrap();
    let shin = drawn("left shin");
    let ends = [RagdollParticle::LeftKnee, RagdollParticle::LeftAnkle];
    assert_eq!(shin.particles, ends.map(RagdollParticle::index));
    assert!(shin.rest[0].y > 0.2 && shin.rest[0] == -shin.rest[1]);
}

#[test]
fn trunk_frames_are_rigid_and_limits_leave_room_to_move() {
    let body = adult();
    for name in ["torso", "pelvis"] {
        let part = body.parts.iter().find(|p| p.name == name).unwrap();
        let inside = |d: &&Distance| {
            d.bound == Bound::Equal
                && part.particles.contains(&d.a)
                && part.particles.contains(&d.b)
        };
        let n = part.particles.len();
        assert_eq!(body.distances.iter().filter(inside).count(), n * (n - 1) / 2, "{name}");
        let [a, b, c, d] = [0, 1, 2, 3].map(|i| part.rest[i]);
        let volume = (b - a).cross(c - a).dot(d - a) / 6.0;
        assert!(volume.abs() > 5e-5, "{name}: {volume} m³");
    }
    for d in body.distances.iter().filter(|d| d.bound != Bound::Equal) {
        let [a, b] = [d.a, d.b].map(|i| body.particles[i as usize].position);
        let room = (gap(a, b) - d.rest).abs();
        assert!(room > 0.003, "{d:?} leaves {room} m");
    }
}

#[test]
fn a_figure_without_a_height_or_mass_is_refused() {
    for height in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        let spec = RagdollSpec { height, ..RagdollSpec::default() };
        assert_eq!(ragdoll(&spec), Err(RagdollFault::Height));
    }
    for mass in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        let spec = RagdollSpec { mass, ..RagdollSpec::default() };
        assert_eq!(ragdoll(&spec), Err(RagdollFault::Mass));
    }
}
