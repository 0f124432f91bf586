//! The point of a simplex nearest to the origin, and the smallest face that contains it.
//!
//! ```text
//! v = argmin |x|,  x = sum l_i w_i,  l_i >= 0,  sum l_i = 1;   the w_i with l_i > 0 remain
//! ```
//!
//! The nearest feature of a triangle follows from the signs of its areas, that of a tetrahedron
//! from those of its volumes [Montanari 2017]; the formulas for a triangle are those of [Ericson
//! 2005, section 5.1.5]. If rounding hides an area or a volume, the features of one dimension less
//! are compared by their distances.

use nalgebra::Vector3;

/// A triangle counts as a line if its area, and a tetrahedron as a triangle if its volume, is below
/// this fraction of the product of its edges, where rounding decides the signs.
const FLAT: f64 = 1e-13;

/// At most four points of the difference `A - B` of two bodies, with the vertices they come from.
#[derive(Clone, Copy, Debug)]
pub struct Simplex {
    /// Points in use.
    pub len: usize,
    /// Differences of vertices, m.
    pub w: [Vector3<f64>; 4],
    /// Vertices of A.
    pub a: [u16; 4],
    /// Vertices of B.
    pub b: [u16; 4],
    /// Weights of the nearest point, once [`Self::reduce`] has run.
    pub l: [f64; 4],
}

/// A face of a simplex by the indices of its points, and the weights of the nearest point.
#[derive(Clone, Copy)]
struct Face {
    len: usize,
    at: [usize; 4],
    l: [f64; 4],
}

impl Simplex {
    /// No points.
    pub const EMPTY: Self = Simplex { len: 0, w: [Vector3::new(0.0, 0.0, 0.0); 4], a: [0; 4], b: [0; 4], l: [0.0; 4] };

    /// Adds a point; there is room for four.
    pub fn push(&mut self, w: Vector3<f64>, a: u16, b: u16) {
        let i = self.len;
        (self.w[i], self.a[i], self.b[i]) = (w, a, b);
        self.len = i + 1;
    }

    /// Whether this difference of vertices is one of the points.
    pub fn contains(&self, a: u16, b: u16) -> bool {
        (0..self.len).any(|i| self.a[i] == a && self.b[i] == b)
    }

    /// Reduces the simplex to the smallest face that contains the point nearest to the origin and
    /// returns that point. Four points remain only when the origin is inside.
    pub fn reduce(&mut self) -> Vector3<f64> {
        let face = match self.len {
            1 => Face { len: 1, at: [0; 4], l: [1.0, 0.0, 0.0, 0.0] },
            2 => self.segment(0, 1),
            3 => self.triangle(0, 1, 2),
            _ => self.tetrahedron(),
        };
        let old = *self;
        self.len = face.len;
        self.l = face.l;
        let mut v = Vector3::zeros();
        for (i, &at) in face.at[..face.len].iter().enumerate() {
            (self.w[i], self.a[i], self.b[i]) = (old.w[at], old.a[at], old.b[at]);
            v += old.w[at] * face.l[i];
        }
        v
    }

    fn vertex(i: usize) -> Face {
        Face { len: 1, at: [i, 0, 0, 0], l: [1.0, 0.0, 0.0, 0.0] }
    }

    fn edge(i: usize, k: usize, t: f64) -> Face {
        Face { len: 2, at: [i, k, 0, 0], l: [1.0 - t, t, 0.0, 0.0] }
    }

    fn segment(&self, i: usize, k: usize) -> Face {
        let (p, q) = (&self.w[i], &self.w[k]);
        let along = q - p;
        let (t, whole) = (-p.dot(&along), along.norm_squared());
        if t <= 0.0 {
            Self::vertex(i)
        } else if t >= whole {
            Self::vertex(k)
        } else {
            Self::edge(i, k, t / whole)
        }
    }

