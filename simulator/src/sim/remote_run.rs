//! A run whose robot is in another process: tasks, estimator and collision avoidance run here, the
//! motion there.
//!
//! The only data of the robot are its sensor readings ([`SensorReadings`]). A snapshot therefore
//! contains the estimated state, the measured sole forces, and contact states inferred from these
//! forces and the speeds of the soles. Quantities that only a simulation has (energies,
//! penetrations, steps) are not measured.

use super::actuation::joint_efforts;
use super::event_kind::EventKind;
use super::floor::Floor;
use super::measure::snapshot;
use super::report::{AvoidanceTime, Metrics, Observer, Outcome, SimEvent, Snapshot};
use super::run::run_tasks;
use super::run_error::RunError;
use super::self_collision::SelfCollisionMonitor;
use super::sensing::Estimator;
use super::setup::Setup;
use crate::contact::model::state::SoleState;
use crate::dynamics::State;
use crate::dynamics::chain::FrameMotion;
use crate::geometry::roll_pitch_yaw;
use crate::robot::Model;
use crate::task::server::TickInput;
use crate::task::{AugmentedData, Command, Needs, SensorReadings, TaskServer};
use nalgebra::{Isometry3, Translation3, Vector3};
use std::fmt::Write;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A robot in another process.
pub trait RemoteRobot: Send {
    /// Waits for its next control tick and receives its readings. Returns the tick's number; none
    /// when its run is over.
    ///
    /// # Errors
    /// An error that ends the run.
    fn sense(&mut self, sensed: &mut SensorReadings) -> Result<Option<u64>, RunError>;

    /// Sends the joint commands that hold from `tick` on, and the number of the next tick with a
    /// new command.
    ///
    /// # Errors
    /// An error of the connection.
    fn command(&mut self, tick: u64, command: &Command, next: Option<u64>) -> Result<(), RunError>;

    /// Called when the run has ended. Returns notes for the user.
    fn leave(&mut self) -> Vec<String>;
}

/// A run whose robot is in another process.
pub struct RemoteRun {
    model: Arc<Model>,
    gravity: Vector3<f64>,
    floor: Floor,
    /// Speed below which a sole counts as static, m/s.
    static_speed: f64,
    tasks: TaskServer,
    /// Joint commands after self-collision avoidance.
    safe_command: Command,
    estimator: Estimator,
    self_collision: Option<Box<SelfCollisionMonitor>>,
    data: AugmentedData,
    snapshot: Snapshot,
    metrics: Metrics,
    duration: f64,
    log_rate: f64,
    logged: u64,
    fallen_below: Option<f64>,
    /// Tasks that events end: time, s, and number.
    task_ends: Vec<(f64, usize)>,
    start: State,
}

impl RemoteRun {
    /// Prepares a run. Contact, integration, forces, carried objects, sensors and events of `setup`
    /// belong to the robot's process and are ignored, except for the tasks that events end.
    pub fn new(mut setup: Setup) -> Self {
        let model = setup.model.clone();
        let start = setup.initial_state();
        let mut first = snapshot::blank(&model);
        first.points = snapshot::blank_points(&setup.tasks);
        first.estimate = Some(snapshot::blank_estimate(&model));
        let self_collision = SelfCollisionMonitor::of_run(&mut setup, &start);
        first.self_contact = self_collision.as_ref().map(|monitor| monitor.blank());
        let estimator = Estimator::new(&setup.estimator, &model, setup.imu, setup.gravity);
        if setup.sensors.is_some() || estimator.estimates() {
            setup.tasks.tick_always();
        }
        RemoteRun {
            gravity: setup.gravity,
            static_speed: setup.contact.tolerances.velocity,
            safe_command: setup.tasks.command.clone(),
            data: AugmentedData::new(&model),
            estimator,
            self_collision,
            snapshot: first,
            metrics: Metrics { remote_robot: true, ..Metrics::default() },
            duration: setup.duration,
            log_rate: setup.log_rate,
            logged: 0,
            fallen_below: setup.fallen_below,
            task_ends: setup.events.iter().flat_map(|e| e.end_tasks.iter().map(|task| (e.at, *task))).collect(),
            floor: setup.floor,
            tasks: setup.tasks,
            model,
            start,
        }
    }

