//! The robot's model: an immutable tree of rigid links.
//!
//! Conventions of all modules of the simulation:
//! - **Link frame**: each moving link carries an internal frame whose origin is on its joint and
//!   whose **z axis is the joint axis**, so a revolute joint transform is a plane rotation.
//!   `Link::urdf_frame` leads back to the frame of the URDF file; all user input and output is in
//!   that frame.
//! - **Topological order**: a link's parent has a smaller index. `joints[i]` moves `links[i + 1]`;
//!   `links[0]` is the root.
//! - **Velocities** `v`: floating base first, `(p', omega)` = velocity of the root link's URDF
//!   frame origin and angular velocity, both in world axes; then one number per joint. A fixed base
//!   has joints only.
//! - The root's internal frame is its URDF frame.

use super::closure::{Coupling, LoopClosure};
use super::friction::JointFrictionLaw;
use super::rigid_inertia::RigidInertia;
use super::transmission::Transmission;
use nalgebra::{Isometry3, Matrix3, Point3, Vector3};
use std::ops::Range;

macro_rules! index {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
        pub struct $name(pub usize);
    };
}

index!(
    /// Index into [`Model::links`].
    LinkId
);
index!(
    /// Index into [`Model::joints`].
    JointId
);
index!(
    /// Index into [`Model::soles`].
    SoleId
);

/// How the root link is held.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Base {
    /// Free in space: six velocities.
    Floating,
    /// Fixed to the world (a URDF whose root link is called `world`, or `base = "fixed"` in the
    /// robot file).
    Fixed,
}

/// Motion of a joint; the axis is z of the child's internal frame.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum JointKind {
    /// Rotation within limits.
    Revolute,
    /// Rotation without limits.
    Continuous,
    /// Translation.
    Prismatic,
}

/// How a joint is driven.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum DriveMode {
    /// `tau = kp (q_des - q) + kd (qd_des - qd) + feed-forward`, clipped to the effort limit.
    Position,
    /// `tau` = feed-forward only, clipped.
    Force,
    /// `tau = kd (qd_des - qd) + feed-forward`, clipped.
    Velocity,
    /// Follows its command exactly, without dynamics. Limits, stops and gains have no effect.
    Kinematic,
    /// No actuator torque.
    #[default]
    Passive,
}

/// The drive of one joint. Units: N m/rad and N m s/rad, for prismatic joints N/m and N s/m.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Drive {
    /// Drive mode.
    pub mode: DriveMode,
    /// Position gain.
    pub kp: f64,
    /// Velocity gain.
    pub kd: f64,
}

/// One joint of the tree.
#[derive(Clone, PartialEq, Debug)]
pub struct Joint {
    /// Name in the URDF.
    pub name: String,
    /// Its motion.
    pub kind: JointKind,
    /// Lower limit, rad or m; minus infinity when there is none.
    pub lower: f64,
    /// Upper limit, rad or m; infinity when there is none.
    pub upper: f64,
    /// Greatest speed, rad/s or m/s; infinity when not given.
    pub velocity_limit: f64,
    /// Greatest actuator effort, N m or N; infinity when not given.
    pub effort_limit: f64,
    /// Viscous friction, N m s/rad or N s/m.
    pub damping: f64,
    /// Coulomb friction, N m or N.
    pub friction: f64,
    /// Static friction, N m or N; without effect unless greater than Coulomb friction.
    pub static_friction: f64,
    /// Speed over which friction falls from static to Coulomb's, rad/s or m/s, above 0.
    pub stribeck_velocity: f64,
    /// Speed below which friction is below its full size, rad/s or m/s, above 0.
    pub slip_velocity: f64,
    /// Stiffness (N m/rad or N/m) and damping (N m s/rad or N s/m) of the end stops; `None` when
    /// they follow from the inertia.
    pub stop: Option<(f64, f64)>,
    /// Reflected rotor inertia, kg m^2 or kg.
    pub armature: f64,
    /// Time constant with which the actuator's effort follows the command, s; 0 when it follows at
    /// once.
    pub lag: f64,
    /// The actuator.
    pub drive: Drive,
    /// True when the URDF or robot file configured the drive; `joint_default` of a scenario fills
    /// the others.
    pub drive_configured: bool,
}

impl Joint {
    /// The law of the joint's friction.
    pub fn friction_law(&self) -> JointFrictionLaw {
        JointFrictionLaw {
            coulomb: self.friction,
            viscous: self.damping,
            static_: self.static_friction,
            stribeck_velocity: self.stribeck_velocity,
            slip_velocity: self.slip_velocity,
        }
    }
}

/// A shape fixed to a link, for drawing, collision bodies and sole detection.
#[derive(Clone, PartialEq, Debug)]
pub struct Shape {
    /// Pose in the link's internal frame.
    pub pose: Isometry3<f64>,
    /// Its geometry.
    pub geometry: Geometry,
    /// Red, green, blue, opacity, each 0 to 1.
    pub rgba: [f32; 4],
}

