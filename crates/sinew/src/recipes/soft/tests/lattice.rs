//! A lattice of tetrahedra has no gaps, has the specified stiffness at any resolution, and recovers its shape after a fall.

use super::*;
use crate::BodySettings;

fn boxed(size: Vec3, cells: [u32; 3]) -> SoftLatticeSpec {
    let shape = SoftShape::Box { size, cells: UVec3::from_array(cells) };
    SoftLatticeSpec { shape, ..SoftLatticeSpec::default() }
}

fn tetrahedra(world: &Simulation) -> impl Iterator<Item = (f32, f32)> {
    world.constraints().iter().filter_map(|c| {
        let ConstraintKind::Tetrahedron(kind) = &c.kind else { return None };
        let at = |k: usize| world.particles.position(c.rows[k] as usize);
        let now = constraints::Tetrahedron::of([at(0), at(1), at(2), at(3)]).rest;
        Some((now, kind.rest))
    })
}

#[test]
fn cells_fill_the_shape_without_gaps_and_the_surface_is_closed() {
    let ball = SoftShape::Ball { radius: 0.7, cells: 7 };
    let cases = [
        (boxed(Vec3::new(1.0, 2.0, 0.5), [3, 4, 2]), 60, 120, 6.0_f64.recip() * 6.0),
        // 20 sectors of 4³ tetrahedra; shells of 10 k² + 2 particles. The volume is slightly less than that of the ball.
        (SoftLatticeSpec { shape: ball, ..SoftLatticeSpec::default() }, 309, 1280, 1.405),
    ];
    for (spec, particles, cells, volume) in cases {
        let body = soft_lattice(&spec).unwrap();
        assert_at_rest(&body);
        assert_eq!((body.particles.len(), body.constraints.len()), (particles, cells));
        assert!((body.total_mass() - 100.0).abs() < 1e-3);
        let mut world = Simulation::default();
        body.build(&mut world).unwrap();
        let sum: f64 = tetrahedra(&world).map(|(v, _)| f64::from(v)).sum();
        let least = tetrahedra(&world).map(|(v, _)| v).fold(f32::MAX, f32::min);
        let inside = volume_of(&body, &world);
        println!(
            "{sum:.4} m³ of cells, {inside:.4} m³ within the surface; the least cell {least:.1e}"
        );
        assert!((sum / inside - 1.0).abs() < 1e-5 && least > 0.0, "{sum} {inside} {least}");
        assert!((sum / volume - 1.0).abs() < 0.02, "{sum}");
        let mesh = soft_lattice_mesh(&spec).unwrap();
        assert_eq!(mesh.vertices, body.vertices);
        let triangles: Vec<[u32; 3]> =
            mesh.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
        let drawn = MassProperties::of_mesh(&mesh.positions, &triangles).unwrap();
        assert!((drawn.volume / inside - 1.0).abs() < 1e-5, "closed, and outward");
    }
}

/// Deflection of the end of a bar under a force, metres, with its other end pinned, after oscillations have been damped away.
fn gives_way(cells: [u32; 3], force: Vec3) -> Vec3 {
    let bar = SoftLatticeSpec {
        bulk: Bulk::Density(100.0),
        stiffness: 1e5,
        poisson: 0.3,
        damping: 0.05,
        drag: 0.99,
        ..boxed(Vec3::new(1.5, 0.5, 0.5), cells)
    };
    let mut body = soft_lattice(&bar).unwrap();
    let at_end = |p: &ParticleSeed, x: f32| (p.position.x - x).abs() < 1e-4;
    let held: Vec<u32> =
        (0..).zip(&body.particles).filter(|(_, p)| at_end(p, -0.75)).map(|(i, _)| i).collect();
    let pulled: Vec<usize> =
        (0..).zip(&body.particles).filter(|(_, p)| at_end(p, 0.75)).map(|(i, _)| i).collect();
    let mass: f32 = pulled.iter().map(|&i| body.particles[i].mass).sum();
    let share: Vec<Vec3> =
        pulled.iter().map(|&i| force * (body.particles[i].mass / mass)).collect();
    held.iter().for_each(|&i| body.pin(i).unwrap());
    let mut world = floating(&body);
    world.settings.substeps = 20;
    for (&i, &force) in pulled.iter().zip(&share) {
        world.particles.set_external_force(i, force);
    }
    for _ in 0..120 {
        world.step(1.0 / 60.0).unwrap();
    }
    let moved = |&i: &usize| world.particles.position(i) - body.particles[i].position;
    pulled.iter().map(moved).sum::<Vec3>() / pulled.len() as f32
}

