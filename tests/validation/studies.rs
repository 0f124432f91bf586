//! The true values that `scenarios/studies/work-precision-block.toml` compares with, each computed
//! again from its equation.

use stiction::scenario;

use crate::analytic::body::{Body, G};
use crate::analytic::planar;
use crate::support::runs::{rk4, root};

#[test]
fn values_of_the_block_follow_from_its_motion() {
    let file = scenario::load(&root().join("scenarios/studies/work-precision-block.toml")).expect("it is there");
    let runs = file.expand(&[]).unwrap_or_else(|e| panic!("{e}"));
    let (mut slides, mut spins) = (0, 0);
    for run in &runs {
        let s = &run.scenario;
        let ([vx, vy, _], [.., w]) = (s.robot.base.linear_velocity, s.robot.base.angular_velocity);
        let mu = s.floor.friction.kinetic;
        let truth = &s.compare.as_ref().expect("it compares").truth;
        let named = |metric: &str| truth.iter().find(|(name, _)| name.0 == metric).map(|(_, value)| *value);
        let typed = ["final_base_x", "final_base_y", "final_base_yaw"].map(|metric| named(metric).expect("a truth"));
        let (expected, allowed) = if w == 0.0 {
            slides += 1;
            let way = vx.hypot(vy) / (2.0 * mu * G);
            assert!(vx.hypot(vy) / (mu * G) < s.duration, "it comes to rest");
            ([vx * way, vy * way, 0.0], 1e-16)
        } else {
            spins += 1;
            // 1 kg, 0.2 x 0.2 x 0.1 m: robots/block.
            let body = Body::new([0.1, 0.1, 0.05], 1.0);
            let start = [0.0, 0.0, 0.0, vx, vy, w];
            let end = rk4(start, s.duration, 4000, |_, y: &[f64; 6]| planar::derivative(&body, mu, y));
            // Rounding of 4000 steps; their own error is below it.
            ([end[0], end[1], end[2]], 1e-14)
        };
        for (typed, expected) in typed.iter().zip(&expected) {
            assert!((typed - expected).abs() <= allowed, "{typed} {expected}");
        }
    }
    assert!(slides > 20 && slides == spins, "{slides} {spins}");
}
