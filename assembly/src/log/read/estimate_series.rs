//! Sensor readings and state estimate of a log, as time series.

use crate::log::messages::{Estimate, Wrench};
use crate::log::read::log_error::LogDamage;
use crate::log::read::message_values::{quaternion, vector_or_zero};
use nalgebra::{UnitQuaternion, Vector3};

/// Estimated base and readings of the sensors at the last control tick before each record. World
/// axes unless stated otherwise.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EstimateSeries {
    /// Times of the control ticks, s.
    pub tick: Vec<f64>,
    /// Estimated origin of the root link's URDF frame, m.
    pub base_position: Vec<Vector3<f64>>,
    /// Its estimated orientation.
    pub base_orientation: Vec<UnitQuaternion<f64>>,
    /// Estimated velocity of that origin, m/s.
    pub base_linear_velocity: Vec<Vector3<f64>>,
    /// Estimated angular velocity, rad/s.
    pub base_angular_velocity: Vec<Vector3<f64>>,
    /// Orientation read.
    pub orientation: Vec<UnitQuaternion<f64>>,
    /// Angular velocity of the IMU read, its axes, rad/s.
    pub angular_velocity: Vec<Vector3<f64>>,
    /// Specific force at the IMU read, its axes, m/s^2.
    pub specific_force: Vec<Vector3<f64>>,
    /// The joints in the robot's order.
    pub joints: Vec<JointReadings>,
    /// The soles in the robot's order.
    pub soles: Vec<SoleReadings>,
}

/// Readings of one joint.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JointReadings {
    /// Name in the URDF.
    pub name: String,
    /// True for a prismatic joint.
    pub prismatic: bool,
    /// Positions, rad or m.
    pub position: Vec<f64>,
    /// Velocities.
    pub velocity: Vec<f64>,
    /// Loads, N m or N.
    pub load: Vec<f64>,
}

/// Readings of one sole.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SoleReadings {
    /// Name in the robot file.
    pub name: String,
    /// Forces, N.
    pub force: Vec<Vector3<f64>>,
    /// Moments about the mean of the sole's vertices, N m.
    pub moment: Vec<Vector3<f64>>,
    /// True where the estimator takes the sole as static; `None` if it does not use contacts.
    pub held: Option<Vec<bool>>,
}

/// Checks that every row has a value for each joint and sole.
pub(super) fn check(rows: &[Estimate], joints: usize, soles: usize) -> Result<(), LogDamage> {
    for e in rows {
        let (q, held) = ([&e.q, &e.qd, &e.load], e.static_soles.len());
        if q.iter().any(|a| a.len() != joints) || e.soles.len() != soles || !(held == 0 || held == soles) {
            return Err(LogDamage::Estimate(e.time));
        }
    }
    Ok(())
}

/// Turns rows into columns; they must have passed [`check`].
pub(super) fn series(joints: &[(String, bool)], soles: &[String], rows: &[Estimate]) -> EstimateSeries {
    let triples = |get: fn(&Estimate) -> &Option<crate::log::messages::Vector3>| -> Vec<Vector3<f64>> {
        rows.iter().map(|e| vector_or_zero(get(e))).collect()
    };
    let column = |get: fn(&Estimate) -> &Vec<f64>, j: usize| rows.iter().map(|e| get(e)[j]).collect();
    let of = |s: usize, get: fn(&Wrench) -> &Option<crate::log::messages::Vector3>| {
        rows.iter().map(move |e| vector_or_zero(get(&e.soles[s]))).collect()
    };
    let has_static = rows.first().is_some_and(|e| !e.static_soles.is_empty());
    EstimateSeries {
        tick: rows.iter().map(|e| e.tick).collect(),
        base_position: triples(|e| &e.base_position),
        base_orientation: rows.iter().map(|e| quaternion(e.base_orientation)).collect(),
        base_linear_velocity: triples(|e| &e.base_linear_velocity),
        base_angular_velocity: triples(|e| &e.base_angular_velocity),
        orientation: rows.iter().map(|e| quaternion(e.orientation)).collect(),
        angular_velocity: triples(|e| &e.angular_velocity),
        specific_force: triples(|e| &e.specific_force),
        joints: (joints.iter().enumerate())
            .map(|(j, (name, prismatic))| JointReadings {
                name: name.clone(),
                prismatic: *prismatic,
                position: column(|e| &e.q, j),
                velocity: column(|e| &e.qd, j),
                load: column(|e| &e.load, j),
            })
            .collect(),
        soles: (soles.iter().enumerate())
            .map(|(s, name)| SoleReadings {
                name: name.clone(),
                force: of(s, |w| &w.force),
                moment: of(s, |w| &w.moment),
                held: has_static.then(|| rows.iter().map(|e| e.static_soles[s]).collect()),
            })
            .collect(),
    }
}
