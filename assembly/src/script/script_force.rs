//! `script`: a force model written in Luau; see [`crate::script`].
//!
//! The integrator evaluates forces at any time and state, in any order, and repeats rejected steps.
//! Between corners the result must therefore be a function of time and state alone: globals of the
//! script are read-only, and random numbers are not available. The first evaluation after the start
//! and after each corner is made twice, and the results are compared.

use super::fields::View;
use super::{ForceEntry, Params, RobotNames, Script, ScriptError};
use crate::force::profile::Profile;
use crate::force::{AppliedForces, Force, ForceContext, ForceError, ReportEvent};
use nalgebra::Vector3;

/// Force model of a script.
pub struct ScriptForce {
    name: String,
    script: Script,
    names: RobotNames,
    span: Profile,
    corners: Vec<f64>,
    params: Params,
    /// Parameter changes with their times, in order.
    changes: Vec<(f64, Params)>,
    /// Number of changes applied so far.
    changed: usize,
    forces: Vec<ForceEntry>,
    repeated: Vec<ForceEntry>,
    /// True if the next evaluation is made twice for comparison.
    check_next: bool,
    /// True once it is initialised.
    ready: bool,
    failure: Option<ScriptError>,
}

/// Times and parameters of a script.
pub struct Schedule {
    /// Time span in which it acts.
    pub span: Profile,
    /// Times at which its forces are discontinuous, s.
    pub corners: Vec<f64>,
    /// Parameters at the start.
    pub params: Params,
    /// Parameter changes with their times, ascending.
    pub changes: Vec<(f64, Params)>,
}

impl ScriptForce {
    /// A force model called `name`.
    pub fn new(name: String, script: Script, names: RobotNames, schedule: Schedule) -> Self {
        let mut corners = schedule.corners;
        corners.extend(schedule.span.corners());
        corners.extend(schedule.changes.iter().map(|(at, _)| *at));
        ScriptForce {
            name,
            script,
            names,
            span: schedule.span,
            corners,
            params: schedule.params,
            changes: schedule.changes,
            changed: 0,
            forces: Vec::new(),
            repeated: Vec::new(),
            check_next: true,
            ready: false,
            failure: None,
        }
    }

    fn evaluate_script(&mut self, view: &View) -> Result<(), ScriptError> {
        self.script.run_force(view, &self.names, &mut self.forces)?;
        if std::mem::take(&mut self.check_next) {
            self.script.run_force(view, &self.names, &mut self.repeated)?;
            if self.forces != self.repeated {
                let message = "`run` returned different forces for the same time and state: between corners it must \
                               be a function of both alone";
                return Err(ScriptError::new(&self.name, None, message));
            }
        }
        Ok(())
    }
}

fn view<'a>(context: &'a ForceContext) -> View<'a> {
    View {
        time: context.time,
        model: context.model,
        gravity: context.gravity,
        state: context.state,
        kinematics: context.kinematics,
        task: None,
    }
}

impl Force for ScriptForce {
    fn init(&mut self, context: &ForceContext) -> Result<(), ForceError> {
        let continues = self.script.init(&view(context), &self.params);
        self.ready = true;
        continues.map(|_| ()).map_err(ForceError::new)
    }

    fn on_corner(&mut self, context: &ForceContext, report: &mut ReportEvent) {
        self.check_next = true;
        while let Some((_, params)) = self.changes.get(self.changed).filter(|(at, _)| *at <= context.time) {
            self.changed += 1;
            report("force", &self.name, "changes".into());
            if let Err(error) = self.script.change(&view(context), params) {
                self.failure.get_or_insert(error);
            }
        }
    }

    fn evaluate(&mut self, context: &ForceContext, applied: &mut AppliedForces) {
        if !self.ready || self.failure.is_some() || self.span.factor(context.time, context.within) == 0.0 {
            return;
        }
        if let Err(error) = self.evaluate_script(&view(context)) {
            self.failure = Some(error);
            return;
        }
        for force in &self.forces {
            match force {
                ForceEntry::Joint { joint, effort } => applied.joint(context.model, *joint, *effort),
                ForceEntry::Wrench { link, point, force, moment, axes } => {
                    let (rotation, origin) = context.frame(*link);
                    let to_world = |v: &Vector3<f64>| axes.as_ref().map_or(*v, |axes| rotation * (axes * v));
                    applied.wrench(context, *link, &(origin + rotation * point), &to_world(force), &to_world(moment));
                }
            }
        }
    }

    fn corners(&self) -> &[f64] {
        &self.corners
    }

    fn has_memory(&self) -> bool {
        true
    }

    fn failure(&self) -> Option<ForceError> {
        self.failure.clone().map(ForceError::new)
    }
}
