//! Writes `/scene/contact`, redrawn at every tick: force arrows, clamped vertices, centre of mass,
//! centre of pressure, support polygon, point of optimal stability, and points of tasks.

use crate::files::RecordError;
use crate::log::write::frames_topic::world_frame;
use crate::log::write::log_output::{Channel, LogOutput};
use crate::log::write::proto_writer::ProtoWriter;
use crate::log::write::topic::Topic;
use crate::robot::Model;
use crate::sim::{Snapshot, SoleSnapshot};
use foxglove::messages::{SceneUpdate, line_primitive};
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
    /// Encoded heads of the entities of soles, and of the others.
    soles: Vec<Vec<u8>>,
    others: [Vec<u8>; OTHERS.len()],
    links: Vec<u8>,
    /// True once another link has touched. From then on links have an entity: an empty one replaces its
    /// predecessor.
    has_links: bool,
    metres_per_newton: f64,
    /// Diameter of a vertex marker, m.
    size: f64,
}

/// Entities after those of the soles: external forces, balance, points of tasks.
const OTHERS: [&str; 3] = ["external", "balance", "points"];

/// Fields of `foxglove.SceneEntity`.
const TIMESTAMP: u32 = 1;
const FRAME: u32 = 2;
const ID: u32 = 3;
const FRAME_LOCKED: u32 = 5;
const ARROWS: u32 = 7;
const SPHERES: u32 = 9;
const LINES: u32 = 11;

/// Frame and name of an entity, encoded.
fn head(frame: &str, id: &str) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut to = ProtoWriter::new(&mut bytes);
    to.text(FRAME, frame);
    to.text(ID, id);
    to.uint(FRAME_LOCKED, 1);
    bytes
}

