//! How near the robot is to touching itself, as series.

use crate::log::messages::SelfCollision;
use nalgebra::Vector3;

/// The nearest pair of bodies at each record, and what avoidance does.
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
    /// Joints kept from where the tasks want them.
    pub frozen: Vec<f64>,
    /// By joint, where avoidance is at work: its name, does it move along its axis, and where the tasks want it, rad or m.
    pub wanted: Vec<(String, bool, Vec<f64>)>,
}

/// Does every row have a value for each joint, or none?
pub(super) fn check(rows: &[SelfCollision], joints: usize) -> Result<(), String> {
    let avoids = rows.first().map_or(0, |r| r.wanted.len());
    for r in rows {
        if r.wanted.len() != r.frozen.len() || r.wanted.len() != avoids || (avoids != 0 && avoids != joints) {
            return Err(format!("/self_collision at {} s does not have a value for each joint", r.time));
        }
    }
    Ok(())
}

/// Rows into columns; needs [`check`].
pub(super) fn series(joints: &[(String, bool)], rows: &[SelfCollision]) -> SelfCollisionSeries {
    let avoids = rows.first().is_some_and(|r| !r.wanted.is_empty());
    let wanted = |(j, (name, slides)): (usize, &(String, bool))| {
        (name.clone(), *slides, rows.iter().map(|r| r.wanted[j]).collect())
    };
    SelfCollisionSeries {
        distance: rows.iter().map(|r| r.distance).collect(),
        pair: rows.iter().map(|r| format!("{}/{}", r.first, r.second)).collect(),
        points: rows.iter().map(points).collect(),
        tests: rows.iter().map(|r| r.tests as f64).collect(),
        frozen: rows.iter().map(|r| r.frozen.iter().filter(|f| **f).count() as f64).collect(),
        wanted: joints.iter().enumerate().filter(|_| avoids).map(wanted).collect(),
    }
}

fn points(row: &SelfCollision) -> Option<[Vector3<f64>; 2]> {
    let [a, b] = [row.on_first.as_ref()?, row.on_second.as_ref()?].map(|v| Vector3::new(v.x, v.y, v.z));
    Some([a, b])
}
