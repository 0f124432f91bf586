//! `<keyframe>`: the home posture.

use super::ignored::Ignored;
use super::joints::{Kind, ball_angles};
use super::moving_tree::{Context, Parts};
use super::view::View;
use crate::robot::robot_error::RobotError;

/// The home posture: that of the key `home`, else of the first key, else the reference positions.
///
/// # Errors
/// A `qpos` with the wrong number of values.
pub(super) fn home(context: &Context, parts: &Parts, ignored: &mut Ignored) -> Result<Vec<f64>, RobotError> {
    let document = context.document;
    let mut home = parts.references.clone();
    let keys: Vec<usize> = document.section("keyframe").flat_map(|s| document.children(s).iter().copied()).collect();
    let named = keys.iter().find(|&&id| document.text(id, "name") == Some("home"));
    if let Some(&id) = named.or(keys.first()) {
        let count: usize = parts.file_joints.iter().map(|joint| joint.kind.positions()).sum();
        if let Some(list) = View::bare(document, id).list("qpos", count, count)? {
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
                        home[first..first + 3]
                            .copy_from_slice(&ball_angles([values[0], values[1], values[2], values[3]]));
                    }
                    (Kind::Hinge | Kind::Slide, Some(first)) => home[first] = values[0],
                    _ => {}
                }
            }
        }
        if keys.len() > 1 {
            let used = document.text(id, "name").map_or("the first key".into(), |name| format!("key `{name}`"));
            ignored.note(id, format!("{used} of {} gives the home posture", keys.len()));
        }
    }
    for (joint, home) in parts.joints.iter().zip(&mut home) {
        if !(joint.lower..=joint.upper).contains(home) {
            let id = keys.first().copied().unwrap_or(super::document::ROOT);
            let clamped = home.clamp(joint.lower, joint.upper);
            ignored.note(id, format!("home {home} of joint `{}` is outside its range: {clamped} is used", joint.name));
            *home = clamped;
        }
    }
    Ok(home)
}
