//! Motion capture in BVH: a skeleton (`HIERARCHY`) whose joints name channels, then the channels' values frame by frame
//! (`MOTION`). Source of the format: M. Meredith and S. Maddock, Motion capture file formats explained, University of
//! Sheffield (2001), section 3.
//!
//! A track is called `JOINT.CHANNEL`, such as `LeftKnee.Xrotation`. Rotations become radians and are unwrapped (a step of
//! more than half a turn between two frames is taken the short way round); positions stay in the file's unit.

use super::{Fault, Knot, Motion, Track};
use std::collections::HashSet;
use std::f64::consts::TAU;
use std::ops::Range;

const CHANNELS: [&str; 6] = ["Xposition", "Yposition", "Zposition", "Xrotation", "Yrotation", "Zrotation"];

/// Reads a motion from the text of a file; its first frame is at time 0.
///
/// # Errors
/// A word where another is wanted, a number that is none, a joint or channel named twice, a channel that there is not, no
/// channel, no frame, fewer or more values than frames take.
pub fn read(text: &str) -> Result<Motion, Fault> {
    let mut words = Words { text, at: 0 };
    words.expect("HIERARCHY")?;
    let (mut tracks, mut moving): (Vec<Track>, HashSet<String>) = Default::default();
    let mut roots = 0;
    while words.peek() == "ROOT" || roots == 0 {
        words.expect("ROOT")?;
        skeleton(&mut words, &mut tracks, &mut moving)?;
        roots += 1;
    }
    let place = words.next()?;
    if &text[place.clone()] != "MOTION" {
        return Err(words.unexpected(place, "`ROOT` or `MOTION`"));
    }
    if tracks.is_empty() {
        return Err(Fault::new(place, "no joint has a channel"));
    }
    words.expect("Frames:")?;
    let place = words.next()?;
    let frames: usize = match text[place.clone()].parse() {
        Ok(n) if n > 0 => n,
        _ => return Err(words.unexpected(place, "the number of frames, at least 1,")),
    };
    words.expect("Frame")?;
    words.expect("Time:")?;
    let (period, place) = words.number("the time between frames")?;
    if period <= 0.0 {
        return Err(Fault::new(place, format!("the time between frames must be greater than 0, not {period}")));
    }
    for frame in 0..frames {
        for track in &mut tracks {
            let (mut value, place) = words.number(&format!("`{}` of frame {frame} of {frames}", track.name))?;
            if track.name.ends_with("rotation") {
                value = value.to_radians();
                if let Some(before) = track.knots.last() {
                    value -= ((value - before.value) / TAU).round() * TAU;
                }
            }
            track.knots.push(Knot { time: frame as f64 * period, value, place });
        }
    }
    if !words.peek().is_empty() {
        let place = words.next()?;
        return Err(Fault::new(place, format!("there is more than {frames} frames of {} values", tracks.len())));
    }
    Ok(Motion { tracks })
}

/// A root and all that hangs on it; `ROOT` has been read.
fn skeleton(words: &mut Words, tracks: &mut Vec<Track>, moving: &mut HashSet<String>) -> Result<(), Fault> {
    let mut depth = 0;
    joint(words, tracks, moving)?;
    depth += 1;
    while depth > 0 {
        let place = words.next()?;
        match &words.text[place.clone()] {
            "JOINT" => {
                joint(words, tracks, moving)?;
                depth += 1;
            }
            "End" => {
                words.expect("Site")?;
                words.expect("{")?;
                offset(words)?;
                words.expect("}")?;
            }
            "}" => depth -= 1,
            _ => return Err(words.unexpected(place, "`JOINT`, `End Site` or `}`")),
        }
    }
    Ok(())
}

/// Name, offset and channels of a joint, up to what hangs on it; `moving` are those before it that have channels.
fn joint(words: &mut Words, tracks: &mut Vec<Track>, moving: &mut HashSet<String>) -> Result<(), Fault> {
    let place = words.next()?;
    let name = &words.text[place.clone()];
    if name == "{" {
        return Err(Fault::new(place, "the joint has no name"));
    }
    if moving.contains(name) {
        return Err(Fault::new(place, format!("there are two joints `{name}`")));
    }
    let (name, first) = (name.to_owned(), tracks.len());
    words.expect("{")?;
    offset(words)?;
    if words.peek() != "CHANNELS" {
        return Ok(());
    }
    words.next()?;
    let count = words.next()?;
    let Ok(n) = words.text[count.clone()].parse::<usize>() else {
        return Err(words.unexpected(count, "the number of channels"));
    };
    for _ in 0..n {
        let place = words.next()?;
        let channel = &words.text[place.clone()];
        if !CHANNELS.contains(&channel) {
            return Err(words.unexpected(place, "a channel, such as `Xrotation`,"));
        }
        let channel = format!("{name}.{channel}");
        if tracks[first..].iter().any(|t| t.name == channel) {
            return Err(Fault::new(place, format!("there are two channels `{channel}`")));
        }
        tracks.push(Track { name: channel, place, knots: Vec::new() });
    }
    if n > 0 {
        moving.insert(name);
    }
    Ok(())
}

