//! CB-i against the published figures: group masses, lengths, the total centre of mass, senses of
//! the joints.

use nalgebra::{Matrix3, Point3, Vector3};
use stiction::robot::{DriveMode, Link, Model};

use super::convention::by_model;
use super::figures::{centre_of_mass, level_soles, margins, moments, origin, senses, urdf_is_printed_by_its_script};
use super::shipped;

fn cbi() -> Model {
    shipped("cbi/cbi.toml").model
}

/// Mass of the links moved by the joints of these names, and of the root for "".
fn mass_of(model: &Model, joints: impl Fn(&str) -> bool) -> f64 {
    let name = |i: usize| if i == 0 { "" } else { model.joints[i - 1].name.as_str() };
    (0..model.links.len()).filter(|&i| joints(name(i))).map(|i| model.links[i].mass).sum()
}

const ARM: [&str; 7] = ["SFE", "SAA", "HR", "EB", "WR", "WFE", "WAA"];
const LEG: [&str; 7] = ["HAA", "HFE", "HFR", "KFE", "AR", "AFE", "AAA"];

#[test]
fn files_load_without_notices() {
    for robot in ["cbi/cbi.toml", "cbi/cbi-92.toml", "quadruped/quadruped.toml"] {
        assert!(shipped(robot).notices.is_empty(), "{:?}", shipped(robot).notices);
    }
}

#[test]
fn masses_add_up_to_the_published_groups() {
    let model = cbi();
    assert_eq!((model.nj(), model.links.len(), model.nv(), model.soles.len()), (38, 39, 44, 2));
    let kinematic = model.joints.iter().filter(|j| j.drive.mode == DriveMode::Kinematic);
    assert_eq!(kinematic.map(|j| j.name.as_str()).collect::<Vec<_>>(), ["R_EP", "R_ET", "L_EP", "L_ET"]);
    let group = |names: &[&str], side: &str| {
        mass_of(&model, |j| j.strip_prefix(side).is_some_and(|rest| names.contains(&rest)))
    };
    let published = [
        (mass_of(&model, |_| true), 62.880),
        (mass_of(&model, str::is_empty), 7.145),
        (group(&LEG, "L_"), 14.155),
        (group(&LEG, "R_"), 14.155),
        (group(&ARM, "L_"), 6.817),
        (group(&ARM, "R_"), 6.817),
        (group(&["TR"], "B_"), 1.964),
        (group(&["TAA"], "B_"), 1.661),
        (group(&["TFE"], "B_"), 5.839),
        (group(&["HN"], "B_"), 0.531),
        (group(&["HT"], "B_"), 0.531),
        (group(&["HR"], "B_"), 2.736),
        (group(&["EP", "ET"], "L_") + group(&["EP", "ET"], "R_"), 0.529),
    ];
    for (found, figure) in published {
        // Both are printed to a gram or finer: the tolerance is half a gram, plus rounding of the
        // links' 0.1 g.
        assert!((found - figure).abs() < 0.8e-3, "{found} kg instead of {figure}");
    }
}

#[test]
fn lengths_and_centre_of_mass_match_the_published_values() {
    let model = cbi();
    let zero = [0.0; 38];
    let at = |link: &str| origin(&model, &zero, link);
    let com = centre_of_mass(&model, &zero);
    // From mid-hip, the root's origin; published to 0.1 mm.
    assert!((com - Vector3::new(-0.0090, 0.0009, -0.0318)).amax() < 1e-4, "{com}");
    let torso = at("torso");
    let published = [
        ((at("l_hip") - at("r_hip")).norm() / 2.0, 0.0889),
        ((at("l_knee") - at("l_hip")).norm(), 0.3958),
        ((at("l_ankle") - at("l_knee")).norm(), 0.3810),
        (torso.z, 0.1761),
        (-torso.x, 0.0042),
        ((at("l_shoulder_roll") - at("l_shoulder")).norm(), 0.2768),
        (at("l_upper_arm").y, 0.2197),
        (at("l_upper_arm").z - torso.z, 0.3067),
        ((at("l_elbow") - at("l_upper_arm")).norm(), 0.2577),
        (at("l_elbow").z - at("l_hand").z, 0.2408),
        (at("neck_nod").z - torso.z, 0.3068),
        // 0.010 behind the ankle axes.
        (at("l_ankle").x - com.x, 0.010),
    ];
    for (found, figure) in published {
        // Printed to 0.1 mm; the last one to 1 mm, with the value 0.0101.
        assert!((found - figure).abs() < 1.5e-4, "{found} m instead of {figure}");
    }
    // Top of the head, 0.280 above the neck point, measured from the soles.
    let sole = level_soles(&model, &zero);
    assert!((at("neck_nod").z + 0.280 - sole - 1.591).abs() < 5e-4, "{}", at("neck_nod").z + 0.280 - sole);
}

#[test]
fn every_inertia_tensor_is_physical() {
    for robot in ["cbi/cbi.toml", "cbi/cbi-92.toml"] {
        for link in &shipped(robot).model.links {
            let [least, middle, greatest] = moments(link);
            assert!(least > 0.0 && greatest < least + middle, "{}: {least} {middle} {greatest}", link.name);
        }
    }
}

/// Centre and tensor in the axes of the link's URDF frame.
fn in_urdf(link: &Link) -> (Vector3<f64>, Matrix3<f64>) {
    let back = link.urdf_frame.inverse();
    let r = back.rotation.to_rotation_matrix().into_inner();
    ((back * Point3::from(link.com)).coords, r * link.inertia * r.transpose())
}

