//! Random colliders, body contacts, body colliders and sleep.

use sinew::glam::{Quat, Vec3};
use sinew::recipes::{BoxSpec, box_3d};
use sinew::{BodyCollider, Simulation, Sleep};
use sinew::{
    BodyContacts, BodySettings, Collider, ContactParticipant, Filter, Frame, Layers, Material,
    Shape, SlideConfig,
};

use crate::input::Input;

const MAX_COLLIDERS: usize = 5;
const MAX_BODIES: usize = 4;
const MAX_BODY_COLLIDERS: usize = 5;

/// One operation. `most` is the maximum number of particles.
pub(crate) fn operate(world: &mut Simulation, input: &mut Input, most: usize) {
    let count = world.particles.len() as u32;
    match input.below(9) {
        0 | 1 => {
            if let Some(shape) = shape(input) {
                let mut collider = Collider::fixed(shape, frame(input));
                if input.rarely(3) {
                    collider = collider.moving_to(frame(input));
                }
                collider.material = material(input);
                collider.layers = layers(input);
                (collider.sensor, collider.events) = (input.rarely(4), input.flag());
                world.colliders.truncate(MAX_COLLIDERS - 1);
                world.colliders.push(collider);
            }
        }
        2 if !world.colliders.is_empty() => {
            let k = input.below(world.colliders.len() as u32) as usize;
            if input.rarely(4) {
                world.colliders.swap_remove(k);
            } else {
                world.colliders[k].start = world.colliders[k].end;
                world.colliders[k].end = frame(input);
            }
        }
        3 => {
            let own = BodyContacts {
                material: material(input),
                layers: layers(input),
                with_bodies: input.flag(),
                with_itself: input.flag(),
                surface: input.flag(),
                events: input.flag(),
                disabled: input.rarely(6),
            };
            world.contacts.truncate(MAX_BODIES - 1);
            world.contacts.push(own);
            // Pairs without contacts; the bodies and colliders may not exist.
            let participants = [0, 1].map(|_| {
                let number = input.below(MAX_BODIES as u32 + 1);
                if input.flag() {
                    ContactParticipant::Body(number)
                } else {
                    ContactParticipant::Collider(number)
                }
            });
            world.ignored.truncate(MAX_BODIES);
            world.ignored.extend(input.rarely(3).then_some(participants));
        }
        4 if count > 0 => {
            let (row, body) = (input.below(count) as usize, input.below(MAX_BODIES as u32));
            world.particles.set_body(row, (!input.rarely(6)).then_some(body));
            if input.flag() {
                world.particles.set_rest(row, Some(input.vector()));
            }
        }
        5 if count as usize + 8 <= most => {
            let size = Vec3::new(input.ordinary(), input.ordinary(), input.ordinary()).abs();
            let spec = BoxSpec { size, mass: input.mostly(Input::positive), ..BoxSpec::default() };
            let contacts = BodyContacts { with_bodies: true, ..Default::default() };
            if let Ok(own) = box_3d(&spec) {
                // A refused blueprint must change nothing.
                let before = (world.particles.len(), world.body_colliders().len());
                if own.build_colliding(world, contacts).is_err() {
                    assert_eq!((world.particles.len(), world.body_colliders().len()), before);
                }
            }
        }
        6 => {
            let number = input.below(5);
            let rows: Vec<u32> = (0..number).map(|_| input.below(count + 1)).collect();
            let rest: Vec<Vec3> = rows.iter().map(|_| input.vector()).collect();
            if let Some(shape) = shape(input) {
                let body_colliders = world.body_colliders_mut();
                body_colliders.truncate(MAX_BODY_COLLIDERS - 1);
                let id = body_colliders.len() as u64;
                body_colliders.push(BodyCollider { rows, rest: rest.into(), shape, id });
            }
        }
        7 => {
            let sleep = Sleep {
                allowed: !input.rarely(4),
                keeps_awake: input.rarely(8),
                speed: input.mostly(|input| input.positive() / 16.0),
                still: input.mostly(|_| 0.4),
                asleep: input.rarely(4),
                support_hash: u64::from(input.below(3)),
            };
            world.sleep.truncate(MAX_BODIES - 1);
            world.sleep.push(sleep);
            world.bodies.resize(MAX_BODIES, BodySettings::default());
        }
        _ => query(world, input),
    }
}

/// Queries change nothing, whatever the arguments, and return valid numbers.
fn query(world: &Simulation, input: &mut Input) {
    let (from, way, most) = (input.vector(), input.vector(), input.any());
    if let Some(hit) = world.cast_ray(from, way, most, &Filter::default()) {
        assert!(hit.distance >= 0.0 && hit.distance <= most, "{hit:?}");
    }
    world.nearest_particle(from, most, &Filter::default());
    if let Some(shape) = shape(input) {
        let (place, all) = (frame(input), Filter::default());
        if let Some(hit) = world.cast_shape(&shape, &place, way, most, &all) {
            assert!(hit.distance >= 0.0 && hit.distance <= most, "{hit:?}");
        }
        let out = world.move_and_slide(&shape, &place, way, most, &SlideConfig::default(), &all);
        let left = out.velocity.length();
        assert!(left <= 1.001 * way.length() || !way.is_finite(), "{out:?}");
        assert!(out.translation.is_finite() || !place.translation.is_finite(), "{out:?}");
    }
}

fn shape(input: &mut Input) -> Option<Shape> {
    let size = |input: &mut Input| input.mostly(Input::positive);
    let shape = match input.below(8) {
        0 => Ok(Shape::half_space()),
        1 => Shape::sphere(size(input)),
        2 => Shape::capsule(size(input), size(input)),
        3 => Shape::cuboid(Vec3::new(size(input), size(input), size(input))),
        4 => Shape::cylinder(size(input), size(input)),
        5 => {
            let points: Vec<Vec3> = (0..4 + input.below(4)).map(|_| input.vector()).collect();
            Shape::hull(&points)
        }
        6 => {
            let vertices: Vec<Vec3> = (0..3 + input.below(4)).map(|_| input.vector()).collect();
            let corner = |input: &mut Input| input.below(vertices.len() as u32 + 1);
            let triangles = (0..1 + input.below(4))
                .map(|_| [corner(input), corner(input), corner(input)])
                .collect();
            Shape::mesh(vertices.clone(), triangles)
        }
        _ => {
            let (sphere, by) = (Shape::sphere(1.0), input.vector());
            sphere.and_then(|sphere| sphere.scaled(by))
        }
    };
    shape.ok()
}

fn frame(input: &mut Input) -> Frame {
    let turn = input.vector();
    let q = Quat::from_xyzw(turn.x, turn.y, turn.z, input.mostly(|_| 1.0));
    let q = if input.rarely(8) { q } else { q.try_normalize().unwrap_or(Quat::IDENTITY) };
    Frame::new(input.vector(), q)
}

trait TryNormalize: Sized {
    fn try_normalize(self) -> Option<Self>;
}

impl TryNormalize for Quat {
    fn try_normalize(self) -> Option<Self> {
        let length = self.length();
        (length.is_finite() && length > 0.0).then(|| self / length)
    }
}

fn material(input: &mut Input) -> Material {
    Material::default()
        .with_friction(input.mostly(Input::positive))
        .with_restitution(input.mostly(|input| input.positive() / 8.0))
}

fn layers(input: &mut Input) -> Layers {
    if input.rarely(4) { Layers::new(input.bits(), input.bits()) } else { Layers::default() }
}
