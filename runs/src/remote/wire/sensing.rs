//! Writes and reads the body of a sensing packet.
//!
//! ```text
//! joints n, soles m      u32 each
//! position               n f64, rad or m
//! velocity               n f64, rad/s or m/s
//! load                   n f64, N m or N
//! orientation            4 f64, quaternion w x y z, world from IMU
//! angular velocity       3 f64, IMU axes, rad/s
//! specific force         3 f64, IMU axes, m/s^2
//! with flag BASE         position 3, quaternion 4, velocity 3, angular velocity 3 f64, of the base
//!                        in the world
//! for each sole          force 3, mean force since the last tick 3, N, moment 3, N m, world
//!   with flag VERTICES   number k u32, then k times force 3, N, and clamped u8, 0 or 1
//!   without it           loaded u8, 0 or 1: 1 if the sole's load suffices for stance
//! ```

use nalgebra::{Quaternion, UnitQuaternion};

use crate::dynamics::chain::FrameMotion;
use crate::remote::wire::{Header, Reader, Rejection, Writer, flags};
use crate::task::SensorReadings;

/// Tolerance of a quaternion's norm.
const UNIT: f64 = 1e-6;

/// Appends the body of `sensed` and returns its flags.
pub fn write_sensing(sensed: &SensorReadings, out: &mut Vec<u8>) -> u8 {
    let mut set = 0;
    let mut w = Writer(out);
    w.u32(sensed.position.len() as u32);
    w.u32(sensed.soles.len() as u32);
    for column in [&sensed.position, &sensed.velocity, &sensed.load] {
        w.numbers(column);
    }
    rotation(&sensed.orientation, &mut w);
    w.numbers(sensed.angular_velocity.as_slice());
    w.numbers(sensed.specific_force.as_slice());
    if let Some(base) = &sensed.base {
        set |= flags::BASE;
        w.numbers(base.position.as_slice());
        rotation(&base.rotation, &mut w);
        w.numbers(base.velocity.as_slice());
        w.numbers(base.omega.as_slice());
    }
    let resolved = !sensed.soles.is_empty() && sensed.soles.iter().all(|sole| sole.resolved && sole.corners.is_empty());
    if resolved {
        set |= flags::VERTICES;
    }
    for sole in &sensed.soles {
        for vector in [&sole.force, &sole.mean_force, &sole.moment] {
            w.numbers(vector.as_slice());
        }
        if resolved {
            w.u32(sole.vertices.len() as u32);
            for (force, clamped) in sole.vertices.iter().zip(&sole.clamped) {
                w.numbers(force.as_slice());
                w.bytes(&[u8::from(*clamped)]);
            }
        } else {
            let is_loaded = !sole.corners.is_empty() || sole.clamped.contains(&true);
            w.bytes(&[u8::from(is_loaded)]);
        }
    }
    set
}

fn rotation(rotation: &UnitQuaternion<f64>, w: &mut Writer) {
    w.numbers(&[rotation.w, rotation.i, rotation.j, rotation.k]);
}

fn flag(r: &mut Reader) -> Result<bool, Rejection> {
    match r.bytes::<1>().ok_or(Rejection::Length)? {
        [0] => Ok(false),
        [1] => Ok(true),
        _ => Err(Rejection::Value),
    }
}

fn read_rotation(r: &mut Reader) -> Result<UnitQuaternion<f64>, Rejection> {
    let [w, i, j, k] = [r.number()?, r.number()?, r.number()?, r.number()?];
    let q = Quaternion::new(w, i, j, k);
    // Not normalised again: both sides must hold the same bits.
    if (q.norm() - 1.0).abs() <= UNIT { Ok(UnitQuaternion::new_unchecked(q)) } else { Err(Rejection::Value) }
}

/// Reads a body into `sensed`, which has the robot's size. Allocates nothing.
///
/// # Errors
/// See [`Rejection`]; `sensed` is then partly overwritten.
pub fn read_sensing(header: &Header, body: &[u8], sensed: &mut SensorReadings) -> Result<(), Rejection> {
    let mut r = Reader(body);
    let joints = r.u32().ok_or(Rejection::Length)? as usize;
    let soles = r.u32().ok_or(Rejection::Length)? as usize;
    if joints != sensed.position.len() || soles != sensed.soles.len() {
        return Err(Rejection::Length);
    }
    sensed.time = header.time;
    for column in [&mut sensed.position, &mut sensed.velocity, &mut sensed.load] {
        r.numbers(column)?;
    }
    sensed.orientation = read_rotation(&mut r)?;
    sensed.angular_velocity = r.vector()?;
    sensed.specific_force = r.vector()?;
    sensed.base = if header.flags & flags::BASE == 0 {
        None
    } else {
        let (position, rotation) = (r.vector()?, read_rotation(&mut r)?);
        Some(FrameMotion { position, rotation, velocity: r.vector()?, omega: r.vector()? })
    };
    let resolved = header.flags & flags::VERTICES != 0;
    for sole in &mut sensed.soles {
        (sole.force, sole.mean_force, sole.moment) = (r.vector()?, r.vector()?, r.vector()?);
        sole.resolved = resolved;
        sole.corners.clear();
        if !resolved {
            let loaded = flag(&mut r)?;
            sole.clamped.fill(loaded);
            continue;
        }
        if r.u32().ok_or(Rejection::Length)? as usize != sole.vertices.len() {
            return Err(Rejection::Length);
        }
        for (force, clamped) in sole.vertices.iter_mut().zip(&mut sole.clamped) {
            *force = r.vector()?;
            *clamped = flag(&mut r)?;
        }
    }
    r.done()
}
