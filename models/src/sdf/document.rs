//! Types of a document: models, links, joints, frames and shapes as written, with positions.

use std::fmt;
use std::ops::Range;
use std::path::PathBuf;

use nalgebra::{Matrix3, Vector3};

use super::pose::Pose;
use super::remarks::Remarks;
use crate::text::source::{Position, Source};

/// Bytes of an element or value in its file.
#[derive(Clone, Debug)]
pub struct At {
    /// The file.
    pub source: Source,
    /// The bytes.
    pub span: Range<usize>,
}

/// Kind of an error.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ErrorKind {
    /// Not well-formed XML.
    Syntax,
    /// No valid SDFormat.
    Invalid,
    /// Valid, but not available here.
    NotAvailable,
}

/// An error at an element.
#[derive(Clone, Debug)]
pub struct SdfError(pub Box<ErrorText>);

/// Position and text of an error.
#[derive(Clone, Debug)]
pub struct ErrorText {
    /// Its position.
    pub at: At,
    /// Its kind.
    pub kind: ErrorKind,
    /// What is wrong.
    pub message: String,
    /// The element it is about.
    pub element: String,
    /// The value found.
    pub found: String,
    /// Description of accepted values.
    pub expected: String,
    /// How to correct it.
    pub help: Option<String>,
}

impl SdfError {
    /// An error at `at`.
    pub fn new(at: At, message: impl Into<String>) -> Self {
        let (element, found, expected) = Default::default();
        let (kind, message) = (ErrorKind::Invalid, message.into());
        SdfError(Box::new(ErrorText { at, kind, message, element, found, expected, help: None }))
    }

    /// Adds the description of accepted values.
    pub fn expected(mut self, expected: impl Into<String>) -> Self {
        self.0.expected = expected.into();
        self
    }

    /// Adds the value found.
    pub fn found(mut self, found: impl fmt::Display) -> Self {
        self.0.found = found.to_string();
        self
    }

    /// Adds the element.
    pub fn element(mut self, element: impl Into<String>) -> Self {
        self.0.element = element.into();
        self
    }

    /// Adds a help line.
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.0.help = Some(help.into());
        self
    }

    /// Marks a feature that this program does not have.
    pub fn not_available(mut self) -> Self {
        self.0.kind = ErrorKind::NotAvailable;
        self
    }

    /// Marks a text that is not well-formed.
    pub fn syntax(mut self) -> Self {
        self.0.kind = ErrorKind::Syntax;
        self
    }

    /// Message with found and expected value, without position.
    pub fn sentence(&self) -> String {
        let found = if self.0.found.is_empty() { String::new() } else { format!(": {}", self.0.found) };
        let expected =
            if self.0.expected.is_empty() { String::new() } else { format!(" (expected {})", self.0.expected) };
        format!("{}{found}{expected}", self.0.message)
    }
}

impl fmt::Display for SdfError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Position { line, column } = self.0.at.source.position(self.0.at.span.start);
        write!(f, "{}:{line}:{column}: {}", self.0.at.source.name(), self.sentence())
    }
}

/// A file with those that it includes.
#[derive(Debug, Default)]
pub struct Document {
    /// Models directly under `<sdf>`.
    pub models: Vec<Model>,
    /// Worlds.
    pub worlds: Vec<World>,
    /// Included files with their bytes, each once.
    pub files: Vec<(PathBuf, Vec<u8>)>,
    /// Notes and warnings.
    pub remarks: Remarks,
}

/// A world.
#[derive(Debug)]
pub struct World {
    /// Its element.
    pub at: At,
    /// Acceleration of free fall, m/s^2, if given.
    pub gravity: Option<([f64; 3], At)>,
    /// Models, included ones too.
    pub models: Vec<Model>,
    /// Frames.
    pub frames: Vec<Frame>,
}

/// A pose as written.
#[derive(Clone, Debug)]
pub struct WrittenPose {
    /// Its value.
    pub pose: Pose,
    /// `relative_to`, if given.
    pub relative_to: Option<String>,
    /// Its element, or that of its owner.
    pub at: At,
}

/// A frame.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Its name.
    pub name: String,
    /// `attached_to`, if given.
    pub attached_to: Option<String>,
    /// Its pose.
    pub pose: WrittenPose,
    /// Its element.
    pub at: At,
}

/// A model.
#[derive(Clone, Debug)]
pub struct Model {
    /// Its name.
    pub name: String,
    /// Its element; of an included one the `<include>`.
    pub at: At,
    /// Whether it is fixed to the world.
    pub is_static: bool,
    /// Its pose.
    pub pose: WrittenPose,
    /// The frame that has this pose; left out: the model's own.
    pub placement_frame: Option<String>,
    /// The link to which the model's frame is attached; left out: the first.
    pub canonical_link: Option<String>,
    /// Links.
    pub links: Vec<Link>,
    /// Joints.
    pub joints: Vec<Joint>,
    /// Frames.
    pub frames: Vec<Frame>,
    /// Nested models, included ones too.
    pub models: Vec<Model>,
}

