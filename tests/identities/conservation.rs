//! Energy and momentum: changes by forces, and conservation.

use super::numeric::{along, assert_near, prepared};
use super::random_tree::{Random, samples};
use nalgebra::Vector3;
use stiction::dynamics::{State, Workspace, aba, body, kinematics};
use stiction::robot::Model;

fn at(model: &Model, state: &State) -> Workspace {
    let mut ws = Workspace::new(model);
    kinematics::update(model, state, &mut ws);
    ws
}

/// Rate of `f` along the motion under `tau` without gravity, by central difference (step 1e-5).
fn rate(model: &Model, state: &State, tau: &[f64], f: impl Fn(&Workspace) -> Vec<f64>) -> Vec<f64> {
    let mut vdot = vec![0.0; model.nv()];
    aba::forward_dynamics(model, &mut at(model, state), tau, &Vector3::zeros(), &mut vdot).unwrap();
    let there = |t: f64| {
        let mut s = state.clone();
        s.displace(&state.v.iter().zip(&vdot).map(|(v, a)| t * (v + 0.5 * t * a)).collect::<Vec<_>>());
        s.v.iter_mut().zip(&vdot).for_each(|(v, a)| *v += t * a);
        f(&at(model, &s))
    };
    let h = 1e-5;
    there(h).iter().zip(there(-h)).map(|(b, a)| (b - a) / (2.0 * h)).collect()
}

fn efforts(model: &Model, r: &mut Random) -> Vec<f64> {
    r.list(model.nv(), 5.0)
}

#[test]
fn kinetic_energy_is_half_v_m_v() {
    for (model, state, _) in samples() {
        let ws = prepared(&model, &state);
        let mut p = vec![0.0; model.nv()];
        ws.mass.multiply(&state.v, &mut p);
        let truth = 0.5 * p.iter().zip(&state.v).map(|(p, v)| p * v).sum::<f64>();
        assert_near("T", &[body::kinetic_energy(&model, &ws)], &[truth], 1e-13);
    }
}

#[test]
fn kinetic_energy_changes_by_the_power_of_the_generalised_force() {
    for (model, state, mut r) in samples() {
        let tau = efforts(&model, &mut r);
        let power: f64 = tau.iter().zip(&state.v).map(|(t, v)| t * v).sum();
        let energy = rate(&model, &state, &tau, |ws| vec![body::kinetic_energy(&model, ws)]);
        // Truncation h^2 T''' with energies near 1e2 J and rates near 1e2 1/s.
        let scale = body::kinetic_energy(&model, &at(&model, &state)).max(power.abs());
        assert_near("T'", &[energy[0] / scale], &[power / scale], 1e-6);
    }
}

#[test]
fn potential_energy_falls_by_the_power_of_gravity() {
    let g = Vector3::new(0.3, -0.2, -9.7);
    for (model, state, _) in samples() {
        let fall = along(&state, &state.v, 1e-5, |s| vec![body::potential_energy(&at(&model, s), &g)]);
        let ws = at(&model, &state);
        let power = body::momentum(&ws).linear.dot(&g);
        assert_near("U'", &[-fall[0]], &[power], 1e-8);
    }
}

/// Joint efforts are internal: only the base force changes the momentum. (Only without armature, a
/// reflected inertia that does not enter the momentum.)
#[test]
fn momentum_of_a_floating_tree_changes_by_the_base_force_alone() {
    for (mut model, state, mut r) in samples().filter(|s| s.0.nb() == 6) {
        model.joints.iter_mut().for_each(|j| j.armature = 0.0);
        let tau = efforts(&model, &mut r);
        let got = rate(&model, &state, &tau, |ws| {
            let m = body::momentum(ws);
            [m.linear.as_slice(), m.angular.as_slice()].concat()
        });
        let force = Vector3::from_column_slice(&tau[..3]);
        let moment = Vector3::from_column_slice(&tau[3..6]);
        let lever = state.position - body::center_of_mass(&at(&model, &state));
        let about_com = moment + lever.cross(&force);
        let truth = [force.as_slice(), about_com.as_slice()].concat();
        assert_near("l', k'", &got, &truth, 1e-6);
    }
}

/// The base rows of M v are the linear momentum and the angular momentum about the base origin.
#[test]
fn momentum_by_links_equals_momentum_by_the_mass_matrix() {
    for (model, state, _) in samples().filter(|s| s.0.nb() == 6) {
        let ws = prepared(&model, &state);
        let mut p = vec![0.0; model.nv()];
        ws.mass.multiply(&state.v, &mut p);
        let m = body::momentum(&ws);
        assert_near("l", m.linear.as_slice(), &p[..3], 1e-13);
        let about_base = m.angular + (body::center_of_mass(&ws) - state.position).cross(&m.linear);
        assert_near("k about the base", about_base.as_slice(), &p[3..6], 1e-13);
        assert_near("m", &[body::total_inertia(&ws).mass], &[model.mass()], 1e-15);
    }
}

/// Nothing depends on the origin or the orientation of the world frame.
#[test]
fn rotating_the_world_rotates_the_motion() {
    for (model, state, mut r) in samples().filter(|s| s.0.nb() == 6) {
        let g = Vector3::new(0.0, 0.0, -9.81);
        let tau = efforts(&model, &mut r);
        let turn = nalgebra::UnitQuaternion::from_scaled_axis(r.vector(2.0));
        let turned = |x: &[f64]| {
            let mut y = x.to_vec();
            for half in [0, 3] {
                let v = turn * Vector3::from_column_slice(&x[half..half + 3]);
                y[half..half + 3].copy_from_slice(v.as_slice());
            }
            y
        };
        let mut other = state.clone();
        other.position = turn * state.position + r.vector(5.0);
        other.rotation = turn * state.rotation;
        other.v = turned(&state.v);
        let (mut a, mut b) = (vec![0.0; model.nv()], vec![0.0; model.nv()]);
        aba::forward_dynamics(&model, &mut at(&model, &state), &tau, &g, &mut a).unwrap();
        aba::forward_dynamics(&model, &mut at(&model, &other), &turned(&tau), &(turn * g), &mut b).unwrap();
        assert_near("vdot", &b, &turned(&a), 1e-11);
    }
}
