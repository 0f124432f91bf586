//! `sweep.random`: the drawn values, their distributions, and their reproducibility.

use stiction::scenario::{ForceSpec, Run, parse_override};

use super::{SMALLEST, file, runs};

/// The runs of a sweep of this `random` table.
fn sampled(random: &str) -> Vec<Run> {
    runs(&format!("{SMALLEST}[sweep]\nrandom = {{ {random} }}\n"))
}

/// The drawn values of one key.
fn drawn(random: &str, key: &str) -> Vec<f64> {
    let number = |run: &Run| {
        let (_, value) = run.parameters.iter().find(|(name, _)| name == key).expect("it is swept");
        value.as_float().or(value.as_integer().map(|i| i as f64)).expect("a number")
    };
    sampled(random).iter().map(number).collect()
}

/// 4096 samples of one distribution.
fn heights(sampling: &str, distribution: &str) -> Vec<f64> {
    let random = format!("samples = 4096, sampling = \"{sampling}\", \"floor.height\" = {{ {distribution} }}");
    drawn(&random, "floor.height")
}

#[test]
fn drawn_values_are_those_of_the_runs() {
    let random = "samples = 5, \"floor.friction\" = { uniform = [0.2, 1.0] }, duration = { uniform = [1, 2] }";
    let runs = sampled(random);
    assert_eq!(runs.len(), 5);
    for run in &runs {
        let names: Vec<_> = run.parameters.iter().map(|p| p.0.as_str()).collect();
        assert_eq!(names, ["floor.friction", "duration"]);
        assert_eq!(run.parameters[0].1.as_float(), Some(run.scenario.floor.friction.static_));
        assert_eq!(run.parameters[1].1.as_float(), Some(run.scenario.duration));
        assert!((1.0..=2.0).contains(&run.scenario.duration));
        assert!(run.scenario.sweep.is_single());
    }
    let force = "[[force]]\ntype = \"push\"\nlink = \"a\"\nforce = [1, 2, 3]\n";
    let swept = "[sweep]\nrandom = { samples = 3, \"force.0.force.1\" = { uniform = [10, 20] } }\n";
    for run in super::runs(&format!("{SMALLEST}{force}{swept}")) {
        let ForceSpec::Push(push) = &run.scenario.force[0] else { panic!("{:?}", run.scenario.force) };
        assert!(push.force[0] == 1.0 && (10.0..20.0).contains(&push.force[1]) && push.force[2] == 3.0, "{push:?}");
    }
}

#[test]
fn equal_seeds_draw_equal_values_in_every_version() {
    // Results are found by keys that depend on these numbers.
    let frozen: [(&str, [[f64; 4]; 3]); 3] = [
        (
            "random",
            [
                [0.820736384274824, 366.0, 0.0045164102849350645, -9.637147094956447],
                [0.910191809488473, 359.0, 0.03167198398739598, -9.931301907815012],
                [0.9503523943814255, 367.0, 0.0010646292056834049, -9.881946779628326],
            ],
        ),
        (
            "lhs",
            [
                [0.3167841314604752, 455.0, 0.02199882366770501, -9.951426453499494],
                [0.8140127615210279, 997.0, 0.01222246210692729, -9.789740215257565],
                [0.4627010690144971, 91.0, 8.351658917681336, -9.715012591892911],
            ],
        ),
        (
            "sobol",
            [
                [0.7654396593570709, 234.0, 8.045216293709505, -10.047300577331384],
                [0.21331754326820374, 964.0, 0.03439681385452865, -9.7225759461686],
                [0.5574378073215485, 575.0, 0.0025158373975025933, -9.797812065393114],
            ],
        ),
    ];
    for (sampling, samples) in frozen {
        let text = format!(
            "gravity = [0, 0, -9.81]\n{SMALLEST}[sweep.random]\nsamples = 3\nsampling = \"{sampling}\"\n\"floor.height\" = {{ uniform = [0, 1] }}\n\
             seed = {{ integer = [0, 999] }}\nduration = {{ log-uniform = [1e-3, 10] }}\n\"gravity.2\" = {{ normal = [-9.81, 0.1] }}\n"
        );
        for (run, [height, seed, duration, gravity]) in runs(&text).iter().zip(samples) {
            let s = &run.scenario;
            assert_eq!((s.floor.height, s.seed as f64), (height, seed), "{sampling}: exact on every machine");
            // These use the machine's exp and ln: a few units in the last place.
            assert!((s.duration / duration - 1.0).abs() < 1e-15, "{sampling} {}", s.duration);
            assert!((s.gravity[2] / gravity - 1.0).abs() < 1e-15, "{sampling} {}", s.gravity[2]);
        }
    }
}

