//! The probability of a wrong verdict, computed exactly: by enumeration for a fixed number of runs,
//! by dynamic programming over all sequences of results where each run may end the batch.

use stiction::statistics::{Rule, ShareTest, probability};

const ALPHA: f64 = 0.05;

/// True if `k` of `n` successes show something about a probability.
type Shows<'a> = &'a dyn Fn(usize, usize) -> bool;

/// Probability that `shows` after some of `runs` runs, judged after each of them.
fn ever(runs: usize, p: f64, shows: Shows) -> f64 {
    // Probability of each number of successes in sequences that have shown nothing yet.
    let mut open = vec![1.0];
    let mut shown = 0.0;
    for n in 1..=runs {
        let mut next = vec![0.0; n + 1];
        for (k, share) in open.iter().enumerate() {
            next[k] += share * (1.0 - p);
            next[k + 1] += share * p;
        }
        for (k, share) in next.iter_mut().enumerate().filter(|(k, _)| shows(n, *k)) {
            shown += std::mem::take(share);
            let _ = k;
        }
        open = next;
    }
    shown
}

/// Probability that `shows` after exactly `runs` runs.
fn at_end(runs: usize, p: f64, shows: Shows) -> f64 {
    (0..=runs).filter(|k| shows(runs, *k)).map(|k| probability(runs, k, p)).sum()
}

#[test]
fn a_fixed_number_of_runs_is_judged_wrongly_at_most_as_often_as_stated() {
    let test = ShareTest { rule: Rule::Fixed, alpha: ALPHA };
    let mut greatest: f64 = 0.0;
    for threshold in [0.05, 0.5, 0.9, 0.99] {
        for runs in [1, 2, 3, 10, 30, 59, 100, 299, 300] {
            for part in [0.0, 0.2, 0.5, 0.9, 0.99, 1.0] {
                // A probability up to the threshold, and one from it on.
                let (below, above) = (threshold * part, 1.0 - (1.0 - threshold) * part);
                let holds = at_end(runs, below, &|n, k| test.shows_at_least(n, k, threshold));
                let fails = at_end(runs, above, &|n, k| test.shows_at_most(n, k, threshold));
                // Rounding of the sum.
                assert!(holds <= ALPHA * (1.0 + 1e-12), "{threshold} {runs} {below}: {holds}");
                assert!(fails <= ALPHA * (1.0 + 1e-12), "{threshold} {runs} {above}: {fails}");
                greatest = greatest.max(holds).max(fails);
            }
        }
    }
    // The bounds are not far too wide either: some case comes close to what is allowed.
    assert!(greatest > 0.9 * ALPHA, "{greatest}");
}

#[test]
fn a_batch_that_its_results_end_is_judged_wrongly_at_most_as_often_as_stated() {
    let test = ShareTest { rule: Rule::Sequential, alpha: ALPHA };
    const RUNS: usize = 300;
    for threshold in [0.5, 0.9, 0.98] {
        // The least number of successes of n runs that shows the share, and the most that refutes it.
        let counts: Vec<usize> = (0..=RUNS + 1).collect();
        let least: Vec<usize> =
            (0..=RUNS).map(|n| counts[..=n].partition_point(|k| !test.shows_at_least(n, *k, threshold))).collect();
        let most: Vec<usize> =
            (0..=RUNS).map(|n| counts[..=n].partition_point(|k| test.shows_at_most(n, *k, threshold))).collect();
        for part in [0.5, 0.9, 1.0] {
            let (below, above) = (threshold * part, 1.0 - (1.0 - threshold) * part);
            let holds = ever(RUNS, below, &|n, k| k >= least[n]);
            let fails = ever(RUNS, above, &|n, k| k < most[n]);
            assert!(holds <= ALPHA, "{threshold} {below}: {holds}");
            assert!(fails <= ALPHA, "{threshold} {above}: {fails}");
        }
        // It decides: a share well above the threshold is shown in most batches.
        let clear = 1.0 - (1.0 - threshold) * 0.1;
        let holds = ever(RUNS, clear, &|n, k| k >= least[n]);
        assert!(holds > 0.8 || threshold == 0.98, "{threshold} {clear}: {holds}");
    }
}

#[test]
fn judging_a_fixed_test_after_every_run_would_break_the_guarantee() {
    // What the wider bounds of `early` are for, and proof that the enumeration above can fail.
    let test = ShareTest { rule: Rule::Fixed, alpha: ALPHA };
    let wrong = ever(200, 0.9, &|n, k| test.shows_at_least(n, k, 0.9) || test.shows_at_most(n, k, 0.9));
    assert!(wrong > 3.0 * ALPHA, "{wrong}");
}

#[test]
fn a_test_needs_no_fewer_successes_with_more_runs() {
    // Verdicts by counts are monotone, as order statistics and the search for bounds require.
    for rule in [Rule::Fixed, Rule::Sequential] {
        let test = ShareTest { rule, alpha: ALPHA };
        for threshold in [0.1, 0.5, 0.9] {
            for n in [1, 5, 40, 120] {
                let above: Vec<bool> = (0..=n).map(|k| test.shows_at_least(n, k, threshold)).collect();
                let below: Vec<bool> = (0..=n).map(|k| test.shows_at_most(n, k, threshold)).collect();
                assert!(above.is_sorted(), "{rule:?} {threshold} {n}: {above:?}");
                assert!(below.iter().rev().is_sorted(), "{rule:?} {threshold} {n}: {below:?}");
                assert!(!above.iter().zip(&below).any(|(a, b)| *a && *b), "{rule:?} {threshold} {n}");
            }
        }
    }
}
