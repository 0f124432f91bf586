//! Motion capture in BVH: a skeleton (`HIERARCHY`) whose joints list channels, then the channels'
//! values frame by frame (`MOTION`) [Meredith 2001, section 3].
//!
//! A track is named `JOINT.CHANNEL`, such as `LeftKnee.Xrotation`. Rotations become radians and are
//! unwrapped: a step of more than half a turn between two frames takes the shorter direction.
//! Positions stay in the file's unit.

use super::{Knot, Motion, MotionError, Track};
use std::collections::HashSet;
use std::f64::consts::TAU;
use std::ops::Range;

const CHANNELS: [&str; 6] = ["Xposition", "Yposition", "Zposition", "Xrotation", "Yrotation", "Zrotation"];

/// Reads a motion from the text of a file; its first frame is at time 0.
///
/// # Errors
/// An unexpected token, an invalid number, a duplicate joint or channel, an unknown channel, no
/// channel, no frame, or fewer or more values than the frames take.
pub fn read(text: &str) -> Result<Motion, MotionError> {
    let mut tokens = Tokens { text, at: 0 };
    tokens.expect("HIERARCHY")?;
    let (mut tracks, mut with_channels): (Vec<Track>, HashSet<String>) = Default::default();
    let mut roots = 0;
    while tokens.peek() == "ROOT" || roots == 0 {
        tokens.expect("ROOT")?;
        read_skeleton(&mut tokens, &mut tracks, &mut with_channels)?;
        roots += 1;
    }
    let span = tokens.next()?;
    if &text[span.clone()] != "MOTION" {
        return Err(tokens.unexpected(span, "`ROOT` or `MOTION`"));
    }
    if tracks.is_empty() {
        return Err(MotionError::new(span, "no joint has a channel"));
    }
    tokens.expect("Frames:")?;
    let span = tokens.next()?;
    let frames: usize = match text[span.clone()].parse() {
        Ok(n) if n > 0 => n,
        _ => return Err(tokens.unexpected(span, "the number of frames, at least 1")),
    };
    tokens.expect("Frame")?;
    tokens.expect("Time:")?;
    let (period, span) = tokens.number("the time between frames")?;
    if period <= 0.0 {
        return Err(MotionError::new(span, format!("the time between frames must be greater than 0, not {period}")));
    }
    for frame in 0..frames {
        for track in &mut tracks {
            let (mut value, span) = tokens.number(&format!("`{}` of frame {frame} of {frames}", track.name))?;
            if track.name.ends_with("rotation") {
                value = value.to_radians();
                if let Some(before) = track.knots.last() {
                    value -= ((value - before.value) / TAU).round() * TAU;
                }
            }
            track.knots.push(Knot { time: frame as f64 * period, value, span });
        }
    }
    if !tokens.peek().is_empty() {
        let span = tokens.next()?;
        return Err(MotionError::new(span, format!("there is more than {frames} frames of {} values", tracks.len())));
    }
    Ok(Motion { tracks })
}

/// Reads a root and its descendants; `ROOT` has been read.
fn read_skeleton(
    tokens: &mut Tokens,
    tracks: &mut Vec<Track>,
    with_channels: &mut HashSet<String>,
) -> Result<(), MotionError> {
    read_joint(tokens, tracks, with_channels)?;
    let mut depth = 1;
    while depth > 0 {
        let span = tokens.next()?;
        match &tokens.text[span.clone()] {
            "JOINT" => {
                read_joint(tokens, tracks, with_channels)?;
                depth += 1;
            }
            "End" => {
                tokens.expect("Site")?;
                tokens.expect("{")?;
                read_offset(tokens)?;
                tokens.expect("}")?;
            }
            "}" => depth -= 1,
            _ => return Err(tokens.unexpected(span, "`JOINT`, `End Site` or `}`")),
        }
    }
    Ok(())
}

/// Reads name, offset and channels of a joint; `with_channels` are the earlier joints with
/// channels.
fn read_joint(
    tokens: &mut Tokens,
    tracks: &mut Vec<Track>,
    with_channels: &mut HashSet<String>,
) -> Result<(), MotionError> {
    let span = tokens.next()?;
    let name = &tokens.text[span.clone()];
    if name == "{" {
        return Err(MotionError::new(span, "the joint has no name"));
    }
    if with_channels.contains(name) {
        return Err(MotionError::new(span, format!("there are two joints `{name}`")));
    }
    let (name, first) = (name.to_owned(), tracks.len());
    tokens.expect("{")?;
    read_offset(tokens)?;
    if tokens.peek() != "CHANNELS" {
        return Ok(());
    }
    tokens.next()?;
    let count = tokens.next()?;
    let Ok(n) = tokens.text[count.clone()].parse::<usize>() else {
        return Err(tokens.unexpected(count, "the number of channels"));
    };
    for _ in 0..n {
        let span = tokens.next()?;
        let channel = &tokens.text[span.clone()];
        if !CHANNELS.contains(&channel) {
            return Err(tokens.unexpected(span, "a channel, such as `Xrotation`"));
        }
        let channel = format!("{name}.{channel}");
        if tracks[first..].iter().any(|t| t.name == channel) {
            return Err(MotionError::new(span, format!("there are two channels `{channel}`")));
        }
        tracks.push(Track { name: channel, span, knots: Vec::new() });
    }
    if n > 0 {
        with_channels.insert(name);
    }
    Ok(())
}