#[test]
fn draws_depend_on_seed_and_path_only() {
    let of = |head: &str, random: &str| -> Vec<f64> {
        runs(&format!("{head}\n{SMALLEST}[sweep]\nrandom = {{ {random} }}\n"))
            .iter()
            .map(|r| r.scenario.floor.height)
            .collect()
    };
    for sampling in ["random", "lhs"] {
        let key = "\"floor.height\" = { uniform = [0, 1] }";
        let alone = of("", &format!("samples = 6, sampling = \"{sampling}\", {key}"));
        let with_others =
            of("", &format!("samples = 6, duration = {{ uniform = [1, 2] }}, {key}, sampling = \"{sampling}\""));
        assert_eq!(alone, with_others, "{sampling}");
        assert_eq!(
            alone,
            of("seed = 1", &format!("samples = 6, sampling = \"{sampling}\", {key}")),
            "1 is the default"
        );
        assert_ne!(alone, of("seed = 2", &format!("samples = 6, sampling = \"{sampling}\", {key}")));
    }
    // In a Sobol sequence the index of the key counts, so a later key changes nothing.
    let key = "samples = 6, sampling = \"sobol\", \"floor.height\" = { uniform = [0, 1] }";
    assert_eq!(of("", key), of("", &format!("{key}, duration = {{ uniform = [1, 2] }}")));
    assert_ne!(of("", key), of("seed = 2", key));
    // Fewer samples are the first of more, except in a Latin hypercube.
    let first = |n: usize, sampling: &str| {
        of("", &format!("samples = {n}, sampling = \"{sampling}\", \"floor.height\" = {{ uniform = [0, 1] }}"))
    };
    assert_eq!(first(9, "random")[..6], first(6, "random"));
    assert_eq!(first(9, "sobol")[..6], first(6, "sobol"));
    // An overridden seed draws new values; a repeated one does not.
    let file = file(&format!("{SMALLEST}[sweep]\nrepeat = 2\nrandom = {{ {key} }}\n")).unwrap();
    let values = |set: &str| -> Vec<_> {
        let runs = file.expand(&[parse_override(set).unwrap()]).unwrap();
        runs.iter().map(|r| (r.scenario.floor.height, r.scenario.seed)).collect()
    };
    let (one, two) = (values("seed=1"), values("seed=2"));
    assert!(one[0].0 == one[1].0 && one[0].1 + 1 == one[1].1, "{one:?}");
    assert_ne!(one[0].0, two[0].0);
}

