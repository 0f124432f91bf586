//! The table of metrics. Each row defines a column of the summary: field, name, kind, unit, the
//! runs for which it is known, and meaning.
//!
//! A row generates the field of [`Metrics`], its entry in `run.json`, its columns in the summary in
//! this order, its name in `[[expect]]`, its initial and unmeasured values, and its line in
//! `docs/results.md`. Forms of a row:
//!
//! ```text
//! field("name"): Kind, "unit", Known, "meaning";             one column, the same name in `run.json`
//! field("name")["a", "b", "c"]: Vector, ...                  three columns; `[]`: in `run.json` only
//! = method("name"): ...                                      computed from other fields by `Metrics::method`
//! @ Source::Figure("name"): ...                              a value from outside `Metrics`
//! ```

use super::column::{ColumnSource, Cost, Distance, Known, MetricRow};
use super::kind::{AtEnd, Count, Kind, LaterCount, OptionalCount, OptionalReal, Running, Vector};
use super::number::Measure;
use serde::{Deserialize, Serialize};

/// Type of the field of a kind, explicit for the documentation.
macro_rules! value {
    (Count) => { u64 };
    (LaterCount) => { u64 };
    (AtEnd) => { f64 };
    (Running) => { f64 };
    (Vector) => { [f64; 3] };
    (OptionalReal) => { Option<f64> };
    (OptionalCount) => { Option<u64> };
}

macro_rules! metrics {
    ($(
        $($field:ident)? $(= $method:ident)? $(@ $source:ident::$figure:ident)?
        ($name:literal) $([$($column:literal),*])?: $kind:ident, $unit:literal, $known:ident, $meaning:literal;
    )*) => {
        /// Measurements of one run. Timings and comparisons are recorded separately.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        #[serde(from = "MetricsRecord", into = "MetricsRecord")]
        pub struct Metrics {
            /// Whether the robot ran in another process or machine: metrics that only a simulation
            /// knows are not measured.
            pub remote_robot: bool,
            $($(
                #[doc = $meaning]
                pub $field: value!($kind),
            )?)*
        }

        impl Metrics {
            /// Values before the first step of a simulation: counts and running maxima are 0, all
            /// others unmeasured.
            pub fn at_start() -> Self {
                Metrics { remote_robot: false, $($($field: $kind::AT_START,)?)* }
            }
        }

        impl Default for Metrics {
            /// No measurements: reals are NaN or none, counts 0.
            fn default() -> Self {
                Metrics { remote_robot: false, $($($field: $kind::UNMEASURED,)?)* }
            }
        }

        /// [`Metrics`] in `run.json`.
        #[derive(Serialize, Deserialize)]
        struct MetricsRecord {
            #[serde(default, rename = "elsewhere", skip_serializing_if = "std::ops::Not::not")]
            remote_robot: bool,
            $($(
                #[serde(rename = $name)]
                $field: <$kind as Kind>::Record,
            )?)*
        }

        impl From<MetricsRecord> for Metrics {
            fn from(record: MetricsRecord) -> Self {
                Metrics { remote_robot: record.remote_robot, $($($field: $kind::read(record.$field),)?)* }
            }
        }

        impl From<Metrics> for MetricsRecord {
            fn from(m: Metrics) -> Self {
                MetricsRecord { remote_robot: m.remote_robot, $($($field: $kind::write(m.$field),)?)* }
            }
        }

        /// The rows of the table.
        pub(super) const ROWS: &[MetricRow] = &[$(MetricRow {
            columns: row_columns(&[$name], &[$(&[$($column),*])?]),
            unit: $unit,
            meaning: $meaning,
            known: Known::$known,
            is_count: $kind::IS_COUNT,
            source: {
                $(ColumnSource::Metrics(|m, axis| $kind::measure(&m.$field, axis)))?
                $(ColumnSource::Metrics(|m, _| m.$method().map_or(Measure::Nothing, Measure::Real)))?
                $(ColumnSource::$source($source::$figure))?
            },
        }),*];
    };
}

