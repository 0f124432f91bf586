//! Owners of the same separation.

use super::*;
use std::f64::consts::FRAC_PI_4;

/// The lower side of a box lies on an edge of another, but belongs to none: two of its sides cross the line of this
/// edge, and only one reaches it.
#[test]
fn of_parallel_sides_the_one_that_reaches_the_edge_owns_the_plane() {
    let mut a = ConvexBody::cuboid(Vector3::repeat(0.1));
    let below = a.faces.iter().position(|face| face.normal.z < -0.5).unwrap() as u16;
    a.set_touchable(below, false);
    let b = ConvexBody::cuboid(Vector3::new(0.3, 0.1, 0.1));
    let turn = *Rotation3::from_axis_angle(&Vector3::x_axis(), FRAC_PI_4).matrix();
    for side in [-1.0, 1.0] {
        let pa = Placement::at_rest(Matrix3::identity(), Vector3::new(0.0, 0.0, 0.1));
        let pb = Placement::at_rest(turn, Vector3::new(side * 0.25, 0.0, -0.1 * 2f64.sqrt()));
        let found = tied_topology(&a, &pa, &b, &pb, 0.0, 1e-9).unwrap();
        let Owner::Edges(i, _) = found.owner else { panic!("{:?}", found.owner) };
        let x = a.edge(i).ends.map(|k| a.vertex(k).x);
        assert_eq!(x, [side * 0.1; 2]);
        let mut geometry = PatchGeometry::new();
        super::super::geometry(&found, &a, &pa, &b, &pb, &mut geometry);
        let point = &geometry.points[0];
        assert!((point.position - Vector3::x() * (side * 0.1)).norm() < 1e-12 && point.gap.abs() < 1e-12);
        // Not on the other side of the edges, where they are deep.
        assert!(geometry.axes[(2, 2)] > 0.999);
    }
    let far = Placement::at_rest(turn, Vector3::new(0.0, 0.0, -0.1 * 2f64.sqrt() - 1e-6));
    let pa = Placement::at_rest(Matrix3::identity(), Vector3::new(0.0, 0.0, 0.1));
    assert!(tied_topology(&a, &pa, &b, &far, 1e-6, 1e-9).is_none());
}

/// A box lies across the edge of a table, and turns until the edge lies in its lower face.
#[test]
fn an_edge_that_comes_to_lie_in_a_face_touches_at_both_borders() {
    let (table, block) = (ConvexBody::cuboid(Vector3::repeat(1.0)), ConvexBody::cuboid(Vector3::new(0.5, 0.1, 0.1)));
    let pair = |angle: f64| {
        let rotation = turn(Vector3::y() * 0.4) * turn(Vector3::x() * angle);
        let mut pair = Pair::new(&block, at(rotation, 1.03, 0.0, 1.1), &table, level(0.0, 0.0, 0.0));
        let owner = pair.touch();
        (pair, owner)
    };
    let flat = |(pair, owner): &(Pair, Owner)| flat_topology([*owner; 2], &pair.a, &pair.pa, &pair.b, &pair.pb, 1.0);
    let nearly = pair(1e-9);
    assert!(matches!(nearly.1, Owner::Edges(..)), "{:?}", nearly.1);
    let found = flat(&nearly).unwrap();
    assert!(matches!(found.owner, Owner::FaceOfA(_)), "{found:?}");
    let gaps = nearly.0.geometry(&found).points.iter().filter(|point| point.gap.abs() < 1e-9).count();
    assert_eq!(gaps, 2, "{found:?}");
    // The face that owned the plane keeps it, though another has the same distance.
    let top = Owner::FaceOfB(table.faces.iter().position(|face| face.normal.z > 0.5).unwrap() as u16);
    let of = |owners: [Owner; 2], (pair, _): &(Pair, Owner)| {
        flat_topology(owners, &pair.a, &pair.pa, &pair.b, &pair.pb, 1.0).map(|found| found.owner)
    };
    assert_eq!(of([top, found.owner], &nearly), Some(found.owner));
    assert_eq!(of([found.owner, top], &nearly), None);
    let tilted = pair(1e-4);
    assert!(matches!(tilted.1, Owner::Edges(..)) && flat(&tilted).is_none(), "{:?}", tilted.1);
}
