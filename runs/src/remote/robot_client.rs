//! Task side of a link: connects to a robot, receives its sensing, answers with control.

use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use crate::remote::channel::{Address, Channel};
use crate::remote::counts::Counts;
use crate::remote::impairment::Impairment;
use crate::remote::link_error::LinkError;
use crate::remote::wire::{Confirm, Hello, Kind, Rejection, Welcome, fingerprint, flags, read_sensing, write_control};
use crate::remote::{SILENCE, nonce};
use crate::robot::Model;
use crate::sim::RemoteRobot;
use crate::sim::RunError;
use crate::task::{Command, SensorReadings};

/// Period of hellos and confirms, which are sent until they are answered.
const HELLO_PERIOD: Duration = Duration::from_millis(50);
/// Number of messages that end a session; they are not acknowledged.
const BYES: usize = 5;

/// A robot in another process.
pub struct RobotClient {
    channel: Channel,
    cancel: Option<Arc<AtomicBool>>,
    /// Seconds of its clock per second; none: each tick waits for control.
    pub pace: Option<f64>,
    /// Sent until the first sensing arrives.
    confirm: Option<Confirm>,
    /// The tick answered last, its command and next tick.
    answered: Option<(u64, Command, Option<u64>)>,
    /// Buffer for decoding; partly overwritten by rejected packets.
    buffer: SensorReadings,
}

/// Result of waiting for sensing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RobotMessage {
    /// A tick that needs an answer.
    Tick(u64),
    /// The run has ended.
    Last,
}

impl RobotClient {
    /// Opens a session with the robot at an address.
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
        let mut channel = Channel::bind(&own, impairment.map(|impairment| (impairment, "tasks")))?;
        let hello_number = nonce()?;
        channel.begin(hello_number, address.at);
        let robot = fingerprint(model);
        let mut remote = RobotClient {
            channel,
            cancel,
            pace: None,
            confirm: None,
            answered: None,
            buffer: SensorReadings::blank(model),
        };
        let end = Instant::now() + SILENCE;
        while Instant::now() < end {
            remote.check_cancelled()?;
            let hello = Hello { robot, rate };
            remote.channel.send(Kind::Hello, (0, 0.0), |out| {
                hello.write(out);
                0
            })?;
            let until = (Instant::now() + HELLO_PERIOD).min(end);
            while let Some(packet) = remote.channel.receive(until)? {
                let welcome = match packet.header.kind {
                    Kind::Welcome => Welcome::read(remote.channel.body(&packet)),
                    _ => Err(Rejection::Session),
                };
                match welcome {
                    Ok(welcome) if welcome.answers == hello_number && packet.from == address.at => {
                        if welcome.robot != robot {
                            return Err(LinkError::Robot(address.at));
                        }
                        if welcome.rate != rate {
                            return Err(LinkError::Rate { address: address.at, there: welcome.rate, here: rate });
                        }
                        remote.channel.begin(packet.header.session, address.at);
                        remote.pace = Some(welcome.pace).filter(|pace| *pace > 0.0);
                        remote.confirm = Some(Confirm { answers: hello_number, challenge: welcome.challenge });
                        return Ok(remote);
                    }
                    Ok(_) => remote.channel.counts.reject(Rejection::Session),
                    Err(reason) => remote.channel.counts.reject(reason),
                }
            }
        }
        Err(remote.channel.silent(SILENCE))
    }

    /// Waits for a tick that has not been answered.
    pub fn sense(&mut self, sensed: &mut SensorReadings) -> Result<RobotMessage, LinkError> {
        let mut end = Instant::now() + SILENCE;
        let mut confirm_at = Instant::now();
        loop {
            self.check_cancelled()?;
            let now = Instant::now();
            if now >= end {
                return Err(self.channel.silent(SILENCE));
            }
            let mut until = end.min(now + Duration::from_millis(100));
            if let Some(confirm) = self.confirm {
                if now >= confirm_at {
                    self.channel.send(Kind::Confirm, (0, 0.0), |out| {
                        confirm.write(out);
                        0
                    })?;
                    confirm_at = now + HELLO_PERIOD;
                }
                until = until.min(confirm_at);
            }
            let Some(packet) = self.channel.receive(until)? else { continue };
            match packet.header.kind {
                Kind::Sensing => {}
                Kind::Bye => return Err(LinkError::Ended(packet.from)),
                // A repeated welcome: the hello was duplicated.
                _ => {
                    self.channel.counts.reject(Rejection::Replayed);
                    continue;
                }
            }
            if let Err(reason) = read_sensing(&packet.header, self.channel.body(&packet), &mut self.buffer) {
                self.channel.counts.reject(reason);
                continue;
            }
            let last = packet.header.flags & flags::LAST != 0;
            let tick = packet.header.tick;
            self.channel.mark_accepted(&packet);
            self.confirm = None;
            end = Instant::now() + SILENCE;
            match &self.answered {
                Some((answered, ..)) if !last && tick == *answered => {
                    self.channel.counts.resent += 1;
                    self.send_answer()?;
                }
                Some((answered, ..)) if !last && tick < *answered => {}
                _ => {
                    sensed.clone_from(&self.buffer);
                    return Ok(if last { RobotMessage::Last } else { RobotMessage::Tick(tick) });
                }
            }
        }
    }

    /// Answers a tick with joint commands and the next tick for which sensing is needed.
    pub fn command(&mut self, tick: u64, command: &Command, next: Option<u64>) -> Result<(), LinkError> {
        match &mut self.answered {
            Some((answered, last, last_next)) => {
                (*answered, *last_next) = (tick, next);
                last.copy_from(command);
            }
            none => *none = Some((tick, command.clone(), next)),
        }
        self.send_answer()
    }

    fn send_answer(&mut self) -> Result<(), LinkError> {
        let Some((tick, command, next)) = &self.answered else { return Ok(()) };
        self.channel.send(Kind::Control, (*tick, self.buffer.time), |out| {
            write_control(command, *next, out);
            0
        })
    }

    /// Ends the session.
    pub fn leave(&mut self) {
        for _ in 0..BYES {
            let _ = self.channel.send(Kind::Bye, (0, self.buffer.time), |_| 0);
        }
    }

    /// Packet counts.
    pub fn counts(&self) -> Counts {
        self.channel.counts
    }

    fn check_cancelled(&self) -> Result<(), LinkError> {
        let cancelled = self.cancel.as_ref().is_some_and(|cancel| cancel.load(Ordering::Relaxed));
        if cancelled { Err(LinkError::Cancelled) } else { Ok(()) }
    }
}

impl RemoteRobot for RobotClient {
    fn sense(&mut self, sensed: &mut SensorReadings) -> Result<Option<u64>, RunError> {
        Ok(match RobotClient::sense(self, sensed)? {
            RobotMessage::Tick(tick) => Some(tick),
            RobotMessage::Last => None,
        })
    }

    fn command(&mut self, tick: u64, command: &Command, next: Option<u64>) -> Result<(), RunError> {
        Ok(RobotClient::command(self, tick, command, next)?)
    }

    fn leave(&mut self) -> Vec<String> {
        RobotClient::leave(self);
        vec![format!("link: {}", self.channel.counts)]
    }
}
