//! Encodes a run as bytes for the page.
//!
//! ```text
//! u32 length of the head | head: JSON | zeros up to a multiple of 8 | columns
//! ```
//!
//! Little-endian. The head describes the contents; `{"at": A, "n": N}` in it refers to N numbers
//! that begin A bytes into the columns: times as f64, indices and offsets as u32, codes as u8, all
//! others as f32, rounded from the log's f64. An absent number (centre of pressure in flight) is
//! NaN.

use crate::log::{ContactPoint, Frame, SelfCollisionSeries, SoleSeries};
use crate::view::drawn_run::DrawnRun;
use foxglove::messages::{Color, LinePrimitive, Point3, Pose, SceneEntity, line_primitive};
use nalgebra::{Isometry3, Vector3};
use serde_json::{Value, json};

/// Version of the encoding; the page refuses others.
const FORMAT: u32 = 1;

/// An encoded run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PackedRun(pub Vec<u8>);

/// Encodes a run, with at most `rate` ticks per second, Hz, if given.
pub fn pack(drawn: &DrawnRun, rate: Option<f64>) -> PackedRun {
    let ticks = drawn.thinned(rate);
    let rows: Vec<usize> = ticks.iter().map(|&i| drawn.rows[i]).collect();
    let mut columns = Columns { ticks: &ticks, rows: &rows, bytes: Vec::new() };
    let times = columns.times(&drawn.times);
    let run = &drawn.run;
    let motion = run.motion.as_ref();
    let head = json!({
        "format": FORMAT,
        "run": {
            "scenario": run.info.scenario, "key": run.info.key, "method": run.info.method,
            "program": run.info.program, "robot": run.info.robot, "complete": run.complete,
        },
        "times": times,
        "world": drawn.world(),
        "frames": drawn.scene.frames.iter().map(|f| frame(f, &mut columns)).collect::<Vec<_>>(),
        "shapes": drawn.scene.entities.iter().flat_map(|e| shapes(e, &mut columns)).collect::<Vec<_>>(),
        "com": motion.map(|m| columns.vectors(&m.com)),
        "cop": motion.map(|m| columns.optional(&m.cop)),
        "stable": motion.map(|m| columns.optional(&m.stable_point)),
        "polygon": motion.map(|m| columns.lists(|i| m.support_polygon[i].iter().flat_map(xyz).collect())),
        "external": motion.map(|m| columns.lists(|i| {
            m.external[i].iter().flat_map(|(at, force)| [at.x, at.y, at.z, force.x, force.y, force.z]).collect()
        })),
        "points": motion.map(|m| m.points.iter().map(|p| json!({
            "name": p.name, "position": columns.optional(&p.position),
        })).collect::<Vec<_>>()),
        "nearest": run.self_collision.as_ref().map(|s| nearest(s, margin(drawn), &mut columns)),
        "soles": run.soles.as_ref().map(|all| all.iter().map(|s| sole(s, &mut columns)).collect::<Vec<_>>()),
        "events": run.events.iter().map(|e| json!({
            "time": e.time, "kind": e.kind, "subject": e.subject, "message": e.message,
        })).collect::<Vec<_>>(),
    });
    PackedRun(columns.after_head(&head.to_string()))
}

/// Columns of numbers, appended one after the other.
struct Columns<'a> {
    /// Indices of the shown ticks among those of the frames, and among those of the run's series.
    ticks: &'a [usize],
    rows: &'a [usize],
    bytes: Vec<u8>,
}

