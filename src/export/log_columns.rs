//! The columns of a log: each name with its unit, and the value at any instant.

use crate::export::data_table::Values;
use crate::export::log_instants::LogInstant;
use crate::geometry::roll_pitch_yaw;
use crate::log::messages::Residual;
use crate::log::{EstimateSeries, JointSeries, Motion, ObjectSeries, SelfCollisionSeries, SoleSeries, Trajectory};
use nalgebra::{UnitQuaternion, Vector3};

/// Name of the first column.
pub(super) const TIME: &str = "time_s";

/// A column and the source of its values.
pub(super) struct LogColumn<'a> {
    pub name: String,
    get: Get<'a>,
}

enum Get<'a> {
    /// A number; `None` where it does not exist.
    Real(Box<dyn Fn(LogInstant) -> Option<f64> + 'a>),
    Text(&'a [String]),
    Flag(&'a [bool]),
}

impl LogColumn<'_> {
    /// The values at these instants.
    pub fn values(&self, instants: &[LogInstant]) -> Values {
        match &self.get {
            Get::Real(get) => Values::Real(instants.iter().map(|s| get(*s)).collect()),
            Get::Text(series) => Values::Text(instants.iter().map(|s| series[s.before].clone()).collect()),
            Get::Flag(series) => Values::Flag(instants.iter().map(|s| series[s.before]).collect()),
        }
    }
}

/// Reads one number of the residual.
type ResidualPart = fn(&Residual) -> f64;

/// Collects the columns.
#[derive(Default)]
struct Columns<'a>(Vec<LogColumn<'a>>);

/// All columns but the time: motion of base and centre of mass, joints, soles with their vertices,
/// objects, residuals, energies.
pub(super) fn of(log: &Trajectory) -> Vec<LogColumn<'_>> {
    let mut all = Columns::default();
    if let Some(motion) = &log.motion {
        all.motion(motion);
        motion.joints.iter().for_each(|joint| all.joint(joint));
    }
    log.soles.iter().flatten().for_each(|sole| all.sole(sole));
    log.objects.iter().for_each(|object| all.object(object));
    if let Some(residuals) = &log.residuals {
        all.residuals(residuals);
    }
    if let Some(estimate) = &log.estimate {
        all.estimate(estimate);
    }
    if let Some(series) = &log.self_collision {
        all.self_collision(series);
    }
    all.0
}

impl<'a> Columns<'a> {
    fn real(&mut self, name: impl Into<String>, get: impl Fn(LogInstant) -> Option<f64> + 'a) {
        self.0.push(LogColumn { name: name.into(), get: Get::Real(Box::new(get)) });
    }

    fn scalar(&mut self, name: impl Into<String>, series: &'a [f64]) {
        self.real(name, |s| Some(s.interpolate(series[s.before], series[s.after])));
    }

    /// Adds three columns: `PREFIXx_UNIT`, y, z.
    fn vector(&mut self, prefix: &str, unit: &str, series: &'a [Vector3<f64>]) {
        for (k, axis) in ["x", "y", "z"].into_iter().enumerate() {
            let name = format!("{prefix}{axis}_{unit}");
            self.real(name, move |s| Some(s.interpolate(series[s.before][k], series[s.after][k])));
        }
    }

    /// Adds three columns: `PREFIXroll_rad`, pitch, yaw.
    fn angles(&mut self, prefix: &str, series: &'a [UnitQuaternion<f64>]) {
        for (k, name) in ["roll", "pitch", "yaw"].into_iter().enumerate() {
            self.real(format!("{prefix}{name}_rad"), move |s| {
                let orientation = s.interpolate_orientation(&series[s.before], &series[s.after]);
                Some(roll_pitch_yaw(&orientation)[k])
            });
        }
    }

    /// Adds three columns of a point that may be absent. It is interpolated if both ticks have it;
    /// otherwise the tick before counts.
    fn point(&mut self, prefix: &str, series: &'a [Option<Vector3<f64>>]) {
        for (k, axis) in ["x", "y", "z"].into_iter().enumerate() {
            self.real(format!("{prefix}{axis}_m"), move |s| {
                let before = series[s.before]?[k];
                Some(series[s.after].map_or(before, |after| s.interpolate(before, after[k])))
            });
        }
    }

    fn motion(&mut self, m: &'a Motion) {
        self.vector("base_", "m", &m.base_position);
        let orientation =
            |s: LogInstant| s.interpolate_orientation(&m.base_orientation[s.before], &m.base_orientation[s.after]);
        let part = |q: UnitQuaternion<f64>, k: usize| [q.w, q.i, q.j, q.k][k];
        for (k, name) in ["base_qw", "base_qx", "base_qy", "base_qz"].into_iter().enumerate() {
            self.real(name, move |s| Some(part(orientation(s), k)));
        }
        self.angles("base_", &m.base_orientation);
        self.vector("base_v", "m_s", &m.base_linear_velocity);
        self.vector("base_w", "rad_s", &m.base_angular_velocity);
        self.vector("com_", "m", &m.com);
        self.vector("com_v", "m_s", &m.com_velocity);
        self.point("cop_", &m.cop);
        self.point("stable_point_", &m.stable_point);
        for point in &m.points {
            self.point(&format!("point.{}.", point.name), &point.position);
        }
    }

