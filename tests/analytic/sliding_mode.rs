//! Sliding modes: states that alternate faster than steps resolve.
//!
//! CB-i lands tilted. Before 0.2 s a vertex comes to rest, but its states alternate. Without sliding
//! modes every change is a located event: the values below come from such a run of the program
//! before it had the mode (commit 81ef348, the same scenario), with 2522 events.

use super::support::watch;

const SCENARIO: &str = "duration = 0.2
    floor = { friction = 0.9577079989743374 }
    contact = { velocity_tolerance = 0.02 }
    control = { rate = 500 }
    log = { rate = 0 }
    integrator = { method = \"dopri5\", relative_tolerance = 1e-7, absolute_tolerance = 1e-9 }
    robot = { model = \"robots/cbi/cbi.toml\", base = { rpy = [0.28, -0.28, 0], linear_velocity = [0, 0, -0.9905] } }";

/// Position (m) and yaw (rad) of the base at the end, with every event located.
const RESOLVED: ([f64; 3], f64) =
    ([-0.00949798959113506, -0.04202632131874456, 0.7290779772627862], 0.07081320290790853);

#[test]
fn a_sliding_mode_moves_as_the_run_that_locates_every_event() {
    let (m, recording) = watch(SCENARIO);
    let (position, yaw) = RESOLVED;
    // The integrator: with a tenth of the tolerances the resolved run moves by 1e-8 m and 3e-8 rad.
    for (end, resolved) in m.final_base_position.iter().zip(position) {
        assert!((end - resolved).abs() < 3e-8, "{:?}", m.final_base_position);
    }
    assert!((m.final_base_rpy[2] - yaw).abs() < 1e-7, "{:?}", m.final_base_rpy);
    assert!(m.sliding_mode_s > 1e-4 && m.sliding_mode_s < 0.02, "{}", m.sliding_mode_s);
    assert!(m.events < 100, "{} events", m.events);
    assert_eq!((m.inconsistent, m.full_searches), (0, 0));
    // The law holds within the mode: rounding, relative to some 100 N.
    assert!(m.max_cone_excess < 1e-9 && m.max_tension_n < 1e-9, "{} {}", m.max_cone_excess, m.max_tension_n);
    assert!(m.max_penetration_m < 1e-9, "{}", m.max_penetration_m);
    assert!(m.energy_error_j.abs() < 1e-6, "{}", m.energy_error_j);

    // Begin and end are events, and what is between them is the column.
    let modes: Vec<_> = recording.events.iter().filter(|e| e.kind == "sliding-mode").collect();
    assert!(
        modes.chunks(2).all(|pair| pair[0].message.starts_with("begins: ") && pair[1].message.starts_with("ends "))
    );
    let time: f64 = modes.chunks(2).map(|pair| pair[1].time - pair[0].time).sum();
    // Rounding of the instants.
    assert!((time - m.sliding_mode_s).abs() < 1e-12, "{time} {}", m.sliding_mode_s);
}

#[test]
fn a_run_whose_states_do_not_alternate_has_no_sliding_mode() {
    let (m, _) =
        watch(&SCENARIO.replace("rpy = [0.28, -0.28, 0], linear_velocity = [0, 0, -0.9905]", "rpy = [0, 0, 0]"));
    assert_eq!(m.sliding_mode_s, 0.0);
}
