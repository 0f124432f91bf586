//! Query commands: joints, base, centre of mass, zero-moment point, contact, frames, Jacobians,
//! columns, events and expectations.

use std::fmt::Write;

use nalgebra::{Isometry3, Vector3};

use crate::console::arguments::Arguments;
use crate::console::console_error::ConsoleError;
use crate::console::displayed_log::{digits, motion, state};
use crate::console::session::Session;
use crate::dynamics::{Workspace, crba, jacobian, kinematics};
use crate::geometry::roll_pitch_yaw;
use crate::log::Trajectory;
use crate::robot::LinkId;
use crate::text::pattern::matches;
use crate::text::suggest;
use crate::text::text_table::limited;

/// Result of a query.
type QueryResult<T> = Result<T, ConsoleError>;

/// Formats a vector with six decimals.
fn vector_text(v: &Vector3<f64>) -> String {
    format!("{:.6} {:.6} {:.6}", v.x, v.y, v.z)
}

impl Session {
    /// `joints [PATTERN]`
    pub(in crate::console) fn joints(&mut self, args: &mut Arguments) -> QueryResult<String> {
        let pattern = args.next().unwrap_or("*").to_owned();
        args.done()?;
        self.with_displayed_log(|_, log, tick| {
            let all = &motion(log)?.joints;
            let joints: Vec<_> = all.iter().filter(|joint| matches(&pattern, &joint.name)).collect();
            if all.is_empty() && pattern == "*" {
                return Ok("no joints\n".to_owned());
            }
            if joints.is_empty() {
                let names = all.iter().map(|joint| joint.name.as_str());
                return Err(ConsoleError::usage(format!("no joint matches `{pattern}`; {}", suggest(&pattern, names))));
            }
            let names: Vec<String> = joints.iter().map(|joint| limited(joint.name.clone())).collect();
            let width = names.iter().map(String::len).max().unwrap_or(0).max(5);
            let heads = ["position", "velocity", "desired", "effort"];
            let mut out = format!("{:width$}", "joint");
            for head in heads {
                let _ = write!(out, " {head:>12}");
            }
            out.push('\n');
            for (joint, name) in joints.into_iter().zip(names) {
                let _ = write!(out, "{name:width$}");
                let of = [&joint.position, &joint.velocity, &joint.desired_position, &joint.effort];
                for series in of {
                    let _ = write!(out, " {:>12.6}", series[tick]);
                }
                out.push('\n');
            }
            Ok(out)
        })
    }

    /// `base`
    pub(in crate::console) fn base(&mut self) -> QueryResult<String> {
        self.with_displayed_log(|_, log, tick| {
            let m = motion(log)?;
            let [roll, pitch, yaw] = roll_pitch_yaw(&m.base_orientation[tick]);
            Ok(format!(
                "position {} m\nroll pitch yaw {roll:.6} {pitch:.6} {yaw:.6} rad\nvelocity {} m/s\nangular velocity {} rad/s\n",
                vector_text(&m.base_position[tick]),
                vector_text(&m.base_linear_velocity[tick]),
                vector_text(&m.base_angular_velocity[tick])
            ))
        })
    }

    /// `com`
    pub(in crate::console) fn com(&mut self) -> QueryResult<String> {
        self.with_displayed_log(|_, log, tick| {
            let m = motion(log)?;
            Ok(format!(
                "position {} m\nvelocity {} m/s\n",
                vector_text(&m.com[tick]),
                vector_text(&m.com_velocity[tick])
            ))
        })
    }

    /// `zmp`
    pub(in crate::console) fn zmp(&mut self) -> QueryResult<String> {
        self.with_displayed_log(|_, log, tick| {
            let m = motion(log)?;
            let point =
                |p: &Option<Vector3<f64>>| p.as_ref().map_or("none".to_owned(), |p| format!("{} m", vector_text(p)));
            let mut out = format!("zero-moment point {}\n", point(&m.cop[tick]));
            let _ = writeln!(out, "point of optimal stability {}", point(&m.stable_point[tick]));
            for corner in &m.support_polygon[tick] {
                let _ = writeln!(out, "support polygon {} m", vector_text(corner));
            }
            Ok(out)
        })
    }

