//! A bad line on purpose: packets that are lost, late, doubled, out of order. Which ones follows from a seed.

use std::time::{Duration, Instant};

use crate::random::Stream;

/// How bad the line is, each a share of the packets that are sent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impairment {
    /// Lost.
    pub loss: f64,
    /// Sent twice.
    pub duplicate: f64,
    /// Held back behind the next packet.
    pub reorder: f64,
    /// Late by up to `delay_up_to`.
    pub delay: f64,
    /// Longest delay, s.
    pub delay_up_to: f64,
    /// Of the draws.
    pub seed: u64,
}

/// A line that is as bad.
#[derive(Debug)]
pub(super) struct BadLine {
    how: Impairment,
    stream: Stream,
    /// Packets on their way, with the time at which they go; none: after the next one.
    waiting: Vec<(Option<Instant>, Vec<u8>)>,
}

impl BadLine {
    pub fn new(how: Impairment, side: &str) -> Self {
        BadLine { how, stream: Stream::new(how.seed, &["link", side]), waiting: Vec::new() }
    }

    /// Takes a packet to be sent; `send` gets what goes out now.
    pub fn send(&mut self, packet: &[u8], mut send: impl FnMut(&[u8])) {
        // All are drawn each time: one share does not change what another one hits.
        let draws = [self.stream.unit(), self.stream.unit(), self.stream.unit(), self.stream.unit(), self.stream.unit()];
        let behind: Vec<_> = self.waiting.extract_if(.., |(due, _)| due.is_none()).collect();
        if draws[0] >= self.how.loss {
            let copies = 1 + usize::from(draws[1] < self.how.duplicate);
            for _ in 0..copies {
                if draws[2] < self.how.reorder {
                    self.waiting.push((None, packet.to_vec()));
                } else if draws[3] < self.how.delay {
                    let late = Duration::from_secs_f64(draws[4] * self.how.delay_up_to);
                    self.waiting.push((Some(Instant::now() + late), packet.to_vec()));
                } else {
                    send(packet);
                }
            }
        }
        behind.iter().for_each(|(_, packet)| send(packet));
    }

    /// Sends what is due.
    pub fn flush(&mut self, mut send: impl FnMut(&[u8])) {
        let now = Instant::now();
        for (_, packet) in self.waiting.extract_if(.., |(due, _)| due.is_some_and(|due| due <= now)) {
            send(&packet);
        }
    }

    /// When something is due.
    pub fn next(&self) -> Option<Instant> {
        self.waiting.iter().filter_map(|(due, _)| *due).min()
    }
}
