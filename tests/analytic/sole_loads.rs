//! What sensors, tasks and logs know of soles on terrain and objects: their loads and contact points are
//! those that statics gives, and those on a plane.

use super::body::G;
use crate::support::runs::{finish, root};
use nalgebra::Vector3;
use std::sync::{Arc, Mutex};
use stiction::sim::{Metrics, NullObserver, Simulation};
use stiction::task::{Command, Context, Needs, Status, Task, TaskResult};
use stiction::{assemble, robot, scenario};

/// Values at the last tick.
#[derive(Clone, Default, Debug)]
struct Seen {
    forces: Vec<Vector3<f64>>,
    mean_forces: Vec<Vector3<f64>>,
    moments: Vec<Vector3<f64>>,
    vertex_forces: Vec<Vector3<f64>>,
    contacts: Vec<Vector3<f64>>,
    contact_forces: Vector3<f64>,
    support: Vec<Vector3<f64>>,
    zmp: Option<Vector3<f64>>,
}

struct Probe(Arc<Mutex<Seen>>);

impl Task for Probe {
    fn init(&mut self, _: &Context, _: &Command) -> TaskResult {
        Ok(Status::Running)
    }

    fn run(&mut self, context: &Context, _: &mut Command) -> TaskResult {
        let (soles, data) = (&context.sensed.soles, context.data);
        *self.0.lock().unwrap() = Seen {
            forces: soles.iter().map(|s| s.force).collect(),
            mean_forces: soles.iter().map(|s| s.mean_force).collect(),
            moments: soles.iter().map(|s| s.moment).collect(),
            vertex_forces: data.soles.iter().flat_map(|s| s.vertex_forces.clone()).collect(),
            contacts: data.contacts.iter().map(|c| c.position).collect(),
            contact_forces: data.contacts.iter().map(|c| c.force).sum(),
            support: data.support_polygon.clone(),
            zmp: data.zmp,
        };
        Ok(Status::Running)
    }

    fn needs(&self) -> Needs {
        Needs::ALL
    }

    fn name(&self) -> &str {
        "probe"
    }
}

fn probe(text: &str) -> (Seen, Metrics) {
    let file = scenario::parse(&root().join("test.toml"), text).unwrap();
    let run = file.expand(&[]).unwrap().remove(0);
    let robot = robot::load(&run.resolve(&run.scenario.robot.model)).unwrap();
    let mut setup = assemble::setup(&run, &robot).unwrap();
    let seen = Arc::new(Mutex::new(Seen::default()));
    setup.tasks.add(0.0, Box::new(Probe(seen.clone())));
    let mut sim = Simulation::new(setup).unwrap();
    let metrics = finish(&mut sim, &mut NullObserver);
    let seen = seen.lock().unwrap().clone();
    (seen, metrics)
}

/// Largest distance of the points of one list from those of another.
fn apart(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    let to = |p: &Vector3<f64>| b.iter().map(|q| (p - q).norm()).fold(f64::INFINITY, f64::min);
    a.iter().map(to).fold(0.0, f64::max)
}

