//! Values of the soles and other polygons of a contact problem, whose number is not limited.

use smallvec::SmallVec;
use std::cmp::Ordering;
use std::fmt;
use std::ops::{Index, IndexMut};
use std::sync::Arc;

/// Number of polygons up to which values are stored without an allocation.
pub const INLINE: usize = 16;

/// Indices of some polygons.
pub type SoleIndices = SmallVec<[usize; INLINE]>;

/// A value of each polygon: the values that were set, by index, and one value for all others.
pub struct PerSole<T> {
    set: Values<T>,
    others: T,
}

/// Values by index. Copies of more than [`INLINE`] share them until one is changed, so that copying allocates
/// nothing.
enum Values<T> {
    Inline(SmallVec<[T; INLINE]>),
    Shared(Arc<Vec<T>>),
}

impl<T> PerSole<T> {
    /// The same value for all polygons.
    pub fn filled(value: T) -> Self {
        PerSole { set: Values::Inline(SmallVec::new()), others: value }
    }

    /// Gives all polygons the same value.
    pub fn fill(&mut self, value: T) {
        *self = PerSole::filled(value);
    }

    #[inline]
    fn values(&self) -> &[T] {
        match &self.set {
            Values::Inline(values) => values,
            Values::Shared(values) => values,
        }
    }

    /// Index from which on all values are equal.
    fn end(&self, other: &Self) -> usize {
        self.values().len().max(other.values().len())
    }
}

impl<T: Copy + PartialEq> PerSole<T> {
    /// Sets the value of a polygon. Allocates nothing if it has that value.
    pub fn set(&mut self, sole: usize, value: T) {
        if self[sole] != value {
            self[sole] = value;
        }
    }
}

impl<T> Index<usize> for PerSole<T> {
    type Output = T;

    #[inline]
    fn index(&self, sole: usize) -> &T {
        self.values().get(sole).unwrap_or(&self.others)
    }
}

impl<T: Copy> IndexMut<usize> for PerSole<T> {
    #[inline]
    fn index_mut(&mut self, sole: usize) -> &mut T {
        if self.values().len() <= sole {
            self.extend_to(sole);
        }
        match &mut self.set {
            Values::Inline(values) => &mut values[sole],
            Values::Shared(values) => &mut Arc::make_mut(values)[sole],
        }
    }
}

impl<T: Copy> PerSole<T> {
    /// Stores the values up to that of polygon `sole`.
    fn extend_to(&mut self, sole: usize) {
        if let Values::Inline(values) = &self.set
            && sole >= INLINE
        {
            self.set = Values::Shared(Arc::new(values.to_vec()));
        }
        match &mut self.set {
            Values::Inline(values) => values.resize(sole + 1, self.others),
            Values::Shared(values) => Arc::make_mut(values).resize(sole + 1, self.others),
        }
    }
}

impl<T: Copy> Clone for PerSole<T> {
    fn clone(&self) -> Self {
        let set = match &self.set {
            Values::Inline(values) => Values::Inline(SmallVec::from_slice(values)),
            Values::Shared(values) => Values::Shared(Arc::clone(values)),
        };
        PerSole { set, others: self.others }
    }

    fn clone_from(&mut self, from: &Self) {
        self.others = from.others;
        match &mut self.set {
            Values::Inline(values) if from.values().len() <= INLINE => {
                values.clear();
                values.extend_from_slice(from.values());
                return;
            }
            // What is not shared is likely to be changed again.
            Values::Shared(values) => {
                if let Some(values) = Arc::get_mut(values) {
                    values.clear();
                    values.extend_from_slice(from.values());
                    return;
                }
            }
            Values::Inline(_) => {}
        }
        *self = from.clone();
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
        f.debug_list().entries(self.values()).finish()
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
    fn a_copy_keeps_its_values_when_the_original_changes() {
        for n in [3, INLINE + 1] {
            let mut values = PerSole::default();
            (0..n).for_each(|s| values[s] = s);
            let copy = values.clone();
            values.set(1, 7);
            values.set(n - 1, n - 1);
            assert_eq!((copy[1], values[1], copy[2], values[n - 1]), (1, 7, 2, n - 1));
        }
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
