//! What the summary tells about single instants of a run: tipping, impacts, flight, and the state at the end.
//!
//! ```text
//! flight        c(t) = c0 + c0' t + g t^2 / 2        k_c(t) = k_c(0)
//! first impact  sqrt(T+ / T-), T the kinetic energy: e for a flat fall, omega+ / omega- for a body that rocks
//! balance       the weight's line of action meets the floor at the centre of pressure
//! ```

use super::simulation::Simulation;
use crate::contact::model::state::{MAX_SOLES, SoleState, States};
use crate::dynamics::body;
use nalgebra::Vector3;

/// What a run remembers between its steps.
#[derive(Default)]
pub struct Marks {
    states: Option<States>,
    flight: Option<Flight>,
    /// Time of the first impact and the kinetic energy before it.
    first_impact: Option<(f64, f64)>,
}

/// The instant at which the robot was first seen without contact.
struct Flight {
    time: f64,
    com: Vector3<f64>,
    velocity: Vector3<f64>,
    /// Angular momentum about the centre of mass.
    spin: Vector3<f64>,
}

impl Marks {
    /// Another flight begins, because something that it rests on has jumped; so have the contact states if the robot is
    /// `elsewhere`.
    pub fn restart(&mut self, elsewhere: bool) {
        self.flight = None;
        self.states = self.states.filter(|_| !elsewhere);
    }
}

impl Simulation {
    /// Looks at the end of a step. Needs kinematics at the plant's state.
    pub(super) fn mark_step(&mut self) {
        let soles = self.plant.problem.soles.len();
        let (states, t) = (self.plant.states, self.plant.state.time);
        if let Some(before) = self.marks.states.replace(states) {
            let tips = |s: usize| states[s] != SoleState::FREE && states[s].normal_rows() < before[s].normal_rows();
            if (0..soles.min(MAX_SOLES)).any(tips) {
                self.metrics.first_tip_s.get_or_insert(t);
            }
        }
        if (0..soles).any(|s| states[s] != SoleState::FREE) {
            self.marks.flight = None;
            return;
        }
        let ws = &self.plant.ws;
        let (com, spin) = (body::center_of_mass(ws), body::momentum(ws).angular);
        match &self.marks.flight {
            None => {
                let velocity = body::center_of_mass_velocity(ws);
                self.marks.flight = Some(Flight { time: t, com, velocity, spin });
            }
            Some(start) => {
                let t = t - start.time;
                let path = start.com + start.velocity * t + self.plant.gravity * (0.5 * t * t);
                let m = &mut self.metrics;
                m.max_flight_path_drift_m = m.max_flight_path_drift_m.max((com - path).norm());
                m.max_flight_spin_drift_nms = m.max_flight_spin_drift_nms.max((spin - start.spin).norm());
            }
        }
    }

    /// Notes an impact that has just taken the kinetic energy `loss`, J, away.
    pub(super) fn mark_impact(&mut self, loss: f64) {
        let (t, after) = (self.plant.state.time, self.plant.kinetic_energy());
        let (first, before) = *self.marks.first_impact.get_or_insert((t, after + loss));
        let m = &mut self.metrics;
        m.last_impact_s = Some(t);
        // Impacts at one instant are one to whoever looks from outside.
        if t == first && before > 0.0 {
            m.first_impact_speed_ratio = Some((after.max(0.0) / before).sqrt());
        }
    }

    /// Fills in what is known at the end. Needs an evaluation without contact at the plant's state; the forces are those
    /// of the last snapshot if that is of the same instant.
    pub(super) fn mark_end(&mut self) {
        let plant = &self.plant;
        let m = &mut self.metrics;
        let (is_floating, v) = (plant.model.nb() == 6, &plant.state.v);
        m.final_base_angular_velocity = if is_floating { [v[3], v[4], v[5]] } else { [0.0; 3] };
        let com = body::center_of_mass(&plant.ws);
        m.final_com_position = com.into();
        m.final_com_velocity = body::center_of_mass_velocity(&plant.ws).into();
        let (start, velocity) = self.launch;
        let shift = plant.state.position - start;
        m.final_base_shift_m = shift.norm();
        m.final_base_sideways_m = velocity.try_normalize(0.0).map(|along| (shift - along * along.dot(&shift)).norm());
        let told = &self.snapshot;
        if told.time != plant.state.time || told.soles.is_empty() {
            return;
        }
        let normal = plant.floor.rotation.column(2).into_owned();
        m.final_normal_force_n = Some(told.soles.iter().flat_map(|s| &s.forces).map(|f| f.dot(&normal)).sum());
        let fall = normal.dot(&plant.gravity);
        m.final_cop_offset_m = told.centre_of_pressure.filter(|_| fall != 0.0).map(|cop| {
            let foot = com - plant.gravity * (plant.floor.height(&com) / fall);
            (cop - foot).norm()
        });
    }
}
