//! Motions as comma-separated tables: time in the first column, a joint in each of the others.
//!
//! ```text
//! time,left_knee,right_knee
//! 0.0,0.70,0.70
//! 0.5,0.35,
//! ```
//!
//! SI units, angles in radians. An empty cell gives no value for its joint. Lines that begin with
//! `#` are comments. The names that `runner export` writes (`time_s`, `joint.NAME.position_rad`,
//! `joint.NAME.desired_position_rad`, `_m` for prismatic joints) denote the joint.

use super::{Knot, Motion, MotionError};
use std::collections::HashSet;
use std::ops::Range;

/// Reads a motion from the text of a file.
///
/// # Errors
/// No header, or a header without `time` first; a column without a name, with a duplicate name, or
/// of a quantity other than positions; lines of different lengths; cells that are not finite
/// numbers; times that do not increase; a column without numbers.
pub fn read(text: &str) -> Result<Motion, MotionError> {
    let mut lines = lines(text);
    let Some(header) = lines.next() else {
        return Err(
            MotionError::new(0..0, "the file is empty").help("the first line names the columns: `time,JOINT,...`")
        );
    };
    let names = header_names(text, header)?;
    let mut columns: Vec<Vec<Knot>> = vec![Vec::new(); names.len()];
    let mut before: Option<f64> = None;
    for line in lines {
        let cells: Vec<_> = cells(text, line.clone()).collect();
        if cells.len() != names.len() + 1 {
            let message = format!("this line has {} cells, the header {}", cells.len(), names.len() + 1);
            return Err(MotionError::new(line, message));
        }
        let time = number(text, &cells[0], "time")?;
        let time = time.ok_or_else(|| MotionError::new(cells[0].clone(), "the time is missing"))?;
        if time < 0.0 {
            return Err(MotionError::new(cells[0].clone(), format!("the time must be 0 or greater, not {time}")));
        }
        if let Some(before) = before.filter(|before| time <= *before) {
            let message = format!("the time must be after that of the line before, {before}, not {time}");
            return Err(MotionError::new(cells[0].clone(), message));
        }
        before = Some(time);
        for ((column, (name, _)), cell) in columns.iter_mut().zip(&names).zip(&cells[1..]) {
            if let Some(value) = number(text, cell, name)? {
                column.push(Knot { time, value, span: cell.clone() });
            }
        }
    }
    let mut motion = Motion::default();
    for ((name, span), knots) in names.into_iter().zip(columns) {
        if knots.is_empty() {
            return Err(MotionError::new(span, format!("column `{name}` holds no number")));
        }
        motion.tracks.push(super::Track { name, span, knots });
    }
    Ok(motion)
}

/// Names of the columns after `time`, with their spans.
fn header_names(text: &str, header: Range<usize>) -> Result<Vec<(String, Range<usize>)>, MotionError> {
    let mut cells = cells(text, header);
    let first = cells.next().unwrap_or(0..0);
    if !["time", "time_s"].contains(&&text[first.clone()]) {
        let message = format!("the first column must be `time`, not {:?}", &text[first.clone()]);
        return Err(MotionError::new(first, message));
    }
    let (mut names, mut known): (Vec<(String, Range<usize>)>, HashSet<&str>) = Default::default();
    for span in cells {
        let written = &text[span.clone()];
        let name = match parse_column_name(written) {
            ColumnName::Position(name) => name,
            ColumnName::Other(quantity) => {
                let help = "export positions alone: `--columns 'joint.*.desired_position_*'`, or `joint.*.position_*`";
                let message = format!("a motion holds positions, not `{quantity}`");
                return Err(MotionError::new(span, message).help(help));
            }
        };
        if name.is_empty() {
            return Err(MotionError::new(span, "this column has no name"));
        }
        if !known.insert(name) {
            return Err(MotionError::new(span, format!("there are two columns of `{name}`")));
        }
        names.push((name.to_owned(), span));
    }
    if names.is_empty() {
        return Err(MotionError::new(first, "there is no column apart from the time"));
    }
    Ok(names)
}

