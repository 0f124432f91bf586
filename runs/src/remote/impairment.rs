//! Impairs a link for tests: loses, delays, duplicates and reorders packets, chosen by a seed.

use std::net::SocketAddr;
use std::str::FromStr;
use std::time::{Duration, Instant};

use crate::random::Stream;

/// Network impairment, each kind as a share of the packets sent.
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
    /// Seed of the random choice.
    pub seed: u64,
}

/// Outgoing link with an impairment.
#[derive(Debug)]
pub(super) struct ImpairedLink {
    impairment: Impairment,
    stream: Stream,
    /// Delayed packets with the time of sending; none: after the next packet.
    waiting: Vec<(Option<Instant>, SocketAddr, Vec<u8>)>,
}

impl ImpairedLink {
    pub fn new(impairment: Impairment, side: &str) -> Self {
        ImpairedLink { impairment, stream: Stream::new(impairment.seed, &["link", side]), waiting: Vec::new() }
    }

    /// Accepts a packet; calls `send` for the packets to send now.
    pub fn send(&mut self, packet: &[u8], to: SocketAddr, mut send: impl FnMut(&[u8], SocketAddr)) {
        // Every number is drawn each time, so that one share does not change the packets that
        // another affects.
        let draws =
            [self.stream.unit(), self.stream.unit(), self.stream.unit(), self.stream.unit(), self.stream.unit()];
        let behind: Vec<_> = self.waiting.extract_if(.., |(due, ..)| due.is_none()).collect();
        if draws[0] >= self.impairment.loss {
            let copies = 1 + usize::from(draws[1] < self.impairment.duplicate);
            for _ in 0..copies {
                if draws[2] < self.impairment.reorder {
                    self.waiting.push((None, to, packet.to_vec()));
                } else if draws[3] < self.impairment.delay {
                    let delay = Duration::from_secs_f64(draws[4] * self.impairment.delay_up_to);
                    self.waiting.push((Some(Instant::now() + delay), to, packet.to_vec()));
                } else {
                    send(packet, to);
                }
            }
        }
        behind.iter().for_each(|(_, to, packet)| send(packet, *to));
    }

    /// Sends delayed packets that are due.
    pub fn flush(&mut self, mut send: impl FnMut(&[u8], SocketAddr)) {
        let now = Instant::now();
        for (_, to, packet) in self.waiting.extract_if(.., |(due, ..)| due.is_some_and(|due| due <= now)) {
            send(&packet, to);
        }
    }

    /// Time at which the next delayed packet is due.
    pub fn next(&self) -> Option<Instant> {
        self.waiting.iter().filter_map(|(due, ..)| *due).min()
    }
}

/// Why the text of an impairment is invalid.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ImpairmentError {
    /// An entry without `=`.
    #[error("`{0}` is not of the form `loss=0.2`")]
    Form(String),
    /// An unknown name.
    #[error("`{0}` is none of loss, duplicate, reorder, delay, seed")]
    Unknown(String),
    /// A share outside of its range.
    #[error("`{0}` is not a share of the packets: expected 0 or more, less than 1")]
    Share(String),
    /// A delay without its length.
    #[error("`delay` is a share and seconds, such as `delay=0.2:0.005`")]
    Delay,
    /// A delay outside of its range.
    #[error("`{0}` is not 0 to 10 seconds")]
    Seconds(String),
    /// A seed that is not a whole number.
    #[error("`{0}` is not a whole number")]
    Seed(String),
}

impl FromStr for Impairment {
    type Err = ImpairmentError;

    /// Parses text such as `loss=0.2,duplicate=0.1,reorder=0.1,delay=0.2:0.005,seed=1`; shares not
    /// given are 0.
    fn from_str(text: &str) -> Result<Self, ImpairmentError> {
        let mut impairment =
            Impairment { loss: 0.0, duplicate: 0.0, reorder: 0.0, delay: 0.0, delay_up_to: 0.0, seed: 1 };
        let share = |value: &str| {
            let share = value.parse().ok().filter(|share: &f64| (0.0..1.0).contains(share));
            share.ok_or_else(|| ImpairmentError::Share(value.to_owned()))
        };
        for entry in text.split(',') {
            let (name, value) = entry.split_once('=').ok_or_else(|| ImpairmentError::Form(entry.to_owned()))?;
            match name.trim() {
                "loss" => impairment.loss = share(value)?,
                "duplicate" => impairment.duplicate = share(value)?,
                "reorder" => impairment.reorder = share(value)?,
                "delay" => {
                    let (part, longest) = value.split_once(':').ok_or(ImpairmentError::Delay)?;
                    impairment.delay = share(part)?;
                    let seconds = longest.parse().ok().filter(|s: &f64| (0.0..=10.0).contains(s));
                    impairment.delay_up_to = seconds.ok_or_else(|| ImpairmentError::Seconds(longest.to_owned()))?;
                }
                "seed" => impairment.seed = value.parse().map_err(|_| ImpairmentError::Seed(value.to_owned()))?,
                other => return Err(ImpairmentError::Unknown(other.to_owned())),
            }
        }
        Ok(impairment)
    }
}
