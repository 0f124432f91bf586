//! `mocap` from its entry: channels are mapped to joints, resampled to the control ticks and brought within ranges and
//! speeds.

use super::playback::{shown, text};
use crate::motion::limit::{self, Limited};
use crate::motion::{Track, bvh, columns};
use crate::robot::{JointKind, Model};
use crate::scenario::{Diagnostic, MocapTarget, MocapTask, Run, suggest};
use crate::task::mocap::Mocap;

/// The task at `path`; none when something is wrong, which then is among the errors. What the limits took away is told in
/// the notes.
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
    let rate = run.scenario.control.rate;
    // Three averages over 2 half + 1 samples each are as wide as the window.
    let half = (spec.smoothing * rate / 6.0).round() as usize;
    let length = motion.span()?.1 / spec.speed;
    let shown = length.min(run.scenario.duration - spec.start).max(0.0);
    let samples = (shown * rate).ceil() as usize + 1 + 3 * half;
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
        let mut x = resampled(track, target, spec.speed / rate, samples);
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
        joints.push((id, x));
    }
    (errors.len() == before).then(|| Mocap::new(joints, rate, spec.blend))
}

/// Joint positions at samples `step` seconds of the recording apart, linear between its frames; before the first and after
/// the last it stands.
fn resampled(track: &Track, target: &MocapTarget, step: f64, samples: usize) -> Vec<f64> {
    let knots = &track.knots;
    let mut at = 0;
    let mut sample = |k: usize| {
        let t = k as f64 * step;
        while at + 1 < knots.len() && knots[at + 1].time <= t {
            at += 1;
        }
        let (here, next) = (&knots[at], &knots[(at + 1).min(knots.len() - 1)]);
        let part = if next.time > here.time { ((t - here.time) / (next.time - here.time)).max(0.0) } else { 0.0 };
        target.offset + target.scale * (here.value + part * (next.value - here.value))
    };
    (0..samples).map(&mut sample).collect()
}
