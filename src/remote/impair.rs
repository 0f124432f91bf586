//! A bad line on purpose: packets that are lost, late, doubled, out of order. Which ones follows from a seed.

use std::str::FromStr;
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
        let draws =
            [self.stream.unit(), self.stream.unit(), self.stream.unit(), self.stream.unit(), self.stream.unit()];
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

impl FromStr for Impairment {
    type Err = String;

    /// Reads words such as `loss=0.2,duplicate=0.1,reorder=0.1,delay=0.2:0.005,seed=1`; what is not named is not bad.
    fn from_str(text: &str) -> Result<Self, String> {
        let mut how = Impairment { loss: 0.0, duplicate: 0.0, reorder: 0.0, delay: 0.0, delay_up_to: 0.0, seed: 1 };
        let share = |value: &str| -> Result<f64, String> {
            let share = value.parse().ok().filter(|share: &f64| (0.0..1.0).contains(share));
            share.ok_or_else(|| format!("`{value}` is no share of the packets: 0 or more, less than 1"))
        };
        for word in text.split(',') {
            let (name, value) = word.split_once('=').ok_or_else(|| format!("`{word}` is not like `loss=0.2`"))?;
            match name.trim() {
                "loss" => how.loss = share(value)?,
                "duplicate" => how.duplicate = share(value)?,
                "reorder" => how.reorder = share(value)?,
                "delay" => {
                    let (part, longest) =
                        value.split_once(':').ok_or("`delay` is a share and seconds, such as `delay=0.2:0.005`")?;
                    how.delay = share(part)?;
                    let seconds = longest.parse().ok().filter(|s: &f64| (0.0..=10.0).contains(s));
                    how.delay_up_to = seconds.ok_or_else(|| format!("`{longest}` is not 0 to 10 seconds"))?;
                }
                "seed" => how.seed = value.parse().map_err(|_| format!("`{value}` is no whole number"))?,
                other => {
                    return Err(format!("`{other}` is none of loss, duplicate, reorder, delay, seed"));
                }
            }
        }
        Ok(how)
    }
}
