//! Transmissions of a robot file, `[[transmission]]`.
//!
//! What a transmission gives (rotor inertia, efforts, speeds, friction) replaces the values of the URDF and of
//! `joint_default` for its joints; a joint's own table must not give it again.

use std::ops::Range;

use toml::Spanned;

use super::adjustments::{DriveSettings, set_drive};
use super::friction::{JointFrictionLaw, SLIP_SPEED, STRIBECK_SPEED};
use super::joint_names::joint_index;
use super::model::{JointId, Model};
use super::robot_error::{FileError, RobotError};
use super::robot_file::{Friction, PerMotor, RobotFile, TransmissionEntry};
use super::transmission::Transmission;
use crate::text::source::Source;

/// Least pivot of a regular `matrix`, whose rows have 1 as their greatest entry.
const LEAST_PIVOT: f64 = 1e-9;

/// Adds the transmissions. Needs the drives.
pub(super) fn add(file: &RobotFile, source: &Source, model: &mut Model) -> Result<(), RobotError> {
    for spanned in &file.transmission {
        let entry = spanned.get_ref();
        let at = Entry { source, element: format!("transmission `{}`", entry.name), span: spanned.span() };
        if model.transmissions.iter().any(|other| other.name == entry.name) {
            let message = format!("there are two transmissions named `{}`", entry.name);
            return Err(at.fault(spanned.span(), message, "a unique name"));
        }
        let joints = at.joints(entry, model)?;
        at.check_given_once(entry, file)?;
        let ratios = at.per_motor("gear_ratio", &entry.gear_ratio, joints.len(), true)?;
        let ratios = ratios.unwrap_or_else(|| vec![1.0; joints.len()]);
        let transmission = at.transmission(entry, joints, &ratios)?;
        at.set_joints(entry, &transmission, &ratios, model)?;
        model.transmissions.push(transmission);
    }
    Ok(())
}

/// An entry of the file, for its errors.
struct Entry<'a> {
    source: &'a Source,
    element: String,
    span: Range<usize>,
}