/// What the name of a column denotes.
enum ColumnName<'a> {
    /// Positions of this joint.
    Position(&'a str),
    /// Another quantity that `runner export` writes.
    Other(&'a str),
}

/// Reads a column name as `runner export` writes it; any other name is a joint's.
fn parse_column_name(written: &str) -> ColumnName<'_> {
    match written.strip_prefix("joint.").and_then(|rest| rest.rsplit_once('.')) {
        Some((name, "position_rad" | "position_m" | "desired_position_rad" | "desired_position_m")) => {
            ColumnName::Position(name)
        }
        Some((_, quantity)) => ColumnName::Other(quantity),
        None => ColumnName::Position(written),
    }
}

/// Lines with content, without line ends.
fn lines(text: &str) -> impl Iterator<Item = Range<usize>> {
    let start = move |line: &str| line.as_ptr() as usize - text.as_ptr() as usize;
    let all = text.lines().map(move |line| start(line)..start(line) + line.len());
    all.filter(|line| !text[line.clone()].trim().is_empty() && !text[line.clone()].trim_start().starts_with('#'))
}

/// Cells of a line, without surrounding blanks and quotes.
fn cells(text: &str, line: Range<usize>) -> impl Iterator<Item = Range<usize>> {
    let mut at = line.start;
    text[line].split(',').map(move |cell| {
        // Spreadsheets write a byte order mark before the first cell.
        let trimmed = cell.trim_start_matches('\u{feff}').trim().trim_matches('"');
        let start = at + (trimmed.as_ptr() as usize - cell.as_ptr() as usize);
        at += cell.len() + 1;
        start..start + trimmed.len()
    })
}

fn number(text: &str, cell: &Range<usize>, name: &str) -> Result<Option<f64>, MotionError> {
    let written = &text[cell.clone()];
    if written.is_empty() {
        return Ok(None);
    }
    match written.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(Some(value)),
        _ => Err(MotionError::new(cell.clone(), format!("`{name}` must be a finite number, not {written:?}"))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_tracks() {
        let text = "# a wave\r\ntime_s, joint.a.b.desired_position_rad ,\"c\"\r\n0.0,1,2\r\n\r\n0.5,,3e-1\r\n";
        let motion = read(text).unwrap();
        let knots = |i: usize| motion.tracks[i].knots.iter().map(|k| (k.time, k.value)).collect::<Vec<_>>();
        assert_eq!((motion.tracks[0].name.as_str(), motion.tracks[1].name.as_str()), ("a.b", "c"));
        assert_eq!(knots(0), [(0.0, 1.0)]);
        assert_eq!(knots(1), [(0.0, 2.0), (0.5, 0.3)]);
        assert_eq!(&text[motion.tracks[1].knots[1].span.clone()], "3e-1");
    }

    #[test]
    fn errors_carry_their_span() {
        let cases = [
            ("", "", "is empty"),
            ("a,b\n0,1\n", "a", "must be `time`"),
            ("time\n0\n", "time", "no column apart from"),
            ("time,a,\n0,1,2\n", "", "has no name"),
            ("time,a,joint.a.position_rad\n0,1,2\n", "joint.a.position_rad", "two columns of `a`"),
            ("time,joint.a.effort_Nm\n0,1\n", "joint.a.effort_Nm", "not `effort_Nm`"),
            ("time,a\n0,1,2\n", "0,1,2", "has 3 cells, the header 2"),
            ("time,a\n0,x\n", "x", "`a` must be a finite number, not \"x\""),
            ("time,a\n0,NaN\n", "NaN", "finite"),
            ("time,a\n,1\n", "", "the time is missing"),
            ("time,a\n-1,1\n", "-1", "0 or greater"),
            ("time,a\n1,1\n1.0,1\n", "1.0", "after that of the line before, 1, not 1"),
            ("time,a\n1,\n", "a", "holds no number"),
        ];
        for (text, span, expected) in cases {
            let error = read(text).unwrap_err();
            assert!(error.message.contains(expected), "{text}: {error}");
            assert_eq!(&text[error.span.clone()], span, "{text}: {error}");
        }
    }
}
