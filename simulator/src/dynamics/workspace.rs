//! Scratch and results of one run, allocated once.

use super::constraints::Constraints;
use super::spatial::{Force, Inertia, Motion};
use super::tree_matrix::{Pattern, TreeMatrix};
use crate::robot::{Base, LinkId, Model};
use nalgebra::{Matrix3, Vector3};

/// Pose, inertia and motion of one link; world axes, spatial quantities about O.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct LinkMotion {
    /// Rotation, world from the link's internal frame.
    pub rotation: Matrix3<f64>,
    /// Origin of the internal frame relative to O, m.
    pub origin: Vector3<f64>,
    /// Spatial inertia.
    pub inertia: Inertia,
    /// Twist V.
    pub velocity: Motion,
    /// Momentum I V about O.
    pub momentum: Force,
    /// Spatial acceleration at `vdot = 0`, without gravity: the velocity products.
    pub drift: Motion,
    /// Spatial acceleration at the `vdot` last given to [`super::kinematics::accelerations`],
    /// without gravity.
    pub acceleration: Motion,
}

/// Results of the algorithms for the state last given to [`super::kinematics::update`].
#[derive(Clone, Debug)]
pub struct Workspace {
    /// O: the root's origin in the world, m.
    pub position: Vector3<f64>,
    /// One entry per link.
    pub links: Vec<LinkMotion>,
    /// Motion S_k that velocity k makes at rate 1; length nv. The base's six are the unit vectors.
    pub axes: Vec<Motion>,
    /// Copy of the state's `v`, length nv.
    pub v: Vec<f64>,
    /// Bias h = Coriolis, centrifugal and gravity terms, length nv.
    pub bias: Vec<f64>,
    /// Mass matrix M, joint armature included.
    pub mass: TreeMatrix,
    /// Factor L with M = L^T L; its diagonal holds 1 / L_kk.
    pub factor: TreeMatrix,
    /// Coupled joints and closed loops.
    pub constraints: Constraints,
    /// All velocities.
    every: Vec<usize>,
    /// Velocities of the base, 6 or 0.
    pub(super) nb: usize,
    /// Index of each link's parent; the root's is 0.
    pub(super) parent: Vec<usize>,
    pub(super) forces: Vec<Force>,
    pub(super) composite: Vec<Inertia>,
    pub(super) articulated: Vec<super::aba::Articulated>,
    pub(super) scratch: Vec<f64>,
}

impl Workspace {
    /// Allocates the workspace of a model.
    pub fn new(model: &Model) -> Self {
        let (nb, nv, nl) = (model.nb(), model.nv(), model.links.len());
        let parent: Vec<usize> = model.links.iter().map(|l| l.parent.map_or(0, |p| p.0)).collect();
        let mut above: Vec<Option<usize>> = (0..nb).map(|k| k.checked_sub(1)).collect();
        above.extend(parent[1..].iter().map(|&p| last_velocity(model.base, p)));
        let unit = |k: usize| {
            let mut x = [0.0; 6];
            x[k] = 1.0;
            Motion::from_slice(&x)
        };
        let mut axes = vec![Motion::ZERO; nv];
        for (k, axis) in axes.iter_mut().enumerate().take(nb) {
            *axis = unit(k);
        }
        let rest = LinkMotion {
            rotation: Matrix3::identity(),
            origin: Vector3::zeros(),
            inertia: Inertia::ZERO,
            velocity: Motion::ZERO,
            momentum: Force::ZERO,
            drift: Motion::ZERO,
            acceleration: Motion::ZERO,
        };
        let zeros = TreeMatrix::zeros(Pattern::new(&above));
        Workspace {
            position: Vector3::zeros(),
            links: vec![rest; nl],
            axes,
            v: vec![0.0; nv],
            bias: vec![0.0; nv],
            mass: zeros.clone(),
            factor: zeros,
            constraints: Constraints::new(model),
            every: (0..nv).collect(),
            nb,
            parent,
            forces: vec![Force::ZERO; nl],
            composite: vec![Inertia::ZERO; nl],
            articulated: vec![super::aba::Articulated::ZERO; nl],
            scratch: vec![0.0; nv],
        }
    }

    /// Number of velocities.
    pub fn nv(&self) -> usize {
        self.axes.len()
    }

    /// Velocities that move a link, root first; empty for the root of a fixed base.
    #[inline(always)]
    pub fn support(&self, link: LinkId) -> &[usize] {
        let base = if self.nb == 6 { Base::Floating } else { Base::Fixed };
        last_velocity(base, link.0).map_or(&[], |k| self.mass.pattern().chain(k))
    }

    /// Velocities that the forces on a link change, root first: those that move it, or all where conditions
    /// couple them.
    #[inline(always)]
    pub fn coupled(&self, link: LinkId) -> &[usize] {
        if self.constraints.number() == 0 { self.support(link) } else { &self.every }
    }

    /// World position (m) of a point given in a link's internal frame.
    #[inline(always)]
    pub fn point(&self, link: LinkId, local: &Vector3<f64>) -> Vector3<f64> {
        let l = &self.links[link.0];
        self.position + l.origin + l.rotation * local
    }
}

/// The last velocity on the path to a link.
fn last_velocity(base: Base, link: usize) -> Option<usize> {
    match base {
        Base::Floating => Some(link + 5),
        Base::Fixed => link.checked_sub(1),
    }
}
