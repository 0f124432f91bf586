//! State of a run without its stepper: plant, contact choice, tasks, sensors and measurements.
//!
//! Steppers and contact states work on this; [`Simulation`](crate::sim::Simulation) owns it
//! together with a stepper.

use super::CommandsAhead;
use crate::contact::model::per_sole::PerSole;
use crate::contact::model::problem::Tolerances;
use crate::contact::model::solution::Solution;
use crate::contact::selection_record::SelectionRecord;
use crate::sim::carried_object::CarriedObjects;
use crate::sim::command_source::CommandSource;
use crate::sim::contact_states::link_contacts::LinkContacts;
use crate::sim::contact_states::pair_contacts::PairContacts;
use crate::sim::event_kind::EventKind;
use crate::sim::floor::SunkLinks;
use crate::sim::measure::energy_balance::EnergyAccount;
use crate::sim::measure::milestones::Milestones;
use crate::sim::measure::residual_maxima::ResidualMaxima;
use crate::sim::measure::sampler::Sampler;
use crate::sim::measure::snapshot::{self, SnapshotLog};
use crate::sim::plant::Plant;
use crate::sim::report::{Metrics, Observer, SimEvent, Snapshot};
use crate::sim::run_error::RunError;
use crate::sim::saved_state::SavedState;
use crate::sim::scenario_event::ScenarioEvent;
use crate::sim::self_collision::SelfCollisionMonitor;
use crate::sim::sensing::{Estimator, Sensors};
use crate::sim::setup::ContactSetup;
use crate::sim::termination::StallGuard;
use crate::task::TaskServer;
use crate::text::length_limit::limit_length;
use nalgebra::Vector3;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Whether a choice of states that finds none near the solved contact problem may be left to
/// velocity-level steps ([`crate::sim::stepper::sliding_mode`]) instead of searching all states.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Deferral {
    /// All states are searched.
    #[default]
    Refused,
    /// The stepper can take velocity-level steps from here.
    Allowed,
    /// The last choice found no state: the stepper must take them.
    Due,
}

/// State of a run without its stepper.
pub struct RunState {
    /// The robot on its floor.
    pub plant: Plant,
    /// Tolerances of contact, narrowed where events are located.
    pub tolerances: Tolerances,
    /// Contact parameters.
    pub contact: ContactSetup,
    /// Tasks.
    pub tasks: TaskServer,
    /// Their commands ahead, if they are computed.
    pub ahead: Option<Box<CommandsAhead>>,
    /// Source of joint commands, if not the tasks.
    pub command_source: Option<Box<dyn CommandSource>>,
    /// Objects that links carry.
    pub carried: CarriedObjects,
    /// Sensors.
    pub sensors: Sensors,
    /// Estimator of the base.
    pub estimator: Estimator,
    /// Monitor of self-collision, if configured.
    pub self_collision: Option<Box<SelfCollisionMonitor>>,
    /// Metrics so far.
    pub metrics: Metrics,
    /// Energies since the start.
    pub energy: EnergyAccount,
    /// Maxima and mean squares of residuals.
    pub residuals: ResidualMaxima,
    /// Instants for the summary.
    pub milestones: Milestones,
    /// Whether a choice of states may be left to velocity-level steps.
    pub deferral: Deferral,
    /// Soles that the last event brought to the limit of their load.
    pub suspect: PerSole<u8>,
    /// Positions of the vertices of each clamped sole when it was clamped, relative to the floor
    /// point, floor axes.
    pub anchors: Vec<Vec<Vector3<f64>>>,
    /// Scratch of projections and impulses.
    pub projection: Solution,
    /// Solution before the present selection.
    pub before_selection: Solution,
    /// Scratch of velocity changes and displacements, nv.
    pub displacement: Vec<f64>,
    /// The contact problem of the present selection, for an observer of problems.
    pub recorded_problem: Option<Box<SelectionRecord>>,
    /// Snapshots for the observer.
    pub log: SnapshotLog,
    /// Sampler at a constant rate, if the observer receives samples.
    pub sampler: Option<Box<Sampler>>,
    /// Have the first contact states been chosen?
    pub started: bool,
    /// Does the stepper work at the velocity level?
    pub velocity_level: bool,
    /// Instants at which a step must end, s, ascending.
    pub corners: Vec<f64>,
    /// Events of the scenario.
    pub events: Vec<ScenarioEvent>,
    /// Number of events applied.
    pub events_done: usize,
    /// States saved by events.
    pub saved: Vec<SavedState>,
    /// End of the run, s.
    pub duration: f64,
    /// Height of the base above the floor below which the robot has fallen, m.
    pub fallen_below: Option<f64>,
    /// Links that touch the floor, if not only soles do.
    pub links: Option<Box<LinkContacts>>,
    /// Pairs of bodies that may touch.
    pub pairs: PairContacts,
    /// Links that end the run when they sink through the floor, if any may.
    pub sunk_links: Option<SunkLinks>,
    /// Time of the last impact faster than the velocity tolerance, s.
    pub last_collision: f64,
    /// Detects a stalled run.
    pub stall_guard: StallGuard,
    /// Ends the run, also within a step, once it is set.
    pub cancel: Option<Arc<AtomicBool>>,
}

