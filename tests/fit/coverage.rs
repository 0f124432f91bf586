//! Intervals of 200 noisy fits against the true values.

use rayon::prelude::*;

use super::{Bench, add_noise, fill, repository};

const TRUTH: [f64; 3] = [0.6, 0.4, 0.01];

/// A fit that starts near the truth; `recovery` shows that fits find it from afar.
fn fit_text(sigma: Option<[f64; 2]>) -> String {
    let mut text = format!(
        "scenario = {:?}\n[[data]]\nfile = \"grid.csv\"\n\
         set = {{ \"integrator.relative_tolerance\" = 1e-6, \"integrator.absolute_tolerance\" = 1e-8 }}\n",
        repository("scenarios/fits/base/cart.toml")
    );
    for (key, start, max) in [
        ("floor.friction.static", 0.59, 1.0),
        ("floor.friction.kinetic", 0.395, 0.5),
        ("robot.joint.swing.friction.coulomb", 0.0098, 0.1),
    ] {
        text += &format!("[[parameter]]\nkey = {key:?}\nstart = {start}\nmin = 0.001\nmax = {max}\n");
    }
    for (k, column) in ["base_x_m", "joint.swing.position_rad"].into_iter().enumerate() {
        let sigma = sigma.map_or_else(String::new, |sigma| format!("sigma = {}\n", sigma[k]));
        text += &format!("[[signal]]\ncolumn = \"{column}\"\n{sigma}");
    }
    text
}

/// How often the intervals of `fits` fits cover each parameter.
fn covered(sigma: Option<[f64; 2]>, noise: [f64; 2], fits: u64) -> [usize; 3] {
    let bench = Bench::new();
    bench.grid("grid.csv", &["base_x_m", "joint.swing.position_rad"], 25.0, 26);
    let mut exact = bench.fit(&fit_text(sigma));
    fill(&mut exact, &TRUTH);
    let one = |seed: u64| {
        let mut fit = exact.clone();
        add_noise(&mut fit, &noise, seed);
        let estimate = fit.solve().unwrap();
        assert!(!estimate.is_unfinished() && !estimate.is_undetermined(), "{seed}: {:?}", estimate.warnings);
        let mut holds = [0; 3];
        for ((holds, found), truth) in holds.iter_mut().zip(&estimate.parameters).zip(TRUTH) {
            let [low, high] = found.interval.unwrap();
            *holds = usize::from((low..=high).contains(&truth));
        }
        holds
    };
    let all: Vec<[usize; 3]> = (0..fits).into_par_iter().map(one).collect();
    all.into_iter().fold([0; 3], |sum, one| std::array::from_fn(|k| sum[k] + one[k]))
}

/// The share of 200 independent intervals of 95 % that cover has a standard deviation of 1.5 %.
#[test]
fn intervals_cover_the_truth_as_often_as_they_state() {
    let noise = [0.001, 0.003];
    let counts = covered(Some(noise), noise, 200);
    println!("given noise: {counts:?} of 200");
    assert!(counts.iter().all(|count| (186..=194).contains(count)), "{counts:?} of 200, expected 186 to 194");
}

/// The same with noise that is estimated, of Student's distribution.
#[test]
fn intervals_with_estimated_noise_cover_as_often() {
    let counts = covered(None, [0.001, 0.003], 60);
    println!("estimated noise: {counts:?} of 60");
    // 57 expected, three standard deviations of 1.7 below.
    assert!(counts.iter().all(|count| *count >= 52), "{counts:?} of 60");
}
