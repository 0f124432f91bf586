//! Quantities to compare with published or designed figures, computed from a loaded model by its
//! documented conventions.

use std::path::Path;
use std::process::Command;

use nalgebra::{Point3, Vector3};
use stiction::robot::{Link, Model};

use super::convention::by_model;

/// Centre of mass in the root's frame, m.
pub fn centre_of_mass(model: &Model, q: &[f64]) -> Vector3<f64> {
    let poses = by_model(model, q);
    let moment = |l: &Link| {
        let internal = poses[&l.name] * l.urdf_frame.inverse().to_homogeneous();
        internal.transform_point(&Point3::from(l.com)).coords * l.mass
    };
    model.links.iter().map(moment).sum::<Vector3<f64>>() / model.mass()
}

/// Origin of a link's URDF frame in the root's frame, m.
pub fn origin(model: &Model, q: &[f64], link: &str) -> Vector3<f64> {
    by_model(model, q)[link].fixed_view::<3, 1>(0, 3).into_owned()
}

/// Principal moments of inertia, ascending, kg m^2.
pub fn moments(link: &Link) -> [f64; 3] {
    let mut moments: [f64; 3] = link.inertia.symmetric_eigenvalues().into();
    moments.sort_by(f64::total_cmp);
    moments
}

/// All sole vertices in the root's frame, m.
fn vertices(model: &Model, q: &[f64]) -> Vec<Vector3<f64>> {
    let poses = by_model(model, q);
    let of = |sole: &stiction::robot::Sole| {
        let link = &model.links[sole.link.0];
        let internal = poses[&link.name] * link.urdf_frame.inverse().to_homogeneous();
        sole.vertices.iter().map(|v| internal.transform_point(&Point3::from(*v)).coords).collect::<Vec<_>>()
    };
    model.soles.iter().flat_map(of).collect()
}

/// Height of all soles in the root's frame, m, which must be one height.
pub fn level_soles(model: &Model, q: &[f64]) -> f64 {
    let vertices = vertices(model, q);
    for vertex in &vertices {
        assert!((vertex.z - vertices[0].z).abs() < 1e-12, "{vertex}");
    }
    vertices[0].z
}

/// Distances of the centre of mass from the back, front, right and left of the rectangle around all soles, m.
pub fn margins(model: &Model, q: &[f64]) -> [f64; 4] {
    let (vertices, com) = (vertices(model, q), centre_of_mass(model, q));
    let side = |pick: fn(f64, f64) -> f64, axis: usize| vertices.iter().map(|v| v[axis]).reduce(pick).unwrap();
    [com.x - side(f64::min, 0), side(f64::max, 0) - com.x, com.y - side(f64::min, 1), side(f64::max, 1) - com.y]
}

/// Joint, link, point in its frame, direction, and the direction in description.
pub type Sense<'a> = (&'a str, &'a str, Vector3<f64>, Vector3<f64>, &'a str);

/// Asserts that each joint, rotated from zero by +0.2 rad, moves a point of a link (in its frame)
/// mostly in the given direction.
pub fn senses(model: &Model, cases: &[Sense]) {
    for (joint, link, point, direction, description) in cases {
        let mut q = vec![0.0; model.nj()];
        let at = |q: &[f64]| by_model(model, q)[*link].transform_point(&Point3::from(*point)).coords;
        let before = at(&q);
        q[model.joint(joint).unwrap().0] = 0.2;
        let moved = at(&q) - before;
        assert!(
            moved.dot(direction) > 0.01 && moved.dot(direction) > 0.6 * moved.norm(),
            "{joint}: {description}? {moved}"
        );
    }
}

/// Asserts that the URDF in `robots/NAME` is the output of its `make_urdf.py`. Skipped with a
/// message without Python.
pub fn urdf_is_printed_by_its_script(name: &str) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots").join(name);
    let committed = std::fs::read_to_string(folder.join(format!("{name}.urdf"))).unwrap();
    match Command::new("python3").arg("-B").arg(folder.join("make_urdf.py")).output() {
        Ok(output) => {
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
            assert!(committed == String::from_utf8(output.stdout).unwrap(), "print {name}.urdf again");
        }
        Err(error) => eprintln!("skipped: no python3 ({error})"),
    }
}
