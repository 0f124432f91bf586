//! Points without repetition.

use nalgebra::Point3;
use std::collections::HashMap;

/// The distinct ones of `points`, in the order in which each first appears, and the index among them of
/// each point.
pub fn distinct_points(points: &[Point3<f64>]) -> (Vec<Point3<f64>>, Vec<u32>) {
    let mut index: HashMap<[u64; 3], u32> = HashMap::new();
    let mut distinct = Vec::new();
    let numbers = points.iter().map(|p| {
        // Adding 0 turns -0 into 0, the same position with other bits.
        let key = [p.x, p.y, p.z].map(|x| (x + 0.0).to_bits());
        *index.entry(key).or_insert_with(|| {
            distinct.push(*p);
            distinct.len() as u32 - 1
        })
    });
    let numbers = numbers.collect();
    (distinct, numbers)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_point_has_the_number_of_its_first_appearance() {
        let p = |x: f64, y: f64| Point3::new(x, y, 1.0);
        let points = [p(2.0, 0.0), p(1.0, 0.0), p(2.0, -0.0), p(2.0, 1e-300), p(1.0, 0.0), p(0.0, 2.0)];
        let (distinct, numbers) = distinct_points(&points);
        assert_eq!(numbers, [0, 1, 0, 2, 1, 3]);
        assert_eq!(distinct, [points[0], points[1], points[3], points[5]]);
    }
}
