//! A small robot, an artificial motion and its log.

use nalgebra::{Isometry3, Matrix3, Point3, Translation3, UnitQuaternion, Vector3};
use std::path::Path;
use std::sync::LazyLock;
use stiction::contact::model::residual::Residual;
use stiction::log::{AttachedText, LogHeader, LogWriter, TopicGroups};
use stiction::robot::{Base, Drive, Geometry, Joint, JointKind, Link, LinkId, Merged, Model, Shape, Sole};
use stiction::sim::{EnergyBalance, Observer, SelfContactSnapshot, SimEvent, Snapshot, SoleSnapshot};
use stiction::task::PointOfInterest;

pub const URDF: &str = r#"<robot name="sample">
  <link name="trunk"><visual><geometry><box size="0.2 0.3 0.1"/></geometry></visual></link>
  <link name="plate"/><link name="tip"/><link name="shank"/><link name="ball"/>
  <joint name="weld" type="fixed"><parent link="trunk"/><child link="plate"/><origin xyz="0 0 0.05"/></joint>
  <joint name="bolt" type="fixed"><parent link="plate"/><child link="tip"/><origin xyz="0 0.1 0"/></joint>
  <joint name="hip" type="revolute"><parent link="trunk"/><child link="shank"/>
    <origin xyz="0 0 -0.1"/><axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="10" velocity="5"/></joint>
  <joint name="ankle" type="continuous"><parent link="shank"/><child link="ball"/>
    <origin xyz="0 0 -0.2"/><axis xyz="1 0 0"/></joint>
</robot>
"#;
pub const SCENARIO: &str = "schema = 1\nduration = 0.1 # größer\n";
pub const ROBOT: &str = "urdf = \"sample.urdf\"\n";

fn isometry(x: f64, y: f64, z: f64, axis_angle: [f64; 3]) -> Isometry3<f64> {
    Isometry3::new(Vector3::new(x, y, z), axis_angle.into())
}

fn link(name: &str, parent: Option<usize>, urdf_frame: Isometry3<f64>, visuals: Vec<Shape>) -> Link {
    Link {
        name: name.into(),
        parent: parent.map(LinkId),
        rotation: Matrix3::identity(),
        offset: Vector3::zeros(),
        mass: 1.5,
        com: Vector3::zeros(),
        inertia: Matrix3::identity() * 0.01,
        urdf_frame,
        merged: Vec::new(),
        visuals,
        collisions: Vec::new(),
    }
}

fn joint(name: &str, kind: JointKind) -> Joint {
    Joint {
        name: name.into(),
        kind,
        lower: -1.0,
        upper: 1.0,
        velocity_limit: f64::INFINITY,
        effort_limit: f64::INFINITY,
        damping: 0.0,
        friction: 0.0,
        armature: 0.0,
        lag: 0.0,
        static_friction: 0.0,
        stribeck_velocity: 0.2,
        slip_velocity: 0.05,
        stop: None,
        drive: Drive::default(),
        drive_configured: false,
    }
}

/// A tetrahedron.
pub fn mesh() -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
    let points = [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.25]];
    (points.map(Point3::from).to_vec(), vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
}

/// A box, a mesh with a rotated internal frame, and a sphere below it; two soles.
pub fn model() -> Model {
    let colour = [0.25, 0.5, 0.75, 1.0];
    let rotated = isometry(0.01, 0.02, 0.03, [std::f64::consts::FRAC_PI_2, 0.0, 0.0]);
    let (points, triangles) = mesh();
    let mut trunk = link(
        "trunk",
        None,
        Isometry3::identity(),
        vec![Shape {
            pose: isometry(0.0, 0.0, 0.4, [0.0, 0.0, 0.3]),
            geometry: Geometry::Box(Vector3::new(0.2, 0.3, 0.1)),
            rgba: colour,
        }],
    );
    trunk.merged.push(Merged { name: "plate".into(), pose: isometry(0.0, 0.0, 0.05, [0.0; 3]) });
    trunk.merged.push(Merged { name: "tip".into(), pose: isometry(0.0, 0.1, 0.05, [0.0; 3]) });
    let shank = link(
        "shank",
        Some(0),
        rotated,
        vec![Shape {
            // Equal to the URDF frame, so the mesh is at the origin of that frame.
            pose: rotated,
            geometry: Geometry::Mesh(points, triangles),
            rgba: colour,
        }],
    );
    let ball = link(
        "ball",
        Some(1),
        isometry(0.0, 0.0, 0.0, [0.0, -0.4, 0.0]),
        vec![
            Shape { pose: Isometry3::identity(), geometry: Geometry::Sphere(0.03), rgba: colour },
            Shape { pose: isometry(0.1, 0.0, 0.0, [0.0; 3]), geometry: Geometry::Capsule(0.02, 0.2), rgba: colour },
            Shape { pose: isometry(0.2, 0.0, 0.0, [0.0; 3]), geometry: Geometry::Cylinder(0.02, 0.2), rgba: colour },
        ],
    );
    let square = [[0.05, 0.03], [-0.05, 0.03], [-0.05, -0.03], [0.05, -0.03]];
    let links = vec![trunk, shank, ball];
    let joints = vec![joint("hip", JointKind::Revolute), joint("ankle", JointKind::Continuous)];
    let soles = vec![
        Sole { name: "left".into(), link: LinkId(1), vertices: square.map(|[x, y]| Vector3::new(x, y, -0.2)).to_vec() },
        Sole { name: "toe".into(), link: LinkId(2), vertices: vec![Vector3::new(0.0, 0.0, -0.03)] },
    ];
    Model { soles, ..Model::tree("sample".into(), Base::Floating, links, joints) }
}