impl Entry<'_> {
    fn fault(&self, span: Range<usize>, message: String, expected: &str) -> RobotError {
        FileError::new(self.source, span, message).element(&self.element).expected(expected).invalid()
    }

    fn bad_value(&self, span: Range<usize>, key: &str, found: impl std::fmt::Display, expected: &str) -> RobotError {
        let fault = FileError::new(self.source, span, format!("{key} of {} cannot be used", self.element));
        fault.found(found).element(&self.element).expected(expected).invalid()
    }

    /// The joints, each one that can have a motor, on one path from the root.
    fn joints(&self, entry: &TransmissionEntry, model: &Model) -> Result<Vec<JointId>, RobotError> {
        let names = entry.joints.get_ref();
        if names.is_empty() {
            let message = format!("{} has no joints", self.element);
            return Err(self.fault(entry.joints.span(), message, "the name of a joint for each motor"));
        }
        let mut joints: Vec<JointId> = Vec::with_capacity(names.len());
        for name in names {
            let joint = JointId(joint_index(name, self.source, model)?);
            let named = name.get_ref();
            if joints.contains(&joint) {
                let message = format!("{} names joint `{named}` twice", self.element);
                return Err(self.fault(name.span(), message, "each joint once"));
            }
            if let Some(other) = model.transmissions.iter().find(|other| other.joints.contains(&joint)) {
                let message = format!("joint `{named}` belongs to transmission `{}` already", other.name);
                return Err(self.fault(name.span(), message, "a joint of no other transmission"));
            }
            if let Some(coupling) = model.coupling_of(joint) {
                let leader = &model.joints[coupling.leader.0].name;
                let message = format!("joint `{named}` follows `{leader}` and has no motor");
                let expected = format!("`{leader}`, or an `armature` in the table of `{named}`");
                return Err(self.fault(name.span(), message, &expected));
            }
            let apart = joints.iter().position(|other| !on_one_path(model, *other, joint));
            if let Some(other) = apart {
                let message = format!("joints `{}` and `{named}` are on different branches", names[other].get_ref());
                return Err(self.fault(name.span(), message, "joints on one path from the root, one below the other"));
            }
            joints.push(joint);
        }
        Ok(joints)
    }

    /// Refuses values that the table of a joint gives too.
    fn check_given_once(&self, entry: &TransmissionEntry, file: &RobotFile) -> Result<(), RobotError> {
        for name in entry.joints.get_ref() {
            let Some(own) = file.joint.get(name.get_ref().as_str()) else { continue };
            let (own, table) = (own.get_ref(), own.span());
            let span_of = |value: &Option<Spanned<f64>>| value.as_ref().map(Spanned::span);
            for (key, span, is_given) in [
                ("armature", span_of(&own.armature), entry.rotor_inertia.is_some()),
                ("effort", span_of(&own.effort), entry.effort.is_some()),
                ("velocity", span_of(&own.velocity), entry.velocity.is_some()),
                ("friction", own.friction.is_some().then_some(table), entry.friction.is_some()),
            ] {
                if let Some(span) = span.filter(|_| is_given) {
                    let by = if key == "armature" { "rotor_inertia" } else { key };
                    let message = format!("{key} of joint `{}` is given by {} too", name.get_ref(), self.element);
                    let expected = format!("no `{key}` here, or no `{by}` there");
                    return Err(self.fault(span, message, &expected));
                }
            }
        }
        Ok(())
    }

    /// A number for each of `n` motors, not negative or above 0.
    fn per_motor(
        &self,
        key: &str,
        given: &Option<Spanned<PerMotor>>,
        n: usize,
        above_zero: bool,
    ) -> Result<Option<Vec<f64>>, RobotError> {
        let Some(spanned) = given else { return Ok(None) };
        let values = match spanned.get_ref() {
            PerMotor::All(value) => vec![*value; n],
            PerMotor::Each(values) => values.clone(),
        };
        if values.len() != n {
            let expected = format!("a number, or {n} of them, one per motor");
            return Err(self.bad_value(spanned.span(), key, format!("{} numbers", values.len()), &expected));
        }
        let is_valid = |x: f64| x.is_finite() && (x > 0.0 || !above_zero && x == 0.0);
        if let Some(value) = values.iter().find(|x| !is_valid(**x)) {
            let expected =
                if above_zero { "finite numbers above 0 (`matrix` has signs)" } else { "finite numbers, not negative" };
            return Err(self.bad_value(spanned.span(), key, value, expected));
        }
        Ok(Some(values))
    }

    /// `matrix` by rows, n x n, and its inverse.
    fn matrix(&self, entry: &TransmissionEntry, n: usize) -> Result<(Vec<f64>, Vec<f64>), RobotError> {
        let expected = format!("{n} rows of {n} finite numbers: a row per motor, a column per joint");
        let Some(given) = &entry.matrix else {
            if n == 1 {
                return Ok((vec![1.0], vec![1.0]));
            }
            let message = format!("{} has {n} joints but no `matrix`", self.element);
            return Err(self.fault(self.span.clone(), message, &expected));
        };
        let rows = given.get_ref();
        if let Some(row) = rows.iter().find(|row| row.len() != n) {
            return Err(self.bad_value(given.span(), "matrix", format!("a row of {}", row.len()), &expected));
        }
        if rows.len() != n {
            return Err(self.bad_value(given.span(), "matrix", format!("{} rows", rows.len()), &expected));
        }
        if let Some(x) = rows.iter().flatten().find(|x| !x.is_finite()) {
            return Err(self.bad_value(given.span(), "matrix", x, &expected));
        }
        let matrix: Vec<f64> = rows.iter().flatten().copied().collect();
        let Some(inverse) = invert(&matrix, n) else {
            let expected = "independent rows: each joint can be moved alone";
            return Err(self.bad_value(given.span(), "matrix", "a singular matrix", expected));
        };
        Ok((matrix, inverse))
    }

    fn transmission(
        &self,
        entry: &TransmissionEntry,
        joints: Vec<JointId>,
        ratios: &[f64],
    ) -> Result<Transmission, RobotError> {
        let n = joints.len();
        let (matrix, inverse) = self.matrix(entry, n)?;
        let gear: Vec<f64> = matrix.iter().enumerate().map(|(e, x)| ratios[e / n] * x).collect();
        let inverse: Vec<f64> = inverse.iter().enumerate().map(|(e, x)| x / ratios[e % n]).collect();
        if !gear.iter().chain(&inverse).all(|x| x.is_finite()) {
            let span = entry.gear_ratio.as_ref().map_or(self.span.clone(), Spanned::span);
            return Err(self.bad_value(span, "gear_ratio", "a matrix with infinite entries", "ratios of finite size"));
        }
        let rotor_inertia = self.per_motor("rotor_inertia", &entry.rotor_inertia, n, false)?;
        let rotor_inertia = rotor_inertia.unwrap_or_else(|| vec![0.0; n]);
        Ok(Transmission {
            effort_limit: self.per_motor("effort", &entry.effort, n, false)?,
            velocity_limit: self.per_motor("velocity", &entry.velocity, n, false)?,
            friction: match &entry.friction {
                None => None,
                Some(friction) => {
                    let law = |ratio: &f64| self.friction(friction, *ratio);
                    Some(ratios.iter().map(law).collect::<Result<_, _>>()?)
                }
            },
            ..Transmission::new(entry.name.clone(), joints, gear, inverse, rotor_inertia)
        })
    }

    /// The friction of a motor with this gear ratio.
    fn friction(&self, given: &Spanned<Friction>, ratio: f64) -> Result<JointFrictionLaw, RobotError> {
        let friction = given.get_ref();
        let value = |key: &str, value: &Option<Spanned<f64>>, default: f64, above_zero: bool| {
            let Some(value) = value else { return Ok(default) };
            let x = *value.get_ref();
            if x.is_finite() && (x > 0.0 || !above_zero && x == 0.0) {
                return Ok(x);
            }
            let expected = if above_zero { "a finite number above 0" } else { "a finite number, not negative" };
            Err(self.bad_value(value.span(), &format!("friction.{key}"), x, expected))
        };
        let coulomb = value("coulomb", &friction.coulomb, 0.0, false)?;
        let static_ = value("static", &friction.static_, 0.0, false)?;
        if static_ > 0.0 && static_ < coulomb {
            let span = friction.static_.as_ref().map_or(given.span(), Spanned::span);
            let expected = format!("at least friction.coulomb, {coulomb}");
            return Err(self.bad_value(span, "friction.static", static_, &expected));
        }
        Ok(JointFrictionLaw {
            coulomb,
            viscous: value("viscous", &friction.viscous, 0.0, false)?,
            static_,
            stribeck_velocity: value("stribeck_velocity", &friction.stribeck_velocity, ratio * STRIBECK_SPEED, true)?,
            slip_velocity: value("slip_velocity", &friction.slip_velocity, ratio * SLIP_SPEED, true)?,
        })
    }

    /// Replaces the settings of the joints by what the transmission gives. The joint of a single motor gets all
    /// of it; coupled joints get bounds of their efforts and speeds.
    fn set_joints(
        &self,
        entry: &TransmissionEntry,
        of: &Transmission,
        ratios: &[f64],
        model: &mut Model,
    ) -> Result<(), RobotError> {
        let n = of.number();
        if !of.is_coupled() {
            let ratio = of.gear[0].abs();
            let friction = of.friction.as_ref().map(|laws| laws[0]);
            let given = entry.friction.as_ref().map(Spanned::get_ref);
            // Defaults behind the gear keep their bits.
            let speed = |given: Option<f64>, default: f64| given.map_or(default * (ratios[0] / ratio), |v| v / ratio);
            let value = |value: &Option<Spanned<f64>>| value.as_ref().map(|v| *v.get_ref());
            let settings = DriveSettings {
                armature: entry.rotor_inertia.is_some().then(|| of.reflected[0]),
                effort: of.effort_limit.as_ref().map(|most| ratio * most[0]),
                velocity: of.velocity_limit.as_ref().map(|most| most[0] / ratio),
                coulomb: friction.map(|law| ratio * law.coulomb),
                viscous: friction.map(|law| ratio * ratio * law.viscous),
                static_friction: friction.map(|law| ratio * law.static_),
                stribeck_velocity: given.map(|given| speed(value(&given.stribeck_velocity), STRIBECK_SPEED)),
                slip_velocity: given.map(|given| speed(value(&given.slip_velocity), SLIP_SPEED)),
                ..DriveSettings::default()
            };
            let name = model.joints[of.joints[0].0].name.clone();
            return set_drive(model, &name, &settings)
                .map_err(|error| self.fault(self.span.clone(), error.to_string(), "values in range"));
        }
        for (j, id) in of.joints.iter().enumerate() {
            let joint = &mut model.joints[id.0];
            if entry.rotor_inertia.is_some() {
                joint.armature = 0.0;
            }
            if let Some(most) = &of.effort_limit {
                joint.effort_limit = most.iter().enumerate().map(|(k, most)| of.ratio(k, j).abs() * most).sum();
            }
            if let Some(most) = &of.velocity_limit {
                joint.velocity_limit =
                    most.iter().enumerate().map(|(k, most)| of.inverse[j * n + k].abs() * most).sum();
            }
            if of.friction.is_some() {
                (joint.friction, joint.damping, joint.static_friction) = (0.0, 0.0, 0.0);
            }
        }
        Ok(())
    }
}