impl MarkerTopic {
    pub fn open(output: &mut LogOutput, model: &Model) -> Result<Self, RecordError> {
        let world = world_frame(model);
        let weight = (model.mass() * STANDARD_GRAVITY).max(f64::MIN_POSITIVE);
        Ok(Self {
            channel: output.foxglove::<SceneUpdate>("/scene/contact")?,
            soles: model.soles.iter().map(|s| head(world, &format!("contact/{}", s.name))).collect(),
            others: OTHERS.map(|id| head(world, id)),
            links: head(world, "contact/links"),
            has_links: false,
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
        /// Field of `foxglove.SceneUpdate`.
        const ENTITIES: u32 = 2;
        self.has_links |= !s.links.is_empty();
        let (size, scale) = (self.size, self.metres_per_newton);
        output.send_fields(&mut self.channel, time, |to| {
            let mut entity = |head: &[u8], draw: &dyn Fn(&mut ProtoWriter)| {
                to.message(ENTITIES, |to| {
                    to.timestamp(TIMESTAMP, time);
                    to.encoded(head);
                    draw(to);
                });
            };
            for (head, sole) in self.soles.iter().zip(&s.soles) {
                entity(head, &|to| draw_soles(std::iter::once(sole), size, scale, to));
            }
            let [external, balance, points] = &self.others;
            entity(external, &|to| {
                s.external.iter().for_each(|(at, force)| write_arrow(at, force, scale, EXTERNAL, to));
            });
            entity(balance, &|to| draw_balance(s, size, to));
            entity(points, &|to| {
                let shown = s.points.iter().filter_map(|point| point.position);
                shown.for_each(|at| write_ball(&at, 1.5 * size, POINT, to));
            });
            if self.has_links {
                entity(&self.links, &|to| draw_soles(s.links.iter().map(|(_, link)| link), size, scale, to));
            }
        })
    }
}

/// Forces and clamped vertices of soles, or of links as one entity.
fn draw_soles<'a>(
    soles: impl Iterator<Item = &'a SoleSnapshot> + Clone,
    size: f64,
    metres_per_newton: f64,
    to: &mut ProtoWriter,
) {
    for sole in soles.clone() {
        let rgba = state_colour(&sole.state);
        for (at, force) in sole.positions.iter().zip(&sole.forces) {
            write_arrow(at, force, metres_per_newton, rgba, to);
        }
    }
    for sole in soles {
        let rgba = state_colour(&sole.state);
        for (at, _) in sole.positions.iter().zip(&sole.clamped).filter(|(_, clamped)| **clamped) {
            write_ball(at, size, rgba, to);
        }
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

fn draw_balance(s: &Snapshot, size: f64, to: &mut ProtoWriter) {
    // Ground without mass has no centre of mass.
    if s.com.iter().all(|x| x.is_finite()) {
        write_ball(&s.com, 2.0 * size, MASS, to);
    }
    s.centre_of_pressure.iter().for_each(|cop| write_ball(cop, 1.5 * size, PRESSURE, to));
    s.stable_point.iter().for_each(|stable| write_ball(stable, 1.5 * size, STABLE, to));
    // An entity replaces its predecessor, so without this list the old polygon vanishes.
    if s.support_polygon.len() < 2 {
        return;
    }
    // Fields of `foxglove.LinePrimitive`.
    to.message(LINES, |to| {
        to.uint(1, line_primitive::Type::LineLoop as u64);
        to.foxglove_pose(2, &Isometry3::identity());
        to.double(3, 2.0);
        to.uint(4, 1);
        to.vectors(5, &s.support_polygon);
        to.foxglove_colour(6, SUPPORT);
    });
}

/// Fields of `foxglove.SpherePrimitive`.
fn write_ball(at: &Vector3<f64>, diameter: f64, rgba: [f32; 4], to: &mut ProtoWriter) {
    to.message(SPHERES, |to| {
        to.foxglove_pose(1, &Isometry3::from_parts((*at).into(), UnitQuaternion::identity()));
        to.numbers(2, [diameter; 3]);
        to.foxglove_colour(3, rgba);
    });
}

/// An arrow from `at` along `force`; none for an invisibly small or non-finite force. Its direction and
/// lengths have single precision, as on the screen: they are drawn only, and compress better.
/// Fields of `foxglove.ArrowPrimitive`.
fn write_arrow(at: &Vector3<f64>, force: &Vector3<f64>, metres_per_newton: f64, rgba: [f32; 4], to: &mut ProtoWriter) {
    let single = |x: f64| f64::from(x as f32);
    let norm = force.norm();
    let length = norm * metres_per_newton;
    if !(length > 1e-3 && length.is_finite()) {
        return;
    }
    let [x, y, z, w] = from_x_axis(&(force / norm));
    let width = (0.06 * length).clamp(0.002, 0.02);
    let head = (0.25 * length).min(0.06);
    to.message(ARROWS, |to| {
        to.message(1, |to| {
            to.vector(1, at);
            to.numbers(2, [x, y, z, w].map(single));
        });
        to.double(2, single(length - head));
        to.double(3, single(width));
        to.double(4, single(head));
        to.double(5, single(2.0 * width));
        to.foxglove_colour(6, rgba);
    });
}

/// The shortest rotation of the x axis, along which an arrow points, to a unit vector: x, y, z, w. Near
/// -x it is nearly half a turn about any axis; at -x it is about z.
///
/// ```text
/// w = sqrt((1 + d_x) / 2),  (x, y, z) = (e_x x d) / 2 w
/// ```
fn from_x_axis(d: &Vector3<f64>) -> [f64; 4] {
    let across = (d.y * d.y + d.z * d.z).sqrt();
    // Half the angle, by its sine and cosine: `1 + d_x` loses all digits near -x.
    let w = if d.x > 0.0 { (0.5 * (1.0 + d.x)).sqrt() } else { across * 0.5 / (0.5 * (1.0 - d.x)).sqrt() };
    let sine = if d.x > 0.0 { across * 0.5 / w } else { (0.5 * (1.0 - d.x)).sqrt() };
    let (y, z) = if across > 0.0 { (-d.z / across, d.y / across) } else { (0.0, 1.0) };
    [0.0, sine * y, sine * z, w]
}

#[cfg(test)]
mod tests {
    use super::*;
    use foxglove::messages::SceneEntity;
    use prost::Message as _;

    /// The arrow of a force, read back as an entity.
    fn arrow(force: &Vector3<f64>) -> Option<foxglove::messages::ArrowPrimitive> {
        let mut bytes = Vec::new();
        write_arrow(&Vector3::zeros(), force, 0.1, STATIC, &mut ProtoWriter::new(&mut bytes));
        SceneEntity::decode(bytes.as_slice()).unwrap().arrows.pop()
    }

    #[test]
    fn an_arrow_has_direction_and_scaled_length_of_its_force() {
        for force in [
            Vector3::new(-3.0, 0.0, 0.0),
            Vector3::new(3.0, 0.0, 0.0),
            Vector3::new(0.0, 0.0, 3.0),
            Vector3::new(0.1, -2.0, 5.0),
            Vector3::new(-1.0, 1e-9, 0.0),
        ] {
            let a = arrow(&force).unwrap();
            let q = a.pose.unwrap().orientation.unwrap();
            let rotation = UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(q.w, q.x, q.y, q.z));
            // Single precision is 6e-8 of each component, which the rotation doubles.
            assert!((rotation * Vector3::x() - force.normalize()).norm() < 3e-7, "{force:?}");
            assert!((a.shaft_length + a.head_length - 0.1 * force.norm()).abs() < 1e-7 * force.norm());
        }
        assert_eq!(arrow(&Vector3::zeros()), None);
        assert_eq!(arrow(&Vector3::repeat(f64::NAN)), None);
    }

    #[test]
    fn the_rotation_of_an_arrow_is_exact_before_rounding_to_single_precision() {
        for (k, x) in [1.0_f64, 0.6, 1e-9, -1e-9, -0.6, -0.999_999_999, -1.0].into_iter().enumerate() {
            let d = Vector3::new(x, (1.0 - x * x).sqrt() * 0.6, -(1.0 - x * x).sqrt() * 0.8).normalize();
            let [i, j, k_part, w] = from_x_axis(&d);
            let rotation = UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(w, i, j, k_part));
            // A few roundings of numbers up to 1.
            assert!((rotation.norm() - 1.0).abs() < 1e-15, "{k}");
            assert!((rotation * Vector3::x() - d).norm() < 2e-15, "{k}");
        }
    }
}