/// The listed columns of a row, or its name if it lists none.
const fn row_columns(name: &'static [&'static str], listed: &[&'static [&'static str]]) -> &'static [&'static str] {
    if listed.is_empty() { name } else { listed[0] }
}

impl Metrics {
    /// Candidates tested per selection; none without selections. A step without an event counts as
    /// a selection that tested one candidate.
    pub fn states_tested_mean(&self) -> Option<f64> {
        let selections = self.selections + self.confirmed;
        (self.selections > 0).then(|| (self.states_tested + self.confirmed) as f64 / selections as f64)
    }
}

metrics! {
    duration_s("duration_s"): AtEnd, "s", Robot, "Simulated time reached.";
    @Cost::Wall("wall_s"): AtEnd, "s", Robot, "Wall-clock time.";
    @Cost::Cpu("cpu_s"): AtEnd, "s", Robot, "Processor time.";
    @Cost::RealTimeFactor("real_time_factor"): AtEnd, "", Robot, "Simulated time over wall-clock time.";
    steps("steps"): Count, "", Simulation, "Accepted integration steps.";
    rejected_steps("rejected_steps"): Count, "", Simulation, "Steps repeated with a smaller size.";
    evaluations("evaluations"): Count, "", Simulation, "Evaluations of the equations of motion.";
    events("events"): Count, "", Simulation, "Contact events located.";
    state_changes("state_changes"): Count, "", Simulation, "Changes of the contact state of any sole.";
    selections("selections")[]: Count, "", Simulation, "Selections of a contact state.";
    states_tested("states_tested")[]: Count, "", Simulation, "Candidate states tested, over all selections.";
    confirmed("confirmed")[]: LaterCount, "", Simulation,
        "Steps without an event, which confirm the states: one candidate each.";
    =states_tested_mean("states_tested_mean"): OptionalReal, "", Simulation, "Candidate states tested per selection.";
    states_tested_max("states_tested_max"): Count, "", Simulation, "Most candidates tested in one selection.";
    full_searches("full_searches"): Count, "", Simulation,
        "Selections of `exact` that found no valid state near the previous ones or near the solved contact problem, and \
        searched all states.";
    impacts("impacts"): Count, "", Simulation,
        "Impacts of contacts that `exact` locates. Those of other methods and of `semi-implicit` take a step and are \
        not counted.";
    jams("jams"): Count, "", Simulation,
        "Painleve configurations: sliding that no finite force continues, or whose force grows without bound. An \
        impulse in zero time ends each, to rest or to lift-off. The event `jam` names the sole, its normal \
        coefficient and the energy lost.";
    sliding_mode_s("sliding_mode_s"): Running, "s", Simulation,
        "Time in sliding modes: contact states alternated faster than steps resolve, or none was found valid, and \
        the run advanced by velocity-level steps. Events of kind `sliding-mode` mark begin and end.";
    inconsistent("inconsistent"): Count, "", Simulation,
        "Selections without a valid candidate; the least violating one was taken. 0 if every selection was valid.";
    final_base_position("final_base_position")["final_base_x", "final_base_y", "final_base_z"]: Vector, "m", Robot,
        "Origin of the root link's frame at the end, world axes.";
    final_base_rpy("final_base_rpy")["final_base_roll", "final_base_pitch", "final_base_yaw"]: Vector, "rad", Robot,
        "Its orientation, as in URDF.";
    final_base_velocity("final_base_velocity")["final_base_vx", "final_base_vy", "final_base_vz"]: Vector, "m/s", Robot,
        "Velocity of that origin.";
    max_penetration_m("max_penetration_m"): AtEnd, "m", Simulation, "Deepest sole vertex below the floor.";
    max_static_creep_m("max_static_creep_m"): Running, "m", Simulation,
        "Greatest drift of a static sole's vertex from where it was clamped; with `penalty`, its creep along the floor.";
    max_lift_m("max_lift_m"): OptionalReal, "m", Simulation,
        "Greatest height of the lowest vertex of the robot's soles; empty without soles.";
    max_cone_excess("max_cone_excess"): AtEnd, "N", Simulation,
        "Greatest tangential load beyond the friction capacity.";
    energy_error_j("energy_error_J"): AtEnd, "J", Simulation, "Error of the energy balance at the end.";
    @Distance::PositionRms("error_position_rms_m"): OptionalReal, "m", Robot,
        "Distance from the reference run in base position, see [below](#comparisons); empty without one.";
    @Distance::JointRms("error_joint_rms_rad"): OptionalReal, "rad", Robot, "The same in joint positions.";
    @Distance::ForceRms("error_force_rms_N"): OptionalReal, "N", Robot, "The same in contact forces.";
    @Distance::StateAgreement("contact_state_agreement"): OptionalReal, "", Simulation,
        "Fraction of equal contact states.";
    first_touchdown_s("first_touchdown_s"): OptionalReal, "s", Simulation,
        "First change of any sole from free; empty if never.";
    first_liftoff_s("first_liftoff_s"): OptionalReal, "s", Simulation, "First change of any sole to free.";
    first_slip_s("first_slip_s"): OptionalReal, "s", Simulation, "First change of any sole from static to sliding.";
    first_stick_s("first_stick_s"): OptionalReal, "s", Simulation, "First change of any sole from sliding to static.";
    first_fall_s("first_fall_s"): OptionalReal, "s", Robot, "When the run ended with outcome `fallen`.";
    max_projection_m("max_projection_m"): Running, "m", Simulation,
        "Greatest drift projected out of the clamped directions after a step.";
    rms_penetration_m("rms_penetration_m"): AtEnd, "m", Simulation,
        "Root mean square of the penetration. All root mean squares weigh the value at the end of each step with its \
        length.";
    max_tension_n("max_tension_N"): AtEnd, "N", Simulation, "Greatest pull of the floor on a vertex, `max(0, -N)`.";
    rms_tension_n("rms_tension_N"): AtEnd, "N", Simulation, "Its root mean square.";
    max_signorini_nm("max_signorini_Nm"): AtEnd, "N m", Simulation,
        "Greatest product of normal force and gap of a vertex, either sign (Signorini complementarity).";
    rms_signorini_nm("rms_signorini_Nm"): AtEnd, "N m", Simulation, "Its root mean square.";
    rms_cone_excess_n("rms_cone_excess_N"): AtEnd, "N", Simulation,
        "Root mean square of the greatest `max(0, |t| - mu N)`: static vertices with the static coefficient, sliding \
        ones with the kinetic; a static edge or face as a whole against its exact capacity.";
    max_dissipation_gap_w("max_dissipation_gap_W"): AtEnd, "W", Simulation,
        "Greatest `|mu N |v| + t . v|` of a sliding vertex: Coulomb friction dissipates the most power it can.";
    rms_dissipation_gap_w("rms_dissipation_gap_W"): AtEnd, "W", Simulation, "Its root mean square.";
    max_creep_speed_m_per_s("max_creep_speed_m_per_s"): AtEnd, "m/s", Simulation,
        "Greatest tangential speed of a static vertex.";
    rms_creep_speed_m_per_s("rms_creep_speed_m_per_s"): AtEnd, "m/s", Simulation, "Its root mean square.";
    max_resultant_gap_n("max_resultant_gap_N"): AtEnd, "N", Simulation,
        "Greatest difference between the sum of a sole's vertex forces and its wrench.";
    force_flickers("force_flickers"): Count, "", Simulation,
        "Times that a sole's force dropped to zero and returned while its gap stayed closed (within the distance \
        tolerance), at the ends of steps.";
    max_energy_error_j("max_energy_error_J"): AtEnd, "J", Simulation, "Greatest absolute error of the energy balance.";
    rms_energy_error_j("rms_energy_error_J"): AtEnd, "J", Simulation, "Its root mean square.";
    energy_change_j("energy_change_J"): AtEnd, "J", Simulation,
        "Kinetic and potential energy, that in the springs of `penalty` included, end less start.";
    actuator_work_j("actuator_work_J"): AtEnd, "J", Simulation, "Work of the actuators.";
    external_work_j("external_work_J"): AtEnd, "J", Simulation,
        "Work of external forces, `joint-friction` among them, and of changes by [events](scenario.md#event).";
    joint_loss_j("joint_loss_J"): AtEnd, "J", Simulation,
        "Energy given to damping, friction and stops of joints as the robot's files describe them. What the springs \
        of stops hold is among it until they return it.";
    friction_loss_j("friction_loss_J"): AtEnd, "J", Simulation,
        "Energy lost to sliding friction at the soles, from the vertex forces and velocities; with `semi-implicit`, \
        the work of all tangential impulses, those of static soles and impacts among them.";
    impact_loss_j("impact_loss_J"): AtEnd, "J", Simulation,
        "Energy lost in velocity jumps: impacts, jams, and the little motion that a new state ends; with fixed steps, \
        in normal impulses; with `penalty`, to its damping and what its springs do not hold.";
    final_base_angular_velocity("final_base_angular_velocity")
        ["final_base_wx_rad_s", "final_base_wy_rad_s", "final_base_wz_rad_s"]: Vector, "rad/s", Robot,
        "Angular velocity of the root link at the end, world axes.";
    final_com_position("final_com_position")["final_com_x_m", "final_com_y_m", "final_com_z_m"]: Vector, "m", Robot,
        "Centre of mass at the end.";
    final_com_velocity("final_com_velocity")["final_com_vx_m_s", "final_com_vy_m_s", "final_com_vz_m_s"]: Vector,
        "m/s", Robot, "Its velocity.";
    final_base_shift_m("final_base_shift_m"): AtEnd, "m", Robot,
        "Distance of the root frame's origin from its initial position.";
    final_base_sideways_m("final_base_sideways_m"): OptionalReal, "m", Robot,
        "Its distance from the straight line of its initial velocity; empty without one.";
    final_normal_force_n("final_normal_force_N"): OptionalReal, "N", Simulation,
        "Sum of the forces of floor and terrain on robot and objects along the floor's normal at the end; empty \
        without soles or when the end was not reached.";
    final_cop_offset_m("final_cop_offset_m"): OptionalReal, "m", Simulation,
        "Distance of the centre of pressure from the point of the floor below the centre of mass, along gravity: 0 \
        where only weight and floor act on a body at rest; empty in flight.";
    first_tip_s("first_tip_s"): OptionalReal, "s", Simulation,
        "First change of any sole to a smaller pattern: from face to edge or vertex, from edge to vertex.";
    last_impact_s("last_impact_s"): OptionalReal, "s", Simulation, "Last of the `impacts`; empty without one.";
    first_impact_speed_ratio("first_impact_speed_ratio"): OptionalReal, "", Simulation,
        "Square root of the kinetic energy after the first impact over that before: the restitution of a flat fall, \
        the ratio of angular velocities of a rocking body. Empty without one of the `impacts`.";
    max_flight_path_drift_m("max_flight_path_drift_m"): OptionalReal, "m", Simulation,
        "Greatest distance of the robot's centre of mass from the parabola of its flight (from the first instant \
        without contact). The effect of external forces counts. Empty for a fixed base.";
    max_flight_spin_drift_nms("max_flight_spin_drift_Nms"): OptionalReal, "N m s", Simulation,
        "Greatest change of the angular momentum about the centre of mass in a flight. Empty for a fixed base.";
    final_object_shift_m("final_object_shift_m"): OptionalReal, "m", Simulation,
        "Greatest distance of the frame of an object from its initial position at the end; empty without objects.";
    final_object_turn_rad("final_object_turn_rad"): OptionalReal, "rad", Simulation,
        "Greatest angle of an object from its initial orientation at the end.";
    final_object_speed_m_per_s("final_object_speed_m_per_s"): OptionalReal, "m/s", Simulation,
        "Greatest speed of the frame of an object at the end.";
    max_loop_error_m("max_loop_error_m"): OptionalReal, "m", Simulation,
        "Greatest error of a closed loop or coupling after a step, m or rad; empty without any.";
    max_estimate_error_m("max_estimate_error_m"): OptionalReal, "m", Simulation,
        "Greatest distance between the estimated base and the true one at a control tick; empty with estimator `truth`.";
    max_estimate_error_rad("max_estimate_error_rad"): OptionalReal, "rad", Simulation, "Greatest angle between them.";
    final_estimate_error_m("final_estimate_error_m"): OptionalReal, "m", Simulation, "The distance at the last tick.";
    final_estimate_error_rad("final_estimate_error_rad"): OptionalReal, "rad", Simulation,
        "The angle at the last tick.";
    min_self_distance_m("min_self_distance_m"): OptionalReal, "m", Robot,
        "Least distance of two watched bodies of the robot at the end of any step; below 0 the depth of their overlap; \
        empty without [`[self_collision]`](scenario.md#self_collision).";
    self_collisions("self_collisions"): OptionalCount, "", Robot, "Times that two watched bodies began to overlap.";
    self_near_s("self_near_s"): OptionalReal, "s", Robot,
        "Time in which two were nearer than `self_collision.margin`.";
    avoidance_cycles("avoidance_cycles"): OptionalCount, "", Robot, "Cycles of avoidance; empty with method 0.";
    avoidance_early_cycles("avoidance_early_cycles"): OptionalCount, "", Robot,
        "Of these, cycles between the regular ones.";
    avoidance_blocked_cycles("avoidance_blocked_cycles"): OptionalCount, "", Robot,
        "Cycles in which a predicted collision blocked a joint.";
    avoidance_tests_mean("avoidance_tests_mean"): OptionalReal, "", Robot, "Postures tested in a cycle, on average.";
    avoidance_tests_max("avoidance_tests_max"): OptionalCount, "", Robot, "Most postures tested in a cycle.";
    avoidance_held_share("avoidance_held_share"): OptionalReal, "", Robot,
        "Fraction of joints and ticks at which a method stopped the joint, or commanded it more than 1 mrad or mm away \
        from the tasks' target, 0 to 1.";
    avoidance_rms_deviation("avoidance_rms_deviation"): OptionalReal, "rad or m", Robot,
        "Root mean square over joints and ticks of the commanded position less the tasks' target.";
    avoidance_max_deviation("avoidance_max_deviation"): OptionalReal, "rad or m", Robot, "Greatest such difference.";
    @Distance::FinalPosition("error_final_position_m"): OptionalReal, "m", Robot,
        "Distance from the reference run in base position at the last instant that both reached.";
    @Distance::FinalRotation("error_final_rotation_rad"): OptionalReal, "rad", Robot, "The same in base orientation.";
    @Distance::ObjectPositionRms("error_object_position_rms_m"): OptionalReal, "m", Simulation,
        "Distance from the reference run in the positions of objects; empty without objects.";
    @Distance::ObjectJointRms("error_object_joint_rms_rad"): OptionalReal, "rad", Simulation,
        "The same in joint positions of objects.";
    @Distance::FinalObjectPosition("error_final_object_position_m"): OptionalReal, "m", Simulation,
        "Greatest distance of an object from the reference run at the last instant that both reached.";
    @Cost::RepeatedWallMin("timing_wall_min_s"): OptionalReal, "s", Robot,
        "Shortest wall-clock time of the repetitions by `compare.timing_repeats`; empty without.";
    @Cost::RepeatedWallMedian("timing_wall_median_s"): OptionalReal, "s", Robot, "Their median.";
    @Cost::RepeatedCpuMin("timing_cpu_min_s"): OptionalReal, "s", Robot, "Shortest processor time of the repetitions.";
    @Cost::RepeatedCpuMedian("timing_cpu_median_s"): OptionalReal, "s", Robot, "Their median.";
    @Cost::Avoidance("avoidance_cpu_s"): OptionalReal, "s", Robot, "Processor time of avoidance.";
    @Cost::AvoidanceCycles("avoidance_cycles_cpu_s"): OptionalReal, "s", Robot, "Of this, in ticks with a cycle.";
}
