//! The context of a task while HOAP-2 stands: forces balance the weight, and points are inside the
//! support polygon.

use crate::support::runs::{finish, root};
use nalgebra::Vector3;
use std::sync::{Arc, Mutex};
use stiction::assemble;
use stiction::sim::{NullObserver, Simulation};
use stiction::task::{Command, Context, Needs, Status, Task, TaskResult};
use stiction::{robot, scenario};

/// Values recorded at a tick.
#[derive(Clone, Default, Debug)]
struct Seen {
    time: f64,
    /// Greatest imbalance of `g(q) - sum J^T f - (0, load)`, N or N m.
    imbalance: f64,
    /// Distance of the zero-moment point and the point of optimal stability outside the support
    /// polygon, m.
    outside: [f64; 2],
    contacts: usize,
    corners: usize,
    /// Radius of the disc about the point of optimal stability.
    radius: f64,
    com_rate: f64,
}

struct Probe(Arc<Mutex<Vec<Seen>>>, Needs);

/// Distance beyond the sides of a counter-clockwise polygon in the floor's plane; negative inside.
fn outside(point: &Vector3<f64>, context: &Context) -> f64 {
    let corners = &context.data.support_polygon;
    let at = |p: &Vector3<f64>| context.floor.flat(p);
    let side = |i: usize| {
        let (a, b) = (at(&corners[i]), at(&corners[(i + 1) % corners.len()]));
        (at(point) - a).perp(&(b - a).normalize())
    };
    (0..corners.len()).map(side).fold(f64::NEG_INFINITY, f64::max)
}

impl Task for Probe {
    fn init(&mut self, _: &Context, _: &Command) -> TaskResult {
        Ok(Status::Running)
    }

    fn run(&mut self, context: &Context, _: &mut Command) -> TaskResult {
        let (data, nb) = (context.data, context.model.nb());
        let mut balance = data.gravity_effort.clone();
        context.sensed.load.iter().zip(&mut balance[nb..]).for_each(|(load, b)| *b -= load);
        for sole in &data.soles {
            for (jacobian, force) in sole.vertex_jacobians.iter().zip(&sole.vertex_forces) {
                for (b, column) in balance.iter_mut().zip(jacobian.chunks_exact(3)) {
                    *b -= Vector3::from_column_slice(column).dot(force);
                }
            }
        }
        let v = &context.state.v;
        let rate: Vector3<f64> =
            data.com_jacobian.chunks_exact(3).zip(v).map(|(c, v)| Vector3::from_column_slice(c) * *v).sum();
        let points = [data.zmp, data.stable_point];
        self.0.lock().unwrap().push(Seen {
            time: context.time,
            imbalance: balance.iter().fold(0.0, |a: f64, b| a.max(b.abs())),
            outside: points.map(|p| p.map_or(f64::NAN, |p| outside(&p, context))),
            contacts: data.contacts.len(),
            corners: data.support_polygon.len(),
            radius: data.stable_radius,
            com_rate: (rate - data.com_velocity).norm(),
        });
        Ok(Status::Running)
    }

    fn needs(&self) -> Needs {
        self.1
    }

    fn name(&self) -> &str {
        "probe"
    }
}

fn probe(text: &str, needs: Needs) -> Vec<Seen> {
    let file = scenario::parse(&root().join("test.toml"), text).unwrap();
    let runs = file.expand(&[]).unwrap();
    let robot = robot::load(&runs[0].resolve(&runs[0].scenario.robot.model)).unwrap();
    let mut setup = assemble::setup(&runs[0], &robot).unwrap();
    let seen = Arc::new(Mutex::new(Vec::new()));
    setup.tasks.add(0.0, Box::new(Probe(seen.clone(), needs)));
    let mut sim = Simulation::new(setup).unwrap();
    finish(&mut sim, &mut NullObserver);
    let seen = seen.lock().unwrap();
    seen.clone()
}

const STANDS: &str = "duration = 6
    control = { rate = 50 }
    integrator = { relative_tolerance = 1e-9, absolute_tolerance = 1e-11 }
    [robot]
    model = \"robots/hoap2/hoap2.toml\"
    [[force]]
    type = \"push\"
    link = \"torso\"
    force = [4, 2, 0]
    start = 0.5
    duration = 0.2
    profile = \"half-sine\"";

#[test]
fn at_rest_contact_forces_and_servo_efforts_balance_the_weight() {
    let seen = probe(STANDS, Needs::ALL);
    assert_eq!(seen[0].contacts, 0, "no forces are known at the first tick");
    let last = seen.last().unwrap();
    assert!(last.time > 5.9);
    // The swing has decayed to 1e-12 rad, times gains of 150 N m/rad.
    assert!(last.imbalance < 1e-9, "{last:?}");
    // During the push it is not in equilibrium.
    assert!(seen.iter().any(|s| s.imbalance > 1.0));
    assert_eq!((last.contacts, last.corners), (8, 4), "{last:?}");
    // Two soles side by side: the disc between heel and toe lines, 94 mm apart.
    assert!((last.radius - 0.047).abs() < 1e-9, "{last:?}");
    for s in seen.iter().filter(|s| s.corners > 2) {
        // The floor only presses, so the zero-moment point stays inside up to rounding; the other
        // point is far inside.
        assert!(s.outside[0] < 1e-9 && s.outside[1] < -0.02, "{s:?}");
        assert!(s.com_rate < 1e-12, "{s:?}");
    }
}

#[test]
fn data_not_requested_are_not_computed() {
    let seen = probe(STANDS, Needs::COM | Needs::COM_JACOBIAN);
    assert!(seen.iter().all(|s| s.contacts == 0 && s.corners == 0 && s.com_rate < 1e-12));
    assert!(seen.iter().all(|s| s.outside[0].is_nan() && s.radius == 0.0));
}
