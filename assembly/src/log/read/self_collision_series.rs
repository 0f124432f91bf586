//! Distances between bodies of the robot and the state of collision avoidance, as time series.

use crate::log::messages::SelfCollision;
use crate::log::read::log_error::LogDamage;
use crate::log::read::message_values::vector;
use nalgebra::Vector3;

/// The nearest pair of bodies at each tick, and the state of avoidance.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SelfCollisionSeries {
    /// Distance of the nearest pair, m; below 0 the depth of its overlap.
    pub distance: Vec<f64>,
    /// Names of its bodies, `FIRST/SECOND`.
    pub pair: Vec<String>,
    /// The nearest points of its bodies, world, m.
    pub points: Vec<Option<[Vector3<f64>; 2]>>,
    /// Postures tested in the last cycle.
    pub tests: Vec<f64>,
    /// Number of joints that avoidance keeps from their desired positions.
    pub frozen: Vec<f64>,
    /// With avoidance, by joint: name, whether prismatic, and the positions desired by the tasks,
    /// rad or m.
    pub desired: Vec<(String, bool, Vec<f64>)>,
}

/// Checks that every row has a value for each joint, or that none has.
pub(super) fn check(rows: &[SelfCollision], joints: usize) -> Result<(), LogDamage> {
    let avoids = rows.first().map_or(0, |r| r.wanted.len());
    for r in rows {
        if r.wanted.len() != r.frozen.len() || r.wanted.len() != avoids || (avoids != 0 && avoids != joints) {
            return Err(LogDamage::SelfCollision(r.time));
        }
    }
    Ok(())
}

/// Turns rows into columns; they must have passed [`check`].
pub(super) fn series(joints: &[(String, bool)], rows: &[SelfCollision]) -> SelfCollisionSeries {
    let avoids = rows.first().is_some_and(|r| !r.wanted.is_empty());
    let desired = |(j, (name, prismatic)): (usize, &(String, bool))| {
        (name.clone(), *prismatic, rows.iter().map(|r| r.wanted[j]).collect())
    };
    SelfCollisionSeries {
        distance: rows.iter().map(|r| r.distance).collect(),
        pair: rows.iter().map(|r| format!("{}/{}", r.first, r.second)).collect(),
        points: rows.iter().map(points).collect(),
        tests: rows.iter().map(|r| r.tests as f64).collect(),
        frozen: rows.iter().map(|r| r.frozen.iter().filter(|f| **f).count() as f64).collect(),
        desired: joints.iter().enumerate().filter(|_| avoids).map(desired).collect(),
    }
}

fn points(row: &SelfCollision) -> Option<[Vector3<f64>; 2]> {
    Some([vector(row.on_first.as_ref()?), vector(row.on_second.as_ref()?)])
}
