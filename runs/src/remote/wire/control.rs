//! Writes and reads the body of a control packet.
//!
//! ```text
//! next       u64   the next tick for which the sender needs sensing; all bits set: never
//! joints n   u32
//! modes      n u8  0 position, 1 velocity, 2 force, 3 kinematic, 4 passive
//! position   n f64 rad or m
//! velocity   n f64 rad/s or m/s
//! effort     n f64 N m or N
//! kp         n f64 N m/rad or N/m
//! kd         n f64 N m s/rad or N s/m
//! ```

use crate::remote::wire::{Reader, Rejection, Writer};
use crate::robot::DriveMode;
use crate::task::Command;

const MODES: [DriveMode; 5] =
    [DriveMode::Position, DriveMode::Velocity, DriveMode::Force, DriveMode::Kinematic, DriveMode::Passive];

/// Appends the body of `command`.
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

/// Reads a body into `command`, which has the robot's size, and returns its `next` tick.
///
/// # Errors
/// See [`Rejection`]; `command` is then partly overwritten. Gains below 0 are invalid values.
pub fn read_control(body: &[u8], command: &mut Command) -> Result<Option<u64>, Rejection> {
    let mut r = Reader(body);
    let next = r.u64().ok_or(Rejection::Length)?;
    let joints = r.u32().ok_or(Rejection::Length)? as usize;
    if joints != command.mode.len() {
        return Err(Rejection::Length);
    }
    for mode in &mut command.mode {
        let [byte] = r.bytes::<1>().ok_or(Rejection::Length)?;
        *mode = *MODES.get(usize::from(byte)).ok_or(Rejection::Value)?;
    }
    for column in [&mut command.position, &mut command.velocity, &mut command.effort, &mut command.kp, &mut command.kd]
    {
        r.numbers(column)?;
    }
    r.done()?;
    if command.kp.iter().chain(&command.kd).any(|gain| *gain < 0.0) {
        return Err(Rejection::Value);
    }
    Ok(Some(next).filter(|next| *next != u64::MAX))
}
