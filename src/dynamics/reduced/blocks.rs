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
    for Block { other, terms } in &out.blocks[out.block_start[s]..out.block_start[s + 1]] {
        // Three columns at a time stay in registers.
        for first in [0, 3] {
            let mut sum = [[0.0; 6]; 3];
            for Term { a, b, length } in &out.terms[terms.clone()] {
                for (ya, yb) in out.y[*a..][..*length].iter().zip(&out.y[*b..][..*length]) {
                    for (column, &b) in sum.iter_mut().zip(&yb[first..]) {
                        for (x, &a) in column.iter_mut().zip(ya) {
                            *x += a * b;
                        }
                    }
                }
            }
            for (c, column) in sum.iter().enumerate().map(|(c, column)| (6 * other + first + c, column)) {
                out.w[6 * s + size * c..][..6].copy_from_slice(column);
                // A block on the diagonal is its own mirror image.
                if s != *other {
                    column.iter().enumerate().for_each(|(r, x)| out.w[c + size * (6 * s + r)] = *x);
                }
            }
        }
    }
}
