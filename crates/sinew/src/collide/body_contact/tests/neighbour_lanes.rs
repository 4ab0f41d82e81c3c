//! Results do not depend on the neighbour lanes: no bit of a body collider depends on others that it does not touch.

use super::*;

/// Boxes that fall onto each other, some with a push into their neighbour, and balls of three particles that roll; between them in the order of creation, as
/// many `others` far away, at rest. All lengths are multiplied by `size`: small ones take more contact sweeps.
fn heap(others: usize, size: f32) -> (Simulation, Vec<usize>) {
    let mut world = world();
    floor(&mut world, rough(0.5));
    let mut own = Vec::new();
    let mut lain = 0;
    for k in 0..24 {
        for _ in 0..others * (k % 3) {
            let at = Vec3::new(300.0 + 3.0 * lain as f32, 0.5, -200.0) * size;
            add_box(&mut world, Vec3::splat(size), 1.0, at, Quat::IDENTITY);
            lain += 1;
        }
        // Every fifth begins inside its neighbour, and is pushed out of it.
        let apart = if k % 5 == 4 { 0.7 } else { 1.15 };
        let at =
            Vec3::new(0.4 * (k % 3) as f32, 0.7 + apart * (k / 2) as f32, 0.9 * (k % 2) as f32);
        let turned = turn(Vec3::new(1.0, 0.3 * k as f32, 0.5), 0.4 * k as f32);
        own.push(add_box(&mut world, Vec3::splat(size), 1.0, at * size, turned));
    }
    (world, own)
}

#[test]
fn neighbour_lanes_do_not_change_a_body_collider() {
    for size in [1.0, 0.05, 0.03, 0.01] {
        let ((mut alone, first), (mut among, second)) = (heap(0, size), heap(1, size));
        for tick in 0..180 {
            step(&mut alone, 1.0 / 60.0);
            step(&mut among, 1.0 / 60.0);
            assert!(bits(&alone, &first) == bits(&among, &second), "{size} m, tick {tick}");
        }
        assert!(alone.contact_cache.len() > 20 && speed(&alone) > 0.0);
    }
}

#[test]
fn missed_pairs_far_away_do_not_change_a_body_collider() {
    let ((mut alone, first), (mut among, second)) = (heap(0, 1.0), heap(0, 1.0));
    // One after the other hits a box that lies there.
    for k in 0..8 {
        let at = Vec3::new(300.0, 0.5, 10.0 * k as f32);
        add_box(&mut among, Vec3::ONE, 1.0, at, Quat::IDENTITY);
        let from = at + Vec3::new(-2.0 - 3.0 * k as f32, 0.3 + 0.2 * k as f32, 0.1);
        let thrown = add_box(&mut among, Vec3::ONE, 1.0, from, Quat::IDENTITY);
        throw(&mut among, thrown, Vec3::new(20.0, 0.0, 0.0), Vec3::Z);
    }
    for tick in 0..120 {
        step(&mut alone, 1.0 / 60.0);
        step(&mut among, 1.0 / 60.0);
        assert!(bits(&alone, &first) == bits(&among, &second), "tick {tick}");
    }
    assert!(speed(&alone) > 0.0);
}

fn bits(world: &Simulation, rows: &[usize]) -> Vec<[u32; 3]> {
    let rows = rows.iter().flat_map(|&first| first..first + 8);
    rows.map(|i| world.particles.position(i).to_array().map(f32::to_bits)).collect()
}