impl Columns<'_> {
    fn put(&mut self, n: usize, numbers: impl IntoIterator<Item = u8>) -> Value {
        self.bytes.resize(self.bytes.len().next_multiple_of(8), 0);
        let at = self.bytes.len();
        self.bytes.extend(numbers);
        json!({ "at": at, "n": n })
    }

    fn floats(&mut self, numbers: &[f64]) -> Value {
        self.put(numbers.len(), numbers.iter().flat_map(|x| (*x as f32).to_le_bytes()))
    }

    fn whole(&mut self, numbers: &[u32]) -> Value {
        self.put(numbers.len(), numbers.iter().flat_map(|x| x.to_le_bytes()))
    }

    fn times(&mut self, times: &[f64]) -> Value {
        let ticks = self.ticks;
        self.put(ticks.len(), ticks.iter().flat_map(|&i| times[i].to_le_bytes()))
    }

    fn vectors(&mut self, series: &[Vector3<f64>]) -> Value {
        let numbers: Vec<f64> = self.rows.iter().flat_map(|&i| xyz(&series[i])).collect();
        self.floats(&numbers)
    }

    fn optional(&mut self, series: &[Option<Vector3<f64>>]) -> Value {
        let absent = Vector3::repeat(f64::NAN);
        let numbers: Vec<f64> = self.rows.iter().flat_map(|&i| xyz(&series[i].unwrap_or(absent))).collect();
        self.floats(&numbers)
    }

    /// Lists of different lengths: their offsets, then all numbers.
    fn lists(&mut self, of: impl Fn(usize) -> Vec<f64>) -> Value {
        let (mut starts, mut all) = (vec![0], Vec::new());
        for &i in self.rows {
            all.extend(of(i));
            starts.push(all.len() as u32);
        }
        json!({ "starts": self.whole(&starts), "numbers": self.floats(&all) })
    }

    fn after_head(self, head: &str) -> Vec<u8> {
        let mut out = (head.len() as u32).to_le_bytes().to_vec();
        out.extend(head.as_bytes());
        out.resize(out.len().next_multiple_of(8), 0);
        out.extend(self.bytes);
        out
    }
}

fn xyz(v: &Vector3<f64>) -> [f64; 3] {
    [v.x, v.y, v.z]
}

/// The distinct texts in order of appearance, and for each text its index among them.
fn distinct<'a>(texts: impl Iterator<Item = &'a str>) -> (Vec<&'a str>, Vec<usize>) {
    let mut names: Vec<&str> = Vec::new();
    let codes = texts.map(|text| {
        names.iter().position(|name| *name == text).unwrap_or_else(|| {
            names.push(text);
            names.len() - 1
        })
    });
    let codes = codes.collect();
    (names, codes)
}

/// A pose as position, then quaternion x, y, z, w.
fn numbers(pose: &Isometry3<f64>) -> [f64; 7] {
    let (p, q) = (&pose.translation.vector, &pose.rotation);
    [p.x, p.y, p.z, q.i, q.j, q.k, q.w]
}