    fn joint(&mut self, j: &'a JointSeries) {
        let (position, effort) = if j.prismatic { ("m", "N") } else { ("rad", "Nm") };
        let name = |what: &str, unit: &str| format!("joint.{}.{what}_{unit}", j.name);
        self.scalar(name("position", position), &j.position);
        self.scalar(name("velocity", &format!("{position}_s")), &j.velocity);
        self.scalar(name("desired_position", position), &j.desired_position);
        self.scalar(name("desired_velocity", &format!("{position}_s")), &j.desired_velocity);
        self.scalar(name("effort", effort), &j.effort);
        self.scalar(name("desired_effort", effort), &j.desired_effort);
    }

    fn sole(&mut self, sole: &'a SoleSeries) {
        let of_sole = format!("{}.{}", if sole.is_link { "link" } else { "sole" }, sole.name);
        self.0.push(LogColumn { name: format!("{of_sole}.state"), get: Get::Text(&sole.state) });
        self.vector(&format!("{of_sole}.force_"), "N", &sole.force);
        for (v, vertex) in sole.vertices.iter().enumerate() {
            let of_vertex = format!("{of_sole}.vertex{v}");
            self.0.push(LogColumn { name: format!("{of_vertex}.clamped"), get: Get::Flag(&vertex.clamped) });
            self.vector(&format!("{of_vertex}."), "m", &vertex.position);
            self.vector(&format!("{of_vertex}.v"), "m_s", &vertex.velocity);
            self.vector(&format!("{of_vertex}.force_"), "N", &vertex.force);
        }
    }

    fn object(&mut self, object: &'a ObjectSeries) {
        let of_object = format!("object.{}.", object.name);
        self.vector(&of_object, "m", &object.position);
        self.angles(&of_object, &object.orientation);
    }

    fn estimate(&mut self, e: &'a EstimateSeries) {
        self.scalar("estimate.tick_s", &e.tick);
        self.vector("estimate.base_", "m", &e.base_position);
        self.angles("estimate.base_", &e.base_orientation);
        self.vector("estimate.base_v", "m_s", &e.base_linear_velocity);
        self.vector("estimate.base_w", "rad_s", &e.base_angular_velocity);
        self.vector("sensor.gyroscope_", "rad_s", &e.angular_velocity);
        self.vector("sensor.accelerometer_", "m_s2", &e.specific_force);
        for j in &e.joints {
            let (position, effort) = if j.prismatic { ("m", "N") } else { ("rad", "Nm") };
            let name = |what: &str, unit: &str| format!("sensor.joint.{}.{what}_{unit}", j.name);
            self.scalar(name("position", position), &j.position);
            self.scalar(name("velocity", &format!("{position}_s")), &j.velocity);
            self.scalar(name("load", effort), &j.load);
        }
        for sole in &e.soles {
            let of_sole = format!("sensor.sole.{}", sole.name);
            self.vector(&format!("{of_sole}.force_"), "N", &sole.force);
            self.vector(&format!("{of_sole}.moment_"), "Nm", &sole.moment);
            if let Some(held) = &sole.held {
                self.0.push(LogColumn { name: format!("{of_sole}.static"), get: Get::Flag(held) });
            }
        }
    }

    fn self_collision(&mut self, series: &'a SelfCollisionSeries) {
        self.scalar("self_collision.distance_m", &series.distance);
        self.0.push(LogColumn { name: "self_collision.pair".into(), get: Get::Text(&series.pair) });
        if series.desired.is_empty() {
            return;
        }
        let at_tick = |values: &'a [f64]| move |s: LogInstant| Some(values[s.before]);
        self.real("self_collision.tests", at_tick(&series.tests));
        self.real("self_collision.frozen_joints", at_tick(&series.frozen));
        for (name, prismatic, desired) in &series.desired {
            let unit = if *prismatic { "m" } else { "rad" };
            self.scalar(format!("joint.{name}.wanted_position_{unit}"), desired);
        }
    }

    fn residuals(&mut self, all: &'a [Residual]) {
        let parts: [(&str, ResidualPart); 14] = [
            ("residual.penetration_m", |r| r.penetration),
            ("residual.tension_N", |r| r.tension),
            ("residual.signorini_Nm", |r| r.signorini),
            ("residual.cone_excess_N", |r| r.cone_excess),
            ("residual.dissipation_gap_W", |r| r.dissipation_gap),
            ("residual.creep_speed_m_s", |r| r.creep_speed),
            ("residual.resultant_gap_N", |r| r.resultant_gap),
            ("energy.change_J", |r| r.energy_change),
            ("energy.actuator_work_J", |r| r.actuator_work),
            ("energy.external_work_J", |r| r.external_work),
            ("energy.joint_loss_J", |r| r.joint_loss),
            ("energy.friction_loss_J", |r| r.friction_loss),
            ("energy.impact_loss_J", |r| r.impact_loss),
            ("energy.error_J", |r| r.energy_error),
        ];
        for (name, get) in parts {
            self.real(name, move |s| Some(s.interpolate(get(&all[s.before]), get(&all[s.after]))));
        }
    }
}
