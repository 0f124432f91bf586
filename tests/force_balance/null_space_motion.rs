//! Projection onto motions that satisfy the constraints.

use crate::identities::random_tree::Random;
use stiction::task::balance::null_space_motion::NullSpaceMotion;

#[test]
fn two_joints_share_a_constraint_by_their_weights() {
    // Minimise sum w (v - e)^2 with v1 + v2 = 0: v = e - (1/w1, 1/w2) (e1 + e2) / (1/w1 + 1/w2).
    let mut null_space = NullSpaceMotion::new(0, &[1.0, 3.0], 2);
    null_space.constrain(|_| 1.0);
    // Projecting again, and projecting the negative, change nothing.
    null_space.constrain(|_| -2.0);
    let mut v = [2.0, 2.0];
    null_space.project(&mut v);
    assert!((v[0] + 1.0).abs() < 1e-15 && (v[1] - 1.0).abs() < 1e-15, "{v:?}");
}

#[test]
fn moving_the_base_costs_nothing() {
    // Base x and two joints; the foot is at x + q1 + 2 q2 and has to stay: the base compensates for
    // the joints.
    let mut null_space = NullSpaceMotion::new(1, &[1.0, 1.0], 2);
    null_space.constrain(|k| [1.0, 1.0, 2.0][k]);
    let mut v = [0.0, 0.3, -0.5];
    null_space.project(&mut v);
    // The base has a small weight: 1e-8 of a joint's.
    assert!((v[1] - 0.3).abs() < 1e-7 && (v[2] + 0.5).abs() < 1e-7 && (v[0] - 0.7).abs() < 1e-7, "{v:?}");
    // With the base constrained too, the joints share.
    null_space.constrain(|k| if k == 0 { 1.0 } else { 0.0 });
    let mut v = [0.0, 1.0, 2.0];
    null_space.project(&mut v);
    assert!(v.iter().all(|v| v.abs() < 1e-7), "{v:?}");
}

#[test]
fn the_projection_keeps_its_constraints() {
    let mut r = Random::new(31);
    let (nb, nj, rows) = (6, 20, 15);
    let weights: Vec<f64> = (0..nj).map(|_| r.within(1e-4, 2.0)).collect();
    let constraints: Vec<Vec<f64>> = (0..rows).map(|_| r.list(nb + nj, 1.0)).collect();
    let mut null_space = NullSpaceMotion::new(nb, &weights, rows);
    constraints.iter().for_each(|row| null_space.constrain(|k| row[k]));
    let mut v = r.list(nb + nj, 1.0);
    v[..nb].fill(0.0);
    let wish = v.clone();
    null_space.project(&mut v);
    for row in &constraints {
        let left: f64 = row.iter().zip(&v).map(|(a, v)| a * v).sum();
        // Rounding, amplified by the scaling of the base, 1e4, and of the lightest joints, 1e2.
        assert!(left.abs() < 1e-9, "{left:e}");
    }
    // The residual is orthogonal to the projected motion, in the weighted metric.
    let product: f64 = (0..nj).map(|j| weights[j] * v[nb + j] * (wish[nb + j] - v[nb + j])).sum();
    assert!(product.abs() < 1e-7 && v[nb..].iter().any(|v| v.abs() > 0.1), "{product:e}");
    let again = {
        let mut w = v.clone();
        null_space.project(&mut w);
        w
    };
    assert!(v.iter().zip(&again).all(|(a, b)| (a - b).abs() < 1e-9));
}
