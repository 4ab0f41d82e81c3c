//! Broad phase over whole bodies: finds the bodies that may touch another one in a step, so that bodies far from everything cost nothing.
//!
//! It serves bodies that have particles of their own to collide with: cloth, ropes, soft bodies, single particles. Rigid parts are tested one by one anyway
//! (`body_contact`), and are included here only as something those may run into.
//!
//! Of a large body near another one, mostly only a few particles are close: a sail has ropes at its corners. The other particles are excluded too. The other
//! body is cut into strips of consecutive particles, and the swept bounds of each strip are a region: particles of the large body outside all regions take no
//! part. One box about the whole body would not do: that about a rope running aslant to a corner contains half of the sail.

use core::ops::Range;

use glam::Vec3;

use super::body_collider::BodyCollider;
use super::manifold::Broad;
use super::material::BodyContacts;
use super::world::World;
use crate::not_cloned::NotCloned;
use crate::particles::{NO_BODY, Particles};

/// Bodies that are near another one in a step. Scratch.
///
/// Bodies that collide by their particles are tested against particles of others in one place (`pairs`, `triangles`) and against shapes in another
/// (`body_contact`), and take part in each only where there is something of that kind. Cloth that a figure runs into touches its limbs and no particle, so none
/// of its triangles is tested against particles.
#[derive(Clone, Debug, Default)]
pub(crate) struct Nearby {
    /// Bodies that may touch particles, of another body or their own.
    particles: Participation,
    /// Bodies that may touch shapes.
    shapes: Participation,
    bodies: Vec<BodyExtent>,
    bounds: Vec<(Vec3, Vec3)>,
    broad: NotCloned<Broad>,
    pairs: Vec<[u32; 2]>,
    /// For each body the greatest distance that its shapes reach beyond its particles, metres; may be missing for bodies without shapes.
    overhangs: Vec<f32>,
    /// Large bodies, each paired with a body that it is near; sorted.
    large_pairs: Vec<[u32; 2]>,
    /// Strips of each body that a large one is near, and of the large ones.
    strips_of: Vec<StripsOf>,
    /// Boxes about consecutive particles of a body.
    strips: Vec<(Vec3, Vec3)>,
}

/// The bodies, regions and particles that may touch things of one kind.
#[derive(Clone, Debug, Default)]
pub(crate) struct Participation {
    /// For each body, whether some of its particles may touch something, and whether that something belongs to another body.
    near: Vec<bool>,
    beside: Vec<bool>,
    /// For each body its slice of `regions`, in which its particles take part; empty where all of them do.
    of_body: Vec<Range<u32>>,
    regions: Vec<(Vec3, Vec3)>,
    /// For each body how many of its particles lie in its regions.
    inside: Vec<u32>,
    /// For each row whether it lies in no region although its body takes part; empty where there is no such row.
    far: Vec<bool>,
}

/// Bounds and motion of a body.
#[derive(Clone, Copy, Debug)]
struct BodyExtent {
    low: Vec3,
    high: Vec3,
    /// The square of the speed of its fastest particle, m²/s².
    fastest: f32,
    /// Mean velocity, m/s. First the sum over its particles; divided only for large bodies that are near others, and for those others.
    velocity: Vec3,
    /// The greatest deviation of a particle's velocity from that, m/s; of the same bodies.
    spread: f32,
    /// The radius of its largest particle, metres.
    radius: f32,
    /// The greatest distance that a pin of it is moved by in this step, metres.
    pin_motion: f32,
    /// Number of its particles.
    particles: u32,
    /// The greatest distance that its shapes reach beyond its particles, metres.
    overhang: f32,
    /// Whether some of its particles collide by themselves, and whether some collide as a shape.
    free: bool,
    has_shapes: bool,
}

/// The strips of a body: their slice of the boxes, the particles in each, and a count of particles processed while they are built.
#[derive(Clone, Debug, Default)]
struct StripsOf {
    strips: Range<u32>,
    size: u32,
    processed: u32,
}

