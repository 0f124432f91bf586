//! One run from start to end.

use super::bodies::Friction;
use super::carried_object::CarriedObjects;
use super::contact_states::link_contacts::LinkContacts;
use super::contact_states::pair_contacts::PairContacts;
use super::contact_states::terrain_pairs::TerrainPairs;
use super::event_kind::EventKind;
use super::floor::SunkLinks;
use super::measure::energy_balance::EnergyAccount;
use super::measure::milestones::Milestones;
use super::measure::residual_maxima::ResidualMaxima;
use super::measure::sampler::Sampler;
use super::measure::snapshot::{self, SnapshotLog};
use super::plant::sole_impulses::SoleImpulses;
use super::plant::system::{Plant, load_scale};
use super::report::{AvoidanceTime, Metrics, Observer, Outcome, SimEvent};
use super::run::{CommandsAhead, Deferral, RunState};
use super::run_error::RunError;
use super::saved_state::SavedState;
use super::self_collision::SelfCollisionMonitor;
use super::sensing::{Estimator, Sensors};
use super::setup::{ImplicitSteps, IntegratorSetup, Setup};
use super::stepper::step_size::StepSize;
use super::stepper::{Discontinuity, ExplicitStepper, SemiImplicitStepper, Stepper};
use super::termination::StallGuard;
use crate::contact::methods::contact_method::Scheme;
use crate::contact::model::per_sole::PerSole;
use crate::contact::model::problem::Problem;
use crate::contact::model::solution::Solution;
use crate::geometry::roll_pitch_yaw;
use crate::integrate::StepControl;
use crate::robot::{LinkId, Model};
use crate::text::length_limit::limit_length;
use nalgebra::Vector3;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A run: its state and its stepper.
pub struct Simulation {
    pub(super) run: RunState,
    pub(super) stepper: Stepper,
    /// Notes for the user at the end of the run.
    notes: Vec<String>,
}

