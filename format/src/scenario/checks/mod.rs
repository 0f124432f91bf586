//! Checks rules that involve several values of a scenario. Each error is shown at the value that
//! breaks the rule.

mod claim;
mod event;
mod force;
mod object;
mod policy;
mod search;
mod task;
mod terrain;

use super::scenario::Scenario;
use crate::geometry::simple_polygon;
use crate::math;
use crate::metrics::{METRICS, is_distance};
use crate::scenario::findings::Findings;
use crate::scenario::format::compare::CompareSpec;
use crate::scenario::format::expect::Expect;
use crate::scenario::format::floor::Friction;
use crate::scenario::format::robot::{PayloadSpec, SoleSpec, TouchingParts};
use crate::scenario::key_path::KeyPath;
use crate::text::source::Span;
use crate::text::toml_tree::Node;

/// Greatest number of delayed readings of a sensor.
const MAX_READINGS: f64 = 1e5;

/// Greatest rate of a log, Hz.
const MAX_LOG_RATE: f64 = 1e9;

/// Greatest number of entries of a list; some checks compare all pairs.
const MAX_ENTRIES: usize = 10_000;

pub(super) use claim::check_claims;
pub(super) use search::check_search;

/// Checks of a scenario whose single values are valid.
struct Check<'a> {
    root: &'a Node,
    findings: &'a mut Findings,
}

/// Host and port of an address such as `udp://127.0.0.1:4747` or `udp://[::1]:4747`.
pub fn host_and_port(backend: &str) -> Option<(&str, u16)> {
    let (host, port) = backend.strip_prefix("udp://")?.rsplit_once(':')?;
    let host = host.strip_prefix('[').map_or(Some(host), |inner| inner.strip_suffix(']'))?;
    let port = port.parse().ok().filter(|port| *port > 0)?;
    (!host.is_empty()).then_some((host, port))
}

/// Reports values that contradict each other.
pub fn check(scenario: &Scenario, root: &Node, findings: &mut Findings) {
    let mut check = Check { root, findings };
    if !check.counts(scenario) {
        return;
    }
    if scenario.robot.model.is_empty() {
        check.error("robot.model", "must name a file");
    }
    check.backend(scenario);
    check.friction("floor.friction", scenario.floor.friction);
    for (i, patch) in scenario.floor.patches.iter().enumerate() {
        check.friction(&format!("floor.patches.{i}.friction"), patch.friction);
        if let Some((corner, must)) = simple_polygon::defect(&patch.polygon) {
            let corner = corner.map_or(String::new(), |c| format!(".{c}"));
            check.error(&format!("floor.patches.{i}.polygon{corner}"), must);
        }
    }
    check.terrain(&scenario.terrain);
    check.objects(&scenario.object);
    check.soles(scenario.robot.soles.as_deref().unwrap_or_default());
    for (i, payload) in scenario.robot.payload.iter().enumerate() {
        check.payload(i, payload);
    }
    for (i, forced) in scenario.contact.forced.iter().enumerate() {
        if let Some(to) = forced.to
            && to <= forced.from
        {
            check.error(&format!("contact.forced.{i}.to"), format!("must be after `from` = {}, not {to}", forced.from));
        }
    }
    for (i, pair) in scenario.contact.pair.iter().enumerate() {
        if let Some(friction) = pair.friction {
            check.friction(&format!("contact.pair.{i}.friction"), friction);
        }
    }
    if scenario.robot.self_contact && scenario.robot.contact != TouchingParts::Bodies {
        check.error("robot.self_contact", "requires `robot.contact = \"bodies\"`: soles do not touch each other");
    }
    for (i, task) in scenario.task.iter().enumerate() {
        check.task(&format!("task.{i}"), task, scenario.duration);
    }
    for (i, force) in scenario.force.iter().enumerate() {
        check.force(&format!("force.{i}"), force, scenario.duration);
    }
    check.delays(scenario);
    check.log_rate(scenario.log.rate);
    check.stop_time(scenario.stop.at, scenario.duration);
    check.events(&scenario.event, scenario.task.len(), scenario.end());
    for (i, expect) in scenario.expect.iter().enumerate() {
        check.expect(&format!("expect.{i}"), expect);
        check.error_metric(&format!("expect.{i}.metric"), expect, scenario.compare.as_ref());
    }
    if scenario.compare.as_ref().is_some_and(|compare| *compare == CompareSpec::default()) {
        check.error("compare", "needs `reference`, `truth` or `timing_repeats`");
    }
}

