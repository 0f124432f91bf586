//! Symmetric or triangular matrices with the branch sparsity of a tree.
//!
//! Entry (i, j), j <= i, can differ from zero only when velocity j lies on the path from the root
//! to velocity i ([Featherstone 2008], section 6.3). Row i therefore stores only its ancestors,
//! root first, and itself last. Two rows share the columns of their common ancestors *at the same
//! offset in the row*, so row operations of the factorisation run over contiguous numbers without
//! index lists.

/// Entries of each row: its ancestors, root first, itself last.
#[derive(Clone, PartialEq, Debug)]
pub struct Pattern {
    start: Vec<usize>,
    column: Vec<usize>,
    /// Descendants of each row, the last first, with the positions of their first entries, and where
    /// those of a row begin.
    descendant: Vec<(usize, usize)>,
    descendant_start: Vec<usize>,
    /// See [`Pattern::base`].
    base: usize,
    /// See [`Pattern::by_depth`].
    by_depth: Vec<usize>,
}

impl Pattern {
    /// Builds the pattern from the parent velocity of each velocity (`None`: attached to the
    /// ground). Parents have smaller indices.
    pub fn new(parents: &[Option<usize>]) -> Self {
        let follows =
            |(i, parent): (usize, &Option<usize>)| if i < 6 { *parent == i.checked_sub(1) } else { *parent >= Some(5) };
        let base = if parents.len() >= 6 && parents.iter().enumerate().all(follows) { 6 } else { 0 };
        let mut pattern = Pattern {
            start: vec![0],
            column: Vec::new(),
            descendant: Vec::new(),
            descendant_start: vec![0],
            base,
            by_depth: Vec::new(),
        };
        for (i, parent) in parents.iter().enumerate() {
            if let Some(p) = *parent {
                pattern.column.extend_from_within(pattern.start[p]..pattern.start[p + 1]);
            }
            pattern.column.push(i);
            pattern.start.push(pattern.column.len());
        }
        for i in 0..pattern.len() {
            let below = (i + 1..pattern.len()).rev().filter(|&d| pattern.chain(d).contains(&i));
            let below: Vec<_> = below.map(|d| (d, pattern.start[d])).collect();
            pattern.descendant.extend(below);
            pattern.descendant_start.push(pattern.descendant.len());
        }
        let mut by_depth: Vec<usize> = (base..pattern.len()).collect();
        by_depth.sort_by_key(|&i| pattern.chain(i).len());
        pattern.by_depth = by_depth;
        pattern
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.start.len() - 1
    }

    /// True for a tree without velocities.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// 6 if the first six velocities are a chain with which every other row begins, as those of a
    /// floating base; otherwise 0.
    #[inline(always)]
    pub(super) fn base(&self) -> usize {
        self.base
    }

    /// Velocities after the base by their number of ancestors, least first. Successive ones belong to
    /// different limbs, whose computations do not wait for each other.
    #[inline(always)]
    pub(super) fn by_depth(&self) -> &[usize] {
        &self.by_depth
    }

    /// Whether velocity `i` is `j` or one of its descendants.
    #[inline(always)]
    pub fn is_below(&self, i: usize, j: usize) -> bool {
        self.chain(i).get(self.chain(j).len() - 1) == Some(&j)
    }

    /// Ancestors of velocity `i`, root first, `i` itself last.
    #[inline(always)]
    pub fn chain(&self, i: usize) -> &[usize] {
        &self.column[self.start[i]..self.start[i + 1]]
    }

    /// Velocities on whose path from the root velocity `i` lies, the last first, without `i`: each
    /// with the position of its row among all entries.
    #[inline(always)]
    pub(super) fn descendants(&self, i: usize) -> &[(usize, usize)] {
        &self.descendant[self.descendant_start[i]..self.descendant_start[i + 1]]
    }

    #[inline(always)]
    fn range(&self, i: usize) -> std::ops::Range<usize> {
        self.start[i]..self.start[i + 1]
    }

    /// Position of the first entry of row `i` in [`TreeMatrix::entries`].
    #[inline(always)]
    pub(super) fn start(&self, i: usize) -> usize {
        self.start[i]
    }
}

/// Values on a [`Pattern`].
#[derive(Clone, PartialEq, Debug)]
pub struct TreeMatrix {
    pattern: Pattern,
    values: Vec<f64>,
}

impl TreeMatrix {
    /// The zero matrix.
    pub fn zeros(pattern: Pattern) -> Self {
        let values = vec![0.0; pattern.column.len()];
        TreeMatrix { pattern, values }
    }

    /// Number of rows, nv.
    pub fn len(&self) -> usize {
        self.pattern.len()
    }

    /// True when there are no rows.
    pub fn is_empty(&self) -> bool {
        self.pattern.is_empty()
    }

