//! Compiling from a mark on gives the same plan as compiling from scratch, whatever was added and removed before.

use super::super::tests::bend;
use super::super::*;
use crate::test_random::Random;

/// Bodies one after the other, and ties between them.
#[derive(Clone, Default)]
struct Bodies {
    sizes: Vec<Body>,
    /// Each tie connects a particle of one body to a particle of another: (body, particle) twice.
    ties: Vec<[(usize, u32); 2]>,
}

#[derive(Clone, Copy)]
enum Body {
    /// A square grid of this many rows and columns, with bends along its rows.
    Cloth(u32),
    /// This many particles.
    Rope(u32),
}

impl Body {
    fn particles(self) -> u32 {
        match self {
            Self::Cloth(side) => side * side,
            Self::Rope(count) => count,
        }
    }
}

impl Bodies {
    fn lists(&self) -> (Vec<Distance>, Vec<Constraint>, usize) {
        let (mut distances, mut constraints) = (Vec::new(), Vec::new());
        let (mut first, mut firsts) = (0, Vec::new());
        for &body in &self.sizes {
            firsts.push(first);
            match body {
                Body::Rope(count) => {
                    let rod = |i: u32| Distance::new(first + i, first + i + 1, 1.0);
                    distances.extend((0..count - 1).map(rod));
                }
                Body::Cloth(side) => {
                    let at = |c: u32, r: u32| first + r * side + c;
                    for (r, c) in (0..side).flat_map(|r| (0..side).map(move |c| (r, c))) {
                        if c + 1 < side {
                            distances.push(Distance::new(at(c, r), at(c + 1, r), 1.0));
                        }
                        if r + 1 < side {
                            distances.push(Distance::new(at(c, r), at(c, r + 1), 1.0));
                        }
                        if r + 2 < side {
                            let soft = Distance::new(at(c, r), at(c, r + 2), 2.0);
                            distances.push(soft.with_compliance(1.0));
                        }
                        if c + 3 < side {
                            constraints.push(bend([0, 1, 2, 3].map(|i| at(c + i, r))));
                        }
                    }
                }
            }
            first += body.particles();
        }
        let row = |(body, particle): (usize, u32)| firsts[body] + particle;
        distances.extend(self.ties.iter().map(|ends| {
            let [a, b] = ends.map(row);
            Distance::new(a, b, 0.5)
        }));
        (distances, constraints, first as usize)
    }

    fn remove(&mut self, body: usize) {
        self.sizes.remove(body);
        self.ties.retain(|ends| ends.iter().all(|end| end.0 != body));
        for end in self.ties.iter_mut().flatten().filter(|end| end.0 > body) {
            end.0 -= 1;
        }
    }

    fn change(&mut self, random: &mut Random) {
        let count = self.sizes.len();
        let body = |random: &mut Random| match random.below(3) {
            0 => Body::Cloth(6 + random.below(20) as u32),
            _ => Body::Rope(1 + random.below(40) as u32),
        };
        match random.below(8) {
            0..3 => self.sizes.push(body(random)),
            3 if count > 3 => self.remove(random.below(count)),
            4 if count > 3 => self.remove(count - 1),
            5 => self.sizes[random.below(count)] = body(random),
            6 => {
                let ends = [0, 1].map(|_| {
                    let own = random.below(count);
                    (own, random.below(self.sizes[own].particles() as usize) as u32)
                });
                if ends[0] != ends[1] {
                    self.ties.push(ends);
                }
            }
            _ if !self.ties.is_empty() => drop(self.ties.remove(random.below(self.ties.len()))),
            _ => {}
        }
        let sizes = self.sizes.clone();
        self.ties.retain(|ends| ends.iter().all(|&(own, i)| i < sizes[own].particles()));
    }
}

/// All contents of a plan that depend on its constraints and islands.
fn contents(plan: &Plan) -> [String; 13] {
    let Plan { distances, constraints, rods, constraint_batches, loose_distances, .. } = plan;
    let Plan { groups, cluster_batches, shared_rows, tasks, islands, instance_batches, .. } = plan;
    let chains = islands.list.iter().flat_map(|island| island.chains.clone());
    let chains = chains.map(|number| plan.chains.links(number));
    let Compiling { keys, slots, strides, clusters, reaches, .. } = &plan.compiling;
    [
        format!("{distances:?}"),
        format!("{constraints:?}"),
        format!("{rods:?}"),
        format!("{constraint_batches:?}"),
        format!("{loose_distances:?}"),
        format!("{groups:?}"),
        format!("{cluster_batches:?}"),
        format!("{shared_rows:?}"),
        format!("{tasks:?}"),
        format!("{islands:?}"),
        format!("{:?}", chains.collect::<Vec<_>>()),
        format!("{instance_batches:?}"),
        format!("{keys:?} {slots:?} {strides:?} {clusters:?} {reaches:?}"),
    ]
}

#[test]
fn what_comes_and_goes_leaves_the_plan_of_what_is_there() {
    let mut random = Random::new(1);
    let mut bodies = Bodies::default();
    bodies.sizes.extend([Body::Cloth(24), Body::Rope(9), Body::Cloth(18), Body::Rope(1)]);
    let (mut plan, mut before) = (Plan::default(), (Vec::new(), Vec::new(), 0));
    let mut kept = 0;
    for round in 0..300 {
        let now = bodies.lists();
        let given = PlanInput { distances: &now.0, constraints: &now.1, particles: now.2 };
        let distances = before.0.iter().zip(&now.0).take_while(|(a, b)| a == b).count();
        let constraints = before.1.iter().zip(&now.1).take_while(|(a, b)| a == b).count();
        plan.compile_changed(given, [distances, constraints]);
        kept += usize::from(plan.marks.len() > 2);
        let mut fresh = Plan::default();
        fresh.compile(given);
        for (own, expected) in contents(&plan).iter().zip(&contents(&fresh)) {
            assert!(own == expected, "round {round}");
        }
        before = now;
        bodies.change(&mut random);
    }
    assert!(kept > 200, "there is hardly ever a mark: {kept}");
}

/// Spawning a body last compiles that body alone: the bodies before it keep their keys and their place in memory.
#[test]
fn what_is_added_behind_is_all_that_is_compiled() {
    let mut bodies = Bodies::default();
    bodies.sizes.extend([Body::Cloth(24); 3]);
    let (distances, constraints, particles) = bodies.lists();
    let mut plan = Plan::default();
    plan.compile(PlanInput { distances: &distances, constraints: &constraints, particles });
    let same = [distances.len(), constraints.len()];
    assert_eq!(plan.marked_before(plan.islands.list.len()), 3);
    bodies.sizes.push(Body::Rope(5));
    let (distances, constraints, particles) = bodies.lists();
    let added = PlanInput { distances: &distances, constraints: &constraints, particles };
    assert_eq!(added.valid_from(same).len(), 4);
    plan.compile_changed(added, same);
    assert_eq!(plan.compiling.of_island.len(), 4);
    // A rope tied to the second cloth causes that cloth to be compiled again, and the third, which comes after it.
    bodies.ties.push([(1, 3), (3, 0)]);
    let same = [distances.len(), constraints.len()];
    let (distances, constraints, particles) = bodies.lists();
    plan.compile_changed(
        PlanInput { distances: &distances, constraints: &constraints, particles },
        same,
    );
    let first = distances.iter().filter(|d| d.a < 24 * 24).count();
    assert_eq!(plan.compiling.of_island.len(), distances.len() - first);
}
