//! The robot's side: takes control, gives sensing, at each tick of its clock.
//!
//! As fast as control comes, a tick waits for the control that answers it; what was lost is asked for by sending the sensing
//! again. At a pace, a tick waits for its time and takes the newest control that came before; without any the last one goes on.

use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use crate::remote::channel::{Address, Arrived, Channel};
use crate::remote::counts::Counts;
use crate::remote::error::LinkError;
use crate::remote::impair::Impairment;
use crate::remote::wire::{Hello, Kind, Refused, Welcome, fingerprint, flags, read_control, write_sensing};
use crate::remote::{SILENCE, nonce};
use crate::robot::Model;
use crate::sim::CommandSource;
use crate::sim::RunError;
use crate::task::{Command, Sensed};

/// How the robot's clock goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pace {
    /// Each tick waits for its control.
    Free,
    /// This many seconds of the robot's clock per second.
    Times(f64),
}

/// First wait before sensing is sent again, and the longest.
const AGAIN: (Duration, Duration) = (Duration::from_millis(4), Duration::from_millis(64));
/// How long the end of the run is told to a side that does not say that it heard.
const FAREWELL: Duration = Duration::from_millis(500);

/// See the module.
pub struct MotorServer {
    channel: Channel,
    robot: [u8; 32],
    rate: f64,
    pace: Pace,
    cancel: Option<Arc<AtomicBool>>,
    /// The hello that is answered, and whether control has come in its session.
    answers: u64,
    confirmed: bool,
    /// When the clock stood at 0.
    start: Option<Instant>,
    heard: Instant,
    /// What was read last; of a packet that is refused half read.
    read: Command,
    last: Command,
}

impl MotorServer {
    /// Binds the address. `command` is held until control comes.
    pub fn bind(
        address: &Address,
        model: &Model,
        command: &Command,
        (rate, pace): (f64, Pace),
        impairment: Option<Impairment>,
        cancel: Option<Arc<AtomicBool>>,
    ) -> Result<Self, LinkError> {
        Ok(MotorServer {
            channel: Channel::bind(address, impairment.map(|how| (how, "robot")))?,
            robot: fingerprint(model),
            rate,
            pace,
            cancel,
            answers: 0,
            confirmed: false,
            start: None,
            heard: Instant::now(),
            read: command.clone(),
            last: command.clone(),
        })
    }

    /// Where it listens.
    pub fn local(&self) -> Option<SocketAddr> {
        self.channel.local()
    }

    /// What came and went.
    pub fn counts(&self) -> Counts {
        self.channel.counts
    }

    /// Waits for somebody who wants this robot, at most `patience`.
    pub fn wait(&mut self, patience: Option<Duration>) -> Result<(), LinkError> {
        let end = patience.map(|patience| Instant::now() + patience);
        loop {
            self.check_cancelled()?;
            let now = Instant::now();
            if end.is_some_and(|end| now >= end) {
                return Err(self.silent(patience.unwrap_or_default()));
            }
            let slice = now + Duration::from_millis(100);
            if let Some(arrived) = self.channel.receive(end.map_or(slice, |end| end.min(slice)))?
                && self.greet(&arrived)?
            {
                self.heard = Instant::now();
                return Ok(());
            }
        }
    }

    /// Answers a hello; is there a session now that was not there before?
    fn greet(&mut self, arrived: &Arrived) -> Result<bool, LinkError> {
        if arrived.header.kind != Kind::Hello {
            self.channel.counts.refuse(Refused::Session);
            return Ok(false);
        }
        let (from, asked) = (arrived.from, arrived.header.session);
        let again = self.channel.peer == Some(from) && self.answers == asked;
        if self.confirmed && !again {
            self.channel.counts.refuse(Refused::Session);
            return Ok(false);
        }
        if let Err(why) = Hello::read(self.channel.body(arrived)) {
            self.channel.counts.refuse(why);
            return Ok(false);
        }
        if !again {
            self.answers = asked;
            self.channel.begin(nonce(), from);
        }
        let pace = match self.pace {
            Pace::Free => 0.0,
            Pace::Times(times) => times,
        };
        let welcome = Welcome { answers: asked, robot: self.robot, rate: self.rate, pace };
        self.channel.send(Kind::Welcome, (0, 0.0), |out| {
            welcome.write(out);
            0
        })?;
        Ok(!again)
    }

    /// Tells what the sensors say and gives what the joints are asked from now on, and the next tick of interest.
    pub fn exchange(&mut self, sensed: &Sensed, command: &mut Command) -> Result<Option<u64>, LinkError> {
        let tick = (sensed.time * self.rate).round() as u64;
        match self.pace {
            Pace::Times(pace) if self.start.is_some() => self.at_pace(tick, sensed, pace, command),
            _ => self.in_step(tick, sensed, command),
        }
    }

