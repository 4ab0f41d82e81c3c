//! Random constraints, and other features of a world: compounds, air, controls, attractors.

use std::sync::Arc;

use sinew::constraints::{
    Angle, Area, Bend, Collinear, Cone, Coplanar, Hinge, Patch, Rigid, SizeCorrection, Tetrahedron,
    Volume,
};
use sinew::glam::Vec3;
use sinew::{
    AirFlow, Attractor, BodySettings, Compound, Constraint, ConstraintKind, Control, GradientAt,
    Integrator, Order, Region, Representation, RigidIntegrator, Simulation, Softness,
    SolverSettings,
};

use crate::input::Input;

const MAX_CONSTRAINTS: usize = 12;

/// The solver settings that are not numbers.
pub(crate) fn choices(input: &mut Input, settings: SolverSettings) -> SolverSettings {
    SolverSettings {
        gradient_at: gradient_at(input),
        order: order(input),
        integrator: [
            Integrator::Verlet,
            Integrator::Leapfrog,
            Integrator::SemiImplicitEuler,
            Integrator::ExplicitEuler,
        ][input.below(4) as usize],
        max_speed: settings.max_speed,
        keep_spin: input.flag(),
        long_range: input.flag(),
        microsteps: !input.rarely(4),
        statics: input.rarely(16),
        ..settings
    }
}

/// Adds or changes one of these.
pub(crate) fn operate(
    world: &mut Simulation,
    input: &mut Input,
    row: fn(&mut Input, usize) -> u32,
) {
    let count = world.particles.len();
    let rows =
        |input: &mut Input, n: u32| -> Vec<u32> { (0..n).map(|_| row(input, count)).collect() };
    match input.below(8) {
        0..=3 => {
            let n = input.below(7);
            let constraint = Constraint::new(rows(input, n), kind(input, n as usize));
            let k = input.below(world.constraints().len() as u32 + 1) as usize;
            match world.constraints().len() {
                MAX_CONSTRAINTS if k == MAX_CONSTRAINTS => drop(world.remove_constraint(k - 1)),
                MAX_CONSTRAINTS => drop(world.replace_constraint(k, constraint)),
                _ => world.insert_constraint(k, constraint),
            }
        }
        4 => {
            let n = input.below(6);
            let rows: Vec<usize> = rows(input, n).into_iter().map(|row| row as usize).collect();
            let rest = (0..n).map(|_| input.vector()).collect();
            let all = [RigidIntegrator::Euler, RigidIntegrator::Leapfrog, RigidIntegrator::Verlet];
            let integrator = all[input.below(3) as usize];
            let list = world.compounds_mut();
            list.truncate(2);
            list.push(Compound { integrator, ..Compound::new(rows, rest) });
        }
        5 => {
            let flow = AirFlow {
                velocity: input.vector(),
                gusts: input.mostly(Input::positive),
                ..AirFlow::steady(Vec3::X)
            };
            world.forces.air_flows.truncate(1);
            world.forces.air_flows.push(AirFlow { region: region(input), ..flow });
        }
        6 => {
            let n = input.below(5);
            let mut control = Control::force("fuzz", rows(input, n), input.vector());
            control.torque = input.vector();
            control.point = input.flag().then(|| input.vector());
            world.forces.controls.truncate(2);
            world.forces.controls.push(control);
        }
        _ => {
            world.forces.attractors.truncate(2);
            world.forces.attractors.push(Attractor::new(input.vector(), input.any()));
            let own = BodySettings {
                max_sweeps: input.flag().then(|| input.below(6)),
                single_sweep_below: input.flag().then(|| input.any()),
                tolerance: input.flag().then(|| input.any()),
                tolerance_speed: input.flag().then(|| input.any()),
                gradient_at: input.flag().then(|| gradient_at(input)),
                order: input.flag().then(|| order(input)),
                keep_spin: input.flag().then(|| input.flag()),
                damping: input.any(),
                representation: if input.flag() {
                    Representation::Auto
                } else {
                    Representation::Particles
                },
            };
            *world.bodies = vec![own];
            for i in 0..count {
                world.particles.set_body(i, input.flag().then_some(0));
            }
        }
    }
}

fn gradient_at(input: &mut Input) -> GradientAt {
    if input.flag() { GradientAt::Current } else { GradientAt::StepStart }
}

fn order(input: &mut Input) -> Order {
    [Order::GaussSeidel, Order::MostViolatedFirst, Order::Jacobi][input.below(3) as usize]
}

fn region(input: &mut Input) -> Region {
    if input.flag() {
        Region::EVERYWHERE
    } else {
        Region::sphere(input.vector(), input.mostly(Input::positive))
    }
}

fn softness(input: &mut Input) -> Softness {
    match input.below(5) {
        0 => Softness::Compliant {
            compliance: input.mostly(Input::positive),
            damping: input.mostly(Input::positive),
        },
        1 => Softness::Frequency {
            hertz: input.mostly(Input::positive),
            ratio: input.mostly(Input::positive),
        },
        2 => Softness::Share(input.mostly(|input| input.positive() / 64.0)),
        _ => Softness::Hard,
    }
}

fn kind(input: &mut Input, n: usize) -> ConstraintKind {
    let softness = softness(input);
    let (min, max) = (input.mostly(Input::ordinary), input.mostly(Input::ordinary));
    let rest = input.mostly(Input::positive);
    let correction = if input.flag() { SizeCorrection::Gradient } else { SizeCorrection::Scaling };
    let corner = |input: &mut Input| {
        let beyond = u32::from(input.rarely(16));
        input.below(n.max(1) as u32 + beyond)
    };
    let count = input.below(5);
    let triangles: Arc<[[u32; 3]]> =
        (0..count).map(|_| [corner(input), corner(input), corner(input)]).collect();
    match input.below(11) {
        0 => ConstraintKind::Angle(Angle { min, max, softness }),
        1 => ConstraintKind::Hinge(Hinge { min, max, softness }),
        2 => ConstraintKind::Cone(Cone { axis: input.vector(), max, softness }),
        3 => ConstraintKind::Area(Area { rest, softness }),
        4 => ConstraintKind::Patch(Patch { triangles, rest, correction, softness }),
        5 => ConstraintKind::Tetrahedron(Tetrahedron { rest: min, softness }),
        6 => ConstraintKind::Volume(Volume { triangles, rest, correction, softness }),
        7 => ConstraintKind::Bend(Bend { weights: [min, max, rest, -rest], rest, softness }),
        8 => ConstraintKind::Coplanar(Coplanar { softness }),
        9 => ConstraintKind::Collinear(Collinear { softness }),
        _ => ConstraintKind::Rigid(Rigid {
            rest: (0..n).map(|_| input.vector()).collect(),
            softness,
        }),
    }
}