fn read_offset(tokens: &mut Tokens) -> Result<(), MotionError> {
    tokens.expect("OFFSET")?;
    (0..3).try_for_each(|_| tokens.number("a coordinate of the offset").map(|_| ()))
}

/// Tokenizer of a text separated by white space.
struct Tokens<'a> {
    text: &'a str,
    at: usize,
}

impl Tokens<'_> {
    /// Range of the next token; empty at the end.
    fn find(&self) -> Range<usize> {
        let rest = &self.text[self.at..];
        let start = self.at + (rest.len() - rest.trim_start().len());
        let length = self.text[start..].find(char::is_whitespace).unwrap_or(self.text.len() - start);
        start..start + length
    }

    fn peek(&self) -> &str {
        &self.text[self.find()]
    }

    fn next(&mut self) -> Result<Range<usize>, MotionError> {
        let span = self.find();
        if span.is_empty() {
            return Err(MotionError::new(span, "the file ends too early"));
        }
        self.at = span.end;
        Ok(span)
    }

    fn expect(&mut self, token: &str) -> Result<(), MotionError> {
        let span = self.next()?;
        if &self.text[span.clone()] == token { Ok(()) } else { Err(self.unexpected(span, &format!("`{token}`"))) }
    }

    fn number(&mut self, what: &str) -> Result<(f64, Range<usize>), MotionError> {
        let ended =
            |error: MotionError| MotionError { message: format!("{}: {what} is missing", error.message), ..error };
        let span = self.next().map_err(ended)?;
        match self.text[span.clone()].parse::<f64>() {
            Ok(value) if value.is_finite() => Ok((value, span)),
            _ => Err(self.unexpected(span, &format!("a finite number ({what})"))),
        }
    }

    fn unexpected(&self, span: Range<usize>, expected: &str) -> MotionError {
        let message = format!("expected {expected}, not {:?}", &self.text[span.clone()]);
        MotionError::new(span, message)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const VALID: &str = "HIERARCHY\nROOT Hips\n{\n  OFFSET 0 0 0\n  CHANNELS 2 Yposition Zrotation\n  JOINT Arm\n  {\n    \
        OFFSET 0 1 0\n    CHANNELS 1 Xrotation\n    End Site\n    {\n      OFFSET 0 1 0\n    }\n  }\n}\nMOTION\n\
        Frames: 3\nFrame Time: 0.5\n10 90 170\n11 0 -170\n12 -90 -90\n";

    #[test]
    fn channels_are_tracks_in_radians_and_unwrapped() {
        let motion = read(VALID).unwrap();
        let names: Vec<_> = motion.tracks.iter().map(|t| t.name.as_str()).collect();
        assert_eq!(names, ["Hips.Yposition", "Hips.Zrotation", "Arm.Xrotation"]);
        let values = |i: usize| motion.tracks[i].knots.iter().map(|k| k.value).collect::<Vec<_>>();
        assert_eq!(values(0), [10.0, 11.0, 12.0]);
        for (got, expected) in values(2).into_iter().zip([170.0f64, 190.0, 270.0]) {
            // Roundings of angles of some 5 rad.
            assert!((got - expected.to_radians()).abs() < 1e-14);
        }
        assert_eq!(motion.span(), Some((0.0, 1.0)));
    }

    #[test]
    fn errors_carry_their_span() {
        let cases = [
            ("HIERARCHY", "HIRARCHY", "HIRARCHY", "expected `HIERARCHY`, not \"HIRARCHY\""),
            ("ROOT Hips", "JOINT Hips", "JOINT", "expected `ROOT`"),
            ("OFFSET 0 1 0\n    CHANNELS", "OFFSET 0 1 CHANNELS", "CHANNELS", "a finite number (a coordinate"),
            ("Xrotation", "Wrotation", "Wrotation", "a channel, such as `Xrotation`"),
            ("Yposition Zrotation", "Yposition Yposition", "Yposition", "two channels `Hips.Yposition`"),
            ("JOINT Arm", "JOINT Hips", "Hips", "two joints `Hips`"),
            ("JOINT Arm", "LIMB Arm", "LIMB", "`JOINT`, `End Site` or `}`"),
            ("MOTION", "MOTIONS", "MOTIONS", "`ROOT` or `MOTION`"),
            ("Frames: 3", "Frames: 0", "0", "the number of frames"),
            ("Frames: 3", "Frames: 4", "", "ends too early: `Hips.Yposition` of frame 3 of 4 is missing"),
            ("Frames: 3", "Frames: 2", "12", "more than 2 frames of 3 values"),
            ("Time: 0.5", "Time: 0", "0", "greater than 0, not 0"),
            ("-170", "nan", "nan", "a finite number (`Arm.Xrotation` of frame 1 of 3)"),
            ("CHANNELS 2 Yposition Zrotation", "CHANNELS two", "two", "the number of channels"),
        ];
        for (from, to, span, expected) in cases {
            let text = VALID.replacen(from, to, 1);
            let error = read(&text).unwrap_err();
            assert!(error.message.contains(expected), "{to}: {error}");
            assert_eq!(&text[error.span.clone()], span, "{to}: {error}");
        }
        assert!(read("").unwrap_err().message.contains("too early"));
        let still = "HIERARCHY ROOT a { OFFSET 0 0 0 End Site { OFFSET 0 0 0 } } MOTION Frames: 1 Frame Time: 1";
        assert!(read(still).unwrap_err().message.contains("no joint has a channel"));
    }
}
