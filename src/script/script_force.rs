//! `script`: a force model written in Luau; see [`crate::script`].
//!
//! The integrator requested_data for forces at any time and state, before and after those it asked for last, and takes steps back.
//! So between corners the answer has to be a function of both alone: globals of the script stand still, no random numbers
//! are to be had, and after the start and every corner the first question is asked twice and the answers compared.

use super::fields::View;
use super::{ForceEntry, Params, RobotNames, Script, ScriptError};
use crate::force::profile::Profile;
use crate::force::{AppliedForces, Force, ForceContext, ForceError, ReportEvent};
use nalgebra::Vector3;

/// See the module.
pub struct ScriptForce {
    name: String,
    script: Script,
    named: RobotNames,
    span: Profile,
    corners: Vec<f64>,
    params: Params,
    /// Parameters that are to come, with their times, in order.
    changes: Vec<(f64, Params)>,
    changed: usize,
    effects: Vec<ForceEntry>,
    again: Vec<ForceEntry>,
    /// Is the next answer to be compared with that to the same question asked again?
    doubted: bool,
    /// Has it been initialised?
    ready: bool,
    failure: Option<ScriptError>,
}

/// When a script acts and what it is told.
pub struct Schedule {
    /// When it acts.
    pub span: Profile,
    /// Times at which its forces jump, s.
    pub corners: Vec<f64>,
    /// Parameters at the start.
    pub params: Params,
    /// Parameters that are to come, with their times, ascending.
    pub changes: Vec<(f64, Params)>,
}

impl ScriptForce {
    /// A force model called `name`.
    pub fn new(name: String, script: Script, named: RobotNames, plan: Schedule) -> Self {
        let mut corners = plan.corners;
        corners.extend(plan.span.corners());
        corners.extend(plan.changes.iter().map(|(at, _)| *at));
        ScriptForce {
            name,
            script,
            named,
            span: plan.span,
            corners,
            params: plan.params,
            changes: plan.changes,
            changed: 0,
            effects: Vec::new(),
            again: Vec::new(),
            doubted: true,
            ready: false,
            failure: None,
        }
    }

    fn ask(&mut self, view: &View) -> Result<(), ScriptError> {
        self.script.effects(view, &self.named, &mut self.effects)?;
        if std::mem::take(&mut self.doubted) {
            self.script.effects(view, &self.named, &mut self.again)?;
            if self.effects != self.again {
                let message = "`run` answered the same time and state with different forces: between corners it must be a \
                               function of both alone";
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

    fn pass(&mut self, context: &ForceContext, report: &mut ReportEvent) {
        self.doubted = true;
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
        if let Err(error) = self.ask(&view(context)) {
            self.failure = Some(error);
            return;
        }
        for effect in &self.effects {
            match effect {
                ForceEntry::Joint { joint, effort } => applied.joint(context.model, *joint, *effort),
                ForceEntry::Wrench { link, point, force, moment, axes } => {
                    let (rotation, origin) = context.frame(*link);
                    let turn = |v: &Vector3<f64>| axes.as_ref().map_or(*v, |axes| rotation * (axes * v));
                    applied.wrench(context, *link, &(origin + rotation * point), &turn(force), &turn(moment));
                }
            }
        }
    }

    fn corners(&self) -> &[f64] {
        &self.corners
    }

    fn failure(&self) -> Option<ForceError> {
        self.failure.clone().map(ForceError::new)
    }
}
