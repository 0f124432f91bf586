//! A block on a floor: cases with a one-line solution.

use crate::support::runs::run;

const G: f64 = 9.81;

fn sliding(heading: f64, speed: f64, mu: f64, rest: &str) -> String {
    let (s, c) = heading.sin_cos();
    format!(
        r#"
        duration = 2.0
        robot = {{ model = "robots/block/block.toml", base = {{ linear_velocity = [{}, {}, 0.0] }} }}
        floor = {{ friction = {mu} }}
        integrator = {{ relative_tolerance = 1e-9, absolute_tolerance = 1e-11 }}
        {rest}
        "#,
        speed * c,
        speed * s
    )
}

#[test]
fn a_sliding_block_stops_after_the_closed_distance_for_any_heading() {
    for k in 0..16 {
        let heading = 0.1 + k as f64 * std::f64::consts::TAU / 16.0;
        for (speed, mu) in [(2.0, 0.5), (1.0, 0.15)] {
            let m = run(&sliding(heading, speed, mu, ""));
            let truth = speed * speed / (2.0 * mu * G);
            let (s, c) = heading.sin_cos();
            let [x, y, z] = m.final_base_position;
            println!("{heading:.3} {} {} {} {m:?}", (x * c + y * s) / truth - 1.0, x * s - y * c, z - 0.05);
            // Integration at relative tolerance 1e-9 and the location of the stop.
            assert!(((x * c + y * s) / truth - 1.0).abs() < 1e-8);
            assert!((x * s - y * c).abs() < 1e-9, "sideways");
            assert!((z - 0.05).abs() < 1e-12, "height");
            let stop = m.first_stick_s.expect("it stops");
            assert!((stop / (speed / (mu * G)) - 1.0).abs() < 1e-8);
            assert_eq!(m.inconsistent, 0);
        }
    }
}
