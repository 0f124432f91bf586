//! The protobuf messages of a log, package `stiction`. World axes, SI units; repeated numbers are
//! packed.
//!
//! `message_descriptor.rs` describes the same fields to other readers; a test compares the two on
//! the wire.

/// A vector.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct Vector3 {
    /// Along x.
    #[prost(double, tag = "1")]
    pub x: f64,
    /// Along y.
    #[prost(double, tag = "2")]
    pub y: f64,
    /// Along z.
    #[prost(double, tag = "3")]
    pub z: f64,
}

/// A unit quaternion.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct Quaternion {
    /// Real part.
    #[prost(double, tag = "1")]
    pub w: f64,
    /// First imaginary part.
    #[prost(double, tag = "2")]
    pub x: f64,
    /// Second imaginary part.
    #[prost(double, tag = "3")]
    pub y: f64,
    /// Third imaginary part.
    #[prost(double, tag = "4")]
    pub z: f64,
}

/// A force on the robot.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct Force {
    /// Point of application, m.
    #[prost(message, optional, tag = "1")]
    pub point: Option<Vector3>,
    /// Force, N.
    #[prost(message, optional, tag = "2")]
    pub force: Option<Vector3>,
}

/// A point shown by a task.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Point {
    /// Its name.
    #[prost(string, tag = "1")]
    pub name: String,
    /// World, m; absent while it is not shown.
    #[prost(message, optional, tag = "2")]
    pub position: Option<Vector3>,
}

/// Motion of the whole robot at one tick, topic `/state`. Joint arrays are in the order of the
/// channel's metadata entry `joints`; the entry `joint_kinds` identifies prismatic ones.
#[derive(Clone, PartialEq, prost::Message)]
pub struct State {
    /// Simulated time, s.
    #[prost(double, tag = "1")]
    pub time: f64,
    /// Origin of the root link's URDF frame, m.
    #[prost(message, optional, tag = "2")]
    pub base_position: Option<Vector3>,
    /// Orientation of the root link's URDF frame.
    #[prost(message, optional, tag = "3")]
    pub base_orientation: Option<Quaternion>,
    /// Velocity of that origin, m/s.
    #[prost(message, optional, tag = "4")]
    pub base_linear_velocity: Option<Vector3>,
    /// Angular velocity of the root link, rad/s.
    #[prost(message, optional, tag = "5")]
    pub base_angular_velocity: Option<Vector3>,
    /// Joint positions, rad or m.
    #[prost(double, repeated, tag = "6")]
    pub q: Vec<f64>,
    /// Joint velocities, rad/s or m/s.
    #[prost(double, repeated, tag = "7")]
    pub qd: Vec<f64>,
    /// Desired joint positions.
    #[prost(double, repeated, tag = "8")]
    pub q_desired: Vec<f64>,
    /// Desired joint velocities.
    #[prost(double, repeated, tag = "9")]
    pub qd_desired: Vec<f64>,
    /// Actuator efforts, N m or N.
    #[prost(double, repeated, tag = "10")]
    pub effort: Vec<f64>,
    /// Centre of mass, m.
    #[prost(message, optional, tag = "11")]
    pub com: Option<Vector3>,
    /// Velocity of the centre of mass, m/s.
    #[prost(message, optional, tag = "12")]
    pub com_velocity: Option<Vector3>,
    /// Centre of pressure on the floor plane, m; absent in flight.
    #[prost(message, optional, tag = "13")]
    pub cop: Option<Vector3>,
    /// Convex hull of the touching vertices, m.
    #[prost(message, repeated, tag = "14")]
    pub support_polygon: Vec<Vector3>,
    /// External forces acting at this tick.
    #[prost(message, repeated, tag = "15")]
    pub external: Vec<Force>,
    /// Point of optimal stability: middle of the centres of the largest discs in the support
    /// polygon, on the floor plane, m; absent in flight.
    #[prost(message, optional, tag = "16")]
    pub stable_point: Option<Vector3>,
    /// Efforts commanded by the drives, before limits and lag, N m or N; equal to `effort` where they differ by
    /// rounding only.
    #[prost(double, repeated, tag = "17")]
    pub effort_desired: Vec<f64>,
    /// Points shown by tasks, in a fixed order; later tasks append theirs.
    #[prost(message, repeated, tag = "18")]
    pub points: Vec<Point>,
}

