//! The blocks `W_st = Y_s^T Y_t` that are not always zero: of contacts whose bodies have velocities in common.

use super::{Mechanisms, Reduced};
use std::ops::Range;

/// A block of W, with a contact at or before that of its rows.
#[derive(Clone, Debug)]
pub(super) struct Block {
    other: usize,
    /// Its terms, Y_a Y_b^T.
    terms: Range<usize>,
}

/// Entries of Y that two sides have in common: the first ones of both, and their number.
#[derive(Clone, Debug)]
pub(super) struct Term {
    a: usize,
    b: usize,
    length: usize,
}

impl Reduced {
    /// Adds the blocks of the last contact, whose sides are known, with those before and itself.
    pub(super) fn add_blocks(&mut self, ws: Mechanisms) {
        let s = self.n;
        for other in 0..=s {
            let first = self.terms.len();
            for a in &self.sides[self.sides(s)] {
                let chain = ws.get(a.body.mechanism).coupled(a.body.link);
                for b in self.sides[self.sides(other)].iter().filter(|b| b.body.mechanism == a.body.mechanism) {
                    let of_b = ws.get(b.body.mechanism).coupled(b.body.link);
                    let length = chain.iter().zip(of_b).take_while(|(i, j)| i == j).count();
                    if length > 0 {
                        self.terms.push(Term { a: a.start, b: b.start, length });
                    }
                }
            }
            if self.terms.len() > first {
                self.blocks.push(Block { other, terms: first..self.terms.len() });
            }
        }
        self.block_start.push(self.blocks.len());
    }
}

/// Computes the blocks of contact `s` with those before, and their mirror images. All others remain zero.
pub(super) fn multiply(s: usize, out: &mut Reduced) {
    let size = 6 * out.n;
    let (y, w) = (&out.y, &mut out.w);
    for Block { other, terms } in &out.blocks[out.block_start[s]..out.block_start[s + 1]] {
        let terms = &out.terms[terms.clone()];
        let (row, column) = (6 * s, 6 * other);
        write(&columns::<6>(y, terms, 0, 0), row, column, size, w);
        if s == *other {
            // The rest of the last columns are mirror images.
            write(&columns::<3>(y, terms, 3, 3), row + 3, column + 3, size, w);
        } else {
            write(&columns::<6>(y, terms, 0, 3), row, column + 3, size, w);
        }
    }
}

/// `R` rows of three columns of a block, which stay in registers.
#[inline(always)]
fn columns<const R: usize>(y: &[[f64; 6]], terms: &[Term], row: usize, column: usize) -> [[f64; R]; 3] {
    let mut sum = [[0.0; R]; 3];
    for Term { a, b, length } in terms {
        for (ya, yb) in y[*a..][..*length].iter().zip(&y[*b..][..*length]) {
            for (sum, &b) in sum.iter_mut().zip(&yb[column..]) {
                for (x, &a) in sum.iter_mut().zip(&ya[row..]) {
                    *x += a * b;
                }
            }
        }
    }
    sum
}

/// Writes a part of a block to W from this row and column on, and its mirror image.
#[inline(always)]
fn write<const R: usize>(part: &[[f64; R]; 3], row: usize, column: usize, size: usize, w: &mut [f64]) {
    for (c, entries) in part.iter().enumerate() {
        w[row + size * (column + c)..][..R].copy_from_slice(entries);
    }
    for r in 0..R {
        w[column + size * (row + r)..][..3].copy_from_slice(&part.map(|entries| entries[r]));
    }
}
