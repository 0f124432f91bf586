//! Painleve's rod: a slender rod (2 l = 1 m, 1 kg) slides on its lower end, its centre behind the
//! tip.
//!
//! With theta its angle to the floor, v > 0 the speed of the tip away from below the centre and w =
//! theta', friction pushes the tip towards the centre. `N`, with `I = m l^2 / 3` about the centre
//! and the centre at height l sin theta:
//!
//! ```text
//! m (l cos w' - l sin w^2) = N - m g        I w' = -l cos N + l sin mu N
//! N = m (g - l w^2 sin) / (1 + 3 cos^2 - 3 mu sin cos)
//! ```
//!
//! No finite force exists if mu exceeds `mu_c = (1 + 3 cos^2) / (3 sin cos)`, least 4/3 at tan
//! theta = 2. Beyond, with w^2 small, the tip jams (its slip ends in no time). Angular momentum
//! about it is conserved, `(4/3) m l^2 w+ = (4/3) m l^2 w + m l v sin`, so `w+ = w + 3 v sin / (4
//! l)`, and the energy lost is `m v^2 (1 + 3 cos^2) / 8`.

use super::body::{Body, G};
use crate::support::runs::{Recording, TIGHT, finish, rk4, simulation};
use nalgebra::Vector3;
use stiction::contact::model::state::SoleState;
use stiction::sim::{NullObserver, Simulation};

const L: f64 = 0.5;
const MASS: f64 = 1.0;
const HEADINGS: [f64; 5] = [0.0, 0.7, 1.9, 3.3, 5.4];

/// Initial state of the rod.
#[derive(Clone, Copy, Debug)]
struct Start {
    theta: f64,
    heading: f64,
    /// Speed of the tip away from the point below the centre.
    v: f64,
    w: f64,
    mu: f64,
}

fn critical(theta: f64) -> f64 {
    let (s, c) = theta.sin_cos();
    (1.0 + 3.0 * c * c) / (3.0 * s * c)
}

impl Start {
    /// Unit vector from the tip to below the centre, and the axis of w.
    fn axes(&self) -> (Vector3<f64>, Vector3<f64>) {
        let (s, c) = self.heading.sin_cos();
        (Vector3::new(c, s, 0.0), Vector3::new(s, -c, 0.0))
    }

    fn simulation(&self, duration: f64) -> Simulation {
        self.simulation_aside(duration, 0.0)
    }