    /// Runs to the end of the scenario's duration, or until the robot's side ends.
    pub fn run(
        &mut self,
        robot: &mut dyn RemoteRobot,
        observer: &mut dyn Observer,
        cancel: &AtomicBool,
    ) -> (Outcome, String) {
        let mut sensed = SensorReadings::blank(&self.model);
        let end = self.advance(robot, observer, &mut sensed, cancel);
        self.write_metrics();
        RunError::outcome_of(end, cancel)
    }

    /// The measurements.
    pub fn metrics(&self) -> &Metrics {
        &self.metrics
    }

    /// Processor time of self-collision avoidance, if configured.
    pub fn avoidance_time(&self) -> Option<AvoidanceTime> {
        self.self_collision.as_ref().and_then(|monitor| monitor.avoidance_time())
    }

    fn advance(
        &mut self,
        robot: &mut dyn RemoteRobot,
        observer: &mut dyn Observer,
        sensed: &mut SensorReadings,
        cancel: &AtomicBool,
    ) -> Result<(), RunError> {
        let mut first = true;
        loop {
            if cancel.load(Ordering::Relaxed) {
                return Err(RunError::new(Outcome::Cancelled, "interrupted"));
            }
            let tick = robot.sense(sensed)?;
            if std::mem::take(&mut first) && sensed.base.is_none() {
                // Without a base pose in the readings the robot begins at the start of the
                // scenario.
                sensed.base = Some(FrameMotion::of_base(&self.start));
            }
            self.estimator.update(&self.model, sensed);
            let Some(tick) = tick else {
                self.emit_snapshot(sensed, observer)?;
                let time = sensed.time;
                // The durations of both sides may differ by less than a tick.
                return if time + 0.5 * self.tasks.period() >= self.duration {
                    Ok(())
                } else {
                    Err(RunError::new(
                        Outcome::Error,
                        format!("the robot's process ended its run early, at {time:.6} s"),
                    ))
                };
            };
            if sensed.time >= self.duration {
                self.emit_snapshot(sensed, observer)?;
                return Ok(());
            }
            self.run_tasks(sensed, observer)?;
            robot.command(tick, &self.safe_command, self.tasks.next_number())?;
            if self.log_rate > 0.0 && sensed.time + 1e-9 >= self.logged as f64 / self.log_rate {
                self.emit_snapshot(sensed, observer)?;
                self.logged = (sensed.time * self.log_rate + 1e-9).floor() as u64 + 1;
            }
            self.check_fallen(sensed.time, observer)?;
        }
    }

    fn run_tasks(&mut self, sensed: &SensorReadings, observer: &mut dyn Observer) -> Result<(), RunError> {
        let due = sensed.time + 1e-9 * self.tasks.period();
        self.task_ends.iter().filter(|(at, _)| *at <= due).for_each(|(_, task)| self.tasks.end(*task));
        let input = TickInput {
            model: &self.model,
            gravity: self.gravity,
            floor: self.floor.plane(),
            state: &self.estimator.state,
            sensed,
        };
        let result = run_tasks(&mut self.tasks, &input, observer);
        self.safe_command.copy_from(&self.tasks.command);
        if let Some(monitor) = &mut self.self_collision {
            monitor.avoid(&self.model, &self.estimator.state, &mut self.safe_command);
        }
        result
    }

