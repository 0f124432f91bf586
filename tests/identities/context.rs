//! Data passed to tasks, by identities: forces add up to the sensed wrench, Jacobians are
//! derivatives, nothing allocates.

use super::numeric::GRAVITY;
use super::random_tree::{Random, state, tree};
use crate::support::counting::count;
use nalgebra::{Rotation3, Vector3};
use stiction::geometry::Plane;
use stiction::robot::{Base, LinkId, Model, Sole};
use stiction::task::{AugmentedData, Needs, SensorReadings};

/// A random tree on soles with 1 to 6 vertices.
fn robot(seed: u64) -> Model {
    let mut model = tree(seed, 12, Base::Floating);
    let link = LinkId(model.links.len() - 1);
    model.soles = (1..=6)
        .map(|k| Sole {
            name: format!("sole {k}"),
            link,
            vertices: (0..k)
                .map(|i| std::f64::consts::TAU * f64::from(i) / f64::from(k))
                .map(|a| Vector3::new(0.1 * a.cos(), 0.05 * a.sin(), 0.0))
                .collect(),
        })
        .collect();
    model
}

/// The floor at the current pose of that link: its vertices are in the plane.
fn floor(model: &Model, data: &mut AugmentedData, at: &stiction::dynamics::State) -> Plane {
    data.update(model, at, &SensorReadings::blank(model), &GRAVITY, &Plane::LEVEL, Needs::SOLES);
    let link = LinkId(model.links.len() - 1);
    Plane { rotation: data.workspace.links[link.0].rotation, point: data.workspace.point(link, &Vector3::zeros()) }
}

#[test]
fn a_sensed_wrench_is_distributed_to_vertices_that_only_push() {
    let mut r = Random::new(21);
    let model = robot(3);
    let mut data = AugmentedData::new(&model);
    let at = state(&model, &mut r);
    let floor = floor(&model, &mut data, &at);
    for _ in 0..50 {
        let mut sensed = SensorReadings::blank(&model);
        let mut given = Vec::new();
        for (load, sole) in sensed.soles.iter_mut().zip(&model.soles) {
            // Random pushes on the vertices; the sensor measures their resultant. A point transmits
            // no moment, two points no moment about the line through them.
            let mean = sole.vertices.iter().sum::<Vector3<f64>>() / sole.vertices.len() as f64;
            for v in &sole.vertices {
                let f = r.list(3, 1.0);
                let force = floor.rotation * Vector3::new(0.2 * f[0], 0.2 * f[1], 5.0 + 5.0 * f[2]);
                load.force += force;
                load.moment += (floor.rotation * (v - mean)).cross(&force);
            }
            given.push((load.force, load.moment));
        }
        data.update(&model, &at, &sensed, &GRAVITY, &floor, Needs::CONTACTS | Needs::ZMP);
        let mut total = (0.0, Vector3::zeros());
        for (sole, (force, moment)) in data.soles.iter().zip(given) {
            let arms = sole.vertices.iter().map(|p| p - sole.position);
            let sum: Vector3<f64> = sole.vertex_forces.iter().sum();
            let turn: Vector3<f64> = arms.zip(&sole.vertex_forces).map(|(arm, f)| arm.cross(f)).sum();
            // Rounding, and the 1e-14 of damping in the split, times loads of 60 N.
            assert!((sum - force).norm() < 1e-10, "{sum} {force}");
            assert!((turn - moment).norm() < 1e-10, "{turn} {moment}");
            for (f, p) in sole.vertex_forces.iter().zip(&sole.vertices) {
                let n = floor.to_plane(f).z;
                assert!(n >= 0.0);
                total = (total.0 + n, total.1 + p * n);
            }
        }
        // All vertices lie in the plane, so the zero-moment point is the mean of their normal forces.
        assert!((data.zmp.unwrap() - total.1 / total.0).norm() < 1e-12);
        // A sole that carries more than two hundredths of the weight counts as loaded.
        let light = 0.02 * model.mass() * GRAVITY.norm();
        let stands = |s: &&stiction::task::augmented::SoleData| {
            s.vertex_forces.iter().map(|f| floor.to_plane(f).z).sum::<f64>() > light
        };
        let bears = |f: &&Vector3<f64>| floor.to_plane(f).z > 1e-9;
        let bearing = data.soles.iter().filter(stands).flat_map(|s| &s.vertex_forces).filter(bears).count();
        assert_eq!(data.contacts.len(), bearing);
    }
}

