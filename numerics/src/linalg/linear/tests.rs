//! Tests of dense solves: ranks, least norms, redundant rows.

use super::*;

#[test]
fn solves_a_regular_system_and_finds_its_rank() {
    let mut lin = Linear::new(3);
    let mut a = [4.0, -2.0, 1.0, 3.0, 6.0, -4.0, 2.0, 1.0, 8.0];
    let mut b = [12.0, -25.0, 32.0];
    assert_eq!(lin.solve(&mut a, &mut b), 3);
    // Exact solution by hand: x = (1, -2, 4); rounding of a 3 x 3 elimination.
    for (x, y) in b.iter().zip([1.0, -2.0, 4.0]) {
        assert!((x - y).abs() < 1e-14);
    }
}

#[test]
fn redundant_unknowns_get_the_least_norm() {
    // x + y + z = 6 three times over, and x - y = 1 hidden in the second row: least norm x =
    // 2.5, y = 1.5, z = 2.
    let mut a = [1.0, 1.0, 1.0, 2.0, 0.0, 1.0, 2.0, 2.0, 2.0];
    let mut b = [6.0, 7.0, 12.0];
    assert_eq!(Linear::new(3).solve(&mut a, &mut b), 2);
    for (x, y) in b.iter().zip([2.5, 1.5, 2.0]) {
        assert!((x - y).abs() < 1e-14, "{b:?}");
    }
}

#[test]
fn factors_serve_several_right_hand_sides() {
    let original = [0.0, 2.0, 1.0, 1.0, 1.0, -3.0, 4.0, -1.0, 2.0];
    let (mut lin, mut a) = (Linear::new(3), original);
    lin.factor(&mut a, 3);
    for rhs in [[1.0, 0.0, 0.0], [0.3, -2.0, 5.0]] {
        let mut x = rhs;
        lin.apply(&a, &mut x);
        for i in 0..3 {
            let image: f64 = (0..3).map(|j| original[3 * i + j] * x[j]).sum();
            assert!((image - rhs[i]).abs() < 1e-14);
        }
    }
}

#[test]
fn a_definite_matrix_is_solved_as_any_other() {
    let original = [4.0, -1.0, 0.5, -1.0, 3.0, 1.0, 0.5, 1.0, 2.0];
    let rhs = [1.0, -2.0, 0.7];
    let (mut lin, mut a, mut b) = (Linear::new(3), original, rhs);
    assert_eq!((lin.solve_symmetric(&mut a, &mut b), lin.factors), (3, Factors::Definite));
    let mut x = rhs;
    Linear::new(3).solve(&mut original.clone(), &mut x);
    assert!(b.iter().zip(x).all(|(b, x)| (b - x).abs() < 1e-14), "{b:?} {x:?}");
}

#[test]
fn a_regular_matrix_is_solved_as_any_other() {
    let original = [0.0, 2.0, 1.0, 1.0, 1.0, -3.0, 4.0, -1.0, 2.0];
    let rhs = [0.3, -2.0, 5.0];
    let (mut lin, mut b, mut x) = (Linear::new(3), rhs, rhs);
    assert_eq!((lin.solve_regular(&mut original.clone(), &mut b), lin.factors), (3, Factors::Regular));
    Linear::new(3).solve(&mut original.clone(), &mut x);
    assert!(b.iter().zip(x).all(|(b, x)| (b - x).abs() < 1e-14), "{b:?} {x:?}");
    // Rank 2, as in `redundant_unknowns_get_the_least_norm`.
    let mut b = [6.0, 7.0, 12.0];
    assert_eq!(lin.solve_regular(&mut [1.0, 1.0, 1.0, 2.0, 0.0, 1.0, 2.0, 2.0, 2.0], &mut b), 2);
    assert!(b.iter().zip([2.5, 1.5, 2.0]).all(|(b, x)| (b - x).abs() < 1e-14), "{b:?}");
}