    /// `contact [SOLE]`
    pub(in crate::console) fn contact(&mut self, args: &mut Arguments) -> QueryResult<String> {
        let name = args.next().map(str::to_owned);
        args.done()?;
        self.with_displayed_log(|_, log, tick| {
            let soles = log.soles.as_ref();
            let soles = soles.ok_or_else(|| {
                ConsoleError::usage("the recording has no contact states: its topics lack \"contact\"")
            })?;
            let selected: Vec<_> = soles.iter().filter(|s| name.as_ref().is_none_or(|name| *name == s.name)).collect();
            if let (Some(name), true) = (&name, selected.is_empty()) {
                let names = soles.iter().map(|sole| sole.name.as_str());
                return Err(ConsoleError::usage(format!("there is no sole `{name}`; {}", suggest(name, names))));
            }
            let mut out = String::new();
            for sole in selected {
                let _ = writeln!(out, "{} {} force {} N", sole.name, sole.state[tick], vector_text(&sole.force[tick]));
                for (i, v) in sole.vertices.iter().enumerate() {
                    let held = if v.clamped[tick] { "clamped" } else { "free" };
                    let (at, force) = (vector_text(&v.position[tick]), vector_text(&v.force[tick]));
                    let _ = writeln!(out, "  vertex {i} {held} at {at} m, force {force} N");
                }
            }
            if out.is_empty() {
                out.push_str("no soles\n");
            }
            Ok(out)
        })
    }

    /// `frame LINK`
    pub(in crate::console) fn frame(&mut self, args: &mut Arguments) -> QueryResult<String> {
        let name = args.need("a link")?.to_owned();
        args.done()?;
        self.with_displayed_log(|session, log, tick| {
            let (link, pose) = session.link(&name)?;
            let ws = session.workspace(log, tick)?;
            let own = &ws.links[link.0];
            let rotation = own.rotation * pose.rotation.to_rotation_matrix();
            let position = own.origin + ws.position + own.rotation * pose.translation.vector;
            let rotation = nalgebra::Rotation3::from_matrix_unchecked(rotation);
            let [roll, pitch, yaw] = roll_pitch_yaw(&nalgebra::UnitQuaternion::from_rotation_matrix(&rotation));
            let velocity = jacobian::link_twist(&ws, link, &position);
            Ok(format!(
                "position {} m\nroll pitch yaw {roll:.6} {pitch:.6} {yaw:.6} rad\nvelocity {} m/s\nangular velocity {} rad/s\n",
                vector_text(&position),
                vector_text(&velocity.linear),
                vector_text(&velocity.angular)
            ))
        })
    }

    fn link(&self, name: &str) -> QueryResult<(LinkId, Isometry3<f64>)> {
        let model = self.model();
        let names = || crate::script::links(model).map(|(name, ..)| name).collect::<Vec<_>>();
        model.link(name).ok_or_else(|| {
            let names = names();
            ConsoleError::usage(format!("there is no link `{name}`; {}", suggest(name, names.iter().map(|n| &**n))))
        })
    }

    fn workspace(&self, log: &Trajectory, tick: usize) -> QueryResult<Workspace> {
        let model = self.model();
        let state = state(model, log, tick)?;
        let mut ws = Workspace::new(model);
        kinematics::update(model, &state, &mut ws);
        crba::mass_matrix(model, &mut ws);
        Ok(ws)
    }

    /// `jacobian com|LINK [X Y Z]`
    pub(in crate::console) fn jacobian(&mut self, args: &mut Arguments) -> QueryResult<String> {
        let name = args.need("`com` or a link")?.to_owned();
        let at = if args.peek().is_some() { args.vector("the point")? } else { [0.0; 3] };
        args.done()?;
        self.with_displayed_log(|session, log, tick| {
            let ws = session.workspace(log, tick)?;
            let model = session.model();
            let nv = model.nv();
            // A link named `com` takes precedence over the centre of mass.
            let (rows, values): (&[&str], _) = if name == "com" && model.link("com").is_none() {
                let mut values = vec![0.0; 3 * nv];
                jacobian::center_of_mass(&ws, &mut values);
                (&["vx", "vy", "vz"], values)
            } else {
                let (link, pose) = session.link(&name)?;
                let own = &ws.links[link.0];
                let point = (pose * nalgebra::Point3::from(Vector3::from(at))).coords;
                let mut values = vec![0.0; 6 * nv];
                jacobian::frame(&ws, link, &(own.origin + ws.position + own.rotation * point), &mut values);
                (&["vx", "vy", "vz", "wx", "wy", "wz"], values)
            };
            let base = ["base_vx", "base_vy", "base_vz", "base_wx", "base_wy", "base_wz"];
            let columns = base[..model.nb()].iter().copied().chain(model.joints.iter().map(|j| j.name.as_str()));
            let mut out = format!("row {}\n", columns.collect::<Vec<_>>().join(" "));
            for (r, row) in rows.iter().enumerate() {
                let _ = write!(out, "{row}");
                for k in 0..nv {
                    let _ = write!(out, " {}", digits(values[rows.len() * k + r]));
                }
                out.push('\n');
            }
            Ok(out)
        })
    }

