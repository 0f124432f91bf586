//! `[[terrain]]`: fixed bodies on which the robot stands.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::scenario::format::defaults;
use crate::scenario::format::floor::Friction;
use crate::scenario::format::tagged::tagged;
use crate::text::quantity::{angles, count, json, non_negative, positive, some_positive};

tagged! {
    /// One fixed body.
    TerrainSpec, "terrain" {
        /// A box.
        "box" => Box(BoxTerrain),
        /// A wedge.
        "ramp" => Ramp(RampTerrain),
        /// Stairs with solid steps.
        "stairs" => Stairs(StairsTerrain),
        /// A grid of heights.
        "heightfield" => HeightField(HeightFieldTerrain),
        /// A body from a mesh file.
        "mesh" => Mesh(MeshTerrain),
    }
}

/// A box. All its faces can be touched.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoxTerrain {
    /// Name, which no other entry has. Left out: `terrain.N`, N its index from 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Centre, world, m.
    #[serde(default)]
    pub position: [f64; 3],
    /// Roll, pitch, yaw as in URDF, rad.
    #[serde(default, deserialize_with = "angles")]
    #[schemars(with = "[json::Angle; 3]")]
    pub rpy: [f64; 3],
    /// Edges along its axes x, y, z, m.
    #[schemars(with = "[json::Positive; 3]")]
    pub size: [f64; 3],
    /// Coulomb friction: one number, or static and kinetic. Left out: that of the floor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction: Option<Friction>,
}

/// A wedge that rises along its axis x from height 0. Its underside cannot be touched.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RampTerrain {
    /// Name, which no other entry has. Left out: `terrain.N`, N its index from 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Middle of the lower front edge, where the slope begins, world, m.
    #[serde(default)]
    pub position: [f64; 3],
    /// Roll, pitch, yaw as in URDF, rad.
    #[serde(default, deserialize_with = "angles")]
    #[schemars(with = "[json::Angle; 3]")]
    pub rpy: [f64; 3],
    /// Length along x, width along y and height of the rear edge, m.
    #[schemars(with = "[json::Positive; 3]")]
    pub size: [f64; 3],
    /// Coulomb friction: one number, or static and kinetic. Left out: that of the floor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction: Option<Friction>,
}

/// Stairs that rise along their axis x from height 0; below each step they are solid. Their
/// underside cannot be touched.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StairsTerrain {
    /// Name, which no other entry has. Left out: `terrain.N`, N its index from 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Middle of the lower front edge, below the front of the first step, world, m.
    #[serde(default)]
    pub position: [f64; 3],
    /// Roll, pitch, yaw as in URDF, rad.
    #[serde(default, deserialize_with = "angles")]
    #[schemars(with = "[json::Angle; 3]")]
    pub rpy: [f64; 3],
    /// Number of steps, at most 1000.
    #[serde(deserialize_with = "count")]
    #[schemars(range(min = 1, max = 1000))]
    pub steps: u32,
    /// Height of each step, m.
    #[serde(deserialize_with = "positive")]
    #[schemars(with = "json::Positive")]
    pub rise: f64,
    /// Length of each step, m.
    #[serde(deserialize_with = "positive")]
    #[schemars(with = "json::Positive")]
    pub run: f64,
    /// Width along y, m.
    #[serde(deserialize_with = "positive")]
    #[schemars(with = "json::Positive")]
    pub width: f64,
    /// Additional length of the last step, m.
    #[serde(default, deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub landing: f64,
    /// Coulomb friction: one number, or static and kinetic. Left out: that of the floor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction: Option<Friction>,
}

