//! Patches of different friction: a vertex that crosses a border changes its friction at the border
//! and nowhere else.

use super::body::{Body, G};
use super::planar::{corners, derivative_on};
use crate::support::runs::{TIGHT, rk4, run, simulation, watch};
use nalgebra::{Rotation3, Vector2, Vector3};
use stiction::assemble;
use stiction::robot;
use stiction::scenario;

/// A patch that begins across a heading after `distance` and has no end within reach; its border is
/// `skew` from perpendicular.
fn ahead(heading: f64, distance: f64, skew: f64) -> [[f64; 2]; 4] {
    let turned = |x: f64, y: f64| {
        let (s, c) = heading.sin_cos();
        [x * c - y * s, x * s + y * c]
    };
    let slant = skew.tan();
    [
        turned(distance - 3.0 * slant, -3.0),
        turned(distance + 9.0, -3.0),
        turned(distance + 9.0, 3.0),
        turned(distance + 3.0 * slant, 3.0),
    ]
}

fn point_foot(floor: &str, velocity: [f64; 2], rpy: [f64; 3]) -> String {
    let [x, y] = velocity;
    let v = Rotation3::from_euler_angles(rpy[0], rpy[1], rpy[2]) * Vector3::new(x, y, 0.0);
    format!(
        "duration = 2.0
        stop = {{ sunk_link = \"ignore\" }}
        [robot]
        model = \"robots/block/block.toml\"
        contact = \"soles\"
        base = {{ linear_velocity = [{}, {}, {}] }}
        soles = [{{ name = \"point\", link = \"block\", polygon = [[0, 0, 0]] }}]
        [floor]
        {floor}
        [integrator]
        relative_tolerance = 1e-9
        absolute_tolerance = 1e-11
        [contact]
        distance_tolerance = 1e-8
        velocity_tolerance = 1e-8
        acceleration_tolerance = 1e-8\n",
        v.x, v.y, v.z
    )
}

// Each event is located to 1e-13 of a step of 0.01 s. A border is left 1e-12 m beyond itself, which
// at 0.1 m/s takes 1e-11 s. With distances of some 0.1 m and the integrator's 1e-9, these
// tolerances have a margin of ten.
const RELATIVE: f64 = 1e-8;

#[test]
fn a_mass_point_stops_after_the_closed_distance_for_every_heading_and_skew() {
    for k in 0..12 {
        let heading = 0.1 + k as f64 * std::f64::consts::TAU / 12.0;
        for (speed, mu, skew) in [(2.0, [0.5, 0.25], 0.0), (1.5, [0.1, 0.7], 0.6), (1.0, [0.02, 0.3], -1.1)] {
            let (d, before) = (0.3, 2.0 * mu[0] * G * 0.3);
            let at_border = (speed * speed - before).sqrt();
            let floor = format!(
                "friction = {}\npatches = [{{ polygon = {:?}, friction = {} }}]",
                mu[0],
                ahead(heading, d, skew),
                mu[1]
            );
            let (s, c) = heading.sin_cos();
            let (m, recording) = watch(&point_foot(&floor, [speed * c, speed * s], [0.0; 3]));
            let way = d + at_border * at_border / (2.0 * mu[1] * G);
            let time = (speed - at_border) / (mu[0] * G) + at_border / (mu[1] * G);
            let [x, y, _] = m.final_base_position;
            assert!(((x * c + y * s) / way - 1.0).abs() < RELATIVE, "{}", (x * c + y * s) / way - 1.0);
            assert!((x * s - y * c).abs() < 1e-9, "sideways {}", x * s - y * c);
            assert!((m.first_stick_s.expect("it stops") / time - 1.0).abs() < RELATIVE);
            let border: Vec<_> = recording.events.iter().filter(|e| e.kind == "border").collect();
            assert_eq!(border.len(), 1);
            assert_eq!(border[0].message, "vertex 0 onto patch 0");
            assert!((border[0].time / ((speed - at_border) / (mu[0] * G)) - 1.0).abs() < RELATIVE);
            assert_eq!((m.inconsistent, m.state_changes), (0, 1));
        }
    }
}

#[test]
fn the_later_of_two_patches_applies_and_no_step_skips_a_narrow_strip() {
    // Floor to 0.2, first patch to 0.5 except for a strip of 2 mm of the second, then floor again.
    // A step at 2 m/s is 20 mm.
    let (mu, speed) = ([0.3, 0.1, 0.9], 2.0);
    let floor = format!(
        "friction = {}
        patches = [
            {{ polygon = [[0.2, -1], [0.5, -1, 7], [0.5, 1, 7], [0.2, 1]], friction = {} }},
            {{ polygon = [[0.31, -1], [0.312, -1], [0.312, 1], [0.31, 1]], friction = {{ static = 1.0, kinetic = {} }} }},
        ]",
        mu[0], mu[1], mu[2]
    );
    let (m, recording) = watch(&point_foot(&floor, [speed, 0.0], [0.0; 3]));
    let lost = mu[0] * 0.2 + mu[1] * (0.3 - 0.002) + mu[2] * 0.002;
    let way = 0.5 + (speed * speed - 2.0 * G * lost) / (2.0 * mu[0] * G);
    assert!((m.final_base_position[0] / way - 1.0).abs() < RELATIVE, "{}", m.final_base_position[0] / way - 1.0);
    let onto: Vec<_> = recording.events.iter().filter(|e| e.kind == "border").map(|e| &e.message[14..]).collect();
    assert_eq!(onto, ["patch 0", "patch 1", "patch 0", "the floor"]);
}

#[test]
fn on_a_slope_a_patch_is_defined_by_its_vertical_projection() {
    for (rpy, heading) in [([0.3, 0.0, 0.0], 0.7), ([-0.2, 0.25, 1.0], 2.0), ([0.0, -0.4, 2.0], -1.0)] {
        let tilt = Rotation3::from_euler_angles(rpy[0], rpy[1], rpy[2]);
        let g = tilt.inverse() * Vector3::new(0.0, 0.0, -G);
        let (speed, mu) = (1.0, [0.1, 0.02]);
        // On the line of steepest descent the point stays on it.
        let (d, down) = (0.2, Vector2::new(g.x, g.y));
        let along = down.normalize();
        let seen = (tilt * Vector3::new(along.x, along.y, 0.0)).xy();
        let floor = format!(
            "friction = {}\nrpy = {rpy:?}\npatches = [{{ polygon = {:?}, friction = {} }}]",
            mu[0],
            ahead(seen.y.atan2(seen.x), d * seen.norm(), 0.2 * heading),
            mu[1]
        );
        let text =
            point_foot(&floor, [speed * along.x, speed * along.y], rpy).replace("duration = 2.0", "duration = 0.5");
        let m = run(&text);
        let a = mu.map(|mu| down.norm() + mu * g.z);
        let at_border = (speed * speed + 2.0 * a[0] * d).sqrt();
        let rest = 0.5 - (at_border - speed) / a[0];
        let way = d + at_border * rest + 0.5 * a[1] * rest * rest;
        let end = Vector3::from(m.final_base_position);
        assert!((end.xy() - seen * way).norm() < RELATIVE * way, "{rpy:?} {}", (end.xy() - seen * way).norm());
    }
}

#[test]
fn a_block_slides_onto_a_patch_with_its_front_edge_first() {
    for (body, mu) in [
        (Body::new([0.1, 0.1, 0.05], 1.0), [0.5, 0.2]),
        (Body::new([0.12, 0.06, 0.03], 2.5), [0.1, 0.8]),
        (Body::new([0.05, 0.08, 0.02], 0.4), [0.3, 0.0]),
    ] {
        let [a, _, c] = body.half;
        for yaw in [0.0, 0.9, -2.2] {
            let (speed, d) = (2.5, 0.15);
            let patch = ahead(yaw, a + d, 0.0);
            let end = ahead(yaw, a + d + 0.6, 0.0);
            let polygon = [patch[0], end[0], end[3], patch[3]];
            let velocity = [speed * f64::cos(yaw), speed * f64::sin(yaw), 0.0];
            let text = format!(
                "duration = 3.0\nfloor = {{ friction = {}, patches = [{{ polygon = {polygon:?}, friction = {} }}] }}\n{}{TIGHT}",
                mu[0],
                mu[1],
                body.robot(&format!("rpy = [0.0, 0.0, {yaw}], linear_velocity = {velocity:?}"))
            );
            // N_f + N_r = m g and a (N_f - N_r) = c (mu_f N_f + mu_r N_r).
            let slows = |front: f64, rear: f64| {
                let k = (a + c * rear) / (a - c * front);
                G * (k * front + rear) / (1.0 + k)
            };
            let (out, on) = (mu[0], mu[1]);
            let phases =
                [(out, out, d), (on, out, 2.0 * a), (on, on, 0.6 - 2.0 * a), (out, on, 2.0 * a), (out, out, 9.0)];
            let (mut way, mut square) = (0.0, speed * speed);
            for (front, rear, length) in phases {
                let lost = 2.0 * slows(front, rear) * length;
                if lost > square {
                    way += length * square / lost;
                    break;
                }
                (way, square) = (way + length, square - lost);
            }
            let m = run(&text);
            let [x, y, z] = m.final_base_position;
            let (s, cos) = yaw.sin_cos();
            assert!(
                ((x * cos + y * s) / way - 1.0).abs() < RELATIVE,
                "{mu:?} {yaw}: {}",
                (x * cos + y * s) / way - 1.0
            );
            assert!((x * s - y * cos).abs() < 1e-9 && (m.final_base_rpy[2] - yaw).abs() < 1e-9);
            assert!((z - c).abs() < 1e-9 && m.max_lift_m.unwrap() < 1e-9);
            assert_eq!((m.inconsistent, m.impacts), (0, 0));
        }
    }
}

#[test]
fn a_block_half_on_ice_rotates_as_the_quadrature_predicts() {
    for (body, velocity, spin, mu) in [
        (Body::new([0.1, 0.1, 0.05], 1.0), [2.0, 0.0], 0.0, [0.4, 0.05]),
        (Body::new([0.12, 0.06, 0.03], 2.5), [1.5, 0.3], 2.0, [0.2, 0.5]),
    ] {
        let (yaw, duration) = (0.1, 0.35);
        // Ice where y > 0.01 m.
        let border = 0.01;
        let text = format!(
            "duration = {duration}
            floor = {{ friction = {}, patches = [{{ polygon = [[-5, {border}], [5, {border}], [5, 5], [-5, 5]], friction = {} }}] }}
            {}{TIGHT}",
            mu[0],
            mu[1],
            body.robot(&format!(
                "rpy = [0.0, 0.0, {yaw}], linear_velocity = [{}, {}, 0.0], angular_velocity = [0.0, 0.0, {spin}]",
                velocity[0], velocity[1]
            ))
        );
        let heights = |s: &[f64; 6]| corners(&body, s[2]).map(|r| s[1] + r.y - border);
        let start = [0.0, 0.0, yaw, velocity[0], velocity[1], spin];
        // Runge-Kutta with constant friction at each corner, until the first corner changes sides.
        let (mut at, mut t, mut crossings) = (start, 0.0_f64, 0);
        let mut ice = heights(&at).map(|h| h > 0.0);
        while t < duration {
            let friction = |ice: [bool; 4]| ice.map(|i| if i { mu[1] } else { mu[0] });
            let go = |h: f64| rk4(at, h, 1, |_, s| derivative_on(&body, friction(ice), s));
            let stays = |s: &[f64; 6]| heights(s).iter().zip(ice).all(|(h, ice)| (*h > 0.0) == ice);
            let full = (duration - t).min(2e-4);
            if stays(&go(full)) {
                (at, t) = (go(full), t + full);
                continue;
            }
            let (mut lo, mut hi) = (0.0, full);
            while hi - lo > 1e-15 {
                let mid = 0.5 * (lo + hi);
                if stays(&go(mid)) { lo = mid } else { hi = mid }
            }
            (at, t) = (go(hi), t + hi);
            ice = heights(&at).map(|h| h > 0.0);
            crossings += 1;
        }
        let (m, recording) = watch(&text);
        let end = [m.final_base_position[0], m.final_base_position[1], m.final_base_rpy[2]];
        println!("{end:?} {at:?} {crossings}");
        assert!(crossings > 0 && (at[2] - yaw).abs() > 0.05, "it turns, and corners cross: {crossings} {at:?}");
        assert_eq!(recording.events.iter().filter(|e| e.kind == "border").count(), crossings);
        for (have, want) in end.iter().zip(at) {
            // Both integrate to some 1e-10; no stop within the time.
            assert!((have - want).abs() < 1e-8, "{end:?} {at:?}");
        }
        assert_eq!((m.inconsistent, m.state_changes), (0, 0));
    }
}

#[test]
fn a_vertex_that_slides_along_a_border_causes_no_events() {
    // Two corners move exactly along the border of a patch that is as rough as the floor: nothing
    // deflects the block.
    let text = |mu: f64| {
        format!(
            "duration = 1.0
            robot = {{ model = \"robots/block/block.toml\", contact = \"soles\", base = {{ linear_velocity = [2.0, 0.0, 0.0] }} }}
            floor = {{ friction = 0.5, patches = [{{ polygon = [[-1, 0.1], [3, 0.1], [3, 1], [-1, 1]], friction = {mu} }}] }}\n{TIGHT}"
        )
    };
    let (m, recording) = watch(&text(0.5));
    assert!((m.final_base_position[0] - 4.0 / G).abs() < 1e-9);
    assert_eq!(recording.events.iter().filter(|e| e.kind == "border").count(), 0);
    // If the patch is rougher or smoother, its friction applies on the border: the block rotates,
    // and each corner leaves the border once at most.
    for mu in [0.1, 0.9] {
        let (m, recording) = watch(&text(mu));
        let borders = recording.events.iter().filter(|e| e.kind == "border").count();
        println!("{mu} {borders} {m:?}");
        assert!(m.final_base_rpy[2].abs() > 1e-3, "it turns: {:?}", m.final_base_rpy);
        assert!(borders <= 4 && m.inconsistent == 0, "{borders}");
    }
}

#[test]
fn a_foot_held_on_a_border_by_friction_causes_finitely_many_events() {
    // The left foot slides along the border between rough floor and ice. On the floor its friction
    // rotates the body so that this foot, ahead of the mass, moves outwards onto the ice. There the
    // right foot's friction rotates it back.
    let [floor, ice, right] = [0.8, 0.1, 0.4];
    let m = run(&format!(
        "duration = 1.0
        floor = {{ friction = {floor}, patches = [
            {{ polygon = [[-1, 0.1], [3, 0.1], [3, 1], [-1, 1]], friction = {ice} }},
            {{ polygon = [[-1, -0.05], [3, -0.05], [3, -1], [-1, -1]], friction = {right} }},
        ] }}
        {TIGHT}
        [robot]
        model = \"robots/block/block.toml\"
        contact = \"soles\"
        base = {{ linear_velocity = [2.0, 0.0, 0.0] }}
        soles = [
            {{ name = \"left\", link = \"block\", polygon = [[0.05, 0.1, -0.05]] }},
            {{ name = \"right\", link = \"block\", polygon = [[0.05, -0.1, -0.05]] }},
            {{ name = \"tail\", link = \"block\", polygon = [[-0.1, 0.0, -0.05]] }},
        ]
"
    ));
    // On the border the left foot's mean friction must balance the right one's: no rotation. With N
    // at both front feet and T at the tail: 2 N + T = m g and 0.05 (2 N) - 0.1 T = 0.05 (2 N right
    // + T floor).
    let ratio = (0.05 - 0.05 * right) / (0.1 + 0.05 * floor);
    let slows = G * (right + ratio * floor) / (1.0 + ratio);
    println!("{} {} {m:?}", m.final_base_position[0], 2.0 / slows);
    // Without hysteresis the foot would cross the border more than 3000 times.
    assert!(m.events > 10 && m.events < 300, "{}", m.events);
    // The foot deviates a micrometre from the border, and rotates the body by some 1e-5.
    assert!(m.final_base_rpy[2].abs() < 1e-4, "{}", m.final_base_rpy[2]);
    assert!(
        (m.final_base_position[0] / (2.0 / slows) - 1.0).abs() < 1e-3,
        "{}",
        m.final_base_position[0] * slows / 2.0
    );
}

#[test]
fn fixed_steps_evaluate_friction_at_each_step() {
    let floor = "friction = 0.5\npatches = [{ polygon = [[0.3, -1], [3, -1], [3, 1], [0.3, 1]], friction = 0.25 }]";
    let exact = 0.3 + (4.0 - 2.0 * 0.5 * G * 0.3) / (2.0 * 0.25 * G);
    for method in ["exact", "one-step"] {
        let error = |step: f64| {
            let text = point_foot(floor, [2.0, 0.0], [0.0; 3])
                .replace("[integrator]", &format!("[integrator]\nmethod = \"semi-implicit\"\nstep = {step}"))
                .replace("[contact]", &format!("[contact]\nmethod = \"{method}\""));
            (run(&text).final_base_position[0] - exact).abs()
        };
        // Each step moves with the velocity at its end, v dt / 2 short in all, which before the
        // border costs mu1 / mu2 of it. The border takes effect up to a step late, (mu1 - mu2) g dt
        // of speed for the remaining v_b / (mu2 g) s.
        let at_border = (4.0 - 2.0 * 0.5 * G * 0.3).sqrt();
        let bound = 2.0 * 0.5 * (2.0 - at_border) + 0.5 * at_border + at_border;
        for step in [1e-3, 2e-4] {
            assert!(error(step) < bound * step + 1e-6 && error(step) > 0.2 * step, "{method} {step} {}", error(step));
        }
    }
    // Dormand-Prince without located events: friction changes at the ends of steps of up to a
    // millisecond.
    for (key, value) in [("method", "one-step"), ("events", "step")] {
        let text = point_foot(floor, [2.0, 0.0], [0.0; 3])
            .replace("[integrator]", "[integrator]\nmax_step = 1e-3")
            .replace("[contact]", &format!("[contact]\n{key} = \"{value}\""));
        let error = (run(&text).final_base_position[0] - exact).abs();
        assert!(error < 1.1e-3 && error > 1e-9, "{key} {error}");
    }
}

#[test]
fn a_vertical_floor_has_no_patches() {
    let text = "robot = { model = \"robots/block/block.toml\", contact = \"soles\" }
        floor = { rpy = [\"90 deg\", 0, 0], patches = [{ polygon = [[0, 0], [1, 0], [1, 1]], friction = 0.1 }] }\n";
    let file = scenario::parse(std::path::Path::new("test.toml"), text).expect("its values are sound");
    let runs = file.expand(&[]).expect("one run");
    let robot = robot::load(&crate::support::runs::root().join("robots/block/block.toml")).expect("the block");
    let errors = assemble::setup(&runs[0], &robot).err().expect("it is refused").to_string();
    assert!(errors.contains("are projected vertically") && errors.contains("test.toml:2"), "{errors}");
}

#[test]
fn vertices_start_in_the_friction_region_below_them() {
    let sim = |x: f64| {
        let text = format!(
            "robot = {{ model = \"robots/block/block.toml\", contact = \"soles\", base = {{ position = [{x}, 0.0, 0.05] }} }}
            floor = {{ friction = 0.5, patches = [{{ polygon = [[0.1, -1], [3, -1], [3, 1], [0.1, 1]], friction = 0.1 }}] }}\n"
        );
        let mut sim = simulation(&text);
        sim.begin(&mut stiction::sim::NullObserver).expect("it stands");
        let p = &sim.plant().problem.soles[0];
        p.vertices.iter().map(|v| v.mu_s).collect::<Vec<_>>()
    };
    // The border belongs to the patch.
    assert_eq!(sim(0.0), [0.5, 0.1, 0.1, 0.5]);
    assert_eq!(sim(-1e-9), [0.5; 4]);
    assert_eq!(sim(0.2), [0.1; 4]);
}
