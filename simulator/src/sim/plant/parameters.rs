//! Parameters that change while running.

use super::Plant;
use crate::force::{Force, ForceError};
use crate::robot::Model;
use crate::sim::floor::Floor;
use nalgebra::Vector3;
use std::any::Any;
use std::sync::Arc;

impl Plant {
    /// Replaces robot, gravity and floor where given.
    pub fn set_parameters(&mut self, model: Option<Arc<Model>>, gravity: Option<Vector3<f64>>, floor: Option<Floor>) {
        if let Some(model) = model {
            self.model = model;
            self.invalidate_kinematics();
        }
        self.gravity = gravity.unwrap_or(self.gravity);
        if let Some(floor) = floor {
            self.floor = floor;
        }
    }

    /// Replaces force models, by number, and initialises the new ones.
    pub fn replace_forces(&mut self, forces: impl Iterator<Item = (usize, Box<dyn Force>)>) -> Result<(), ForceError> {
        for (i, mut force) in forces {
            let former: &dyn Any = &*self.forces[i];
            force.continue_from(former, self.state.time);
            self.forces[i] = force;
            self.init_force(i)?;
        }
        self.reserve_forces();
        Ok(())
    }
}
