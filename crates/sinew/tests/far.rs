//! Far from the origin, where two adjacent `f32` are half a millimetre apart.

use sinew::glam::Vec3;
use sinew::{Distance, ParticleSeed, Pin, Simulation};

#[test]
fn what_hangs_on_a_moving_pin_is_pulled_evenly_five_kilometres_out_too() {
    let scene = |offset: Vec3| {
        let mut world = Simulation::default();
        world.settings.substeps = 64;
        world.particles.push(ParticleSeed::at(offset).pinned()).unwrap();
        world.particles.push(ParticleSeed::at(offset - Vec3::Y)).unwrap();
        world.distances_mut().push(Distance::new(0, 1, 1.0));
        for tick in 1..=64 {
            // 1/64 m a tick, which f32 can represent at that distance; a sixty-fourth of that it cannot.
            let target = offset + Vec3::X * (tick as f32 / 64.0);
            world.boundaries.pins = vec![Pin { particle: 0, target }];
            world.step(1.0 / 60.0).unwrap();
            assert_eq!(world.particles.position(0), target);
        }
        (world.particles.relative_to(1, offset), world.particles.velocity(1))
    };
    assert_eq!(scene(Vec3::new(5000.0, 3000.0, -4000.0)), scene(Vec3::ZERO));
}
