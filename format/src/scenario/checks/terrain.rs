//! Rules for `[[terrain]]`.

use super::Check;
use crate::scenario::format::floor::Friction;
use crate::scenario::format::terrain::{HeightFieldTerrain, MeshBody, MeshTerrain, StairsTerrain, TerrainSpec};
use std::collections::HashMap;

/// Least and greatest length, m. Products of others would lose digits or overflow.
const LENGTHS: [f64; 2] = [1e-6, 1e6];

/// Greatest number of steps of stairs.
const MAX_STEPS: u32 = 1000;

impl Check<'_> {
    /// Checks all entries.
    pub(super) fn terrain(&mut self, entries: &[TerrainSpec]) {
        let mut names = HashMap::new();
        for (i, spec) in entries.iter().enumerate() {
            let path = format!("terrain.{i}");
            let (entry, name) = (spec.entry(), spec.name(i));
            self.name("terrain", i, (name, entry.name.is_some()), &mut names);
            self.place(&path, entry.position, entry.friction);
            match spec {
                TerrainSpec::Box(block) => self.lengths(&format!("{path}.size"), &block.size),
                TerrainSpec::Ramp(ramp) => self.lengths(&format!("{path}.size"), &ramp.size),
                TerrainSpec::Stairs(stairs) => self.stairs(&path, stairs),
                TerrainSpec::HeightField(field) => self.height_field(&path, field),
                TerrainSpec::Mesh(mesh) => self.mesh(&path, mesh),
            }
        }
    }

    /// The name of entry `i` of a list, with whether it is given; `names` has those before it.
    pub(super) fn name(
        &mut self,
        list: &str,
        i: usize,
        (name, is_given): (String, bool),
        names: &mut HashMap<String, usize>,
    ) {
        if name.is_empty() {
            self.error(&format!("{list}.{i}.name"), "must not be empty");
        }
        if let Some(other) = names.insert(name.clone(), i) {
            // A name by default cannot be changed; the other one was chosen.
            let chosen = if is_given { i } else { other };
            self.error(&format!("{list}.{chosen}.name"), format!("{name:?} is the name of two entries"));
        }
    }

    /// Position and friction of the entry at `path`.
    pub(super) fn place(&mut self, path: &str, position: [f64; 3], friction: Option<Friction>) {
        for (axis, x) in position.into_iter().enumerate().filter(|(_, x)| x.abs() > LENGTHS[1]) {
            let must = format!("must be within {} m, not {x}", LENGTHS[1]);
            self.error(&format!("{path}.position.{axis}"), must);
        }
        if let Some(friction) = friction {
            self.friction(&format!("{path}.friction"), friction);
        }
    }

    pub(super) fn lengths(&mut self, path: &str, lengths: &[f64]) {
        for (k, length) in lengths.iter().enumerate() {
            self.length(&format!("{path}.{k}"), *length);
        }
    }

    pub(super) fn length(&mut self, path: &str, length: f64) {
        let [least, greatest] = LENGTHS;
        if !(least..=greatest).contains(&length) {
            self.error(path, format!("must be from {least} to {greatest} m, not {length}"));
        }
    }

    fn stairs(&mut self, path: &str, stairs: &StairsTerrain) {
        if stairs.steps > MAX_STEPS {
            self.error(&format!("{path}.steps"), format!("must be at most {MAX_STEPS}, not {}", stairs.steps));
        }
        for (key, length) in [("rise", stairs.rise), ("run", stairs.run), ("width", stairs.width)] {
            self.length(&format!("{path}.{key}"), length);
        }
        if stairs.landing > 0.0 {
            self.length(&format!("{path}.landing"), stairs.landing);
        }
    }

    fn height_field(&mut self, path: &str, field: &HeightFieldTerrain) {
        match (&field.file, &field.heights) {
            (Some(file), None) => self.file(path, file, &["csv", "png"]),
            (None, Some(_)) => {}
            _ => self.error(path, "needs either `file` or `heights`"),
        }
        match (field.size, field.spacing) {
            (Some(size), None) => self.lengths(&format!("{path}.size"), &size),
            (None, Some(spacing)) => self.length(&format!("{path}.spacing"), spacing),
            _ => self.error(path, "needs either `size` or `spacing`"),
        }
        if !field.is_picture() {
            if field.height.is_some() {
                let must = "has no meaning with a table: its heights are `scale` times its numbers plus `offset`";
                self.error(&format!("{path}.height"), must);
            }
            return;
        }
        for (key, given) in [("scale", field.scale), ("offset", field.offset)] {
            if given.is_some() {
                let must = "has no meaning with a picture: `height` has the heights of black and of white";
                self.error(&format!("{path}.{key}"), must);
            }
        }
        match field.height {
            None => self.error(path, "needs `height` for a picture: the heights of black and of white"),
            Some([black, white]) if !(black < white) => {
                let must = format!("must be [height of black, height of white] in order, not [{black}, {white}]");
                self.error(&format!("{path}.height"), must);
            }
            Some(_) => {}
        }
    }

    fn mesh(&mut self, path: &str, mesh: &MeshTerrain) {
        self.file(path, &mesh.file, &["stl", "obj", "dae"]);
        let Some(depth) = mesh.depth else { return };
        match mesh.body {
            MeshBody::Triangles => self.length(&format!("{path}.depth"), depth),
            MeshBody::Convex => self.error(&format!("{path}.depth"), "has no meaning with `as = \"convex\"`"),
        }
    }
}
