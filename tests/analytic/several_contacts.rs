//! Several contacts that share a load: which one slips, and when, by Coulomb's law.

use super::body::G;
use super::terrain::finished;
use nalgebra::Vector3;
use std::path::Path;

/// Integral twice of an acceleration `slope (t - from)` from rest, m.
fn way(slope: f64, from: f64, until: f64) -> f64 {
    slope * (until - from).powi(3) / 6.0
}

/// A block of 1 kg on a box of 2 kg is pushed by a force that grows by 10 N/s, on a floor that is rougher
/// than the box: only the block slips, at mu m g.
#[test]
fn a_block_slips_on_a_box_on_a_rough_floor() {
    let (sim, m) = finished(
        "duration = 0.6
        floor.friction = 0.9
        robot = { model = \"robots/block/block.toml\", base = { position = [0, 0, 0.15] } }
        object = [{ type = \"box\", size = [1, 0.4, 0.1], mass = 2.0, friction = 0.3, position = [0, 0, 0.05] }]
        force = [{ type = \"ramp\", link = \"block\", force = [10, 0, 0], start = 0.0, duration = 1.0 }]",
    );
    let slips = 0.3 * G / 10.0;
    assert!((m.first_slip_s.unwrap() - slips).abs() < 1e-9, "{:?} {slips}", m.first_slip_s);
    let expected = way(10.0, slips, 0.6);
    assert!((m.final_base_position[0] - expected).abs() < 1e-9, "{:?} {expected}", m.final_base_position);
    // 0.3 m g on the box is less than 0.3 * 3 m g from the floor.
    assert!(sim.plant().objects.list[0].state.position.x.abs() < 1e-12);
    assert!(m.inconsistent == 0 && m.energy_error_j.abs() < 1e-9 && m.max_cone_excess < 1e-9, "{m:?}");
}

/// The same on a smooth floor: both slide together, until the friction that pulls the box along is not
/// enough.
#[test]
fn a_box_slides_on_a_smooth_floor_and_the_block_slips_later() {
    let (floor, top, rate, end) = (0.05, 0.4, 20.0, 0.5);
    let (sim, m) = finished(&format!(
        "duration = {end}
        floor.friction = {floor}
        robot = {{ model = \"robots/block/block.toml\", base = {{ position = [0, 0, 0.15] }} }}
        object = [{{ type = \"box\", size = [1, 0.4, 0.1], mass = 2.0, friction = {top}, position = [0, 0, 0.05] }}]
        force = [{{ type = \"ramp\", link = \"block\", force = [{rate}, 0, 0], start = 0.0, duration = 1.0 }}]"
    ));
    // m = 1 kg, 2 m. Together from t1 on with 3 m a = F - mu_f 3 m g, until the pull on the box,
    // 2 m a + mu_f 3 m g, is mu m g at t2.
    let t1 = 3.0 * floor * G / rate;
    let a2 = (top - 3.0 * floor) * G / 2.0;
    let t2 = (3.0 * a2 + 3.0 * floor * G) / rate;
    let (x2, v2, rest) = (way(rate / 3.0, t1, t2), rate / 6.0 * (t2 - t1).powi(2), end - t2);
    let box_ = x2 + v2 * rest + 0.5 * a2 * rest * rest;
    let block = box_ + way(rate, t2, end);
    assert!((m.first_slip_s.unwrap() - t1).abs() < 1e-9, "{:?} {t1}", m.first_slip_s);
    let found = [sim.plant().objects.list[0].state.position.x, m.final_base_position[0]];
    assert!((found[0] - box_).abs() < 1e-9 && (found[1] - block).abs() < 1e-9, "{found:?} {box_} {block}");
    assert!(m.inconsistent == 0 && m.energy_error_j.abs() < 1e-9 && m.max_cone_excess < 1e-9, "{m:?}");
}

/// Two plates press a box of 1 kg from both sides, with less force by 10 N/s: it falls when twice the
/// friction of a plate is its weight.
#[test]
fn a_box_between_two_plates_falls_when_they_press_too_little() {
    let folder = tempfile::tempdir().unwrap();
    let urdf = folder.path().join("gripper.urdf");
    write_gripper(&urdf);
    let (mu, force, rate) = (0.5, 14.0, 10.0);
    let (sim, m) = finished(&format!(
        "duration = 0.6
        floor.plane = false
        robot = {{ model = {urdf:?}, contact = \"bodies\", joint_default = {{ mode = \"passive\" }} }}
        object = [{{ type = \"box\", size = [0.1, 0.1, 0.1], mass = 1.0, friction = {mu}, position = [0, 0, 0] }}]
        force = [
            {{ type = \"constant\", link = \"left\", force = [{force}, 0, 0] }},
            {{ type = \"constant\", link = \"right\", force = [-{force}, 0, 0] }},
            {{ type = \"ramp\", link = \"left\", force = [-{rate}, 0, 0], start = 0.0, duration = 1.0 }},
            {{ type = \"ramp\", link = \"right\", force = [{rate}, 0, 0], start = 0.0, duration = 1.0 }},
        ]"
    ));
    let falls = (force - G / (2.0 * mu)) / rate;
    assert!((m.first_slip_s.unwrap() - falls).abs() < 1e-9, "{:?} {falls}", m.first_slip_s);
    let dropped = way(2.0 * mu * rate, falls, 0.6);
    let position = sim.plant().objects.list[0].state.position;
    assert!((position + Vector3::z() * dropped).norm() < 1e-9, "{position} {dropped}");
    assert!(m.inconsistent == 0 && m.energy_error_j.abs() < 1e-9 && m.max_cone_excess < 1e-9, "{m:?}");
}

/// Two plates of 0.06 m that slide along x and touch a box of 0.1 m at the origin.
pub fn write_gripper(path: &Path) {
    let finger = |name: &str, x: f64| {
        format!(
            "<link name=\"{name}\">
                <inertial>
                    <mass value=\"0.5\"/>
                    <inertia ixx=\"1e-3\" iyy=\"1e-3\" izz=\"1e-3\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/>
                </inertial>
                <collision><geometry><box size=\"0.02 0.06 0.06\"/></geometry></collision>
            </link>
            <joint name=\"{name}_slide\" type=\"prismatic\">
                <parent link=\"world\"/><child link=\"{name}\"/><origin xyz=\"{x} 0 0\"/><axis xyz=\"1 0 0\"/>
                <limit lower=\"-1\" upper=\"1\" effort=\"100\" velocity=\"10\"/>
            </joint>"
        )
    };
    let links = finger("left", -0.06) + &finger("right", 0.06);
    std::fs::write(path, format!("<robot name=\"gripper\"><link name=\"world\"/>{links}</robot>")).unwrap();
}
