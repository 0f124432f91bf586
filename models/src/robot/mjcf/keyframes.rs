//! `<keyframe>`: the home posture, and postures with names.

use std::collections::HashSet;

use super::document::{Id, ROOT};
use super::ignored::Ignored;
use super::joints::{Kind, ball_angles};
use super::moving_tree::{Context, Parts};
use super::view::View;
use crate::robot::model::Keyframe;
use crate::robot::robot_error::RobotError;

/// The home posture: that of the key `home`, else of the first key, else the reference positions; and the
/// postures of all keys with names.
///
/// # Errors
/// A `qpos` with the wrong number of values; two keys with one name.
pub(super) fn read(
    context: &Context,
    parts: &Parts,
    ignored: &mut Ignored,
) -> Result<(Vec<f64>, Vec<Keyframe>), RobotError> {
    let document = context.document;
    let keys: Vec<Id> = document.section("keyframe").flat_map(|s| document.children(s).iter().copied()).collect();
    let name = |id: Id| document.text(id, "name");
    let home_key = keys.iter().find(|&&id| name(id) == Some("home")).or(keys.first()).copied();
    let (mut home, mut keyframes, mut names) = (None, Vec::new(), HashSet::new());
    for &id in keys.iter().filter(|&&id| Some(id) == home_key || name(id).is_some()) {
        let joints = posture(context, parts, id, ignored)?;
        if Some(id) == home_key {
            home = Some(joints.clone());
        }
        let Some(name) = name(id) else { continue };
        if !names.insert(name) {
            let fault = View::bare(document, id).fault("name", "a name that no other key has");
            return Err(fault.found(name).invalid());
        }
        keyframes.push(Keyframe { name: name.to_owned(), joints });
    }
    let home = home.unwrap_or_else(|| within_ranges(parts, parts.references.clone(), ROOT, ignored));
    if let (Some(id), true) = (home_key, keys.len() > 1) {
        let used = name(id).map_or("the first key".into(), |name| format!("key `{name}`"));
        ignored.note(id, format!("{used} of {} gives the home posture", keys.len()));
    }
    Ok((home, keyframes))
}

/// The posture of a key.
fn posture(context: &Context, parts: &Parts, id: Id, ignored: &mut Ignored) -> Result<Vec<f64>, RobotError> {
    let mut posture = parts.references.clone();
    let count: usize = parts.file_joints.iter().map(|joint| joint.kind.positions()).sum();
    if let Some(list) = View::bare(context.document, id).list("qpos", count, count)? {
        let mut at = 0;
        for joint in &parts.file_joints {
            let values = &list[at..at + joint.kind.positions()];
            at += values.len();
            match (joint.kind, joint.first) {
                (Kind::Free, _) if parts.placed[joint.body].is_some() => {
                    let text: Vec<String> = values.iter().map(f64::to_string).collect();
                    let message = "the pose of the base in the key is not read: the scenario sets it; it is";
                    ignored.note(id, format!("{message} {}", text.join(" ")));
                }
                (Kind::Ball, Some(first)) => {
                    posture[first..first + 3]
                        .copy_from_slice(&ball_angles([values[0], values[1], values[2], values[3]]));
                }
                (Kind::Hinge | Kind::Slide, Some(first)) => posture[first] = values[0],
                _ => {}
            }
        }
    }
    Ok(within_ranges(parts, posture, id, ignored))
}

/// The posture with all joints within their ranges.
fn within_ranges(parts: &Parts, mut posture: Vec<f64>, id: Id, ignored: &mut Ignored) -> Vec<f64> {
    for (joint, q) in parts.joints.iter().zip(&mut posture) {
        if !(joint.lower..=joint.upper).contains(q) {
            let clamped = q.clamp(joint.lower, joint.upper);
            ignored.note(id, format!("position {q} of joint `{}` is outside its range: {clamped} is used", joint.name));
            *q = clamped;
        }
    }
    posture
}