    /// Emits a snapshot of the present estimate.
    fn emit_snapshot(&mut self, sensed: &SensorReadings, observer: &mut dyn Observer) -> Result<(), RunError> {
        let (state, model) = (&self.estimator.state, &self.model);
        let plane = self.floor.plane();
        let data = &mut self.data;
        data.update(model, state, sensed, &self.gravity, &plane, Needs::ALL);
        let out = &mut self.snapshot;
        out.time = state.time;
        out.base_pose = Isometry3::from_parts(Translation3::from(state.position), state.rotation);
        if model.nb() == 6 {
            out.base_linear_velocity = Vector3::from_column_slice(&state.v[..3]);
            out.base_angular_velocity = Vector3::from_column_slice(&state.v[3..6]);
        }
        out.q.copy_from_slice(&state.joints);
        out.qd.copy_from_slice(&state.v[model.nb()..]);
        out.effort.copy_from_slice(&sensed.load);
        out.q_desired.copy_from_slice(&self.safe_command.position);
        out.qd_desired.copy_from_slice(&self.safe_command.velocity);
        for (j, desired) in out.effort_desired.iter_mut().enumerate() {
            *desired = joint_efforts::desired_effort(j, out.q[j], out.qd[j], &self.safe_command);
        }
        (out.com, out.com_velocity) = (data.com, data.com_velocity);
        (out.centre_of_pressure, out.stable_point) = (data.zmp, data.stable_point);
        out.support_polygon.clear();
        out.support_polygon.extend_from_slice(&data.support_polygon);
        for (s, sole) in out.soles.iter_mut().enumerate() {
            let measured = &data.soles[s];
            sole.clamped.fill(false);
            sole.positions.copy_from_slice(&measured.vertices);
            sole.forces.copy_from_slice(&measured.vertex_forces);
            for contact in data.contacts.iter().filter(|contact| contact.sole == s) {
                contact.vertex.into_iter().for_each(|vertex| sole.clamped[vertex] = true);
            }
            for (i, velocity) in sole.velocities.iter_mut().enumerate() {
                *velocity = Vector3::zeros();
                for (k, v) in state.v.iter().enumerate() {
                    let column = &measured.vertex_jacobians[i][3 * k..3 * k + 3];
                    *velocity += Vector3::new(column[0], column[1], column[2]) * *v;
                }
            }
            let speeds = sole.velocities.iter().zip(&sole.clamped).filter(|(_, clamped)| **clamped);
            let is_static = speeds.map(|(velocity, _)| velocity.norm()).all(|speed| speed <= self.static_speed);
            sole.state.clear();
            let _ = write!(sole.state, "{}", inferred_state(&sole.clamped, is_static));
        }
        for (to, (_, position)) in out.points.iter_mut().zip(self.tasks.points()) {
            to.position = position;
        }
        if let Some(estimate) = &mut out.estimate {
            snapshot::fill_estimate(&self.estimator, sensed, estimate);
        }
        if let (Some(monitor), Some(out)) = (&mut self.self_collision, &mut out.self_contact) {
            monitor.fill(model, state, &data.workspace, out);
        }
        observer.snapshot(out).map_err(RunError::internal)
    }

    fn check_fallen(&mut self, time: f64, observer: &mut dyn Observer) -> Result<(), RunError> {
        let height = self.floor.height(&self.estimator.state.position);
        let Some(below) = self.fallen_below.filter(|below| height < *below) else { return Ok(()) };
        self.metrics.first_fall_s = Some(time);
        let message = format!("base {height:.4} m above the floor at {time:.4} s, below {below} m");
        let event = SimEvent { time, kind: EventKind::Fallen, subject: String::new(), message: message.clone() };
        observer.event(&event).map_err(RunError::internal)?;
        Err(RunError::new(Outcome::Fallen, message))
    }

    fn write_metrics(&mut self) {
        let state = &self.estimator.state;
        let m = &mut self.metrics;
        m.duration_s = state.time;
        m.final_base_position = state.position.into();
        m.final_base_rpy = roll_pitch_yaw(&state.rotation);
        if self.model.nb() == 6 {
            m.final_base_velocity = [state.v[0], state.v[1], state.v[2]];
            m.final_base_angular_velocity = [state.v[3], state.v[4], state.v[5]];
        }
        m.final_base_shift_m = (state.position - self.start.position).norm();
        m.final_com_position = self.data.com.into();
        m.final_com_velocity = self.data.com_velocity.into();
        if let Some(monitor) = &self.self_collision {
            monitor.write_metrics(m);
        }
    }
}

/// Infers the state of a sole from its vertices in contact. Patterns without a state count as the
/// whole face.
fn inferred_state(clamped: &[bool], is_static: bool) -> SoleState {
    let k = clamped.len();
    let matches = |state: &SoleState| clamped.iter().enumerate().all(|(i, clamped)| state.clamps(i, k) == *clamped);
    let mode = |state: &SoleState| state.is_static() == is_static || *state == SoleState::FREE;
    let all = || SoleState::all(k).filter(mode);
    all().find(matches).or_else(|| all().last()).unwrap_or(SoleState::FREE)
}