fn offset(words: &mut Words) -> Result<(), Fault> {
    words.expect("OFFSET")?;
    (0..3).try_for_each(|_| words.number("a coordinate of the offset").map(|_| ()))
}

/// Reads a text word by word.
struct Words<'a> {
    text: &'a str,
    at: usize,
}

impl Words<'_> {
    /// Where the next word stands; empty at the end.
    fn find(&self) -> Range<usize> {
        let rest = &self.text[self.at..];
        let start = self.at + (rest.len() - rest.trim_start().len());
        let length = self.text[start..].find(char::is_whitespace).unwrap_or(self.text.len() - start);
        start..start + length
    }

    fn peek(&self) -> &str {
        &self.text[self.find()]
    }

    fn next(&mut self) -> Result<Range<usize>, Fault> {
        let place = self.find();
        if place.is_empty() {
            return Err(Fault::new(place, "the file ends too early"));
        }
        self.at = place.end;
        Ok(place)
    }

    fn expect(&mut self, word: &str) -> Result<(), Fault> {
        let place = self.next()?;
        if &self.text[place.clone()] == word { Ok(()) } else { Err(self.unexpected(place, &format!("`{word}`"))) }
    }

    fn number(&mut self, what: &str) -> Result<(f64, Range<usize>), Fault> {
        let ended = |fault: Fault| Fault { message: format!("{}: {what} is missing", fault.message), ..fault };
        let place = self.next().map_err(ended)?;
        match self.text[place.clone()].parse::<f64>() {
            Ok(value) if value.is_finite() => Ok((value, place)),
            _ => Err(self.unexpected(place, &format!("a finite number ({what})"))),
        }
    }

    fn unexpected(&self, place: Range<usize>, wanted: &str) -> Fault {
        let message = format!("{wanted} must stand here, not {:?}", &self.text[place.clone()]);
        Fault::new(place, message)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOUND: &str = "HIERARCHY\nROOT Hips\n{\n  OFFSET 0 0 0\n  CHANNELS 2 Yposition Zrotation\n  JOINT Arm\n  {\n    \
        OFFSET 0 1 0\n    CHANNELS 1 Xrotation\n    End Site\n    {\n      OFFSET 0 1 0\n    }\n  }\n}\nMOTION\n\
        Frames: 3\nFrame Time: 0.5\n10 90 170\n11 0 -170\n12 -90 -90\n";

    #[test]
    fn channels_are_tracks_in_radians_and_unwrapped() {
        let motion = read(SOUND).unwrap();
        let names: Vec<_> = motion.tracks.iter().map(|t| t.name.as_str()).collect();
        assert_eq!(names, ["Hips.Yposition", "Hips.Zrotation", "Arm.Xrotation"]);
        let values = |i: usize| motion.tracks[i].knots.iter().map(|k| k.value).collect::<Vec<_>>();
        assert_eq!(values(0), [10.0, 11.0, 12.0]);
        for (got, wanted) in values(2).into_iter().zip([170.0f64, 190.0, 270.0]) {
            // Roundings of angles of some 5 rad.
            assert!((got - wanted.to_radians()).abs() < 1e-14);
        }
        assert_eq!(motion.span(), Some((0.0, 1.0)));
    }

    #[test]
    fn what_is_wrong_is_told_at_its_place() {
        let cases = [
            ("HIERARCHY", "HIRARCHY", "HIRARCHY", "`HIERARCHY` must stand here, not \"HIRARCHY\""),
            ("ROOT Hips", "JOINT Hips", "JOINT", "`ROOT` must"),
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
        for (from, to, place, words) in cases {
            let text = SOUND.replacen(from, to, 1);
            let fault = read(&text).unwrap_err();
            assert!(fault.message.contains(words), "{to}: {fault}");
            assert_eq!(&text[fault.place.clone()], place, "{to}: {fault}");
        }
        assert!(read("").unwrap_err().message.contains("too early"));
        let still = "HIERARCHY ROOT a { OFFSET 0 0 0 End Site { OFFSET 0 0 0 } } MOTION Frames: 1 Frame Time: 1";
        assert!(read(still).unwrap_err().message.contains("no joint has a channel"));
    }
}
