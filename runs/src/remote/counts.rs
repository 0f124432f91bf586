//! Counts the packets of a link.

use std::fmt;

use crate::remote::wire::Rejection;

/// Packets of one side.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Packets sent, resent ones included.
    pub sent: u64,
    /// Packets resent because there was no answer.
    pub resent: u64,
    /// Packets accepted.
    pub received: u64,
    /// Packets of the other side that were lost: gaps in its sequence numbers.
    pub missing: u64,
    /// Ticks without a new command.
    pub stale: u64,
    rejected: [u64; Rejection::ALL.len()],
}

impl Counts {
    /// Counts a rejected packet.
    pub fn reject(&mut self, reason: Rejection) {
        self.rejected[reason as usize] += 1;
    }

    /// Number of packets rejected for this reason.
    pub fn rejected(&self, reason: Rejection) -> u64 {
        self.rejected[reason as usize]
    }
}

impl fmt::Display for Counts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} packets sent, {} received, {} lost", self.sent, self.received, self.missing)?;
        if self.resent > 0 {
            write!(f, ", {} resent", self.resent)?;
        }
        if self.stale > 0 {
            write!(f, ", {} ticks without a new command", self.stale)?;
        }
        for reason in Rejection::ALL.into_iter().filter(|reason| self.rejected(*reason) > 0) {
            write!(f, ", {} dropped ({})", self.rejected(reason), reason.name())?;
        }
        Ok(())
    }
}
