//! Event location: finds the first sign change of event functions inside a step.
//!
//! Several event functions g_i(theta), theta in [0, 1], are positive before their events. Given a
//! bracket with all of them positive on the left and some negative on the right, regula falsi with
//! Illinois weights per function, safeguarded by bisection, converges to the first sign change.

/// Finds the first theta in (`a`, `b`] where any of the functions is negative, in a bracket of
/// `width`. `evaluate(theta, g)` computes the values. `left` and `right` contain the values at the
/// ends and are overwritten; on return `right` contains those at the returned theta, where at least
/// one is negative.
pub fn first_crossing(
    mut a: f64,
    mut b: f64,
    left: &mut [f64],
    right: &mut [f64],
    scratch: &mut [f64],
    width: f64,
    mut evaluate: impl FnMut(f64, &mut [f64]),
) -> f64 {
    let mut last_side = 0i8;
    for round in 0..200 {
        if b - a <= width {
            break;
        }
        // The earliest secant estimate; every third round bisects, which guarantees convergence.
        let mut theta = b;
        if round % 3 == 2 {
            theta = 0.5 * (a + b);
        } else {
            for (l, r) in left.iter().zip(right.iter()) {
                if *r < 0.0 && *l > 0.0 {
                    theta = theta.min(a + (b - a) * l / (l - r));
                }
            }
            // The guard closes the bracket from the other side after convergence.
            let guard = 0.5 * width;
            theta = theta.clamp(a + guard, b - guard);
        }
        evaluate(theta, scratch);
        if scratch.iter().any(|g| *g < 0.0) {
            b = theta;
            right.copy_from_slice(scratch);
            if last_side == 1 {
                left.iter_mut().for_each(|g| *g *= 0.5);
            }
            last_side = 1;
        } else {
            a = theta;
            left.copy_from_slice(scratch);
            if last_side == -1 {
                right.iter_mut().for_each(|g| *g *= 0.5);
            }
            last_side = -1;
        }
    }
    b
}

#[cfg(test)]
mod tests {
    use super::*;

    fn locate(functions: &[&dyn Fn(f64) -> f64]) -> (f64, usize) {
        let n = functions.len();
        let at = |x: f64| functions.iter().map(|f| f(x)).collect::<Vec<_>>();
        let (mut l, mut r, mut s) = (at(0.0), at(1.0), vec![0.0; n]);
        let mut count = 0;
        let x = first_crossing(0.0, 1.0, &mut l, &mut r, &mut s, 1e-13, |x, g| {
            count += 1;
            g.copy_from_slice(&at(x));
        });
        (x, count)
    }

    #[test]
    fn the_first_of_several_events_is_found() {
        let (x, count) = locate(&[&|x| 0.7 - x, &|x| 0.3 - x * x * x, &|x| (0.9 - x).powi(3)]);
        // Width of the final bracket.
        assert!((x - 0.3f64.cbrt()).abs() < 2e-13, "{x}");
        assert!(count < 40, "{count}");
    }

    #[test]
    fn events_of_hard_shapes_are_located() {
        let (x, _) = locate(&[&|x| if x < 0.123 { 1.0 } else { -1e-9 }]);
        assert!((x - 0.123).abs() < 2e-13);
        let (x, _) = locate(&[&|x| (0.5f64 - x).cbrt()]);
        assert!((x - 0.5).abs() < 2e-13);
    }
}
