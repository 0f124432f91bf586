//! Directions that the data do not determine, known in closed form, and estimates at bounds.

use super::{Bench, add_noise, fill, repository};

/// A block slides to rest: x = v t - mu g t^2 / 2. Only the product of friction and gravity matters;
/// a payload adds as much inertia as friction.
fn sliding(parameters: &[(&str, f64, f64, f64)], extra: &str) -> (Bench, String) {
    let bench = Bench::new();
    bench.grid("slide.csv", &["base_x_m"], 50.0, 20);
    bench.write(
        "block.toml",
        &format!(
            "duration = 1.0\nfloor = {{ friction = {{ static = 0.5, kinetic = 0.5 }} }}\n\
             gravity = [0, 0, -9.81]\n[robot]\nmodel = {:?}\nbase = {{ linear_velocity = [3, 0, 0] }}\n\
             payload = [{{ link = \"block\", mass = 0.5, position = [0, 0, 0.02] }}]\n",
            repository("robots/block/block.toml")
        ),
    );
    let mut text = "scenario = \"block.toml\"\n[[data]]\nfile = \"slide.csv\"\n".to_owned();
    for (key, start, min, max) in parameters {
        text += &format!("[[parameter]]\nkey = {key:?}\nstart = {start}\nmin = {min}\nmax = {max}\n");
    }
    text += &format!("[[signal]]\ncolumn = \"base_x_m\"\nsigma = 0.001\n{extra}");
    (bench, text)
}

#[test]
fn only_the_product_of_friction_and_gravity_slows_a_block() {
    let (bench, text) = sliding(
        &[
            ("floor.friction.kinetic", 0.45, 0.1, 0.5),
            ("gravity.2", -9.0, -12.0, -6.0),
            ("robot.payload.0.mass", 0.7, 0.1, 2.0),
        ],
        "",
    );
    let mut fit = bench.fit(&text);
    fill(&mut fit, &[0.4, -9.81, 0.5]);
    let estimate = fit.solve().unwrap();
    let values: Vec<f64> = estimate.parameters.iter().map(|p| p.estimate).collect();
    // Found by steps of 1e-10, of runs with tolerances of 1e-6 that are exact for this motion.
    assert!((values[0] * values[1] / (0.4 * -9.81) - 1.0).abs() < 1e-8, "{values:?}");
    assert!(estimate.parameters.iter().all(|p| !p.determined && p.interval.is_none()), "{:?}", estimate.parameters);
    assert_eq!(estimate.not_determined.len(), 2);
    let texts: Vec<&str> = estimate.not_determined.iter().map(|direction| direction.text.as_str()).collect();
    let product = "the data determine only the product of `floor.friction.kinetic` and `gravity.2`: ";
    assert!(texts.iter().any(|text| text.starts_with(product)), "{texts:?}");
    let mass = "the data do not determine `robot.payload.0.mass`: it has no effect on the signals";
    assert!(texts.contains(&mass), "{texts:?}");
    let weights = &estimate.not_determined.iter().find(|d| d.text.starts_with(product)).unwrap().weights;
    // d mu / mu = - d g / g; gravity is negative, so its relative size grows with its value. The error is that
    // of central differences of a quadratic, rounding over steps of 1e-2.
    let half = 0.5_f64.sqrt();
    assert!((weights[0] - half).abs() < 1e-6 && (weights[1] - half).abs() < 1e-6, "{weights:?}");
    assert!(estimate.is_undetermined() && !estimate.differs() && !estimate.is_unfinished());
    assert_eq!(estimate.degrees_of_freedom, 20 - 1);
}

/// A single parameter of a motion that is quadratic in it: the standard error has a closed form.
#[test]
fn the_standard_error_is_that_of_linear_regression() {
    let (bench, text) = sliding(&[("floor.friction.kinetic", 0.3, 0.1, 0.5)], "");
    let mut fit = bench.fit(&text);
    fill(&mut fit, &[0.4]);
    let estimate = fit.solve().unwrap();
    // x_k = 3 t_k - mu g t_k^2 / 2, so dx/dmu = -g t^2 / 2 at t = k / 50, k < 20; it stops after 0.76 s.
    let sum: f64 = (0..20).map(|k| (9.81 * 0.5 * (f64::from(k) / 50.0).powi(2)).powi(2)).sum();
    let exact = 0.001 / sum.sqrt();
    let found = estimate.parameters[0].standard_error.unwrap();
    // Rounding of the differences.
    assert!((found / exact - 1.0).abs() < 1e-9, "{found:e} and {exact:e}");
    let [low, high] = estimate.parameters[0].interval.unwrap();
    // 1.959964 is the 97.5 % point of the normal distribution.
    assert!(((high - low) / (2.0 * 1.959963984540054 * exact) - 1.0).abs() < 1e-9);
}

