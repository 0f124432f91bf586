//! Exact inference on a share: binomial probabilities and confidence bounds, for a fixed number of
//! runs and for one that the results themselves end. An exact test of trends by ranks. Tails and quantiles
//! for least squares.
//!
//! Imports: `math`. Used by: `scenario`, `results`, `fit`, `history`.

mod binomial;
mod distributions;
mod rank_trend;
mod share_test;

pub use binomial::{ln_probability, lower_tail, probability, upper_tail};
pub use distributions::{chi_square_tail, f_tail, normal_quantile, student_quantile};
pub use rank_trend::{RankTrend, rank_trend};
pub use share_test::{Rule, ShareTest, ln_mean_above, ln_mean_below};