#[test]
fn a_bar_gives_way_alike_however_fine_it_is_cut() {
    // F L / (E A) of a thin bar: 1 %. The pinned end cannot narrow, which stiffens it a little.
    let pull = Vec3::X * 250.0;
    let [coarse, fine] = [[6, 2, 2], [12, 4, 4]].map(|cells| gives_way(cells, pull).x);
    println!("pulled: {coarse:.5} m coarse, {fine:.5} m fine; a thin bar {:.5} m", 0.015);
    assert!((fine / 0.015 - 1.0).abs() < 0.05, "{fine}");
    assert!((coarse / fine - 1.0).abs() < 0.05, "{coarse} {fine}");
    // F L³ / (3 E I) with I = h⁴/12, and F L / (5/6 G A) for the shear.
    let load = Vec3::NEG_Y * 10.0;
    let bent =
        10.0 * 3.375 / (3.0 * 1e5 * 0.0625 / 12.0) + 10.0 * 1.5 / (5.0 / 6.0 * 1e5 / 2.6 * 0.25);
    let [coarse, middle, fine] =
        [[9, 3, 3], [12, 4, 4], [18, 6, 6]].map(|cells| -gives_way(cells, load).y);
    println!(
        "bent: {coarse:.5} m at 3 cells across, {middle:.5} m at 4, {fine:.5} m at 6; a thin bar {bent:.5} m"
    );
    assert!((middle / fine - 1.0).abs() < 0.1, "{middle} {fine}");
    assert!((fine / bent - 1.0).abs() < 0.1, "{fine}");
}

/// Jelly gets a single sweep in a substep where that gives the same motion as many. With another stiffness, and in longer substeps, it gets the world's number.
#[test]
fn jelly_hangs_as_far_as_by_many_sweeps_whatever_the_substeps() {
    for (substeps, stiffness, once) in [
        (4, 2e4, false),
        (8, 2e4, true),
        (10, 2e4, true),
        (10, 8e4, false),
        (40, 2e4, true),
        (40, 8e4, true),
        (4, 3e3, true),
    ] {
        let jelly = SoftLatticeSpec { drag: 0.99, stiffness, ..SoftLatticeSpec::default() };
        let hangs = |sweeps: Option<u32>| {
            let mut body = soft_lattice(&jelly).unwrap();
            if sweeps.is_some() {
                body.settings = BodySettings { max_sweeps: sweeps, ..BodySettings::default() };
            }
            let top = |p: &ParticleSeed| p.position.y > 0.49;
            let held: Vec<u32> =
                (0..).zip(&body.particles).filter(|(_, p)| top(p)).map(|(i, _)| i).collect();
            held.iter().for_each(|&i| body.pin(i).unwrap());
            let mut world = Simulation::default();
            (world.settings.substeps, world.settings.tolerance) = (substeps, 0.0);
            body.build(&mut world).unwrap();
            run(&mut world, 0..180);
            (height_of(&world) - 1.0, world.report().most_sweeps)
        };
        let [(own, sweeps), (many, _)] = [None, Some(20)].map(hangs);
        println!("{substeps} substeps, {stiffness} Pa: {own:.5} m by {sweeps}, {many:.5} by 20");
        assert_eq!(sweeps, if once { 1 } else { 4 }, "{substeps} substeps, {stiffness} Pa");
        assert!((own / many - 1.0).abs() < 0.035, "{substeps}, {stiffness}: {own} {many}");
    }
}

#[test]
fn a_cube_of_jelly_falls_and_is_whole_again() {
    let body = soft_lattice(&SoftLatticeSpec::default()).unwrap();
    let mut world = Simulation::default();
    world.boundaries.planes.push(Plane::ground(-1.5));
    let turn = glam::Quat::from_xyzw(0.3, 0.1, -0.2, 0.9);
    body.transformed(turn, Vec3::ZERO).build(&mut world).unwrap();
    let full = volume_of(&body, &world);
    let mut lowest = 1.0_f64;
    for _ in 0..600 {
        let report = world.step(1.0 / 60.0).unwrap();
        assert!(report.frozen.is_empty());
        lowest = lowest.min(volume_of(&body, &world) / full);
    }
    let inverted = tetrahedra(&world).filter(|(now, _)| *now <= 0.0).count();
    let worst = tetrahedra(&world).map(|(now, rest)| (now / rest - 1.0).abs()).fold(0.0, f32::max);
    let off = volume_of(&body, &world) / full - 1.0;
    println!(
        "volume off by {off:.4} at the end, {lowest:.3} at the least; {inverted} inverted, the worst cell off by {worst:.3}"
    );
    assert_eq!(inverted, 0);
    assert!(off.abs() < 0.02, "{off}");
    let ledger = world.ledger();
    assert!(ledger.kinetic < 1.0, "it lies: {ledger:?}");
}

#[test]
fn a_lattice_squeezed_flat_and_turned_inside_out_comes_back() {
    let ball = SoftShape::Ball { radius: 0.5, cells: 4 };
    for spec in
        [boxed(Vec3::ONE, [2, 2, 2]), SoftLatticeSpec { shape: ball, ..SoftLatticeSpec::default() }]
    {
        let body = soft_lattice(&spec).unwrap();
        let mut world = floating(&body);
        for i in 0..world.particles.len() {
            let p = world.particles.position(i);
            world.particles.set_position(i, p * Vec3::new(1.3, 0.0, 1.3));
        }
        run(&mut world, 0..300);
        let inverted = tetrahedra(&world).filter(|(now, _)| *now <= 0.0).count();
        println!("{inverted} of {} stay inverted", body.constraints.len());
        assert_eq!(inverted, 0);
        assert!((0..world.particles.len()).all(|i| world.particles.position(i).is_finite()));
    }
}
