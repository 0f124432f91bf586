//! A copy of a plant without its external forces, for checkpoints of runs.

use super::system::Plant;
use crate::contact::methods::contact_method::ContactMethod;

impl Plant {
    /// A copy of everything but the external forces, which cannot be copied. A contact solver that cannot
    /// be copied is replaced by a new one of `method`.
    pub fn copy_without_forces(&self, method: &dyn ContactMethod) -> Plant {
        // No `..rest`: the compiler names a new field that is not copied.
        Plant {
            model: self.model.clone(),
            polygons: self.polygons.clone(),
            bodies: self.bodies.clone(),
            pair_bias: self.pair_bias.clone(),
            pair_rules: self.pair_rules.clone(),
            floor_rules: self.floor_rules.clone(),
            terrain: self.terrain.clone(),
            gravity: self.gravity,
            floor: self.floor.clone(),
            layout: self.layout.clone(),
            forces: Vec::new(),
            command: self.command.clone(),
            interpolated: self.interpolated.clone(),
            stops: self.stops.clone(),
            state: self.state.clone(),
            objects: self.objects.clone(),
            kinematics_state: self.kinematics_state.clone(),
            refreshed: self.refreshed,
            ws: self.ws.clone(),
            reduced: self.reduced.clone(),
            problem: self.problem.clone(),
            states: self.states.clone(),
            solution: self.solution.clone(),
            has_point_forces: self.has_point_forces,
            step_loads: self.step_loads,
            method: self.method.copy().unwrap_or_else(|| method.solver(&self.problem)),
            directions: self.directions.clone(),
            turning: self.turning.clone(),
            fast_slips: self.fast_slips.clone(),
            regions: self.regions.clone(),
            rest: self.rest,
            step_error: self.step_error,
            within: self.within,
            tau: self.tau.clone(),
            drives: self.drives.clone(),
            passive: self.passive.clone(),
            external: self.external.clone(),
            arrows: self.arrows.clone(),
            acceleration: self.acceleration.clone(),
            implicit_diagonal: self.implicit_diagonal.clone(),
            implicit_passive: self.implicit_passive.clone(),
            implicit_external: self.implicit_external.clone(),
            dampers: self.dampers.clone(),
            impulses: self.impulses.clone(),
            kinematic_paths: self.kinematic_paths.clone(),
            prescribed_acceleration: self.prescribed_acceleration.clone(),
            scratch: self.scratch.clone(),
            multipliers: self.multipliers.clone(),
            jump: self.jump.clone(),
            evaluations: self.evaluations,
            failure: self.failure,
        }
    }
}