/// Geometry of a [`Shape`], metres, as URDF defines it.
#[derive(Clone, PartialEq, Debug)]
pub enum Geometry {
    /// Full edge lengths along x, y, z.
    Box(Vector3<f64>),
    /// Radius, length along z.
    Cylinder(f64, f64),
    /// Radius, length of the cylindrical part along z.
    Capsule(f64, f64),
    /// Radius.
    Sphere(f64),
    /// Vertices and triangles, already scaled.
    Mesh(Vec<Point3<f64>>, Vec<[u32; 3]>),
}

/// A URDF link that a fixed joint welded to this one.
#[derive(Clone, PartialEq, Debug)]
pub struct Merged {
    /// Its name.
    pub name: String,
    /// Pose of its URDF frame in the carrying link's internal frame.
    pub pose: Isometry3<f64>,
}

/// One rigid link.
#[derive(Clone, PartialEq, Debug)]
pub struct Link {
    /// Name in the URDF.
    pub name: String,
    /// The parent link; `None` for the root.
    pub parent: Option<LinkId>,
    /// Orientation of the internal frame in the parent's internal frame at joint position 0.
    pub rotation: Matrix3<f64>,
    /// Origin of the internal frame in the parent's internal frame at joint position 0, m.
    pub offset: Vector3<f64>,
    /// Mass, kg.
    pub mass: f64,
    /// Centre of mass in the internal frame, m.
    pub com: Vector3<f64>,
    /// Inertia tensor about the centre of mass in the internal frame's axes, kg m^2.
    pub inertia: Matrix3<f64>,
    /// Pose of the URDF link frame in the internal frame.
    pub urdf_frame: Isometry3<f64>,
    /// Links welded to this one.
    pub merged: Vec<Merged>,
    /// Visual shapes.
    pub visuals: Vec<Shape>,
    /// Collision shapes.
    pub collisions: Vec<Shape>,
}

impl Link {
    /// Mass, centre of mass and inertia, in the internal frame.
    pub fn body(&self) -> RigidInertia {
        RigidInertia { mass: self.mass, com: self.com, tensor: self.inertia }
    }

    /// Replaces mass, centre of mass and inertia.
    pub fn set_body(&mut self, body: &RigidInertia) {
        (self.mass, self.com, self.inertia) = (body.mass, body.com, body.tensor);
    }
}

/// A convex planar polygon of vertices that may touch the floor, fixed to one link.
#[derive(Clone, PartialEq, Debug)]
pub struct Sole {
    /// Name, unique in the robot.
    pub name: String,
    /// Carrying link.
    pub link: LinkId,
    /// Vertices in the carrying link's **internal** frame, m, in order around the polygon
    /// (counter-clockwise seen from above when the sole faces down). One vertex is a point foot,
    /// two a line foot.
    pub vertices: Vec<Vector3<f64>>,
}

impl Sole {
    /// Mean of the vertices, m.
    pub fn centroid(&self) -> Vector3<f64> {
        self.vertices.iter().sum::<Vector3<f64>>() / self.vertices.len().max(1) as f64
    }

    /// Greatest distance of a vertex from the centroid, m; 1 for a point foot.
    pub fn radius(&self) -> f64 {
        let centroid = self.centroid();
        let radius = self.vertices.iter().map(|v| (v - centroid).norm()).fold(0.0, f64::max);
        if radius > 0.0 { radius } else { 1.0 }
    }
}

/// A frame of interest fixed to a link.
#[derive(Clone, PartialEq, Debug)]
pub struct EndEffector {
    /// Name, unique among the robot's end effectors.
    pub name: String,
    /// Carrying link.
    pub link: LinkId,
    /// Pose in the carrying link's **internal** frame.
    pub pose: Isometry3<f64>,
}

/// A frame on a link.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Mount {
    /// Carrying link.
    pub link: LinkId,
    /// Pose in the carrying link's **internal** frame.
    pub pose: Isometry3<f64>,
}

/// A sensor with a frame of its own.
#[derive(Clone, PartialEq, Debug)]
pub struct SensorFrame {
    /// Name, unique among the robot's sensors of its kind.
    pub name: String,
    /// Its frame.
    pub mount: Mount,
}

/// Frames of the robot's sensors, in file order.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct SensorFrames {
    /// Inertial measurement units.
    pub imu: Vec<SensorFrame>,
    /// Force-torque sensors.
    pub force: Vec<SensorFrame>,
}

/// A robot: immutable after loading and shared by all threads.
#[derive(Clone, PartialEq, Debug)]
pub struct Model {
    /// Name in the URDF.
    pub name: String,
    /// How the root is held.
    pub base: Base,
    /// Links in topological order.
    pub links: Vec<Link>,
    /// `joints[i]` moves `links[i + 1]`.
    pub joints: Vec<Joint>,
    /// Soles, in file order.
    pub soles: Vec<Sole>,
    /// End effectors, in file order.
    pub end_effectors: Vec<EndEffector>,
    /// Sensors that have a frame of their own.
    pub sensors: SensorFrames,
    /// Home posture, one number per joint.
    pub home: Vec<f64>,
    /// Postures with names, in file order: the keys of an MJCF file.
    pub keyframes: Vec<Keyframe>,
    /// Joints that follow others, each after those it follows.
    pub couplings: Vec<Coupling>,
    /// Closed loops, in file order.
    pub loops: Vec<LoopClosure>,
    /// Transmissions, in file order.
    pub transmissions: Vec<Transmission>,
}

