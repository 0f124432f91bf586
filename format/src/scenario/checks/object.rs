//! Rules for `[[object]]`.

use super::Check;
use crate::scenario::format::object::ObjectSpec;
use std::collections::HashMap;

/// Greatest number of objects: each has a state, and each pair may touch.
const MAX_OBJECTS: usize = 200;

/// Least and greatest mass, kg.
const MASSES: [f64; 2] = [1e-9, 1e9];

impl Check<'_> {
    /// Checks all objects.
    pub(super) fn objects(&mut self, objects: &[ObjectSpec]) {
        if objects.len() > MAX_OBJECTS {
            self.error("object", format!("must have at most {MAX_OBJECTS} entries, not {}", objects.len()));
        }
        let mut names = HashMap::new();
        for (i, spec) in objects.iter().enumerate() {
            let path = format!("object.{i}");
            let (entry, name) = (spec.entry(), spec.name(i));
            self.name("object", i, (name, entry.name.is_some()), &mut names);
            self.place(&path, entry.position, entry.friction);
            let mass = match spec {
                ObjectSpec::Box(spec) => {
                    self.lengths(&format!("{path}.size"), &spec.size);
                    spec.mass
                }
                ObjectSpec::Sphere(spec) => {
                    self.length(&format!("{path}.radius"), spec.radius);
                    spec.mass
                }
                ObjectSpec::Capsule(spec) => {
                    self.length(&format!("{path}.radius"), spec.radius);
                    self.length(&format!("{path}.length"), spec.length);
                    spec.mass
                }
                ObjectSpec::Cylinder(spec) => {
                    self.length(&format!("{path}.radius"), spec.radius);
                    self.length(&format!("{path}.length"), spec.length);
                    spec.mass
                }
                ObjectSpec::Mesh(spec) => {
                    self.file(&path, &spec.file, &["stl", "obj", "dae"]);
                    spec.mass
                }
                ObjectSpec::Model(spec) => {
                    if spec.model.is_empty() {
                        self.error(&format!("{path}.model"), "must name a file");
                    }
                    continue;
                }
            };
            let [least, greatest] = MASSES;
            if !(least..=greatest).contains(&mass) {
                self.error(&format!("{path}.mass"), format!("must be from {least} to {greatest} kg, not {mass}"));
            }
        }
    }
}
