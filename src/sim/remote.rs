//! A run whose robot is somewhere else: tasks, estimator and avoidance of collisions here, motion and contact there.
//!
//! All that is known of the robot is what its sensors say ([`Sensed`]), so a snapshot shows the estimated state, the forces that the
//! soles feel, and contact states that these forces and the speeds of the soles suggest. What only a simulation knows (energies,
//! penetrations, steps) is not measured.

use super::error::Stop;
use super::estimate::Estimator;
use super::observe;
use super::report::{AvoidanceTime, Metrics, Observer, Outcome, SimEvent, Snapshot};
use super::self_contact::SelfContact;
use super::setup::{Floor, Setup};
use crate::contact::model::state::SoleState;
use crate::dynamics::State;
use crate::dynamics::chain::FrameMotion;
use crate::robot::Model;
use crate::task::server::TickInput;
use crate::task::{Augmented, Command, Needs, Sensed, TaskServer};
use nalgebra::{Isometry3, Translation3, Vector3};
use std::fmt::Write;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A robot that is not simulated by this run.
pub trait Robot: Send {
    /// Waits for its next control tick and takes its readings; gives the tick's number, none when it is all over there.
    ///
    /// # Errors
    /// What ends the run.
    fn sense(&mut self, sensed: &mut Sensed) -> Result<Option<u64>, Stop>;

    /// What its joints are asked from that tick on, and the number of the next tick at which there is something to decide.
    fn answer(&mut self, tick: u64, command: &Command, next: Option<u64>) -> Result<(), Stop>;

    /// Nothing more is asked. Gives what there is to tell a person.
    fn leave(&mut self) -> Vec<String>;
}

/// What a snapshot of such a run is made of.
const SHOWN: Needs = Needs::ALL;

/// See the module.
pub struct RemoteRun {
    model: Arc<Model>,
    gravity: Vector3<f64>,
    floor: Floor,
    /// Slower than this a sole counts as resting, m/s.
    slow: f64,
    tasks: TaskServer,
    /// What the joints are asked when no body may touch another.
    safe: Command,
    estimator: Estimator,
    self_contact: Option<Box<SelfContact>>,
    data: Augmented,
    snapshot: Snapshot,
    metrics: Metrics,
    duration: f64,
    log_rate: f64,
    logged: u64,
    fallen_below: Option<f64>,
    /// Tasks that events end: when, s, and which.
    ends: Vec<(f64, usize)>,
    start: State,
}

impl RemoteRun {
    /// Prepares a run; what `setup` says about contact, integration, forces, loads, sensors and events is of the robot's side, but for the
    /// tasks that events end.
    pub fn new(mut setup: Setup) -> Self {
        let model = setup.model.clone();
        let mut start = State::home(&model);
        (start.position, start.rotation) = (setup.start.position, setup.start.rotation);
        start.joints.copy_from_slice(&setup.start.joints);
        start.v.copy_from_slice(&setup.start.v);
        let mut snapshot = observe::blank(&model);
        snapshot.points = observe::blank_points(&setup.tasks);
        snapshot.estimate = Some(observe::blank_estimate(&model));
        let self_contact = setup.self_contact.take().map(|own| {
            if own.avoid.is_some() {
                setup.tasks.tick_always();
            }
            Box::new(SelfContact::new(own, &model, &setup.tasks.command, &start, setup.tasks.period()))
        });
        snapshot.self_contact = self_contact.as_ref().map(|own| own.blank());
        let estimator = Estimator::new(&setup.estimator, &model, setup.imu, setup.gravity);
        if setup.sensors.is_some() || estimator.estimates() {
            setup.tasks.tick_always();
        }
        RemoteRun {
            gravity: setup.gravity,
            slow: setup.contact.tolerances.velocity,
            safe: setup.tasks.command.clone(),
            data: Augmented::new(&model),
            estimator,
            self_contact,
            snapshot,
            metrics: Metrics { remote_robot: true, ..Metrics::default() },
            duration: setup.duration,
            log_rate: setup.log_rate,
            logged: 0,
            fallen_below: setup.fallen_below,
            ends: setup.changes.iter().flat_map(|c| c.end_tasks.iter().map(|task| (c.at, *task))).collect(),
            floor: setup.floor,
            tasks: setup.tasks,
            model,
            start,
        }
    }

