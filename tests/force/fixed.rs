//! Forces on a link that is fixed to the world are refused: they could not move it.

use crate::support::runs::root;
use stiction::{assemble, robot, scenario};

#[test]
fn a_force_on_a_fixed_link_is_refused_at_the_link_name() {
    for force in [
        "type = \"constant\"\nlink = \"base\"\nforce = [1, 0, 0]",
        "type = \"spring\"\nlink = \"base\"\nstiffness = 1",
        "type = \"drag\"\nlink = \"base\"\nlinear = 1",
        "type = \"carried-object\"\nlink = \"base\"\nmass = 1",
        "type = \"random-pushes\"\nnumber = 1\nmagnitude = [1, 1]\nlinks = [\"base\"]",
    ] {
        let text = format!("[robot]\nmodel = \"robots/pendulum/pendulum.urdf\"\nsoles = []\n[[force]]\n{force}\n");
        let text = text.replace("\"base\"", &format!("{:?}", fixed()));
        let runs = scenario::parse(&root().join("test.toml"), &text).and_then(|f| f.expand(&[])).expect("it is sound");
        let robot = robot::load(&runs[0].resolve(&runs[0].scenario.robot.model)).expect("it is there");
        let Err(wrong) = assemble::setup(&runs[0], &robot) else { panic!("accepted: {force}") };
        let [error] = &wrong.0[..] else { panic!("{wrong}") };
        assert!(error.message.contains("is fixed") && error.to_string().contains("link"), "{wrong}");
    }
}

/// The pendulum's fixed root.
fn fixed() -> String {
    let robot = robot::load(&root().join("robots/pendulum/pendulum.urdf")).expect("it is there");
    robot.model.links[0].name.clone()
}