/// One sole at one tick. Arrays have one entry per vertex.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Sole {
    /// Name in the robot file.
    #[prost(string, tag = "1")]
    pub name: String,
    /// `free`, or pattern and mode.
    #[prost(string, tag = "2")]
    pub state: String,
    /// True for a vertex that is clamped to the floor.
    #[prost(bool, repeated, tag = "3")]
    pub clamped: Vec<bool>,
    /// Vertex positions, m.
    #[prost(message, repeated, tag = "4")]
    pub positions: Vec<Vector3>,
    /// Vertex velocities, m/s.
    #[prost(message, repeated, tag = "5")]
    pub velocities: Vec<Vector3>,
    /// Forces of the floor on the vertices, N.
    #[prost(message, repeated, tag = "6")]
    pub forces: Vec<Vector3>,
    /// Sum of `forces`, N.
    #[prost(message, optional, tag = "7")]
    pub force: Option<Vector3>,
}

/// Poses of the links of objects at one tick, topic `/objects`. The channel's metadata names them.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Objects {
    /// Simulated time, s.
    #[prost(double, tag = "1")]
    pub time: f64,
    /// Seven numbers for each: origin of its frame in the world, m, and orientation w, x, y, z.
    #[prost(double, repeated, tag = "2")]
    pub poses: Vec<f64>,
}

/// Closed loops and couplings of the robot at one tick, topic `/loops`. The channel's metadata names them.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Loops {
    /// Simulated time, s.
    #[prost(double, tag = "1")]
    pub time: f64,
    /// Force on the first link of each loop at the origin of its first frame, world, N.
    #[prost(message, repeated, tag = "2")]
    pub forces: Vec<Vector3>,
    /// Moment on it, N m.
    #[prost(message, repeated, tag = "3")]
    pub moments: Vec<Vector3>,
    /// Greatest error of a condition of each loop, m or rad.
    #[prost(double, repeated, tag = "4")]
    pub errors: Vec<f64>,
    /// Effort of each coupling on its following joint, N m or N.
    #[prost(double, repeated, tag = "5")]
    pub coupling_efforts: Vec<f64>,
    /// Position of that joint less what the coupling gives it, rad or m.
    #[prost(double, repeated, tag = "6")]
    pub coupling_errors: Vec<f64>,
}

/// All soles at one tick, topic `/contact`.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Contact {
    /// Simulated time, s.
    #[prost(double, tag = "1")]
    pub time: f64,
    /// The soles in the model's order.
    #[prost(message, repeated, tag = "2")]
    pub soles: Vec<Sole>,
    /// Other contacts, closed or about to close, by name: of links with the floor, and of pairs of bodies
    /// (`A on B`). Their vertices change.
    #[prost(message, repeated, tag = "3")]
    pub links: Vec<Sole>,
}

/// Residuals and energy balance at one tick, topic `/residual`.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct Residual {
    /// Simulated time, s.
    #[prost(double, tag = "1")]
    pub time: f64,
    /// Deepest vertex below the floor, m.
    #[prost(double, tag = "2")]
    pub penetration: f64,
    /// Greatest tension of the floor on a vertex, N.
    #[prost(double, tag = "3")]
    pub tension: f64,
    /// Greatest product of normal force and gap of a vertex, N m.
    #[prost(double, tag = "4")]
    pub signorini: f64,
    /// Greatest tangential load beyond the friction capacity, N.
    #[prost(double, tag = "5")]
    pub cone_excess: f64,
    /// Greatest shortfall of a sliding vertex from maximum dissipation, W.
    #[prost(double, tag = "6")]
    pub dissipation_gap: f64,
    /// Greatest tangential speed of a static vertex, m/s.
    #[prost(double, tag = "7")]
    pub creep_speed: f64,
    /// Greatest distance between a sole's vertex forces and its wrench, N.
    #[prost(double, tag = "8")]
    pub resultant_gap: f64,
    /// Kinetic and potential energy minus their value at the start, J.
    #[prost(double, tag = "9")]
    pub energy_change: f64,
    /// Work of the actuators since the start, J.
    #[prost(double, tag = "10")]
    pub actuator_work: f64,
    /// Work of external forces, J.
    #[prost(double, tag = "11")]
    pub external_work: f64,
    /// Energy dissipated by damping, friction and stops of the joints, J.
    #[prost(double, tag = "12")]
    pub joint_loss: f64,
    /// Energy dissipated by friction at the soles, J.
    #[prost(double, tag = "13")]
    pub friction_loss: f64,
    /// Energy dissipated by impacts and other velocity jumps, J.
    #[prost(double, tag = "14")]
    pub impact_loss: f64,
    /// Error of the energy balance, J.
    #[prost(double, tag = "15")]
    pub energy_error: f64,
}

