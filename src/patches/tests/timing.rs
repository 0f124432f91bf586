//! Time of the functions, for reports: `cargo test --release timing -- --ignored --nocapture`.

use super::*;
use std::hint::black_box;
use std::time::Instant;

fn time(name: &str, mut f: impl FnMut()) {
    let mut best = f64::INFINITY;
    for _ in 0..5 {
        let (start, mut count) = (Instant::now(), 0);
        while start.elapsed().as_secs_f64() < 0.05 {
            f();
            count += 1;
        }
        best = best.min(start.elapsed().as_secs_f64() / count as f64);
    }
    println!("{name}: {:.2} us", best * 1e6);
}

#[test]
#[ignore = "prints times"]
fn timing_of_pairs() {
    let mut random = Random::new(97);
    let cube = ConvexBody::cuboid(Vector3::new(0.5, 0.5, 0.5));
    let tilted = at(turn(Vector3::new(0.3, 0.2, 0.4)), 0.1, 0.2, 2.0);
    let pairs = [
        ("cuboids, flat", Pair::new(&cube, at(turn(Vector3::z() * 0.6), 0.2, 0.1, 1.0), &cube, level(0.0, 0.0, 0.0))),
        ("cuboids, tilted", Pair::new(&cube, tilted, &cube, level(0.0, 0.0, 0.0))),
        ("hulls of 60", Pair::new(&random.hull(60), tilted, &random.hull(60), level(0.0, 0.0, 0.0))),
        ("ball, cuboid", Pair::new(&ConvexBody::ball(0.2), tilted, &cube, level(0.0, 0.0, 0.0))),
    ];
    for (name, mut pair) in pairs {
        let owner = pair.touch();
        let (held, mut out) = (pair.topology(owner, 1e-9), PatchGeometry::new());
        println!("{name}: {owner:?}, {} corners", held.corners.len());
        let (a, b) = (&pair.a, &pair.b);
        time("  separation", || {
            black_box(separation(a, black_box(&pair.pa), b, &pair.pb, Some(owner), 1e-3));
        });
        time("  geometry", || geometry(&held, a, black_box(&pair.pa), b, &pair.pb, &mut out));
        time("  validity", || {
            black_box(validity(&held, a, black_box(&pair.pa), b, &pair.pb, 1.0));
        });
        let mut new = Topology::new();
        time("  topology", || {
            topology(a, black_box(&pair.pa), b, &pair.pb, 1e-9, owner, None, &mut new);
        });
    }
}
