//! Quantities of single instants for the summary: tipping, impacts, flight, and the final state.
//!
//! ```text
//! flight        c(t) = c0 + c0' t + g t^2 / 2        k_c(t) = k_c(0)
//! first impact  sqrt(T+ / T-), T the kinetic energy: e for a flat fall, omega+ / omega- for a rocking body
//! balance       the weight's line of action meets the floor at the centre of pressure
//! ```

use crate::contact::model::state::{SoleState, States};
use crate::dynamics::body;
use crate::math;
use crate::sim::plant::Plant;
use crate::sim::report::{Metrics, Snapshot};
use nalgebra::{UnitQuaternion, Vector3};

/// Contact states, flight and first impact so far.
#[derive(Clone, Default)]
pub struct Milestones {
    states: Option<States>,
    flight: Option<Flight>,
    /// Time of the first impact and the kinetic energy before it.
    first_impact: Option<(f64, f64)>,
    /// Base position at the start, and its velocity.
    launch: (Vector3<f64>, Vector3<f64>),
    /// Poses of the objects at the start.
    objects: Vec<(Vector3<f64>, UnitQuaternion<f64>)>,
}

/// Start of a flight: the first step end without contact.
#[derive(Clone)]
struct Flight {
    time: f64,
    com: Vector3<f64>,
    velocity: Vector3<f64>,
    /// Angular momentum about the centre of mass.
    spin: Vector3<f64>,
}

impl Milestones {
    /// For a run from the plant's present state.
    pub fn new(plant: &Plant) -> Self {
        let v = &plant.state.v;
        let velocity = if plant.model.nb() == 6 { Vector3::new(v[0], v[1], v[2]) } else { Vector3::zeros() };
        let objects = plant.objects.list.iter().map(|object| (object.state.position, object.state.rotation)).collect();
        Milestones { launch: (plant.state.position, velocity), objects, ..Milestones::default() }
    }

    /// Restarts after a jump of the motion; contact states have jumped too if a state was
    /// `restored`.
    pub fn restart(&mut self, restored: bool) {
        self.flight = None;
        if restored {
            self.states = None;
        }
    }

    /// Continues with other polygons, `number` in all, which have these states; `former` gives the former
    /// index of each that was there before.
    pub fn replace_polygons(&mut self, number: usize, states: &States, former: impl Fn(usize) -> Option<usize>) {
        let Some(before) = &mut self.states else { return };
        let old = std::mem::replace(before, states.clone());
        for s in 0..number {
            if let Some(former) = former(s) {
                before[s] = old[former];
            }
        }
    }

    /// Evaluates the end of a step. Needs kinematics at the plant's state.
    pub fn record_step(&mut self, plant: &Plant, m: &mut Metrics) {
        let soles = plant.problem.soles.len();
        let (states, t) = (&plant.states, plant.state.time);
        if let Some(before) = &self.states {
            let tips = |s: usize| states[s] != SoleState::FREE && states[s].normal_rows() < before[s].normal_rows();
            if (0..soles).any(tips) {
                m.first_tip_s.get_or_insert(t);
            }
        }
        self.states.get_or_insert_default().clone_from(states);
        if plant.model.nb() != 6 {
            return;
        }
        m.max_flight_path_drift_m.get_or_insert(0.0);
        m.max_flight_spin_drift_nms.get_or_insert(0.0);
        // Contacts between objects and the floor are not the robot's.
        let touches = |s: usize| states[s] != SoleState::FREE && plant.reduced.bodies(s).any(|b| b.mechanism == 0);
        if (0..soles).any(touches) {
            self.flight = None;
            return;
        }
        let ws = &plant.ws;
        let (com, spin) = (body::center_of_mass(ws), body::momentum(ws).angular);
        match &self.flight {
            None => {
                let velocity = body::center_of_mass_velocity(ws);
                self.flight = Some(Flight { time: t, com, velocity, spin });
            }
            Some(start) => {
                let t = t - start.time;
                let path = start.com + start.velocity * t + plant.gravity * (0.5 * t * t);
                let greatest =
                    |metric: &mut Option<f64>, drift: f64| *metric = metric.map(|before| math::greater(before, drift));
                greatest(&mut m.max_flight_path_drift_m, (com - path).norm());
                greatest(&mut m.max_flight_spin_drift_nms, (spin - start.spin).norm());
            }
        }
    }

    /// Evaluates an impact at time `t` that dissipated `loss` and left the kinetic energy `after`,
    /// J.
    pub fn record_impact(&mut self, t: f64, after: f64, loss: f64, m: &mut Metrics) {
        let (first, before) = *self.first_impact.get_or_insert((t, after + loss));
        m.last_impact_s = Some(t);
        // Impacts at one instant count as one.
        if t == first && before > 0.0 {
            m.first_impact_speed_ratio = Some((after.max(0.0) / before).sqrt());
        }
    }

    /// Writes the state at the end into the metrics. Needs an evaluation without contact at the
    /// plant's state; the forces are those of the last snapshot if it is of the same instant.
    pub fn write_end(&self, plant: &Plant, last: &Snapshot, m: &mut Metrics) {
        let (is_floating, v) = (plant.model.nb() == 6, &plant.state.v);
        m.final_base_angular_velocity = if is_floating { [v[3], v[4], v[5]] } else { [0.0; 3] };
        let com = body::center_of_mass(&plant.ws);
        m.final_com_position = com.into();
        m.final_com_velocity = body::center_of_mass_velocity(&plant.ws).into();
        let (start, velocity) = self.launch;
        let shift = plant.state.position - start;
        m.final_base_shift_m = shift.norm();
        m.final_base_sideways_m = velocity.try_normalize(0.0).map(|along| (shift - along * along.dot(&shift)).norm());
        for (object, (position, rotation)) in plant.objects.list.iter().zip(&self.objects) {
            let state = &object.state;
            let speed = if object.model.nb() == 6 { Vector3::from_column_slice(&state.v[..3]).norm() } else { 0.0 };
            let greatest =
                |metric: &mut Option<f64>, value: f64| *metric = Some(math::greater(metric.unwrap_or(0.0), value));
            greatest(&mut m.final_object_shift_m, (state.position - position).norm());
            greatest(&mut m.final_object_turn_rad, rotation.angle_to(&state.rotation));
            greatest(&mut m.final_object_speed_m_per_s, speed);
        }
        if last.time != plant.state.time || last.soles.is_empty() {
            return;
        }
        let normal = plant.floor.rotation.column(2).into_owned();
        // Contacts of two moving bodies are internal forces.
        let links = last.links.iter().zip(&plant.polygons[last.soles.len()..]);
        let of_world = links.filter(|(_, polygon)| !polygon.is_between_mechanisms()).map(|((_, link), _)| link);
        let forces = last.soles.iter().chain(of_world).flat_map(|s| &s.forces);
        m.final_normal_force_n = Some(forces.map(|f| f.dot(&normal)).sum());
        let fall = normal.dot(&plant.gravity);
        m.final_cop_offset_m = last.centre_of_pressure.filter(|_| fall != 0.0).map(|cop| {
            let foot = com - plant.gravity * (plant.floor.height(&com) / fall);
            (cop - foot).norm()
        });
    }
}
