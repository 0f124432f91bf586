//! Creates tasks that a network runs: resolves joints and soles, and checks that the network fits.

use crate::assemble::names::{self, Owner};
use crate::policy::{Action, ActionMode, History, Interface, Part, Policy, Quantity, Settings, Term, load};
use crate::robot::{DriveMode, JointId, Model, SoleId};
use crate::scenario::{
    Diagnostic, PolicyAction, PolicyMode, PolicyNumbers, PolicyObservation, PolicyTask, PolicyTerm, Run,
};
use crate::task::Task;
use crate::text::{pattern, suggest};

/// Least normal force of a sole in contact, N, by default.
const CONTACT_FORCE: f64 = 1.0;

/// The task of the entry at `path`; what does not fit the robot or the network is an error at its
/// position.
pub(super) fn policy(
    run: &Run,
    model: &Model,
    path: &str,
    spec: &PolicyTask,
    notes: &mut Vec<String>,
    errors: &mut Vec<Diagnostic>,
) -> Option<Box<dyn Task>> {
    let before = errors.len();
    let mut entry = Entry { run, model, path, errors };
    let posture = entry.posture(spec);
    let joints = entry.joints("action.joints", &spec.action.joints);
    let (mut terms, mut commands) = (Vec::new(), 0);
    for (i, observation) in spec.observations.iter().enumerate() {
        terms.extend(entry.term(i, observation, (&joints, &posture), commands));
        commands += observation.values.len();
    }
    let action = entry.action(&spec.action, joints, &posture, notes);
    // A file that cannot be read was reported when the scenario was expanded.
    let input = run.input(&format!("{path}.file"))?;
    if errors.len() > before {
        return None;
    }
    let action = action?;
    let widths: Vec<usize> = terms.iter().map(|term| term.quantity.width()).collect();
    let history = History::new(widths, spec.history as usize, spec.newest_first, spec.by_term);
    let interface = Interface {
        observation: history.width(),
        action: action.joints.len(),
        input: spec.input.clone(),
        output: spec.output.clone(),
        state: spec.state.iter().map(|state| (state.input.clone(), state.output.clone())).collect(),
    };
    let network = match load(&input.bytes, &interface) {
        Ok(network) => network,
        Err(error) => {
            let (key, list) = match error.part {
                Part::Program => ("type".to_owned(), String::new()),
                Part::File => ("file".to_owned(), String::new()),
                Part::Observations => ("observations".to_owned(), listed_terms(spec, &terms)),
                Part::Action => ("action.joints".to_owned(), listed_joints(model, &action.joints)),
                Part::Input => ("input".to_owned(), String::new()),
                Part::Output => ("output".to_owned(), String::new()),
                Part::State(i) => (format!("state.{i}"), String::new()),
            };
            // A name that was not given has no position; the file is what lacks it.
            let missing = (error.part == Part::Input && spec.input.is_none())
                || (error.part == Part::Output && spec.output.is_none());
            let key = if missing { "file" } else { &key };
            errors.push(run.error_at(&format!("{path}.{key}"), format!("{}{list}", error.message), error.help));
            return None;
        }
    };
    let settings = Settings {
        terms,
        history,
        action,
        decimation: spec.decimation,
        command: spec.observations.iter().flat_map(|o| o.values.iter().copied()).collect(),
        changes: spec.change.iter().map(|change| (change.at, change.values.clone())).collect(),
        end: spec.duration.map_or(f64::INFINITY, |duration| spec.start + duration),
    };
    Some(Box::new(Policy::new(settings, network)))
}

/// As ": gravity 3, joint-positions 20, 2 of them in the history".
fn listed_terms(spec: &PolicyTask, terms: &[Term]) -> String {
    let name = |term: PolicyTerm| toml::Value::try_from(term).ok().and_then(|v| v.as_str().map(str::to_owned));
    let named = spec.observations.iter().zip(terms);
    let list: Vec<String> =
        named.map(|(o, term)| format!("{} {}", name(o.term).unwrap_or_default(), term.quantity.width())).collect();
    let history = if spec.history > 1 { format!("; times `history` = {}", spec.history) } else { String::new() };
    format!(": {}{history}", list.join(", "))
}