impl Simulation {
    /// Prepares a run.
    ///
    /// # Errors
    /// A robot, method or other part of the setup that is not supported.
    pub fn new(mut setup: Setup) -> Result<Self, RunError> {
        let model = setup.model.clone();
        check_soles(&model)?;
        let mut problem = Problem::new(&model.soles.iter().map(|s| s.vertices.len()).collect::<Vec<_>>());
        for (sole, geometry) in problem.soles.iter_mut().zip(&model.soles) {
            sole.radius = geometry.radius();
            sole.body = geometry.link.0;
            let floor = Friction { mu_s: setup.floor.mu_s, mu_k: setup.floor.mu_k, extra: setup.floor.extra };
            (0..sole.vertices.len()).for_each(|i| floor.assign(sole, i));
        }
        let objects: f64 = setup.objects.iter().map(|object| object.model.mass()).sum();
        problem.scale = load_scale(model.mass() + objects, &setup.gravity);
        let method = setup.contact.method.solver(&problem);
        let projection = Solution::new(&problem);
        let corners = setup.corners();
        let mut plant = Plant::new(setup.plant(), method, problem);
        let carried = CarriedObjects::new(&model, std::mem::take(&mut setup.carried_objects));
        let stepper = stepper(&setup.integrator, &plant);
        let mut tolerances = setup.contact.tolerances;
        if setup.contact.locate && plant.method.locates_events() {
            tolerances = tolerances.with_located_events();
        }
        let sensors = Sensors::new(&plant, setup.sensors, setup.imu, setup.tasks.period(), setup.seed);
        let estimator = Estimator::new(&setup.estimator, &model, setup.imu, setup.gravity);
        if estimator.integrates_forces() || setup.command_source.is_some() {
            plant.impulses = Some(SoleImpulses::new(model.soles.len()));
        }
        let mut first = snapshot::blank(&model);
        first.external.reserve(plant.arrows.capacity());
        first.points = snapshot::blank_points(&setup.tasks);
        if setup.sensors.is_some() || estimator.estimates() {
            setup.tasks.tick_always();
            first.estimate = Some(snapshot::blank_estimate(&model));
        }
        let self_collision = SelfCollisionMonitor::of_run(&mut setup, &plant.state);
        first.self_contact = self_collision.as_ref().map(|monitor| monitor.blank());
        let terrain = (!setup.terrain.is_empty()).then(|| TerrainPairs::new(setup.terrain.clone(), &plant));
        let mut run = RunState {
            tolerances,
            contact: setup.contact,
            ahead: plant.kinematic_paths.looks_ahead().then(|| Box::new(CommandsAhead::new(&plant.command))),
            tasks: setup.tasks,
            command_source: setup.command_source,
            carried,
            sensors,
            estimator,
            self_collision,
            metrics: Metrics::at_start(),
            energy: EnergyAccount::default(),
            residuals: ResidualMaxima::default(),
            milestones: Milestones::new(&plant),
            suspect: PerSole::default(),
            anchors: model.soles.iter().map(|s| vec![Vector3::zeros(); s.vertices.len()]).collect(),
            before_selection: projection.clone(),
            projection,
            displacement: vec![0.0; plant.acceleration.len()],
            recorded_problem: None,
            log: SnapshotLog::new(first, setup.log_rate, std::mem::take(&mut setup.log_instants)),
            sampler: None,
            started: false,
            deferral: Deferral::Refused,
            velocity_level: matches!(stepper, Stepper::SemiImplicit(_)),
            corners,
            events: setup.events,
            events_done: 0,
            saved: Vec::new(),
            duration: setup.duration,
            fallen_below: setup.fallen_below,
            sunk_links: (setup.ends_when_sunk && setup.touching_links.is_none()).then(|| SunkLinks::new(&model)),
            pairs: PairContacts::new(std::mem::take(&mut setup.bodies.1), terrain),
            links: setup.touching_links.map(|hulls| Box::new(LinkContacts::new(hulls))),
            last_collision: f64::NEG_INFINITY,
            stall_guard: StallGuard::default(),
            cancel: None,
            plant,
        };
        run.plant.evaluate_free();
        run.energy.start = run.plant.energy();
        run.saved = vec![SavedState::new(&run.plant, &run.anchors); setup.saved_states];
        Ok(Simulation { run, stepper, notes: Vec::new() })
    }

    /// Ends the run with outcome `cancelled` when `flag` is set, also within a step: a search through
    /// many contact states may take minutes.
    pub fn cancel_on(&mut self, flag: Arc<AtomicBool>) {
        self.run.cancel = Some(flag);
    }

    /// Runs to the end. `cancel` ends the run at the next step with outcome `cancelled`; see also
    /// [`cancel_on`](Self::cancel_on).
    pub fn run(&mut self, observer: &mut dyn Observer, cancel: &AtomicBool) -> (Outcome, String) {
        let end = self.advance(observer, cancel).and_then(|()| self.finish(observer));
        self.notes.extend(self.run.command_source.iter_mut().flat_map(|source| source.leave()));
        self.write_metrics();
        RunError::outcome_of(end, cancel)
    }

    /// Measurements so far.
    pub fn metrics(&self) -> &Metrics {
        &self.run.metrics
    }

    /// Notes for the user after the end.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// The plant at its present state.
    pub fn plant(&self) -> &Plant {
        &self.run.plant
    }

    /// Processor time of self-collision avoidance, if configured.
    pub fn avoidance_time(&self) -> Option<AvoidanceTime> {
        self.run.self_collision.as_ref().and_then(|monitor| monitor.avoidance_time())
    }

