//! Quality of P5's heap at rest: the speeds and the penetration of its boxes after twenty seconds, with as many substeps in both engines.

use sinew::Simulation;
use sinew::glam::{Quat, Vec3};
use sinew::pose::Pose;

use crate::measure::{Cube, Effort, Ours, World, mean_square};
use crate::peers;
use crate::row::{Row, Unit};

/// Ticks after which the heap should be at rest: 20 s.
const TICKS: usize = 1200;

/// Half an edge of a box, metres.
const HALF: f32 = 0.5;

/// Diagonal of a box, metres: boxes whose centres are farther apart do not touch.
const DIAGONAL: f32 = 1.733;

/// P5's heap of `edge³` boxes, with the same number of substeps in both engines: the remaining speed of its boxes, and in the note the deepest penetration.
pub(super) fn heaps(effort: &Effort, (mut world, edge): (Simulation, u32), substeps: u32) -> Row {
    let ticks = if effort.quick { TICKS / 10 } else { TICKS };
    world.settings.substeps = substeps;
    let scene = format!("the heap {} s later, {substeps} substeps each", ticks / 60);
    let row = Row::new("P5", scene, Unit::Speed).sized(world.distances().len(), substeps, 1);
    let later = |world: &mut dyn World| {
        (0..ticks).for_each(|_| world.tick());
        (1e3 * mean_square(&world.speeds()).sqrt(), 1e3 * deepest(&world.cubes()))
    };
    let (ours, depth) = later(&mut Ours(world));
    let peer = peers::heap(effort, edge, substeps).map(|mut peer| later(peer.as_mut()));
    let theirs = peer.map(|(_, depth)| format!(", rapier {depth:.2} mm")).unwrap_or_default();
    let note = format!("deepest penetration {depth:.2} mm{theirs}");
    Row { ours: Some(ours), peer: peer.map(|(speed, _)| speed), ..row }.noted(note)
}

/// Deepest penetration of any corner into another cube or the floor, metres.
pub(super) fn deepest(cubes: &[Cube]) -> f64 {
    let mut deepest = 0.0_f32;
    for (number, cube) in cubes.iter().enumerate() {
        let near = |other: &Cube| other.pose.translation.distance(cube.pose.translation) < DIAGONAL;
        let others = cubes.iter().enumerate().filter(|(other, _)| *other != number);
        let others: Vec<&Cube> =
            others.map(|(_, other)| other).filter(|other| near(other)).collect();
        for corner in corners(&cube.pose) {
            let inside = others.iter().map(|other| depth(&other.pose, corner)).fold(0.0, f32::max);
            deepest = deepest.max(inside).max(-corner.y);
        }
    }
    f64::from(deepest)
}

/// The corners of a cube in world space.
fn corners(pose: &Pose) -> impl Iterator<Item = Vec3> {
    let signs = |bits: u32| {
        Vec3::from_array([0, 1, 2].map(|axis| if bits >> axis & 1 == 1 { HALF } else { -HALF }))
    };
    let pose = *pose;
    (0..8).map(move |bits| pose.point(signs(bits)))
}

/// Depth of a point in a cube, metres; negative outside of it.
fn depth(pose: &Pose, point: Vec3) -> f32 {
    let back = Pose { translation: Vec3::ZERO, rotation: Quat::conjugate(pose.rotation) };
    HALF - back.point(point - pose.translation).abs().max_element()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube(translation: Vec3, rotation: Quat, velocity: Vec3) -> Cube {
        Cube { pose: Pose { translation, rotation }, velocity }
    }

    #[test]
    fn a_corner_in_another_box_or_in_the_floor_is_as_deep_as_it_is() {
        let level = |x: f32, y: f32| cube(Vec3::new(x, y, x), Quat::IDENTITY, Vec3::ZERO);
        assert_eq!(deepest(&[level(0.0, 0.5), level(2.0, 0.5)]), 0.0);
        assert!((deepest(&[level(0.0, 0.49)]) - 0.01).abs() < 1e-6);
        // The upper box is offset, so that its corners are inside of the lower one and not at its edge.
        assert!((deepest(&[level(0.0, 0.5), level(0.25, 1.497)]) - 0.003).abs() < 1e-6);
        let tilted = Quat::from_rotation_z(core::f32::consts::FRAC_PI_4);
        let stands = cube(Vec3::Y * 0.7, tilted, Vec3::ZERO);
        assert!((deepest(&[stands]) - f64::from(0.5_f32.sqrt() - 0.7)).abs() < 1e-6);
    }
}
