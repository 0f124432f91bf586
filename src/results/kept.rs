//! As many of the runs as there is room for, whatever their number: memory does not grow with it.

use std::collections::BTreeMap;

/// Runs that are kept in memory to be shown: as many as a batch has by default at the most.
pub const MOST_KEPT: usize = 10_000;

/// Of these those that went wrong, when there are more runs than can be kept.
const MOST_REFUSED: usize = 1000;

/// Things by their place in the plan: all of them while there is room, else the first of those that went wrong and the first
/// of the others. Which these are does not depend on the order in which they come.
#[derive(Clone, Debug)]
pub struct Kept<T> {
    most: usize,
    good: BTreeMap<usize, T>,
    refused: BTreeMap<usize, T>,
    dropped: usize,
}

impl<T> Default for Kept<T> {
    fn default() -> Self {
        Self::at_most(MOST_KEPT)
    }
}

impl<T> Kept<T> {
    /// Room for so many.
    pub fn at_most(most: usize) -> Self {
        Kept { most, good: BTreeMap::new(), refused: BTreeMap::new(), dropped: 0 }
    }

    /// Takes one in. What there is no room for is gone.
    pub fn insert(&mut self, place: usize, thing: T, is_refused: bool) {
        if is_refused { &mut self.refused } else { &mut self.good }.insert(place, thing);
        if self.good.len() + self.refused.len() > self.most {
            let crowded = if self.refused.len() > MOST_REFUSED.min(self.most) || self.good.is_empty() {
                &mut self.refused
            } else {
                &mut self.good
            };
            crowded.pop_last();
            self.dropped += 1;
        }
    }

    /// How many are kept.
    pub fn len(&self) -> usize {
        self.good.len() + self.refused.len()
    }

    /// Is there nothing?
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// How many there was no room for.
    pub fn dropped(&self) -> usize {
        self.dropped
    }

    /// By place, if it is kept.
    pub fn get(&self, place: usize) -> Option<&T> {
        self.good.get(&place).or_else(|| self.refused.get(&place))
    }

    /// The same to be changed.
    pub fn get_mut(&mut self, place: usize) -> Option<&mut T> {
        self.good.get_mut(&place).or_else(|| self.refused.get_mut(&place))
    }

    /// All that are kept, by place.
    pub fn into_sorted(self) -> Vec<T> {
        let mut all = self.good;
        all.extend(self.refused);
        all.into_values().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_are_kept_and_those_that_went_wrong_whatever_comes_first() {
        let refused = |place: &usize| place % 7 == 6;
        let mut orders: Vec<Vec<usize>> = vec![(0..50).collect(), (0..50).rev().collect()];
        orders.push((0..50).map(|i| i * 13 % 50).collect());
        for order in orders {
            let mut kept = Kept::at_most(12);
            order.iter().for_each(|place| kept.insert(*place, *place, refused(place)));
            assert_eq!(kept.dropped(), 38);
            assert_eq!(kept.get(20), Some(&20));
            assert_eq!(kept.get(21), None);
            assert_eq!(kept.into_sorted(), [0, 1, 2, 3, 4, 6, 13, 20, 27, 34, 41, 48], "{order:?}");
        }
        let mut all = Kept::at_most(50);
        (0..50).for_each(|place| all.insert(place, place, refused(&place)));
        assert_eq!(all.into_sorted(), (0..50).collect::<Vec<_>>());
    }
}
