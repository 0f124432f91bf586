//! Creates the task `mocap`: maps channels to joints, resamples them to the control ticks, and
//! limits ranges and speeds.

use crate::assemble::names;
use crate::assemble::playback::{file_error, has_extension, text};
use crate::motion::limit::{self, Limited};
use crate::motion::{Track, bvh, columns};
use crate::robot::{JointKind, Model};
use crate::scenario::{Diagnostic, MocapTarget, MocapTask, Run};
use crate::task::mocap::Mocap;
use crate::text::suggest;

/// Least number of samples in the smoothing window.
const MIN_WINDOW_SAMPLES: f64 = 18.0;
/// Greatest number of samples per tick: a window shorter than a fifth of a tick has no effect at
/// ticks.
const MAX_REFINEMENT: f64 = 100.0;
/// Greatest number of samples of one joint.
const MAX_SAMPLES: f64 = 1e7;

/// The task at `path`; `None` after an error, which goes to `errors`. The effect of the limits goes
/// to `notes`.
pub(super) fn mocap(
    run: &Run,
    model: &Model,
    path: &str,
    spec: &MocapTask,
    notes: &mut Vec<String>,
    errors: &mut Vec<Diagnostic>,
) -> Option<Mocap> {
    let input = run.input(&format!("{path}.file"))?;
    let Some(text) = text(input) else {
        let message = format!("{}: the file is not UTF-8", input.path.display());
        errors.push(run.error_at(&format!("{path}.file"), message, None));
        return None;
    };
    let motion = match if has_extension(input, "csv") { columns::read(text) } else { bvh::read(text) } {
        Ok(motion) => motion,
        Err(error) => {
            errors.push(file_error(input, text, error));
            return None;
        }
    };
    let before = errors.len();
    let ticks = run.scenario.control.rate;
    // More samples than ticks if the window would hold too few.
    let needed = (MIN_WINDOW_SAMPLES / (spec.smoothing * ticks)).ceil();
    let refinement = if needed > MAX_REFINEMENT { 1.0 } else { needed.max(1.0) };
    let rate = refinement * ticks;
    // Three averages over 2 half + 1 samples each are as wide as the window.
    let half = (spec.smoothing * rate / 6.0).round();
    let length = motion.span()?.1 / spec.speed;
    let samples = (length * rate).ceil() + 1.0 + 3.0 * half;
    if samples > MAX_SAMPLES {
        let message = format!(
            "`{path}`: {length:.3} s at `control.rate` = {ticks} with `smoothing` = {} takes {samples:.0} samples; at most \
             {MAX_SAMPLES:.0} are allowed",
            spec.smoothing
        );
        errors.push(run.error_at(&format!("{path}.file"), message, None));
        return None;
    }
    let (samples, half) = (samples as usize, half as usize);
    // Time from the start to the first tick.
    let delay = (spec.start * ticks - 1e-9).ceil().max(0.0) / ticks - spec.start;
    let mut joints = Vec::new();
    for (channel, target) in &spec.map {
        let key = format!("{path}.map.\"{channel}\"");
        let Some(track) = motion.track(channel) else {
            let help = suggest(channel, motion.tracks.iter().map(|t| t.name.as_str()).collect::<Vec<_>>());
            let message = format!("{} has no channel `{channel}`", input.path.display());
            errors.push(run.error_at_key(&key, message, Some(help)));
            continue;
        };
        let Some(id) = model.joint(&target.joint) else {
            let help = suggest(&target.joint, model.joints.iter().map(|j| j.name.as_str()).collect::<Vec<_>>());
            let message = format!("the robot `{}` has no joint `{}`", model.name, target.joint);
            errors.push(run.error_at(&format!("{key}.joint"), message, Some(help)));
            continue;
        };
        let joint = &model.joints[id.0];
        let mut x = resample(track, target, spec.speed, (delay, rate), samples);
        let ranged = match joint.kind {
            JointKind::Continuous => Limited::default(),
            JointKind::Revolute | JointKind::Prismatic => limit::range(&mut x, joint.lower, joint.upper),
        };
        let fastest = spec.speed_limit.unwrap_or(f64::INFINITY).min(joint.velocity_limit);
        let slowed = limit::speed(&mut x, fastest / rate);
        limit::smooth(&mut x, half);
        let unit = if joint.kind == JointKind::Prismatic { "m" } else { "rad" };
        for (limited, what) in [(ranged, "range".to_owned()), (slowed, format!("speed limit of {fastest} {unit}/s"))] {
            if limited.samples > 0 {
                let Limited { distance, samples: changed } = limited;
                let joint = &joint.name;
                notes.push(format!(
                    "{path}: the {what} of `{joint}` changed {changed} of {samples} samples by up to {distance:.4} {unit}"
                ));
            }
        }
        joints.push((id, x.into_iter().step_by(refinement as usize).collect()));
    }
    let ids: Vec<_> = joints.iter().map(|(id, _)| *id).collect();
    names::note_ignored_commands(run, model, path, &ids, notes);
    (errors.len() == before).then(|| Mocap::new(joints, ticks, spec.blend))
}

/// Joint positions sampled at `rate`, Hz, the first `delay` seconds after time 0 of the recording,
/// which plays at `speed`. Linear between frames; constant before the first and after the last.
fn resample(track: &Track, target: &MocapTarget, speed: f64, (delay, rate): (f64, f64), samples: usize) -> Vec<f64> {
    let knots = &track.knots;
    let mut at = 0;
    let mut sample = |k: usize| {
        let t = (delay + k as f64 / rate) * speed;
        while at + 1 < knots.len() && knots[at + 1].time <= t {
            at += 1;
        }
        let (here, next) = (&knots[at], &knots[(at + 1).min(knots.len() - 1)]);
        let part = if next.time > here.time { ((t - here.time) / (next.time - here.time)).max(0.0) } else { 0.0 };
        target.offset + target.scale * (here.value + part * (next.value - here.value))
    };
    (0..samples).map(&mut sample).collect()
}
