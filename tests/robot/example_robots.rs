//! Loads every URDF of PyPI's `example-robot-data`, with and without `--repair`. Skipped with a
//! message if the package is not installed. The test searches EXAMPLE_ROBOT_DATA (its folder
//! `example-robot-data` or `robots`), then the usual locations of Python packages.

use std::path::{Path, PathBuf};

use nalgebra::Vector3;
use rayon::prelude::*;
use serde_json::Value;
use stiction::robot::{InertiaPolicy, Robot, load_with};

use super::finding::polygon;
use crate::support::runs;

/// URDFs refused as shipped: the path, text of the error, and how many of Pinocchio's joints the
/// repair locks.
const REFUSED: &[(&str, &str, usize)] = &[
    ("icub_description/robots/icub.urdf", "the inertia of link `r_hip_2` is not positive definite", 1),
    ("icub_description/robots/icub_reduced.urdf", "the inertia of link `r_hip_2` is not positive definite", 0),
    ("romeo_description/urdf/romeo.urdf", "moves but has no mass", 24),
    ("romeo_description/urdf/romeo_laas_small.urdf", "the inertia of link `body` is not positive definite", 2),
    ("romeo_description/urdf/romeo_small.urdf", "the inertia of link `RShoulderYawLink` breaks the triangle", 0),
];

/// Not expanded from its xacro file: it has no links.
const EMPTY: &str = "ur_description/urdf/ur3.urdf";

fn robots() -> Option<PathBuf> {
    let at = |place: PathBuf| [place.join("robots"), place].into_iter().find(|p| p.join("talos_data").is_dir());
    if let Some(given) = std::env::var_os("EXAMPLE_ROBOT_DATA") {
        let found = at(PathBuf::from(&given));
        return Some(found.unwrap_or_else(|| panic!("EXAMPLE_ROBOT_DATA={given:?} holds no robots/talos_data")));
    }
    let home = |name: &str, rest: &str| std::env::var_os(name).map(|base| PathBuf::from(base).join(rest));
    let libraries = [
        home("VIRTUAL_ENV", "lib"),
        home("CONDA_PREFIX", "lib"),
        home("HOME", ".local/lib"),
        Some("/usr/local/lib".into()),
        Some("/usr/lib".into()),
    ];
    let versions = libraries.into_iter().flatten().filter_map(|lib| lib.read_dir().ok()).flatten().flatten();
    let packages = versions.flat_map(|v| ["site-packages", "dist-packages"].map(|kind| v.path().join(kind)));
    packages.map(|p| p.join("cmeel.prefix/share/example-robot-data")).find_map(at)
}

/// The folder of robots; prints that the test is skipped if there is none.
fn robots_or_skip(test: &str) -> Option<PathBuf> {
    let found = robots();
    if found.is_none() {
        println!(
            "{test}: skipped, since the Python package example-robot-data is not installed (see EXAMPLE_ROBOT_DATA)"
        );
    }
    found
}

