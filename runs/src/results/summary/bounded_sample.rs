//! A bounded sample of runs: memory stays constant as the batch grows.

use std::collections::BTreeMap;

/// Largest number of runs in a sample: the default limit of a batch.
pub const SAMPLE_SIZE: usize = 10_000;

/// Share of failed runs in a sample, where not all runs fit.
const MAX_FAILED: usize = 1000;

/// Items by their index in the plan: all while there is room, then the first failed ones and the
/// first others. The sample does not depend on the order of insertion.
#[derive(Clone, Debug)]
pub struct BoundedSample<T> {
    capacity: usize,
    good: BTreeMap<usize, T>,
    failed: BTreeMap<usize, T>,
}

impl<T> Default for BoundedSample<T> {
    fn default() -> Self {
        Self::with_capacity(SAMPLE_SIZE)
    }
}

impl<T> BoundedSample<T> {
    /// An empty sample of at most `capacity` items.
    pub fn with_capacity(capacity: usize) -> Self {
        BoundedSample { capacity, good: BTreeMap::new(), failed: BTreeMap::new() }
    }

    /// Inserts an item; a full sample drops one.
    pub fn insert(&mut self, index: usize, item: T, is_failed: bool) {
        if is_failed { &mut self.failed } else { &mut self.good }.insert(index, item);
        if self.len() > self.capacity {
            let crowded = if self.failed.len() > MAX_FAILED.min(self.capacity) || self.good.is_empty() {
                &mut self.failed
            } else {
                &mut self.good
            };
            crowded.pop_last();
        }
    }

    /// Number of items in the sample.
    pub fn len(&self) -> usize {
        self.good.len() + self.failed.len()
    }

    /// True if the sample has no item.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The item of an index, if it is in the sample.
    pub fn get(&self, index: usize) -> Option<&T> {
        self.good.get(&index).or_else(|| self.failed.get(&index))
    }

    /// The item of an index for modification, if it is in the sample.
    pub fn get_mut(&mut self, index: usize) -> Option<&mut T> {
        self.good.get_mut(&index).or_else(|| self.failed.get_mut(&index))
    }

    /// All items with their indices.
    pub fn iter(&self) -> impl Iterator<Item = (usize, &T)> {
        self.good.iter().chain(&self.failed).map(|(index, item)| (*index, item))
    }

    /// All items, in the order of their indices.
    pub fn into_sorted(self) -> Vec<T> {
        let mut all = self.good;
        all.extend(self.failed);
        all.into_values().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_full_sample_has_the_first_items_and_the_first_failed_ones_in_any_order_of_insertion() {
        let is_failed = |index: &usize| index % 7 == 6;
        let mut orders: Vec<Vec<usize>> = vec![(0..50).collect(), (0..50).rev().collect()];
        orders.push((0..50).map(|i| i * 13 % 50).collect());
        for order in orders {
            let mut sample = BoundedSample::with_capacity(12);
            order.iter().for_each(|index| sample.insert(*index, *index, is_failed(index)));
            assert_eq!(sample.get(20), Some(&20));
            assert_eq!(sample.get(21), None);
            assert_eq!(sample.into_sorted(), [0, 1, 2, 3, 4, 6, 13, 20, 27, 34, 41, 48], "{order:?}");
        }
        let mut all = BoundedSample::with_capacity(50);
        (0..50).for_each(|index| all.insert(index, index, is_failed(&index)));
        assert_eq!(all.into_sorted(), (0..50).collect::<Vec<_>>());
    }
}