/// Maximum number of strips of a body, and minimum number of particles of a strip.
const MAX_STRIPS: u32 = 8;
const MIN_STRIP: u32 = 4;

/// Up to this many particles of a body, all take part.
const LARGE: u32 = 64;

/// Above this many regions of a body all of its particles take part: testing each against so many boxes takes as long.
const MAX_REGIONS: usize = 48;

/// Where more than one particle in this many is in a region, all of the body take part: the set of participants then changes less often, and neighbour lists
/// last longer.
const FULL_RATIO: u32 = 2;

/// Factor on the speed of the fastest particle: what its neighbours fling can become faster than any of them was.
pub(super) const SPEED_FACTOR: f32 = 1.5;

/// How far a body may reach in a step of `dt` seconds beyond the radii of its particles, metres, if the fastest of them moves at `speed` m/s.
pub(super) fn reach(speed: f32, gravity: f32, dt: f32) -> f32 {
    SPEED_FACTOR * (speed + gravity * dt) * dt
}

impl Nearby {
    /// A result in which every body that collides takes part, wherever it is.
    #[cfg(test)]
    pub(super) fn everywhere(contacts: &[BodyContacts]) -> Self {
        let near: Vec<bool> = contacts.iter().map(BodyContacts::takes_part).collect();
        let all = Participation { beside: near.clone(), near, ..Participation::default() };
        Self { particles: all.clone(), shapes: all, ..Self::default() }
    }

    /// Participation in contacts with particles of another body, or of the same one.
    pub(super) fn to_particles(&self) -> &Participation {
        &self.particles
    }

    /// Participation in contacts with shapes of another body, or of the same one.
    pub(super) fn to_shapes(&self) -> &Participation {
        &self.shapes
    }

    /// Computes how far shapes overhang particles, when either has changed.
    pub(super) fn compile(&mut self, body_colliders: &[BodyCollider], particles: &Particles) {
        self.overhangs.clear();
        for BodyCollider { rows, rest, shape, .. } in body_colliders {
            let body = rows.first().and_then(|&row| particles.body.get(row as usize));
            let Some(&body) = body.filter(|&&body| body != NO_BODY) else { continue };
            let (low, high) = shape.bounds();
            let corners = (0..8_u32).map(|i| {
                let side = |bit: u32| if i >> bit & 1 == 1 { 1.0 } else { 0.0 };
                low + (high - low) * Vec3::new(side(0), side(1), side(2))
            });
            let apart = |corner: Vec3| {
                rest.iter().map(|at| at.distance(corner)).fold(f32::INFINITY, f32::min)
            };
            let overhang = corners.map(apart).fold(0.0, f32::max);
            let body = body as usize;
            self.overhangs.resize(self.overhangs.len().max(body + 1), 0.0);
            self.overhangs[body] = self.overhangs[body].max(overhang);
        }
    }

    /// Finds the bodies and regions that take part in this step. Rows that are marked in `excluded` do not collide by themselves.
    pub(super) fn broad_phase(&mut self, particles: &Particles, world: &World, excluded: &[bool]) {
        let contacts = world.filter.bodies();
        self.particles.clear(contacts.len());
        self.shapes.clear(contacts.len());
        if !contacts.iter().any(BodyContacts::takes_part) {
            return;
        }
        // Where everything that collides does so by a shape, there is nothing to find.
        let is_free = |(row, &body): (usize, &u32)| {
            let own = contacts.get(body as usize);
            excluded.get(row) != Some(&true)
                && own.is_some_and(|own| particles.radius[row] > 0.0 || own.surface)
        };
        if !particles.body.iter().enumerate().any(is_free) {
            return;
        }
        self.measure(particles, world, excluded);
        if !self.bodies.iter().any(|body| body.free) {
            return;
        }
        let Self { bodies, bounds, broad, pairs, .. } = self;
        bounds.clear();
        bounds.extend(bodies.iter().map(|body| body.bounds(world)));
        broad.0.pairs(bounds, pairs);
        for (number, (body, own)) in bodies.iter().zip(contacts).enumerate() {
            let with_itself = body.free && own.with_itself && !own.disabled;
            self.particles.near[number] = with_itself;
            self.shapes.near[number] = with_itself && body.has_shapes;
        }
        for &[a, b] in &*pairs {
            let [a, b] = [a as usize, b as usize];
            if !((bodies[a].free || bodies[b].free) && contacts[a].collides_with(&contacts[b])) {
                continue;
            }
            for [one, other] in [[a, b], [b, a]] {
                self.particles.add(one, bodies[one].free && bodies[other].free);
                self.shapes.add(one, bodies[one].free && bodies[other].has_shapes);
            }
        }
        self.find_large_pairs(world);
        if !self.large_pairs.is_empty() {
            self.find_strips(particles, world);
            self.find_regions(world);
            for participation in [&mut self.particles, &mut self.shapes] {
                participation.find_far(particles, &self.bodies);
            }
        }
    }

