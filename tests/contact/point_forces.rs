//! The solution with every vertex as a point obeys Signorini's and Coulomb's laws.

use super::pair::{JOINTS, pair};
use super::rest::pressed;
use super::rigid::{G, triple};
use proptest::prelude::*;
use stiction::contact::model::problem::{Level, Problem};
use stiction::contact::search::point_forces::PointForces;

/// Greatest violation of the laws by vertices at rest, relative to the greatest force and motion.
fn violation(p: &Problem, points: &mut PointForces) -> f64 {
    let motion = points.motion(p).to_vec();
    let forces: Vec<_> = points.forces().collect();
    let load = forces.iter().map(|(_, _, f)| f.norm()).fold(f64::MIN_POSITIVE, f64::max);
    let drive = p.b.iter().map(|b| b.abs()).fold(G, f64::max);
    let mut worst: f64 = 0.0;
    for (s, i, f) in forces {
        let (m, mu) = (p.vertex_motion(&motion, s, i), p.soles[s].vertices[i].mu_s);
        let (t, slip) = (f.xy(), m.xy());
        let cone = (t.norm() - mu * f.z) / load;
        // Friction dissipates all it can: t . m_t = -mu N |m_t|.
        let dissipation = (t.dot(&slip) + mu * f.z * slip.norm()) / (load * drive);
        let product = (f.z * m.z).abs() / (load * drive);
        worst = [-f.z / load, -m.z / drive, product, cone, dissipation.abs()].into_iter().fold(worst, f64::max);
    }
    worst
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 200,
        failure_persistence: None,
        rng_seed: proptest::test_runner::RngSeed::Fixed(7),
        ..ProptestConfig::default()
    })]

    #[test]
    fn converged_point_forces_obey_the_contact_laws(
        pair in pair(JOINTS), force in [triple(), triple()], moment in [triple(), triple()]
    ) {
        let loads = [0, 1].map(|i| pressed(&pair.bodies[i], &force[i], &moment[i]));
        let mut p = pair.problem(Level::Acceleration, &loads);
        for v in p.soles.iter_mut().flat_map(|sole| &mut sole.vertices) {
            v.mu_k = v.mu_s;
        }
        let mut points = PointForces::new(&p);
        let residual = points.solve(&p, |_, _| true);
        // Most problems converge; the search does not need the others.
        prop_assume!(residual < 1e-8);
        // The residual of the last iteration, times the ratio of motions and of forces.
        let worst = violation(&p, &mut points);
        prop_assert!(worst < 1e-6, "{worst:e} at a residual of {residual:e}");
    }
}