    /// Prepares the first step; [`run`](Self::run) calls this.
    ///
    /// # Errors
    /// An error of a force, task or observer.
    pub fn begin(&mut self, observer: &mut dyn Observer) -> Result<(), RunError> {
        let run = &mut self.run;
        let rate = observer.sample_rate();
        run.sampler = (rate > 0.0).then(|| Box::new(Sampler::new(rate, run.duration, &run.plant)));
        run.plant.init_forces().map_err(RunError::internal)?;
        run.apply_due_events(observer)?;
        notify_forces(run, observer)?;
        run.update_carried_objects(observer)?;
        run.control_tick(observer)?;
        let plant = &mut run.plant;
        let nb = plant.model.nb();
        let state = &mut plant.state;
        plant.drives.fill_lag(&plant.model, &state.joints, &state.v[nb..], &plant.command, &mut state.actuators);
        plant.objects.fill_lag();
        plant.within = 0.0;
        run.report_imposed(observer)?;
        match &mut self.stepper {
            Stepper::SemiImplicit(stepper) if run.plant.method.scheme() == Scheme::TimeStepping => {
                stepper.begin(run, observer)?;
            }
            _ => run.choose_states(observer)?,
        }
        run.started = true;
        run.check_self_collision(observer)?;
        run.measure_step();
        // A state saved at the start includes the contact states.
        for k in 0..run.events_done {
            if let Some(slot) = run.events[k].save {
                run.save(slot);
            }
        }
        Ok(())
    }

    /// Takes one integration step, including control ticks and events at its start.
    ///
    /// # Errors
    /// Early termination, or an error of a force, task or observer.
    pub fn step(&mut self, observer: &mut dyn Observer) -> Result<(), RunError> {
        let run = &mut self.run;
        let t = run.plant.state.time;
        let is_due = |run: &RunState| run.tasks.next_tick().is_some_and(|tick| tick <= t);
        let mut ticks = is_due(run);
        let corner = run.corners.contains(&t);
        let restarts = corner && run.apply_due_events(observer)?;
        if restarts {
            run.tasks.resume_ticks(t);
            ticks |= is_due(run);
        }
        if corner {
            notify_forces(run, observer)?;
            run.update_carried_objects(observer)?;
        }
        if ticks {
            run.control_tick(observer)?;
        }
        let discontinuity = if corner {
            run.report_imposed(observer)?;
            Discontinuity::Corner
        } else if ticks || run.plant.kinematic_paths.ends(t) {
            Discontinuity::Tick
        } else {
            Discontinuity::None
        };
        let next_corner = run.corners.iter().copied().find(|c| *c > t);
        let ends = [run.tasks.next_tick(), next_corner, run.plant.kinematic_paths.corner(t)];
        let until = ends.into_iter().flatten().fold(run.duration, f64::min);
        let result = match &mut self.stepper {
            Stepper::Explicit(stepper) => {
                if restarts {
                    stepper.restart();
                }
                stepper.step(run, until, discontinuity, observer)
            }
            Stepper::SemiImplicit(stepper) => stepper.step(run, until, observer),
        };
        check_forces(run)?;
        result?;
        run.check_self_collision(observer)?;
        check_fallen(run, observer)
    }

    fn advance(&mut self, observer: &mut dyn Observer, cancel: &AtomicBool) -> Result<(), RunError> {
        if !self.run.started {
            self.begin(observer)?;
        }
        while self.run.plant.state.time < self.run.duration {
            if cancel.load(Ordering::Relaxed) {
                return Err(RunError::new(Outcome::Cancelled, "interrupted"));
            }
            self.step(observer)?;
        }
        Ok(())
    }

    fn finish(&mut self, observer: &mut dyn Observer) -> Result<(), RunError> {
        let run = &mut self.run;
        run.emit_last_step(observer)?;
        run.plant.evaluate();
        run.plant.update_multipliers();
        if let Some(sampler) = &mut run.sampler {
            sampler.sample_end(&run.plant, observer)?;
        }
        run.emit_snapshot(observer)?;
        run.finish_command_source()
    }