impl Check<'_> {
    /// Checks the address of a remote robot. `backend_key` requires an address.
    fn backend(&mut self, scenario: &Scenario) {
        let robot = &scenario.robot;
        if let Some(backend) = &robot.backend
            && host_and_port(backend).is_none()
        {
            self.error("robot.backend", format!("must be like \"udp://127.0.0.1:4747\", not {backend:?}"));
        }
        if robot.backend.is_none() && robot.backend_key.is_some() {
            self.error("robot.backend_key", "requires `robot.backend`, which is missing");
        }
    }

    /// False, with an error, when a list has too many entries.
    fn counts(&mut self, scenario: &Scenario) -> bool {
        let lists = [
            ("task", scenario.task.len()),
            ("force", scenario.force.len()),
            ("expect", scenario.expect.len()),
            ("terrain", scenario.terrain.len()),
            ("object", scenario.object.len()),
            ("floor.patches", scenario.floor.patches.len()),
            ("contact.forced", scenario.contact.forced.len()),
            ("contact.pair", scenario.contact.pair.len()),
            ("robot.payload", scenario.robot.payload.len()),
            ("robot.soles", scenario.robot.soles.as_ref().map_or(0, Vec::len)),
        ];
        let long = lists.into_iter().find(|(_, count)| *count > MAX_ENTRIES);
        if let Some((path, count)) = long {
            self.error(path, format!("has {count} entries, at most {MAX_ENTRIES} are allowed"));
        }
        long.is_none()
    }

    /// Instants of a log have different times.
    fn log_rate(&mut self, rate: f64) {
        if rate > MAX_LOG_RATE {
            let must =
                format!("must be at most {MAX_LOG_RATE} Hz, since times of the log are whole nanoseconds, not {rate}");
            self.error("log.rate", must);
        }
    }

    /// Limits delays: readings are kept in memory until they are due.
    fn delays(&mut self, scenario: &Scenario) {
        let s = &scenario.sensors;
        let delays = [
            ("joint_position", s.joint_position.delay),
            ("joint_velocity", s.joint_velocity.delay),
            ("joint_load", s.joint_load.delay),
            ("orientation", s.orientation.delay),
            ("gyroscope", s.gyroscope.delay),
            ("accelerometer", s.accelerometer.delay),
            ("sole_force", s.sole_force.delay),
            ("sole_moment", s.sole_moment.delay),
        ];
        let rate = scenario.control.rate;
        for (sensor, delay) in delays.into_iter().filter(|(_, delay)| delay * rate > MAX_READINGS) {
            let must = format!(
                "must be at most {MAX_READINGS} ticks, that is {} s at `control.rate` = {rate}, not {delay}",
                MAX_READINGS / rate
            );
            self.error(&format!("sensors.{sensor}.delay"), must);
        }
    }

    /// Spans of the key and of the value at a path.
    fn spans(&self, path: &str) -> (Span, Span) {
        KeyPath::internal(path).locate(self.root)
    }

    fn has(&self, path: &str, key: &str) -> bool {
        KeyPath::internal(path).get(self.root).is_some_and(|node| node.get(key).is_some())
    }

    fn warning(&mut self, path: &str, message: String) {
        let span = self.spans(path).1;
        self.findings.warning(span, message, None);
    }

    /// Reports that the value at `path` violates a rule; `must` follows the path in the message.
    fn error(&mut self, path: &str, must: impl AsRef<str>) {
        let span = self.spans(path).1;
        self.findings.error(span, format!("`{path}` {}", must.as_ref()), None);
    }

    fn friction(&mut self, path: &str, friction: Friction) {
        let Friction { static_, kinetic, .. } = friction;
        if kinetic > static_ {
            self.error(
                &format!("{path}.kinetic"),
                format!("must not be greater than `static` = {static_}, not {kinetic}"),
            );
        }
    }

    fn soles(&mut self, soles: &[SoleSpec]) {
        for (i, sole) in soles.iter().enumerate() {
            if sole.polygon.is_empty() {
                self.error(&format!("robot.soles.{i}.polygon"), "must have at least one vertex");
            }
            if soles[..i].iter().any(|other| other.name == sole.name) {
                self.error(&format!("robot.soles.{i}.name"), format!("{:?} is the name of two soles", sole.name));
            }
        }
    }

    fn payload(&mut self, i: usize, payload: &PayloadSpec) {
        let path = format!("robot.payload.{i}");
        if let Some(size) = payload.size {
            if payload.inertia != [0.0; 6] {
                self.error(&format!("{path}.size"), "has no meaning with `inertia`; give one of them");
            }
            if !size.iter().all(|edge| *edge > 0.0) {
                self.error(&format!("{path}.size"), format!("must be three lengths above 0, not {size:?}"));
            }
        }
        self.inertia(&format!("robot.payload.{i}.inertia"), payload.inertia);
    }

    /// A rigid body's inertia tensor is positive semidefinite, and so is `trace/2 * 1 - inertia`,
    /// the second moment of its mass (the triangle inequality in any axes).
    fn inertia(&mut self, path: &str, [xx, yy, zz, xy, xz, yz]: [f64; 6]) {
        let half = (xx + yy + zz) / 2.0;
        let tolerance = 1e-9 * half.abs();
        if !semidefinite([half - xx, half - yy, half - zz, -xy, -xz, -yz], tolerance) {
            let must = "is not the inertia of a rigid body (order: ixx, iyy, izz, ixy, ixz, iyz; triangle inequality)";
            self.error(path, must);
        }
    }

    /// The file of the entry at `path` must have one of these endings.
    fn file(&mut self, path: &str, file: &str, endings: &[&str]) {
        let known = |e: &std::ffi::OsStr| endings.iter().any(|known| e.eq_ignore_ascii_case(known));
        if !std::path::Path::new(file).extension().is_some_and(known) {
            let endings: Vec<String> = endings.iter().map(|e| format!("`.{e}`")).collect();
            let must = format!("must name a file that ends in {}, not {file:?}", endings.join(" or "));
            self.error(&format!("{path}.file"), must);
        }
    }

    fn starts_in_time(&mut self, path: &str, start: f64, end: f64) {
        if start >= end {
            let message = format!("`{path}` starts at {start} s, but the run ends at {end} s");
            self.warning(&format!("{path}.start"), message);
        }
    }

    /// Metrics of errors require a reference run or a truth.
    fn error_metric(&mut self, path: &str, expect: &Expect, compare: Option<&CompareSpec>) {
        let reference = compare.is_some_and(|c| c.reference.is_some());
        if let Some(metric) = expect.metric.as_deref().filter(|m| is_distance(m) && !reference) {
            self.error(path, format!("names `{metric}`, which requires a reference run: `[compare]` with `reference`"));
        }
        let distance = expect.metric.as_deref().filter(|m| !METRICS.contains(m)).and_then(|m| m.strip_prefix("error_"));
        let known = |metric: &str| compare.is_some_and(|c| c.truth.keys().any(|truth| truth.0 == metric));
        if let Some(metric) = distance.filter(|metric| !known(metric)) {
            self.error(
                path,
                format!(
                    "names `error_{metric}`, which requires a truth: `[compare]` with `truth = {{ {metric} = .. }}`"
                ),
            );
        }
    }

    fn expect(&mut self, path: &str, expect: &Expect) {
        let limits = expect.min.is_some() || expect.max.is_some();
        let tolerance = expect.tolerance.or(expect.relative_tolerance);
        let message = match (&expect.metric, expect.outcome) {
            (Some(_), Some(_)) => Some("must have either `metric` or `outcome`, not both"),
            (None, None) => Some("lacks the key `metric` (or `outcome`)"),
            (None, Some(_)) if expect.value.is_some() || tolerance.is_some() || limits => {
                Some("with `outcome` takes no value and no limits")
            }
            (None, Some(_)) => None,
            (Some(_), None) => match (expect.value, tolerance) {
                (Some(_), None) => Some("has `value` and lacks the key `tolerance`"),
                (None, Some(_)) => Some("has `tolerance` and lacks the key `value`"),
                (Some(_), Some(_)) if limits => Some("must have either `value` or `min` and `max`, not both"),
                (None, None) if !limits => Some("needs `value` and `tolerance`, or `min` or `max`"),
                _ => None,
            },
        };
        if let Some(message) = message {
            self.error(path, message);
        }
        if let (Some(min), Some(max)) = (expect.min, expect.max)
            && max < min
        {
            self.error(&format!("{path}.max"), format!("must not be smaller than `min` = {min}, not {max}"));
        }
    }
}

