//! Creates the task `playback`: reads the motion, checks it against the robot's joints and ranges,
//! and fits curves.

use crate::assemble::names;
use crate::log::Trajectory;
use crate::motion::spline::{EndConditions, Spline};
use crate::motion::{Knot, Motion, MotionError, Track, columns, postures};
use crate::robot::{Joint, JointId, JointKind, Model};
use crate::scenario::{Diagnostic, Ends, Input, JointLimits, PlaybackTask, Recorded, Run};
use crate::task::playback::Playback;
use crate::text::suggest;
use std::ops::Range;

/// Fraction of a joint's range by which a curve may exceed it between knots, less than an end stop
/// yields.
const OVERSHOOT: f64 = 1e-3;

/// A motion file, with its text for excerpts in errors; a log has no text.
struct Source<'a> {
    run: &'a Run,
    path: &'a str,
    input: &'a Input,
    text: Option<&'a str>,
}

impl Source<'_> {
    /// An error at a range of the text, or at the key that names the file.
    fn error(&self, piece: Range<usize>, message: String, help: Option<String>) -> Box<Diagnostic> {
        let name = self.input.path.display().to_string();
        Box::new(match self.text {
            Some(text) => Diagnostic::in_text(&name, text, piece, message, help),
            None => self.run.error_at(&format!("{}.file", self.path), format!("{name}: {message}"), help),
        })
    }
}

/// The task at `path`; `None` after an error, which goes to `errors`.
pub(super) fn playback(
    run: &Run,
    model: &Model,
    path: &str,
    spec: &PlaybackTask,
    notes: &mut Vec<String>,
    errors: &mut Vec<Diagnostic>,
) -> Option<Playback> {
    let input = run.input(&format!("{path}.file"))?;
    let source = Source { run, path, input, text: text(input) };
    let motion = match read(&source, spec.recorded) {
        Ok(motion) => motion,
        Err(error) => {
            errors.push(*error);
            return None;
        }
    };
    let before = errors.len();
    for (i, name) in spec.joints.iter().enumerate() {
        let key = format!("{path}.joints.{i}");
        if spec.joints[..i].contains(name) {
            errors.push(run.error_at(&key, format!("`{name}` is listed twice"), None));
        } else if motion.track(name).is_none() {
            let help = suggest(name, motion.tracks.iter().map(|t| t.name.as_str()).collect::<Vec<_>>());
            let message = format!("the motion {} does not move `{name}`", input.path.display());
            errors.push(run.error_at(&key, message, Some(help)));
        }
    }
    let tracks = motion.tracks.iter().filter(|t| spec.joints.is_empty() || spec.joints.contains(&t.name));
    let mut joints = Vec::new();
    for track in tracks {
        match curve(&source, model, spec, track, motion.span()?) {
            Ok(joint) => joints.push(joint),
            Err(error) => errors.push(*error),
        }
        // Each error contains the text of the file.
        if errors.len() > before + names::MAX_ERRORS {
            break;
        }
    }
    let ids: Vec<_> = joints.iter().map(|(id, _)| *id).collect();
    names::note_ignored_commands(run, model, path, &ids, notes);
    let changes = spec.change.iter().map(|c| (c.at, c.speed)).collect();
    (errors.len() == before).then(|| Playback::new(joints, spec.speed, spec.repeat, spec.blend, changes))
}

/// True when the file has this extension.
pub(super) fn has_extension(input: &Input, extension: &str) -> bool {
    input.path.extension().is_some_and(|e| e.eq_ignore_ascii_case(extension))
}

/// The text of a file, unless it is a log.
pub(super) fn text(input: &Input) -> Option<&str> {
    if has_extension(input, "mcap") { None } else { std::str::from_utf8(&input.bytes).ok() }
}

/// An error in a text file, with its excerpt.
pub(super) fn file_error(input: &Input, text: &str, error: MotionError) -> Diagnostic {
    Diagnostic::in_text(&input.path.display().to_string(), text, error.span, error.message, error.help)
}

fn read(source: &Source, recorded: Recorded) -> Result<Motion, Box<Diagnostic>> {
    let input = source.input;
    if has_extension(input, "mcap") {
        return logged_motion(source, recorded);
    }
    let Some(text) = source.text else {
        return Err(source.error(0..0, "the file is not UTF-8".into(), None));
    };
    let read = if has_extension(input, "csv") { columns::read(text) } else { postures::read(text) };
    read.map_err(|error| Box::new(file_error(input, text, error)))
}