    fn triangle(&self, i: usize, j: usize, k: usize) -> Face {
        let (p, q, r) = (&self.w[i], &self.w[j], &self.w[k]);
        let (ab, ac) = (q - p, r - p);
        let (d1, d2) = (-ab.dot(p), -ac.dot(p));
        if d1 <= 0.0 && d2 <= 0.0 {
            return Self::vertex(i);
        }
        let (d3, d4) = (-ab.dot(q), -ac.dot(q));
        if d3 >= 0.0 && d4 <= d3 {
            return Self::vertex(j);
        }
        let (d5, d6) = (-ab.dot(r), -ac.dot(r));
        if d6 >= 0.0 && d5 <= d6 {
            return Self::vertex(k);
        }
        let (va, vb, vc) = (d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2);
        let whole = va + vb + vc;
        // The sum of the three is four times the square of the area.
        if whole <= FLAT * ab.norm_squared() * ac.norm_squared() {
            return self.nearest([self.segment(i, j), self.segment(i, k), self.segment(j, k)]);
        }
        if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
            return Self::edge(i, j, d1 / (d1 - d3));
        }
        if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
            return Self::edge(i, k, d2 / (d2 - d6));
        }
        if va <= 0.0 && d4 >= d3 && d5 >= d6 {
            return Self::edge(j, k, (d4 - d3) / ((d4 - d3) + (d5 - d6)));
        }
        let (l, m) = (vb / whole, vc / whole);
        Face { len: 3, at: [i, j, k, 0], l: [1.0 - l - m, l, m, 0.0] }
    }

    fn tetrahedron(&self) -> Face {
        let [p, q, r, s] = &self.w;
        let (e, f, g) = (q - p, r - p, s - p);
        let volume = e.dot(&f.cross(&g));
        let flat = volume.abs() <= FLAT * e.norm() * f.norm() * g.norm();
        // Weight of each corner times the volume: the volume of the tetrahedron with the origin in
        // place of that corner.
        let (m1, m2, m3) = (-p.dot(&f.cross(&g)), -p.dot(&g.cross(&e)), -p.dot(&e.cross(&f)));
        let parts = [volume - m1 - m2 - m3, m1, m2, m3];
        let outside = parts.map(|part| flat || part * volume < 0.0);
        const OPPOSITE: [[usize; 3]; 4] = [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]];
        let mut best: Option<(f64, Face)> = None;
        for (_, [i, j, k]) in outside.iter().zip(OPPOSITE).filter(|(outside, _)| **outside) {
            let face = self.triangle(i, j, k);
            let distance = self.squared(&face);
            if best.as_ref().is_none_or(|(least, _)| distance < *least) {
                best = Some((distance, face));
            }
        }
        best.map_or(Face { len: 4, at: [0, 1, 2, 3], l: parts.map(|part| part / volume) }, |(_, face)| face)
    }

    fn nearest(&self, faces: [Face; 3]) -> Face {
        let [a, b, c] = faces.map(|f| (self.squared(&f), f));
        let first = if b.0 < a.0 { b } else { a };
        if c.0 < first.0 { c.1 } else { first.1 }
    }

    fn squared(&self, face: &Face) -> f64 {
        let sum = |v, (i, l): (&usize, &f64)| v + self.w[*i] * *l;
        face.at[..face.len].iter().zip(&face.l).fold(Vector3::zeros(), sum).norm_squared()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Stream;

    fn simplex(points: &[Vector3<f64>]) -> Simplex {
        let mut s = Simplex::EMPTY;
        points.iter().enumerate().for_each(|(i, p)| s.push(*p, i as u16, 0));
        s
    }

    /// The remaining face contains the point, and no corner of the simplex is on the origin's side
    /// of the plane through the point normal to the line to the origin: together they prove that it
    /// is the nearest.
    #[test]
    fn the_nearest_point_satisfies_its_optimality_condition() {
        let mut r = Stream::new(1, &["simplex"]);
        let mut inside = 0;
        for case in 0..40_000 {
            let len = 1 + case % 4;
            let points: Vec<_> = (0..len).map(|_| Vector3::from_fn(|_, _| r.normal()) + Vector3::repeat(0.5)).collect();
            let mut s = simplex(&points);
            let v = s.reduce();
            let sum: f64 = s.l[..s.len].iter().sum();
            assert!(s.l[..s.len].iter().all(|l| *l > 0.0) && (sum - 1.0).abs() < 1e-12, "{:?}", s.l);
            inside += usize::from(s.len == 4);
            // Rounding of products of a handful of numbers of about 1, amplified by slivers among
            // 40 000.
            assert!(points.iter().all(|p| v.dot(p) >= v.norm_squared() - 1e-10), "{points:?}");
        }
        // One in eight random tetrahedra around the origin contains it; these are moved away.
        assert!((50..2_000).contains(&inside), "{inside}");
    }

    #[test]
    fn flat_simplices_have_a_nearest_point_too() {
        let p = |x: f64, y: f64, z: f64| Vector3::new(x, y, z);
        // Three points on a line, four on a plane: the result is known by symmetry.
        let mut line = simplex(&[p(-1.0, 1.0, 0.0), p(0.5, 1.0, 0.0), p(3.0, 1.0, 0.0)]);
        assert!((line.reduce() - p(0.0, 1.0, 0.0)).norm() < 1e-15 && line.len == 2);
        let square = [p(-1.0, -1.0, 2.0), p(1.0, -1.0, 2.0), p(1.0, 1.0, 2.0), p(-1.0, 1.0, 2.0)];
        let mut plane = simplex(&square);
        assert!((plane.reduce() - p(0.0, 0.0, 2.0)).norm() < 1e-15 && plane.len < 4);
        let mut point = simplex(&[p(1.0, 2.0, 2.0); 4]);
        assert!((point.reduce().norm() - 3.0).abs() < 1e-15 && point.len == 1);
    }
}
