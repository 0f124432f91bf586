//! Times cases in turn.

use std::fmt;

/// Values of one case, ascending.
pub struct Values(Vec<f64>);

impl Values {
    pub fn new(mut values: Vec<f64>) -> Self {
        values.sort_by(f64::total_cmp);
        Self(values)
    }

    pub fn min(&self) -> f64 {
        self.0[0]
    }

    pub fn median(&self) -> f64 {
        0.5 * (self.0[(self.0.len() - 1) / 2] + self.0[self.0.len() / 2])
    }

    pub fn max(&self) -> f64 {
        self.0[self.0.len() - 1]
    }
}

/// `median (least to greatest)`
impl fmt::Display for Values {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.2} ({:.2} to {:.2})", self.median(), self.min(), self.max())
    }
}

/// Results of each case in each round: `rounds[round][case]`. The first `dropped` rounds warm up.
pub fn rounds<T>(dropped: usize, count: usize, cases: &mut [Box<dyn FnMut() -> T + '_>]) -> Vec<Vec<T>> {
    let all = (0..dropped + count).map(|_| cases.iter_mut().map(|case| case()).collect());
    all.skip(dropped).collect()
}
