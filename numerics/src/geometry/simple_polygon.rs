//! Checks that corners form a simple polygon: its border does not touch itself.

/// Greatest number of corners: each edge is compared with all others.
const MAX_CORNERS: usize = 1000;

/// The defect of a polygon, if it has one: the index of the corner concerned, if any, and a text
/// that follows the polygon's name.
pub fn defect(corners: &[[f64; 2]]) -> Option<(Option<usize>, String)> {
    let n = corners.len();
    if n < 3 {
        return Some((None, format!("must have at least 3 corners, not {n}")));
    }
    if n > MAX_CORNERS {
        return Some((None, format!("has {n} corners, at most {MAX_CORNERS} are allowed")));
    }
    for (i, corner) in corners.iter().enumerate() {
        if let Some(j) = corners[..i].iter().position(|other| other == corner) {
            return Some((Some(i), format!("is the same point as corner {j}")));
        }
    }
    let edge = |i: usize| (corners[i], corners[(i + 1) % n]);
    for i in 0..n {
        for j in i + 1..n {
            // Neighbouring edges share a corner; they must not overlap.
            let touch = match (j == i + 1, i == 0 && j == n - 1) {
                (true, _) => folds(corners[i], corners[j], corners[(j + 1) % n]),
                (_, true) => folds(corners[j], corners[0], corners[1]),
                _ => intersect(edge(i), edge(j)),
            };
            if touch {
                let message =
                    format!("crosses or touches itself: edge {i} (from corner {i} to {}) and edge {j}", i + 1);
                return Some((None, message));
            }
        }
    }
    None
}

/// Twice the area of a triangle, positive when it runs counter-clockwise.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// True when the path a, b, c reverses at b.
fn folds(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> bool {
    turn(a, b, c) == 0.0 && (b[0] - a[0]) * (c[0] - b[0]) + (b[1] - a[1]) * (c[1] - b[1]) < 0.0
}

/// True when two segments have a common point.
fn intersect((a, b): ([f64; 2], [f64; 2]), (c, d): ([f64; 2], [f64; 2])) -> bool {
    let sides = [turn(a, b, c), turn(a, b, d), turn(c, d, a), turn(c, d, b)];
    let between = |x: f64, y: f64| (x < 0.0 && y > 0.0) || (x > 0.0 && y < 0.0);
    let within =
        |p: [f64; 2], q: [f64; 2], r: [f64; 2]| (0..2).all(|k| p[k].min(q[k]) <= r[k] && r[k] <= p[k].max(q[k]));
    (between(sides[0], sides[1]) && between(sides[2], sides[3]))
        || (sides[0] == 0.0 && within(a, b, c))
        || (sides[1] == 0.0 && within(a, b, d))
        || (sides[2] == 0.0 && within(c, d, a))
        || (sides[3] == 0.0 && within(c, d, b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn simple_polygons_of_either_sense_convex_or_not() {
        let good: [&[[f64; 2]]; 3] = [
            &[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
            &[[0.0, 0.0], [0.0, 1.0], [0.5, 1.0], [0.5, 0.5], [1.0, 0.5], [1.0, 0.0]],
            // A corner on a straight side is allowed.
            &[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]],
        ];
        for corners in good {
            assert_eq!(defect(corners), None);
        }
    }

    #[test]
    fn polygons_that_touch_themselves_are_refused() {
        type Case = (&'static [[f64; 2]], Option<usize>, &'static str);
        let bad: [Case; 6] = [
            (&[[0.0, 0.0], [1.0, 0.0]], None, "at least 3 corners, not 2"),
            (&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 0.0]], Some(3), "same point as corner 0"),
            (&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]], None, "edge 0 (from corner 0 to 1) and edge 2"),
            (&[[0.0, 0.0], [2.0, 0.0], [1.0, 0.0]], None, "crosses or touches itself"),
            // A spike outwards, and a corner that touches a side.
            (&[[0.0, 0.0], [1.0, 0.0], [1.0, 2.0], [1.0, 1.0], [0.0, 1.0]], None, "crosses or touches itself"),
            (&[[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 0.0], [0.0, 1.0]], None, "crosses or touches itself"),
        ];
        for (corners, corner, expected) in bad {
            let (at, message) = defect(corners).expect(expected);
            assert!(at == corner && message.contains(expected), "{message}");
        }
    }
}
