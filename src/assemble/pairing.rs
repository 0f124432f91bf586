//! Compatibility of contact methods, integrators, restitution and forced states.
//!
//! | | `dopri5` | `bs23` | `rk4` | `semi-implicit` | `restitution` | `forced` |
//! |---|---|---|---|---|---|---|
//! | `exact` | x | x | x | x | where events are located | x |
//! | `one-step` | x | x | x | x | | x |
//! | `penalty` | x | x | x | x | | |
//! | `lcp`, `ncp` | | | | x | | |

use crate::robot::{Base, DriveMode, Model};
use crate::scenario::{ContactMethod, Diagnostic, IntegratorMethod, Run};

/// All integrators.
const ALL: &[IntegratorMethod] =
    &[IntegratorMethod::Dopri5, IntegratorMethod::Bs23, IntegratorMethod::Rk4, IntegratorMethod::SemiImplicit];
/// Those that integrate accelerations.
const EXPLICIT: &[IntegratorMethod] = &[IntegratorMethod::Dopri5, IntegratorMethod::Bs23, IntegratorMethod::Rk4];

/// The integrators with which a method runs, and the reason if not with all.
fn integrators(method: ContactMethod) -> (&'static [IntegratorMethod], &'static str) {
    match method {
        ContactMethod::Exact | ContactMethod::OneStep | ContactMethod::Penalty => (ALL, ""),
        ContactMethod::Lcp | ContactMethod::Ncp => {
            (&[IntegratorMethod::SemiImplicit], "knows only impulses over a fixed step")
        }
    }
}

/// The integrators with which a method treats impacts as separate events and so supports restitution.
fn bouncing(method: ContactMethod) -> &'static [IntegratorMethod] {
    if method == ContactMethod::Exact { EXPLICIT } else { &[] }
}

/// Why a method cannot have forced states, if it cannot.
fn unforced(method: ContactMethod) -> Option<&'static str> {
    match method {
        ContactMethod::Exact | ContactMethod::OneStep => None,
        ContactMethod::Penalty => Some("clamps no vertices"),
        ContactMethod::Lcp | ContactMethod::Ncp => Some("chooses no states"),
    }
}

/// Reports combinations that do not work, each at its position in the file.
pub(super) fn check(run: &Run, errors: &mut Vec<Diagnostic>) {
    let contact = &run.scenario.contact;
    let (method, integrator) = (contact.method.name(), run.scenario.integrator.method);
    let (works, reason) = integrators(contact.method);
    if !works.contains(&integrator) {
        let message = format!(
            "`contact.method` = \"{method}\" {reason} and does not run with `integrator.method` = \"{}\"",
            integrator.name()
        );
        let help = format!("set `integrator.method` = {}", named(works));
        errors.push(run.error_at("contact.method", message, Some(help)));
    }
    check_restitution(run, errors);
    if let Some(reason) = unforced(contact.method).filter(|_| !contact.forced.is_empty()) {
        let message = format!("`contact.forced` does not work with `contact.method` = \"{method}\", which {reason}");
        let help = "methods \"exact\" and \"one-step\" can have forced states".to_owned();
        errors.push(run.error_at("contact.forced", message, Some(help)));
    }
}

/// Reports a restitution that method and integrator do not support, of the scenario or of an event.
pub(super) fn check_restitution(run: &Run, errors: &mut Vec<Diagnostic>) {
    let (contact, integrator) = (&run.scenario.contact, run.scenario.integrator.method);
    if contact.restitution > 0.0 && !bouncing(contact.method).contains(&integrator) {
        let message = format!(
            "`contact.restitution` does not work with `contact.method` = \"{}\" and `integrator.method` = \"{}\"",
            contact.method.name(),
            integrator.name()
        );
        let help = format!("it works with method \"exact\" and integrator {}", named(EXPLICIT));
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

fn named(integrators: &[IntegratorMethod]) -> String {
    integrators.iter().map(|i| format!("\"{}\"", i.name())).collect::<Vec<_>>().join(" or ")
}
