//! Motions as postures in TOML:
//!
//! ```toml
//! [[posture]]
//! at = 0.5
//! joints = { left_knee = "40 deg", right_knee = "40 deg" }
//! ```
//!
//! A joint moves through the postures that name it; the other postures do not affect it.

use super::{Knot, Motion, MotionError, Track};
use crate::text::angle::Angle;
use crate::text::toml_syntax::TomlError;
use serde::Deserialize;
use std::collections::hash_map::Entry;
use std::collections::{BTreeMap, HashMap};
use toml::Spanned;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    /// For readers only.
    #[serde(default, rename = "description")]
    _description: String,
    posture: Vec<Posture>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Posture {
    at: Spanned<f64>,
    joints: BTreeMap<Spanned<String>, Spanned<Angle>>,
}

/// Reads a motion from the text of a file.
///
/// # Errors
/// Invalid TOML or unknown keys; numbers that are not finite; a time that is negative or does not
/// increase; no posture, or one without joints.
pub fn read(text: &str) -> Result<Motion, MotionError> {
    let file: File = toml::from_str(text).map_err(|error| {
        let TomlError { span: piece, message, help } = TomlError::new(&error, text, true);
        let form = || "a motion is a list of `[[posture]]` with `at` (s) and `joints`".into();
        MotionError::new(piece, message).help(help.unwrap_or_else(form))
    })?;
    let mut motion = Motion::default();
    // Index of the track of each name.
    let mut known: HashMap<String, usize> = HashMap::new();
    let mut before: Option<f64> = None;
    for posture in file.posture {
        let (at, span) = (*posture.at.get_ref(), posture.at.span());
        if !(at >= 0.0 && at.is_finite()) {
            return Err(MotionError::new(span, format!("`at` must be 0 or greater, not {at}")));
        }
        if let Some(before) = before.filter(|before| at <= *before) {
            let message = format!("`at` must be after the posture before it, at {before} s, not {at}");
            return Err(MotionError::new(span, message));
        }
        before = Some(at);
        if posture.joints.is_empty() {
            return Err(MotionError::new(span, "this posture names no joint"));
        }
        for (name, angle) in posture.joints {
            let value = angle.get_ref().value;
            let (knot, span) = (Knot { time: at, value, span: angle.span() }, name.span());
            match known.entry(name.into_inner()) {
                Entry::Occupied(track) => motion.tracks[*track.get()].knots.push(knot),
                Entry::Vacant(free) => {
                    motion.tracks.push(Track { name: free.key().clone(), span, knots: vec![knot] });
                    free.insert(motion.tracks.len() - 1);
                }
            }
        }
    }
    if motion.tracks.is_empty() {
        return Err(MotionError::new(0..0, "there is no posture"));
    }
    Ok(motion)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_joint_moves_through_the_postures_that_name_it() {
        let text =
            "[[posture]]\nat = 0\njoints = { a = 1, b = \"90 deg\" }\n[[posture]]\nat = 0.5\njoints = { b = 0.25 }\n";
        let motion = read(text).unwrap();
        let knots =
            |name: &str| motion.track(name).unwrap().knots.iter().map(|k| (k.time, k.value)).collect::<Vec<_>>();
        assert_eq!(knots("a"), [(0.0, 1.0)]);
        assert_eq!(knots("b"), [(0.0, std::f64::consts::FRAC_PI_2), (0.5, 0.25)]);
        assert_eq!(&text[motion.track("b").unwrap().knots[1].span.clone()], "0.25");
        assert_eq!(motion.span(), Some((0.0, 0.5)));
    }

    #[test]
    fn errors_carry_their_span() {
        let cases = [
            ("posture = []", "", "there is no posture"),
            ("[[posture]]\nat = -1\njoints = { a = 1 }", "-1", "0 or greater, not -1"),
            ("[[posture]]\nat = nan\njoints = { a = 1 }", "nan", "0 or greater, not NaN"),
            (
                "[[posture]]\nat = 1\njoints = { a = 1 }\n[[posture]]\nat = 1.0\njoints = { a = 1 }",
                "1.0",
                "after the posture before it, at 1 s, not 1",
            ),
            ("[[posture]]\nat = 1\njoints = {}", "1", "names no joint"),
            (
                "[[posture]]\nat = 1\njoints = { a = inf }",
                "inf",
                "invalid value: floating point `inf`, expected a finite number of radians or a string such as \"30 deg\"",
            ),
            ("[[posture]]\nat = 1\njoints = { a = \"x\" }", "\"x\"", "radians"),
            ("[[posture]]\nat = 1\njoint = { a = 1 }", "joint", "unknown field `joint`"),
            ("[[posture]]\nat = \n", "", ""),
        ];
        for (text, span, expected) in cases {
            let error = read(text).unwrap_err();
            assert!(error.message.contains(expected), "{text}: {error}");
            assert_eq!(text.get(error.span.clone()).unwrap_or("?").trim(), span, "{text}: {error}");
        }
    }
}