/// Reproducible numbers without pattern.
fn wobble(tick: usize, i: usize) -> f64 {
    ((tick * 31 + i * 17) as f64 * 0.618_033_988_749_894_9).sin()
}

fn vector(tick: usize, i: usize) -> Vector3<f64> {
    Vector3::new(wobble(tick, i), wobble(tick, i + 1), wobble(tick, i + 2))
}

/// The vertices move with the link, so that readers can compare them with the sole's frame.
fn sole(tick: usize, state: &str, link: &Link, pose: &Isometry3<f64>, vertices: &[Vector3<f64>]) -> SoleSnapshot {
    let internal = pose * link.urdf_frame.inverse();
    let each = |shift: usize| (0..vertices.len()).map(|v| vector(tick, shift + 5 * v)).collect::<Vec<_>>();
    let touching = state != "free";
    SoleSnapshot {
        state: state.into(),
        clamped: (0..vertices.len()).map(|v| touching && v != 1).collect(),
        positions: vertices.iter().map(|v| (internal * Point3::from(*v)).coords).collect(),
        velocities: each(70),
        forces: each(90).into_iter().map(|f| if touching { f * 20.0 } else { Vector3::zeros() }).collect(),
    }
}

/// Poses of the links' URDF frames in a posture: joints turn about z of the internal frames.
pub fn link_poses(base: &Isometry3<f64>, q: &[f64]) -> Vec<Isometry3<f64>> {
    let model = model();
    let mut internal = vec![base * model.links[0].urdf_frame.inverse()];
    for (link, angle) in model.links[1..].iter().zip(q) {
        let turn = Isometry3::rotation(Vector3::new(0.0, 0.0, *angle));
        internal.push(internal[link.parent.unwrap().0] * Translation3::from(link.offset) * turn);
    }
    internal.iter().zip(&model.links).map(|(pose, link)| pose * link.urdf_frame).collect()
}

/// Poses of the links in a snapshot.
pub fn link_poses_of(s: &Snapshot) -> Vec<Isometry3<f64>> {
    link_poses(&s.base_pose, &s.q)
}