/// Whether one of two joints is on the path from the root to the other one.
fn on_one_path(model: &Model, a: JointId, b: JointId) -> bool {
    let (above, below) = (a.0.min(b.0) + 1, a.0.max(b.0) + 1);
    let parent = |link: &usize| model.links[*link].parent.map(|parent| parent.0);
    std::iter::successors(Some(below), parent).any(|link| link == above)
}

/// Inverse of an n x n matrix by rows, by Gauss-Jordan elimination with row pivoting; none of a singular one.
fn invert(matrix: &[f64], n: usize) -> Option<Vec<f64>> {
    // Rows [a, b] of n entries each: a becomes the unit matrix, b the inverse of the scaled matrix.
    let mut rows: Vec<Vec<f64>> = Vec::with_capacity(n);
    let mut scales = Vec::with_capacity(n);
    for (k, row) in matrix.chunks(n).enumerate() {
        let scale = row.iter().map(|x| x.abs()).fold(0.0, f64::max);
        if !(scale > 0.0 && scale.is_finite()) {
            return None;
        }
        let unit = (0..n).map(|j| if j == k { 1.0 } else { 0.0 });
        rows.push(row.iter().map(|x| x / scale).chain(unit).collect());
        scales.push(scale);
    }
    for c in 0..n {
        let p = (c..n).reduce(|p, r| if rows[r][c].abs() > rows[p][c].abs() { r } else { p })?;
        rows.swap(c, p);
        let pivot = rows[c].clone();
        if pivot[c].abs() <= LEAST_PIVOT {
            return None;
        }
        for (r, row) in rows.iter_mut().enumerate() {
            let factor = row[c] / pivot[c];
            for (x, p) in row.iter_mut().zip(&pivot) {
                *x = if r == c { p / pivot[c] } else { *x - factor * p };
            }
        }
    }
    Some(rows.iter().flat_map(|row| row[n..].iter().zip(&scales).map(|(x, scale)| x / scale)).collect())
}