    /// Runs to the end of the scenario's duration, or until the robot's side ends.
    pub fn run(
        &mut self,
        robot: &mut dyn Robot,
        observer: &mut dyn Observer,
        cancel: &AtomicBool,
    ) -> (Outcome, String) {
        let mut sensed = Sensed::blank(&self.model);
        let end = self.advance(robot, observer, &mut sensed, cancel);
        self.sum_up();
        Stop::outcome_of(end, cancel)
    }

    /// What was measured.
    pub fn metrics(&self) -> &Metrics {
        &self.metrics
    }

    /// Processor time that avoidance of self-collision took; none without.
    pub fn avoidance_time(&self) -> Option<AvoidanceTime> {
        self.self_contact.as_ref().and_then(|own| own.spent())
    }

    fn advance(
        &mut self,
        robot: &mut dyn Robot,
        observer: &mut dyn Observer,
        sensed: &mut Sensed,
        cancel: &AtomicBool,
    ) -> Result<(), Stop> {
        let mut first = true;
        loop {
            if cancel.load(Ordering::Relaxed) {
                return Err(Stop::new(Outcome::Cancelled, "interrupted"));
            }
            let tick = robot.sense(sensed)?;
            if std::mem::take(&mut first) && sensed.base.is_none() {
                // Nobody there sees the robot from outside: it begins where the scenario puts it.
                sensed.base = Some(FrameMotion::of_base(&self.start));
            }
            let Some(tick) = tick else {
                self.look(sensed);
                self.show(sensed, observer)?;
                let time = sensed.time;
                // The two durations may differ; a tick is the smallest difference.
                return if time + 0.5 * self.tasks.period() >= self.duration {
                    Ok(())
                } else {
                    Err(Stop::new(Outcome::Error, format!("the robot's side ended at {time:.6} s")))
                };
            };
            self.look(sensed);
            if sensed.time >= self.duration {
                self.show(sensed, observer)?;
                return Ok(());
            }
            self.decide(sensed, observer)?;
            robot.answer(tick, &self.safe, self.tasks.next_number())?;
            if self.log_rate > 0.0 && sensed.time + 1e-9 >= self.logged as f64 / self.log_rate {
                self.show(sensed, observer)?;
                self.logged = (sensed.time * self.log_rate + 1e-9).floor() as u64 + 1;
            }
            self.check_fallen(sensed.time, observer)?;
        }
    }

    /// Takes the readings of a tick.
    fn look(&mut self, sensed: &Sensed) {
        self.estimator.update(&self.model, sensed);
    }

    fn decide(&mut self, sensed: &Sensed, observer: &mut dyn Observer) -> Result<(), Stop> {
        let time = sensed.time;
        let due = time + 1e-9 * self.tasks.period();
        self.ends.iter().filter(|(at, _)| *at <= due).for_each(|(_, task)| self.tasks.end(*task));
        let situation = TickInput {
            model: &self.model,
            gravity: self.gravity,
            floor: self.floor.plane(),
            state: &self.estimator.state,
            sensed,
        };
        let mut failure = None;
        let ran = self.tasks.run(&situation, |what, name| {
            let message = format!("task {name} {what}");
            let event = SimEvent { time, kind: "task", subject: name.to_string(), message };
            failure = observer.event(&event).err().or(failure.take());
        });
        self.safe.copy_from(&self.tasks.command);
        if let Some(own) = &mut self.self_contact {
            own.avoid(&self.model, &self.estimator.state, &mut self.safe);
        }
        failure.map_or(ran.map_err(|e| e.to_string()), Err).map_err(|m| Stop::new(Outcome::Error, m))
    }

