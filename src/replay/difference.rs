//! What differs between a run and the same run made again.

use super::{Again, Change, Left, log, record};
use std::fmt;

/// The first difference of a file.
#[derive(Clone, PartialEq, Debug)]
pub struct Difference {
    /// The file.
    pub file: &'static str,
    /// Where in it: time and column, or the place of a value.
    pub place: String,
    /// What was left and what came of it now, where that can be told in a few words.
    pub values: Option<(String, String)>,
    /// Values that differ besides.
    pub more: usize,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Difference { file, place, values, more } = self;
        write!(f, "{file}: {place}")?;
        if let Some((then, now)) = values {
            write!(f, ": {then} then, {now} now")?;
        }
        match more {
            0 => Ok(()),
            1 => write!(f, " (and 1 more value)"),
            n => write!(f, " (and {n} more values)"),
        }
    }
}

/// The first difference of the log, and that of the record; none: what both say of the run is the same to the last bit.
///
/// Not compared are times that the run took, swept parameters (a run made again is not swept), and what changed inputs
/// change by themselves: hashes, key and program, and the texts attached to the log.
pub fn compare(then: &Left, again: &Again) -> Vec<Difference> {
    let inputs_changed = again.changes.iter().any(Change::is_of_inputs);
    let logs = match (&then.log, &again.left.log) {
        (Some(a), Some(b)) => log::compare(a, b, inputs_changed, then.was_cut()),
        // Its record knows of one.
        (None, _) if then.record.log.is_some() => Some(Difference {
            file: "log.mcap",
            place: "it is missing, and the record knows of one".into(),
            values: None,
            more: 0,
        }),
        _ => None,
    };
    // The metrics of a run that was ended from outside are those of that moment.
    let records = (!then.was_cut()).then(|| record::compare(&then.record, &again.left.record)).flatten();
    logs.into_iter().chain(records).collect()
}
