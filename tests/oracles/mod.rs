//! Comparison with independent libraries. Each `make_*.py` writes the JSON beside it and is run by hand.

mod collision;
mod contact;
mod context;
mod dynamics;
mod dynamics_oracle;