/// A link.
#[derive(Clone, Debug)]
pub struct Link {
    /// Its name.
    pub name: String,
    /// Its element.
    pub at: At,
    /// Its pose.
    pub pose: WrittenPose,
    /// Mass and inertia; `None` without `<inertial>`.
    pub inertial: Option<Inertial>,
    /// Visual shapes.
    pub visuals: Vec<Shape>,
    /// Collision shapes.
    pub collisions: Vec<Shape>,
    /// Sensors.
    pub sensors: Vec<Sensor>,
}

/// Mass and inertia of a link.
#[derive(Clone, Debug)]
pub struct Inertial {
    /// Its element.
    pub at: At,
    /// Pose of the centre of mass and of the tensor's axes.
    pub pose: WrittenPose,
    /// Mass, kg.
    pub mass: f64,
    /// Inertia tensor about the centre of mass, kg m^2.
    pub tensor: Matrix3<f64>,
}

/// A visual or collision shape.
#[derive(Clone, Debug)]
pub struct Shape {
    /// Its name.
    pub name: String,
    /// Its element.
    pub at: At,
    /// Its pose.
    pub pose: WrittenPose,
    /// Its geometry.
    pub geometry: Geometry,
    /// Red, green, blue, opacity, each 0 to 1, if given.
    pub rgba: Option<[f32; 4]>,
    /// Coefficient of friction, if given, and the second one if it differs.
    pub mu: Option<(f64, Option<f64>)>,
}

/// A geometry, m.
#[derive(Clone, Debug, PartialEq)]
pub enum Geometry {
    /// Edges along x, y, z.
    Box(Vector3<f64>),
    /// Radius, length along z.
    Cylinder(f64, f64),
    /// Radius, length of the cylindrical part along z.
    Capsule(f64, f64),
    /// Radius.
    Sphere(f64),
    /// Radii along x, y, z.
    Ellipsoid(Vector3<f64>),
    /// A mesh file: its URI, scale, and whether only a part of it is used.
    Mesh(String, Vector3<f64>, bool),
    /// The convex hull of points that only the file's reader has; with a mesh file and a scale where
    /// that gives them.
    Hull(Option<(PathBuf, f64)>),
    /// A half-space below its normal.
    Plane(Vector3<f64>),
    /// Heights that the file's reader has.
    Heights(Heights),
    /// Heights as a picture: its URI, size, and position.
    Heightmap(String, Vector3<f64>, Vector3<f64>),
    /// The element's name of another shape, such as `polyline`.
    Other(String),
}

/// Greatest number of heights of one shape: they become part of a scenario's text.
pub const MAX_HEIGHTS: usize = 250_000;

/// A grid of heights about its middle.
#[derive(Clone, Debug, PartialEq)]
pub struct Heights {
    /// Heights, m, by rows along x; the first row is at the least y.
    pub rows: Vec<Vec<f64>>,
    /// Distances of the outer columns and of the outer rows, m.
    pub size: [f64; 2],
}

impl Heights {
    /// Checks the size of a grid before it is read. An error is the reason why it is not.
    pub fn check_size(rows: usize, columns: usize) -> Result<(), String> {
        if rows >= 2 && columns >= 2 && rows.saturating_mul(columns) <= MAX_HEIGHTS {
            return Ok(());
        }
        Err(format!("it has {rows} rows of {columns} heights; from 2 x 2 to {MAX_HEIGHTS} in all are read"))
    }
}

/// A sensor.
#[derive(Clone, Debug)]
pub struct Sensor {
    /// Its name.
    pub name: String,
    /// Its type, such as `imu`.
    pub kind: String,
    /// Its element.
    pub at: At,
    /// Its pose.
    pub pose: WrittenPose,
}

/// A joint.
#[derive(Clone, Debug)]
pub struct Joint {
    /// Its name.
    pub name: String,
    /// Its type, such as `revolute`.
    pub kind: String,
    /// Its element.
    pub at: At,
    /// Its pose.
    pub pose: WrittenPose,
    /// Name of the parent link or frame, or `world`.
    pub parent: (String, At),
    /// Name of the child link or frame.
    pub child: (String, At),
    /// `<axis>` and `<axis2>`.
    pub axes: Vec<Axis>,
    /// Sensors.
    pub sensors: Vec<Sensor>,
}

/// An axis of a joint. Units: rad, N m and s for rotations, m, N and s for translations.
#[derive(Clone, Debug)]
pub struct Axis {
    /// Its element.
    pub at: At,
    /// Direction as written.
    pub xyz: Vector3<f64>,
    /// The frame in which it is written; `None` for the joint's own.
    pub expressed_in: Option<String>,
    /// Lower limit, if there is one.
    pub lower: Option<f64>,
    /// Upper limit, if there is one.
    pub upper: Option<f64>,
    /// Greatest effort, if there is one.
    pub effort: Option<f64>,
    /// Greatest speed, if there is one.
    pub velocity: Option<f64>,
    /// Viscous friction.
    pub damping: f64,
    /// Coulomb friction.
    pub friction: f64,
    /// The joint that it follows.
    pub mimic: Option<Mimic>,
}

/// `q = multiplier (q_leader - reference) + offset`.
#[derive(Clone, Debug)]
pub struct Mimic {
    /// Its element.
    pub at: At,
    /// The joint that leads.
    pub joint: String,
    /// Its axis, `axis` or `axis2`.
    pub axis: String,
    /// Multiplier.
    pub multiplier: f64,
    /// Offset.
    pub offset: f64,
    /// Reference.
    pub reference: f64,
}