    /// Lists large bodies with the bodies that they are near.
    fn find_large_pairs(&mut self, world: &World) {
        let contacts = world.filter.bodies();
        let Self { bodies, pairs, particles, shapes, large_pairs, .. } = self;
        large_pairs.clear();
        let is_beside = |body: u32| particles.has_other(body) || shapes.has_other(body);
        let is_large = |body: usize| {
            bodies[body].particles > LARGE && bodies[body].free && is_beside(body as u32)
        };
        if !(0..bodies.len()).any(is_large) {
            return;
        }
        let may_touch =
            |&&[a, b]: &&[u32; 2]| contacts[a as usize].collides_with(&contacts[b as usize]);
        let both_ways = pairs.iter().filter(may_touch).flat_map(|&[a, b]| [[a, b], [b, a]]);
        large_pairs.extend(both_ways.filter(|&[body, other]| {
            let other = &bodies[other as usize];
            is_large(body as usize) && (other.free || other.has_shapes)
        }));
        large_pairs.sort_unstable();
    }

    /// Bounds the strips of the bodies in `large_pairs`, and computes the mean velocity and spread of each.
    fn find_strips(&mut self, particles: &Particles, world: &World) {
        let contacts = world.filter.bodies();
        let Self { bodies, large_pairs, strips_of, strips: boxes, .. } = self;
        boxes.clear();
        strips_of.clear();
        strips_of.resize(bodies.len(), StripsOf::default());
        for &body in large_pairs.iter().flatten() {
            let (extent, own) = (&mut bodies[body as usize], &mut strips_of[body as usize]);
            if own.size == 0 {
                // Shapes and surfaces also collide between particles of different strips, so they are one strip.
                let whole = extent.has_shapes || contacts[body as usize].surface;
                let strips = if whole { 1 } else { MAX_STRIPS };
                own.size = extent.particles.div_ceil(strips).max(MIN_STRIP);
                extent.velocity /= extent.particles as f32;
                let first = boxes.len() as u32;
                let end = first + extent.particles.div_ceil(own.size);
                own.strips = first..end;
                boxes.resize(end as usize, (Vec3::INFINITY, Vec3::NEG_INFINITY));
            }
        }
        for (row, &body) in particles.body.iter().enumerate() {
            let Some(own) = strips_of.get_mut(body as usize).filter(|own| own.size > 0) else {
                continue;
            };
            let at = particles.origin[row] + particles.position[row].truncate();
            if !contacts[body as usize].takes_part() || !at.is_finite() {
                continue;
            }
            let extent = &mut bodies[body as usize];
            let (number, about) =
                (own.processed / own.size, particles.radius[row] + extent.overhang);
            // The first particle of a strip belongs to the strip before, too: a rope may collide by the segment between the two.
            let first = own.processed.is_multiple_of(own.size) && number > 0;
            let strips = own.strips.start + number - u32::from(first)..=own.strips.start + number;
            for strip in strips {
                let (low, high) = &mut boxes[strip as usize];
                (*low, *high) = (low.min(at - about), high.max(at + about));
            }
            let apart = particles.velocity[row].truncate() - extent.velocity;
            extent.spread = extent.spread.max(apart.length());
            own.processed += 1;
        }
    }

