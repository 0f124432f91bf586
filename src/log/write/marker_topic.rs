//! Writes `/scene/contact`, redrawn at every tick: force arrows, clamped vertices, centre of mass,
//! centre of pressure, support polygon, point of optimal stability, and points of tasks.

use crate::files::RecordError;
use crate::log::write::conversion::{colour, point, pose, pose_at, timestamp};
use crate::log::write::frames_topic::world_frame;
use crate::log::write::log_output::{Channel, LogOutput};
use crate::log::write::scene_shapes::entity;
use crate::log::write::topic::Topic;
use crate::robot::Model;
use crate::sim::{Snapshot, SoleSnapshot};
use foxglove::messages::{
    ArrowPrimitive, LinePrimitive, SceneEntity, SceneUpdate, SpherePrimitive, Vector3 as Size, line_primitive,
};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};

const STATIC: [f32; 4] = [0.1, 0.65, 0.25, 1.0];
const SLIDING: [f32; 4] = [0.95, 0.5, 0.05, 1.0];
const FREE: [f32; 4] = [0.5, 0.5, 0.5, 1.0];
const EXTERNAL: [f32; 4] = [0.85, 0.1, 0.15, 1.0];
const MASS: [f32; 4] = [0.95, 0.8, 0.1, 1.0];
const PRESSURE: [f32; 4] = [0.7, 0.1, 0.7, 1.0];
const STABLE: [f32; 4] = [0.1, 0.75, 0.85, 1.0];
const POINT: [f32; 4] = [0.1, 0.1, 0.1, 1.0];
const SUPPORT: [f32; 4] = [0.1, 0.35, 0.85, 1.0];

/// Length of an arrow with the robot's weight, m.
const WEIGHT_ARROW: f64 = 0.5;
const STANDARD_GRAVITY: f64 = 9.806_65;

pub(super) struct MarkerTopic {
    channel: Channel,
    /// One entity per sole, then external forces, then balance, then points of tasks, then other links
    /// once any has touched.
    message: SceneUpdate,
    metres_per_newton: f64,
    /// Diameter of a vertex marker, m.
    size: f64,
}

/// Number of entities after those of the soles, without links.
const OTHERS: usize = 3;

impl MarkerTopic {
    pub fn open(output: &mut LogOutput, model: &Model) -> Result<Self, RecordError> {
        let world = world_frame(model);
        let soles = model.soles.iter().map(|s| entity(world, format!("contact/{}", s.name)));
        let others = ["external", "balance", "points"].map(|id| entity(world, id.to_owned()));
        let weight = (model.mass() * STANDARD_GRAVITY).max(f64::MIN_POSITIVE);
        Ok(Self {
            channel: output.foxglove::<SceneUpdate>("/scene/contact")?,
            message: SceneUpdate { deletions: Vec::new(), entities: soles.chain(others).collect() },
            metres_per_newton: WEIGHT_ARROW / weight,
            size: marker_size(model),
        })
    }
}

/// A tenth of the widest sole, limited so that markers are visible and do not hide a foot.
fn marker_size(model: &Model) -> f64 {
    let width =
        model.soles.iter().flat_map(|s| s.vertices.iter().map(|v| (v - s.vertices[0]).norm())).fold(0.0, f64::max);
    (0.1 * width).clamp(0.005, 0.05)
}

impl Topic for MarkerTopic {
    fn record(&mut self, time: u64, s: &Snapshot, output: &mut LogOutput) -> Result<(), RecordError> {
        let stamp = timestamp(time);
        for to in &mut self.message.entities {
            to.timestamp = Some(stamp);
            to.arrows.clear();
            to.spheres.clear();
        }
        if !s.links.is_empty() && self.message.entities.len() == s.soles.len() + OTHERS {
            let frame = self.message.entities[s.soles.len()].frame_id.clone();
            self.message
                .entities
                .push(SceneEntity { timestamp: Some(stamp), ..entity(&frame, "contact/links".to_owned()) });
        }
        let (soles, others) = self.message.entities.split_at_mut(s.soles.len());
        for (to, sole) in soles.iter_mut().zip(&s.soles) {
            draw_sole(sole, self.size, self.metres_per_newton, to);
        }
        if let [external, balance, points, links @ ..] = others {
            if let [to, ..] = links {
                s.links.iter().for_each(|(_, link)| draw_sole(link, self.size, self.metres_per_newton, to));
            }
            for (at, force) in &s.external {
                external.arrows.extend(arrow(at, force, self.metres_per_newton, EXTERNAL));
            }
            draw_balance(s, self.size, balance);
            let shown = s.points.iter().filter_map(|point| point.position);
            points.spheres.extend(shown.map(|at| ball(&at, 1.5 * self.size, POINT)));
        }
        output.send(&mut self.channel, time, &self.message)
    }
}

