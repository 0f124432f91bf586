//! A solution of the reduced contact problem: sole wrenches, sole motions, vertex forces.

use crate::contact::model::per_sole::PerSole;
use crate::contact::model::problem::Problem;
use nalgebra::{Vector2, Vector3};

/// Wrenches, motions and vertex forces of a problem. The problem fixes the length of each list.
#[derive(Clone, Debug)]
pub struct Solution {
    /// Sole wrenches w, 6F, floor axes at the reference points.
    pub wrench: Vec<f64>,
    /// Sole motions m = b + W w, 6F.
    pub motion: Vec<f64>,
    /// Normal force of each vertex, by sole (N or N s).
    pub normal: Vec<Vec<f64>>,
    /// Tangential force of each vertex, by sole, x and y in floor axes. Within a static pattern
    /// only the resultant is physical; the split, proportional to the normal forces, is a
    /// convention.
    pub tangent: Vec<Vec<Vector2<f64>>>,
    /// Did the pressure rule of every face find a centre of pressure inside its polygon?
    pub inside: PerSole<bool>,
}

impl Solution {
    /// A zero solution of the right size.
    pub fn new(p: &Problem) -> Self {
        Solution {
            wrench: vec![0.0; p.dim()],
            motion: vec![0.0; p.dim()],
            normal: p.soles.iter().map(|s| vec![0.0; s.vertices.len()]).collect(),
            tangent: p.soles.iter().map(|s| vec![Vector2::zeros(); s.vertices.len()]).collect(),
            inside: PerSole::filled(true),
        }
    }

    /// Copies another solution. Allocates only if that is larger.
    pub fn copy_from(&mut self, other: &Solution) {
        self.wrench.clone_from(&other.wrench);
        self.motion.clone_from(&other.motion);
        self.normal.clone_from(&other.normal);
        self.tangent.clone_from(&other.tangent);
        self.inside.clone_from(&other.inside);
    }

    /// Sets the force on vertex `i` of sole `s`, floor axes, N or N s.
    pub fn set_vertex_force(&mut self, s: usize, i: usize, force: Vector3<f64>) {
        self.normal[s][i] = force.z;
        self.tangent[s][i] = force.xy();
    }

    /// Computes wrenches and motions from the forces on the vertices.
    pub fn gather_vertex_forces(&mut self, p: &Problem) {
        for (s, sole) in p.soles.iter().enumerate() {
            let wrench = &mut self.wrench[6 * s..6 * s + 6];
            wrench.fill(0.0);
            for ((v, n), t) in sole.vertices.iter().zip(&self.normal[s]).zip(&self.tangent[s]) {
                let one = wrench_at(&v.r, &Vector3::new(t.x, t.y, *n));
                wrench.iter_mut().zip(one).for_each(|(a, b)| *a += b);
            }
        }
        let n = p.dim();
        for (i, m) in self.motion.iter_mut().enumerate() {
            *m = p.b[i] + p.w[i * n..(i + 1) * n].iter().zip(&self.wrench).map(|(w, f)| w * f).sum::<f64>();
        }
    }

    /// Scales wrenches and forces, to convert impulses over a step to forces.
    pub fn scale(&mut self, factor: f64) {
        self.wrench.iter_mut().for_each(|w| *w *= factor);
        self.normal.iter_mut().flatten().for_each(|n| *n *= factor);
        self.tangent.iter_mut().flatten().for_each(|t| *t *= factor);
    }
}

/// Wrench at the reference point of a force at `r`.
pub(crate) fn wrench_at(r: &Vector3<f64>, f: &Vector3<f64>) -> [f64; 6] {
    let m = r.cross(f);
    [f.x, f.y, f.z, m.x, m.y, m.z]
}