/// Encodes a frame; one that never moves in its parent has one pose.
fn frame(frame: &Frame, columns: &mut Columns) -> Value {
    let first = frame.poses.first().map(numbers).unwrap_or([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
    let fixed = frame.poses.iter().all(|pose| numbers(pose) == first);
    let rows: Vec<f64> = match fixed {
        true => first.to_vec(),
        false => columns.ticks.iter().flat_map(|&i| numbers(&frame.poses[i])).collect(),
    };
    json!({ "name": frame.name, "parent": frame.parent, "fixed": fixed, "poses": columns.floats(&rows) })
}

/// Encodes the nearest pair of the robot's bodies: indices into a list of names, distance, and a
/// point on either body.
fn nearest(series: &SelfCollisionSeries, margin: f64, columns: &mut Columns) -> Value {
    let ticks = columns.rows;
    let (names, codes) = distinct(ticks.iter().map(|&i| series.pair[i].as_str()));
    let codes: Vec<u32> = codes.into_iter().map(|code| code as u32).collect();
    let distances: Vec<f64> = ticks.iter().map(|&i| series.distance[i]).collect();
    let [first, second] = [0, 1].map(|side| {
        let points: Vec<_> = series.points.iter().map(|points| points.map(|both| both[side])).collect();
        columns.optional(&points)
    });
    json!({
        "margin": margin, "pairs": names, "pair": columns.whole(&codes), "distance": columns.floats(&distances),
        "first": first, "second": second,
    })
}

/// Distance that collision avoidance keeps, from the scenario in the log, m; 0 without avoidance.
fn margin(drawn: &DrawnRun) -> f64 {
    let scenario = drawn.run.scenario_text().and_then(|text| text.parse::<toml::Table>().ok());
    let given = scenario.as_ref().and_then(|table| table.get("self_collision")?.get("margin")?.as_float());
    given.unwrap_or(0.0)
}

fn sole(sole: &SoleSeries, columns: &mut Columns) -> Value {
    let ticks = columns.rows;
    let (names, codes) = distinct(ticks.iter().map(|&i| sole.state[i].as_str()));
    // A sole of k vertices has 1 + 2 (2 k + 1) states, so a byte suffices for more than 60
    // vertices; soles have fewer.
    let codes: Vec<u8> = codes.into_iter().map(|code| code as u8).collect();
    let state = columns.put(codes.len(), codes);
    let vertices: Vec<Value> = sole
        .vertices
        .iter()
        .map(|v| {
            let clamped = ticks.iter().map(|&i| u8::from(v.clamped[i]));
            json!({
                "clamped": columns.put(ticks.len(), clamped),
                "position": columns.vectors(&v.position),
                "force": columns.vectors(&v.force),
            })
        })
        .collect();
    // Of other contacts: position, force, and 1 where it is clamped, for each vertex.
    let points = sole.is_link.then(|| {
        let numbers =
            |p: &ContactPoint| [xyz(&p.position), xyz(&p.force)].concat().into_iter().chain([f64::from(p.clamped)]);
        columns.lists(|i| sole.points[i].iter().flat_map(numbers).collect())
    });
    json!({
        "name": sole.name, "states": names, "state": state, "force": columns.vectors(&sole.force), "vertices": vertices,
        "points": points,
    })
}

fn shapes(entity: &SceneEntity, columns: &mut Columns) -> Vec<Value> {
    let mut all = Vec::new();
    let mut add = |kind: &str, pose: &Option<Pose>, colour: &Option<Color>, rest: Value| {
        let mut shape = json!({
            "kind": kind, "frame": entity.frame_id, "entity": entity.id, "pose": pose_numbers(pose), "colour": colour_numbers(colour),
        });
        if let (Value::Object(shape), Value::Object(rest)) = (&mut shape, rest) {
            shape.extend(rest);
        }
        all.push(shape);
    };
    let size = |v: &Option<foxglove::messages::Vector3>| v.as_ref().map_or([1.0; 3], |v| [v.x, v.y, v.z]);
    for s in &entity.cubes {
        add("box", &s.pose, &s.color, json!({ "size": size(&s.size) }));
    }
    for s in &entity.spheres {
        add("sphere", &s.pose, &s.color, json!({ "size": size(&s.size) }));
    }
    for s in &entity.cylinders {
        let ends = [s.bottom_scale, s.top_scale];
        add("cylinder", &s.pose, &s.color, json!({ "size": size(&s.size), "ends": ends }));
    }
    for s in &entity.triangles {
        let rest = json!({ "points": points(&s.points, columns), "indices": columns.whole(&s.indices) });
        add("mesh", &s.pose, &s.color, rest);
    }
    for s in &entity.lines {
        let rest = json!({ "points": points(&s.points, columns), "line": line(s) });
        add("lines", &s.pose, &s.color, rest);
    }
    all
}

fn line(s: &LinePrimitive) -> &'static str {
    match line_primitive::Type::try_from(s.r#type) {
        Ok(line_primitive::Type::LineLoop) => "loop",
        Ok(line_primitive::Type::LineList) => "pairs",
        _ => "strip",
    }
}

fn points(points: &[Point3], columns: &mut Columns) -> Value {
    let numbers: Vec<f64> = points.iter().flat_map(|p| [p.x, p.y, p.z]).collect();
    columns.floats(&numbers)
}

fn pose_numbers(pose: &Option<Pose>) -> [f64; 7] {
    let p = pose.as_ref().and_then(|p| p.position.as_ref()).map_or([0.0; 3], |p| [p.x, p.y, p.z]);
    let q = pose.as_ref().and_then(|p| p.orientation.as_ref()).map_or([0.0, 0.0, 0.0, 1.0], |q| [q.x, q.y, q.z, q.w]);
    [p[0], p[1], p[2], q[0], q[1], q[2], q[3]]
}

fn colour_numbers(colour: &Option<Color>) -> [f64; 4] {
    colour.as_ref().map_or([0.5, 0.5, 0.5, 1.0], |c| [c.r, c.g, c.b, c.a])
}
