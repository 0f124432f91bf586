//! Creates the tasks of the task server from their entries.

use crate::assemble::{balance, mocap, names, planned, playback, policy, script_setup};
use crate::robot::{JointId, Model};
use crate::scenario::{Diagnostic, JointLimits, Run, SineTask, TaskSpec};
use crate::sim::setup::Start;
use crate::task::posture::Posture;
use crate::task::sine::{Sine, Swing, SwingChange};
use crate::task::{Command, Task, TaskServer};

/// Tasks in file order; those that do not fit the robot are errors at their positions.
pub(super) fn tasks(
    run: &Run,
    model: &Model,
    start: &Start,
    notes: &mut Vec<String>,
    errors: &mut Vec<Diagnostic>,
) -> TaskServer {
    let mut server = TaskServer::new(run.scenario.control.rate, model, Command::hold(model, &start.joints));
    if run.scenario.control.idle_ticks {
        server.tick_always();
    }
    for (i, spec) in run.scenario.task.iter().enumerate() {
        let path = format!("task.{i}");
        let (start, task): (f64, Option<Box<dyn Task>>) = match spec {
            TaskSpec::Posture(posture) => {
                let targets = names::joints(model, run, &format!("{path}.joints"), posture.joints.iter(), errors);
                for &(id, q) in &targets {
                    let key = format!("{path}.joints.{}", model.joints[id.0].name);
                    names::check_range(run, model, &key, id, ("the goal", q, q), errors);
                }
                let joints: Vec<_> = targets.iter().map(|t| t.0).collect();
                names::note_ignored_commands(run, model, &path, &joints, notes);
                (posture.start, Some(Box::new(Posture::new(targets, posture.duration))))
            }
            TaskSpec::Sine(spec) => (spec.start, Some(Box::new(sine(run, model, &path, spec, notes, errors)))),
            TaskSpec::Playback(spec) => {
                let task = playback::playback(run, model, &path, spec, notes, errors);
                (spec.start, task.map(|task| Box::new(task) as _))
            }
            TaskSpec::Mocap(spec) => {
                let task = mocap::mocap(run, model, &path, spec, notes, errors);
                (spec.start, task.map(|task| Box::new(task) as _))
            }
            TaskSpec::Balance(spec) => (spec.start, balance::balance(run, model, &path, spec, errors)),
            TaskSpec::GravityCompensation(spec) => {
                (spec.start, Some(balance::gravity_compensation(run, model, &path, spec, errors)))
            }
            TaskSpec::Script(spec) => (spec.start, script_setup::task(run, model, i, spec, errors)),
            TaskSpec::Squat(spec) => (spec.start, planned::squat(run, model, &path, spec, errors)),
            TaskSpec::Walk(spec) => (spec.start, planned::walk(run, model, &path, spec, errors)),
            TaskSpec::Policy(spec) => (spec.start, policy::policy(run, model, &path, spec, notes, errors)),
        };
        // A task that cannot be created has reported an error.
        if let Some(task) = task {
            server.add(start, task);
        }
    }
    server
}

fn sine(
    run: &Run,
    model: &Model,
    path: &str,
    spec: &SineTask,
    notes: &mut Vec<String>,
    errors: &mut Vec<Diagnostic>,
) -> Sine {
    let named = spec.joints.iter().map(|(name, joint)| (name, &joint.amplitude));
    names::joints(model, run, &format!("{path}.joints"), named, errors);
    let known = || spec.joints.iter().filter_map(|(name, joint)| Some((name, model.joint(name)?, joint)));
    let joints = known().map(|(_, id, joint)| {
        let swing =
            Swing { amplitude: joint.amplitude, frequency: joint.frequency, phase: joint.phase, offset: joint.offset };
        (id, swing)
    });
    let ids: Vec<_> = known().map(|(_, id, _)| id).collect();
    names::note_ignored_commands(run, model, path, &ids, notes);
    known().for_each(|(name, id, _)| check_oscillation(run, model, (path, name), id, spec, (notes, errors)));
    let change = |(number, name): (usize, &String), change: &crate::scenario::SineChange| {
        let new = change.joints.get(name)?;
        Some(SwingChange { joint: number, amplitude: new.amplitude, frequency: new.frequency, offset: new.offset })
    };
    let changes = spec.change.iter().map(|at| {
        let joints = known().map(|(name, ..)| name).enumerate();
        (at.at, joints.filter_map(|joint| change(joint, at)).collect())
    });
    let limited = run.scenario.robot.joint_limits == JointLimits::Stop;
    Sine::new(joints.collect(), spec.duration.unwrap_or(f64::INFINITY), spec.ramp, changes.collect(), limited)
}

/// Refuses oscillations beyond a joint's range, before and after changes, and notes frequencies
/// that are too high for the control rate. Amplitude and middle change together between two sets of
/// parameters, so transitions need no check of their own.
fn check_oscillation(
    run: &Run,
    model: &Model,
    (path, name): (&str, &str),
    id: JointId,
    spec: &SineTask,
    (notes, errors): (&mut Vec<String>, &mut Vec<Diagnostic>),
) {
    let first = &spec.joints[name];
    let joint = &model.joints[id.0];
    let (mut amplitude, mut offset) = (first.amplitude.abs(), first.offset);
    let changes = spec.change.iter().enumerate().filter_map(|(i, c)| Some((i, c.joints.get(name)?)));
    let mut stages = vec![(format!("{path}.joints.{name}.amplitude"), amplitude, offset, Some(first.frequency))];
    for (i, new) in changes {
        amplitude = new.amplitude.map_or(amplitude, f64::abs);
        offset = new.offset.or(offset);
        stages.push((format!("{path}.change.{i}.joints.{name}"), amplitude, offset, new.frequency));
    }
    let half = 0.5 * run.scenario.control.rate;
    for (key, amplitude, offset, frequency) in stages {
        // If the middle is known only when the task begins, the range must be wide enough.
        let middle = offset.unwrap_or(0.5 * (joint.lower + joint.upper));
        names::check_range(
            run,
            model,
            &key,
            id,
            ("the oscillation of", middle - amplitude, middle + amplitude),
            errors,
        );
        if let Some(f) = frequency.filter(|f| f.abs() >= half) {
            notes
                .push(format!("{key}: {f} Hz is not below half of `control.rate`, {half} Hz: ticks cannot resolve it"));
        }
    }
}