    fn write_metrics(&mut self) {
        let run = &mut self.run;
        let state = &run.plant.state;
        let m = &mut run.metrics;
        m.duration_s = state.time;
        m.evaluations = run.plant.evaluations;
        m.final_base_position = state.position.into();
        m.final_base_rpy = roll_pitch_yaw(&state.rotation);
        let is_floating = run.plant.model.nb() == 6;
        m.final_base_velocity = if is_floating { [state.v[0], state.v[1], state.v[2]] } else { [0.0; 3] };
        if let Some(monitor) = &run.self_collision {
            monitor.write_metrics(m);
        }
        run.plant.evaluate_free();
        run.measure_energy();
        run.residuals.write(&run.energy.balance(&run.plant), &mut run.metrics);
        run.milestones.write_end(&run.plant, &run.log.snapshot, &mut run.metrics);
    }
}

fn check_soles(model: &Model) -> Result<(), RunError> {
    if let Some(s) = model.soles.iter().find(|s| s.vertices.is_empty() || s.vertices.len() > 64) {
        let message = format!("sole `{}` has {} vertices, 1 to 64 are supported", s.name, s.vertices.len());
        return Err(RunError::internal(message));
    }
    Ok(())
}

fn stepper(integrator: &IntegratorSetup, plant: &Plant) -> Stepper {
    match *integrator {
        IntegratorSetup::Controlled { pair, relative, absolute, max_step, implicit } => {
            let control = StepControl::new(pair.order);
            let size = StepSize::Controlled { control, relative, absolute, max_step, h: max_step.min(1e-3) };
            Stepper::Explicit(Box::new(ExplicitStepper::new(pair, plant, size, implicit)))
        }
        IntegratorSetup::Stepped { method, step } => {
            let size = StepSize::Fixed(step);
            Stepper::Explicit(Box::new(ExplicitStepper::new(method, plant, size, ImplicitSteps::Never)))
        }
        IntegratorSetup::SemiImplicit { step } => Stepper::SemiImplicit(Box::new(SemiImplicitStepper::new(step))),
    }
}

/// Notifies the force models of a corner or of the start.
fn notify_forces(run: &mut RunState, observer: &mut dyn Observer) -> Result<(), RunError> {
    let time = run.plant.state.time;
    let mut failure = None;
    run.plant.pass_forces(&mut |kind, subject, message| {
        let event = SimEvent {
            time,
            kind: EventKind::Force(kind),
            subject: subject.to_string(),
            message: limit_length(message),
        };
        failure = failure.take().or(observer.event(&event).err());
    });
    failure.map_or(Ok(()), |e| Err(RunError::internal(e)))
}

/// Fails when a force model has failed.
fn check_forces(run: &mut RunState) -> Result<(), RunError> {
    let failure = run.plant.forces.iter().find_map(|f| f.failure());
    failure.map_or(Ok(()), |e| Err(RunError::internal(format!("{e} at {:.6} s", run.plant.state.time))))
}

/// The deepest link that has sunk through the floor, with its depth, m.
fn sunk_link(run: &mut RunState) -> Option<(LinkId, f64)> {
    let links = run.sunk_links.as_ref()?;
    run.plant.update_kinematics();
    links.deepest(&run.plant.ws, &run.plant.floor)
}

/// Fails when the base is below the height at which the robot counts as fallen, or a link has sunk.
fn check_fallen(run: &mut RunState, observer: &mut dyn Observer) -> Result<(), RunError> {
    let t = run.plant.state.time;
    let height = run.plant.floor.height(&run.plant.state.position);
    let (subject, message) = if let Some(below) = run.fallen_below.filter(|below| height < *below) {
        (String::new(), format!("base {height:.4} m above the floor at {t:.4} s, below {below} m"))
    } else if let Some((link, depth)) = sunk_link(run) {
        let name = run.plant.model.links[link.0].name.clone();
        let message = format!("link `{name}` {depth:.4} m below the floor at {t:.4} s; only soles touch the floor");
        (name, message)
    } else {
        return Ok(());
    };
    run.metrics.first_fall_s.get_or_insert(t);
    run.event(observer, EventKind::Fallen, &subject, &message)?;
    run.emit_last_step(observer)?;
    run.plant.evaluate();
    run.plant.update_multipliers();
    run.emit_snapshot(observer)?;
    Err(RunError::new(Outcome::Fallen, message))
}
