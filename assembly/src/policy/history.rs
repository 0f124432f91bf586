//! The last observations, in the order in which a network receives them.

/// The last N observations of W numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct History {
    /// Observations, the oldest first.
    frames: Vec<f32>,
    /// Widths of the terms of an observation.
    widths: Vec<usize>,
    length: usize,
    newest_first: bool,
    by_term: bool,
    filled: bool,
}

impl History {
    /// For `length` observations whose terms have these widths. `newest_first`: the present one is
    /// the first; `by_term`: each term with its history, one after the other.
    pub fn new(widths: Vec<usize>, length: usize, newest_first: bool, by_term: bool) -> Self {
        let frames = vec![0.0; length * widths.iter().sum::<usize>()];
        History { frames, widths, length, newest_first, by_term, filled: false }
    }

    /// Number of numbers that the network receives.
    pub fn width(&self) -> usize {
        self.frames.len()
    }

    /// Adds an observation, the first one `length` times, and writes all to `input`.
    pub fn push(&mut self, observation: &[f32], input: &mut [f32]) {
        let width = observation.len();
        if self.filled {
            self.frames.copy_within(width.., 0);
            let last = self.frames.len() - width;
            self.frames[last..].copy_from_slice(observation);
        } else {
            self.frames.chunks_exact_mut(width).for_each(|frame| frame.copy_from_slice(observation));
            self.filled = true;
        }
        let (frames, length) = (&self.frames, self.length);
        let frame = |k: usize| if self.newest_first { length - 1 - k } else { k };
        let mut to = 0;
        let mut copy = |k: usize, from: usize, count: usize| {
            let from = frame(k) * width + from;
            input[to..to + count].copy_from_slice(&frames[from..from + count]);
            to += count;
        };
        if self.by_term {
            let mut from = 0;
            for count in &self.widths {
                (0..length).for_each(|k| copy(k, from, *count));
                from += count;
            }
        } else {
            (0..length).for_each(|k| copy(k, 0, width));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn inputs(newest_first: bool, by_term: bool) -> [Vec<f32>; 3] {
        let mut history = History::new(vec![1, 2], 2, newest_first, by_term);
        [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0]].map(|observation| {
            let mut input = vec![0.0; 6];
            history.push(&observation, &mut input);
            input
        })
    }

    #[test]
    fn observations_are_stacked_in_each_order() {
        let first = [1.0, 2.0, 3.0, 1.0, 2.0, 3.0];
        let third = |expected: [f32; 6], newest_first, by_term| {
            let [start, _, last] = inputs(newest_first, by_term);
            assert_eq!(last, expected);
            if !by_term {
                assert_eq!(start, first, "all are the first one at the start");
            }
        };
        third([4.0, 5.0, 6.0, 7.0, 8.0, 9.0], false, false);
        third([7.0, 8.0, 9.0, 4.0, 5.0, 6.0], true, false);
        third([4.0, 7.0, 5.0, 6.0, 8.0, 9.0], false, true);
        third([7.0, 4.0, 8.0, 9.0, 5.0, 6.0], true, true);
    }
}
