//! Weight of kinematic objects: no force moves a collider, but it can press on what it stands on.
//!
//! It stands on what lies directly below it, within reach. Several points of contact share the weight like equal springs under a stiff plate: each gets `1/N +
//! λ·(x - x̄)`, with the `λ` that puts the resultant under the collider's centre, and none a negative share. The share of static geometry is dropped; on a body
//! the share is a force at a point, on single particles a force on each.

use glam::{Mat3, Vec3};

use super::{Filter, Simulation};
use crate::collide::{
    AtStart, ContactParticipant, Frame, ManifoldScratch, Obstacle, Shape, SweepMotion, collide,
};
use crate::forces::Control;

/// A point of support.
struct Support {
    point: Vec3,
    /// Distance below the shape, metres.
    gap: f32,
    on: Carrier,
}

/// What carries a share of the weight.
enum Carrier {
    /// Static geometry.
    Fixed,
    /// Particles: up to three rows, each with its fraction of the share.
    Rows([(u32, f32); 3]),
    /// A body collider, given by its first row.
    Body(u32),
}

/// Points that lie this much lower than the highest one carry nothing, metres.
const UNEVEN: f32 = 0.02;

impl Simulation {
    /// Makes a collider press on what it stands on, within `reach` metres below it, with the weight of `mass` kg in the world's gravity. The force is added to
    /// [controls](crate::Forces::controls) without a name, which the caller removes again. Without gravity, without support, or with arguments that are not
    /// finite and positive, nothing happens.
    pub fn press(&mut self, collider: u32, mass: f32, reach: f32) {
        let weight = self.forces.gravity * mass;
        let Some(own) = self.colliders.get(collider as usize).filter(|own| own.is_valid()) else {
            return;
        };
        let Some(down) = weight.try_normalize().filter(|_| mass > 0.0 && reach > 0.0) else {
            return;
        };
        let filter = Filter {
            layers: own.layers,
            except: Some(ContactParticipant::Collider(collider)),
            ..Filter::default()
        };
        let (shape, frame) = (own.shape.clone(), own.end);
        let supports = self.supports(&shape, &frame, down, reach, &filter);
        let points: Vec<Vec3> = supports.iter().map(|support| support.point).collect();
        let shares = shares(&points, frame.translation, down);
        let mut forces: Vec<(u32, f32)> = Vec::new();
        let mut bodies: Vec<(u32, f32, Vec3)> = Vec::new();
        for (support, share) in supports.iter().zip(shares) {
            match support.on {
                Carrier::Fixed => {}
                Carrier::Rows(rows) => forces.extend(rows.map(|(row, part)| (row, part * share))),
                Carrier::Body(row) => match bodies.iter_mut().find(|body| body.0 == row) {
                    Some(body) => {
                        body.1 += share;
                        body.2 += support.point * share;
                    }
                    None => bodies.push((row, share, support.point * share)),
                },
            }
        }
        let controls = &mut self.forces.controls;
        let pressing = forces.into_iter().filter(|&(_, share)| share > 0.0);
        controls.extend(pressing.map(|(row, share)| Control::force("", [row], weight * share)));
        for (row, share, moment) in bodies.into_iter().filter(|body| body.1 > 0.0) {
            let solid = self.body_colliders.iter().find(|solid| solid.rows.first() == Some(&row));
            let rows = solid.map_or_else(|| vec![row], |solid| solid.rows.clone());
            controls.push(Control::force("", rows, weight * share).at(moment / share));
        }
    }

    /// The points at which a shape is supported.
    fn supports(
        &self,
        shape: &Shape,
        frame: &Frame,
        down: Vec3,
        reach: f32,
        filter: &Filter,
    ) -> Vec<Support> {
        let mut found: Vec<Support> = Vec::new();
        let (low, high) = shape.bounds_in(frame);
        let around = (low - reach, high + reach);
        let mut scratch = ManifoldScratch::default();
        self.obstacles(around, filter, &mut |participant, row, obstacle| {
            // Only contacts from above: contacts at the side carry nothing.
            let holds = |normal: Vec3| normal.dot(down) < -0.3;
            if let Obstacle::Shape(other, at) = obstacle {
                let seen = frame.from_within(at);
                let fixed = matches!(participant, ContactParticipant::Collider(_));
                collide(shape, other, &seen, reach, &mut scratch, &mut |manifold| {
                    if !holds(at.turn(manifold.normal)) {
                        return;
                    }
                    found.extend(manifold.points().iter().map(|point| Support {
                        point: at.point(point.on_b),
                        gap: point.distance,
                        on: match row {
                            Some(row) if !fixed => Carrier::Body(row),
                            _ => Carrier::Fixed,
                        },
                    }));
                });
                return;
            }
            let Some(near) = shape.nearest_contact(frame, reach, obstacle) else { return };
            let (point, normal) = (near.point.as_vec3(), near.normal.as_vec3());
            let (Some(row), true) = (row, holds(normal)) else { return };
            let rows = match obstacle {
                Obstacle::Triangle(corners) => self.corner_shares(row, corners, point),
                _ => Some([(row, 1.0), (row, 0.0), (row, 0.0)]),
            };
            if let Some(rows) = rows {
                found.push(Support { point, gap: near.distance, on: Carrier::Rows(rows) });
            }
        });
        // The smallest gap is the height of the fall onto each support.
        let least = found.iter().map(|support| support.gap).fold(f32::INFINITY, f32::min);
        let start = AtStart::Overlapped;
        let falls =
            SweepMotion { direction: down, length: reach, clearance: 0.0, start, along: &[] };
        if found.is_empty() || self.sweep(shape, frame, &falls, filter).is_none() {
            return Vec::new();
        }
        found.retain(|support| support.gap <= least + UNEVEN);
        found
    }