impl RunState {
    /// Reports an event.
    pub fn event(
        &mut self,
        observer: &mut dyn Observer,
        kind: EventKind,
        subject: &str,
        message: &str,
    ) -> Result<(), RunError> {
        let time = self.plant.state.time;
        let event = SimEvent { time, kind, subject: subject.to_string(), message: limit_length(message.to_owned()) };
        observer.event(&event).map_err(RunError::internal)
    }

    /// Are events located inside steps?
    pub fn locates_events(&self) -> bool {
        self.contact.locate && self.plant.method.locates_events()
    }

    /// Are the instants located at which vertices enter and leave a compliant floor?
    pub fn locates_surface(&self) -> bool {
        self.contact.locate && self.plant.is_compliant()
    }

    /// Counts an event at the present time.
    pub fn count_event(&mut self) -> Result<(), RunError> {
        self.stall_guard.count(self.plant.state.time)
    }

    /// Measures the end of a step.
    pub fn measure_step(&mut self) {
        self.milestones.record_step(&self.plant, &mut self.metrics);
        self.residuals.record_step(&mut self.plant, self.tolerances.distance);
        if self.plant.has_conditions() {
            let error = self.plant.condition_error();
            self.metrics.max_loop_error_m = Some(self.metrics.max_loop_error_m.unwrap_or(0.0).max(error));
        }
    }

    /// Measures the error of the energy balance at the plant's present state, which must be
    /// evaluated.
    pub fn measure_energy(&mut self) {
        let error = self.energy.balance(&self.plant).error();
        self.residuals.record_energy_error(self.plant.state.time, error);
    }

    /// Time of the next sample before the end, s.
    pub fn next_sample(&self) -> Option<f64> {
        self.sampler.as_ref()?.next()
    }

    /// Samples the plant's present state; needs an evaluation at it.
    pub fn sample_state(&mut self, observer: &mut dyn Observer) -> Result<(), RunError> {
        self.sampler.as_mut().map_or(Ok(()), |sampler| sampler.sample_state(&self.plant, observer))
    }

    /// Emits a snapshot of the plant's present state; needs an evaluation at it.
    pub fn emit_snapshot(&mut self, observer: &mut dyn Observer) -> Result<(), RunError> {
        if !self.log.begin(self.plant.state.time) {
            // A fixed step that ends the run, or spans several instants of the log, is logged once.
            return Ok(());
        }
        let mut snapshot = std::mem::take(&mut self.log.snapshot);
        self.fill_snapshot(&mut snapshot);
        self.log.snapshot = snapshot;
        observer.snapshot(&self.log.snapshot).map_err(RunError::internal)
    }

    /// Emits the snapshots due up to `t`; fixed steps log the first state at or after the instant.
    pub fn emit_due_snapshots(&mut self, t: f64, observer: &mut dyn Observer) -> Result<(), RunError> {
        while self.log.next().is_some_and(|due| due <= t + 1e-12) {
            self.emit_snapshot(observer)?;
        }
        Ok(())
    }

    /// Emits the last instant of a run of velocity-level steps, with the forces of the last step.
    pub fn emit_last_step(&mut self, observer: &mut dyn Observer) -> Result<(), RunError> {
        if self.velocity_level { self.emit_snapshot(observer) } else { Ok(()) }
    }

    /// Fills a snapshot with the plant's last evaluation and the tasks' points.
    pub fn fill_snapshot(&mut self, out: &mut Snapshot) {
        snapshot::fill(&mut self.plant, &mut self.log.edges, out);
        out.energy = self.energy.balance(&self.plant);
        for (to, (_, position)) in out.points.iter_mut().zip(self.tasks.points()) {
            to.position = position;
        }
        if let (Some(monitor), Some(out)) = (&mut self.self_collision, &mut out.self_contact) {
            monitor.fill(&self.plant.model, &self.plant.state, &self.plant.ws, out);
        }
    }
}