/// Without `sigma` the noise is that of the residuals, and the quantile is Student's with n - p.
#[test]
fn estimated_noise_gives_the_interval_of_regression() {
    let (bench, text) = sliding(&[("floor.friction.kinetic", 0.3, 0.1, 0.5)], "");
    let mut fit = bench.fit(&text.replace("sigma = 0.001\n", ""));
    fill(&mut fit, &[0.4]);
    add_noise(&mut fit, &[0.002], 5);
    let estimate = fit.solve().unwrap();
    // Linear regression of y = x - 3 t on -g t^2 / 2 by its normal equation.
    let recording = &fit.experiments[0].recording;
    let points: Vec<(f64, f64)> = recording
        .times
        .iter()
        .zip(&recording.channels[0].values)
        .map(|(t, x)| (-9.81 * 0.5 * t * t, x - 3.0 * t))
        .collect();
    let (xx, xy) = points.iter().fold((0.0, 0.0), |(xx, xy), (x, y)| (xx + x * x, xy + x * y));
    let mu = xy / xx;
    let square: f64 = points.iter().map(|(x, y)| (y - mu * x).powi(2)).sum();
    let error = (square / 19.0 / xx).sqrt();
    let found = &estimate.parameters[0];
    // The search ends with predicted decreases of 1e-10 of the sum: 1e-5 of a standard error.
    assert!((found.estimate - mu).abs() < 1e-4 * error, "{} and {mu}", found.estimate);
    assert!((found.standard_error.unwrap() / error - 1.0).abs() < 1e-6);
    let [low, high] = found.interval.unwrap();
    // 2.0930240544 is the 97.5 % point of Student's distribution with 19 degrees of freedom.
    assert!(((high - low) / (2.0 * 2.093024054408263 * error) - 1.0).abs() < 1e-6);
    assert_eq!(estimate.degrees_of_freedom, 19);
    assert!((estimate.reduced_chi_square - 1.0).abs() < 1e-9, "{}", estimate.reduced_chi_square);
}

#[test]
fn an_estimate_at_a_bound_is_reported() {
    let (bench, text) = sliding(&[("floor.friction.kinetic", 0.3, 0.1, 0.35)], "");
    let mut fit = bench.fit(&text);
    fill(&mut fit, &[0.35]);
    fit.parameters[0].bounds = (0.1, 0.33);
    let estimate = fit.solve().unwrap();
    let found = &estimate.parameters[0];
    assert_eq!((found.estimate, found.at_bound, found.interval), (0.33, Some("max"), None));
    assert!(
        estimate.is_undetermined() && estimate.warnings[0].contains("is at its bound `max`"),
        "{:?}",
        estimate.warnings
    );
    assert!(estimate.differs(), "the residuals exceed the noise of 1 mm: {}", estimate.chi_square);
}

/// Held-out data of another friction are found out; those of the same are not.
#[test]
fn held_out_data_are_checked() {
    for (friction, agrees) in [(0.4, true), (0.41, false)] {
        for sigma in ["sigma = 0.001\n", ""] {
            let (bench, text) = sliding(&[("floor.friction.kinetic", 0.3, 0.1, 0.5)], "");
            let text = text.replace("sigma = 0.001\n", sigma);
            let held = "[[data]]\nname = \"held\"\nfile = \"slide.csv\"\nhold_out = true\n[[signal]]";
            let mut fit = bench.fit(&text.replace("[[signal]]", held));
            fill(&mut fit, &[0.4]);
            let other = fit.simulated(&[friction]).unwrap().pop().unwrap();
            fit.experiments[1].recording = other;
            add_noise(&mut fit, &[0.001], 3);
            let estimate = fit.solve().unwrap();
            assert_eq!(estimate.differs(), !agrees, "{friction} {sigma}: {:?}", estimate.data);
            assert_eq!(estimate.values, 20, "held-out data are not fitted");
        }
    }
}
