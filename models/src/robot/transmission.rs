//! Transmissions: motors that drive joints through gears, one joint alone or several together.
//!
//! ```text
//! theta' = T q'      T = diag(gear_ratio) matrix       speeds of the motors by those of the joints
//! tau    = T^T m     m = T^-T tau                      efforts of the joints by torques of the motors
//! A      = T^T J T   J = diag(rotor_inertia)           reflected inertia, part of the mass matrix
//! ```
//!
//! T is square and regular: a motor per joint. Power is conserved, `m . theta' = tau . q'`, and so is
//! the kinetic energy of the rotors, `1/2 theta'^T J theta' = 1/2 q'^T A q'`. Like an armature,
//! a rotor has no position in space and no momentum of the body. Source: [Featherstone 2008], section 9.6.
//!
//! A transmission of one joint is a setting of that joint: armature `T^2 J`, effort `|T| m_max`,
//! speed `theta'_max / |T|`. Only coupled ones have terms of their own in a simulation.

use super::friction::JointFrictionLaw;
use super::model::JointId;

/// A transmission.
#[derive(Clone, PartialEq, Debug)]
pub struct Transmission {
    /// Name, unique among the robot's transmissions.
    pub name: String,
    /// Its joints, in the order of the columns of `gear`.
    pub joints: Vec<JointId>,
    /// T by rows: those of the motors.
    pub gear: Vec<f64>,
    /// T^-1 by rows: those of the joints.
    pub inverse: Vec<f64>,
    /// J: inertia of each rotor, kg m^2.
    pub rotor_inertia: Vec<f64>,
    /// A by rows.
    pub reflected: Vec<f64>,
    /// Greatest torque of each motor, N m; none without limits.
    pub effort_limit: Option<Vec<f64>>,
    /// Greatest speed of each motor, rad/s; none without limits.
    pub velocity_limit: Option<Vec<f64>>,
    /// Friction of each motor, N m by rad/s.
    pub friction: Option<Vec<JointFrictionLaw>>,
}

impl Transmission {
    /// Without limits and friction; `gear` and `inverse` are T and T^-1 by rows.
    pub fn new(name: String, joints: Vec<JointId>, gear: Vec<f64>, inverse: Vec<f64>, rotor_inertia: Vec<f64>) -> Self {
        let n = joints.len();
        let term = |i: usize, j: usize, k: usize| gear[k * n + i] * gear[k * n + j] * rotor_inertia[k];
        let entry = |e: usize| (0..n).map(|k| term(e / n, e % n, k)).sum();
        let reflected = (0..n * n).map(entry).collect();
        let (effort_limit, velocity_limit, friction) = (None, None, None);
        Self { name, joints, gear, inverse, rotor_inertia, reflected, effort_limit, velocity_limit, friction }
    }

    /// Number of motors, and of joints.
    #[inline]
    pub fn number(&self) -> usize {
        self.joints.len()
    }

    /// Whether it couples joints; otherwise the settings of its joint contain it.
    #[inline]
    pub fn is_coupled(&self) -> bool {
        self.joints.len() > 1
    }

    /// Entry (k, j) of T: of motor `k` and the transmission's joint `j`.
    #[inline]
    pub fn ratio(&self, k: usize, j: usize) -> f64 {
        self.gear[k * self.number() + j]
    }

    /// Speed of motor `k` at velocities `qd` of all joints: row k of `T q'`.
    pub fn motor_speed(&self, k: usize, qd: &[f64]) -> f64 {
        self.joints.iter().enumerate().map(|(j, id)| self.ratio(k, j) * qd[id.0]).sum()
    }

    /// Torque of motor `k` at efforts `tau` of all joints: row k of `T^-T tau`.
    pub fn motor_torque(&self, k: usize, tau: &[f64]) -> f64 {
        let n = self.number();
        self.joints.iter().enumerate().map(|(j, id)| self.inverse[j * n + k] * tau[id.0]).sum()
    }

    /// Effort of the transmission's joint `j` at torques of its motors: row j of `T^T m`.
    pub fn joint_effort(&self, j: usize, torques: &[f64]) -> f64 {
        torques.iter().enumerate().map(|(k, m)| self.ratio(k, j) * m).sum()
    }

    /// Calls `add` with joints and value of each entry of A on and below its diagonal.
    #[inline]
    pub fn reflected_entries(&self, mut add: impl FnMut(JointId, JointId, f64)) {
        let n = self.number();
        for (i, a) in self.joints.iter().enumerate() {
            for (j, b) in self.joints[..=i].iter().enumerate() {
                add(*a, *b, self.reflected[i * n + j]);
            }
        }
    }
}