    /// `columns [PATTERN]`
    pub(in crate::console) fn columns(&mut self, args: &mut Arguments) -> QueryResult<String> {
        let pattern = args.next().unwrap_or("*").to_owned();
        args.done()?;
        self.with_displayed_log(|_, log, _| {
            let names = crate::export::column_names(log);
            let found: String =
                names.iter().filter(|name| matches(&pattern, name)).map(|name| format!("{name}\n")).collect();
            if found.is_empty() {
                Err(ConsoleError::usage(format!("no column matches `{pattern}`")))
            } else {
                Ok(found)
            }
        })
    }

    /// `value COLUMN ...`
    pub(in crate::console) fn value(&mut self, args: &mut Arguments) -> QueryResult<String> {
        let names = args.rest();
        if names.is_empty() {
            return Err(ConsoleError::usage("a column is missing (`columns`)"));
        }
        let values = self.displayed_columns(&names)?;
        let time = "time_s".to_owned();
        let selected = |name: &String| *name != time || names.contains(&time);
        Ok(values.iter().filter(|(name, _)| selected(name)).map(|(name, value)| format!("{name} {value}\n")).collect())
    }

    /// `events [NUMBER]`
    pub(in crate::console) fn events(&mut self, args: &mut Arguments) -> QueryResult<String> {
        let limit = args.some_number().unwrap_or(20.0).max(0.0) as usize;
        args.done()?;
        if let (Some(cursor), Some(recording)) = (&self.cursor, &self.recording) {
            let past = recording.log.events.partition_point(|e| e.time <= cursor.time + 1e-9);
            let line = |(i, e): (usize, &crate::log::LoggedEvent)| {
                let text = format!("{i}: {:.6} {} {} {}", e.time, e.kind, e.subject, e.message);
                text.split_whitespace().collect::<Vec<_>>().join(" ") + "\n"
            };
            let from = past.saturating_sub(limit);
            return Ok(recording.log.events.iter().enumerate().take(past).skip(from).map(line).collect());
        }
        let events: Vec<_> = self.observer.events.iter().collect();
        Ok(Session::event_lines(&events[events.len().saturating_sub(limit)..]))
    }

    /// `expect COLUMN [min=X] [max=X] [value=X tolerance=X]`
    pub(in crate::console) fn expect(&mut self, args: &mut Arguments) -> QueryResult<String> {
        let column = args.need("a column")?.to_owned();
        let (mut min, mut max, mut value, mut tolerance, mut text) = (None, None, None, None, None);
        for (key, given) in args.assignments()? {
            let slot = match key.as_str() {
                "min" => &mut min,
                "max" => &mut max,
                "value" => &mut value,
                "tolerance" => &mut tolerance,
                _ => return Err(ConsoleError::usage(format!("`{key}` is none of min, max, value, tolerance"))),
            };
            *slot = crate::console::scenario_document::as_number(&given);
            if slot.is_none() {
                match given {
                    toml::Value::String(given) if key == "value" => text = Some(given),
                    other => return Err(ConsoleError::usage(format!("`{key}` must be a number, not {other}"))),
                }
            }
        }
        if let Some(text) = text {
            let found = self.displayed_columns(std::slice::from_ref(&column))?;
            let found = found.into_iter().find(|(name, _)| *name == column).map(|(_, value)| value).unwrap_or_default();
            let holds = found == text;
            return expectation(holds, &column, &found, &format!("= {text}"));
        }
        if value.is_some() && tolerance.is_none() {
            return Err(ConsoleError::usage("`value` of a number needs a `tolerance`"));
        }
        let limits = [min, max, value].iter().filter(|limit| limit.is_some()).count();
        if limits == 0 {
            return Err(ConsoleError::usage("`min`, `max` or `value` is missing"));
        }
        if let (Some(min), Some(max)) = (min, max)
            && min > max
        {
            return Err(ConsoleError::usage(format!("`min` = {min} is greater than `max` = {max}")));
        }
        let found = self.displayed_value(&column)?;
        let shown = found.map_or("none".to_owned(), |x| x.to_string());
        let mut conditions = Vec::new();
        let mut holds = found.is_some();
        let x = found.unwrap_or(f64::NAN);
        if let Some(min) = min {
            holds &= x >= min;
            conditions.push(format!(">= {min}"));
        }
        if let Some(max) = max {
            holds &= x <= max;
            conditions.push(format!("<= {max}"));
        }
        if let (Some(value), Some(tolerance)) = (value, tolerance) {
            holds &= (x - value).abs() <= tolerance;
            conditions.push(format!("within {tolerance} of {value}"));
        }
        expectation(holds, &column, &shown, &conditions.join(" and "))
    }
}

/// Result of an expectation.
fn expectation(holds: bool, column: &str, found: &str, condition: &str) -> QueryResult<String> {
    if holds {
        return Ok(format!("{column} {found}, {condition}\n"));
    }
    Err(ConsoleError::Expectation(format!("expected {column} {condition}, found {found}")))
}