    /// Tells the observer what is known now.
    fn show(&mut self, sensed: &Sensed, observer: &mut dyn Observer) -> Result<(), Stop> {
        let (state, model) = (&self.estimator.state, &self.model);
        let plane = self.floor.plane();
        let data = &mut self.data;
        data.update(model, state, sensed, &self.gravity, &plane, SHOWN);
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
        out.q_desired.copy_from_slice(&self.safe.position);
        out.qd_desired.copy_from_slice(&self.safe.velocity);
        for (j, wanted) in out.effort_desired.iter_mut().enumerate() {
            *wanted = super::actuator::wanted(j, out.q[j], out.qd[j], &self.safe);
        }
        for (link, pose) in out.link_poses.iter_mut().enumerate() {
            *pose = data.link_pose(model, crate::robot::LinkId(link));
        }
        (out.com, out.com_velocity) = (data.com, data.com_velocity);
        (out.centre_of_pressure, out.stable_point) = (data.zmp, data.stable_point);
        out.support_polygon.clear();
        out.support_polygon.extend_from_slice(&data.support_polygon);
        for (s, sole) in out.soles.iter_mut().enumerate() {
            let seen = &data.soles[s];
            sole.clamped.fill(false);
            sole.positions.copy_from_slice(&seen.vertices);
            sole.forces.copy_from_slice(&seen.vertex_forces);
            for contact in data.contacts.iter().filter(|contact| contact.sole == s) {
                sole.clamped[contact.vertex] = true;
            }
            for (i, velocity) in sole.velocities.iter_mut().enumerate() {
                *velocity = Vector3::zeros();
                for (k, v) in state.v.iter().enumerate() {
                    let column = &seen.vertex_jacobians[i][3 * k..3 * k + 3];
                    *velocity += Vector3::new(column[0], column[1], column[2]) * *v;
                }
            }
            let speeds = sole.velocities.iter().zip(&sole.clamped).filter(|(_, clamped)| **clamped);
            let rests = speeds.map(|(velocity, _)| velocity.norm()).all(|speed| speed <= self.slow);
            sole.state.clear();
            let _ = write!(sole.state, "{}", suggested(&sole.clamped, rests));
        }
        for (to, (_, position)) in out.points.iter_mut().zip(self.tasks.points()) {
            to.position = position;
        }
        if let Some(estimate) = &mut out.estimate {
            observe::fill_estimate(&self.estimator, sensed, estimate);
        }
        if let (Some(own), Some(out)) = (&mut self.self_contact, &mut out.self_contact) {
            own.fill(model, state, &data.workspace, out);
        }
        observer.snapshot(out).map_err(|m| Stop::new(Outcome::Error, m))
    }

    fn check_fallen(&mut self, time: f64, observer: &mut dyn Observer) -> Result<(), Stop> {
        let height = self.floor.height(&self.estimator.state.position);
        let Some(below) = self.fallen_below.filter(|below| height < *below) else { return Ok(()) };
        self.metrics.first_fall_s = Some(time);
        let message = format!("base {height:.4} m above the floor at {time:.4} s, below {below} m");
        let event = SimEvent { time, kind: "fallen", subject: String::new(), message: message.clone() };
        observer.event(&event).map_err(|m| Stop::new(Outcome::Error, m))?;
        Err(Stop::new(Outcome::Fallen, message))
    }

    fn sum_up(&mut self) {
        let state = &self.estimator.state;
        let m = &mut self.metrics;
        m.duration_s = state.time;
        m.final_base_position = state.position.into();
        let (roll, pitch, yaw) = state.rotation.euler_angles();
        m.final_base_rpy = [roll, pitch, yaw];
        if self.model.nb() == 6 {
            m.final_base_velocity = [state.v[0], state.v[1], state.v[2]];
            m.final_base_angular_velocity = [state.v[3], state.v[4], state.v[5]];
        }
        m.final_base_shift_m = (state.position - self.start.position).norm();
        m.final_com_position = self.data.com.into();
        m.final_com_velocity = self.data.com_velocity.into();
        if let Some(own) = &self.self_contact {
            own.sum_up(m);
        }
    }
}

/// The state of a sole whose vertices in contact are known; of patterns that no state has, that of the whole face.
fn suggested(clamped: &[bool], rests: bool) -> SoleState {
    let k = clamped.len();
    let fits = |state: &SoleState| clamped.iter().enumerate().all(|(i, clamped)| state.clamps(i, k) == *clamped);
    let mode = |state: &SoleState| state.is_static() == rests || *state == SoleState::FREE;
    let all = || SoleState::all(k).filter(mode);
    all().find(fits).or_else(|| all().last()).unwrap_or(SoleState::FREE)
}
