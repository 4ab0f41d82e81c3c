//! Shapes whose nearest point has a closed form, for kernels that test eight points at a time with the same formulas as for one.

use glam::Vec3;

use super::convex::NearestOf;
use super::flat::Cuboid;
use super::round::{Ball, Capsule, Cylinder};
use super::{Form, Shape};
use crate::lanes::{Number, Vector};

/// A shape with a closed form.
#[derive(Clone, Copy, Debug)]
pub(crate) enum ClosedForm {
    HalfSpace,
    Ball(Ball),
    Capsule(Capsule),
    Cuboid(Cuboid),
    Cylinder(Cylinder),
}

impl Shape {
    /// Its closed form, if it has one.
    pub(crate) fn closed_form(&self) -> Option<ClosedForm> {
        match &self.form {
            Form::HalfSpace => Some(ClosedForm::HalfSpace),
            Form::Ball(ball) => Some(ClosedForm::Ball(*ball)),
            Form::Capsule(capsule) => Some(ClosedForm::Capsule(*capsule)),
            Form::Cuboid(cuboid) => Some(ClosedForm::Cuboid(*cuboid)),
            Form::Cylinder(cylinder) => Some(ClosedForm::Cylinder(*cylinder)),
            Form::InsideBox(_) | Form::Hull(_) | Form::Mesh(_) | Form::Heights(_) => None,
        }
    }
}

impl ClosedForm {
    /// The nearest surface point of one point, or of each of eight, in the frame of the shape.
    #[inline(always)]
    pub(crate) fn nearest<N: Number>(&self, p: Vector<N>) -> NearestOf<N> {
        match self {
            Self::HalfSpace => NearestOf {
                point: Vector::new(p.x, N::zero(), p.z),
                normal: Vector::splat(Vec3::Y),
                distance: p.y,
            },
            Self::Ball(ball) => ball.nearest_of(p),
            Self::Capsule(capsule) => capsule.nearest_of(p),
            Self::Cuboid(cuboid) => cuboid.nearest_of(p),
            Self::Cylinder(cylinder) => cylinder.nearest_of(p),
        }
    }
}
