//! The tasks' side: finds a robot, hears its sensors, answers with control.

use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use crate::remote::channel::{Address, Channel};
use crate::remote::counts::Counts;
use crate::remote::error::LinkError;
use crate::remote::impair::Impairment;
use crate::remote::wire::{Hello, Kind, Refused, Welcome, fingerprint, flags, read_sensing, write_control};
use crate::remote::{SILENCE, nonce};
use crate::robot::Model;
use crate::sim::RemoteRobot;
use crate::sim::RunError;
use crate::task::{Command, Sensed};

/// How often a robot is asked for a session.
const ASK: Duration = Duration::from_millis(50);
/// How often the end of a session is told; nobody answers.
const BYES: usize = 5;

/// A robot somewhere else.
pub struct Remote {
    channel: Channel,
    cancel: Option<Arc<AtomicBool>>,
    /// Seconds of its clock per second; none: it waits for control.
    pub pace: Option<f64>,
    /// The tick that was answered last, with what.
    answered: Option<(u64, Command, Option<u64>)>,
    read: Sensed,
}

/// What was heard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Heard {
    /// A tick that wants an answer.
    Tick(u64),
    /// The run there is over.
    Last,
}

impl Remote {
    /// Asks the robot at an address for a session.
    pub fn connect(
        address: &Address,
        model: &Model,
        rate: f64,
        impairment: Option<Impairment>,
        cancel: Option<Arc<AtomicBool>>,
    ) -> Result<Self, LinkError> {
        address.check()?;
        let here = match address.at.ip() {
            ip if ip.is_loopback() => ip,
            IpAddr::V4(_) => Ipv4Addr::UNSPECIFIED.into(),
            IpAddr::V6(_) => Ipv6Addr::UNSPECIFIED.into(),
        };
        let own = Address { at: SocketAddr::new(here, 0), key: address.key.clone() };
        let mut channel = Channel::bind(&own, impairment.map(|how| (how, "tasks")))?;
        let asked = nonce();
        channel.begin(asked, address.at);
        let robot = fingerprint(model);
        let mut remote = Remote { channel, cancel, pace: None, answered: None, read: Sensed::blank(model) };
        let end = Instant::now() + SILENCE;
        while Instant::now() < end {
            remote.check_cancelled()?;
            let hello = Hello { robot, rate };
            remote.channel.send(Kind::Hello, (0, 0.0), |out| {
                hello.write(out);
                0
            })?;
            let until = (Instant::now() + ASK).min(end);
            while let Some(arrived) = remote.channel.receive(until)? {
                let welcome = match arrived.header.kind {
                    Kind::Welcome => Welcome::read(remote.channel.body(&arrived)),
                    _ => Err(Refused::Session),
                };
                match welcome {
                    Ok(welcome) if welcome.answers == asked && arrived.from == address.at => {
                        if welcome.robot != robot {
                            return Err(LinkError::Robot(address.at));
                        }
                        if welcome.rate != rate {
                            return Err(LinkError::Rate { address: address.at, there: welcome.rate, here: rate });
                        }
                        remote.channel.begin(arrived.header.session, address.at);
                        remote.pace = Some(welcome.pace).filter(|pace| *pace > 0.0);
                        return Ok(remote);
                    }
                    Ok(_) => remote.channel.counts.refuse(Refused::Session),
                    Err(why) => remote.channel.counts.refuse(why),
                }
            }
        }
        Err(remote.channel.silent(SILENCE))
    }

    /// Waits for a tick that was not answered yet, however fast or slow it comes.
    pub fn sense(&mut self, sensed: &mut Sensed) -> Result<Heard, LinkError> {
        let mut end = Instant::now() + SILENCE;
        loop {
            self.check_cancelled()?;
            let now = Instant::now();
            if now >= end {
                return Err(self.channel.silent(SILENCE));
            }
            let Some(arrived) = self.channel.receive(end.min(now + Duration::from_millis(100)))? else { continue };
            match arrived.header.kind {
                Kind::Sensing => {}
                Kind::Bye => return Err(LinkError::Ended(arrived.from)),
                // The welcome again, because the hello had an echo.
                _ => {
                    self.channel.counts.refuse(Refused::Replayed);
                    continue;
                }
            }
            if let Err(why) = read_sensing(&arrived.header, self.channel.body(&arrived), &mut self.read) {
                self.channel.counts.refuse(why);
                continue;
            }
            let last = arrived.header.flags & flags::LAST != 0;
            let tick = arrived.header.tick;
            self.channel.take(&arrived);
            end = Instant::now() + SILENCE;
            match &self.answered {
                Some((answered, ..)) if !last && tick == *answered => {
                    self.channel.counts.again += 1;
                    self.answer_again()?;
                }
                Some((answered, ..)) if !last && tick < *answered => {}
                _ => {
                    sensed.clone_from(&self.read);
                    return Ok(if last { Heard::Last } else { Heard::Tick(tick) });
                }
            }
        }
    }

    /// Answers a tick: what the joints are asked, and the next tick at which there is something to decide.
    pub fn command(&mut self, tick: u64, command: &Command, next: Option<u64>) -> Result<(), LinkError> {
        match &mut self.answered {
            Some((answered, kept, then)) => {
                (*answered, *then) = (tick, next);
                kept.copy_from(command);
            }
            none => *none = Some((tick, command.clone(), next)),
        }
        self.answer_again()
    }

    fn answer_again(&mut self) -> Result<(), LinkError> {
        let Some((tick, command, next)) = &self.answered else { return Ok(()) };
        self.channel.send(Kind::Control, (*tick, self.read.time), |out| {
            write_control(command, *next, out);
            0
        })
    }

    /// Ends the session.
    pub fn leave(&mut self) {
        for _ in 0..BYES {
            let _ = self.channel.send(Kind::Bye, (0, self.read.time), |_| 0);
        }
    }

    /// What came and went.
    pub fn counts(&self) -> Counts {
        self.channel.counts
    }

    fn check_cancelled(&self) -> Result<(), LinkError> {
        let cancelled = self.cancel.as_ref().is_some_and(|cancel| cancel.load(Ordering::Relaxed));
        if cancelled { Err(LinkError::Cancelled) } else { Ok(()) }
    }
}

impl RemoteRobot for Remote {
    fn sense(&mut self, sensed: &mut Sensed) -> Result<Option<u64>, RunError> {
        Ok(match Remote::sense(self, sensed)? {
            Heard::Tick(tick) => Some(tick),
            Heard::Last => None,
        })
    }

    fn command(&mut self, tick: u64, command: &Command, next: Option<u64>) -> Result<(), RunError> {
        Ok(Remote::command(self, tick, command, next)?)
    }

    fn leave(&mut self) -> Vec<String> {
        Remote::leave(self);
        vec![format!("link: {}", self.channel.counts)]
    }
}
