//! Self-collision of cloth.

use glam::Vec3;

use super::{World, self_colliding};
use crate::particles::ParticleSeed;

const DT: f32 = 1.0 / 60.0;
const SIDE: usize = 64;
const SPACING: f32 = 0.01;

/// A sheet of 64 × 64 particles folded in the middle, the upper half `gap` above the lower one and moving down at `speed`, m/s.
fn folded(radius: f32, gap: f32, speed: f32) -> World {
    let mut world = World {
        contacts: vec![self_colliding(0.3, 0.0)],
        gravity: Vec3::Y * -9.81,
        room: Some((Vec3::new(-5.0, 0.0, -5.0), Vec3::splat(5.0), 0.5)),
        ..Default::default()
    };
    for i in 0..SIDE * SIDE {
        let (column, row) = ((i % SIDE) as f32, i / SIDE);
        let half = SIDE / 2;
        // The fold runs along z. Its arc is left out; the rods close it.
        let upper = row >= half;
        let along = if upper { SIDE - 1 - row } else { row } as f32 - half as f32;
        // Shifted by half a cell, so that particles face gaps, which is the worst case.
        let askew = if upper { Vec3::new(0.45, 0.0, 0.0) } else { Vec3::ZERO };
        let at = (Vec3::new(column, 0.0, along) + askew) * SPACING;
        let height = if upper { radius + gap } else { radius };
        let velocity = if upper { Vec3::NEG_Y * speed } else { Vec3::ZERO };
        let seed = ParticleSeed::at(at + Vec3::Y * height).with_radius(radius);
        world.push(seed.with_mass(2e-5).with_velocity(velocity), 0);
        world.rest.push(Vec3::new(column, 0.0, row as f32) * SPACING);
    }
    for i in 0..SIDE * SIDE {
        let (column, row) = (i % SIDE, i / SIDE);
        for (dx, dy) in [(1, 0), (0, 1), (1, 1), (-1_isize, 1)] {
            let Some(x) = column.checked_add_signed(dx).filter(|x| *x < SIDE) else { continue };
            let y = row + dy;
            if y < SIDE {
                let length = (world.rest[i] - world.rest[y * SIDE + x]).length();
                world.rods.push((i as u32, (y * SIDE + x) as u32, length));
            }
        }
    }
    world
}

/// The least distance of two particles that are not neighbours, as a share of the thickness and at most two, and how many particles of the upper half are below
/// the lower half.
fn layers(world: &World, radius: f32) -> (f32, usize) {
    // Only pairs within two thicknesses matter; sorted along x, those are few.
    let reach = 4.0 * radius;
    let mut along: Vec<_> = (0..SIDE * SIDE).map(|i| (world.particles.position(i), i)).collect();
    along.sort_by(|one, other| one.0.x.total_cmp(&other.0.x));
    let mut least = reach;
    // For each particle, the lateral distance to the nearest one of the lower half, and how far it is below it.
    let mut under = vec![(f32::MAX, 0.0); SIDE * SIDE];
    let is_upper = |i: usize| i / SIDE >= SIDE / 2;
    for (n, &(p, i)) in along.iter().enumerate() {
        for &(q, j) in along[n + 1..].iter().take_while(|(q, _)| q.x - p.x < reach) {
            if (world.rest[i] - world.rest[j]).length() < 2.5 * SPACING {
                continue;
            }
            let d = p - q;
            least = least.min(d.length());
            if is_upper(i) != is_upper(j) {
                let (above, height) = if is_upper(i) { (i, d.y) } else { (j, -d.y) };
                let flat = Vec3::new(d.x, 0.0, d.z).length();
                if flat < under[above].0 {
                    under[above] = (flat, height);
                }
            }
        }
    }
    let is_swapped = |&&(flat, height): &&(f32, f32)| flat < 0.75 * SPACING && height < 0.0;
    (least / (2.0 * radius), under.iter().filter(is_swapped).count())
}

#[test]
fn a_folded_sheet_keeps_its_layers_apart() {
    let radius = 0.49 * SPACING;
    for speed in [0.0, 3.0, 30.0] {
        let mut world = folded(radius, 0.05, speed);
        let mut worst = (f32::MAX, 0);
        for step in 0..90 {
            world.step(DT);
            if step % 3 == 0 {
                let (least, swapped) = layers(&world, radius);
                worst = (worst.0.min(least), worst.1.max(swapped));
            }
        }
        let last = layers(&world, radius);
        println!(
            "{speed} m/s: never below {:.3} of the thickness, at rest {:.3}; {} swapped at worst, {} at rest",
            worst.0, last.0, worst.1, last.1
        );
        assert!(last.0 > 0.9, "{last:?}");
        assert_eq!(last.1, 0);
    }
}
