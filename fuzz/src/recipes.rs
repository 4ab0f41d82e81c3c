//! Specs of boxes, ropes, cloth and ragdolls: refused, or a valid blueprint that can be stepped.

use sinew::glam::{Quat, Vec3};
use sinew::recipes::{Blueprint, BoxLayout, BoxSpec, ClothMaterial, ClothSpec, RagdollSpec};
use sinew::recipes::{RopeSpec, box_2d, box_3d, cloth_grid, grid_uvs, ragdoll, rope};
use sinew::{Bound, Plane, Simulation};

use crate::input::Input;

/// Larger bodies are valid, but a waste of the fuzzer's time.
const MAX_PARTICLES: u64 = 2000;

/// Builds a body from a random spec. Panics if a recipe breaks a guarantee.
pub fn recipes(data: &[u8]) {
    let mut input = Input::new(data);
    let (mass, body) = match input.below(5) {
        0 => {
            let spec = box_spec(&mut input);
            (Some(spec.mass), box_3d(&spec).ok())
        }
        1 => {
            let spec = box_spec(&mut input);
            (Some(spec.mass), box_2d(&spec).ok())
        }
        2 => {
            let spec = rope_spec(&mut input);
            let free = !spec.pin_start && !spec.pin_end;
            (free.then_some(spec.mass), rope(&spec).ok())
        }
        3 => {
            let spec = cloth_spec(&mut input);
            let body = cloth_grid(&spec).ok();
            if let Some(body) = &body {
                let coordinates = grid_uvs(&spec).expect("a spec was taken once and refused once");
                assert_eq!(coordinates.len(), body.particles.len());
            }
            (body.is_some().then_some(spec.material.density * spec.width * spec.height), body)
        }
        _ => {
            let spec = RagdollSpec {
                height: input.mostly(Input::positive),
                mass: input.mostly(mass),
                damping: input.mostly(Input::positive),
            };
            (Some(spec.mass), ragdoll(&spec).ok())
        }
    };
    if let Some(body) = body {
        check(&body, mass, &mut input);
    }
}

/// Checks that a blueprint returned by a recipe is valid, has the requested mass, and can be rotated, built and stepped.
fn check(body: &Blueprint, mass: Option<f32>, input: &mut Input) {
    assert_eq!(body.validate(), Ok(()));
    assert!(!body.particles.is_empty());
    assert!(body.distances.iter().all(|d| d.rest > 0.0), "a rod without a length");
    if let Some(mass) = mass {
        let error = (body.total_mass() - mass).abs();
        assert!(error <= 1e-3 * mass, "{} instead of {mass} kg", body.total_mass());
    }
    let rotation = Quat::from_xyzw(input.any(), input.any(), input.any(), input.any());
    let placed = body.transformed(rotation, input.vector());
    let sound = placed.validate();
    let mut world = Simulation::default();
    world.boundaries.planes.push(Plane::ground(0.0));
    match placed.build(&mut world) {
        Ok(rows) => assert_eq!(rows, 0..body.particles.len()),
        Err(fault) => {
            assert_eq!(sound, Err(fault));
            assert!(world.particles.is_empty() && world.distances().is_empty());
        }
    }
    // Few substeps: this tests the body, not the solver.
    world.settings.substeps = 2;
    world.step(1.0 / 60.0).expect("a step of 1/60 s was refused");
    assert!((0..world.particles.len()).all(|i| world.particles.is_finite(i)));
}

fn mass(input: &mut Input) -> f32 {
    input.positive()
}

fn size(input: &mut Input) -> Vec3 {
    Vec3::from_array([(); 3].map(|()| input.mostly(Input::positive)))
}

fn share(input: &mut Input) -> f32 {
    input.positive() / 64.0
}

fn box_spec(input: &mut Input) -> BoxSpec {
    BoxSpec {
        size: size(input),
        mass: input.mostly(mass),
        layout: if input.flag() { BoxLayout::Corners } else { BoxLayout::Equimomental },
        radius: input.mostly(|input| input.ordinary().max(0.0)),
        drag: input.mostly(share),
    }
}

fn rope_spec(input: &mut Input) -> RopeSpec {
    RopeSpec {
        from: input.vector(),
        to: input.vector(),
        segments: few(input, 1),
        mass: input.mostly(mass),
        radius: input.mostly(share),
        slack: input.mostly(|input| if input.flag() { 0.0 } else { input.positive() }),
        bound: [Bound::Equal, Bound::AtMost, Bound::AtLeast][input.below(3) as usize],
        compliance: input.mostly(|_| 0.0),
        drag: input.mostly(share),
        pin_start: input.flag(),
        pin_end: input.flag(),
    }
}

fn cloth_spec(input: &mut Input) -> ClothSpec {
    let columns = few(input, 1);
    ClothSpec {
        width: input.mostly(Input::positive),
        height: input.mostly(Input::positive),
        columns,
        rows: few(input, u64::from(columns) + 1),
        shear: input.flag(),
        material: ClothMaterial {
            density: input.mostly(Input::positive),
            stretch_compliance: input.mostly(|_| 0.0),
            bend_compliance: if input.flag() { Some(input.mostly(|_| 1.0)) } else { None },
            radius: input.mostly(share),
            drag: input.mostly(share),
            weld_tolerance: input.mostly(|_| 1e-5),
        },
    }
}

/// A number of cells, such that `(cells + 1) · others` particles are either few, or too many for any recipe.
fn few(input: &mut Input, others: u64) -> u32 {
    let cells = if input.rarely(16) { input.bits() } else { input.below(24) };
    let particles = (u64::from(cells) + 1).saturating_mul(others);
    if (MAX_PARTICLES..=1 << 24).contains(&particles) { 3 } else { cells }
}
