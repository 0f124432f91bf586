//! Data computed for tasks from the estimated state and the sensors, each part only when its
//! [`Needs`] flag is set.
//!
//! World axes and SI units unless stated otherwise. Jacobians are stored column by column: a 3 x nv
//! one has entry (row, k) at `3 k + row`, a 6 x nv one at `6 k + row` with the three linear rows
//! first. Columns are the model's velocities ([`crate::robot::model`]): six of a floating base,
//! then the joints.

mod contacts;
mod efforts;
mod end_effectors;
mod links;
mod load_split;
mod mass_center;
mod soles;
mod support;

pub use contacts::{ContactPoint, LIGHT};
pub use end_effectors::EndEffectorData;
pub use soles::SoleData;

use super::{Needs, SensorReadings};
use crate::dynamics::{State, Workspace, crba, kinematics, rnea};
use crate::geometry::Plane;
use crate::robot::Model;
use nalgebra::Vector3;

/// The augmented data. Parts not needed at the last update are stale.
#[derive(Clone, Debug)]
pub struct AugmentedData {
    /// Kinematics at the estimated state ([`Needs::LINKS`]; [`link_pose`](Self::link_pose) reads
    /// it), the mass matrix M in `mass` ([`Needs::MASS`]) and the bias h in `bias`
    /// ([`Needs::BIAS`]): `M vdot + h = tau`.
    pub workspace: Workspace,
    /// Centre of mass, m ([`Needs::COM`]).
    pub com: Vector3<f64>,
    /// Its velocity, m/s ([`Needs::COM`]).
    pub com_velocity: Vector3<f64>,
    /// `com' = J v`, 3 x nv ([`Needs::COM_JACOBIAN`]).
    pub com_jacobian: Vec<f64>,
    /// 3 x nj, no base velocities: `d/dt (R^T (com - p)) = J q'` with p the base's origin and R its
    /// axes: the rate of the centre of mass relative to the base, in base axes
    /// ([`Needs::COM_JACOBIAN_BASE`]).
    pub com_jacobian_base: Vec<f64>,
    /// Generalised force g(q) that compensates gravity, the bias at rest, nv: the force and moment
    /// on a floating base, then the joint efforts, N m or N ([`Needs::GRAVITY`]).
    pub gravity_effort: Vec<f64>,
    /// One entry per sole ([`Needs::SOLES`] and more).
    pub soles: Vec<SoleData>,
    /// One entry per end effector of the robot file ([`Needs::END_EFFECTORS`]).
    pub end_effectors: Vec<EndEffectorData>,
    /// Vertices that stick or slide on the floor, sole by sole ([`Needs::CONTACTS`]).
    pub contacts: Vec<ContactPoint>,
    /// Zero-moment point: point of the floor plane about which the floor's forces have no moment
    /// along the plane, m; none without a load ([`Needs::ZMP`]).
    pub zmp: Option<Vector3<f64>>,
    /// Corners of the convex hull of the contact points seen along the floor's normal,
    /// counter-clockwise, m; one or two for a point or a line, none in flight ([`Needs::SUPPORT`]).
    pub support_polygon: Vec<Vector3<f64>>,
    /// Point of optimal stability of the support polygon, on the floor plane, m
    /// ([`Needs::STABLE_POINT`]); see [`mod@crate::geometry::stable_point`].
    pub stable_point: Option<Vector3<f64>>,
    /// Radius of the largest disc in the support polygon, m ([`Needs::STABLE_POINT`]).
    pub stable_radius: f64,
    gravity: Vector3<f64>,
    splitter: load_split::Splitter,
    edges: Vec<crate::geometry::stable_point::Edge>,
}

/// Contact points on the soles for which there is memory at the start.
pub fn contact_points(model: &Model) -> usize {
    model.soles.iter().map(|sole| sole.vertices.len() + SensorReadings::CORNERS).sum()
}

impl AugmentedData {
    /// Allocates for a robot.
    pub fn new(model: &Model) -> Self {
        let (nv, nj) = (model.nv(), model.nj());
        let points = contact_points(model);
        AugmentedData {
            workspace: Workspace::new(model),
            com: Vector3::zeros(),
            com_velocity: Vector3::zeros(),
            com_jacobian: vec![0.0; 3 * nv],
            com_jacobian_base: vec![0.0; 3 * nj],
            gravity_effort: vec![0.0; nv],
            soles: model.soles.iter().map(|s| SoleData::new(s, nv)).collect(),
            end_effectors: model.end_effectors.iter().map(|_| EndEffectorData::new(nv)).collect(),
            contacts: Vec::with_capacity(points),
            zmp: None,
            support_polygon: Vec::with_capacity(3 * points + 2),
            stable_point: None,
            stable_radius: 0.0,
            gravity: Vector3::zeros(),
            splitter: load_split::Splitter::new(model),
            edges: Vec::with_capacity(2 * points),
        }
    }

    /// Computes the parts in `needs` and those they depend on. `gravity` in m/s^2; `floor` is the
    /// floor plane that the estimator assumes. Allocates nothing.
    pub fn update(
        &mut self,
        model: &Model,
        state: &State,
        sensed: &SensorReadings,
        gravity: &Vector3<f64>,
        floor: &Plane,
        needs: Needs,
    ) {
        if needs == Needs::NONE {
            return;
        }
        self.gravity = *gravity;
        kinematics::update(model, state, &mut self.workspace);
        if needs.intersects(Needs::MASS | Needs::COM_JACOBIAN) {
            crba::mass_matrix(model, &mut self.workspace);
        }
        if needs.contains(Needs::BIAS) {
            rnea::bias(&mut self.workspace, gravity);
        }
        if needs.contains(Needs::COM) {
            self.find_com();
        }
        if needs.contains(Needs::COM_JACOBIAN) {
            self.find_com_jacobian();
        }
        if needs.contains(Needs::COM_JACOBIAN_BASE) {
            self.find_com_jacobian_base();
        }
        if needs.contains(Needs::GRAVITY) {
            self.find_gravity_effort();
        }
        if needs.contains(Needs::SOLES) {
            self.find_soles(model);
        }
        if needs.contains(Needs::SOLE_JACOBIANS) {
            self.find_sole_jacobians(model);
        }
        if needs.contains(Needs::VERTEX_JACOBIANS) {
            self.find_vertex_jacobians(model);
        }
        if needs.contains(Needs::END_EFFECTORS) {
            self.find_end_effectors(model);
        }
        if needs.contains(Needs::CONTACTS) {
            self.find_contacts(sensed, floor);
        }
        if needs.contains(Needs::ZMP) {
            self.find_zmp(sensed, floor);
        }
        if needs.contains(Needs::SUPPORT) {
            self.find_support(floor);
        }
        if needs.contains(Needs::STABLE_POINT) {
            self.find_stable_point(floor);
        }
    }
}