    /// The rows of the triangle whose first row is given, with the barycentric weight of each at a point on it.
    fn corner_shares(
        &self,
        first: u32,
        corners: &[Vec3; 3],
        point: Vec3,
    ) -> Option<[(u32, f32); 3]> {
        let matches = |rows: &&[u32; 3]| {
            let same = |(row, corner): (&u32, &Vec3)| {
                self.particles.body.get(*row as usize).is_some()
                    && self.particles.position(*row as usize) == *corner
            };
            rows[0] == first && rows.iter().zip(corners).all(same)
        };
        let rows = self.forces.surfaces.iter().find(matches)?;
        let [a, b, c] = *corners;
        let across = (b - a).cross(c - a);
        let area = across.length_squared();
        let of =
            |p: Vec3, q: Vec3| ((p - point).cross(q - point).dot(across) / area).clamp(0.0, 1.0);
        let parts = [of(b, c), of(c, a), of(a, b)];
        let sum: f32 = parts.iter().sum();
        (area > 0.0 && sum > 0.0).then(|| core::array::from_fn(|i| (rows[i], parts[i] / sum)))
    }
}

/// Shares of a weight that acts at `middle`, above the points.
fn shares(points: &[Vec3], middle: Vec3, down: Vec3) -> Vec<f32> {
    let mut carries = vec![true; points.len()];
    let mut shares = vec![0.0; points.len()];
    // Each round removes a point that would have to pull; at the latest three points, or one, are left without one.
    for _ in 0..points.len() {
        let list = || points.iter().enumerate().filter(|(i, _)| carries[*i]).map(|(i, p)| (i, *p));
        let count = list().count() as f32;
        if count == 0.0 {
            break;
        }
        let level = |v: Vec3| v - down * v.dot(down);
        let centre = list().map(|(_, p)| p).sum::<Vec3>() / count;
        let mut spread = Mat3::ZERO;
        for (_, p) in list() {
            let arm = level(p - centre);
            spread += Mat3::from_cols(arm * arm.x, arm * arm.y, arm * arm.z);
        }
        // Regularised along gravity, and for collinear or coincident points.
        let size = spread.x_axis.x + spread.y_axis.y + spread.z_axis.z;
        let regular = |v: Vec3| Mat3::from_cols(v * v.x, v * v.y, v * v.z);
        spread += regular(down) * size.max(1e-12) + Mat3::IDENTITY * (1e-4 * size).max(1e-12);
        let tilt = spread.inverse() * level(middle - centre);
        let mut pulls = false;
        shares.fill(0.0);
        for (i, p) in list() {
            shares[i] = 1.0 / count + tilt.dot(level(p - centre));
            pulls |= shares[i] < 0.0;
        }
        if !pulls {
            break;
        }
        let least = list().map(|(i, _)| shares[i]).fold(f32::INFINITY, f32::min);
        let worst = list().map(|(i, _)| i).find(|&i| shares[i] == least);
        if let Some(worst) = worst.filter(|_| count > 1.0) {
            carries[worst] = false;
        }
    }
    let sum: f32 = shares.iter().map(|share: &f32| share.max(0.0)).sum();
    shares.iter().map(|share| if sum > 0.0 { share.max(0.0) / sum } else { 0.0 }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collide::Collider;
    use crate::recipes::{BoxSpec, ClothSpec, box_3d, cloth_grid};

    #[test]
    fn points_share_a_weight_so_that_it_rests_under_its_middle() {
        let square = [Vec3::new(-1.0, 0.0, -1.0), Vec3::new(1.0, 0.0, -1.0)];
        let square = [square[0], square[1], Vec3::new(1.0, 0.0, 1.0), Vec3::new(-1.0, 0.0, 1.0)];
        for at in [Vec3::Y, Vec3::new(0.5, 2.0, 0.0), Vec3::new(0.3, 1.0, -0.6)] {
            let shares = shares(&square, at, Vec3::NEG_Y);
            assert!(
                (shares.iter().sum::<f32>() - 1.0).abs() < 1e-6 && shares.iter().all(|s| *s >= 0.0)
            );
            let rests: Vec3 = square.iter().zip(&shares).map(|(p, s)| *p * *s).sum();
            assert!((rests - at.with_y(0.0)).length() < 2e-3, "{at} {rests}");
        }
        assert_eq!(shares(&square[..1], Vec3::X, Vec3::NEG_Y), [1.0]);
        let edge = shares(&square, Vec3::new(5.0, 1.0, 0.0), Vec3::NEG_Y);
        assert!(
            (edge[1] + edge[2] - 1.0).abs() < 1e-3,
            "beyond them: the near side carries it {edge:?}"
        );
        assert!(shares(&[], Vec3::ZERO, Vec3::NEG_Y).is_empty());
    }

    /// The forces by which a collider of this shape and mass presses.
    fn pressed(world: &mut Simulation, shape: Shape, at: Vec3, mass: f32) -> Vec<Control> {
        world.colliders.push(Collider::fixed(shape, Frame::at(at)));
        world.press(world.colliders.len() as u32 - 1, mass, 0.05);
        core::mem::take(&mut world.forces.controls)
    }

    #[test]
    fn it_presses_on_a_body_below_it_and_not_on_one_beside_it_or_farther_down() {
        let mut world = Simulation::default();
        let cube = box_3d(&BoxSpec::default()).unwrap();
        let rows = cube.build_colliding(&mut world, Default::default()).unwrap();
        world.begin_step(0.01).unwrap();
        let foot = Shape::sphere(0.2).unwrap();
        let found = pressed(&mut world, foot.clone(), Vec3::new(0.3, 0.71, 0.0), 80.0);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].rows.len(), rows.len());
        assert!((found[0].force - Vec3::NEG_Y * 80.0 * 9.81).length() < 1e-2, "{found:?}");
        let point = found[0].point.unwrap();
        assert!((point - Vec3::new(0.3, 0.5, 0.0)).length() < 1e-3, "{point}");
        world.colliders.clear();
        assert!(pressed(&mut world, foot.clone(), Vec3::new(0.3, 0.8, 0.0), 80.0).is_empty());
        assert!(pressed(&mut world, foot.clone(), Vec3::new(0.71, 0.0, 0.0), 80.0).is_empty());
        for mass in [0.0, -1.0, f32::NAN] {
            world.colliders.clear();
            assert!(pressed(&mut world, foot.clone(), Vec3::Y * 0.71, mass).is_empty());
        }
    }

    #[test]
    fn a_ground_takes_its_share_and_cloth_by_the_corners_of_its_triangles() {
        let mut world = Simulation::default();
        let cube = box_3d(&BoxSpec::default()).unwrap();
        cube.build_colliding(&mut world, Default::default()).unwrap();
        let table = Shape::cuboid(Vec3::ONE).unwrap();
        world.colliders.push(Collider::fixed(table, Frame::at(Vec3::X)));
        world.begin_step(0.01).unwrap();
        let plate = Shape::cuboid(Vec3::new(1.0, 0.1, 0.5)).unwrap();
        let found = pressed(&mut world, plate, Vec3::new(0.5, 0.56, 0.0), 10.0);
        let sum: Vec3 = found.iter().map(|control| control.force).sum();
        assert!((sum.y + 0.5 * 98.1).abs() < 1.0, "half of it: {sum}");

        let mut world = Simulation::default();
        let flat = glam::Quat::from_xyzw(1.0, 0.0, 0.0, 1.0);
        let cloth = cloth_grid(&ClothSpec::default()).unwrap().transformed(flat, Vec3::ZERO);
        cloth.build_colliding(&mut world, Default::default()).unwrap();
        world.begin_step(0.01).unwrap();
        let middle = world.particles.position(world.particles.len() / 2);
        let at = middle + Vec3::new(0.011, 0.21, 0.007);
        let found = pressed(&mut world, Shape::sphere(0.2).unwrap(), at, 10.0);
        let sum: Vec3 = found.iter().map(|control| control.force).sum();
        assert!(!found.is_empty() && (sum.y + 98.1).abs() < 0.1, "{sum}");
    }
}