#[test]
fn a_latin_hypercube_has_one_sample_in_each_part_of_equal_probability() {
    let parts = |values: Vec<f64>, probability: &dyn Fn(f64) -> f64| {
        let n = values.len();
        let mut parts: Vec<usize> = values.into_iter().map(|x| (probability(x) * n as f64).floor() as usize).collect();
        parts.sort_unstable();
        assert_eq!(parts, (0..n).collect::<Vec<_>>());
    };
    parts(heights("lhs", "uniform = [0, 1]"), &|x| x);
    parts(heights("lhs", "uniform = [-3, 5]"), &|x| (x + 3.0) / 8.0);
    parts(heights("lhs", "log-uniform = [1e-3, 10]"), &|x| (x / 1e-3).log10() / 4.0);
    parts(heights("sobol", "uniform = [0, 1]"), &|x| x);
    // Integers and strings: each equally often, if their number divides the samples.
    let counted = |random: &str| {
        let mut counts = std::collections::BTreeMap::new();
        // `duration` distinguishes runs that are otherwise equal.
        for run in sampled(&format!("{random}, duration = {{ uniform = [1, 2] }}")) {
            *counts.entry(run.parameters[0].1.to_string()).or_insert(0) += 1;
        }
        counts.into_iter().collect::<Vec<_>>()
    };
    let sixths = counted("samples = 60, sampling = \"lhs\", seed = { integer = [5, 10] }");
    assert_eq!(sixths, ["10", "5", "6", "7", "8", "9"].map(|w| (w.to_owned(), 10)));
    let counts =
        counted("samples = 64, sampling = \"sobol\", \"contact.method\" = { choice = [\"exact\", \"one-step\"] }");
    assert_eq!(counts, [("\"exact\"".to_owned(), 32), ("\"one-step\"".to_owned(), 32)]);
    let mixed = counted("samples = 4, sampling = \"lhs\", \"floor.height\" = { choice = [1, 0.5] }");
    assert_eq!(mixed, [("0.5".to_owned(), 2), ("1.0".to_owned(), 2)], "a column is of one kind of number");
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn moments(values: &[f64]) -> [f64; 4] {
    let m = mean(values);
    let central = |k: i32| mean(&values.iter().map(|x| (x - m).powi(k)).collect::<Vec<_>>());
    let deviation = central(2).sqrt();
    [m, deviation, central(3) / deviation.powi(3), central(4) / deviation.powi(4)]
}

#[test]
fn normal_samples_have_the_moments_of_the_normal_distribution() {
    let n = 4096f64;
    for sampling in ["random", "lhs", "sobol"] {
        let [m, deviation, skewness, kurtosis] = moments(&heights(sampling, "normal = [10, 2]"));
        // Five standard errors of independent samples: deviation / sqrt(n), deviation / sqrt(2 n),
        // sqrt(6 / n), sqrt(24 / n). Stratified samples stay far below.
        assert!((m - 10.0).abs() < 5.0 * 2.0 / n.sqrt(), "{sampling} {m}");
        assert!((deviation - 2.0).abs() < 5.0 * 2.0 / (2.0 * n).sqrt(), "{sampling} {deviation}");
        assert!(skewness.abs() < 5.0 * (6.0 / n).sqrt(), "{sampling} {skewness}");
        assert!((kurtosis - 3.0).abs() < 5.0 * (24.0 / n).sqrt(), "{sampling} {kurtosis}");
    }
    // Stratified, the mean's error falls with n^(-3/2) except for the tails: each part errs by at
    // most its width.
    let [m, ..] = moments(&heights("lhs", "normal = [10, 2]"));
    assert!((m - 10.0).abs() < 2e-3, "{m}");
}

#[test]
fn samples_stay_in_their_range_and_fill_it() {
    for sampling in ["random", "lhs", "sobol"] {
        let values = heights(sampling, "uniform = [-0.1, 0.3]");
        assert!(values.iter().all(|x| (-0.1..=0.3).contains(x)));
        // (b - a) / sqrt(12 n), five of them.
        assert!((mean(&values) - 0.1).abs() < 5.0 * 0.4 / (12.0 * 4096f64).sqrt());
        let values = heights(sampling, "log-uniform = [1e-6, 1e-2]");
        assert!(values.iter().all(|x| (1e-6..=1e-2).contains(x)));
        // A quarter of them in each decade; the standard error of a count is sqrt(3 n) / 4.
        for decade in -6..-2 {
            let inside = values.iter().filter(|x| x.log10().floor() as i32 == decade).count() as f64;
            assert!((inside - 1024.0).abs() < 5.0 * (3.0 * 4096f64).sqrt() / 4.0, "{sampling} {decade} {inside}");
        }
        let seeds = drawn(
            &format!(
                "samples = 2000, sampling = \"{sampling}\", seed = {{ integer = [-0, 3] }}, duration = {{ uniform = [1, 2] }}"
            ),
            "seed",
        );
        for whole in 0..4 {
            let count = seeds.iter().filter(|s| **s == f64::from(whole)).count() as f64;
            assert!((count - 500.0).abs() < 5.0 * (2000.0 * 3.0 / 16.0f64).sqrt(), "{sampling} {whole} {count}");
        }
    }
}

#[test]
fn samples_are_one_dimension_nested_in_the_order_of_the_file() {
    let random =
        "random = { samples = 2, duration = { uniform = [1, 2] }, \"floor.friction\" = { uniform = [0, 1] } }\n";
    let grid = "grid = { \"floor.height\" = [0, 10] }\n";
    let order = |text: String| -> Vec<_> {
        let runs = runs(&format!("{SMALLEST}[sweep]\n{text}"));
        runs.iter().map(|r| (r.scenario.duration, r.scenario.floor.height, r.scenario.floor.friction.static_)).collect()
    };
    let outer = order(format!("{random}{grid}"));
    assert_eq!(outer.iter().map(|r| r.1).collect::<Vec<_>>(), [0.0, 10.0, 0.0, 10.0]);
    assert!(outer[0].0 == outer[1].0 && outer[0].2 == outer[1].2 && outer[1].0 != outer[2].0, "{outer:?}");
    let inner = order(format!("{grid}{random}"));
    assert_eq!(inner.iter().map(|r| r.1).collect::<Vec<_>>(), [0.0, 0.0, 10.0, 10.0]);
    assert_eq!(
        (inner[0].0, inner[1].0),
        (outer[0].0, outer[2].0),
        "drawn values do not depend on the position in the file"
    );
}

#[test]
fn the_number_of_runs_is_limited_before_anything_is_drawn() {
    let text = format!("{SMALLEST}[sweep]\nrandom = {{ samples = 4294967295, duration = {{ uniform = [1, 2] }} }}\n");
    let found = file(&text).unwrap().expand(&[]).unwrap_err();
    assert!(found.to_string().contains("4294967295 runs, 10000 are allowed"), "{found}");
    assert_eq!(found.0[0].location(), "scenarios/test.toml:4:1");
    let limited = file(&text.replace("4294967295", "7")).unwrap();
    assert_eq!(limited.expand_at_most(&[], 7).unwrap().len(), 7);
    assert!(limited.expand_at_most(&[], 6).is_err());
}

#[test]
fn a_sobol_sequence_is_no_longer_than_its_table() {
    let text = |n: u32| {
        format!(
            "{SMALLEST}[sweep]\nrandom = {{ samples = {n}, sampling = \"sobol\", duration = {{ uniform = [1, 2] }} }}\n"
        )
    };
    let found = file(&text(65537)).unwrap().expand_at_most(&[], usize::MAX).unwrap_err();
    assert!(found.to_string().contains("a Sobol sequence has at most 65536 samples, not 65537"), "{found}");
    assert_eq!(found.0[0].location(), "scenarios/test.toml:4:22");
    let wide = |n: usize| {
        let joints: Vec<_> = (0..n).map(|i| format!("\"robot.posture.j{i}\" = {{ uniform = [0, 1] }}")).collect();
        format!("{SMALLEST}[sweep.random]\nsamples = 2\nsampling = \"sobol\"\n{}\n", joints.join("\n"))
    };
    assert_eq!(runs(&wide(256)).len(), 2);
    let found = file(&wide(257)).unwrap().expand(&[]).unwrap_err();
    assert!(found.to_string().contains("a Sobol sequence has at most 256 keys, not 257"), "{found}");
    assert_eq!(found.0[0].location(), "scenarios/test.toml:3:8");
}

#[test]
fn an_overridden_key_is_constant_while_the_others_are_drawn() {
    let text = format!(
        "{SMALLEST}[sweep]\nrandom = {{ samples = 3, duration = {{ uniform = [1, 2] }}, \"floor.height\" = {{ uniform = [0, 1] }} }}\n"
    );
    let file = file(&text).unwrap();
    let (free, fixed) = (file.expand(&[]).unwrap(), file.expand(&[parse_override("duration=7").unwrap()]).unwrap());
    for (free, fixed) in free.iter().zip(&fixed) {
        assert_eq!((fixed.scenario.duration, fixed.scenario.floor.height), (7.0, free.scenario.floor.height));
    }
    let both = ["duration=7", "floor.height=0"].map(|s| parse_override(s).unwrap());
    assert_eq!(file.expand(&both).unwrap().len(), 1, "nothing is left to draw");
}
