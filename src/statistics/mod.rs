//! Exact inference on a share: binomial probabilities and confidence bounds, for a fixed number of
//! runs and for one that the results themselves end. An exact test of trends by ranks.
//!
//! Imports: `math`. Used by: `scenario`, `results`.

mod binomial;
mod rank_trend;
mod share_test;

pub use binomial::{ln_probability, lower_tail, probability, upper_tail};
pub use rank_trend::{RankTrend, rank_trend};
pub use share_test::{Rule, ShareTest, ln_mean_above, ln_mean_below};
