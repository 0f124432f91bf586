//! Tests of physically impossible inertias in scenarios and in `inspect`.

use super::Place;

/// The block with a principal moment that exceeds the sum of the others.
fn unphysical() -> Place {
    let place = Place::new();
    let urdf = std::fs::read_to_string(place.path("block/block.urdf")).unwrap();
    let moment = "izz=\"0.0066666666666666667\"";
    assert!(urdf.contains(moment));
    place.write("block/block.urdf", urdf.replace(moment, "izz=\"1.0\""));
    place
}

#[test]
fn a_scenario_can_repair_an_inertia() {
    let place = unphysical();
    place.write("refused.toml", "duration = 0.01\n[robot]\nmodel = \"block/block.toml\"\n");
    place.write("repaired.toml", "duration = 0.01\n[robot]\nmodel = \"block/block.toml\"\ninertia = \"repair\"\n");
    let refused = place.runner(&["run", "refused.toml", "-o", "out"]).exits(2);
    assert!(refused.stderr.contains("inertia of link `block`"), "{}", refused.stderr);
    let repaired = place.runner(&["run", "repaired.toml", "-o", "out"]).exits(0);
    assert!(repaired.stderr.contains("inertia of link `block` repaired"), "{}{}", repaired.stdout, repaired.stderr);
    // In one batch: the robot is loaded both with and without repair, and the invalid one is
    // refused.
    place.runner(&["run", "refused.toml", "repaired.toml", "-o", "both"]).exits(2);
    place.write("word.toml", "[robot]\nmodel = \"block/block.toml\"\ninertia = \"mend\"\n");
    assert!(place.runner(&["check", "word.toml"]).exits(2).stderr.contains("word.toml:3:"));
}

#[test]
fn inspect_shows_the_effect_of_a_repair() {
    let place = unphysical();
    place.runner(&["inspect", "block/block.urdf"]).exits(2);
    let shown = place.runner(&["inspect", "--repair", "block/block.urdf"]).exits(0).stdout;
    assert!(
        shown.contains("inertia of link `block` repaired: principal moments") && shown.contains("become"),
        "{shown}"
    );
}
