//! Checks that contact method, integrator, restitution and imposed states can be combined. The
//! [`MethodDescriptor`] of each method gives its combinations:
//!
//! | | `dopri5`, `rosenbrock`, `bdf`, `auto` | `bs23` | `rk4` | `semi-implicit` | `restitution` | `forced` | `torsional`, `rolling` |
//! |---|---|---|---|---|---|---|---|
//! | `exact` | x | x | x | x | where events are located | x | x |
//! | `one-step` | x | x | x | x | | x | x |
//! | `penalty` | x | x | x | x | | | |
//! | `lcp`, `ncp` | | | | x | | | |

use crate::contact::methods::registry::{METHODS, MethodDescriptor};
use crate::robot::{Base, DriveMode, Model};
use crate::scenario::{Diagnostic, Friction, IntegratorMethod, Run, Scenario};

/// Integrators of accelerations, which locate events.
const LOCATING: &[IntegratorMethod] = &[
    IntegratorMethod::Dopri5,
    IntegratorMethod::Rosenbrock,
    IntegratorMethod::Bdf,
    IntegratorMethod::Auto,
    IntegratorMethod::Bs23,
    IntegratorMethod::Rk4,
];

/// Reports combinations that do not work, each at its position in the file.
pub(super) fn check(run: &Run, errors: &mut Vec<Diagnostic>) {
    let contact = &run.scenario.contact;
    let (method, integrator) = (contact.method.name(), run.scenario.integrator.method);
    let descriptor = contact.method.descriptor();
    if let Some(reason) = descriptor.only_semi_implicit.filter(|_| integrator != IntegratorMethod::SemiImplicit) {
        let message = format!(
            "`contact.method` = \"{method}\" {reason} and does not run with `integrator.method` = \"{}\"",
            integrator.name()
        );
        let help = format!("set `integrator.method` = {}", quoted_names(&[IntegratorMethod::SemiImplicit]));
        errors.push(run.error_at("contact.method", message, Some(help)));
    }
    check_restitution(run, errors);
    check_moments(run, errors);
    if let Some(reason) = descriptor.unforced.filter(|_| !contact.forced.is_empty()) {
        let message = format!("`contact.forced` does not work with `contact.method` = \"{method}\", which {reason}");
        let help = format!("states can be imposed with {}", with_method(|method| method.unforced.is_none()));
        errors.push(run.error_at("contact.forced", message, Some(help)));
    }
}

/// Reports torsional and rolling friction that the method does not support.
pub(super) fn check_moments(run: &Run, errors: &mut Vec<Diagnostic>) {
    let contact = &run.scenario.contact;
    let Some(reason) = contact.method.descriptor().momentless else { return };
    for (path, friction) in frictions(&run.scenario) {
        let terms = [("torsional", friction.torsional), ("rolling", friction.rolling)];
        for (term, value) in terms.into_iter().filter(|(_, value)| value.is_some_and(|value| value > 0.0)) {
            let message = format!(
                "`{path}.{term}` = {} does not work with `contact.method` = \"{}\", which {reason}",
                value.unwrap_or_default(),
                contact.method.name()
            );
            let help = format!("it works with {}", with_method(|method| method.momentless.is_none()));
            errors.push(run.error_at(&format!("{path}.{term}"), message, Some(help)));
        }
    }
}

/// All friction of a scenario, with its path.
fn frictions(scenario: &Scenario) -> Vec<(String, Friction)> {
    let mut all = vec![("floor.friction".to_owned(), scenario.floor.friction)];
    let mut add = |list: &str, each: &mut dyn Iterator<Item = Option<Friction>>| {
        let given = each.enumerate().filter_map(|(i, friction)| Some((format!("{list}.{i}.friction"), friction?)));
        all.extend(given);
    };
    add("floor.patches", &mut scenario.floor.patches.iter().map(|patch| Some(patch.friction)));
    add("terrain", &mut scenario.terrain.iter().map(|terrain| terrain.entry().friction));
    add("object", &mut scenario.object.iter().map(|object| object.entry().friction));
    add("contact.pair", &mut scenario.contact.pair.iter().map(|pair| pair.friction));
    all
}

/// Reports a restitution, of the scenario or set by an event, that method and integrator do not
/// support.
pub(super) fn check_restitution(run: &Run, errors: &mut Vec<Diagnostic>) {
    let (contact, integrator) = (&run.scenario.contact, run.scenario.integrator.method);
    let bounces = contact.method.descriptor().restitution && LOCATING.contains(&integrator);
    if contact.restitution > 0.0 && !bounces {
        let message = format!(
            "`contact.restitution` does not work with `contact.method` = \"{}\" and `integrator.method` = \"{}\"",
            contact.method.name(),
            integrator.name()
        );
        let methods = with_method(|method| method.restitution);
        let help = format!("it works with {methods} and integrator {}", quoted_names(LOCATING));
        errors.push(run.error_at("contact.restitution", message, Some(help)));
    }
}

/// Refuses soles that only kinematic joints carry: no contact force could change their motion.
pub(super) fn check_soles(run: &Run, model: &Model, errors: &mut Vec<Diagnostic>) {
    if model.base == Base::Floating {
        return;
    }
    for sole in &model.soles {
        let mut up = Some(sole.link);
        let mut free = false;
        while let Some(link) = up.filter(|link| link.0 > 0) {
            free |= model.joints[link.0 - 1].drive.mode != DriveMode::Kinematic;
            up = model.links[link.0].parent;
        }
        if !free {
            let message = format!(
                "sole `{}` moves as prescribed: every joint between it and the fixed root is kinematic, and no contact \
                 force could hold it",
                sole.name
            );
            let help = "set `robot.soles` = [] for a robot without contact".to_owned();
            errors.push(run.error_at("robot.model", message, Some(help)));
        }
    }
}

/// Names of the methods that satisfy a condition, for messages.
fn with_method(holds: impl Fn(&MethodDescriptor) -> bool) -> String {
    let names: Vec<_> = METHODS.iter().filter(|m| holds(m)).map(|m| format!("\"{}\"", m.name)).collect();
    let noun = if names.len() == 1 { "method" } else { "methods" };
    format!("{noun} {}", names.join(" and "))
}

fn quoted_names(integrators: &[IntegratorMethod]) -> String {
    integrators.iter().map(|i| format!("\"{}\"", i.name())).collect::<Vec<_>>().join(" or ")
}
