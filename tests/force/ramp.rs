//! `ramp`: a box pushed by a force that rises and then stays constant.

use super::fly;
use crate::analytic::body::Body;

#[test]
fn a_ramp_gives_a_cubic_then_a_parabola() {
    let body = Body::new([0.1, 0.1, 0.05], 2.0);
    let (force, start, rise, duration) = (6.0, 0.2, 0.5, 1.0);
    let text = format!(
        "gravity = [0, 0, 0]\n[[force]]\ntype = \"ramp\"\nlink = \"block\"\nforce = [{force}, 0, 0]\n\
         start = {start}\nduration = {rise}\n"
    );
    let end = fly(&body, [0.0, 0.0, 1.0], [0.0; 3], duration, &text);
    let (a, rest) = (force / body.mass, duration - start - rise);
    let (x, v) = (a * rise * rise / 6.0, a * rise / 2.0);
    // Polynomials of degree 3 and 2: the integrator is exact up to rounding.
    assert!((end.position.x - (x + v * rest + a * rest * rest / 2.0)).abs() < 1e-13, "{}", end.position);
    assert!((end.velocity.x - (v + a * rest)).abs() < 1e-13, "{}", end.velocity);
    // Equal to a push with that profile, to the last bit.
    let push =
        fly(&body, [0.0, 0.0, 1.0], [0.0; 3], duration, &text.replace("\"ramp\"", "\"push\"\nprofile = \"ramp\""));
    assert_eq!((push.position, push.velocity), (end.position, end.velocity));
}