fn listed_joints(model: &Model, joints: &[usize]) -> String {
    let names: Vec<&str> = joints.iter().map(|j| model.joints[*j].name.as_str()).collect();
    format!(": {}", names.join(", "))
}

/// An entry whose names are resolved.
struct Entry<'a> {
    run: &'a Run,
    model: &'a Model,
    path: &'a str,
    errors: &'a mut Vec<Diagnostic>,
}

impl Entry<'_> {
    fn error(&mut self, key: &str, message: String, help: Option<String>) {
        self.errors.push(self.run.error_at(&format!("{}.{key}", self.path), message, help));
    }

    /// The default posture.
    fn posture(&mut self, spec: &PolicyTask) -> Vec<f64> {
        let key = format!("{}.keyframe", self.path);
        let owner = Owner::robot(self.model);
        let mut posture = names::start_posture(owner, self.run, &key, spec.keyframe.as_ref(), self.errors);
        let key = format!("{}.posture", self.path);
        for (JointId(j), q) in names::joints(self.model, self.run, &key, spec.posture.iter(), self.errors) {
            posture[j] = q;
        }
        posture
    }

    /// The joints with these names or patterns at `key`, in this order. A pattern does not include
    /// joints that follow others.
    fn joints(&mut self, key: &str, listed: &[String]) -> Vec<usize> {
        let model = self.model;
        let mut found = Vec::new();
        for (i, name) in listed.iter().enumerate() {
            let key = format!("{key}.{i}");
            let exact = model.joint(name);
            let of_pattern =
                |j: &usize| pattern::matches(name, &model.joints[*j].name) && model.coupling_of(JointId(*j)).is_none();
            let joints = match exact {
                Some(JointId(j)) => vec![j],
                None => (0..model.joints.len()).filter(of_pattern).collect(),
            };
            if joints.is_empty() {
                let help = suggest(name, model.joints.iter().map(|joint| joint.name.as_str()));
                self.error(&key, format!("the robot `{}` has no joint `{name}`", model.name), Some(help));
            }
            if let Some(j) = joints.iter().find(|j| found.contains(*j)) {
                self.error(&key, format!("the joint `{}` is named twice", model.joints[*j].name), None);
            }
            found.extend(joints);
        }
        found
    }

    fn soles(&mut self, key: &str, listed: Option<&Vec<String>>) -> Vec<usize> {
        let model = self.model;
        if model.soles.is_empty() {
            self.error(key, format!("the robot `{}` has no soles", model.name), None);
        }
        let Some(listed) = listed else { return (0..model.soles.len()).collect() };
        let path = format!("{}.{key}.soles", self.path);
        let soles = names::soles(model, self.run, &path, listed, self.errors);
        soles.into_iter().map(|SoleId(s)| s).collect()
    }

    /// One number for each of `count`; a list of another length is an error at `key`.
    fn numbers(&mut self, key: &str, numbers: &PolicyNumbers, count: usize) -> Option<Vec<f64>> {
        let expanded = numbers.expand(count);
        if let (None, PolicyNumbers::Each(list)) = (&expanded, numbers) {
            let given = list.len();
            self.error(key, format!("must be one number or a list of {count}, not of {given}"), None);
        }
        expanded
    }

    /// The term `i`; `joints` are those of the action, `commands` the number of given numbers before.
    fn term(
        &mut self,
        i: usize,
        spec: &PolicyObservation,
        (joints, posture): (&[usize], &[f64]),
        commands: usize,
    ) -> Option<Term> {
        let key = format!("observations.{i}");
        let mut of_joints = || match &spec.joints {
            Some(listed) => self.joints(&format!("{key}.joints"), listed),
            None => joints.to_vec(),
        };
        let period = spec.period.unwrap_or(1.0);
        let quantity = match spec.term {
            PolicyTerm::LinearVelocity => Quantity::LinearVelocity,
            PolicyTerm::AngularVelocity => Quantity::AngularVelocity,
            PolicyTerm::Gravity => Quantity::Gravity,
            PolicyTerm::Orientation => Quantity::Orientation,
            PolicyTerm::Height => Quantity::Height,
            PolicyTerm::Command => Quantity::Command(commands, spec.values.len()),
            PolicyTerm::JointPositions => {
                let zero = |j: usize| if spec.relative { posture[j] } else { 0.0 };
                Quantity::JointPositions(of_joints().into_iter().map(|j| (j, zero(j))).collect())
            }
            PolicyTerm::JointVelocities => Quantity::JointVelocities(of_joints()),
            PolicyTerm::PreviousAction => Quantity::PreviousAction(joints.len()),
            PolicyTerm::SoleForces => Quantity::SoleForces(self.soles(&key, spec.soles.as_ref())),
            PolicyTerm::Contacts => {
                let soles = self.soles(&key, spec.soles.as_ref());
                Quantity::Contacts(soles, spec.threshold.unwrap_or(CONTACT_FORCE))
            }
            PolicyTerm::Sine => Quantity::Sine(period, spec.phase),
            PolicyTerm::Cosine => Quantity::Cosine(period, spec.phase),
        };
        let count = quantity.width();
        let scale = self.numbers(&format!("{key}.scale"), &spec.scale, count);
        let offset = self.numbers(&format!("{key}.offset"), &spec.offset, count);
        Some(Term { quantity, scale: scale?, offset: offset?, clip: spec.clip.unwrap_or(f64::INFINITY) })
    }

    fn action(
        &mut self,
        spec: &PolicyAction,
        joints: Vec<usize>,
        posture: &[f64],
        notes: &mut Vec<String>,
    ) -> Option<Action> {
        let (model, count) = (self.model, joints.len());
        for &j in &joints {
            if let Some(coupling) = model.coupling_of(JointId(j)) {
                let (name, leader) = (&model.joints[j].name, &model.joints[coupling.leader.0].name);
                self.error("action.joints", format!("`{name}` follows `{leader}` and cannot be commanded"), None);
            }
        }
        let mode = match spec.mode {
            PolicyMode::Position => ActionMode::Position,
            PolicyMode::Force => ActionMode::Force,
        };
        let drive = |j: &usize| model.joints[*j].drive.mode;
        let driven = |j: &usize| !matches!(drive(j), DriveMode::Passive | DriveMode::Kinematic);
        let ignored = |j: &&usize| match mode {
            ActionMode::Position => drive(j) == DriveMode::Passive,
            ActionMode::Force => !driven(j),
        };
        for j in joints.iter().filter(ignored) {
            let name = &model.joints[*j].name;
            let mode = if drive(j) == DriveMode::Passive { "passive" } else { "kinematic" };
            notes.push(format!("{}: `{name}` is in mode `{mode}` and ignores the network", self.path));
        }
        let scale = self.numbers("action.scale", &spec.scale, count);
        let mut gains = |key: &str, gains: &Option<PolicyNumbers>| match gains {
            Some(gains) => self.numbers(key, gains, count).map(Some),
            None => Some(None),
        };
        let (kp, kd) = (gains("action.kp", &spec.kp), gains("action.kd", &spec.kd));
        let offset = |j: &usize| if mode == ActionMode::Position { posture[*j] } else { 0.0 };
        Some(Action {
            mode,
            driven: joints.iter().map(driven).collect(),
            offset: joints.iter().map(offset).collect(),
            scale: scale?,
            // Rounded as the output is.
            clip: spec.clip.unwrap_or(f64::INFINITY) as f32,
            kp: kp?,
            kd: kd?,
            joints,
        })
    }
}
