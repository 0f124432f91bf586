//! Compares height fields of an MJCF world with MuJoCo 4.0: points that its rays meet, on pictures,
//! a binary file and written numbers. Values are written by `make_height_fields.py`.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;
use stiction::assemble;
use stiction::nalgebra::Vector3;
use stiction::scenario::parse;

/// MuJoCo stores heights as 32-bit numbers.
const BOUND: f64 = 1e-7;

#[derive(Deserialize)]
struct Oracle {
    fields: BTreeMap<String, Vec<[f64; 3]>>,
}

#[test]
fn height_fields_have_the_triangles_of_mujoco() {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let oracle = std::fs::read_to_string(here.join("tests/oracles/height_fields.json")).unwrap();
    let oracle: Oracle = serde_json::from_str(&oracle).unwrap();
    let block = here.join("robots/block/block.urdf");
    let text = format!("[robot]\nmodel = {block:?}\n[world]\nfile = \"height_fields/fields.xml\"\n");
    let run = parse(&here.join("tests/scenario/s.toml"), text).unwrap().expand(&[]).unwrap().remove(0);
    assert!(run.warnings.0.is_empty(), "{}", run.warnings);
    // The heights are in the record, so that a re-run needs none of the files.
    let folder = tempfile::tempdir().unwrap();
    let again = parse(&folder.path().join("s.toml"), run.resolved_toml.clone()).unwrap().expand(&[]).unwrap().remove(0);
    assert_eq!(again.scenario.terrain, run.scenario.terrain);
    let terrain = assemble::terrain::terrain(&again, None, &mut Vec::new(), &mut Vec::new());
    let names = terrain.grids().iter().map(|grid| grid.entry().name.to_string());
    assert_eq!(names.collect::<Vec<_>>(), ["written", "raw", "level", "yard/grey", "yard/red"]);
    for grid in terrain.grids() {
        let entry = grid.entry();
        let points = &oracle.fields[entry.name.rsplit('/').next().unwrap()];
        for point in points {
            let own = entry.rotation.transpose() * (Vector3::from(*point) - entry.position);
            let height = grid.height(own.x, own.y).unwrap();
            assert!((height - own.z).abs() < BOUND, "{}: {height} against {}", entry.name, own.z);
        }
    }
    assert_eq!(terrain.grids()[3].entry().mu_s, 0.4);
}
