//! Creates the task `mocap`: maps channels to joints, resamples them to the control ticks, and limits ranges and speeds.

use crate::assemble::names;
use crate::assemble::playback::{shown, text};
use crate::motion::limit::{self, Limited};
use crate::motion::{Track, bvh, columns};
use crate::robot::{JointKind, Model};
use crate::scenario::{Diagnostic, MocapTarget, MocapTask, Run};
use crate::task::mocap::Mocap;
use crate::text::suggest;

/// Samples that the averages need within the smoothing window, and the finest resampling for that, relative to ticks: a
/// window shorter than a fifth of a tick has no effect at ticks.
const FINE: f64 = 18.0;
const MOST_FINER: f64 = 100.0;
/// Most samples of one joint.
const MOST_SAMPLES: f64 = 1e7;

/// The task at `path`; none with an error, which goes to `errors`. The effect of the limits goes to `notes`.
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
    let is_table = input.path.extension().is_some_and(|e| e.eq_ignore_ascii_case("csv"));
    let motion = match if is_table { columns::read(text) } else { bvh::read(text) } {
        Ok(motion) => motion,
        Err(fault) => {
            errors.push(shown(input, text, fault));
            return None;
        }
    };
    let before = errors.len();
    let ticks = run.scenario.control.rate;
    // Samples between ticks where the window would else be one of a few samples only.
    let needed = (FINE / (spec.smoothing * ticks)).ceil();
    let finer = if needed > MOST_FINER { 1.0 } else { needed.max(1.0) };
    let rate = finer * ticks;
    // Three averages over 2 half + 1 samples each are as wide as the window.
    let half = (spec.smoothing * rate / 6.0).round();
    let length = motion.span()?.1 / spec.speed;
    let samples = (length * rate).ceil() + 1.0 + 3.0 * half;
    if samples > MOST_SAMPLES {
        let message = format!(
            "`{path}`: {length:.3} s at `control.rate` = {ticks} with `smoothing` = {} takes {samples:.0} samples; at most \
             {MOST_SAMPLES:.0} are allowed",
            spec.smoothing
        );
        errors.push(run.error_at(&format!("{path}.file"), message, None));
        return None;
    }
    let (samples, half) = (samples as usize, half as usize);
    // The first tick comes after the start by this.
    let late = (spec.start * ticks - 1e-9).ceil().max(0.0) / ticks - spec.start;
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
        let mut x = resampled(track, target, spec.speed, (late, rate), samples);
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
                let Limited { distance, samples: moved } = limited;
                let joint = &joint.name;
                let note = format!(
                    "{path}: the {what} of `{joint}` took up to {distance:.4} {unit} off {moved} of {samples} samples"
                );
                notes.push(note);
            }
        }
        joints.push((id, x.into_iter().step_by(finer as usize).collect()));
    }
    let ids: Vec<_> = joints.iter().map(|(id, _)| *id).collect();
    names::heard(run, model, path, &ids, notes);
    (errors.len() == before).then(|| Mocap::new(joints, ticks, spec.blend))
}

/// Joint positions sampled at `rate`, Hz, the first `late` seconds after time 0 of the recording, which plays at `speed`.
/// Linear between frames; constant before the first and after the last.
fn resampled(track: &Track, target: &MocapTarget, speed: f64, (late, rate): (f64, f64), samples: usize) -> Vec<f64> {
    let knots = &track.knots;
    let mut at = 0;
    let mut sample = |k: usize| {
        let t = (late + k as f64 / rate) * speed;
        while at + 1 < knots.len() && knots[at + 1].time <= t {
            at += 1;
        }
        let (here, next) = (&knots[at], &knots[(at + 1).min(knots.len() - 1)]);
        let part = if next.time > here.time { ((t - here.time) / (next.time - here.time)).max(0.0) } else { 0.0 };
        target.offset + target.scale * (here.value + part * (next.value - here.value))
    };
    (0..samples).map(&mut sample).collect()
}