    /// Sparsity pattern.
    pub fn pattern(&self) -> &Pattern {
        &self.pattern
    }

    /// Entries of row `i` over `pattern().chain(i)`.
    #[inline(always)]
    pub fn row(&self, i: usize) -> &[f64] {
        &self.values[self.pattern.range(i)]
    }

    /// Entries of all rows, one row after the other.
    #[inline(always)]
    pub(super) fn entries(&self) -> &[f64] {
        &self.values
    }

    /// Columns and entries of all rows, in order.
    #[inline(always)]
    pub(super) fn rows(&self) -> impl DoubleEndedIterator<Item = (&[usize], &[f64])> + ExactSizeIterator {
        let Pattern { start, column, .. } = &self.pattern;
        start.windows(2).map(|ends| (&column[ends[0]..ends[1]], &self.values[ends[0]..ends[1]]))
    }

    /// Columns and entries of row `i`, for writing.
    #[inline(always)]
    pub fn row_mut(&mut self, i: usize) -> (&[usize], &mut [f64]) {
        let range = self.pattern.range(i);
        (&self.pattern.column[range.clone()], &mut self.values[range])
    }

    /// Entry (i, j) of the symmetric matrix, `i` and `j` in any order; zero off the pattern.
    pub fn get(&self, i: usize, j: usize) -> f64 {
        let (i, j) = (i.max(j), i.min(j));
        self.pattern.chain(i).iter().position(|&c| c == j).map_or(0.0, |e| self.row(i)[e])
    }

    /// `out = A x` with A symmetric, both of length nv.
    pub fn multiply(&self, x: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        for i in 0..self.len() {
            let chain = self.pattern.chain(i);
            let row = self.row(i);
            let above = row.len() - 1;
            let mut sum = row[above] * x[i];
            for (&j, &a) in chain[..above].iter().zip(row) {
                sum += a * x[j];
                out[j] += a * x[i];
            }
            out[i] += sum;
        }
    }

    /// `(A x)_k` with A symmetric, `x` of length nv.
    pub fn row_times(&self, k: usize, x: &[f64]) -> f64 {
        let (chain, row) = (self.pattern.chain(k), self.row(k));
        let depth = row.len() - 1;
        let above = chain[..depth].iter().zip(row).fold(row[depth] * x[k], |sum, (&j, a)| sum + a * x[j]);
        let below = self.pattern.descendants(k).iter().rev();
        below.fold(above, |sum, &(d, start)| sum + self.values[start + depth] * x[d])
    }

    /// Adds `x` to entry (i, j), one of which is on the path from the root to the other.
    #[inline]
    pub fn add_entry(&mut self, i: usize, j: usize, x: f64) {
        let (i, j) = (i.max(j), i.min(j));
        let depth = self.pattern.chain(j).len() - 1;
        debug_assert!(self.pattern.is_below(i, j));
        self.row_mut(i).1[depth] += x;
    }

    /// Adds a matrix of the same pattern.
    pub fn add(&mut self, other: &TreeMatrix) {
        self.values.iter_mut().zip(&other.values).for_each(|(a, b)| *a += b);
    }

    /// `x^T A y` with A symmetric, both of length nv.
    pub fn between(&self, x: &[f64], y: &[f64]) -> f64 {
        let row = |i: usize| {
            let above = self.row(i).len() - 1;
            let off = self.pattern.chain(i)[..above].iter().zip(self.row(i));
            let off: f64 = off.map(|(&j, a)| a * (x[i] * y[j] + x[j] * y[i])).sum();
            off + self.row(i)[above] * x[i] * y[i]
        };
        (0..self.len()).map(row).sum()
    }

    /// `out += factor A e_k`, the column of velocity `k` of the symmetric matrix; `out` has length
    /// nv.
    pub fn add_column(&self, k: usize, factor: f64, out: &mut [f64]) {
        for (&j, &a) in self.pattern.chain(k).iter().zip(self.row(k)) {
            out[j] += factor * a;
        }
        let depth = self.pattern.chain(k).len() - 1;
        for &(d, start) in self.pattern.descendants(k) {
            out[d] += factor * self.values[start + depth];
        }
    }

    /// Replaces row and column `k` by those of the unit matrix.
    pub(super) fn decouple(&mut self, k: usize) {
        let depth = self.pattern.chain(k).len() - 1;
        let (_, row) = self.row_mut(k);
        row.fill(0.0);
        row[depth] = 1.0;
        for &(_, start) in self.pattern.descendants(k) {
            self.values[start + depth] = 0.0;
        }
    }

    /// Copies `other`, of the same pattern, without allocating.
    pub fn copy_from(&mut self, other: &TreeMatrix) {
        self.values.copy_from_slice(&other.values);
    }
}
