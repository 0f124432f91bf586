//! The robot on its floor as a system of differential equations, contact states held fixed.
//!
//! [`Plant`] evaluates the right-hand side: kinematics, efforts, the reduced contact problem,
//! wrenches and accelerations. The other files are parts of it: the layout of the integrator's
//! vector, implicit dampers, kinematic joints as constraints, sliding directions, friction regions
//! of the vertices, loads and impulses on the soles, energies and powers, objects besides the robot,
//! couplings and closed loops.
//!
//! Imports actuation, floor, contact, dynamics and force. Called by every other module of sim;
//! independent of [`Simulation`](super::Simulation), tasks, observers and metrics.

mod carried_mass;
mod conditions;
mod contact_stiffness;
mod drive_stiffness;
pub mod energy;
pub mod energy_flows;
mod external_stiffness;
mod force_models;
mod friction;
pub mod friction_stiffness;
pub mod implicit_dampers;
pub mod implicit_forces;
pub mod kinematic_joints;
mod mechanism_states;
mod motor_stiffness;
mod object_forces;
pub mod objects;
pub mod pair_vertices;
mod parameters;
mod plant_copy;
pub mod polygon;
pub mod sliding_directions;
pub mod sole_impulses;
pub mod sole_loads;
pub mod state_layout;
mod stiff_products;
pub mod system;
mod turning;
mod vertices;

pub use energy_flows::EnergyFlows;
pub use objects::ObjectSetup;
pub use polygon::Polygon;
pub use state_layout::StateLayout;
pub use system::{Plant, PlantSetup};
