//! The quadruped against its design.

use nalgebra::Vector3;
use stiction::robot::Model;

use super::figures::{centre_of_mass, level_soles, margins, moments, senses, urdf_is_printed_by_its_script};
use super::shipped;

fn quadruped() -> Model {
    shipped("quadruped/quadruped.toml").model
}

#[test]
fn it_stands_on_four_points() {
    let model = quadruped();
    assert_eq!((model.nj(), model.nv(), model.soles.len()), (12, 18, 4));
    assert!(model.soles.iter().all(|s| s.vertices.len() == 1));
    // 6.50 kg for the body, 1.72 kg for each leg.
    assert!((model.mass() - (6.50 + 4.0 * 1.72)).abs() < 1e-9, "{}", model.mass());
    // Two segments of 0.22 m, 40 degrees from the vertical.
    let floor = level_soles(&model, &model.home);
    assert!((floor + 2.0 * 0.22 * 40f64.to_radians().cos()).abs() < 1e-12, "{floor}");
    // On a slope of 15 degrees the vertical through the centre of mass moves by height * tan. It
    // must stay between the feet, or the robot tips over them.
    let height = centre_of_mass(&model, &model.home).z - floor;
    let margins = margins(&model, &model.home);
    assert!(margins.iter().all(|m| *m > height * 15f64.to_radians().tan() + 0.03), "{margins:?}");
}

#[test]
fn a_shank_is_its_tube_and_its_ball() {
    // Computed by hand: a rod of 0.11 kg, radius 0.011, length 0.21 around z = -0.105 and a ball of
    // 0.05 kg, radius 0.014 around z = 0.014 - 0.22, about their common centre.
    let model = quadruped();
    let shank = model.links.iter().find(|l| l.name == "fl_shank").unwrap();
    let (rod, ball, a, b) = (0.11, 0.05, -0.105, 0.014 - 0.22);
    let centre = (rod * a + ball * b) / (rod + ball);
    let across = rod * (3.0 * 0.011f64.powi(2) + 0.21f64.powi(2)) / 12.0
        + 0.4 * ball * 0.014f64.powi(2)
        + rod * (a - centre) * (a - centre)
        + ball * (b - centre) * (b - centre);
    let along = rod * 0.011f64.powi(2) / 2.0 + 0.4 * ball * 0.014f64.powi(2);
    let [least, middle, greatest] = moments(shank);
    // The file has nine digits.
    assert!((shank.mass - 0.16).abs() < 1e-9 && (shank.com.norm() + centre).abs() < 1e-9);
    assert!((least - along).abs() < 1e-11 && (middle - across).abs() < 1e-11 && (greatest - across).abs() < 1e-11);
}

#[test]
fn joints_rotate_in_the_directions_of_the_readme() {
    let (o, x, y) = (Vector3::zeros(), Vector3::x(), Vector3::y());
    senses(
        &quadruped(),
        &[
            ("fl_hip_pitch", "fl_foot", o, -x, "leg backward"),
            ("hr_knee", "hr_foot", o, -x, "shank backward"),
            ("fl_hip_roll", "fl_foot", o, y, "left leg outward"),
            ("fr_hip_roll", "fr_foot", o, y, "right leg inward"),
        ],
    );
}

#[test]
fn the_urdf_equals_the_output_of_its_script() {
    urdf_is_printed_by_its_script("quadruped");
}