    /// Finds the regions in which particles of large bodies may touch another body: the swept bounds of that body, relative to the mean velocity of the large
    /// one, because a parachute and its ropes fall together.
    fn find_regions(&mut self, world: &World) {
        let contacts = world.filter.bodies();
        let Self { particles, shapes, bodies, large_pairs, strips_of, strips, .. } = self;
        for large_pairs in large_pairs.chunk_by(|one, other| one[0] == other[0]) {
            let body = large_pairs[0][0] as usize;
            let extent = &bodies[body];
            let others = || large_pairs.iter().map(|&[_, other]| other as usize);
            let speed = |other: usize| {
                let apart = bodies[other].velocity - extent.velocity;
                apart.length() + bodies[other].spread
            };
            // What is hit may become as fast as what hits it.
            let fastest = others().map(speed).fold(extent.spread, f32::max);
            let reach = |speed: f32| reach(speed, world.g(), world.dt);
            let own = extent.pin_motion + extent.radius + extent.rounding() + reach(fastest);
            let regions = |other: usize| {
                let theirs = &bodies[other];
                let wide = own + theirs.pin_motion + theirs.rounding() + reach(speed(other));
                let Range { start, end } = strips_of[other].strips.clone();
                let boxes = &strips[start as usize..end as usize];
                boxes.iter().map(move |&(low, high)| (low - wide, high + wide))
            };
            // In a body that collides with itself any particle may touch another one of it.
            let alone = !contacts[body].with_itself;
            if alone {
                let others = others().filter(|&other| bodies[other].free);
                particles.set_regions(body, others.flat_map(regions));
            }
            if alone || !extent.has_shapes {
                let others = others().filter(|&other| bodies[other].has_shapes);
                shapes.set_regions(body, others.flat_map(regions));
            }
        }
    }

    /// Computes the bounds of each body that takes part, including the targets of its pins.
    fn measure(&mut self, particles: &Particles, world: &World, excluded: &[bool]) {
        let contacts = world.filter.bodies();
        self.bodies.clear();
        self.bodies.resize(contacts.len(), BodyExtent::EMPTY);
        for (row, &body) in particles.body.iter().enumerate() {
            let Some(own) = contacts.get(body as usize) else { continue };
            let at = particles.origin[row] + particles.position[row].truncate();
            if !own.takes_part() || !at.is_finite() {
                continue;
            }
            let (extent, radius) = (&mut self.bodies[body as usize], particles.radius[row]);
            let excluded = excluded.get(row) == Some(&true);
            extent.add(at, radius);
            extent.has_shapes |= excluded;
            let speed = particles.velocity[row].truncate().length_squared();
            extent.fastest = extent.fastest.max(speed);
            extent.velocity += particles.velocity[row].truncate();
            extent.particles += 1;
            extent.free |= !excluded && (radius > 0.0 || own.surface);
        }
        for (extent, &overhang) in self.bodies.iter_mut().zip(&self.overhangs) {
            (extent.low, extent.high) = (extent.low - overhang, extent.high + overhang);
            extent.overhang = overhang;
        }
        for pin in &world.boundaries.pins {
            let body = particles.body.get(pin.particle as usize).copied().unwrap_or(NO_BODY);
            if let Some(extent) = self.bodies.get_mut(body as usize)
                && pin.target.is_finite()
            {
                let row = pin.particle as usize;
                extent.add(pin.target, particles.radius[row]);
                let at = particles.origin[row] + particles.position[row].truncate();
                extent.pin_motion = extent.pin_motion.max((pin.target - at).length());
            }
        }
    }
}

impl Participation {
    /// Clears everything, and resizes for this many bodies.
    fn clear(&mut self, bodies: usize) {
        self.near.clear();
        self.near.resize(bodies, false);
        self.beside.clear();
        self.beside.resize(bodies, false);
        self.of_body.clear();
        self.regions.clear();
        self.far.clear();
    }

