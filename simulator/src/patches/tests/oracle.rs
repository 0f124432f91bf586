//! Separations of random pairs against independent methods.

use super::*;

/// Greatest distance of the origin from the faces of the hull of all differences of vertices. This
/// is the separation of polyhedra along the normals of the faces of A - B.
fn by_minkowski_difference(pair: &Pair) -> f64 {
    let points: Vec<Vector3<f64>> = pair
        .a
        .vertices
        .iter()
        .flat_map(|x| pair.b.vertices.iter().map(|y| pair.pa.point(x) - pair.pb.point(y)))
        .collect();
    let hull = ConvexBody::from_points(&points).unwrap();
    hull.faces.iter().map(|face| -face.offset).fold(f64::NEG_INFINITY, f64::max)
}

/// Least of a convex function on [-1, 1], by thirds. The error is that of equal values, 1e-8 in the
/// argument and 1e-16 in the value.
fn least(f: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (-1.0, 1.0);
    for _ in 0..100 {
        let (s, t) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if f(s) < f(t) { high = t } else { low = s }
    }
    f((low + high) / 2.0)
}

/// Error: COPLANAR (1e-9) times the size, from the merged faces of the difference.
#[test]
fn polyhedra_have_the_separation_of_their_minkowski_difference() {
    let mut random = Random::new(71);
    let (mut apart, mut edges) = (0, 0);
    for k in 0..120 {
        let (a, b) = match k % 3 {
            0 => (random.cuboid(), random.cuboid()),
            1 => (random.hull(9), random.cuboid()),
            _ => (random.hull(8), random.hull(10)),
        };
        let mut pair = Pair::new(&a, random.placement(), &b, random.placement());
        pair.pa.position *= 1.7;
        let (found, expected) = (pair.separation(), by_minkowski_difference(&pair));
        assert!((found.distance - expected).abs() < 1e-8, "{k}: {} {expected}", found.distance);
        apart += usize::from(expected > 0.0);
        edges += usize::from(matches!(found.owner, Some(Owner::Edges(..))));
        let mirror = pair.swapped().separation();
        assert!((mirror.distance - found.distance).abs() < 1e-14);
        assert_eq!(mirror.owner.map(swap), found.owner);
        let hinted = separation(&pair.a, &pair.pa, &pair.b, &pair.pb, found.owner, f64::INFINITY);
        assert_eq!(hinted, found);
        let hinted = separation(&pair.a, &pair.pa, &pair.b, &pair.pb, found.owner, 0.0);
        assert!((hinted.distance > 0.0) == (expected > 0.0));
        let depth = touchable_depth(&pair.a, &pair.pa, &pair.b, &pair.pb);
        assert!((depth - (-found.distance).max(0.0)).abs() < 1e-15);
    }
    assert!((20..100).contains(&apart) && edges > 20, "{apart} {edges}");
}

/// Error: that of the search by thirds.
#[test]
fn rounded_bodies_have_the_distance_of_their_cores() {
    let mut random = Random::new(73);
    let half = Vector3::new(0.5, 0.4, 0.3);
    let (cube, capsule, ball) = (ConvexBody::cuboid(half), ConvexBody::capsule(0.6, 0.15), ConvexBody::ball(0.2));
    let core = |p: &Placement, s: f64| p.point(&(Vector3::z() * (0.6 * s)));
    let mut kinds = [0; 6];
    for k in 0..600 {
        let mut pa = random.placement();
        pa.position = random.direction() * (1.1 + 0.5 * random.next());
        let pb = random.placement();
        let pair = Pair::new(
            [&capsule, &ball][k % 2],
            pa,
            [&cube, &capsule, &ball][k % 3],
            Placement { position: Vector3::zeros(), ..pb },
        );
        let to_box = |x: &Vector3<f64>| {
            let x = pair.pb.rotation.tr_mul(x);
            x.zip_map(&half, |x, h| (x.abs() - h).max(0.0)).norm()
        };
        let to_core = |x: &Vector3<f64>| match k % 3 {
            0 => to_box(x),
            1 => least(|t| (x - core(&pair.pb, t)).norm()),
            _ => x.norm(),
        };
        let distance = if k % 2 == 0 { least(|s| to_core(&core(&pair.pa, s))) } else { to_core(&pair.pa.position) };
        if distance < 1e-3 {
            continue;
        }
        let expected = distance - pair.a.rounding - pair.b.rounding;
        let (found, mirror) = (pair.separation(), pair.swapped().separation());
        assert!((found.distance - expected).abs() < 1e-8, "{k}: {found:?} {expected}");
        assert!((mirror.distance - found.distance).abs() < 1e-14);
        assert_eq!(mirror.owner.map(swap), found.owner);
        // The patch has the gap of the separation.
        let at = pair.geometry(&pair.topology(found.owner.unwrap(), 10.0));
        let gap = at.points.iter().map(|p| p.gap).fold(f64::INFINITY, f64::min);
        assert!((gap - found.distance).abs() < 1e-12, "{k}: {found:?} {gap}");
        kinds[match found.owner.unwrap() {
            Owner::FaceOfA(_) => 0,
            Owner::FaceOfB(_) => 1,
            Owner::Edges(..) => 2,
            Owner::VertexVertex(..) => 3,
            Owner::VertexOfAEdgeOfB(..) => 4,
            Owner::EdgeOfAVertexOfB(..) => 5,
            Owner::Curved(..) | Owner::Along(..) => unreachable!(),
        }] += 1;
    }
    assert!(kinds[0] == 0 && kinds[1..].iter().all(|&count| count > 10), "{kinds:?}");
}

/// Pairs brought to contact have a patch with a closed gap, no corner below the plane, and a
/// positive validity.
#[test]
fn random_pairs_in_contact_have_valid_patches() {
    let mut random = Random::new(79);
    for k in 0..300 {
        let (a, b) = match k % 4 {
            0 => (random.cuboid(), random.cuboid()),
            1 => (random.hull(12), random.hull(20)),
            2 => (ConvexBody::capsule(0.4, 0.1), random.hull(15)),
            _ => (ConvexBody::ball(0.3), random.cuboid()),
        };
        let mut pair = Pair::new(&a, random.placement(), &b, random.placement());
        pair.pa.position = pair.pb.position + random.direction() * 4.0;
        // A touches along the line between the bodies: the separation is a lower bound on the way.
        let way = (pair.pb.position - pair.pa.position).normalize();
        for _ in 0..4000 {
            let distance = pair.separation().distance;
            if distance < 1e-13 {
                break;
            }
            pair.pa.position += way * distance;
        }
        let found = pair.separation();
        assert!(found.distance.abs() < 1e-12, "{k}: {found:?}");
        let topology = pair.topology(found.owner.unwrap(), 1e-9);
        let at = pair.geometry(&topology);
        let gap = at.points.iter().map(|p| p.gap).fold(f64::INFINITY, f64::min);
        assert!(gap.abs() < 1e-9, "{k}: {topology:?} {gap}");
        assert!(pair.validity(&topology) > 0.0, "{k}: {topology:?}");
    }
}