/// A posture with a name.
#[derive(Clone, Debug, PartialEq)]
pub struct Keyframe {
    /// Name, unique in its model.
    pub name: String,
    /// Positions, one number per joint, rad or m.
    pub joints: Vec<f64>,
}

impl Model {
    /// A tree with its home at 0, and nothing besides links and joints.
    pub fn tree(name: String, base: Base, links: Vec<Link>, joints: Vec<Joint>) -> Self {
        Model {
            name,
            base,
            home: vec![0.0; joints.len()],
            links,
            joints,
            soles: Vec::new(),
            end_effectors: Vec::new(),
            sensors: SensorFrames::default(),
            keyframes: Vec::new(),
            couplings: Vec::new(),
            loops: Vec::new(),
            transmissions: Vec::new(),
        }
    }

    /// Velocities of the base: 6 or 0.
    pub fn nb(&self) -> usize {
        match self.base {
            Base::Floating => 6,
            Base::Fixed => 0,
        }
    }

    /// Number of joints.
    pub fn nj(&self) -> usize {
        self.joints.len()
    }

    /// Number of velocities, `nb + nj`.
    pub fn nv(&self) -> usize {
        self.nb() + self.nj()
    }

    /// Total mass, kg, without the fixed root of a fixed-base model.
    pub fn mass(&self) -> f64 {
        let first = usize::from(self.base == Base::Fixed);
        self.links[first..].iter().map(|l| l.mass).sum()
    }

    /// Joints whose actuators lag, in ascending order.
    pub fn lagging(&self) -> impl Iterator<Item = JointId> {
        self.joints.iter().enumerate().filter(|(_, j)| j.lag > 0.0).map(|(i, _)| JointId(i))
    }

    /// Transmissions that couple several joints.
    #[inline]
    pub fn coupled_transmissions(&self) -> impl Iterator<Item = &Transmission> {
        self.transmissions.iter().filter(|transmission| transmission.is_coupled())
    }

    /// The transmission that couples a joint with others.
    pub fn coupled_transmission_of(&self, joint: JointId) -> Option<&Transmission> {
        self.coupled_transmissions().find(|transmission| transmission.joints.contains(&joint))
    }

    /// Whether a pattern of joint names means a joint that it matches: it leaves out those that follow others, a
    /// name does not.
    pub fn is_meant(&self, pattern: &str, joint: JointId) -> bool {
        self.joints[joint.0].name == pattern || self.coupling_of(joint).is_none()
    }

    /// The loops with their conditions, which come after those of the couplings.
    pub fn loop_conditions(&self) -> impl Iterator<Item = (&LoopClosure, Range<usize>)> {
        let mut next = self.couplings.len();
        self.loops.iter().map(move |closure| {
            let first = next;
            next += closure.kind.number();
            (closure, first..next)
        })
    }

    /// The coupling that a joint follows.
    pub fn coupling_of(&self, joint: JointId) -> Option<&Coupling> {
        self.couplings.iter().find(|coupling| coupling.joint == joint)
    }

    /// Sets the positions of following joints to those that their leaders give them.
    pub fn set_followers(&self, positions: &mut [f64]) {
        for coupling in &self.couplings {
            positions[coupling.joint.0] = coupling.evaluate(positions[coupling.leader.0]).0;
        }
    }

    /// Moves efforts of following joints to their leaders, which have to exert them: by the slopes of the
    /// couplings at these positions.
    pub fn move_efforts_to_leaders(&self, positions: &[f64], efforts: &mut [f64]) {
        // Each coupling comes after those of the joints that it follows.
        for coupling in self.couplings.iter().rev() {
            let slope = coupling.evaluate(positions[coupling.leader.0]).1;
            let effort = std::mem::take(&mut efforts[coupling.joint.0]);
            efforts[coupling.leader.0] += slope * effort;
        }
    }

    /// The joint of that name.
    pub fn joint(&self, name: &str) -> Option<JointId> {
        self.joints.iter().position(|j| j.name == name).map(JointId)
    }

    /// Index of the end effector of that name.
    pub fn end_effector(&self, name: &str) -> Option<usize> {
        self.end_effectors.iter().position(|e| e.name == name)
    }

    /// The link of that name, welded ones included, with the pose of its URDF frame in the carrying
    /// link's internal frame.
    pub fn link(&self, name: &str) -> Option<(LinkId, Isometry3<f64>)> {
        self.links.iter().enumerate().find_map(|(i, l)| {
            if l.name == name {
                return Some((LinkId(i), l.urdf_frame));
            }
            l.merged.iter().find(|m| m.name == name).map(|m| (LinkId(i), m.pose))
        })
    }
}