    /// Sets the regions in which particles of a body take part.
    fn set_regions(&mut self, body: usize, of_others: impl Iterator<Item = (Vec3, Vec3)>) {
        let Self { near, of_body, regions, .. } = self;
        let first = regions.len();
        regions.extend(of_others.take(MAX_REGIONS + 1));
        let is_finite = |(low, high): &(Vec3, Vec3)| low.is_finite() && high.is_finite();
        // Where a speed is infinite or NaN, all particles take part.
        if regions.len() - first > MAX_REGIONS || !regions[first..].iter().all(is_finite) {
            regions.truncate(first);
        }
        of_body.resize(near.len(), 0..0);
        of_body[body] = first as u32..regions.len() as u32;
    }

    /// Marks the particles that are in no region of their body, unless most of the body is in one.
    fn find_far(&mut self, particles: &Particles, bodies: &[BodyExtent]) {
        let Self { of_body, regions, far, inside, .. } = self;
        if regions.is_empty() {
            return;
        }
        inside.clear();
        inside.resize(bodies.len(), 0);
        far.resize(particles.len(), false);
        for (row, &body) in particles.body.iter().enumerate() {
            let own = of_body.get(body as usize).filter(|own| !own.is_empty());
            let Some(own) = own else { continue };
            let at = particles.origin[row] + particles.position[row].truncate();
            let regions = &regions[own.start as usize..own.end as usize];
            far[row] = !regions.iter().any(|&region| is_within((at, at), region));
            inside[body as usize] += u32::from(!far[row]);
        }
        let mut any = false;
        for ((own, extent), inside) in of_body.iter_mut().zip(bodies).zip(&*inside) {
            if *inside * FULL_RATIO > extent.particles {
                *own = 0..0;
            }
            any |= own.start < own.end;
        }
        if !any {
            far.clear();
        }
        for (far, &body) in far.iter_mut().zip(&particles.body) {
            *far &= of_body.get(body as usize).is_some_and(|own| !own.is_empty());
        }
    }

    /// Marks a body as near another one, if `beside`.
    fn add(&mut self, body: usize, beside: bool) {
        self.near[body] |= beside;
        self.beside[body] |= beside;
    }

    /// Whether some particles of a body may touch things of another body.
    pub(super) fn has_other(&self, body: u32) -> bool {
        self.beside.get(body as usize) == Some(&true)
    }

    /// Whether some particles of a body take part.
    #[inline(always)]
    pub(super) fn has(&self, body: u32) -> bool {
        self.near.get(body as usize) == Some(&true)
    }

    /// Whether the particle of a row, which belongs to `body`, takes part.
    #[inline(always)]
    pub(super) fn has_particle(&self, row: usize, body: u32) -> bool {
        self.has(body) && self.far.get(row) != Some(&true)
    }

    /// Whether the triangle of three points of a body, metres in the world, takes part.
    pub(super) fn has_hull(&self, body: u32, points: [Vec3; 3]) -> bool {
        let own = self.of_body.get(body as usize).filter(|own| !own.is_empty());
        let Some(own) = own else { return self.has(body) };
        let [a, b, c] = points;
        let bounds = (a.min(b).min(c), a.max(b).max(c));
        let regions = &self.regions[own.start as usize..own.end as usize];
        regions.iter().any(|&region| is_within(bounds, region))
    }
}

impl BodyExtent {
    const EMPTY: Self = Self {
        low: Vec3::INFINITY,
        high: Vec3::NEG_INFINITY,
        fastest: 0.0,
        velocity: Vec3::ZERO,
        spread: 0.0,
        radius: 0.0,
        pin_motion: 0.0,
        particles: 0,
        overhang: 0.0,
        free: false,
        has_shapes: false,
    };

    #[inline(always)]
    fn add(&mut self, at: Vec3, radius: f32) {
        self.low = self.low.min(at - radius);
        self.high = self.high.max(at + radius);
        self.radius = self.radius.max(radius);
    }

