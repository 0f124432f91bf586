//! Comparison with independent libraries. Each `make_*.py` writes a JSON file of this folder and is
//! run by hand.

mod binomial;
mod collision;
mod contact;
mod context;
mod distributions;
mod dynamics;
mod dynamics_oracle;
mod height_fields;
mod loops;
mod mjcf;
mod sdf;
mod trend;
