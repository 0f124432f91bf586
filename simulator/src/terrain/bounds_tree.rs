//! A tree of bounding boxes, for the pieces near a box.

use nalgebra::Vector3;

/// A box with its edges along the world's axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    pub min: Vector3<f64>,
    pub max: Vector3<f64>,
}

impl Bounds {
    /// The bounding box of points.
    pub fn of(points: &[Vector3<f64>]) -> Self {
        let empty = Bounds { min: Vector3::repeat(f64::INFINITY), max: Vector3::repeat(f64::NEG_INFINITY) };
        points.iter().fold(empty, |bounds, p| Bounds { min: bounds.min.inf(p), max: bounds.max.sup(p) })
    }

    fn union(&self, other: &Bounds) -> Bounds {
        Bounds { min: self.min.inf(&other.min), max: self.max.sup(&other.max) }
    }

    /// True if they have a point in common.
    pub fn meets(&self, other: &Bounds) -> bool {
        (0..3).all(|axis| self.min[axis] <= other.max[axis] && other.min[axis] <= self.max[axis])
    }
}

/// Nodes in the order of a depth-first search: the first child of a node follows it.
#[derive(Clone, Debug, Default)]
pub(super) struct BoundsTree {
    nodes: Vec<Node>,
}

#[derive(Clone, Debug)]
struct Node {
    bounds: Bounds,
    /// The node after all descendants.
    next: u32,
    /// The box, if the node is a leaf.
    leaf: Option<u32>,
}

impl BoundsTree {
    /// A tree of these boxes.
    pub fn new(bounds: Vec<Bounds>) -> Self {
        let mut order: Vec<u32> = (0..bounds.len() as u32).collect();
        let mut tree = BoundsTree { nodes: Vec::with_capacity(2 * bounds.len()) };
        if !order.is_empty() {
            tree.add(&mut order, &bounds);
        }
        tree
    }

    /// Adds the node of some boxes. Halving their number keeps the depth logarithmic.
    fn add(&mut self, order: &mut [u32], bounds: &[Bounds]) {
        let of = |k: u32| &bounds[k as usize];
        let whole = order.iter().skip(1).fold(*of(order[0]), |whole, &k| whole.union(of(k)));
        let node = self.nodes.len();
        let leaf = (order.len() == 1).then_some(order[0]);
        self.nodes.push(Node { bounds: whole, next: 0, leaf });
        if leaf.is_none() {
            let axis = (whole.max - whole.min).imax();
            let key = |k: &u32| of(*k).min[axis] + of(*k).max[axis];
            order.sort_unstable_by(|a, b| key(a).total_cmp(&key(b)).then(a.cmp(b)));
            let (low, high) = order.split_at_mut(order.len() / 2);
            self.add(low, bounds);
            self.add(high, bounds);
        }
        self.nodes[node].next = self.nodes.len() as u32;
    }

    /// Calls `f` with the index of each box that meets `bounds`.
    pub fn near(&self, bounds: &Bounds, mut f: impl FnMut(u32)) {
        let mut at = 0;
        while let Some(node) = self.nodes.get(at) {
            if !node.bounds.meets(bounds) {
                at = node.next as usize;
                continue;
            }
            if let Some(leaf) = node.leaf {
                f(leaf);
            }
            at += 1;
        }
    }
}