    /// Swept bounds of the step. Inverted, so that it overlaps nothing, for a body that takes no part.
    fn bounds(&self, world: &World) -> (Vec3, Vec3) {
        let wide = reach(self.fastest.sqrt(), world.g(), world.dt) + self.rounding();
        (self.low - wide, self.high + wide)
    }

    /// Bound of the rounding of position plus origin, which grows with the distance from the origin, metres.
    fn rounding(&self) -> f32 {
        1e-6 * (self.low.abs().max(self.high.abs()).max_element() + 1.0)
    }
}

/// Whether a box overlaps a region; false for NaN.
fn is_within((low, high): (Vec3, Vec3), region: (Vec3, Vec3)) -> bool {
    low.cmple(region.1).all() && region.0.cmple(high).all()
}

#[cfg(test)]
mod tests {
    use glam::Quat;

    use super::*;
    use crate::collide::ContactFilter;
    use crate::constraints::{Boundaries, Pin};
    use crate::islands::Islands;
    use crate::particles::ParticleSeed;
    use crate::recipes::{BoxLayout, BoxSpec, box_3d};

    /// A flat sheet of 40 × 40 particles with a spacing of 0.1 m and a radius of 0.04 m, with a corner at the origin; and other bodies.
    #[derive(Default)]
    struct Sheet {
        particles: Particles,
        contacts: Vec<BodyContacts>,
        boundaries: Boundaries,
        shapes: Vec<BodyCollider>,
    }

    impl Sheet {
        const SIDE: usize = 40;

        fn new() -> Self {
            let mut sheet = Self::default();
            let all = (0..Self::SIDE * Self::SIDE).map(|i| [i % Self::SIDE, i / Self::SIDE]);
            sheet.add(all.map(|[x, z]| Vec3::new(x as f32, 0.0, z as f32) * 0.1), Vec3::ZERO);
            sheet
        }

        /// Adds a body of such particles with a common velocity.
        fn add(&mut self, places: impl IntoIterator<Item = Vec3>, velocity: Vec3) {
            let body = self.contacts.len() as u32;
            self.contacts.push(BodyContacts { with_bodies: true, ..BodyContacts::DEFAULT });
            for place in places {
                let seed = ParticleSeed::at(place).with_radius(0.04);
                let row = self.particles.push(seed).unwrap() as usize;
                self.particles.set_body(row, Some(body));
                self.particles.set_velocity(row, velocity);
            }
        }

        /// Adds a crate of 1 m that lies on the middle of the sheet.
        fn add_crate(&mut self, layout: BoxLayout) {
            let spec = BoxSpec { size: Vec3::splat(1.0), layout, ..BoxSpec::default() };
            let crate_ = box_3d(&spec).unwrap();
            let crate_ = crate_.transformed(Quat::IDENTITY, Vec3::new(2.0, 0.56, 2.0));
            let rows = self.particles.len() as u32..self.particles.len() as u32 + 8;
            self.add(crate_.particles.iter().map(|seed| seed.position), Vec3::ZERO);
            let part = &crate_.parts[0];
            let (rest, shape) = (part.rest.as_slice().into(), part.shape.clone().unwrap());
            self.shapes.push(BodyCollider { rows: rows.collect(), rest, shape, id: 0 });
        }

        /// The broad phase for a step of 1/60 s.
        fn nearby(&self) -> Nearby {
            let (filter, islands) = (ContactFilter::untied(&self.contacts), Islands::default());
            let world = World {
                boundaries: &self.boundaries,
                colliders: &[],
                body_colliders: &self.shapes,
                filter: &filter,
                islands: &islands,
                dt: 1.0 / 60.0,
                substeps: 10,
                gravity: Vec3::Y * -9.81,
                row_gravity: &crate::forces::RowGravity::from(9.81),
                at_rest: false,
            };
            let mut nearby = Nearby::default();
            nearby.compile(&self.shapes, &self.particles);
            let mut excluded = vec![false; self.particles.len()];
            self.shapes
                .iter()
                .flat_map(|of| &of.rows)
                .for_each(|&row| excluded[row as usize] = true);
            nearby.broad_phase(&self.particles, &world, &excluded);
            nearby
        }

