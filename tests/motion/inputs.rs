//! Files named by a scenario, in addition to its robot, are part of the run.

use super::{Folder, PENDULUM};
use crate::cli::Place;
use std::path::Path;
use stiction::results::RunRecord;

fn list(place: &Place) -> Vec<String> {
    let output = place.runner(&["list", "s.toml", "--format", "csv"]).exits(0).stdout;
    let table = crate::cli::Table::parse(&output);
    table.column("key").into_iter().map(str::to_owned).collect()
}

fn place() -> Place {
    let place = Place::new();
    let robots = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots");
    let play = "[[task]]\ntype = \"playback\"\nfile = \"m.csv\"\n[log]\nrate = 0\n";
    place.write("m.csv", "time,elbow\n0,0\n1,1\n");
    let text = PENDULUM.replace("ROBOTS", robots.to_str().unwrap()).replace("duration = 4.0", "duration = 0.01");
    place.write("s.toml", format!("{text}{play}"));
    place
}

#[test]
fn another_motion_file_changes_the_run_key() {
    let place = place();
    let first = list(&place);
    assert_eq!(first.len(), 1);
    assert_eq!(list(&place), first);
    place.write("m.csv", "time,elbow\n0,0\n1,1.0\n");
    assert_ne!(list(&place), first, "a byte more");
    place.write("m.csv", "time,elbow\n0,0\n1,1\n");
    assert_eq!(list(&place), first);
}

#[test]
fn summary_and_log_hold_the_avoidance_columns() {
    let place = place();
    place.runner(&["s.toml"]).exits(0);
    let key = list(&place).remove(0);
    let record = RunRecord::read(&place.path(&format!("results/s/{key}/run.json"))).unwrap();
    let last = record.inputs.last().unwrap();
    let bytes = std::fs::read(place.path("m.csv")).unwrap();
    assert_eq!((last.name.as_str(), last.blake3.as_str()), ("m.csv", blake3::hash(&bytes).to_hex().as_str()));
}

#[test]
fn each_run_of_a_sweep_has_its_own_draws() {
    let folder = Folder::with(&[("a.csv", "time,elbow\n0,0\n"), ("b.csv", "time,elbow\n0,1\n")]);
    let robots = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots");
    let text = format!(
        "{}[[task]]\ntype = \"playback\"\nfile = \"a.csv\"\n[compare]\nreference = {{ \"task.0.file\" = \"b.csv\" }}\n\
         [sweep]\ngrid = {{ \"task.0.file\" = [\"a.csv\", \"b.csv\", \"c.csv\"] }}\n",
        PENDULUM.replace("ROBOTS", robots.to_str().unwrap())
    );
    let parse = |text: &str| stiction::scenario::parse(&folder.path().join("s.toml"), text).unwrap().expand(&[]);
    let refused = parse(&text).unwrap_err();
    assert!(refused.0[0].message.contains("cannot read") && refused.0[0].message.contains("c.csv"), "{refused}");
    assert_eq!(refused.len(), 1);
    let runs = parse(&text.replace(", \"c.csv\"", "")).unwrap();
    let bytes = |run: &stiction::scenario::Run| run.input("task.0.file").unwrap().bytes.to_vec();
    assert_eq!(bytes(&runs[0]), b"time,elbow\n0,0\n");
    assert_eq!(bytes(&runs[1]), b"time,elbow\n0,1\n");
    assert_eq!(bytes(runs[0].reference.as_ref().unwrap()), b"time,elbow\n0,1\n");
}
