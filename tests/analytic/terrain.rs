//! Contact with terrain: seams that change nothing, borders over which bodies tip, and robots on boxes.

use super::body::G;
use crate::support::runs::{finish, root, simulation};
use nalgebra::{UnitQuaternion, Vector3};
use std::fmt::Write;
use stiction::Scenario;
use stiction::sim::{Metrics, NullObserver, Simulation};

const TIGHT: &str = "integrator = { relative_tolerance = 1e-10, absolute_tolerance = 1e-12 }
    contact = { distance_tolerance = 1e-8, velocity_tolerance = 1e-8, acceleration_tolerance = 1e-8 }
    log = { rate = 0 }\n";

pub(super) fn finished(scenario: &str) -> (Simulation, Metrics) {
    let mut sim = simulation(&format!("{TIGHT}{scenario}"));
    let metrics = finish(&mut sim, &mut NullObserver);
    (sim, metrics)
}

/// A level surface at height 0.2 m: as a plane, one box, two boxes, a height field, a mesh.
fn surfaces(folder: &std::path::Path) -> [(&'static str, String); 5] {
    let row = ["0.25"; 12].join(",");
    std::fs::write(folder.join("flat.csv"), vec![row; 12].join("\n")).unwrap();
    let mut mesh = String::new();
    let n = 7;
    for k in 0..(n + 1) * (n + 1) {
        let at = |k: usize| -2.0 + 4.0 * k as f64 / n as f64;
        writeln!(mesh, "v {} {} 0.25", at(k / (n + 1)), at(k % (n + 1))).unwrap();
    }
    for k in 0..n * n {
        let a = k / n * (n + 1) + k % n + 1;
        let b = a + n + 1;
        writeln!(mesh, "f {a} {b} {}\nf {a} {} {}", b + 1, b + 1, a + 1).unwrap();
    }
    std::fs::write(folder.join("flat.obj"), mesh).unwrap();
    let path = |name: &str| folder.join(name).display().to_string();
    [
        ("plane", "floor = { friction = 0.4, height = 0.25 }\n".into()),
        (
            "box",
            "floor.friction = 0.4\nterrain = [{ type = \"box\", size = [4, 4, 0.25], position = [0, 0, 0.125] }]\n"
                .into(),
        ),
        (
            "seam",
            "floor.friction = 0.4\nterrain = [
                { type = \"box\", size = [2, 4, 0.25], position = [-0.85, 0, 0.125] },
                { type = \"box\", size = [2, 4, 0.25], position = [1.15, 0, 0.125] },
            ]\n"
            .into(),
        ),
        (
            "height field",
            format!(
                "floor.friction = 0.4\nterrain = [{{ type = \"heightfield\", file = {:?}, size = [2.03, 2.11] }}]\n",
                path("flat.csv")
            ),
        ),
        ("mesh", format!("floor.friction = 0.4\nterrain = [{{ type = \"mesh\", file = {:?} }}]\n", path("flat.obj"))),
    ]
}

/// A box that slides, turns and stops on each of these surfaces, across seams.
#[test]
fn a_box_slides_alike_on_every_level_surface() {
    let folder = tempfile::tempdir().unwrap();
    let mut reference: Option<(Vector3<f64>, UnitQuaternion<f64>)> = None;
    for (name, surface) in surfaces(folder.path()) {
        let (sim, m) = finished(&format!(
            "{surface}duration = 1.0
            robot = {{ model = \"robots/ground/ground.urdf\" }}
            object = [{{ type = \"box\", size = [0.2, 0.1, 0.1], mass = 2.0, position = [0, 0, 0.3], linear_velocity = [2.0, 0.3, 0], angular_velocity = [0, 0, 1] }}]"
        ));
        let state = &sim.plant().objects.list[0].state;
        let found = (state.position, state.rotation);
        let (position, rotation) = *reference.get_or_insert(found);
        // Steps end at other instants: errors of the integrator, and of 1e-9 m at borders.
        assert!((found.0 - position).norm() < 2e-9, "{name}: {}", (found.0 - position).norm());
        assert!(found.1.angle_to(&rotation) < 2e-8, "{name}: {}", found.1.angle_to(&rotation));
        assert!(m.impact_loss_j.abs() < 1e-9 && m.inconsistent == 0 && m.impacts == 0, "{name}: {m:?}");
        assert!(m.energy_error_j.abs() < 1e-9 && m.max_penetration_m < 2e-9, "{name}: {m:?}");
    }
}

/// A box slides obliquely over seams between pieces: at each instant its velocity is v0 - mu g t, so that no seam
/// changes it.
#[test]
fn no_seam_changes_the_velocity_of_a_box() {
    let folder = tempfile::tempdir().unwrap();
    let (v0, mu) = (Vector3::new(1.92, 0.56, 0.0), 0.4);
    let has_seams = |(name, _): &(&str, String)| ["seam", "height field", "mesh"].contains(name);
    for (name, surface) in surfaces(folder.path()).into_iter().filter(has_seams) {
        let mut sim = simulation(&format!(
            "{TIGHT}duration = 0.4
            robot = {{ model = \"robots/ground/ground.urdf\" }}
            object = [{{ type = \"box\", size = [0.2, 0.1, 0.1], mass = 2.0, position = [-0.3, 0, 0.3], linear_velocity = [1.92, 0.56, 0] }}]
            {surface}"
        ));
        sim.begin(&mut NullObserver).unwrap();
        let mut steps = 0;
        while sim.plant().state.time < 0.4 {
            sim.step(&mut NullObserver).unwrap();
            let (t, state) = (sim.plant().state.time, &sim.plant().objects.list[0].state);
            let expected = v0 - v0.normalize() * (mu * G * t);
            let error = (0..3).map(|k| (state.v[k] - expected[k]).abs().max(state.v[3 + k].abs())).fold(0.0, f64::max);
            assert!(error < 1e-12, "{name} {t} {error:e}");
            steps += 1;
        }
        let position = sim.plant().objects.list[0].state.position;
        assert!(steps > 4 && position.x > 0.1, "{name} {steps} {position}");
    }
}

/// The soles of a robot on each of them.
#[test]
fn a_block_slides_alike_on_every_level_surface() {
    let folder = tempfile::tempdir().unwrap();
    for (name, surface) in surfaces(folder.path()) {
        let (_, m) = finished(&format!(
            "{surface}duration = 1.0
            robot = {{ model = \"robots/block/block.toml\", base = {{ position = [0, 0, 0.3], linear_velocity = [2, 0.3, 0] }} }}"
        ));
        let way = (4.0 + 0.09) / (2.0 * 0.4 * G);
        assert!((m.final_base_shift_m - way).abs() < 2e-9, "{name}: {}", m.final_base_shift_m - way);
        assert!(m.impact_loss_j.abs() < 1e-9 && m.inconsistent == 0, "{name}: {m:?}");
    }
}

/// Without friction a box moves at constant speed until its centre is over the table's edge, then tips.
#[test]
fn a_box_tips_when_its_centre_passes_the_edge_of_a_table() {
    let (sim, m) = finished(
        "duration = 0.25
        floor.friction = 0.0
        terrain = [{ type = \"box\", size = [1, 1, 0.5], position = [0, 0, 0.25] }]
        robot = { model = \"robots/ground/ground.urdf\" }
        object = [{ type = \"box\", size = [0.3, 0.1, 0.1], mass = 2.0, position = [0.3, 0.1, 0.55], linear_velocity = [1, 0, 0] }]",
    );
    assert!((m.first_tip_s.unwrap() - 0.2).abs() < 1e-9, "{:?}", m.first_tip_s);
    let state = &sim.plant().objects.list[0].state;
    // The frictionless edge is below the centre at first: horizontal velocity remains, and the box turns.
    assert!(state.v[4] > 0.1 && m.energy_error_j.abs() < 1e-9 && m.inconsistent == 0, "{} {m:?}", state.v[4]);
}

/// The same of a short box: its corners leave the table, an event, shortly before its centre does.
#[test]
fn a_short_box_tips_when_its_centre_passes_the_edge_of_a_table() {
    let (_, m) = finished(
        "duration = 0.13
        floor.friction = 0.0
        terrain = [{ type = \"box\", size = [1, 1, 0.5], position = [0, 0, 0.25] }]
        robot = { model = \"robots/ground/ground.urdf\" }
        object = [{ type = \"box\", size = [0.06, 0.06, 0.06], mass = 2.0, position = [0.39, 0.1, 0.53], linear_velocity = [1, 0, 0] }]",
    );
    // Corners are the same within 1e-9 m.
    assert!((m.first_tip_s.unwrap() - 0.11).abs() < 2e-9, "{:?}", m.first_tip_s);
}

/// A humanoid that is pushed moves alike on a plane and on a box.
#[test]
fn a_humanoid_moves_alike_on_a_plane_and_on_a_box() {
    let end = |surface: &str| {
        let (_, m) = finished(&format!(
            "{surface}duration = 0.6
            robot = {{ model = \"robots/hoap2/hoap2.toml\", base = {{ position = [0, 0, 0.534] }} }}
            force = [{{ type = \"push\", link = \"torso\", force = [15, 5, 0], start = 0.2, duration = 0.1 }}]"
        ));
        assert!(m.inconsistent == 0 && m.max_penetration_m < 1e-9, "{surface} {m:?}");
        // 1.5 ms in sliding modes, whose tolerances are those of steps to the power of 2/3: at most 2.2e-8 J in ten runs
        // with almost equal pushes.
        assert!(m.max_energy_error_j < 3e-8, "{surface} {m:?}");
        (Vector3::from(m.final_base_position), m.first_tip_s)
    };
    let plane = end("floor.height = 0.25\n");
    let box_ = end("terrain = [{ type = \"box\", size = [1, 1, 0.25], position = [0, 0, 0.125] }]\n");
    // Integration errors of different steps, which unstable rocking multiplies.
    assert!((plane.0 - box_.0).norm() < 1e-8, "{:?} {:?}", plane, box_);
    assert!((plane.1.unwrap_or(0.0) - box_.1.unwrap_or(0.0)).abs() < 1e-8, "{:?} {:?}", plane, box_);
}

/// A box on a ramp: it slides with g (sin a - mu cos a), or stands.
#[test]
fn a_box_slides_down_a_ramp_or_stands() {
    let angle = (0.5f64).atan();
    for (mu, slides) in [(0.3, true), (0.6, false)] {
        let up = Vector3::new(-angle.sin(), 0.0, angle.cos());
        let along = Vector3::new(angle.cos(), 0.0, angle.sin());
        let start = along * 1.5 + up * 0.05;
        let (sim, m) = finished(&format!(
            "duration = 0.5
            floor.friction = {mu}
            terrain = [{{ type = \"ramp\", size = [2, 1, 1] }}]
            robot = {{ model = \"robots/ground/ground.urdf\" }}
            object = [{{ type = \"box\", size = [0.2, 0.1, 0.1], mass = 2.0, position = [{}, 0, {}], rpy = [0, {}, 0] }}]",
            start.x, start.z, -angle
        ));
        let a = if slides { G * (angle.sin() - mu * angle.cos()) } else { 0.0 };
        let found = sim.plant().objects.list[0].state.position;
        assert!((found - start + along * (0.125 * a)).norm() < 1e-9, "{mu}: {found}");
        assert!(m.inconsistent == 0 && m.energy_error_j.abs() < 1e-9, "{mu}: {m:?}");
    }
}

#[test]
fn nothing_touches_an_absent_plane() {
    let (_, m) = finished(
        "duration = 1.0
        floor.plane = false
        robot = { model = \"robots/block/block.toml\", base = { position = [0, 0, 0.05] } }",
    );
    assert!((m.final_base_position[2] - 0.05 + 0.5 * G).abs() < 1e-9, "{:?}", m.final_base_position);
}

/// A robot inside the prisms of a height field, whose walls cannot be touched.
#[test]
fn starts_inside_terrain_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let [_, _, _, (_, field), _] = surfaces(folder.path());
    let text = format!(
        "{field}robot = {{ model = \"robots/block/block.toml\", base = {{ position = [0.013, 0.02, 0.29] }} }}"
    );
    let file = stiction::scenario::parse(&root().join("test.toml"), text).unwrap();
    let run = file.expand(&[]).unwrap().remove(0);
    let robot = stiction::robot::load(&run.resolve(&run.scenario.robot.model)).unwrap();
    let error = stiction::assemble::setup(&run, &robot).err().unwrap().to_string();
    assert!(error.contains("`block` and `terrain.0` overlap by 0.0100 m at the start"), "{error}");
}

/// Of two neighbours in one plane either could own the contact with a point of terrain, also the one that does not
/// contain the point.
#[test]
fn hulls_of_links_have_no_neighbours_in_one_plane() {
    for robot in ["hoap2", "cbi", "quadruped"] {
        let sim = simulation(&format!(
            "robot = {{ model = \"robots/{robot}/{robot}.toml\", contact = \"bodies\", base = {{ position = [0, 0, 3] }} }}
            terrain = [{{ type = \"box\", size = [1, 1, 0.1] }}]"
        ));
        let mut checked = 0;
        for body in &sim.plant().bodies {
            for edge in body.shape.edges.iter().filter(|edge| !edge.has_no_faces()) {
                let [m, n] = edge.faces.map(|k| body.shape.face(k).normal);
                // Points within 1e-9 of the size of a hull from a plane belong to one face.
                assert!(m.cross(&n).norm() > 1e-9, "{}: {m} {n}", body.name);
                checked += 1;
            }
        }
        assert!(checked > 100);
    }
}

/// Two falls of the quadruped. In the first a point of the rubble, between two coplanar faces of a hull, was not
/// seen: the body sank in by 0.02 mm.
#[test]
fn a_robot_that_falls_on_rubble_does_not_sink_in() {
    let falls = [
        (1.1, [-1.93, 0.128, 1.2], [1.89, 1.416, 0.454], [0.112, -0.228, -0.166], [-2.73, -1.044], 0.604),
        (1.6, [-0.776, 0.453, 1.2], [-0.118, 0.37, 2.905], [0.265, 0.1, -1.526], [1.678, -1.955], 2.713),
    ];
    for (duration, position, rpy, velocity, [wx, wy], scale) in falls {
        let mut sim = simulation(&format!(
            "duration = {duration}
            floor.friction = 0.4
            terrain = [{{ type = \"heightfield\", file = \"scenarios/terrain/rubble.csv\", size = [2.0, 3.0], position = [-1, 0, 0], scale = {scale} }}]
            robot = {{ model = \"robots/quadruped/quadruped.toml\", contact = \"bodies\", base = {{ position = {position:?}, rpy = {rpy:?}, linear_velocity = {velocity:?}, angular_velocity = [{wx}, {wy}, 0] }} }}"
        ));
        let m = finish(&mut sim, &mut NullObserver);
        assert!(m.max_penetration_m < 1e-8 && m.inconsistent == 0, "{duration}: {}", m.max_penetration_m);
        // Energies are not under error control: 3e-7 J here.
        assert!(m.impacts > 5 && m.energy_error_j.abs() < 1e-5, "{duration}: {} J", m.energy_error_j);
    }
}

/// A level box whose lower side touches the peak of a height field, on which six triangles meet, at a distance d
/// from below its centre of mass. The peak does not slip, so that the box turns about it:
///
/// ```text
/// alpha = m g d / (I + m (d^2 + c^2))     N = m (g - alpha d)     T = m alpha c
/// ```
///
/// with its half height c, I about the axis through the centre of mass.
#[test]
fn a_box_meets_a_peak_of_a_height_field_once() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("peak.csv"), "0,0,0\n0,0.25,0\n0,0,0\n").unwrap();
    let file = folder.path().join("peak.csv").display().to_string();
    let (mass, d, c) = (2.0, 0.03125, 0.0625);
    let mut sim = simulation(&format!(
        "{TIGHT}duration = 0.02
        floor.friction = 0.9
        robot = {{ model = \"robots/ground/ground.urdf\" }}
        terrain = [{{ type = \"heightfield\", file = {file:?}, size = [2.0, 2.0] }}]
        object = [{{ type = \"box\", size = [0.5, 0.25, 0.125], mass = {mass}, position = [{d}, 0, 0.3125] }}]"
    ));
    sim.begin(&mut NullObserver).unwrap();
    let loads: Vec<f64> = sim.plant().solution.normal.iter().flatten().copied().filter(|n| *n != 0.0).collect();
    let inertia = mass / 12.0 * (0.5 * 0.5 + 0.125 * 0.125);
    let alpha = mass * G * d / (inertia + mass * (d * d + c * c));
    assert_eq!(loads.len(), 1, "{loads:?}");
    // Rounding.
    assert!((loads[0] - mass * (G - alpha * d)).abs() < 1e-11, "{loads:?}");
    let m = finish(&mut sim, &mut NullObserver);
    let turned = sim.plant().objects.list[0].state.rotation.angle();
    // The turn is alpha t^2 / 2 up to the fourth order of t; the energy is that of the integrator.
    assert!((turned / (0.5 * alpha * 4e-4) - 1.0).abs() < 1e-2, "{turned}");
    assert!(m.max_penetration_m < 1e-9 && m.energy_error_j.abs() < 1e-10 && m.inconsistent == 0, "{m:?}");
}

/// Two falls of `scenarios/studies/falls.toml`, whose contacts creep ever slower, at their limits of friction. The
/// runs ended as stalled, as errors of the steps stopped contacts and turned them round thousands of times.
#[test]
fn robots_that_creep_come_to_rest() {
    let study = Scenario::load(root().join("scenarios/studies/falls.toml")).unwrap();
    let falls = study.set("seed", 1).set("sweep.random.samples", 12).runs().unwrap();
    for i in [5, 6] {
        let mut sim = falls[i].simulation().unwrap();
        let m = finish(&mut sim, &mut NullObserver);
        let speed = sim.plant().each_velocity().fold(0.0, |most: f64, v| most.max(v.abs()));
        // Joint speeds that the servos have not damped yet.
        assert!(m.sliding_mode_s < 0.1 && speed < 1e-7, "{i}: {} s, {speed}", m.sliding_mode_s);
        assert!(m.max_penetration_m < 1e-9 && m.max_cone_excess < 1e-9 && m.inconsistent == 0, "{i}: {m:?}");
        // Impacts and slow slips before the rest.
        assert!(m.energy_error_j.abs() < 1e-4, "{i}: {} J", m.energy_error_j);
    }
}
