//! Which distances become segments, and the shapes of those.

use super::super::{BoxSpec, RopeSpec, box_3d, rope};
use super::*;

#[test]
fn each_rod_of_a_rope_becomes_a_capsule_as_thick_as_the_thinner_end() {
    let mut body = rope(&RopeSpec { segments: 4, radius: 0.02, ..RopeSpec::default() }).unwrap();
    body.particles[4].radius = 0.1;
    body.particles[0].radius = 0.01;
    body.distances[2].bound = Bound::AtMost;
    let body = body.with_segments();
    assert_eq!(body.validate(), Ok(()));
    assert_eq!(body.parts.len(), 4);
    for (i, (part, radius)) in body.parts.iter().zip([0.01, 0.02, 0.02, 0.02]).enumerate() {
        assert_eq!((part.name, &part.particles[..]), ("segment", &[i as u32, i as u32 + 1][..]));
        assert_eq!(part.rest, [Vec3::Y * 0.125, Vec3::Y * -0.125]);
        assert_eq!(part.size, Vec3::new(2.0 * radius, 0.25 + 2.0 * radius, 2.0 * radius));
        assert_eq!(part.shape, Shape::capsule(radius, 0.25).ok());
    }
}

#[test]
fn struts_rods_within_a_part_and_what_has_no_thickness_become_none() {
    let mut body = rope(&RopeSpec { segments: 3, ..RopeSpec::default() }).unwrap();
    body.particles[0].radius = 0.0;
    body.distances[1].bound = Bound::AtLeast;
    body.distances.push(Distance::new(0, 9, 1.0));
    assert_eq!(body.with_segments().parts.len(), 1);
    let mut body = box_3d(&BoxSpec::default()).unwrap();
    body.particles.iter_mut().for_each(|particle| particle.radius = 0.1);
    body.parts[0].shape = Shape::cuboid(Vec3::ONE).ok();
    assert_eq!(body.clone().with_segments(), body);
}
