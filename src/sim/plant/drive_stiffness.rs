//! Stiffness of drives, joint friction and stops, as the stiff part of a Rosenbrock step.
//!
//! The effort of joint j depends on its own position and velocity, and of a lagging actuator on the effort z
//! that follows the servo's u ([`crate::sim::actuation::lag`]):
//!
//! ```text
//! dtau_j = -(k dq_j + d dv_j) + dz        T dz' = -(k_u dq_j + d_u dv_j) - dz
//! A = -sum_j r_j (k e_q + d e_v - e_z)^T  - sum_j e_z (k_u e_q + d_u e_v + e_z)^T / T  + N
//! ```
//!
//! k and d are the slopes of servo, friction and stop, r_j the accelerations and powers that a unit effort of the
//! joint causes with the contact states held, `M^-1 e_j` less what the contacts react; N has the rates of joint
//! positions. Slopes are difference quotients at each step. Responses change slowly with the configuration and are
//! kept for some steps: W-methods need no exact derivative.

use super::{EnergyFlows, Plant};
use crate::dynamics::reduced;
use crate::integrate::StiffPart;
use crate::robot::Model;
use crate::sim::actuation::effort_slopes::{DrivesAt, Slopes};
use crate::sim::actuation::kinematic_paths::JointMotion;

/// Test effort of a response, relative to that of 1 rad/s^2 or 1 m/s^2 of its joint alone.
const TEST: f64 = 1e-3;

/// A joint whose effort depends on its state.
#[derive(Clone, Copy, PartialEq, Debug)]
struct StiffJoint {
    mechanism: usize,
    joint: usize,
    /// Its lagging actuator, and the time constant, s.
    lag: Option<(usize, f64)>,
}

/// The joints of the stiff part, whose first products are theirs.
#[derive(Clone, Debug, Default)]
pub struct DriveStiffness {
    joints: Vec<StiffJoint>,
    present: Vec<StiffJoint>,
    slopes: Vec<[Slopes; 2]>,
    before: Evaluation,
    products: usize,
}

/// What responses are compared with.
#[derive(Clone, Debug, Default)]
struct Evaluation {
    /// Motions of the contact problem without wrenches.
    motions: Vec<f64>,
    accelerations: Vec<f64>,
    powers: EnergyFlows,
}

impl DriveStiffness {
    /// Writes the stiff part at the plant's last evaluation, with the responses of an earlier one unless `renew`, or
    /// other joints have become stiff. Leaves the evaluation as it was. Returns whether responses are new.
    pub fn update(&mut self, plant: &mut Plant, renew: bool, out: &mut StiffPart) -> bool {
        self.find(plant);
        let renew = renew || self.present != self.joints;
        if renew {
            self.joints.clone_from(&self.present);
            self.renew(plant, out);
        }
        out.truncate(self.products);
        out.by_time.clear();
        let mut product = 0;
        for (at, [servo, passive]) in self.joints.iter().zip(&self.slopes) {
            let (q, v) = plant.layout.joint(at.mechanism, at.joint);
            let rate = plant.drives_at(at.mechanism).rates[at.joint];
            let (row, column) = out.product(product);
            let [k, d] = if at.lag.is_some() { *passive } else { std::array::from_fn(|i| servo[i] + passive[i]) };
            row.clear();
            row.extend([(q, k), (v, d)]);
            column[plant.layout.controlled()] = -rate;
            // Of the servo with its command along its path.
            let motion = plant.desired_motion(at.mechanism, at.joint);
            let by_time = motion.map_or(0.0, |motion| servo[0] * motion.qd + servo[1] * motion.qdd);
            if let Some((actuator, constant)) = at.lag {
                let z = plant.layout.actuator(at.mechanism, actuator);
                row.push((z, -1.0));
                product += 1;
                let row = out.product(product).0;
                row.clear();
                row.extend([(q, servo[0] / constant), (v, servo[1] / constant), (z, 1.0 / constant)]);
            }
            if by_time != 0.0 {
                out.add_by_time(product, -at.lag.map_or(by_time, |(_, constant)| by_time / constant));
            }
            product += 1;
        }
        self.add_powers(plant, out);
        renew
    }

    /// Products of the flows of energy: the power of an effort depends on the velocity of its joint.
    fn add_powers(&self, plant: &Plant, out: &mut StiffPart) {
        let flows = plant.layout.controlled();
        for (flow, sign) in [(0, 1.0), (2, -1.0)] {
            let Some((row, column)) = out.add() else { return };
            column[flows + flow] = sign;
            for at in &self.joints {
                let drives = plant.drives_at(at.mechanism);
                let efforts = if flow == 0 { &drives.drives.efforts } else { drives.passive };
                row.push((plant.layout.joint(at.mechanism, at.joint).1, efforts[at.joint]));
            }
        }
    }