fn draw_sole(sole: &SoleSnapshot, size: f64, metres_per_newton: f64, to: &mut SceneEntity) {
    let rgba = state_colour(&sole.state);
    for (at, _) in sole.positions.iter().zip(&sole.clamped).filter(|(_, clamped)| **clamped) {
        to.spheres.push(ball(at, size, rgba));
    }
    for (at, force) in sole.positions.iter().zip(&sole.forces) {
        to.arrows.extend(arrow(at, force, metres_per_newton, rgba));
    }
}

fn state_colour(state: &str) -> [f32; 4] {
    if state.ends_with("static") {
        STATIC
    } else if state.ends_with("dynamic") {
        SLIDING
    } else {
        FREE
    }
}

fn draw_balance(s: &Snapshot, size: f64, to: &mut SceneEntity) {
    to.spheres.push(ball(&s.com, 2.0 * size, MASS));
    if let Some(cop) = &s.centre_of_pressure {
        to.spheres.push(ball(cop, 1.5 * size, PRESSURE));
    }
    if let Some(stable) = &s.stable_point {
        to.spheres.push(ball(stable, 1.5 * size, STABLE));
    }
    // An entity replaces its predecessor, so an empty list removes the old polygon.
    if s.support_polygon.len() < 2 {
        to.lines.clear();
        return;
    }
    if to.lines.is_empty() {
        to.lines.push(LinePrimitive {
            r#type: line_primitive::Type::LineLoop.into(),
            pose: Some(pose(&Isometry3::identity())),
            thickness: 2.0,
            scale_invariant: true,
            color: Some(colour(SUPPORT)),
            ..Default::default()
        });
    }
    let points = &mut to.lines[0].points;
    points.clear();
    points.extend(s.support_polygon.iter().map(point));
}

fn ball(at: &Vector3<f64>, diameter: f64, rgba: [f32; 4]) -> SpherePrimitive {
    let size = Size { x: diameter, y: diameter, z: diameter };
    SpherePrimitive { pose: Some(pose_at(at)), size: Some(size), color: Some(colour(rgba)) }
}

/// An arrow from `at` along `force`; none for an invisibly small or non-finite force.
fn arrow(at: &Vector3<f64>, force: &Vector3<f64>, metres_per_newton: f64, rgba: [f32; 4]) -> Option<ArrowPrimitive> {
    let length = force.norm() * metres_per_newton;
    if !(length > 1e-3 && length.is_finite()) {
        return None;
    }
    // An arrow points along x. A force along -x has no unique shortest rotation; it is turned about
    // z.
    let rotation = UnitQuaternion::rotation_between(&Vector3::x(), force)
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::z_axis(), std::f64::consts::PI));
    let width = (0.06 * length).clamp(0.002, 0.02);
    let head = (0.25 * length).min(0.06);
    Some(ArrowPrimitive {
        pose: Some(pose(&Isometry3::from_parts((*at).into(), rotation))),
        shaft_length: length - head,
        shaft_diameter: width,
        head_length: head,
        head_diameter: 2.0 * width,
        color: Some(colour(rgba)),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_arrow_has_direction_and_scaled_length_of_its_force() {
        for force in [
            Vector3::new(-3.0, 0.0, 0.0),
            Vector3::new(3.0, 0.0, 0.0),
            Vector3::new(0.1, -2.0, 5.0),
            Vector3::new(-1.0, 1e-9, 0.0),
        ] {
            let a = arrow(&Vector3::zeros(), &force, 0.1, STATIC).unwrap();
            let q = a.pose.unwrap().orientation.unwrap();
            let rotation = UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(q.w, q.x, q.y, q.z));
            // Error: the acos of a near-parallel pair loses half the digits, 1e-8.
            assert!((rotation * Vector3::x() - force.normalize()).norm() < 1e-7, "{force:?}");
            assert!((a.shaft_length + a.head_length - 0.1 * force.norm()).abs() < 1e-15);
        }
        assert_eq!(arrow(&Vector3::zeros(), &Vector3::zeros(), 0.1, STATIC), None);
        assert_eq!(arrow(&Vector3::zeros(), &Vector3::repeat(f64::NAN), 0.1, STATIC), None);
    }
}