/// Tick `tick` of a motion logged at 200 Hz. The first sole is static, sliding and free in turn.
pub fn snapshot(tick: usize) -> Snapshot {
    let pose = |i: usize| {
        Isometry3::from_parts(
            Translation3::from(vector(tick, i)),
            UnitQuaternion::from_scaled_axis(vector(tick, i + 3) * 2.0),
        )
    };
    let q = vec![wobble(tick, 1), wobble(tick, 2)];
    let link_poses = link_poses(&pose(0), &q);
    let model = model();
    let state = ["face-static", "face-dynamic", "free"][tick % 3];
    Snapshot {
        time: tick as f64 * 0.005,
        base_pose: link_poses[0],
        base_linear_velocity: vector(tick, 100),
        base_angular_velocity: vector(tick, 103),
        q,
        qd: vec![wobble(tick, 3), wobble(tick, 4)],
        effort: vec![wobble(tick, 5), wobble(tick, 6)],
        effort_desired: vec![wobble(tick, 10), wobble(tick, 11)],
        q_desired: vec![wobble(tick, 7), wobble(tick, 8)],
        qd_desired: vec![wobble(tick, 9), 0.0],
        loops: Vec::new(),
        couplings: Vec::new(),
        object_poses: Vec::new(),
        com: vector(tick, 200),
        com_velocity: vector(tick, 203),
        centre_of_pressure: (state != "free").then(|| vector(tick, 206)),
        stable_point: (state != "free").then(|| vector(tick, 209)),
        support_polygon: if state == "free" { Vec::new() } else { (0..5).map(|i| vector(tick, 300 + i)).collect() },
        points: vec![
            PointOfInterest { name: "goal".into(), position: Some(vector(tick, 420)) },
            PointOfInterest { name: "now and then".into(), position: (tick % 4 == 1).then(|| vector(tick, 430)) },
        ],
        // A link touches at every third tick, with changing vertices.
        links: if tick % 3 == 1 {
            let all = |n: usize| (0..=tick % 2).map(|i| vector(tick, n + 3 * i)).collect();
            let (positions, velocities, forces) = (all(600), all(610), all(620));
            let clamped = vec![true; tick % 2 + 1];
            let state = "vertex-0-static".into();
            vec![("shank".into(), SoleSnapshot { state, clamped, positions, velocities, forces })]
        } else {
            Vec::new()
        },
        soles: model
            .soles
            .iter()
            .zip([state, "free"])
            .map(|(s, state)| sole(tick, state, &model.links[s.link.0], &link_poses[s.link.0], &s.vertices))
            .collect(),
        residual: Residual {
            penetration: wobble(tick, 500),
            tension: wobble(tick, 501),
            signorini: wobble(tick, 502),
            cone_excess: wobble(tick, 503),
            dissipation_gap: wobble(tick, 504),
            creep_speed: wobble(tick, 505),
            resultant_gap: wobble(tick, 506),
        },
        energy: EnergyBalance {
            change: wobble(tick, 510),
            actuators: wobble(tick, 511),
            external: wobble(tick, 512),
            joint_loss: wobble(tick, 513),
            friction_loss: wobble(tick, 514),
            impact_loss: wobble(tick, 515),
        },
        external: if tick.is_multiple_of(2) { vec![(vector(tick, 400), vector(tick, 403) * 30.0)] } else { Vec::new() },
        estimate: None,
        self_contact: Some(SelfContactSnapshot {
            pairs: vec![["trunk".into(), "ball".into()], ["trunk".into(), "shank".into()]],
            nearest: Some((wobble(tick, 520), tick % 2, vector(tick, 521), vector(tick, 524))),
            cycles: tick as u64,
            tests: 3 * tick as u64,
            frozen: vec![tick.is_multiple_of(3), true],
            desired: vec![wobble(tick, 530), wobble(tick, 531)],
        }),
    }
}

pub fn event(tick: usize) -> SimEvent {
    let kinds = ["touchdown", "slip", "jam", "inconsistent"];
    SimEvent {
        time: tick as f64 * 0.005 + 0.001_234_567_8,
        kind: stiction::sim::EventKind::Force(kinds[tick % kinds.len()]),
        subject: "left".into(),
        message: if tick == 2 { String::new() } else { format!("left sole at tick {tick}") },
    }
}

/// No terrain.
static TERRAIN: LazyLock<stiction::terrain::Terrain> = LazyLock::new(Default::default);

/// A patch on the tilted floor.
pub static PATCHES: LazyLock<Vec<Vec<Vector3<f64>>>> =
    LazyLock::new(|| vec![vec![vector(0, 500), vector(0, 510), vector(0, 520)]]);

pub fn header(topics: TopicGroups) -> LogHeader<'static> {
    LogHeader {
        scenario_name: "sample",
        key: "0123abcd",
        method: "exact",
        scenario: AttachedText { name: "sample.toml", text: SCENARIO },
        robot: Some(AttachedText { name: "robot.toml", text: ROBOT }),
        urdf: AttachedText { name: "sample.urdf", text: URDF },
        floor: Some(isometry(0.0, 0.0, -0.1, [0.2, 0.0, 0.0])),
        patches: &PATCHES,
        objects: &[],
        terrain: &TERRAIN,
        inputs: &[],
        topics,
        viewer_rate: f64::INFINITY,
    }
}

/// A writer after `ticks` snapshots and their events.
pub fn open_log(path: &Path, ticks: usize, topics: TopicGroups) -> LogWriter {
    open_log_with(path, ticks, &header(topics))
}

/// The same with a header.
pub fn open_log_with(path: &Path, ticks: usize, header: &LogHeader) -> LogWriter {
    let mut log = LogWriter::create(path, &model(), header).unwrap();
    for tick in 0..ticks {
        log.snapshot(&snapshot(tick)).unwrap();
        if tick < 4 {
            log.event(&event(tick)).unwrap();
        }
    }
    log
}

/// The bytes of a finished log.
pub fn log(ticks: usize, topics: TopicGroups) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.mcap");
    open_log(&path, ticks, topics).finish().unwrap();
    std::fs::read(&path).unwrap()
}