    /// The same with the tip's velocity rotated by `aside` about the vertical.
    fn simulation_aside(&self, duration: f64, aside: f64) -> Simulation {
        let (forward, axis) = self.axes();
        let (s, c) = self.theta.sin_cos();
        let omega = axis * self.w;
        let centre = -(nalgebra::Rotation3::from_axis_angle(&Vector3::z_axis(), aside) * forward) * self.v
            + omega.cross(&(forward * c + Vector3::z() * s)) * L;
        simulation(&format!(
            "duration = {duration}
            floor = {{ friction = {} }}
            robot = {{ model = \"robots/rod/rod.toml\", contact = \"soles\", base = {{ rpy = [0, {:?}, {:?}], linear_velocity = {:?}, angular_velocity = {:?} }} }}
            {TIGHT}",
            self.mu,
            std::f64::consts::FRAC_PI_2 - self.theta,
            self.heading,
            centre.as_slice(),
            omega.as_slice()
        ))
    }

    /// Simulates the first selection of states.
    fn begin(&self) -> (Simulation, Recording) {
        let (mut sim, mut recording) = (self.simulation(1.0), Recording::default());
        sim.begin(&mut recording).unwrap_or_else(|e| panic!("{e}"));
        (sim, recording)
    }

    /// Sliding by the balances of the module page, unknowns w' and N, by Cramer's rule: `[w', N]`.
    fn balance(&self, theta: f64, w: f64) -> [f64; 2] {
        let (s, c) = theta.sin_cos();
        let inertia = MASS * L * L / 3.0;
        // m l c w' - N = m l s w^2 - m g;  I w' + l (c - mu s) N = 0
        let (a, b, p) = (MASS * L * c, -1.0, MASS * (L * s * w * w - G));
        let (d, e) = (inertia, L * (c - self.mu * s));
        let det = a * e - b * d;
        [p * e / det, -p * d / det]
    }
}

/// Velocity of the tip and angular velocity in the rod's plane (forward, up, w), and the component
/// out of the plane.
fn plane(sim: &Simulation, start: &Start) -> [f64; 4] {
    let (forward, axis) = start.axes();
    let tip = sim.plant().problem.soles[0].vertices[0].velocity;
    let omega = Vector3::from_column_slice(&sim.plant().reduced.velocity[3..6]);
    let side = forward.cross(&Vector3::z());
    [tip.dot(&forward), tip.z, omega.dot(&axis), tip.dot(&side).abs() + (omega - axis * omega.dot(&axis)).norm()]
}

#[test]
fn below_the_critical_friction_the_force_is_finite_and_known() {
    for theta in [0.6, 1.1, 1.4] {
        for part in [0.0, 0.5, 0.99, 0.9999] {
            for (heading, w) in HEADINGS.into_iter().zip([0.0, 1.5, -2.0, 0.5, 3.0]) {
                let start = Start { theta, heading, v: 0.8, w, mu: part * critical(theta) };
                let (sim, _) = start.begin();
                let [_, force] = start.balance(theta, w);
                let (s, c) = theta.sin_cos();
                let formula = MASS * (G - L * w * w * s) / (1.0 + 3.0 * c * c - 3.0 * start.mu * s * c);
                assert!((formula / force - 1.0).abs() < 1e-9);
                let n = sim.plant().solution.normal[0][0];
                // The denominator is a difference: rounding of the pose (1e-15) over its size
                // (1e-4).
                assert!((n / force - 1.0).abs() < 1e-9, "{start:?}: {n} {force}");
                assert!(sim.plant().states[0].is_dynamic());
                assert_eq!((sim.metrics().jams, sim.metrics().inconsistent), (0, 0), "{start:?}");
            }
        }
    }
}

#[test]
fn the_jam_begins_at_the_critical_friction() {
    for theta in [0.5, 0.9, 2f64.atan(), 1.3] {
        for heading in HEADINGS {
            let jams = |mu: f64| {
                let (sim, recording) = Start { theta, heading, v: 0.8, w: 0.3, mu }.begin();
                assert_eq!(sim.metrics().inconsistent, 0);
                assert_eq!(recording.events.iter().filter(|e| e.kind == "jam").count() as u64, sim.metrics().jams);
                sim.metrics().jams > 0
            };
            let (mut low, mut high) = (0.1, 20.0);
            assert!(!jams(low) && jams(high));
            while high - low > 1e-7 {
                let middle = 0.5 * (low + high);
                if jams(middle) { high = middle } else { low = middle }
            }
            // The bisection's width.
            assert!((low - critical(theta)).abs() < 1e-6, "{low} {}", critical(theta));
        }
    }
    assert!((critical(2f64.atan()) - 4.0 / 3.0).abs() < 1e-15);
}

#[test]
fn a_jam_conserves_angular_momentum_about_the_tip() {
    for theta in [0.6, 1.1, 1.3] {
        for factor in [1.000_001, 1.1, 3.0] {
            for (heading, w) in HEADINGS.into_iter().zip([0.0, 1.5, -2.0, 0.5, 3.0]) {
                for v in [1e-3, 0.7, 9.0] {
                    let start = Start { theta, heading, v, w, mu: factor * critical(theta) };
                    let (sim, recording) = start.begin();
                    assert_eq!((sim.metrics().jams, sim.metrics().inconsistent), (1, 0), "{start:?}");
                    assert_eq!(recording.events.iter().filter(|e| e.kind == "jam" && e.subject == "tip").count(), 1);
                    let (s, c) = theta.sin_cos();
                    let [forward, up, turn, sideways] = plane(&sim, &start);
                    // Rounding of one solve with velocities of some m/s.
                    assert!(
                        forward.abs() + up.abs() + sideways < 1e-12 * (1.0 + v),
                        "{start:?} {forward} {up} {sideways}"
                    );
                    assert!((turn - (w + 0.75 * v * s / L)).abs() < 1e-12 * (1.0 + v), "{start:?} {turn}");
                    // Kinetic energies before and after from the tip's velocity and w.
                    let kinetic = |v: f64, w: f64| {
                        let (x, z) = (-v - L * w * s, L * w * c);
                        0.5 * MASS * (x * x + z * z + L * L / 3.0 * w * w)
                    };
                    let lost = kinetic(v, w) - kinetic(0.0, turn);
                    let loss = MASS * v * v * (1.0 + 3.0 * c * c) / 8.0;
                    assert!((lost - loss).abs() < 1e-12 * (10.0 + v * v), "{start:?} {lost} {loss}");
                }
            }
        }
    }
}

#[test]
fn fast_rotation_lifts_off_where_sliding_is_also_possible() {
    for heading in HEADINGS {
        // l w^2 sin > g beyond the critical friction: the state is indeterminate, and lift-off
        // clamps less.
        let start = Start { theta: 1.1, heading, v: 0.8, w: 5.0, mu: 2.0 * critical(1.1) };
        let (sim, _) = start.begin();
        assert!(start.balance(1.1, 5.0)[1] > 0.0, "sliding under load would be a solution");
        assert_eq!(sim.plant().states[0], SoleState::FREE);
        assert_eq!((sim.metrics().jams, sim.metrics().inconsistent), (0, 0));
    }
}

#[test]
fn off_its_plane_a_jam_is_resolved_and_energy_falls() {
    // Slip at any angle to the rod's plane, also with sideways rotation.
    let mut jams = 0;
    for n in 0..400 {
        let part = |k: f64| (f64::from(n) * k).fract();
        let (theta, mu) = (0.4 + 1.1 * part(0.618_034), 1.3 + 3.0 * part(0.414_214));
        let (heading, aside) = (6.3 * part(0.732_051), 1.6 * (part(0.236_068) - 0.5));
        let start = Start { theta, heading, v: 1.0, w: 2.0 * part(0.162_278) - 1.0, mu };
        let mut sim = start.simulation_aside(0.05, aside);
        let mut recording = Recording::default();
        let before = sim.plant().problem.soles[0].vertices[0].velocity;
        sim.begin(&mut recording).unwrap_or_else(|e| panic!("{e}"));
        let after = sim.plant().problem.soles[0].vertices[0].velocity;
        let m = sim.metrics();
        assert_eq!(m.inconsistent, 0, "{start:?} {aside}");
        jams += m.jams;
        if m.jams > 0 {
            // The solution is exact for a slip that ends; a continuing slip leaves a thousandth of
            // the vanishing approach.
            assert!(after.z.abs() < 1e-9 && after.norm() < before.norm(), "{start:?} {aside} {before} {after}");
            assert!(
                recording.events.iter().any(|e| e.kind == "jam" && !e.message.contains("lost -")),
                "{:?}",
                recording.events
            );
        }
        let m = finish(&mut start.simulation_aside(0.05, aside), &mut NullObserver);
        // Integration of some 10 J at 1e-9.
        assert!(m.inconsistent == 0 && m.energy_error_j.abs() < 1e-7, "{start:?} {aside}: {m:?}");
    }
    assert!(jams > 50, "{jams} jams seen");
}

/// End of a slide that reaches `mu_c`: kind, time, angle, w, slip, by the balance of the module
/// page in the time s with `dt = D ds`, `D = 1 + 3 cos^2 - 3 mu sin cos`, in which the singular
/// point is an ordinary one.
fn ending(start: &Start) -> (&'static str, [f64; 4]) {
    let d = |y: &[f64; 4]| {
        let (s, c) = y[1].sin_cos();
        1.0 + 3.0 * c * c - 3.0 * start.mu * s * c
    };
    let weight = |y: &[f64; 4]| G - L * y[2] * y[2] * y[1].sin();
    let f = |_: f64, y: &[f64; 4]| {
        let ([_, theta, w, _], scale) = (*y, d(y));
        let (s, c) = theta.sin_cos();
        // D N, and D w'.
        let force = MASS * weight(y);
        let turn = 3.0 / (MASS * L) * (start.mu * s - c) * force;
        [scale, scale * w, turn, -(start.mu * force / MASS + scale * L * c * w * w + L * s * turn)]
    };
    let mut y = [0.0, start.theta, start.w, start.v];
    loop {
        let (mut step, next) = (1e-4, rk4(y, 1e-4, 1, f));
        let crossed = |y: &[f64; 4]| y[3] <= 0.0 || weight(y) <= 0.0;
        if d(&next) < 1e-13 && !crossed(&next) {
            // The remaining impulse changes w to its end, where the weight vanishes; slip follows
            // in proportion.
            let [t, theta, w, v] = next;
            let (s, c) = theta.sin_cos();
            let end = (G / (L * s)).sqrt();
            let rate = -(start.mu / (3.0 / L * (start.mu * s - c)) + L * s);
            return ("jam", [t, theta, end, v + rate * (end - w)]);
        }
        if crossed(&next) {
            for _ in 0..60 {
                step *= 0.5;
                let half = rk4(y, step, 1, f);
                if !crossed(&half) {
                    y = half;
                }
            }
            return (if y[3] < 1e-6 { "stick" } else { "liftoff" }, y);
        }
        y = next;
    }
}

#[test]
fn sliding_towards_the_limit_ends_as_the_rods_equations_predict() {
    let cases = [
        (1.4, 0.3, 2.0, 2.0, "stick"),
        (1.4, 0.3, 4.0, 10.0, "liftoff"),
        (2.0, 0.5, 2.0, 2.0, "stick"),
        (2.0, 1.4, 4.0, 10.0, "liftoff"),
        (2.0, 0.3, 2.0, 10.0, "jam"),
        (2.0, 0.5, 0.0, 10.0, "jam"),
        (3.0, 0.3, 4.0, 10.0, "jam"),
    ];
    for (mu, theta, w, v, kind) in cases {
        for heading in HEADINGS {
            let start = Start { theta, heading, v, w, mu };
            let (truth, [t, angle, turn, slip]) = ending(&start);
            assert_eq!(truth, kind, "{start:?}");
            let (mut sim, mut recording) = (start.simulation(1.0), Recording::default());
            sim.begin(&mut recording).unwrap_or_else(|e| panic!("{e}"));
            while recording.events.is_empty() {
                sim.step(&mut recording).unwrap_or_else(|e| panic!("{start:?}: {e}"));
            }
            let first = &recording.events[0];
            let [forward, up, omega, sideways] = plane(&sim, &start);
            assert_eq!((first.kind.as_str(), sim.metrics().inconsistent), (kind, 0), "{start:?}");
            assert_eq!(sim.metrics().jams, u64::from(kind == "jam"));
            // Integration at 1e-9 of speeds of up to 10 m/s, 1e-8 m/s a second; slips end and loads
            // vanish at some m/s^2. At the singular point the force is a root in time, which
            // amplifies the errors of the last steps.
            let bar = if kind == "jam" { 1e-6 } else { 1e-7 };
            assert!((first.time - t).abs() < bar, "{start:?} {} {t}", first.time);
            assert!(
                (omega - turn).abs() < 10.0 * bar && (forward + slip).abs() < 10.0 * bar,
                "{start:?} {omega} {turn} {forward} {slip}"
            );
            assert!(up.abs() + sideways < 1e-8, "{start:?} {up} {sideways}");
            if kind == "jam" {
                // The singular point in closed form: tan^2 - 3 mu tan + 4 = 0, l w^2 sin = g.
                let tan = 0.5 * (3.0 * mu - (9.0 * mu * mu - 16.0).sqrt());
                assert!((angle - tan.atan()).abs() < 1e-12, "{angle}");
                assert!((omega - (G / (L * tan.atan().sin())).sqrt()).abs() < 1e-9, "{omega}");
                assert_eq!(sim.plant().states[0], SoleState::FREE);
            }
        }
    }
}

#[test]
fn a_tall_box_trips_over_its_leading_edge() {
    // Flat on a face, half width a along the motion, centre at height h: with the leading edge as
    // the tip of the rod, mu_c = (I / m + a^2) / (a h) = (4 a^2 + h^2) / (3 a h), and w+ = m v h /
    // (I + m (a^2 + h^2)).
    for (a, b, h) in [(0.1, 0.1, 0.2), (0.05, 0.2, 0.2), (0.1, 0.05, 0.15)] {
        let body = Body::new([a, b, h], 2.0);
        let (critical, turn) = ((4.0 * a * a + h * h) / (3.0 * a * h), 0.75 * 1.3 * h / (a * a + h * h));
        for yaw in [0.0, 1.0, 4.0] {
            let run = |mu: f64| {
                let (sin, cos) = f64::sin_cos(yaw);
                let base = format!("rpy = [0, 0, {yaw}], linear_velocity = [{}, {}, 0]", 1.3 * cos, 1.3 * sin);
                let mut sim =
                    simulation(&format!("duration = 1\nfloor = {{ friction = {mu} }}\n{}{TIGHT}", body.robot(&base)));
                sim.begin(&mut NullObserver).unwrap_or_else(|e| panic!("{e}"));
                assert_eq!(sim.metrics().inconsistent, 0, "{mu}");
                sim
            };
            let (mut low, mut high) = (0.2, 20.0);
            while high - low > 1e-7 {
                let middle = 0.5 * (low + high);
                if run(middle).metrics().jams > 0 { high = middle } else { low = middle }
            }
            assert!((low - critical).abs() < 1e-6, "{a} {h} {yaw}: {low} {critical}");
            let sim = run(1.2 * critical);
            let omega = Vector3::from_column_slice(&sim.plant().reduced.velocity[3..6]);
            // Rounding of one solve.
            assert!((omega - Vector3::new(-yaw.sin(), yaw.cos(), 0.0) * turn).norm() < 1e-11 * turn, "{omega} {turn}");
        }
    }
}

#[test]
fn the_scenarios_expect_the_values_of_the_equations() {
    // painleve-jam: tan theta = 2, tip at 0.5 m/s, then a pendulum about the tip for 0.1 s.
    let theta = 2f64.atan();
    let w = 0.75 * 0.5 * theta.sin() / L;
    let [end, _] = rk4([theta, w], 0.1, 4000, |_, [a, w]: &[f64; 2]| [*w, -0.75 * G / L * a.cos()]);
    let file = |name: &str| {
        let path = crate::support::runs::root().join(format!("scenarios/validation/painleve-{name}.toml"));
        stiction::scenario::load(&path).unwrap_or_else(|e| panic!("{e}")).expand(&[]).unwrap_or_else(|e| panic!("{e}"))
    };
    let expects = |name: &str, metric: &str, truth: f64, bar: f64| {
        for run in file(name) {
            let expect = run
                .scenario
                .expect
                .iter()
                .find(|e| e.metric.as_deref() == Some(metric))
                .expect("an expectation of this metric");
            assert!((expect.value.expect("a value") - truth).abs() < bar, "{name} {metric} {truth}");
        }
    };
    expects("jam", "final_base_pitch", std::f64::consts::FRAC_PI_2 - end, 1e-12);
    expects("jam", "final_base_x", L * (end.cos() - theta.cos()), 1e-12);
    let limit = Start { theta: 0.5, heading: 0.0, v: 10.0, w: 0.0, mu: 2.0 };
    let (kind, [t, ..]) = ending(&limit);
    assert_eq!(kind, "jam");
    expects("limit", "first_liftoff_s", t, 1e-7);
}