        /// Positions of the particles of the sheet that may touch another body.
        fn taking_part(&self) -> Vec<Vec3> {
            let nearby = self.nearby();
            // Small bodies take part with all of their particles or none.
            let sheet = 0..Self::SIDE * Self::SIDE;
            let others = sheet.end..self.particles.len();
            let body = |row: usize| self.particles.body[row];
            for kind in [nearby.to_particles(), nearby.to_shapes()] {
                let of_all = |row: usize| kind.has_particle(row, body(row)) == kind.has(body(row));
                assert!(others.clone().all(of_all));
            }
            let place = |row: usize| self.particles.position(row);
            let takes_part = |&row: &usize| {
                nearby.to_particles().has_particle(row, 0)
                    || nearby.to_shapes().has_particle(row, 0)
            };
            sheet.filter(takes_part).map(place).collect()
        }
    }

    #[test]
    fn of_a_sheet_with_a_thing_on_its_corner_only_what_is_below_it_takes_part() {
        let mut sheet = Sheet::new();
        sheet.add([Vec3::new(0.1, 0.08, 0.1)], Vec3::ZERO);
        let taking_part = sheet.taking_part();
        // Two radii, and for each the reach that gravity adds in the step.
        let near = 0.1 + 2.0 * (0.04 + reach(0.0, 9.81, 1.0 / 60.0));
        assert_eq!(taking_part.len(), 1, "{taking_part:?}");
        assert!(taking_part.iter().all(|at| at.max_element() <= near));
    }

    #[test]
    fn where_something_comes_fast_more_of_it_takes_part() {
        let mut sheet = Sheet::new();
        sheet.add([Vec3::new(1.0, 0.1, 1.0)], Vec3::new(12.0, -3.0, 0.0));
        // What is hit moves as fast, so the reach is twice 0.3 m in the step.
        let within = |at: &&Vec3| (at.x - 1.0).abs() < 0.6 && (at.z - 1.0).abs() < 0.6;
        let all = Sheet::new().particles;
        let wanted = (0..all.len()).map(|row| all.position(row)).filter(|at| within(&at)).count();
        let taking_part = sheet.taking_part();
        assert_eq!(taking_part.iter().filter(within).count(), wanted);
        assert!(wanted > 100 && taking_part.len() < 250, "{wanted} of {}", taking_part.len());
    }

    #[test]
    fn a_common_velocity_adds_no_participants() {
        let mut sheet = Sheet::new();
        sheet.add([Vec3::new(0.1, 0.08, 0.1)], Vec3::ZERO);
        for row in 0..sheet.particles.len() {
            sheet.particles.set_velocity(row, Vec3::new(3.0, -20.0, 5.0));
        }
        let taking_part = sheet.taking_part();
        assert_eq!(taking_part.len(), 1, "{taking_part:?}");
    }

    /// The corners of a crate on a sheet used to be two strips, and the sheet sank in between them; with a crate whose particles are inside of it, by more than
    /// a third of its size.
    #[test]
    fn below_all_of_a_shape_it_takes_part() {
        for layout in [BoxLayout::Corners, BoxLayout::Equimomental] {
            let mut sheet = Sheet::new();
            sheet.add_crate(layout);
            let taking_part = sheet.taking_part();
            let below = |at: &&Vec3| (at.x - 2.0).abs() < 0.5 && (at.z - 2.0).abs() < 0.5;
            assert_eq!(taking_part.iter().filter(below).count(), 81, "{layout:?}");
            assert!(taking_part.len() < 400, "{layout:?}: {}", taking_part.len());
        }
    }

