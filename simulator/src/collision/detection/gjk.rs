//! GJK distance between two convex polyhedra, with proven bounds.
//!
//! ```text
//! d(A, B) = min |x|, x in A - B = { a - b };    v_k = the point nearest to 0 of the convex hull of W_k
//! w_k = s_A(-v_k) - s_B(v_k);                   v_k . w_k / |v_k|  <=  d(A, B)  <=  |v_k|
//! ```
//!
//! W_k contains at most four differences of vertices: those that v_(k-1) needs, and w_(k-1). Every
//! step proves both bounds, so the iteration stops when they meet, when the lower one exceeds the
//! caller's limit, or when the hull of W contains the origin. Coherence: the first W contains the
//! vertices of the last result for this pair, at their present positions.
//!
//! Sources: [Gilbert 1988]; bounds and termination by [van den Bergen 1999].

use nalgebra::Vector3;

use super::simplex::Simplex;
use super::support_mapping::SupportMapping;

/// Gap between the bounds at convergence, m. Coordinates of about 1 m carry rounding errors of
/// 1e-16 m.
const MEET: f64 = 1e-12;
/// Bodies closer than this touch, m: rounding hides the direction between them.
const TOUCH: f64 = 1e-12;
/// Polyhedra converge in finitely many steps; only a loop of rounding errors reaches this many.
const MOST_STEPS: usize = 100;

/// The vertices of the last result for a pair: the start of the next query.
#[derive(Clone, Copy, Debug)]
pub struct Warm {
    len: u8,
    a: [u16; 4],
    b: [u16; 4],
}

impl Warm {
    /// No result yet.
    pub const COLD: Self = Warm { len: 0, a: [0; 4], b: [0; 4] };

    fn simplex(&self, a: &impl SupportMapping, b: &impl SupportMapping) -> Simplex {
        let mut s = Simplex::EMPTY;
        for i in 0..(self.len as usize).max(1) {
            let (ia, ib) = (self.a[i], self.b[i]);
            s.push(a.vertex(ia) - b.vertex(ib), ia, ib);
        }
        s
    }

    fn store(&mut self, s: &Simplex) {
        *self = Warm { len: s.len as u8, a: s.a, b: s.b };
    }
}

/// Result for a pair.
#[derive(Clone, Copy, Debug)]
pub enum Outcome {
    /// Apart.
    Apart {
        /// From B's nearest point to A's, m.
        v: Vector3<f64>,
        /// The vertices of the nearest points, with their weights.
        simplex: Simplex,
    },
    /// Farther apart than the caller's limit.
    Beyond,
    /// They share at least a point, within [`TOUCH`].
    Overlap {
        /// A simplex that contains the origin.
        simplex: Simplex,
    },
}

/// The nearest points of two bodies that are apart.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Nearest {
    /// Distance, m.
    pub distance: f64,
    /// Unit vector from A to B.
    pub normal: Vector3<f64>,
    /// A's point, m.
    pub on_a: Vector3<f64>,
    /// B's point, m.
    pub on_b: Vector3<f64>,
}

/// Nearest points from `v` and the weights of [`Outcome::Apart`].
pub fn nearest(a: &impl SupportMapping, b: &impl SupportMapping, v: &Vector3<f64>, simplex: &Simplex) -> Nearest {
    let weights = simplex.l.iter().take(simplex.len);
    let on_a = simplex.a.iter().zip(weights.clone()).map(|(k, l)| a.vertex(*k) * *l).sum();
    let on_b = simplex.b.iter().zip(weights).map(|(k, l)| b.vertex(*k) * *l).sum();
    let distance = v.norm();
    Nearest { distance, normal: -v / distance, on_a, on_b }
}

/// The distance of A and B, or [`Outcome::Beyond`] as soon as it is proven to exceed `beyond`, m
/// (infinity: never).
pub fn distance(a: &impl SupportMapping, b: &impl SupportMapping, warm: &mut Warm, beyond: f64) -> Outcome {
    let mut s = warm.simplex(a, b);
    let mut v = s.reduce();
    let (mut ia, mut ib) = (s.a[s.len - 1], s.b[s.len - 1]);
    for _ in 0..MOST_STEPS {
        let square = v.norm_squared();
        if s.len == 4 || square <= TOUCH * TOUCH {
            warm.store(&s);
            return Outcome::Overlap { simplex: s };
        }
        ia = a.outermost(&-v, ia);
        ib = b.outermost(&v, ib);
        let w = a.vertex(ia) - b.vertex(ib);
        let reach = v.dot(&w);
        let length = square.sqrt();
        if reach > beyond * length {
            warm.store(&s);
            return Outcome::Beyond;
        }
        if square - reach <= MEET * length || s.contains(ia, ib) {
            break;
        }
        let old = s;
        s.push(w, ia, ib);
        let next = s.reduce();
        // Without progress the rest is rounding: the last result with its proven bounds is the
        // best.
        if next.norm_squared() >= square {
            s = old;
            break;
        }
        v = next;
    }
    warm.store(&s);
    Outcome::Apart { v, simplex: s }
}