/// True when a symmetric matrix `[xx, yy, zz, xy, xz, yz]` is positive semidefinite: no principal
/// minor is below zero.
fn semidefinite([xx, yy, zz, xy, xz, yz]: [f64; 6], tolerance: f64) -> bool {
    let (t, t2, t3) = (tolerance, tolerance * tolerance.max(xx + yy + zz), tolerance * math::powi(xx + yy + zz, 2));
    let determinant = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz);
    [xx, yy, zz].iter().all(|d| *d >= -t)
        && [xx * yy - xy * xy, xx * zz - xz * xz, yy * zz - yz * yz].iter().all(|d| *d >= -t2)
        && determinant >= -t3
}

#[cfg(test)]
mod tests {
    use super::semidefinite;

    #[test]
    fn semidefiniteness_by_known_matrices() {
        assert!(semidefinite([1.0, 1.0, 1.0, 0.0, 0.0, 0.0], 1e-12));
        assert!(semidefinite([0.0; 6], 0.0));
        // The outer product of (1, 2, 3) with itself: eigenvalues 14, 0, 0.
        assert!(semidefinite([1.0, 4.0, 9.0, 2.0, 3.0, 6.0], 1e-12));
        assert!(!semidefinite([1.0, 4.0, 9.0, 2.1, 3.0, 6.0], 1e-12));
        assert!(!semidefinite([1.0, 1.0, -0.1, 0.0, 0.0, 0.0], 1e-12));
        // Every 2x2 minor is positive, the determinant is 1 - 3 * 0.81 - 2 * 0.729 < 0.
        assert!(!semidefinite([1.0, 1.0, 1.0, 0.9, 0.9, -0.9], 1e-12));
    }
}