#[test]
fn a_singular_symmetric_matrix_gives_the_least_norm() {
    // x + y = 2 twice, z = 1; the indefinite one has the solution (2, 1).
    let mut b = [2.0, 2.0, 1.0];
    let mut lin = Linear::new(3);
    assert_eq!(lin.solve_symmetric(&mut [1.0, 1.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0], &mut b), 2);
    assert!(lin.factors == Factors::Complete && b.iter().all(|x| (x - 1.0).abs() < 1e-15), "{b:?}");
    let mut b = [1.0, 2.0];
    lin.solve_symmetric(&mut [0.0, 1.0, 1.0, 0.0], &mut b);
    assert_eq!(b, [2.0, 1.0]);
}

#[test]
fn redundant_rows_keep_the_image() {
    // The third row is the sum of the first two, and so is the right-hand side.
    let original = [2.0, 1.0, 3.0, 1.0, 3.0, 4.0, 3.0, 4.0, 7.0];
    let rhs = [1.0, 2.0, 3.0];
    let (mut a, mut b) = (original, rhs);
    assert_eq!(Linear::new(3).solve(&mut a, &mut b), 2);
    for i in 0..3 {
        let image: f64 = (0..3).map(|j| original[3 * i + j] * b[j]).sum();
        assert!((image - rhs[i]).abs() < 1e-14);
    }
}

/// Rows that differ in the 10th digit: exact elimination tells them apart by unknowns of 1e5.
#[test]
fn drops_nearly_redundant_rows_where_asked() {
    let matrix = [1.0, 1.0, 1.0, 1.0 + 1e-10];
    let right = [1.0, 1.0 + 1e-5];
    let mut lin = Linear::new(2);
    let (mut a, mut x) = (matrix, right);
    lin.solve(&mut a, &mut x);
    assert!((x[1] - 1e5).abs() < 1.0 && lin.rank() == 2 && lin.has_nearly_redundant(), "{x:?}");
    lin.drop_nearly_redundant(true);
    let (mut a, mut x) = (matrix, right);
    lin.solve_symmetric(&mut a, &mut x);
    assert!(lin.rank() == 1 && x.iter().all(|x| (x - 0.5).abs() < 1e-5), "{x:?}");
    lin.drop_nearly_redundant(false);
    let (mut a, mut x) = ([1.0, 1.0, 1.0, 2.0], [1.0, 3.0]);
    lin.solve(&mut a, &mut x);
    assert!(x == [-1.0, 2.0] && !lin.has_nearly_redundant(), "{x:?}");
}

/// A null vector whose last entries are small leaves every pivot above 1e-8: a program that looked at the pivots
/// alone found a regular matrix, and loads of any size along the null vector.
#[test]
fn a_singular_matrix_with_positive_pivots_gets_the_least_norm() {
    const N: usize = 12;
    let mut v = [-0.48, 0.5, 3e-6, 0.13, -0.012, -3e-6, 0.48, -0.5, -3e-6, -0.13, 0.0117, 3e-6];
    let norm = super::dot(&v, &v).sqrt();
    v.iter_mut().for_each(|x| *x /= norm);
    // 1 - part v v^T; singular with all of it. A solution perpendicular to v.
    let matrix = |part: f64| -> Vec<f64> {
        (0..N * N).map(|e| f64::from(u8::from(e / N == e % N)) - part * v[e / N] * v[e % N]).collect()
    };
    let original = matrix(1.0);
    let along = v.iter().enumerate().map(|(i, v)| v * i as f64).sum::<f64>();
    let truth: Vec<f64> = v.iter().enumerate().map(|(i, v)| i as f64 - along * v).collect();
    let (mut lin, mut a, mut b) = (Linear::new(N), original.clone(), truth.clone());
    assert!(!lin.factor_definite(&original, N));
    assert_eq!(lin.solve_symmetric(&mut a, &mut b), N - 1);
    // Rounding, of a regular part whose eigenvalues are 1.
    assert!(b.iter().zip(&truth).all(|(x, y)| (x - y).abs() < 1e-13), "{b:?}");
    assert!(lin.factor_definite(&matrix(0.9), N));
}
