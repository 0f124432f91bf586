//! Finds parameters of contact methods that no run of a file uses.

use super::run::Run;
use crate::contact::methods::registry::METHODS;
use crate::text::diagnostic::{Diagnostic, Diagnostics, Severity};

/// Parameters of contact methods that no run of the file uses.
#[derive(Default)]
pub(super) struct UnusedParameters {
    used: Vec<&'static str>,
    /// The warning about each method, from the first run that gives its parameters.
    warnings: Vec<(&'static str, Diagnostic)>,
}

impl UnusedParameters {
    pub fn check(&mut self, run: &Run) {
        let contact = &run.scenario.contact;
        let used = contact.method.name();
        if !self.used.contains(&used) {
            self.used.push(used);
        }
        let parameters = contact.parameters();
        for name in METHODS.iter().filter(|method| (method.is_configured)(&parameters)).map(|method| method.name) {
            if self.warnings.iter().any(|(known, _)| *known == name) {
                continue;
            }
            let message = format!("`contact.{name}` has no effect: `contact.method` is \"{used}\"");
            let warning = run.diagnose(&format!("contact.{name}"), Severity::Warning, true, message, None);
            self.warnings.push((name, warning));
        }
    }

    /// Adds those of later runs.
    pub fn append(&mut self, later: UnusedParameters) {
        for used in later.used {
            if !self.used.contains(&used) {
                self.used.push(used);
            }
        }
        for (name, warning) in later.warnings {
            if !self.warnings.iter().any(|(known, _)| *known == name) {
                self.warnings.push((name, warning));
            }
        }
    }

    pub fn warnings(mut self) -> Diagnostics {
        self.warnings.retain(|(name, _)| !self.used.contains(name));
        self.warnings.sort_by_key(|(name, _)| METHODS.iter().position(|method| method.name == *name));
        Diagnostics(self.warnings.into_iter().map(|(_, warning)| warning).collect())
    }
}
