//! Values of the soles and other polygons of a contact problem, whose number is not limited.

use smallvec::SmallVec;
use std::cmp::Ordering;
use std::fmt;
use std::ops::{Index, IndexMut};

/// Number of polygons up to which values are stored without an allocation.
pub const INLINE: usize = 16;

/// Indices of some polygons.
pub type SoleIndices = SmallVec<[usize; INLINE]>;

/// A value of each polygon: the values that were set, by index, and one value for all others.
pub struct PerSole<T> {
    set: SmallVec<[T; INLINE]>,
    others: T,
}

impl<T> PerSole<T> {
    /// The same value for all polygons.
    pub fn filled(value: T) -> Self {
        PerSole { set: SmallVec::new(), others: value }
    }

    /// Gives all polygons the same value.
    pub fn fill(&mut self, value: T) {
        self.set.clear();
        self.others = value;
    }

    /// Index from which on all values are equal.
    fn end(&self, other: &Self) -> usize {
        self.set.len().max(other.set.len())
    }
}

impl<T> Index<usize> for PerSole<T> {
    type Output = T;

    fn index(&self, sole: usize) -> &T {
        self.set.get(sole).unwrap_or(&self.others)
    }
}

impl<T: Copy> IndexMut<usize> for PerSole<T> {
    fn index_mut(&mut self, sole: usize) -> &mut T {
        while self.set.len() <= sole {
            self.set.push(self.others);
        }
        &mut self.set[sole]
    }
}

impl<T: Copy> Clone for PerSole<T> {
    fn clone(&self) -> Self {
        PerSole { set: SmallVec::from_slice(&self.set), others: self.others }
    }

    fn clone_from(&mut self, from: &Self) {
        self.set.clear();
        self.set.extend_from_slice(&from.set);
        self.others = from.others;
    }
}

impl<T: Default> Default for PerSole<T> {
    fn default() -> Self {
        PerSole::filled(T::default())
    }
}

impl<T: PartialEq> PartialEq for PerSole<T> {
    fn eq(&self, other: &Self) -> bool {
        self.others == other.others && (0..self.end(other)).all(|s| self[s] == other[s])
    }
}

impl<T: Eq> Eq for PerSole<T> {}

impl<T: Ord> PartialOrd for PerSole<T> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<T: Ord> Ord for PerSole<T> {
    fn cmp(&self, other: &Self) -> Ordering {
        let orders = (0..self.end(other)).map(|s| self[s].cmp(&other[s]));
        orders.into_iter().find(|order| order.is_ne()).unwrap_or_else(|| self.others.cmp(&other.others))
    }
}

impl<T: fmt::Debug> fmt::Debug for PerSole<T> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_list().entries(&self.set).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_that_were_not_set_are_the_common_one() {
        let mut values = PerSole::filled(true);
        assert!(values[0] && values[1000]);
        values[40] = false;
        assert!(values[0] && values[39] && !values[40] && values[41]);
        values.fill(true);
        assert!(values[40]);
    }

    #[test]
    fn comparison_does_not_depend_on_which_values_were_set() {
        let (mut a, mut b) = (PerSole::default(), PerSole::default());
        a[50] = 0;
        assert_eq!(a, b);
        assert_eq!(a.cmp(&b), Ordering::Equal);
        b[3] = 1;
        assert_ne!(a, b);
        assert!(a < b);
        a[2] = 1;
        assert!(a > b, "the first polygon decides");
        assert_ne!(PerSole::filled(1), PerSole::filled(2));
    }

    #[test]
    fn copies_are_equal_within_and_beyond_the_inline_size() {
        for n in [INLINE, INLINE + 1, 100] {
            let mut values = PerSole::default();
            (0..n).for_each(|s| values[s] = s);
            let mut copy = PerSole::filled(7);
            copy[3] = 5;
            copy.clone_from(&values);
            assert_eq!(copy, values);
            assert_eq!(values.clone(), values);
            assert!((0..n).all(|s| copy[s] == s) && copy[n] == 0);
        }
    }
}
