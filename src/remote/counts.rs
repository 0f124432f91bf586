//! What came and went over a link.

use std::fmt;

use crate::remote::wire::Refused;

/// Packets of one side.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Packets sent, those sent again among them.
    pub sent: u64,
    /// Of these, sent again because no answer came.
    pub again: u64,
    /// Packets that were acted on.
    pub received: u64,
    /// Packets of the other side that never came: gaps in its numbers.
    pub missing: u64,
    /// Ticks that went by without fresh control.
    pub stale: u64,
    refused: [u64; Refused::ALL.len()],
}

impl Counts {
    /// One more that was not acted on.
    pub fn refuse(&mut self, why: Refused) {
        self.refused[why as usize] += 1;
    }

    /// How many were not acted on for this reason.
    pub fn refused(&self, why: Refused) -> u64 {
        self.refused[why as usize]
    }
}

impl fmt::Display for Counts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} packets sent, {} received, {} lost on the way here", self.sent, self.received, self.missing)?;
        if self.again > 0 {
            write!(f, ", {} sent again", self.again)?;
        }
        if self.stale > 0 {
            write!(f, ", {} ticks without fresh control", self.stale)?;
        }
        for why in Refused::ALL.into_iter().filter(|why| self.refused(*why) > 0) {
            write!(f, ", {} dropped ({})", self.refused(why), why.name())?;
        }
        Ok(())
    }
}
