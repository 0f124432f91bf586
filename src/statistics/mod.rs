//! Exact inference on a share: binomial probabilities and confidence bounds, for a fixed number of
//! runs and for one that the results themselves end.
//!
//! Imports: `math`. Used by: `scenario`, `results`.

mod binomial;
mod share_test;

pub use binomial::{ln_probability, lower_tail, probability, upper_tail};
pub use share_test::{Rule, ShareTest, ln_mean_above, ln_mean_below};
