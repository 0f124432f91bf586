//! The forces that a step takes implicitly: drives, joint friction and stops
//! (`drive_stiffness.rs`), motors that drive several joints (`motor_stiffness.rs`), springs and dampers of a
//! compliant floor (`contact_stiffness.rs`) and of external forces (`external_stiffness.rs`).
//!
//! Each product of the stiff part has the accelerations and powers that a unit of a force causes, and the row of what
//! the force depends on. Rows are new at each step. Responses change slowly with the configuration and are kept for
//! some steps: W-methods need no exact derivative.

use super::Plant;
use super::contact_stiffness::ContactStiffness;
use super::drive_stiffness::DriveStiffness;
use super::energy_flows::FLOWS;
use super::external_stiffness::ExternalStiffness;
use super::motor_stiffness::MotorStiffness;
use super::stiff_products::Evaluation;
use crate::integrate::StiffPart;

/// The implicit forces of a plant.
#[derive(Clone, Debug, Default)]
pub struct ImplicitForces {
    drives: DriveStiffness,
    motors: MotorStiffness,
    contacts: ContactStiffness,
    external: ExternalStiffness,
    before: Evaluation,
    products: usize,
}

impl ImplicitForces {
    /// Finds the stiff forces at the plant's last evaluation. Returns whether others have become stiff.
    pub fn find(&mut self, plant: &Plant) -> bool {
        self.drives.find(plant) | self.motors.find(plant) | self.contacts.find(plant) | self.external.find(plant)
    }

    /// Most products that the forces found can need until others are.
    pub fn most_products(&self, plant: &Plant) -> usize {
        let of_plant = self.drives.most_products(plant) + self.contacts.most_products(plant);
        of_plant + self.motors.most_products(plant) + self.external.products() + FLOWS
    }

    /// Computes N and the responses to the forces found. Leaves the evaluation as it was.
    pub fn renew(&mut self, plant: &mut Plant, out: &mut StiffPart) {
        out.clear();
        self.before.motions.clone_from(&plant.problem.b);
        self.before.wrenches.clone_from(&plant.solution.wrench);
        self.before.accelerations.clone_from(&plant.acceleration);
        self.before.powers = plant.powers();
        self.drives.renew(plant, &self.before, out);
        self.motors.renew(plant, &self.before, out);
        self.external.renew(plant, &self.before, out);
        plant.problem.b.copy_from_slice(&self.before.motions);
        self.contacts.renew(plant, &self.before, out);
        self.products = out.rank();
        if self.contacts.products() + self.external.products() > 0 {
            plant.configuration_rates(&mut out.rates);
        }
        plant.method.respond(&plant.problem, &plant.states, &mut plant.solution);
        plant.close();
    }

    /// Writes the stiff part at the plant's last evaluation, for the forces found, with the responses last computed.
    pub fn write(&mut self, plant: &Plant, out: &mut StiffPart) {
        out.truncate(self.products);
        out.by_time.clear();
        let product = self.drives.write(plant, 0, out);
        let product = self.motors.write(plant, product, out);
        let product = self.external.write(plant, product, out);
        self.contacts.write(plant, product, out);
        self.drives.add_powers(plant, out);
        self.external.add_power(plant, out);
        self.contacts.add_powers(plant, out);
    }
}
