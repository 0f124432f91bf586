//! Units of columns: those in their names, and those the contract names without.

/// Units by the ends of names, longer ends first.
const ENDS: [(&str, &str); 14] = [
    ("_m_per_s", "m/s"),
    ("_rad_s", "rad/s"),
    ("_m_s", "m/s"),
    ("_Nms", "N m s"),
    ("_Nm", "N m"),
    ("_rad", "rad"),
    ("_vx", "m/s"),
    ("_vy", "m/s"),
    ("_vz", "m/s"),
    ("_m", "m"),
    ("_s", "s"),
    ("_N", "N"),
    ("_J", "J"),
    ("_W", "W"),
];

/// Units of names that do not say them.
const NAMES: [(&str, &str); 7] = [
    ("final_base_x", "m"),
    ("final_base_y", "m"),
    ("final_base_z", "m"),
    ("final_base_roll", "rad"),
    ("final_base_pitch", "rad"),
    ("final_base_yaw", "rad"),
    ("max_cone_excess", "N"),
];

/// Does the name of a column say its unit?
pub(super) fn is_said(column: &str) -> bool {
    let velocity = ["_vx", "_vy", "_vz"];
    ENDS.iter().any(|(end, _)| column.ends_with(end) && !velocity.contains(end))
}

/// The unit of a column, or of the error in one; empty for counts and ratios.
pub(super) fn unit(column: &str) -> &'static str {
    let measured = column.strip_prefix("error_").unwrap_or(column);
    let named = NAMES.iter().find(|(name, _)| *name == measured);
    named.or_else(|| ENDS.iter().find(|(end, _)| column.ends_with(end))).map_or("", |(_, unit)| unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_those_of_the_names() {
        let columns = [
            ("error_position_rms_m", "m"),
            ("error_final_base_x", "m"),
            ("error_final_base_vz", "m/s"),
            ("error_force_rms_N", "N"),
            ("error_final_base_yaw", "rad"),
            ("max_creep_speed_m_per_s", "m/s"),
            ("final_com_vx_m_s", "m/s"),
            ("final_base_wx_rad_s", "rad/s"),
            ("max_flight_spin_drift_Nms", "N m s"),
            ("max_signorini_Nm", "N m"),
            ("rms_dissipation_gap_W", "W"),
            ("max_cone_excess", "N"),
            ("energy_error_J", "J"),
            ("force_flickers", ""),
            ("error_impacts", ""),
            ("first_impact_speed_ratio", ""),
        ];
        for (column, expected) in columns {
            assert_eq!(unit(column), expected, "{column}");
        }
    }
}
