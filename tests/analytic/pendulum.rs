//! A double pendulum against its equations of motion.
//!
//! With absolute angles a, b of two equal bars (mass m, length l, inertia I about the middle, c = l / 2) and d = a - b:
//!
//! ```text
//! (I + m c^2 + m l^2) a'' + m l c cos d b'' =  -m l c sin d b'^2 - (m c + m l) g sin a
//!  m l c cos d a'' + (I + m c^2) b''        =   m l c sin d a'^2 - m c g sin b
//! ```

use super::body::G;
use crate::support::runs::{finish, rk4, simulation};
use stiction::sim::NullObserver;

const M: f64 = 1.0;
const L: f64 = 0.5;
const C: f64 = 0.25;
/// m (0.5^2 + 0.02^2) / 12
const I: f64 = 0.25040 / 12.0;

/// Derivative of `[a, b, a', b']`.
pub fn derivative(s: &[f64; 4]) -> [f64; 4] {
    let [a, b, p, q] = *s;
    let (sin, cos) = (a - b).sin_cos();
    let coupling = M * L * C;
    let (xx, xy, yy) = (I + M * C * C + M * L * L, coupling * cos, I + M * C * C);
    let right = [-coupling * sin * q * q - M * (C + L) * G * a.sin(), coupling * sin * p * p - M * C * G * b.sin()];
    let det = xx * yy - xy * xy;
    [p, q, (yy * right[0] - xy * right[1]) / det, (xx * right[1] - xy * right[0]) / det]
}

#[test]
fn a_double_pendulum_obeys_its_equations_and_conserves_energy() {
    for (shoulder, elbow, rate) in [(0.5, 0.2, 0.0), (2.0, -1.0, 1.0), (-1.2, 2.5, -3.0)] {
        let duration = 2.0;
        let mut sim = simulation(&format!(
            "duration = {duration}
            integrator = {{ relative_tolerance = 1e-12, absolute_tolerance = 1e-13 }}
            [robot]
            model = \"robots/pendulum/pendulum.urdf\"
            soles = []
            joint_default = {{ mode = \"passive\" }}
            posture = {{ shoulder = {shoulder}, elbow = {elbow} }}
            velocity = {{ shoulder = {rate}, elbow = 0.5 }}\n"
        ));
        let m = finish(&mut sim, &mut NullObserver);
        let truth = rk4([shoulder, shoulder + elbow, rate, rate + 0.5], duration, 200_000, |_, s| derivative(s));
        let (q, v) = (&sim.plant().state.joints, &sim.plant().state.v);
        // Integration at 1e-12 over some thousand steps, amplified by the divergence of
        // neighbouring trajectories, at most 1e3.
        for (mine, truth) in [(q[0], truth[0]), (q[0] + q[1], truth[1]), (v[0], truth[2]), (v[0] + v[1], truth[3])] {
            assert!((mine - truth).abs() < 1e-8, "{mine} {truth}");
        }
        // No force drives it, so the work is zero and the error is the drift of the energy:
        // integration error.
        assert!(m.energy_error_j.abs() < 1e-9, "{}", m.energy_error_j);
    }
}