/// The edge of a table is under a block of 1 kg, 0.03 m ahead of its centre: it touches at two vertices and
/// where the edge crosses its sides.
#[test]
fn a_block_over_an_edge_rests_on_its_rear_vertices_and_the_edge() {
    let (seen, m) = probe(
        "duration = 0.2
        terrain = [{ type = \"box\", size = [1, 1, 0.25], position = [-0.47, 0, 0.125] }]
        robot = { model = \"robots/block/block.toml\", base = { position = [0, 0, 0.3] } }
        log = { rate = 10 }",
    );
    let weight = Vector3::new(0.0, 0.0, G);
    // Rounding of forces of some 10 N.
    assert!((seen.forces[0] - weight).norm() < 1e-12, "{seen:?}");
    assert!(seen.moments[0].norm() < 1e-12 && (seen.contact_forces - weight).norm() < 1e-12, "{seen:?}");
    let corners = [[-0.1, -0.1], [0.03, -0.1], [0.03, 0.1], [-0.1, 0.1]].map(|[x, y]| Vector3::new(x, y, 0.25));
    assert!(seen.contacts.len() == 4 && apart(&corners, &seen.contacts) < 1e-12, "{seen:?}");
    // The support polygon and the zero-moment point are on the floor plane.
    let below = corners.map(|c| Vector3::new(c.x, c.y, 0.0));
    assert!(seen.support.len() == 4 && apart(&below, &seen.support) < 1e-12, "{seen:?}");
    assert!(seen.zmp.unwrap().norm() < 1e-12, "{seen:?}");
    // Vertices that do not touch carry nothing.
    assert!(seen.vertex_forces[1].norm() + seen.vertex_forces[2].norm() == 0.0, "{seen:?}");
    assert!((m.final_normal_force_n.unwrap() - G).abs() < 1e-12, "{:?}", m.final_normal_force_n);
    assert!(m.final_cop_offset_m.unwrap() < 1e-12, "{:?}", m.final_cop_offset_m);
}

/// A block of 1 kg on a box of 3 kg: the sole carries the block, the floor both.
#[test]
fn a_block_on_a_box_feels_its_own_weight() {
    for contact in ["soles", "bodies"] {
        let (seen, m) = probe(&format!(
            "duration = 0.2
            object = [{{ type = \"box\", size = [0.4, 0.4, 0.25], mass = 3.0, position = [0, 0, 0.125] }}]
            robot = {{ model = \"robots/block/block.toml\", contact = \"{contact}\", base = {{ position = [0.01, 0.02, 0.3] }} }}
            log = {{ rate = 10 }}"
        ));
        assert!((seen.forces[0] - Vector3::new(0.0, 0.0, G)).norm() < 1e-12, "{seen:?}");
        // Two vertices on a diagonal through the centre may carry it alone.
        assert!(seen.moments[0].norm() < 1e-12 && seen.contacts.len() >= 2, "{seen:?}");
        assert!((seen.zmp.unwrap() - Vector3::new(0.01, 0.02, 0.0)).norm() < 1e-12, "{seen:?}");
        // 4 kg times 9.81 m/s^2, with its rounding.
        assert!((m.final_normal_force_n.unwrap() - 4.0 * G).abs() < 1e-12, "{:?}", m.final_normal_force_n);
    }
}

/// A humanoid that balances by forces at the contacts it senses, pushed: on a plane, on a box, and across
/// the seam of two boxes below its left foot, in the same way.
#[test]
fn a_humanoid_balances_alike_on_a_plane_and_on_boxes() {
    let surfaces = [
        "floor.height = 0.25\n",
        "floor = { plane = false, height = 0.25 }
        terrain = [{ type = \"box\", size = [1, 1, 0.25], position = [0, 0, 0.125] }]\n",
        "floor = { plane = false, height = 0.25 }
        terrain = [
            { type = \"box\", size = [1, 1, 0.25], position = [0, -0.462, 0.125] },
            { type = \"box\", size = [1, 1, 0.25], position = [0, 0.538, 0.125] },
        ]\n",
    ];
    let mut first: Option<(Seen, Metrics)> = None;
    for surface in surfaces {
        let (seen, m) = probe(&format!(
            "{surface}duration = 0.5
            integrator = {{ relative_tolerance = 1e-9, absolute_tolerance = 1e-11 }}
            control = {{ estimator = \"inertial\", inertial = {{ acceleration = \"soles\" }} }}
            robot = {{ model = \"robots/hoap2/hoap2.toml\", base = {{ position = [0, 0, 0.5334389] }} }}
            task = [{{ type = \"balance\", control = \"force\", force = {{ contacts = \"sensed\" }} }}]
            force = [{{ type = \"push\", link = \"torso\", force = [2, 1, 0], start = 0.1, duration = 0.1 }}]
            log = {{ rate = 10 }}"
        ));
        assert!(m.inconsistent == 0 && m.max_penetration_m < 1e-9, "{surface} {m:?}");
        assert!(seen.contacts.len() >= 8 && seen.forces.iter().all(|f| f.z > 10.0), "{surface} {seen:?}");
        let (plane, of_plane) = first.get_or_insert((seen.clone(), m.clone()));
        // Integration errors of different steps, times the weight of 70 N, by 1 / m of the servos.
        assert!(apart(&plane.forces, &seen.forces) < 1e-5, "{surface} {seen:?} {plane:?}");
        assert!(apart(&plane.mean_forces, &seen.mean_forces) < 1e-5, "{surface} {seen:?} {plane:?}");
        assert!(apart(&plane.moments, &seen.moments) < 1e-6, "{surface} {seen:?} {plane:?}");
        assert!(apart(&plane.support, &seen.support) < 1e-8, "{surface} {seen:?} {plane:?}");
        assert!((plane.zmp.unwrap() - seen.zmp.unwrap()).norm() < 1e-7, "{surface} {seen:?} {plane:?}");
        let base = |m: &Metrics| Vector3::from(m.final_base_position);
        assert!((base(of_plane) - base(&m)).norm() < 1e-8, "{surface} {:?} {:?}", base(of_plane), base(&m));
        let normal = |m: &Metrics| m.final_normal_force_n.unwrap();
        assert!((normal(of_plane) - normal(&m)).abs() < 1e-5, "{surface} {} {}", normal(of_plane), normal(&m));
    }
}