/// The joints of a run's log.
fn logged_motion(source: &Source, recorded: Recorded) -> Result<Motion, Box<Diagnostic>> {
    let key = format!("{}.file", source.path);
    let error = |message: String| Box::new(source.run.error_at(&key, message, None));
    let log = Trajectory::from_bytes(&source.input.path, &source.input.bytes).map_err(|e| error(e.to_string()))?;
    let name = source.input.path.display();
    let motion = log.motion.ok_or_else(|| error(format!("{name}: the log has no topic `state`")))?;
    if log.times.is_empty() || motion.joints.is_empty() {
        return Err(error(format!("{name}: the log holds no joint positions")));
    }
    let track = |joint: &crate::log::JointSeries| {
        let values = match recorded {
            Recorded::Desired => &joint.desired_position,
            Recorded::Actual => &joint.position,
        };
        let knot = |(time, value): (&f64, &f64)| Knot { time: *time, value: *value, span: 0..0 };
        Track { name: joint.name.clone(), span: 0..0, knots: log.times.iter().zip(values).map(knot).collect() }
    };
    Ok(Motion { tracks: motion.joints.iter().map(track).collect() })
}

/// The curve of one joint, which must stay in the joint's range if the scenario has end stops.
fn curve(
    source: &Source,
    model: &Model,
    spec: &PlaybackTask,
    track: &Track,
    (first, last): (f64, f64),
) -> Result<(JointId, Spline), Box<Diagnostic>> {
    let name = &track.name;
    let Some(id) = model.joint(name) else {
        let help = suggest(name, model.joints.iter().map(|j| j.name.as_str()).collect::<Vec<_>>());
        let message = format!("the robot `{}` has no joint `{name}`", model.name);
        return Err(source.error(track.span.clone(), message, Some(help)));
    };
    let joint = &model.joints[id.0];
    let limited = source.run.scenario.robot.joint_limits == JointLimits::Stop && joint.kind != JointKind::Continuous;
    let (lower, upper) = if limited { (joint.lower, joint.upper) } else { (f64::NEG_INFINITY, f64::INFINITY) };
    if let Some(knot) = track.knots.iter().find(|k| !(lower..=upper).contains(&k.value)) {
        let message = format!("`{name}` = {} at {} s is {}", knot.value, knot.time, outside(joint));
        return Err(source.error(knot.span.clone(), message, None));
    }
    let (start, end) = (&track.knots[0], &track.knots[track.knots.len() - 1]);
    if spec.repeat {
        let fault = if start.time != first || end.time != last {
            Some(format!("`{name}` has no value at {first} s or none at {last} s, where the motion repeats"))
        } else if start.value != end.value {
            let (from, to) = (start.value, end.value);
            Some(format!("`{name}` = {to} at {last} s is not {from} as at {first} s, where the motion repeats"))
        } else {
            None
        };
        if let Some(message) = fault {
            let help = "with `loop` a motion must end in its first posture".to_owned();
            return Err(source.error(end.span.clone(), message, Some(help)));
        }
    }
    let ends = match (spec.repeat, spec.ends.unwrap_or_default()) {
        (true, _) => EndConditions::Periodic,
        (false, Ends::Natural) => EndConditions::Natural,
        (false, Ends::Clamped) => EndConditions::Clamped,
    };
    let (times, values): (Vec<f64>, Vec<f64>) = track.knots.iter().map(|k| (k.time, k.value)).unzip();
    let spline = Spline::new(times, &values, ends)
        .map_err(|error| source.error(track.span.clone(), format!("`{name}`: {error}"), None))?;
    let tolerance = OVERSHOOT * (upper - lower);
    if let Some((t, q)) = spline.extremes().into_iter().find(|(_, q)| *q < lower - tolerance || *q > upper + tolerance)
    {
        let message = format!("the curve of `{name}` reaches {q:.4} at {t:.3} s, {}", outside(joint));
        let help = "one more posture near that time, or postures farther from the limit, keep it inside";
        return Err(source.error(track.span.clone(), message, Some(help.into())));
    }
    Ok((id, spline))
}

fn outside(joint: &Joint) -> String {
    let unit = if joint.kind == JointKind::Prismatic { "m" } else { "rad" };
    format!("outside its range, {:.4} to {:.4} {unit}", joint.lower, joint.upper)
}
