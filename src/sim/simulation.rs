//! One run from start to end.

use super::change::{Change, Saved};
use super::commander::Commander;
use super::error::Stop;
use super::estimate::Estimator;
use super::explicit::{Explicit, Sizes};
use super::fixed::Fixed;
use super::impulse::Impulses;
use super::ledger::Flows;
use super::loads::Loads;
use super::marks::Marks;
use super::measure::Tally;
use super::plant::{Plant, load_scale};
use super::report::{Metrics, Observer, Outcome, SimEvent, Snapshot};
use super::sample::Sampler;
use super::self_contact::SelfContact;
use super::sensors::Sensors;
use super::setup::{ContactSetup, IntegratorSetup, Setup};
use crate::contact::methods::contact_method::Scheme;
use crate::contact::model::problem::{Problem, Tolerances};
use crate::contact::model::solution::Solution;
use crate::contact::model::state::MAX_SOLES;
use crate::contact::selection_record::SelectionRecord;
use crate::geometry::stable_point::Edge;
use crate::integrate::StepControl;
use crate::task::TaskServer;
use nalgebra::Vector3;
use std::sync::atomic::{AtomicBool, Ordering};

enum Stepper {
    Explicit(Box<Explicit>),
    Fixed(Box<Fixed>),
}

/// What may have jumped at the start of a step.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Jump {
    /// Nothing.
    None,
    /// What the joints are asked, or a prescribed acceleration.
    Tick,
    /// A force, or which states are imposed.
    Corner,
}

/// A run: owns its state, couples the rooms.
pub struct Simulation {
    pub(super) plant: Plant,
    pub(super) tolerances: Tolerances,
    pub(super) contact: ContactSetup,
    pub(super) tasks: TaskServer,
    pub(super) commander: Option<Box<dyn Commander>>,
    /// What the run has to tell a person at its end.
    notes: Vec<String>,
    pub(super) loads: Loads,
    pub(super) sensors: Sensors,
    pub(super) estimator: Estimator,
    /// None when nobody asks.
    pub(super) self_contact: Option<Box<SelfContact>>,
    pub(super) metrics: Metrics,
    /// Work of velocity jumps since the start, J: impacts, jams, and what a new contact state ends.
    pub(super) work: f64,
    /// Energies that flowed since the start.
    pub(super) flows: Flows,
    pub(super) tally: Tally,
    /// Soles that the last event put at the limit of their load.
    pub(super) suspect: [u8; MAX_SOLES],
    /// Where the vertices of each clamped sole were when it was clamped, relative to the floor point, floor axes.
    pub(super) anchors: Vec<Vec<Vector3<f64>>>,
    pub(super) projection: Solution,
    /// The selection at hand, for an observer that wants to hear of it.
    pub(super) frozen: Option<Box<SelectionRecord>>,
    pub(super) displacement: Vec<f64>,
    pub(super) snapshot: Snapshot,
    /// Scratch of the snapshot's point of optimal stability.
    pub(super) edges: Vec<Edge>,
    /// None when nobody wants samples.
    pub(super) sampler: Option<Box<Sampler>>,
    /// Has the first choice of states been made?
    pub(super) started: bool,
    pub(super) corners: Vec<f64>,
    /// Events of the scenario, and how many of them have happened.
    pub(super) changes: Vec<Change>,
    pub(super) happened: usize,
    /// States saved by events.
    pub(super) saved: Vec<Saved>,
    stepper: Option<Stepper>,
    pub(super) duration: f64,
    log_rate: f64,
    logged: u64,
    /// Time of the last snapshot told, s.
    told: Option<f64>,
    pub(super) fallen_below: Option<f64>,
    pub(super) start_energy: f64,
    pub(super) marks: Marks,
    /// Base position at the start, and its velocity.
    pub(super) launch: (Vector3<f64>, Vector3<f64>),
    /// Events counted since a time, s: within about a second, and at one instant.
    pub(super) window: (f64, u64),
    pub(super) in_place: (f64, u64),
}

