//! Checkpoints: the state of a run between two steps, to which the run can return.
//!
//! Unlike the states that scenario events save, a checkpoint includes time, commands, stepper and
//! measurements: the steps after a return give the bits of those after the checkpoint. It excludes
//! what cannot be copied, such as the variables of scripts; runs that depend on it are refused. What
//! a task remembers is included if it can be saved ([`crate::task::Task::save`]).

use super::contact_states::link_contacts::LinkContacts;
use super::contact_states::pair_contacts::PairContacts;
use super::measure::energy_balance::EnergyAccount;
use super::measure::milestones::Milestones;
use super::measure::residual_maxima::ResidualMaxima;
use super::measure::snapshot::SnapshotLog;
use super::plant::Plant;
use super::report::{Metrics, Outcome};
use super::run::RunState;
use super::run_error::RunError;
use super::simulation::Simulation;
use super::stepper::Stepper;
use super::termination::StallGuard;
use crate::contact::model::per_sole::PerSole;
use crate::contact::model::solution::Solution;
use crate::dynamics::State;
use crate::task::server::TaskProgress;
use nalgebra::Vector3;

/// State of a run between two steps; see [`Simulation::checkpoint`].
pub struct Checkpoint {
    /// Without forces.
    plant: Plant,
    stepper: Stepper,
    tasks: TaskProgress,
    links: Option<Box<LinkContacts>>,
    pairs: PairContacts,
    contact: ContactMemory,
    measured: Measured,
    /// Number of scenario events applied.
    events_done: usize,
    stall_guard: StallGuard,
}

/// What the choice of contact states remembers.
#[derive(Clone)]
struct ContactMemory {
    suspect: PerSole<u8>,
    anchors: Vec<Vec<Vector3<f64>>>,
    projection: Solution,
    before_selection: Solution,
    last_collision: f64,
}

/// Measurements of a run.
#[derive(Clone)]
struct Measured {
    metrics: Metrics,
    energy: EnergyAccount,
    residuals: ResidualMaxima,
    milestones: Milestones,
    log: SnapshotLog,
}

impl Checkpoint {
    /// Simulated time, s.
    pub fn time(&self) -> f64 {
        self.plant.state.time
    }

    /// Whether a run has the same robot and objects.
    fn fits(&self, run: &RunState) -> bool {
        let size = |state: &State| (state.joints.len(), state.v.len(), state.actuators.len());
        let all = |plant: &Plant| {
            let objects = plant.objects.list.iter().map(|object| &object.state);
            std::iter::once(&plant.state).chain(objects).map(size).collect::<Vec<_>>()
        };
        all(&self.plant) == all(&run.plant)
    }
}

impl Simulation {
    /// The present state, to which [`return_to`](Self::return_to) goes back. The run must have begun
    /// and not ended early.
    ///
    /// # Errors
    /// The run depends on something that a checkpoint does not include, which the message names.
    pub fn checkpoint(&self) -> Result<Checkpoint, RunError> {
        let run = &self.run;
        check(run)?;
        Ok(Checkpoint {
            plant: run.plant.copy_without_forces(&*run.contact.method),
            stepper: self.stepper.clone(),
            tasks: run.tasks.progress(),
            links: run.links.clone(),
            pairs: run.pairs.clone(),
            contact: ContactMemory {
                suspect: run.suspect.clone(),
                anchors: run.anchors.clone(),
                projection: run.projection.clone(),
                before_selection: run.before_selection.clone(),
                last_collision: run.last_collision,
            },
            measured: Measured {
                metrics: run.metrics.clone(),
                energy: run.energy,
                residuals: run.residuals.clone(),
                milestones: run.milestones.clone(),
                log: run.log.clone(),
            },
            events_done: run.events_done,
            stall_guard: run.stall_guard,
        })
    }

    /// Returns to a checkpoint of this run, also after it ended. Events of forces that were reported
    /// since are not reported again.
    ///
    /// # Errors
    /// The checkpoint belongs to another run, or events of the scenario, or tasks with memory that cannot
    /// be saved, were executed since; the state is then unchanged.
    pub fn return_to(&mut self, checkpoint: &Checkpoint) -> Result<(), RunError> {
        let run = &mut self.run;
        check(run)?;
        if !checkpoint.fits(run) {
            return Err(refused("the checkpoint belongs to a robot or objects of another run"));
        }
        if run.events_done != checkpoint.events_done {
            return Err(refused("an event of the scenario happened since the checkpoint"));
        }
        let tasks = run.tasks.return_to(&checkpoint.tasks);
        tasks.map_err(|task| refused(format!("task `{task}` depends on its earlier calls")))?;
        let forces = std::mem::take(&mut run.plant.forces);
        run.plant = checkpoint.plant.copy_without_forces(&*run.contact.method);
        run.plant.forces = forces;
        run.links = checkpoint.links.clone();
        run.pairs = checkpoint.pairs.clone();
        let contact = checkpoint.contact.clone();
        (run.suspect, run.anchors) = (contact.suspect, contact.anchors);
        (run.projection, run.before_selection) = (contact.projection, contact.before_selection);
        run.last_collision = contact.last_collision;
        let measured = checkpoint.measured.clone();
        (run.metrics, run.energy, run.residuals) = (measured.metrics, measured.energy, measured.residuals);
        (run.milestones, run.log) = (measured.milestones, measured.log);
        run.stall_guard = checkpoint.stall_guard;
        run.started = true;
        self.stepper = checkpoint.stepper.clone();
        Ok(())
    }
}

fn refused(why: impl Into<String>) -> RunError {
    RunError::new(Outcome::Error, why)
}

/// Refuses runs whose steps depend on state outside of a checkpoint.
fn check(run: &RunState) -> Result<(), RunError> {
    let cause = if run.command_source.is_some() {
        "the joint commands of another process"
    } else if run.log.snapshot.estimate.is_some() || run.estimator.estimates() {
        "errors of sensors or an estimator"
    } else if run.self_collision.is_some() {
        "the monitor of self-collision"
    } else if run.carried.count() > 0 {
        "carried objects"
    } else if run.sampler.is_some() {
        "samples for a comparison"
    } else if run.plant.forces.iter().any(|force| force.has_memory()) {
        "a force with memory, such as a script"
    } else {
        return Ok(());
    };
    Err(refused(format!("a checkpoint does not include {cause}")))
}
