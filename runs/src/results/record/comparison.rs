//! Distances of a run from its reference run and from known truths.

use crate::metrics::{Distance, number};
use serde::{Deserialize, Serialize};

/// Result of a comparison. Errors are none without a reference, and where there was nothing to
/// compare.
///
/// Means are over the instants of the scenario's log and the run's end, up to the end of the
/// shorter run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Comparison {
    /// Key of the reference run; none without one.
    pub reference: Option<String>,
    /// Instants compared.
    pub instants: u64,
    /// The last instant, s.
    pub until_s: Option<f64>,
    /// The comparison covers both runs to their ends.
    pub whole: bool,
    /// Root mean square distance of the base's origins, m.
    #[serde(with = "number::some_real")]
    pub error_position_rms_m: Option<f64>,
    /// Root mean square difference over the joints, rad (m where a joint slides); none without
    /// joints.
    #[serde(with = "number::some_real")]
    pub error_joint_rms_rad: Option<f64>,
    /// Root mean square over the soles of the length of the force difference, N; none without
    /// soles.
    #[serde(with = "number::some_real", rename = "error_force_rms_N")]
    pub error_force_rms_n: Option<f64>,
    /// Fraction of soles and instants with equal contact states, 0 to 1; none without soles.
    pub contact_state_agreement: Option<f64>,
    /// Distance of the base's origins at the last instant, m.
    #[serde(with = "number::some_real")]
    pub error_final_position_m: Option<f64>,
    /// Angle between the base's orientations at the last instant, rad.
    #[serde(with = "number::some_real")]
    pub error_final_rotation_rad: Option<f64>,
    /// Root mean square distance of the objects' origins, m; none without objects.
    #[serde(with = "number::some_real", skip_serializing_if = "Option::is_none")]
    pub error_object_position_rms_m: Option<f64>,
    /// Root mean square difference over the joints of objects, rad (m where a joint slides); none without.
    #[serde(with = "number::some_real", skip_serializing_if = "Option::is_none")]
    pub error_object_joint_rms_rad: Option<f64>,
    /// Greatest distance of an object's origins at the last instant, m; none without objects.
    #[serde(with = "number::some_real", skip_serializing_if = "Option::is_none")]
    pub error_final_object_position_m: Option<f64>,
    /// Distances of metrics from known truths.
    pub truth: Vec<TruthError>,
}

/// A metric's distance from its truth.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TruthError {
    /// A numeric column of the summary.
    pub metric: String,
    /// `|measured - truth|` in the metric's unit; none where nothing was measured.
    #[serde(with = "number::some_real")]
    pub error: Option<f64>,
}

impl TruthError {
    /// The summary column of the distance.
    pub fn column(&self) -> String {
        format!("error_{}", self.metric)
    }
}

impl Comparison {
    /// True if there was nothing to compare with.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Its value of this distance, in the unit of its column; none where it was not compared.
    pub fn distance(&self, distance: Distance) -> Option<f64> {
        match distance {
            Distance::PositionRms => self.error_position_rms_m,
            Distance::JointRms => self.error_joint_rms_rad,
            Distance::ForceRms => self.error_force_rms_n,
            Distance::StateAgreement => self.contact_state_agreement,
            Distance::FinalPosition => self.error_final_position_m,
            Distance::FinalRotation => self.error_final_rotation_rad,
            Distance::ObjectPositionRms => self.error_object_position_rms_m,
            Distance::ObjectJointRms => self.error_object_joint_rms_rad,
            Distance::FinalObjectPosition => self.error_final_object_position_m,
        }
    }
}

/// Times of a run repeated alone on the machine, s.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Repeats {
    /// Repetitions.
    pub count: u32,
    /// Shortest wall-clock time.
    pub wall_min_s: f64,
    /// Median of the wall-clock times.
    pub wall_median_s: f64,
    /// Shortest processor time.
    #[serde(with = "number::real")]
    pub cpu_min_s: f64,
    /// Median of the processor times.
    #[serde(with = "number::real")]
    pub cpu_median_s: f64,
}