impl Simulation {
    /// Prepares a run. Fails on what the physics rooms cannot do.
    pub fn new(mut setup: Setup) -> Result<Self, Stop> {
        let model = setup.model.clone();
        let error = |m: String| Stop::new(Outcome::Error, m);
        if model.soles.len() > MAX_SOLES {
            return Err(error(format!("{} soles, at most {MAX_SOLES} are supported", model.soles.len())));
        }
        if let Some(s) = model.soles.iter().find(|s| s.vertices.is_empty() || s.vertices.len() > 64) {
            return Err(error(format!("sole `{}` has {} vertices, 1 to 64 are supported", s.name, s.vertices.len())));
        }
        let mut problem = Problem::new(&model.soles.iter().map(|s| s.vertices.len()).collect::<Vec<_>>());
        for (sole, geometry) in problem.soles.iter_mut().zip(&model.soles) {
            let centre = geometry.vertices.iter().sum::<Vector3<f64>>() / geometry.vertices.len() as f64;
            let reach = geometry.vertices.iter().map(|v| (v - centre).norm()).fold(0.0, f64::max);
            sole.radius = if reach > 0.0 { reach } else { 1.0 };
            sole.body = geometry.link.0;
            for v in &mut sole.vertices {
                (v.mu_s, v.mu_k) = (setup.floor.mu_s, setup.floor.mu_k);
            }
        }
        problem.scale = load_scale(&model, &setup.gravity);
        let method = setup.contact.method.solver(&problem);
        let projection = Solution::new(&problem);
        let corners = setup.corners();
        let mut plant = Plant::new(&mut setup, method, problem);
        let loads = Loads::new(&model, std::mem::take(&mut setup.loads));
        let n = plant.layout.size();
        let stepper = match setup.integrator {
            IntegratorSetup::Controlled { pair, relative, absolute, max_step } => {
                let control = StepControl::new(pair.order);
                let sizes = Sizes::Controlled { control, relative, absolute, max_step, h: max_step.min(1e-3) };
                Stepper::Explicit(Box::new(Explicit::new(pair, n, sizes)))
            }
            IntegratorSetup::Stepped { method, step } => {
                Stepper::Explicit(Box::new(Explicit::new(method, n, Sizes::Fixed(step))))
            }
            IntegratorSetup::SemiImplicit { step } => Stepper::Fixed(Box::new(Fixed::new(step))),
        };
        let mut tolerances = setup.contact.tolerances;
        if setup.contact.locate && plant.method.locates_events() {
            tolerances = tolerances.with_located_events();
        }
        let sensors = Sensors::new(&plant, setup.sensors, setup.imu, setup.tasks.period(), setup.seed);
        let estimator = Estimator::new(&setup.estimator, &model, setup.imu, setup.gravity);
        if estimator.adds_forces() || setup.commander.is_some() {
            plant.impulses = Some(Impulses::new(model.soles.len()));
        }
        let mut snapshot = super::observe::blank(&model);
        snapshot.external.reserve(plant.arrows.capacity());
        snapshot.points = super::observe::blank_points(&setup.tasks);
        if setup.sensors.is_some() || estimator.estimates() {
            setup.tasks.tick_always();
            snapshot.estimate = Some(super::observe::blank_estimate(&model));
        }
        let self_contact = setup.self_contact.take().map(|own| {
            if own.avoid.is_some() {
                setup.tasks.tick_always();
            }
            let (command, period) = (&setup.tasks.command, setup.tasks.period());
            Box::new(SelfContact::new(own, &model, command, &plant.state, period))
        });
        snapshot.self_contact = self_contact.as_ref().map(|own| own.blank());
        let v = &plant.state.v;
        let launch = if model.nb() == 6 { Vector3::new(v[0], v[1], v[2]) } else { Vector3::zeros() };
        let mut sim = Simulation {
            tolerances,
            contact: setup.contact,
            tasks: setup.tasks,
            commander: setup.commander,
            notes: Vec::new(),
            loads,
            sensors,
            estimator,
            self_contact,
            metrics: Metrics::at_start(),
            work: 0.0,
            flows: Flows::default(),
            tally: Tally::default(),
            suspect: [0; MAX_SOLES],
            anchors: model.soles.iter().map(|s| vec![Vector3::zeros(); s.vertices.len()]).collect(),
            projection,
            frozen: None,
            displacement: vec![0.0; model.nv()],
            snapshot,
            edges: Vec::new(),
            sampler: None,
            started: false,
            corners,
            saved: Vec::new(),
            changes: setup.changes,
            happened: 0,
            stepper: Some(stepper),
            duration: setup.duration,
            log_rate: setup.log_rate,
            logged: 0,
            told: None,
            fallen_below: setup.fallen_below,
            marks: Marks::default(),
            launch: (plant.state.position, launch),
            start_energy: 0.0,
            window: (0.0, 0),
            in_place: (-1.0, 0),
            plant,
        };
        sim.plant.evaluate_free();
        sim.start_energy = sim.plant.energy();
        sim.saved = vec![Saved::new(&sim.plant, &sim.anchors); setup.saved_states];
        Ok(sim)
    }

