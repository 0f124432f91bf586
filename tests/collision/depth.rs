//! Overlaps against the separating axis theorem. If a translation separates two convex polyhedra,
//! so does one along a face normal of either, or along the cross product of an edge of each. The
//! shortest is among these.

use super::random_bodies::{apart_along, model, normals_and_edges, placed, polytope, pose, single};
use stiction::random::Stream;

#[test]
fn depth_and_sign_are_those_of_the_separating_axis_theorem() {
    let mut r = Stream::new(11, &["depth"]);
    let mut overlapping = 0;
    for case in 0..800 {
        let m = model(vec![polytope(&mut r, 4 + case % 12), polytope(&mut r, 4 + case % 7)]);
        let poses = [pose(&mut r, 0.12), pose(&mut r, 0.12)];
        let [a, b] = [0, 1].map(|i| placed(&m.bodies[i], &poses));
        let [(na, ea), (nb, eb)] = [0, 1].map(|i| normals_and_edges(&m.bodies[i], &poses));
        let crosses = ea.iter().flat_map(|x| eb.iter().map(move |y| x.cross(y)));
        let crosses = crosses.filter(|c| c.norm() > 1e-6).map(|c| c.normalize());
        let axes = na.into_iter().chain(nb).chain(crosses);
        let best = axes.flat_map(|n| [n, -n]).map(|n| apart_along(&n, &a, &b)).fold(f64::NEG_INFINITY, f64::max);
        let found = single(&m, &poses).distance;
        // The theorem's axes give the distance only between parallel faces, but always show whether
        // the bodies are apart.
        if best < 0.0 {
            overlapping += 1;
            // Pairs of edges at less than 1e-6 rad are left out above; rounding of both sides.
            assert!((found - best).abs() < 1e-10, "case {case}: {found} instead of {best}");
        } else {
            assert!(found >= best - 1e-11, "case {case}: {found} though an axis shows a gap of {best}");
        }
    }
    assert!((200..700).contains(&overlapping), "{overlapping}");
}