#[test]
fn a_centre_of_pressure_off_the_sole_is_moved_to_its_outline() {
    let model = robot(3);
    let mut data = AugmentedData::new(&model);
    let at = state(&model, &mut Random::new(22));
    let floor = floor(&model, &mut data, &at);
    for (s, arm) in
        [(3, Vector3::new(0.3, 0.0, 0.0)), (5, Vector3::new(0.1, 0.4, 0.0)), (1, Vector3::new(0.5, 0.1, 0.0))]
    {
        let mut sensed = SensorReadings::blank(&model);
        let force = floor.rotation * Vector3::new(0.0, 0.0, 10.0);
        sensed.soles[s].force = force;
        sensed.soles[s].moment = (floor.rotation * arm).cross(&force);
        data.update(&model, &at, &sensed, &GRAVITY, &floor, Needs::CONTACTS);
        let sole = &data.soles[s];
        let normal: Vec<f64> = sole.vertex_forces.iter().map(|f| floor.to_plane(f).z).collect();
        assert!((normal.iter().sum::<f64>() - 10.0).abs() < 1e-12 && normal.iter().all(|n| *n >= 0.0), "{normal:?}");
        let cop: Vector3<f64> = sole.vertices.iter().zip(&normal).map(|(p, n)| p * (n / 10.0)).sum();
        let unclamped = sole.position + floor.rotation * arm;
        // No point of the sole is nearer: tried at many points of its outline.
        let k = sole.vertices.len();
        let outline = (0..k).flat_map(|i| (0..=100).map(move |j| (i, f64::from(j) / 100.0)));
        let nearest = outline
            .map(|(i, t)| (sole.vertices[i] * (1.0 - t) + sole.vertices[(i + 1) % k] * t - unclamped).norm())
            .fold(f64::INFINITY, f64::min);
        assert!((cop - unclamped).norm() <= nearest + 1e-12, "{s}");
        assert!(data.contacts.iter().all(|c| c.sole == s) && (1..=2).contains(&data.contacts.len()));
    }
}

#[test]
fn the_base_jacobian_is_the_derivative_of_the_mass_centre_in_base_axes() {
    let mut r = Random::new(23);
    for base in [Base::Floating, Base::Fixed] {
        let model = tree(5, 20, base);
        let mut at = state(&model, &mut r);
        let mut data = AugmentedData::new(&model);
        let sensed = SensorReadings::blank(&model);
        let mut seen = |at: &stiction::dynamics::State| {
            data.update(&model, at, &sensed, &GRAVITY, &Plane::LEVEL, Needs::COM | Needs::COM_JACOBIAN_BASE);
            (at.rotation.inverse() * (data.com - at.position), data.com_jacobian_base.clone())
        };
        let jacobian = seen(&at).1;
        for j in 0..model.nj() {
            // Central difference: h^2 / 6 times a third derivative of some metres, rounding 1e-16 / h.
            let h = 1e-5;
            at.joints[j] += h;
            let after = seen(&at).0;
            at.joints[j] -= 2.0 * h;
            let before = seen(&at).0;
            at.joints[j] += h;
            let slope = (after - before) / (2.0 * h);
            let column = Vector3::from_column_slice(&jacobian[3 * j..3 * j + 3]);
            assert!((slope - column).norm() < 1e-9, "{j}: {slope} {column}");
        }
    }
}

#[test]
fn nothing_allocates_and_data_not_requested_are_unchanged() {
    let mut r = Random::new(24);
    let model = robot(7);
    let (a, b) = (state(&model, &mut r), state(&model, &mut r));
    let mut sensed = SensorReadings::blank(&model);
    for (s, load) in sensed.soles.iter_mut().enumerate() {
        load.force = Vector3::new(1.0, 2.0, 30.0);
        load.moment = Vector3::new(0.1, -0.2, 0.3);
        if s % 2 == 0 {
            load.resolved = true;
            load.clamped.fill(true);
        }
    }
    let mut data = AugmentedData::new(&model);
    let floor = Plane { rotation: Rotation3::from_euler_angles(0.1, 0.2, 0.3).into_inner(), point: Vector3::zeros() };
    assert_eq!(count(|| data.update(&model, &a, &sensed, &GRAVITY, &floor, Needs::ALL)), 0);
    assert!(data.stable_point.is_some() && data.stable_radius > 0.0 && data.support_polygon.len() > 2);
    let before = data.clone();
    assert_eq!(count(|| data.update(&model, &b, &sensed, &GRAVITY, &floor, Needs::COM)), 0);
    assert_ne!(data.com, before.com);
    assert_eq!(
        (data.com_jacobian, data.zmp, data.gravity_effort),
        (before.com_jacobian, before.zmp, before.gravity_effort)
    );
}