    /// Runs to the end. `cancel` ends it at the next step with outcome `cancelled`.
    pub fn run(&mut self, observer: &mut dyn Observer, cancel: &AtomicBool) -> (Outcome, String) {
        let end = self.advance(observer, cancel);
        let end = end.and_then(|()| self.finish(observer));
        self.notes.extend(self.commander.iter_mut().flat_map(|commander| commander.leave()));
        self.sum_up();
        Stop::outcome_of(end, cancel)
    }

    /// What was measured so far.
    pub fn metrics(&self) -> &Metrics {
        &self.metrics
    }

    /// What else there is to tell a person after the end.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// The plant at its present state.
    pub fn plant(&self) -> &Plant {
        &self.plant
    }

    /// Prepares the first step; [`run`](Self::run) does it by itself.
    pub fn begin(&mut self, observer: &mut dyn Observer) -> Result<(), Stop> {
        let rate = observer.sample_rate();
        self.sampler = (rate > 0.0).then(|| Box::new(Sampler::new(rate, self.duration, &self.plant.state)));
        self.init_forces()?;
        self.happen(observer)?;
        self.pass_forces(observer)?;
        self.pass_loads(observer)?;
        self.run_tasks(observer)?;
        self.plant.fill_actuators();
        self.plant.within = 0.0;
        self.tell_imposed(observer)?;
        let mut stepper = self.stepper.take();
        let begun = match &mut stepper {
            Some(Stepper::Fixed(fixed)) if self.plant.method.scheme() == Scheme::TimeStepping => {
                fixed.look_ahead(self, observer)
            }
            _ => self.decide(observer),
        };
        self.stepper = stepper;
        begun?;
        self.started = true;
        self.watch_self(observer)?;
        self.measure();
        // A state saved at the start is one with contact.
        for k in 0..self.happened {
            if let Some(slot) = self.changes[k].save {
                self.save(slot);
            }
        }
        Ok(())
    }

    /// Takes one integration step, with all that belongs to it.
    pub fn step(&mut self, observer: &mut dyn Observer) -> Result<(), Stop> {
        let t = self.plant.state.time;
        let tick = self.tasks.next_tick();
        let ticks = tick.is_some_and(|tick| tick <= t);
        let corner = self.corners.contains(&t);
        let happens = corner && self.happen(observer)?;
        if corner {
            self.pass_forces(observer)?;
            self.pass_loads(observer)?;
        }
        if ticks {
            self.run_tasks(observer)?;
        }
        let jump = if corner {
            self.tell_imposed(observer)?;
            Jump::Corner
        } else if ticks || self.plant.guide.ends(t) {
            Jump::Tick
        } else {
            Jump::None
        };
        let corner = self.corners.iter().copied().find(|c| *c > t);
        let stops = [self.tasks.next_tick(), corner, self.plant.guide.corner(t)];
        let until = stops.into_iter().flatten().fold(self.duration, f64::min);
        let mut stepper = self.stepper.take().expect("put back below");
        if let (Stepper::Explicit(explicit), true) = (&mut stepper, happens) {
            explicit.restart();
        }
        let result = match &mut stepper {
            Stepper::Explicit(explicit) => explicit.step(self, until, jump, observer),
            Stepper::Fixed(fixed) => fixed.step(self, until, observer),
        };
        self.stepper = Some(stepper);
        self.check_forces()?;
        result?;
        self.watch_self(observer)?;
        self.check_fallen(observer)
    }

    fn advance(&mut self, observer: &mut dyn Observer, cancel: &AtomicBool) -> Result<(), Stop> {
        if !self.started {
            self.begin(observer)?;
        }
        while self.plant.state.time < self.duration {
            if cancel.load(Ordering::Relaxed) {
                return Err(Stop::new(Outcome::Cancelled, "interrupted"));
            }
            self.step(observer)?;
        }
        Ok(())
    }