#[test]
fn all_robots_load_with_the_joints_and_mass_of_pinocchio() {
    let Some(folder) = robots_or_skip("loading the example robots") else { return };
    let oracle: Value = serde_json::from_str(include_str!("../oracles/example_robots.json")).unwrap();
    let robots: Vec<(&String, &Value)> = oracle["robots"].as_object().unwrap().iter().collect();
    assert_eq!(robots.len(), 69);
    let judged: Vec<Result<(), String>> = robots
        .par_iter()
        .map(|&(name, expected)| {
            compare_with_pinocchio(&folder.join(name), name, expected).map_err(|why| format!("{name}: {why}"))
        })
        .collect();
    let wrong: Vec<String> = judged.into_iter().filter_map(Result::err).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

fn compare_with_pinocchio(path: &Path, name: &str, expected: &Value) -> Result<(), String> {
    let loaded = load_with(path, None);
    if name == EMPTY {
        return match loaded {
            Err(error) if expected.is_null() && error.to_string().contains("no links") => Ok(()),
            other => Err(format!("{other:?}")),
        };
    }
    let refused = REFUSED.iter().find(|(refused, ..)| *refused == name);
    let (robot, locked) = match (loaded, refused) {
        (Ok(robot), None) => (robot, 0),
        (Err(error), Some((_, why, locked))) => {
            if !error.to_string().contains(why) {
                return Err(format!("`{why}` is not in {error}"));
            }
            let repaired = load_with(path, Some(InertiaPolicy::Repair)).map_err(|e| e.to_string())?;
            (repaired, *locked)
        }
        (Ok(_), Some(_)) => return Err("it is not refused".into()),
        (Err(error), None) => return Err(error.to_string()),
    };
    let notice = robot.notices.iter().filter(|n| n.message.contains("is locked at 0")).count();
    let joints = expected["joints"].as_u64().unwrap() as usize;
    if notice != locked || robot.model.nj() + locked != joints {
        return Err(format!("{} joints and {notice} locked, Pinocchio has {joints}", robot.model.nj()));
    }
    let mass: f64 = robot.model.links.iter().map(|l| l.mass).sum();
    let theirs = expected["mass"].as_f64().unwrap();
    // Sums of some hundred masses in different orders.
    if (mass - theirs).abs() > 1e-13 * theirs {
        return Err(format!("{mass} kg, Pinocchio has {theirs}"));
    }
    let trace: f64 = robot.model.links.iter().map(|l| l.inertia.trace()).sum();
    let theirs = expected["inertia"].as_f64().ok_or("no inertia in the oracle")?;
    // Sums of some hundred tensors in different orders; a repair changes them.
    if refused.is_none() && (trace - theirs).abs() > 1e-12 * theirs {
        return Err(format!("{trace} kg m^2 on the diagonals, Pinocchio has {theirs}"));
    }
    assert_shapes(&robot)
}

/// Checks that no mesh is missing except those with a `file:///` path, that every triangle has its
/// corners, and that soles are flat.
fn assert_shapes(robot: &Robot) -> Result<(), String> {
    let lost = robot.notices.iter().find(|n| n.message.contains("left out") && !n.message.contains("file:///"));
    if let Some(notice) = lost {
        return Err(notice.to_string());
    }
    for i in 0..robot.model.soles.len() {
        let p = polygon(robot, i);
        let plane = |q: &Vector3<f64>| (p[1] - p[0]).cross(&(p[2] - p[0])).normalize().dot(&(q - p[0]));
        // Rounding of coordinates below 1 m, amplified where the first corner is obtuse.
        if p.is_empty() || p.len() > 3 && p.iter().any(|q| plane(q).abs() > 1e-9) {
            return Err(format!("sole {i}: {p:?}"));
        }
    }
    Ok(())
}

/// Stands on the detected soles with a position servo for 5 s. Returns the greatest distance of the
/// base from its position after the first second, in which the joints sag under the weight.
fn stand(urdf: &Path, kp: f64, kd: f64) -> f64 {
    let text = format!(
        "duration = 5.0\n[robot]\nmodel = {urdf:?}\njoint_default = {{ kp = {kp}, kd = {kd} }}\n\
         [integrator]\nmethod = \"semi-implicit\"\nstep = 1e-3\n[log]\nrate = 50.0\n"
    );
    let (metrics, notice) = runs::watch(&text);
    assert_eq!(metrics.inconsistent, 0);
    let settled = notice.snapshots.iter().filter(|s| s.time >= 1.0);
    let base: Vec<Vector3<f64>> = settled.map(|s| s.base_pose.translation.vector).collect();
    assert!(base.len() > 150, "{}", base.len());
    base.iter().map(|p| (p - base[0]).norm()).fold(0.0, f64::max)
}

#[test]
fn talos_and_g1_stand_for_five_seconds_on_detected_soles() {
    let Some(folder) = robots_or_skip("standing of Talos and G1") else { return };
    for (urdf, kp, kd) in [
        ("talos_data/robots/talos_reduced.urdf", 5000.0, 200.0),
        ("talos_data/robots/talos_full_v2.urdf", 5000.0, 200.0),
        ("g1_description/urdf/g1_29dof_rev_1_0.urdf", 3000.0, 100.0),
    ] {
        let drift = stand(&folder.join(urdf), kp, kd);
        println!("{urdf}: {drift:.3e} m");
        assert!(drift < 1e-3, "{urdf}: {drift} m");
    }
}