    /// The stiff joints and their slopes.
    fn find(&mut self, plant: &Plant) {
        self.present.clear();
        self.slopes.clear();
        for mechanism in 0..=plant.objects.list.len() {
            let drives = plant.drives_at(mechanism);
            for joint in 0..drives.model.nj() {
                if mechanism == 0 && plant.kinematic_paths.joints().contains(&joint) {
                    continue;
                }
                let slopes = drives.slopes(joint);
                let actuator = drives.drives.lagging.iter().position(|j| *j == joint);
                let lag = actuator.map(|i| (i, drives.model.joints[joint].lag));
                if lag.is_some() || slopes.as_flattened().iter().any(|x| *x != 0.0) {
                    self.present.push(StiffJoint { mechanism, joint, lag });
                    self.slopes.push(slopes);
                }
            }
        }
    }

    /// Products with new responses, and N.
    fn renew(&mut self, plant: &mut Plant, out: &mut StiffPart) {
        out.clear();
        self.before.motions.clone_from(&plant.problem.b);
        self.before.accelerations.clone_from(&plant.acceleration);
        self.before.powers = plant.powers();
        for at in &self.joints {
            let (q, v) = plant.layout.joint(at.mechanism, at.joint);
            out.rates.push((q, v, 1.0));
            let Some((_, column)) = out.add() else { break };
            plant.respond_to_effort(at.mechanism, at.joint, &self.before, column);
            column.iter_mut().for_each(|x| *x = -*x);
            let Some((actuator, _)) = at.lag else { continue };
            let z = plant.layout.actuator(at.mechanism, actuator);
            let Some((_, column)) = out.add() else { break };
            column[z] = -1.0;
        }
        self.products = out.rank();
        plant.problem.b.copy_from_slice(&self.before.motions);
        plant.acceleration.copy_from_slice(&plant.reduced.free);
        plant.method.respond(&plant.problem, &plant.states, &mut plant.solution);
        plant.close();
    }
}

impl Plant {
    /// Number of products that the drives of all mechanisms can need.
    pub fn drive_products(&self) -> usize {
        let of = |model: &Model| model.nj() + model.lagging().count();
        2 + of(&self.model) + self.objects.list.iter().map(|object| of(&object.model)).sum::<usize>()
    }

    fn drives_at(&self, mechanism: usize) -> DrivesAt<'_> {
        match mechanism {
            0 => DrivesAt {
                model: &self.model,
                drives: &self.drives,
                passive: &self.passive,
                stops: self.stops.as_deref(),
                joints: &self.state.joints,
                rates: &self.state.v[self.model.nb()..],
                command: self.followed_command(),
            },
            _ => self.objects.list[mechanism - 1].drives_at(),
        }
    }

    /// The motion that a joint's command follows, if it is interpolated.
    fn desired_motion(&self, mechanism: usize, joint: usize) -> Option<JointMotion> {
        let is_tracked = mechanism == 0 && self.kinematic_paths.tracked().contains(&joint);
        is_tracked.then(|| self.kinematic_paths.at(joint, self.state.time, self.within))
    }

    /// Change of accelerations and powers per unit effort of a joint, contact states held, from the evaluation
    /// `before`. Leaves the evaluation changed.
    fn respond_to_effort(&mut self, mechanism: usize, joint: usize, before: &Evaluation, out: &mut [f64]) {
        let mechanisms = self.objects.mechanisms(&self.ws);
        let ws = mechanisms.get(mechanism);
        let k = ws.nv() - self.drives_at(mechanism).model.nj() + joint;
        let effort = TEST * ws.mass.get(k, k);
        self.problem.b.copy_from_slice(&before.motions);
        self.acceleration.copy_from_slice(&self.reduced.free);
        let motions = (&mut self.acceleration[..], &mut self.problem.b[..]);
        reduced::add_effort(mechanisms, &mut self.reduced, (mechanism, k), effort, motions);
        self.method.respond(&self.problem, &self.states, &mut self.solution);
        reduced::apply(mechanisms, &mut self.reduced, &self.solution.wrench, &mut self.acceleration);
        let accelerations = out[self.layout.velocities()].iter_mut().zip(&self.acceleration).zip(&before.accelerations);
        accelerations.for_each(|((to, after), before)| *to = (after - before) / effort);
        let powers = out[self.layout.controlled()..].iter_mut().zip(self.powers().0).zip(before.powers.0);
        powers.for_each(|((to, after), before)| *to = (after - before) / effort);
    }
}