    /// A figure that ran into cloth had all triangles of the cloth tested in each substep, which took two thirds of the time, though triangles never touch a
    /// shape.
    #[test]
    fn a_body_near_a_shape_is_not_near_particles() {
        let mut sheet = Sheet::new();
        sheet.add_crate(BoxLayout::Corners);
        let nearby = sheet.nearby();
        assert!(nearby.to_shapes().has(0) && !nearby.to_particles().has(0));
        // With a particle nearby as well, each kind has its own regions.
        sheet.add([Vec3::new(0.1, 0.08, 0.1)], Vec3::ZERO);
        let nearby = sheet.nearby();
        let count = |kind: &Participation| {
            (0..Sheet::SIDE * Sheet::SIDE).filter(|&row| kind.has_particle(row, 0)).count()
        };
        assert_eq!(count(nearby.to_particles()), 1);
        assert!((81..400).contains(&count(nearby.to_shapes())));
    }

    #[test]
    fn where_a_velocity_is_no_number_all_of_it_takes_part() {
        for velocity in [Vec3::NAN, Vec3::INFINITY] {
            let mut sheet = Sheet::new();
            sheet.add([Vec3::new(0.1, 0.08, 0.1)], Vec3::ZERO);
            sheet.particles.velocity[700] = velocity.extend(0.0);
            assert_eq!(sheet.taking_part().len(), Sheet::SIDE * Sheet::SIDE, "{velocity}");
        }
    }

    #[test]
    fn particles_along_the_motion_of_a_pin_take_part() {
        let mut sheet = Sheet::new();
        sheet.add([Vec3::new(0.0, 1.5, 0.0)], Vec3::ZERO);
        assert_eq!(sheet.taking_part().len(), 0);
        sheet.particles.position[0].w = 0.0;
        sheet.boundaries.pins.push(Pin { particle: 0, target: Vec3::new(0.0, 1.5, 0.0) });
        // A moved pin drags its neighbours along.
        let taking_part = sheet.taking_part();
        assert!(taking_part.contains(&Vec3::ZERO) && taking_part.len() > 100);
        assert!(taking_part.iter().all(|at| at.max_element() < 1.7));
    }

    #[test]
    fn where_most_of_it_is_near_others_or_there_are_many_all_of_it_takes_part() {
        let corner = Vec3::new(0.1, 0.08, 0.1);
        let mut sheet = Sheet::new();
        let aslant = |share: f32| corner.lerp(Vec3::new(3.0, 0.08, 3.0), share);
        // Under a dense row that lies aslant only the particles below it take part. A body of few points far apart is one box, so everything between them does.
        sheet.add((0..128).map(|i| aslant(i as f32 / 127.0)), Vec3::ZERO);
        let taking_part = sheet.taking_part().len();
        assert!((100..300).contains(&taking_part), "{taking_part}");
        let mut sheet = Sheet::new();
        sheet.add([aslant(0.0), aslant(1.0)], Vec3::ZERO);
        assert_eq!(sheet.taking_part().len(), Sheet::SIDE * Sheet::SIDE);
        let mut sheet = Sheet::new();
        for _ in 0..=MAX_REGIONS {
            sheet.add([corner], Vec3::ZERO);
        }
        assert_eq!(sheet.taking_part().len(), Sheet::SIDE * Sheet::SIDE);
        sheet.contacts.pop();
        sheet.contacts.push(BodyContacts { disabled: true, ..BodyContacts::DEFAULT });
        sheet.particles.set_body(sheet.particles.len() - 1, Some(1));
        assert_eq!(sheet.taking_part().len(), 1);
    }

    #[test]
    fn a_triangle_takes_part_where_it_is_over_a_thing_none_of_its_corners_is_near() {
        let mut sheet = Sheet::new();
        sheet.add([Vec3::new(2.0, 0.08, 2.0)], Vec3::ZERO);
        let nearby = sheet.nearby();
        let corners = |size: f32| [Vec3::ZERO, Vec3::X * size, Vec3::Z * size];
        let kind = nearby.to_particles();
        assert!(kind.has_hull(0, corners(3.9)) && !kind.has_hull(0, corners(1.0)));
    }
}
