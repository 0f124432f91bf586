//! Robot side of a link: sends sensing and receives control at each tick of its clock.
//!
//! At a free pace each tick waits for the control that answers it, and resends its sensing until
//! then. At a fixed pace each tick waits for its time and uses the newest control received before;
//! without one the last command stays in force.
//!
//! A session begins with a confirm that returns the challenge of the welcome. Hellos alone, which may
//! be recorded ones of an earlier session, change nothing.

use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use crate::remote::SILENCE;
use crate::remote::challenge::Challenges;
use crate::remote::channel::{Address, Channel, Packet};
use crate::remote::counts::Counts;
use crate::remote::impairment::Impairment;
use crate::remote::link_error::LinkError;
use crate::remote::wire::{
    Confirm, Hello, Kind, Rejection, Welcome, fingerprint, flags, read_control, session_of, write_sensing,
};
use crate::robot::Model;
use crate::sim::CommandSource;
use crate::sim::RunError;
use crate::task::{Command, SensorReadings};

/// Pace of the robot's clock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pace {
    /// Each tick waits for its control.
    Free,
    /// This many seconds of the robot's clock per second.
    Times(f64),
}

/// First and longest wait before sensing is resent.
const RESEND: (Duration, Duration) = (Duration::from_millis(4), Duration::from_millis(64));
/// Time for which the end of the run is resent without an acknowledgement.
const FINISH: Duration = Duration::from_millis(500);

/// Robot side of a link.
pub struct MotorServer {
    channel: Channel,
    robot: [u8; 32],
    rate: f64,
    pace: Pace,
    cancel: Option<Arc<AtomicBool>>,
    challenges: Challenges,
    /// Number of answered hellos.
    hellos: u64,
    /// Wall-clock instant of time 0.
    start: Option<Instant>,
    last_received: Instant,
    /// Buffer for decoding; partly overwritten by rejected packets.
    buffer: Command,
    last: Command,
}

impl MotorServer {
    /// Binds the address. `command` is in force until the first control.
    pub fn bind(
        address: &Address,
        model: &Model,
        command: &Command,
        (rate, pace): (f64, Pace),
        impairment: Option<Impairment>,
        cancel: Option<Arc<AtomicBool>>,
    ) -> Result<Self, LinkError> {
        Ok(MotorServer {
            channel: Channel::bind(address, impairment.map(|impairment| (impairment, "robot")))?,
            robot: fingerprint(model),
            rate,
            pace,
            cancel,
            challenges: Challenges::new()?,
            hellos: 0,
            start: None,
            last_received: Instant::now(),
            buffer: command.clone(),
            last: command.clone(),
        })
    }

    /// Address on which it listens.
    pub fn local(&self) -> Option<SocketAddr> {
        self.channel.local()
    }

    /// Packet counts.
    pub fn counts(&self) -> Counts {
        self.channel.counts
    }

    /// Waits until a client begins a session, at most `limit`.
    pub fn wait(&mut self, limit: Option<Duration>) -> Result<(), LinkError> {
        let end = limit.map(|limit| Instant::now() + limit);
        loop {
            self.check_cancelled()?;
            let now = Instant::now();
            if end.is_some_and(|end| now >= end) {
                return Err(self.no_client(limit.unwrap_or_default()));
            }
            let slice = now + Duration::from_millis(100);
            if let Some(packet) = self.channel.receive(end.map_or(slice, |end| end.min(slice)))?
                && self.open_session(&packet)?
            {
                self.last_received = Instant::now();
                return Ok(());
            }
        }
    }

    /// Answers a hello, or begins the session of a confirm. Returns whether it began.
    fn open_session(&mut self, packet: &Packet) -> Result<bool, LinkError> {
        let from = packet.from;
        let body = self.channel.body(packet);
        if packet.header.kind == Kind::Hello {
            match Hello::read(body) {
                Ok(_) => self.welcome(from, packet.header.session)?,
                Err(reason) => self.channel.counts.reject(reason),
            }
            return Ok(false);
        }
        match Confirm::read(body) {
            Ok(Confirm { answers, challenge })
                if packet.header.session == session_of(&challenge)
                    && self.challenges.verifies(from, answers, &challenge, Instant::now()) =>
            {
                self.channel.begin(packet.header.session, from);
                self.channel.mark_accepted(packet);
                return Ok(true);
            }
            Ok(_) => self.channel.counts.reject(Rejection::Session),
            Err(reason) => self.channel.counts.reject(reason),
        }
        Ok(false)
    }

    /// Offers a session to the sender of a hello.
    fn welcome(&mut self, to: SocketAddr, hello: u64) -> Result<(), LinkError> {
        self.hellos += 1;
        let pace = match self.pace {
            Pace::Free => 0.0,
            Pace::Times(times) => times,
        };
        let challenge = self.challenges.issue(to, hello, Instant::now());
        let welcome = Welcome { answers: hello, robot: self.robot, rate: self.rate, pace, challenge };
        self.channel.send_to(to, session_of(&challenge), Kind::Welcome, (0, 0.0), |out| {
            welcome.write(out);
            0
        })
    }

    /// Sends the sensor readings, receives the joint commands and returns the next tick for which
    /// the tasks need sensing.
    pub fn exchange(&mut self, sensed: &SensorReadings, command: &mut Command) -> Result<Option<u64>, LinkError> {
        let tick = (sensed.time * self.rate).round() as u64;
        match self.pace {
            Pace::Times(pace) if self.start.is_some() => self.exchange_at_pace(tick, sensed, pace, command),
            _ => self.exchange_in_step(tick, sensed, command),
        }
    }