    fn finish(&mut self, observer: &mut dyn Observer) -> Result<(), Stop> {
        self.snapshot_last(observer)?;
        self.plant.evaluate();
        self.sample_end(observer)?;
        self.tell(observer)?;
        self.dismiss()
    }

    /// The last instant of a run of velocity-level steps, with the forces of the last of them.
    pub(super) fn snapshot_last(&mut self, observer: &mut dyn Observer) -> Result<(), Stop> {
        if self.steps_velocities() { self.snapshot_now(self.plant.state.time, observer) } else { Ok(()) }
    }

    /// Prepares the force models.
    fn init_forces(&mut self) -> Result<(), Stop> {
        self.plant.init_forces().map_err(|m| Stop::new(Outcome::Error, m))
    }

    /// Tells the force models that a corner, or the start, is reached.
    fn pass_forces(&mut self, observer: &mut dyn Observer) -> Result<(), Stop> {
        let time = self.plant.state.time;
        let mut failure = None;
        self.plant.pass_forces(&mut |kind, subject, message| {
            let event = SimEvent { time, kind, subject: subject.to_string(), message };
            failure = failure.take().or(observer.event(&event).err());
        });
        failure.map_or(Ok(()), |m| Err(Stop::new(Outcome::Error, m)))
    }

    /// Ends the run when a force model has failed.
    fn check_forces(&mut self) -> Result<(), Stop> {
        let fault = self.plant.forces.iter().find_map(|f| f.failure());
        fault.map_or(Ok(()), |m| Err(Stop::new(Outcome::Error, format!("{m} at {:.6} s", self.plant.state.time))))
    }

    /// Reports an event.
    pub(super) fn event(
        &mut self,
        observer: &mut dyn Observer,
        kind: &'static str,
        subject: &str,
        message: &str,
    ) -> Result<(), Stop> {
        let event =
            SimEvent { time: self.plant.state.time, kind, subject: subject.to_string(), message: message.to_string() };
        observer.event(&event).map_err(|m| Stop::new(Outcome::Error, m))
    }

    /// Time of the next snapshot due, s.
    pub(super) fn next_snapshot(&self) -> Option<f64> {
        (self.log_rate > 0.0).then(|| self.logged as f64 / self.log_rate)
    }

    /// Tells the observer the plant's present state; needs an evaluation at it.
    pub(super) fn tell(&mut self, observer: &mut dyn Observer) -> Result<(), Stop> {
        self.logged += 1;
        let now = self.plant.state.time;
        if self.told.replace(now) == Some(now) {
            // A fixed step that ends the run, or spans several instants of the log, is one instant.
            return Ok(());
        }
        super::observe::fill(&mut self.plant, &mut self.edges, &mut self.snapshot);
        self.snapshot.energy = self.balance();
        for (to, (_, position)) in self.snapshot.points.iter_mut().zip(self.tasks.points()) {
            to.position = position;
        }
        if let (Some(own), Some(out)) = (&mut self.self_contact, &mut self.snapshot.self_contact) {
            own.fill(&self.plant.model, &self.plant.state, &self.plant.ws, out);
        }
        observer.snapshot(&self.snapshot).map_err(|m| Stop::new(Outcome::Error, m))
    }

    /// Are steps taken at the velocity level? (Not while one is being taken.)
    pub(super) fn steps_velocities(&self) -> bool {
        matches!(self.stepper, Some(Stepper::Fixed(_)))
    }

    /// Are events located inside steps?
    pub(super) fn locates(&self) -> bool {
        self.contact.locate && self.plant.method.locates_events()
    }

    /// Are the instants located at which vertices enter and leave a compliant floor?
    pub(super) fn locates_surface(&self) -> bool {
        self.contact.locate && self.plant.is_compliant()
    }

    fn sum_up(&mut self) {
        let state = &self.plant.state;
        let m = &mut self.metrics;
        m.duration_s = state.time;
        m.evaluations = self.plant.evaluations;
        m.final_base_position = state.position.into();
        let (roll, pitch, yaw) = state.rotation.euler_angles();
        m.final_base_rpy = [roll, pitch, yaw];
        let is_floating = self.plant.model.nb() == 6;
        m.final_base_velocity = if is_floating { [state.v[0], state.v[1], state.v[2]] } else { [0.0; 3] };
        if let Some(own) = &self.self_contact {
            own.sum_up(&mut self.metrics);
        }
        self.plant.evaluate_free();
        self.audit();
        self.conclude();
        self.mark_end();
    }
}
