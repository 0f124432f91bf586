//! What can be asked of the state: joints, centre of mass, zero-moment point, contact, frames, Jacobians, columns.

use std::fmt::Write;

use nalgebra::{Isometry3, Vector3};

use crate::console::error::ConsoleError;
use crate::console::session::Session;
use crate::console::shown::{digits, motion, state};
use crate::console::words::Words;
use crate::dynamics::{Workspace, crba, jacobian, kinematics};
use crate::log::Trajectory;
use crate::robot::LinkId;
use crate::text::pattern::matches;
use crate::text::suggest;

/// What a query gives.
type Found<T> = Result<T, ConsoleError>;

fn three(v: &Vector3<f64>) -> String {
    format!("{:.6} {:.6} {:.6}", v.x, v.y, v.z)
}

impl Session {
    /// `joints [PATTERN]`
    pub(super) fn joints(&mut self, words: &mut Words) -> Found<String> {
        let pattern = words.next().unwrap_or("*").to_owned();
        words.done()?;
        self.shown(|_, log, tick| {
            let all = &motion(log)?.joints;
            let joints: Vec<_> = all.iter().filter(|joint| matches(&pattern, &joint.name)).collect();
            if all.is_empty() && pattern == "*" {
                return Ok("no joints\n".to_owned());
            }
            if joints.is_empty() {
                let names = all.iter().map(|joint| joint.name.as_str());
                return Err(ConsoleError::usage(format!("no joint is like `{pattern}`; {}", suggest(&pattern, names))));
            }
            let width = joints.iter().map(|joint| joint.name.len()).max().unwrap_or(0).max(5);
            let heads = ["position", "velocity", "desired", "effort"];
            let mut out = format!("{:width$}", "joint");
            for head in heads {
                let _ = write!(out, " {head:>12}");
            }
            out.push('\n');
            for joint in joints {
                let _ = write!(out, "{:width$}", joint.name);
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
    pub(super) fn base(&mut self) -> Found<String> {
        self.shown(|_, log, tick| {
            let m = motion(log)?;
            let (roll, pitch, yaw) = m.base_orientation[tick].euler_angles();
            Ok(format!(
                "position {} m\nroll pitch yaw {roll:.6} {pitch:.6} {yaw:.6} rad\nvelocity {} m/s\nangular velocity {} rad/s\n",
                three(&m.base_position[tick]),
                three(&m.base_linear_velocity[tick]),
                three(&m.base_angular_velocity[tick])
            ))
        })
    }

    /// `com`
    pub(super) fn com(&mut self) -> Found<String> {
        self.shown(|_, log, tick| {
            let m = motion(log)?;
            Ok(format!("position {} m\nvelocity {} m/s\n", three(&m.com[tick]), three(&m.com_velocity[tick])))
        })
    }

    /// `zmp`
    pub(super) fn zmp(&mut self) -> Found<String> {
        self.shown(|_, log, tick| {
            let m = motion(log)?;
            let point = |p: &Option<Vector3<f64>>| p.as_ref().map_or("none".to_owned(), |p| format!("{} m", three(p)));
            let mut out = format!("zero-moment point {}\n", point(&m.cop[tick]));
            let _ = writeln!(out, "point of optimal stability {}", point(&m.stable_point[tick]));
            for corner in &m.support_polygon[tick] {
                let _ = writeln!(out, "support polygon {} m", three(corner));
            }
            Ok(out)
        })
    }

    /// `contact [SOLE]`
    pub(super) fn contact(&mut self, words: &mut Words) -> Found<String> {
        let wanted = words.next().map(str::to_owned);
        words.done()?;
        self.shown(|_, log, tick| {
            let soles = log.soles.as_ref();
            let soles = soles
                .ok_or_else(|| ConsoleError::usage("the recording holds no contact: its topics lack \"contact\""))?;
            let meant: Vec<_> = soles.iter().filter(|s| wanted.as_ref().is_none_or(|name| *name == s.name)).collect();
            if let (Some(name), true) = (&wanted, meant.is_empty()) {
                let names = soles.iter().map(|sole| sole.name.as_str());
                return Err(ConsoleError::usage(format!("there is no sole `{name}`; {}", suggest(name, names))));
            }
            let mut out = String::new();
            for sole in meant {
                let _ = writeln!(out, "{} {} force {} N", sole.name, sole.state[tick], three(&sole.force[tick]));
                for (i, v) in sole.vertices.iter().enumerate() {
                    let held = if v.clamped[tick] { "clamped" } else { "free" };
                    let (at, force) = (three(&v.position[tick]), three(&v.force[tick]));
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
    pub(super) fn frame(&mut self, words: &mut Words) -> Found<String> {
        let name = words.need("a link")?.to_owned();
        words.done()?;
        self.shown(|session, log, tick| {
            let (link, pose) = session.link(&name)?;
            let ws = session.workspace(log, tick)?;
            let own = &ws.links[link.0];
            let rotation = own.rotation * pose.rotation.to_rotation_matrix();
            let position = own.origin + ws.position + own.rotation * pose.translation.vector;
            let (roll, pitch, yaw) =
                nalgebra::Rotation3::from_matrix_unchecked(rotation).euler_angles();
            let velocity = jacobian::link_twist(&ws, link, &position);
            Ok(format!(
                "position {} m\nroll pitch yaw {roll:.6} {pitch:.6} {yaw:.6} rad\nvelocity {} m/s\nangular velocity {} rad/s\n",
                three(&position),
                three(&velocity.linear),
                three(&velocity.angular)
            ))
        })
    }

    fn link(&self, name: &str) -> Found<(LinkId, Isometry3<f64>)> {
        let model = self.model();
        let names = || crate::script::links(model).map(|(name, ..)| name).collect::<Vec<_>>();
        model.link(name).ok_or_else(|| {
            let names = names();
            ConsoleError::usage(format!("there is no link `{name}`; {}", suggest(name, names.iter().map(|n| &**n))))
        })
    }

    fn workspace(&self, log: &Trajectory, tick: usize) -> Found<Workspace> {
        let model = self.model();
        let state = state(model, log, tick)?;
        let mut ws = Workspace::new(model);
        kinematics::update(model, &state, &mut ws);
        crba::mass_matrix(model, &mut ws);
        Ok(ws)
    }

    /// `jacobian com|LINK [X Y Z]`
    pub(super) fn jacobian(&mut self, words: &mut Words) -> Found<String> {
        let name = words.need("`com` or a link")?.to_owned();
        let at = if words.peek().is_some() { words.vector("the point")? } else { [0.0; 3] };
        words.done()?;
        self.shown(|session, log, tick| {
            let ws = session.workspace(log, tick)?;
            let model = session.model();
            let nv = model.nv();
            // A link of that name is meant before the centre of mass.
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
    pub(super) fn columns(&mut self, words: &mut Words) -> Found<String> {
        let pattern = words.next().unwrap_or("*").to_owned();
        words.done()?;
        self.shown(|_, log, _| {
            let names = crate::export::column_names(log);
            let found: String =
                names.iter().filter(|name| matches(&pattern, name)).map(|name| format!("{name}\n")).collect();
            if found.is_empty() {
                Err(ConsoleError::usage(format!("no column is like `{pattern}`")))
            } else {
                Ok(found)
            }
        })
    }

    /// `value COLUMN ...`
    pub(super) fn value(&mut self, words: &mut Words) -> Found<String> {
        let names = words.rest();
        if names.is_empty() {
            return Err(ConsoleError::usage("a column is missing (`columns`)"));
        }
        let values = self.columns_now(&names)?;
        let time = "time_s".to_owned();
        let asked = |name: &String| *name != time || names.contains(&time);
        Ok(values.iter().filter(|(name, _)| asked(name)).map(|(name, value)| format!("{name} {value}\n")).collect())
    }

    /// `events [NUMBER]`
    pub(super) fn events(&mut self, words: &mut Words) -> Found<String> {
        let most = words.some_number().unwrap_or(20.0).max(0.0) as usize;
        words.done()?;
        if let (Some(cursor), Some(recording)) = (&self.cursor, &self.recording) {
            let past = recording.log.events.partition_point(|e| e.time <= cursor.time + 1e-9);
            let line = |(i, e): (usize, &crate::log::LoggedEvent)| {
                let words = format!("{i}: {:.6} {} {} {}", e.time, e.kind, e.subject, e.message);
                words.split_whitespace().collect::<Vec<_>>().join(" ") + "\n"
            };
            let from = past.saturating_sub(most);
            return Ok(recording.log.events.iter().enumerate().take(past).skip(from).map(line).collect());
        }
        let events: Vec<_> = self.tap.events.iter().collect();
        Ok(Session::told(&events[events.len().saturating_sub(most)..]))
    }

    /// `expect COLUMN [min=X] [max=X] [value=X tolerance=X]`
    pub(super) fn expect(&mut self, words: &mut Words) -> Found<String> {
        let column = words.need("a column")?.to_owned();
        let (mut min, mut max, mut value, mut tolerance, mut word) = (None, None, None, None, None);
        for (key, given) in words.assignments()? {
            let slot = match key.as_str() {
                "min" => &mut min,
                "max" => &mut max,
                "value" => &mut value,
                "tolerance" => &mut tolerance,
                _ => return Err(ConsoleError::usage(format!("`{key}` is none of min, max, value, tolerance"))),
            };
            *slot = crate::console::document::as_number(&given);
            if slot.is_none() {
                match given {
                    toml::Value::String(text) if key == "value" => word = Some(text),
                    other => return Err(ConsoleError::usage(format!("`{key}` must be a number, not {other}"))),
                }
            }
        }
        if let Some(word) = word {
            let found = self.columns_now(std::slice::from_ref(&column))?;
            let found = found.into_iter().find(|(name, _)| *name == column).map(|(_, value)| value).unwrap_or_default();
            let holds = found == word;
            return judged(holds, &column, &found, &format!("= {word}"));
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
            return Err(ConsoleError::usage(format!("nothing is above {min} and below {max}")));
        }
        let found = self.column_now(&column)?;
        let shown = found.map_or("none".to_owned(), |x| x.to_string());
        let mut wanted = Vec::new();
        let mut holds = found.is_some();
        let x = found.unwrap_or(f64::NAN);
        if let Some(min) = min {
            holds &= x >= min;
            wanted.push(format!(">= {min}"));
        }
        if let Some(max) = max {
            holds &= x <= max;
            wanted.push(format!("<= {max}"));
        }
        if let (Some(value), Some(tolerance)) = (value, tolerance) {
            holds &= (x - value).abs() <= tolerance;
            wanted.push(format!("within {tolerance} of {value}"));
        }
        judged(holds, &column, &shown, &wanted.join(" and "))
    }
}

fn judged(holds: bool, column: &str, found: &str, wanted: &str) -> Found<String> {
    if holds {
        return Ok(format!("{column} {found}, {wanted}\n"));
    }
    Err(ConsoleError::Expectation(format!("expected {column} {wanted}, found {found}")))
}
