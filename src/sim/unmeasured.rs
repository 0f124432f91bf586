//! Metrics of which none was measured.

use super::report::Metrics;

impl Metrics {
    /// Nothing was measured; what would have been is not a number.
    pub fn unmeasured() -> Self {
        const UNKNOWN: [f64; 3] = [f64::NAN; 3];
        Metrics {
            final_base_position: UNKNOWN,
            final_base_rpy: UNKNOWN,
            final_base_velocity: UNKNOWN,
            max_penetration_m: f64::NAN,
            max_static_creep_m: f64::NAN,
            max_projection_m: f64::NAN,
            max_lift_m: f64::NAN,
            max_cone_excess: f64::NAN,
            energy_error_j: f64::NAN,
            rms_penetration_m: f64::NAN,
            max_tension_n: f64::NAN,
            rms_tension_n: f64::NAN,
            max_signorini_nm: f64::NAN,
            rms_signorini_nm: f64::NAN,
            rms_cone_excess_n: f64::NAN,
            max_dissipation_gap_w: f64::NAN,
            rms_dissipation_gap_w: f64::NAN,
            max_creep_speed_m_per_s: f64::NAN,
            rms_creep_speed_m_per_s: f64::NAN,
            max_resultant_gap_n: f64::NAN,
            max_energy_error_j: f64::NAN,
            rms_energy_error_j: f64::NAN,
            energy_change_j: f64::NAN,
            actuator_work_j: f64::NAN,
            external_work_j: f64::NAN,
            joint_loss_j: f64::NAN,
            friction_loss_j: f64::NAN,
            impact_loss_j: f64::NAN,
            final_base_angular_velocity: UNKNOWN,
            final_com_position: UNKNOWN,
            final_com_velocity: UNKNOWN,
            final_base_shift_m: f64::NAN,
            max_flight_path_drift_m: f64::NAN,
            max_flight_spin_drift_nms: f64::NAN,
            ..Metrics::default()
        }
    }
}