    fn exchange_in_step(
        &mut self,
        tick: u64,
        sensed: &SensorReadings,
        command: &mut Command,
    ) -> Result<Option<u64>, LinkError> {
        let mut wait = RESEND.0;
        self.send_sensing(tick, sensed, 0)?;
        self.last_received = Instant::now();
        let mut resend = self.last_received + wait;
        loop {
            self.check_cancelled()?;
            if self.last_received.elapsed() >= SILENCE {
                return Err(self.silent(SILENCE));
            }
            match self.channel.receive(resend)? {
                Some(packet) => {
                    if let Some(next) = self.receive(&packet, Some(tick))? {
                        command.copy_from(&self.last);
                        if let Pace::Times(_) = self.pace {
                            self.start = Some(Instant::now());
                            return Ok(Some(tick + 1));
                        }
                        return Ok(next);
                    }
                }
                None => {
                    self.channel.counts.resent += 1;
                    self.send_sensing(tick, sensed, 0)?;
                    wait = (2 * wait).min(RESEND.1);
                    resend = Instant::now() + wait;
                }
            }
        }
    }

    fn exchange_at_pace(
        &mut self,
        tick: u64,
        sensed: &SensorReadings,
        pace: f64,
        command: &mut Command,
    ) -> Result<Option<u64>, LinkError> {
        let due = self.start.unwrap_or_else(Instant::now) + Duration::from_secs_f64(sensed.time / pace);
        let mut fresh = false;
        loop {
            self.check_cancelled()?;
            // Received packets are read even if the tick is late.
            let slice = due.min(Instant::now() + Duration::from_millis(100));
            match self.channel.receive(slice)? {
                Some(packet) => fresh |= self.receive(&packet, None)?.is_some(),
                None if Instant::now() >= due => break,
                None => {}
            }
        }
        if fresh {
            self.last_received = Instant::now();
        } else {
            self.channel.counts.stale += 1;
            if self.last_received.elapsed() >= SILENCE {
                return Err(self.silent(SILENCE));
            }
        }
        command.copy_from(&self.last);
        self.send_sensing(tick, sensed, 0)?;
        Ok(Some(tick + 1))
    }

    /// Processes a packet. Returns the next tick of a control packet, if it is acceptable: any, or
    /// the answer to a tick.
    fn receive(&mut self, packet: &Packet, answer_to: Option<u64>) -> Result<Option<Option<u64>>, LinkError> {
        match packet.header.kind {
            Kind::Control => match read_control(self.channel.body(packet), &mut self.buffer) {
                Err(reason) => self.channel.counts.reject(reason),
                Ok(_) if answer_to.is_some_and(|tick| packet.header.tick != tick) => {
                    self.channel.counts.reject(Rejection::Replayed);
                }
                Ok(next) => {
                    self.channel.mark_accepted(packet);
                    self.last.copy_from(&self.buffer);
                    return Ok(Some(next));
                }
            },
            // The client repeats it until the first sensing arrives.
            Kind::Confirm => self.channel.mark_accepted(packet),
            Kind::Bye => return Err(LinkError::Ended(packet.from)),
            Kind::Hello | Kind::Welcome | Kind::Sensing => self.channel.counts.reject(Rejection::Foreign),
        }
        Ok(None)
    }

    fn send_sensing(&mut self, tick: u64, sensed: &SensorReadings, more_flags: u8) -> Result<(), LinkError> {
        self.channel.send(Kind::Sensing, (tick, sensed.time), |out| write_sensing(sensed, out) | more_flags)
    }

    /// Sends the last readings until the other side acknowledges them, at most for half a second.
    pub fn finish(&mut self, sensed: &SensorReadings) -> Result<(), LinkError> {
        let tick = (sensed.time * self.rate).round() as u64;
        let end = Instant::now() + FINISH;
        while Instant::now() < end {
            self.send_sensing(tick, sensed, flags::LAST)?;
            let until = (Instant::now() + RESEND.1).min(end);
            while let Some(packet) = self.channel.receive(until)? {
                if packet.header.kind == Kind::Bye {
                    self.channel.mark_accepted(&packet);
                    return Ok(());
                }
            }
        }
        Ok(())
    }

    /// Ends the session early.
    pub fn leave(&mut self) {
        let _ = self.channel.send(Kind::Bye, (0, 0.0), |_| 0);
    }

    fn check_cancelled(&self) -> Result<(), LinkError> {
        let cancelled = self.cancel.as_ref().is_some_and(|cancel| cancel.load(Ordering::Relaxed));
        if cancelled { Err(LinkError::Cancelled) } else { Ok(()) }
    }

    fn silent(&self, after: Duration) -> LinkError {
        self.channel.silent(after)
    }

    /// Error after a wait without a client.
    fn no_client(&self, after: Duration) -> LinkError {
        let mut error = self.silent(after);
        if let (LinkError::Silent { found, .. }, true) = (&mut error, self.hellos > 0) {
            *found += &format!("; {} hellos, whose senders did not answer the welcome", self.hellos);
        }
        error
    }
}

impl CommandSource for MotorServer {
    fn exchange(&mut self, sensed: &SensorReadings, command: &mut Command) -> Result<Option<u64>, RunError> {
        MotorServer::exchange(self, sensed, command).map_err(RunError::from)
    }

    fn finish(&mut self, sensed: &SensorReadings) -> Result<(), RunError> {
        MotorServer::finish(self, sensed).map_err(RunError::from)
    }

    fn leave(&mut self) -> Vec<String> {
        MotorServer::leave(self);
        vec![format!("link: {}", self.channel.counts)]
    }
}