#[test]
fn right_mirrors_left() {
    let model = cbi();
    let flip = Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, 1.0));
    let poses = by_model(&model, &[0.0; 38]);
    for name in ARM.iter().chain(&LEG) {
        let [l, r] = ["L", "R"].map(|side| model.joint(&format!("{side}_{name}")).unwrap().0);
        let (left, right) = (&model.links[l + 1], &model.links[r + 1]);
        let ((cl, il), (cr, ir)) = (in_urdf(left), in_urdf(right));
        assert_eq!(left.mass, right.mass);
        // Exact in the file; the conversion to the internal frame and back rounds.
        assert!((flip * cl - cr).norm() < 1e-15 && (flip * il * flip - ir).norm() < 1e-16, "{name}");
        let place = |link: &Link| poses[&link.name].fixed_view::<3, 1>(0, 3).into_owned();
        assert!((flip * place(left) - place(right)).norm() < 1e-15, "{name}");
        // A rotation is an axial vector: its mirror image keeps y and reverses x and z. The ranges
        // therefore stay.
        let axis = |link: &Link| link.urdf_frame.rotation.inverse() * Vector3::z();
        assert!((flip * axis(left) + axis(right)).norm() < 1e-15, "{name}");
        let (jl, jr) = (&model.joints[l], &model.joints[r]);
        assert_eq!((jl.lower, jl.upper, jl.effort_limit), (jr.lower, jr.upper, jr.effort_limit));
        assert_eq!((jl.drive, jl.damping, model.home[l]), (jr.drive, jr.damping, model.home[r]));
    }
}

/// The effect of a positive angle, as the sources describe it.
#[test]
fn joints_rotate_in_the_directions_of_the_figures() {
    let toes = Vector3::new(0.2, 0.0, 0.0);
    let (o, x, y, z) = (Vector3::zeros(), Vector3::x(), Vector3::y(), Vector3::z());
    senses(
        &cbi(),
        &[
            ("L_HAA", "l_foot", o, -y, "left leg inward"),
            ("R_HAA", "r_foot", o, y, "right leg inward"),
            ("L_HFE", "l_foot", o, x, "leg forward"),
            // A point far ahead: the tilted axis passes close to the toes.
            ("L_HFR", "l_foot", x, y, "left toes outward"),
            ("R_HFR", "r_foot", x, -y, "right toes outward"),
            ("L_KFE", "l_foot", o, -x, "knee flexes backward"),
            ("L_AR", "l_foot", toes, y, "left toes outward"),
            ("L_AFE", "l_foot", toes, z, "toes up"),
            ("L_SFE", "l_hand", o, x, "arm forward"),
            ("R_SFE", "r_hand", o, x, "arm forward"),
            ("L_SAA", "l_hand", o, -y, "left arm inward"),
            ("R_SAA", "r_hand", o, y, "right arm inward"),
            ("L_HR", "l_hand", Vector3::x() * 0.1, y, "left arm turns outward"),
            ("L_WR", "l_hand", Vector3::x() * 0.1, y, "left wrist turns outward"),
            ("L_EB", "l_hand", o, x, "elbow flexes"),
            ("B_TFE", "head", o, x, "bends forward"),
            ("B_HN", "head", z * 0.1, x, "nods forward"),
            ("B_TR", "torso", toes, -y, "turns right"),
            ("B_HR", "head", toes, -y, "looks right"),
            ("B_TAA", "head", o, -y, "leans right"),
            ("B_HT", "head", z * 0.1, -y, "tilts right"),
        ],
    );
}

#[test]
fn at_home_the_soles_are_level() {
    for robot in ["cbi/cbi.toml", "cbi/cbi-92.toml"] {
        let model = shipped(robot).model;
        level_soles(&model, &model.home);
        // Toes, heels and sides of the rectangle around both soles.
        let margins = margins(&model, &model.home);
        assert!(margins.iter().all(|m| *m > 0.06), "{robot}: {margins:?}");
    }
}

#[test]
fn the_92_kg_robot_is_the_same_robot_with_declared_loads() {
    let (light, heavy) = (cbi(), shipped("cbi/cbi-92.toml").model);
    assert!((heavy.mass() - 92.0).abs() < 1e-3, "{}", heavy.mass());
    for (a, b) in light.links.iter().zip(&heavy.links) {
        let load = match a.name.as_str() {
            "torso" => 28.02,
            "l_hand" | "r_hand" => 0.55,
            _ => 0.0,
        };
        assert!((b.mass - a.mass - load).abs() < 1e-12, "{}", a.name);
        assert!(load > 0.0 || a == b, "{}", a.name);
    }
    for (a, b) in light.joints.iter().zip(&heavy.joints) {
        let leg = LEG.iter().any(|j| a.name.ends_with(&format!("_{j}")) && !a.name.starts_with('B'));
        let factor = if leg || a.name.starts_with("B_T") { 2.0 } else { 1.0 };
        assert_eq!((a.drive.kp * factor, a.drive.kd * factor), (b.drive.kp, b.drive.kd), "{}", a.name);
        assert_eq!((a.lower, a.upper, a.effort_limit), (b.lower, b.upper, b.effort_limit));
    }
    assert_eq!(light.soles, heavy.soles);
}

#[test]
fn the_urdf_equals_the_output_of_its_script() {
    urdf_is_printed_by_its_script("cbi");
}
