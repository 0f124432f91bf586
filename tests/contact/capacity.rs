//! Compares the friction limit of a face with an independent scan over slip twists.

use nalgebra::Vector2;
use proptest::prelude::*;
use stiction::contact::model::friction_capacity;

/// Largest factor of the load that friction can carry: the least ratio of friction power to load
/// power over slip twists. A grid over the sphere of twists is refined by shrinking circles about
/// its best points.
fn factor(points: &[(f64, Vector2<f64>)], force: &Vector2<f64>, yaw: f64, radius: f64) -> f64 {
    let ratio = |[a, b]: [f64; 2]| {
        let ((sa, ca), (sb, cb)) = (a.sin_cos(), b.sin_cos());
        let (v, w) = (Vector2::new(ca * cb, sa * cb), sb / radius);
        let friction: f64 = points.iter().map(|(c, r)| c * (v + Vector2::new(-r.y, r.x) * w).norm()).sum();
        let load = force.dot(&v) + yaw * w;
        if load > 0.0 { friction / load } else { f64::INFINITY }
    };
    let step = std::f64::consts::PI / 60.0;
    let mut best: Vec<(f64, [f64; 2])> = (0..120)
        .flat_map(|i| (-30..=30).map(move |j| [i as f64 * step, j as f64 * step]))
        .map(|p| (ratio(p), p))
        .collect();
    best.sort_by(|a, b| a.0.total_cmp(&b.0));
    best.truncate(5);
    let refine = |(mut value, mut at): (f64, [f64; 2])| {
        let mut size = step;
        while size > 1e-9 {
            let around = (0..12).map(|k| {
                let (s, c) = (k as f64 * std::f64::consts::TAU / 12.0).sin_cos();
                [at[0] + size * c, at[1] + size * s]
            });
            match around.map(|p| (ratio(p), p)).min_by(|a, b| a.0.total_cmp(&b.0)).filter(|(v, _)| *v < value) {
                Some((v, p)) => (value, at) = (v, p),
                None => size *= 0.7,
            }
        }
        value
    };
    best.into_iter().map(refine).fold(f64::INFINITY, f64::min)
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 200,
        failure_persistence: None,
        rng_seed: proptest::test_runner::RngSeed::Fixed(3),
        ..ProptestConfig::default()
    })]

    #[test]
    fn the_margin_of_a_face_crosses_zero_where_friction_gives_way(
        weights in proptest::collection::vec(0.05..2.0f64, 3..9),
        positions in proptest::collection::vec((-0.1..0.1f64, -0.1..0.1f64), 8),
        heading in 0.0..6.3f64,
        share in -1.0..1.0f64,
    ) {
        let points: Vec<_> = weights.iter().zip(&positions).map(|(c, (x, y))| (*c, Vector2::new(*x, *y))).collect();
        let radius = 0.1;
        let force = Vector2::new(heading.cos(), heading.sin()) * (1.0 - share.abs());
        let yaw = share * radius;
        let limit = factor(&points, &force, yaw, radius);
        let margin = |f: f64| friction_capacity::face(&points, &(force * f), yaw * f, radius).0;
        // The scan ends at 1e-9 rad; the ratio is at worst first order there (kinks at vertices).
        prop_assert!(margin(limit * (1.0 - 1e-6)) > 0.0, "{} at {limit}", margin(limit * (1.0 - 1e-6)));
        prop_assert!(margin(limit * (1.0 + 1e-6)) < 0.0, "{} at {limit}", margin(limit * (1.0 + 1e-6)));
    }
}