    fn in_step(&mut self, tick: u64, sensed: &Sensed, command: &mut Command) -> Result<Option<u64>, LinkError> {
        let mut wait = AGAIN.0;
        self.tell(tick, sensed, 0)?;
        self.heard = Instant::now();
        let mut resend = self.heard + wait;
        loop {
            self.check_cancelled()?;
            if self.heard.elapsed() >= SILENCE {
                return Err(self.silent(SILENCE));
            }
            match self.channel.receive(resend)? {
                Some(arrived) => {
                    if let Some(next) = self.hear(&arrived, Some(tick))? {
                        command.copy_from(&self.last);
                        if let Pace::Times(_) = self.pace {
                            self.start = Some(Instant::now());
                            return Ok(Some(tick + 1));
                        }
                        return Ok(next);
                    }
                }
                None => {
                    self.channel.counts.again += 1;
                    self.tell(tick, sensed, 0)?;
                    wait = (2 * wait).min(AGAIN.1);
                    resend = Instant::now() + wait;
                }
            }
        }
    }

    fn at_pace(
        &mut self,
        tick: u64,
        sensed: &Sensed,
        pace: f64,
        command: &mut Command,
    ) -> Result<Option<u64>, LinkError> {
        let due = self.start.unwrap_or_else(Instant::now) + Duration::from_secs_f64(sensed.time / pace);
        let mut fresh = false;
        loop {
            self.check_cancelled()?;
            // What has come is read even when the tick is late.
            let slice = due.min(Instant::now() + Duration::from_millis(100));
            match self.channel.receive(slice)? {
                Some(arrived) => fresh |= self.hear(&arrived, None)?.is_some(),
                None if Instant::now() >= due => break,
                None => {}
            }
        }
        if fresh {
            self.heard = Instant::now();
        } else {
            self.channel.counts.stale += 1;
            if self.heard.elapsed() >= SILENCE {
                return Err(self.silent(SILENCE));
            }
        }
        command.copy_from(&self.last);
        self.tell(tick, sensed, 0)?;
        Ok(Some(tick + 1))
    }

    /// Acts on a packet; gives the tick that came with control, if it was control that is wanted: any, or the answer to a tick.
    fn hear(&mut self, arrived: &Arrived, wanted: Option<u64>) -> Result<Option<Option<u64>>, LinkError> {
        match arrived.header.kind {
            Kind::Control => match read_control(self.channel.body(arrived), &mut self.read) {
                Err(why) => self.channel.counts.refuse(why),
                Ok(_) if wanted.is_some_and(|tick| arrived.header.tick != tick) => {
                    self.channel.counts.refuse(Refused::Replayed);
                }
                Ok(next) => {
                    self.channel.take(arrived);
                    self.confirmed = true;
                    self.last.copy_from(&self.read);
                    return Ok(Some(next));
                }
            },
            Kind::Hello => {
                self.greet(arrived)?;
            }
            Kind::Bye => return Err(LinkError::Ended(arrived.from)),
            Kind::Welcome | Kind::Sensing => self.channel.counts.refuse(Refused::Foreign),
        }
        Ok(None)
    }

    fn tell(&mut self, tick: u64, sensed: &Sensed, more: u8) -> Result<(), LinkError> {
        self.channel.send(Kind::Sensing, (tick, sensed.time), |out| write_sensing(sensed, out) | more)
    }

    /// Tells the last of the run, until the other side says that it heard or for half a second.
    pub fn finish(&mut self, sensed: &Sensed) -> Result<(), LinkError> {
        let tick = (sensed.time * self.rate).round() as u64;
        let end = Instant::now() + FAREWELL;
        while Instant::now() < end {
            self.tell(tick, sensed, flags::LAST)?;
            let until = (Instant::now() + AGAIN.1).min(end);
            while let Some(arrived) = self.channel.receive(until)? {
                if arrived.header.kind == Kind::Bye {
                    self.channel.take(&arrived);
                    return Ok(());
                }
            }
        }
        Ok(())
    }

    /// Ends the session before its time.
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
}

impl CommandSource for MotorServer {
    fn exchange(&mut self, sensed: &Sensed, command: &mut Command) -> Result<Option<u64>, RunError> {
        MotorServer::exchange(self, sensed, command).map_err(RunError::from)
    }

    fn finish(&mut self, sensed: &Sensed) -> Result<(), RunError> {
        MotorServer::finish(self, sensed).map_err(RunError::from)
    }

    fn leave(&mut self) -> Vec<String> {
        MotorServer::leave(self);
        vec![format!("link: {}", self.channel.counts)]
    }
}