/// A grid of heights, two triangles to a cell, and solid below. Sides can be touched at the border
/// only, the underside cannot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HeightFieldTerrain {
    /// Name, which no other entry has. Left out: `terrain.N`, N its index from 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Middle of the grid at height 0, world, m.
    #[serde(default)]
    pub position: [f64; 3],
    /// Roll, pitch, yaw as in URDF, rad.
    #[serde(default, deserialize_with = "angles")]
    #[schemars(with = "[json::Angle; 3]")]
    pub rpy: [f64; 3],
    /// Heights: a table (`.csv`) with a row of numbers for each y and a column for each x, both
    /// ascending, or a 16-bit greyscale picture (`.png`), its first line at the least y. Either this
    /// or `heights`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// The rows of a table, in place of `file`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub heights: Option<Vec<Vec<f64>>>,
    /// Distances of the outer columns and of the outer rows, m; either this or `spacing`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<[json::Positive; 2]>")]
    pub size: Option<[f64; 2]>,
    /// Distance of columns and of rows, m; either this or `size`.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "some_positive")]
    #[schemars(with = "Option<json::Positive>")]
    pub spacing: Option<f64>,
    /// Of a table: height of the number 1 above that of 0, m. Left out: 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scale: Option<f64>,
    /// Of a table: height of the number 0, m. Left out: 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset: Option<f64>,
    /// Of a picture: heights of black and of white, m; required.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub height: Option<[f64; 2]>,
    /// Coulomb friction: one number, or static and kinetic. Left out: that of the floor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction: Option<Friction>,
}

/// A body from a mesh file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeshTerrain {
    /// Name, which no other entry has. Left out: `terrain.N`, N its index from 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Origin of the file, world, m.
    #[serde(default)]
    pub position: [f64; 3],
    /// Roll, pitch, yaw as in URDF, rad.
    #[serde(default, deserialize_with = "angles")]
    #[schemars(with = "[json::Angle; 3]")]
    pub rpy: [f64; 3],
    /// Mesh: `.stl`, `.obj` or `.dae`. Corners of triangles are counter-clockwise seen from
    /// outside.
    pub file: String,
    /// Metres to a unit of the file.
    #[serde(default = "defaults::one", deserialize_with = "positive")]
    #[schemars(with = "json::Positive")]
    pub scale: f64,
    /// What the mesh stands for.
    #[serde(default, rename = "as")]
    pub body: MeshBody,
    /// Of triangles: depth of the solid behind each, m. Left out: 0.05.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "some_positive")]
    #[schemars(with = "Option<json::Positive>")]
    pub depth: Option<f64>,
    /// Coulomb friction: one number, or static and kinetic. Left out: that of the floor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction: Option<Friction>,
}

/// What a mesh stands for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum MeshBody {
    /// Its triangles, each with a prism behind it. Only the triangles can be touched.
    #[default]
    Triangles,
    /// Its convex hull.
    Convex,
}

/// Keys that all types have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TerrainEntry<'a> {
    /// Given name.
    pub name: Option<&'a str>,
    /// Position, m.
    pub position: [f64; 3],
    /// Roll, pitch, yaw, rad.
    pub rpy: [f64; 3],
    /// Own friction.
    pub friction: Option<Friction>,
}

impl TerrainSpec {
    /// The keys that all types have.
    pub fn entry(&self) -> TerrainEntry<'_> {
        let (name, position, rpy, friction) = match self {
            TerrainSpec::Box(s) => (&s.name, s.position, s.rpy, s.friction),
            TerrainSpec::Ramp(s) => (&s.name, s.position, s.rpy, s.friction),
            TerrainSpec::Stairs(s) => (&s.name, s.position, s.rpy, s.friction),
            TerrainSpec::HeightField(s) => (&s.name, s.position, s.rpy, s.friction),
            TerrainSpec::Mesh(s) => (&s.name, s.position, s.rpy, s.friction),
        };
        TerrainEntry { name: name.as_deref(), position, rpy, friction }
    }

    /// The name of the entry with this index.
    pub fn name(&self, index: usize) -> String {
        self.entry().name.map_or_else(|| format!("terrain.{index}"), str::to_owned)
    }

    /// The file that the key `file` names, if the type has that key.
    pub fn file(&self) -> Option<&str> {
        match self {
            TerrainSpec::HeightField(field) => field.file.as_deref(),
            TerrainSpec::Mesh(mesh) => Some(&mesh.file),
            TerrainSpec::Box(_) | TerrainSpec::Ramp(_) | TerrainSpec::Stairs(_) => None,
        }
    }
}

impl HeightFieldTerrain {
    /// True for a picture, false for a table.
    pub fn is_picture(&self) -> bool {
        let extension = self.file.as_ref().and_then(|file| std::path::Path::new(file).extension());
        extension.is_some_and(|e| e.eq_ignore_ascii_case("png"))
    }
}