/// Force and moment read at one sole.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct Wrench {
    /// Force, world axes, N.
    #[prost(message, optional, tag = "1")]
    pub force: Option<Vector3>,
    /// Moment about the mean of the sole's vertices, world axes, N m.
    #[prost(message, optional, tag = "2")]
    pub moment: Option<Vector3>,
}

/// Sensor readings and state estimate at the last control tick, topic `/estimate`; written if they
/// can differ from the true state. Joint arrays are in the order of the channel's metadata entry
/// `joints`, those of soles of its entry `soles`.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Estimate {
    /// Simulated time of the message, s.
    #[prost(double, tag = "1")]
    pub time: f64,
    /// Time of the tick, s.
    #[prost(double, tag = "2")]
    pub tick: f64,
    /// Estimated origin of the root link's URDF frame, m.
    #[prost(message, optional, tag = "3")]
    pub base_position: Option<Vector3>,
    /// Its estimated orientation.
    #[prost(message, optional, tag = "4")]
    pub base_orientation: Option<Quaternion>,
    /// Estimated velocity of that origin, m/s.
    #[prost(message, optional, tag = "5")]
    pub base_linear_velocity: Option<Vector3>,
    /// Estimated angular velocity, rad/s.
    #[prost(message, optional, tag = "6")]
    pub base_angular_velocity: Option<Vector3>,
    /// Joint positions read, rad or m.
    #[prost(double, repeated, tag = "7")]
    pub q: Vec<f64>,
    /// Joint velocities read.
    #[prost(double, repeated, tag = "8")]
    pub qd: Vec<f64>,
    /// Joint loads read, N m or N.
    #[prost(double, repeated, tag = "9")]
    pub load: Vec<f64>,
    /// Orientation of the IMU read.
    #[prost(message, optional, tag = "10")]
    pub orientation: Option<Quaternion>,
    /// Angular velocity of the IMU read, its axes, rad/s.
    #[prost(message, optional, tag = "11")]
    pub angular_velocity: Option<Vector3>,
    /// Specific force at the IMU read, its axes, m/s^2.
    #[prost(message, optional, tag = "12")]
    pub specific_force: Option<Vector3>,
    /// Forces and moments read, one per sole.
    #[prost(message, repeated, tag = "13")]
    pub soles: Vec<Wrench>,
    /// True where the estimator takes the sole as static; empty if it does not use contacts.
    #[prost(bool, repeated, tag = "14")]
    pub static_soles: Vec<bool>,
}

/// Distance between bodies of the robot and state of avoidance, topic `/self_collision`; written if
/// the scenario has `[self_collision]`. Joint arrays are in the order of the channel's metadata
/// entry `joints`, and empty without avoidance.
#[derive(Clone, PartialEq, prost::Message)]
pub struct SelfCollision {
    /// Simulated time, s.
    #[prost(double, tag = "1")]
    pub time: f64,
    /// Distance of the nearest pair of bodies, m; below 0 the depth of its overlap; infinite
    /// without pairs.
    #[prost(double, tag = "2")]
    pub distance: f64,
    /// Its first body.
    #[prost(string, tag = "3")]
    pub first: String,
    /// Its second body.
    #[prost(string, tag = "4")]
    pub second: String,
    /// The first body's nearest point, world, m.
    #[prost(message, optional, tag = "5")]
    pub on_first: Option<Vector3>,
    /// The second body's.
    #[prost(message, optional, tag = "6")]
    pub on_second: Option<Vector3>,
    /// Cycles of avoidance so far.
    #[prost(uint64, tag = "7")]
    pub cycles: u64,
    /// Postures tested in the last of them.
    #[prost(uint64, tag = "8")]
    pub tests: u64,
    /// For each joint: true if avoidance keeps it from its desired position.
    #[prost(bool, repeated, tag = "9")]
    pub frozen: Vec<bool>,
    /// Joint positions desired by the tasks, rad or m; the commanded ones are in `/state`.
    #[prost(double, repeated, tag = "10")]
    pub wanted: Vec<f64>,
}

/// An event, topic `/events`.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Event {
    /// Simulated time, s.
    #[prost(double, tag = "1")]
    pub time: f64,
    /// Short kind, such as `touchdown`.
    #[prost(string, tag = "2")]
    pub kind: String,
    /// Its subject, such as a sole; may be empty.
    #[prost(string, tag = "3")]
    pub subject: String,
    /// Its description as text.
    #[prost(string, tag = "4")]
    pub message: String,
}
