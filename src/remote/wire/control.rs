//! The body of a control packet.
//!
//! ```text
//! next       u64   the tick at which the sender wants to hear again; all bits set: never
//! joints n   u32
//! modes      n u8  0 position, 1 velocity, 2 force, 3 kinematic, 4 passive
//! position, velocity, effort, kp, kd: each n f64, rad or m, per s, N m or N, N m/rad or N/m, N m s/rad or N s/m
//! ```

use crate::remote::wire::{Reader, Refused, Writer};
use crate::robot::DriveMode;
use crate::task::Command;

const MODES: [DriveMode; 5] =
    [DriveMode::Position, DriveMode::Velocity, DriveMode::Force, DriveMode::Kinematic, DriveMode::Passive];

/// Appends the body for `command`.
pub fn write_control(command: &Command, next: Option<u64>, out: &mut Vec<u8>) {
    let mut w = Writer(out);
    w.u64(next.unwrap_or(u64::MAX));
    w.u32(command.mode.len() as u32);
    for mode in &command.mode {
        let byte = MODES.iter().position(|m| m == mode).unwrap_or(0) as u8;
        w.bytes(&[byte]);
    }
    for column in [&command.position, &command.velocity, &command.effort, &command.kp, &command.kd] {
        w.numbers(column);
    }
}

/// Reads a body into `command`, which has the robot's size, and gives the tick that comes with it.
///
/// # Errors
/// See [`Refused`]; `command` is then not to be used. Gains below 0 are values that cannot stand there.
pub fn read_control(body: &[u8], command: &mut Command) -> Result<Option<u64>, Refused> {
    let mut r = Reader(body);
    let next = r.u64().ok_or(Refused::Length)?;
    let joints = r.u32().ok_or(Refused::Length)? as usize;
    if joints != command.mode.len() {
        return Err(Refused::Length);
    }
    for mode in &mut command.mode {
        let [byte] = r.bytes::<1>().ok_or(Refused::Length)?;
        *mode = *MODES.get(usize::from(byte)).ok_or(Refused::Value)?;
    }
    for column in [&mut command.position, &mut command.velocity, &mut command.effort, &mut command.kp, &mut command.kd]
    {
        r.numbers(column)?;
    }
    r.done()?;
    if command.kp.iter().chain(&command.kd).any(|gain| *gain < 0.0) {
        return Err(Refused::Value);
    }
    Ok(Some(next).filter(|next| *next != u64::MAX))
}
