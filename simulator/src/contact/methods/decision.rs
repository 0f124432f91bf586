//! Decision rules of the one-step method, sole by sole, without trial states (`docs/contact.md`
//! section 10; [Hale 2008], III.B).
//!
//! **Clamp or release.** Every vertex votes independently, from present quantities, at the first
//! level that applies:
//!
//! | level | clamp | release | weight |
//! |---|---|---|---|
//! | position | below the floor by more than d | above it by more than d | (n + 1)^2 |
//! | force | clamped and pushed (N_i > 0) | clamped and pulled (N_i < 0) | n + 1 |
//! | velocity | moving towards the floor, or not at all | moving away from it | 1 |
//!
//! with n the number of vertices of the sole, so that one vertex of a level outweighs all vertices
//! of the levels below.
//!
//! **Pattern.** The cost of a pattern is the weight of the vertices that disagree with it; the
//! pattern of least cost is chosen. Ties are broken by, in this order:
//!
//! 1. the fewest pulled vertices clamped,
//! 2. the greatest load on clamped vertices,
//! 3. the present pattern,
//! 4. the most clamped vertices.
//!
//! **Mode.** A sticking sole keeps sticking while its last friction load is within its capacity.
//! Beyond that it slips along the twist of the load, turning about a vertex if the twist has its
//! centre there. A sliding sole sticks when its sliding velocities have reversed or vanished; if
//! only one vertex stops, the sole turns about it. A landing sole sticks if it is slower than v_t.

use crate::contact::model::problem::{Problem, SoleProblem, Tolerances, Vertex};
use crate::contact::model::solution::Solution;
use crate::contact::model::state::{Mode, Pattern, SoleState, States};
use crate::contact::search::judge::{self, friction_suffices, margin};
use crate::contact::search::sliding_directions::Onset;

/// Vote of one vertex.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Vote {
    /// Whether the vertex is to be clamped.
    pub clamp: bool,
    /// Weight of the vote.
    pub weight: f64,
}

/// The vote of one vertex of a sole with `n`: its height (m) and normal velocity (m/s), whether it
/// is clamped now, and the last normal force on it (N).
pub fn vote(height: f64, speed: f64, clamped: bool, normal: f64, n: usize, tol: &Tolerances) -> Vote {
    let level = (n + 1) as f64;
    if height.abs() > tol.distance {
        Vote { clamp: height < 0.0, weight: level * level }
    } else if clamped && normal != 0.0 {
        Vote { clamp: normal > 0.0, weight: level }
    } else {
        Vote { clamp: speed <= 0.0, weight: 1.0 }
    }
}

/// The pattern of least cost for these votes. `normal` are the last normal forces, N; `now` is the
/// present pattern.
pub fn cheapest(votes: &[Vote], normal: &[f64], now: Pattern) -> Pattern {
    let k = votes.len();
    // Every other pattern disagrees with at least one vote.
    let present = SoleState::fixed(now);
    if (0..k).all(|i| votes[i].clamp == present.clamps(i, k)) {
        return now;
    }
    // Smaller is better.
    let rank = |pattern: Pattern| {
        let state = SoleState::fixed(pattern);
        let clamped = |i: &usize| state.clamps(*i, k);
        let cost: f64 = (0..k).filter(|&i| votes[i].clamp != state.clamps(i, k)).map(|i| votes[i].weight).sum();
        let pulled = (0..k).filter(clamped).filter(|&i| normal[i] < 0.0).count() as f64;
        let load: f64 = (0..k).filter(clamped).map(|i| normal[i].max(0.0)).sum();
        let changes = f64::from(u8::from(pattern != now));
        [cost, pulled, -load, changes, -(state.normal_rows() as f64)]
    };
    let patterns = [now, Pattern::Free].into_iter().chain(SoleState::patterns(k));
    let ranked = patterns.map(|pattern| (rank(pattern), pattern));
    ranked.reduce(|best, next| if next.0 < best.0 { next } else { best }).map_or(now, |(_, pattern)| pattern)
}

/// The pattern of sole `s`, which was in state `before` with the load `last`.
pub fn pattern(p: &Problem, s: usize, before: SoleState, last: &Solution, tol: &Tolerances) -> Pattern {
    let vertices = &p.soles[s].vertices;
    let k = vertices.len();
    let cast = |(i, (v, n)): (usize, (&Vertex, &f64))| vote(v.height, v.velocity.z, before.clamps(i, k), *n, k, tol);
    let ballots = || vertices.iter().zip(&last.normal[s]).enumerate().map(cast);
    // Usually all votes are for the present pattern.
    if ballots().enumerate().all(|(i, vote)| vote.clamp == before.clamps(i, k)) {
        return before.pattern;
    }
    let mut votes = [Vote { clamp: false, weight: 0.0 }; 64];
    votes.iter_mut().zip(ballots()).for_each(|(to, vote)| *to = vote);
    cheapest(&votes[..k], &last.normal[s], before.pattern)
}

/// Sticking or sliding of sole `s` on `pattern`, from its last load and its present velocities.
/// Leaves the sliding directions of its vertices in the problem where it starts or continues to
/// slide.
pub fn mode(
    p: &mut Problem,
    s: usize,
    pattern: Pattern,
    previous: &States,
    last: &Solution,
    tol: &Tolerances,
) -> SoleState {
    let before = previous[s];
    let stuck = SoleState::fixed(pattern);
    let mode = if before.is_static() {
        let load = (!friction_suffices(p, previous, s, last)).then(|| margin(p, previous, s, last));
        match load.filter(|load| load.normal >= 0.0 && load.friction < 0.0) {
            Some(_) => {
                let mut onset = Onset::default();
                judge::onset(p, previous, s, last, &mut onset);
                mode_at_onset(&mut p.soles[s], stuck, &onset)
            }
            None => mode_at_landing(&mut p.soles[s], stuck, before, tol),
        }
    } else if before.is_dynamic() {
        mode_while_sliding(&mut p.soles[s], stuck, before, last, s, tol)
    } else {
        mode_at_landing(&mut p.soles[s], stuck, before, tol)
    };
    SoleState { pattern, mode }
}

/// The mode of a sole whose load exceeds its capacity and that begins to slip according to `onset`.
fn mode_at_onset(sole: &mut SoleProblem, stuck: SoleState, onset: &Onset) -> Mode {
    let k = sole.vertices.len();
    let (mut slipping, mut holding, mut at) = (0, 0, None);
    for (i, v) in sole.vertices.iter_mut().enumerate().filter(|(i, _)| stuck.clamps(*i, k)) {
        if onset.vertices >> i & 1 == 1 {
            slipping += 1;
            v.direction = onset.directions[i];
        } else {
            holding += 1;
            at = Some(i);
        }
    }
    mode_of(slipping, holding, at)
}

/// The mode of a sole with these numbers of slipping and holding clamped vertices; `at` is one that
/// holds. A single vertex turns about itself without friction: it sticks.
fn mode_of(slipping: usize, holding: usize, at: Option<usize>) -> Mode {
    match (slipping, holding, at) {
        (0, ..) => Mode::Static,
        (_, 1, Some(j)) => Mode::Pivoting(j as u8),
        _ => Mode::Sliding,
    }
}

/// The mode of a sole that slid in state `before`.
fn mode_while_sliding(
    sole: &mut SoleProblem,
    stuck: SoleState,
    before: SoleState,
    last: &Solution,
    s: usize,
    tol: &Tolerances,
) -> Mode {
    let k = sole.vertices.len();
    let (mut sliding, mut stopped, mut at) = (0, 0, None);
    for (i, v) in sole.vertices.iter_mut().enumerate().filter(|(i, _)| stuck.clamps(*i, k)) {
        let t = v.velocity.xy();
        let pivot = before.mode == Mode::Pivoting(i as u8);
        let load = last.tangent[s][i];
        let slides = if pivot {
            load.norm() > v.mu_s * last.normal[s][i].max(0.0)
        } else {
            t.norm() > tol.rest && (t.dot(&v.direction) > 0.0 || !before.clamps(i, k))
        };
        if slides {
            sliding += 1;
            let toward = if pivot { -load } else { t };
            v.direction = toward.try_normalize(0.0).unwrap_or_default();
        } else {
            stopped += 1;
            at = Some(i);
        }
    }
    let mode = mode_of(sliding, stopped, at);
    if mode == Mode::Sliding {
        // Vertices that have turned while others continue to slide get their new direction.
        for (_, v) in sole.vertices.iter_mut().enumerate().filter(|(i, _)| stuck.clamps(*i, k)) {
            v.direction = v.velocity.xy().try_normalize(tol.rest).unwrap_or(v.direction);
        }
    }
    mode
}

/// Sets the sliding directions of a sole along its present velocities. A vertex slower than `rest`
/// (m/s) gets none.
pub fn set_directions(sole: &mut SoleProblem, rest: f64) {
    for v in &mut sole.vertices {
        v.direction = v.velocity.xy().try_normalize(rest).unwrap_or_default();
    }
}

/// The mode of a sole that was in the air, or stuck with other vertices: landing vertices slide if
/// they are faster than v_t.
fn mode_at_landing(sole: &mut SoleProblem, stuck: SoleState, before: SoleState, tol: &Tolerances) -> Mode {
    let k = sole.vertices.len();
    let (mut sliding, mut holding, mut at) = (0, 0, None);
    for (i, v) in sole.vertices.iter_mut().enumerate().filter(|(i, _)| stuck.clamps(*i, k)) {
        let t = v.velocity.xy();
        v.direction = t.try_normalize(tol.rest).unwrap_or_default();
        if !before.clamps(i, k) && t.norm() > tol.velocity {
            sliding += 1;
        } else {
            holding += 1;
            at = Some(i);
        }
    }
    mode_of(sliding, holding, at)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Vector2, Vector3};

    const K: usize = 4;
    const FACE: SoleState = SoleState { pattern: Pattern::Face, mode: Mode::Static };

    /// A square foot of half side 1 m that lies on the floor, mu 0.5 and 0.4; and 10 N on each
    /// vertex as the last load.
    fn standing() -> (Problem, Solution) {
        let mut p = Problem::new(&[K]);
        p.soles[0].radius = 2f64.sqrt();
        p.scale = 40.0;
        let corners = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)];
        for (v, (x, y)) in p.soles[0].vertices.iter_mut().zip(corners) {
            v.r = Vector3::new(x, y, 0.0);
            (v.mu_s, v.mu_k) = (0.5, 0.4);
        }
        let mut last = Solution::new(&p);
        last.normal[0].fill(10.0);
        last.wrench[2] = 40.0;
        (p, last)
    }

    /// The last load carries this tangential force and yaw moment, split evenly and as a turn about
    /// the middle.
    fn load(last: &mut Solution, p: &Problem, force: [f64; 2], yaw: f64) {
        last.wrench.copy_from_slice(&[force[0], force[1], 40.0, 0.0, 0.0, yaw]);
        for (t, v) in last.tangent[0].iter_mut().zip(&p.soles[0].vertices) {
            *t = Vector2::from(force) / 4.0 + Vector2::new(-v.r.y, v.r.x) * (yaw / 8.0);
        }
    }

    fn previous(state: SoleState) -> States {
        let mut states = States::default();
        states[0] = state;
        states
    }

    fn decide(p: &mut Problem, before: SoleState, last: &Solution) -> SoleState {
        let tol = Tolerances { velocity: 0.1, rest: 1e-9, ..Tolerances::default() };
        let pattern = pattern(p, 0, before, last, &tol);
        mode(p, 0, pattern, &previous(before), last, &tol)
    }

    fn sliding_along(p: &mut Problem, velocity: [f64; 2], turn: f64) {
        for v in &mut p.soles[0].vertices {
            v.velocity = Vector3::new(velocity[0] - turn * v.r.y, velocity[1] + turn * v.r.x, 0.0);
            v.direction = v.velocity.xy().normalize();
        }
    }

    #[test]
    fn one_vertex_decides_by_position_then_force_then_velocity() {
        let tol = Tolerances::default();
        let clamp = |weight| Vote { clamp: true, weight };
        let release = |weight| Vote { clamp: false, weight };
        assert_eq!(vote(-0.002, 1.0, true, -5.0, K, &tol), clamp(25.0));
        assert_eq!(vote(0.002, -1.0, true, 5.0, K, &tol), release(25.0));
        assert_eq!(vote(0.0, 1.0, true, 5.0, K, &tol), clamp(5.0));
        assert_eq!(vote(0.0, -1.0, true, -5.0, K, &tol), release(5.0));
        assert_eq!(vote(0.0, -0.01, false, 0.0, K, &tol), clamp(1.0));
        assert_eq!(vote(0.0, 0.01, false, 0.0, K, &tol), release(1.0));
        // A clamped vertex without load votes by its velocity, and one at rest stays clamped.
        assert_eq!(vote(0.0, 0.0, true, 0.0, K, &tol), clamp(1.0));
    }

    #[test]
    fn one_vertex_of_a_level_outweighs_all_of_those_below() {
        for n in 1..=8 {
            let weight = |height, normal| vote(height, 0.0, true, normal, n, &Tolerances::default()).weight;
            let (position, force, velocity) = (weight(1.0, 1.0), weight(0.0, 1.0), weight(0.0, 0.0));
            let others = (n - 1) as f64;
            assert!(position > others * (force + velocity) && force > others * velocity, "{n}");
        }
    }

    fn votes(list: [(bool, f64); K]) -> [Vote; K] {
        list.map(|(clamp, weight)| Vote { clamp, weight })
    }

    #[test]
    fn the_pattern_follows_the_heavier_votes() {
        let even = [1.0; K];
        let (f, v) = (5.0, 1.0);
        // Three pushed corners and one that moves away slowly: the face, at the cost of one light
        // vote.
        assert_eq!(
            cheapest(&votes([(true, f), (true, f), (true, f), (false, v)]), &even, Pattern::Face),
            Pattern::Face
        );
        // Two neighbours pulled: the opposite edge.
        assert_eq!(
            cheapest(&votes([(true, f), (true, f), (false, f), (false, f)]), &even, Pattern::Face),
            Pattern::Edge(0)
        );
        // A diagonal is not a pattern: one of its two vertices is released.
        let diagonal = votes([(true, 25.0), (false, f), (true, f), (false, f)]);
        assert_eq!(cheapest(&diagonal, &even, Pattern::Free), Pattern::Vertex(0));
        assert_eq!(cheapest(&votes([(false, 25.0); K]), &even, Pattern::Face), Pattern::Free);
        assert_eq!(cheapest(&votes([(true, v); K]), &even, Pattern::Free), Pattern::Face);
    }

    #[test]
    fn among_equals_nothing_is_held_down_and_most_of_the_load_is_kept() {
        // The centre of pressure has left the foot at vertex 0: three are pushed, the one across is
        // pulled. The face and the two edges that meet at vertex 0 disagree with one vertex each.
        let pushed = votes([(true, 5.0), (true, 5.0), (false, 5.0), (true, 5.0)]);
        assert_eq!(cheapest(&pushed, &[15.0, 5.1, -5.0, 4.9], Pattern::Face), Pattern::Edge(0));
        assert_eq!(cheapest(&pushed, &[15.0, 4.9, -5.0, 5.1], Pattern::Face), Pattern::Edge(3));
    }

    #[test]
    fn a_sole_sticks_within_its_capacity_and_slips_beyond() {
        let (mut p, mut last) = standing();
        load(&mut last, &p, [19.9, 0.0], 0.0);
        assert_eq!(decide(&mut p, FACE, &last), FACE);
        // 0.5 of 40 N.
        load(&mut last, &p, [20.1, 0.0], 0.0);
        assert_eq!(decide(&mut p, FACE, &last), SoleState::sliding(Pattern::Face));
        // It slips against the friction it carried.
        assert!(p.soles[0].vertices.iter().all(|v| (v.direction + Vector2::x()).norm() < 1e-6));
    }

    #[test]
    fn a_twist_about_a_vertex_turns_the_sole_about_it() {
        let (mut p, mut last) = standing();
        // All the weight on vertex 0, and friction that turns the rest.
        last.normal[0].copy_from_slice(&[39.4, 0.2, 0.2, 0.2]);
        for (t, v) in last.tangent[0].iter_mut().zip(&p.soles[0].vertices) {
            *t = Vector2::new(-(v.r.y - 1.0), v.r.x - 1.0) * 0.2;
        }
        let sum: Vector2<f64> = last.tangent[0].iter().sum();
        let yaw: f64 = last.tangent[0].iter().zip(&p.soles[0].vertices).map(|(t, v)| v.r.xy().perp(t)).sum();
        // Centre of pressure from the normal forces: x and y of vertex 0, nearly.
        let moment =
            |axis: usize| last.normal[0].iter().zip(&p.soles[0].vertices).map(|(n, v)| n * v.r[axis]).sum::<f64>();
        let (mx, my) = (moment(1), -moment(0));
        last.wrench.copy_from_slice(&[sum.x, sum.y, 40.0, mx, my, yaw]);
        assert_eq!(decide(&mut p, FACE, &last), SoleState { pattern: Pattern::Face, mode: Mode::Pivoting(0) });
    }

    #[test]
    fn a_sliding_sole_slides_until_it_has_reversed_or_stopped() {
        let (mut p, last) = standing();
        let before = SoleState::sliding(Pattern::Face);
        sliding_along(&mut p, [0.01, 0.0], 0.0);
        assert_eq!(decide(&mut p, before, &last), before);
        p.soles[0].vertices.iter_mut().for_each(|v| v.velocity.x = -0.01);
        assert_eq!(decide(&mut p, before, &last), FACE);
        p.soles[0].vertices.iter_mut().for_each(|v| v.velocity.x = 0.0);
        assert_eq!(decide(&mut p, before, &last), FACE);
    }

    #[test]
    fn a_sliding_sole_turns_about_the_vertex_that_stops() {
        let (mut p, last) = standing();
        // Turning about vertex 0.
        sliding_along(&mut p, [0.1, -0.1], 0.1);
        p.soles[0].vertices[0].velocity = Vector3::zeros();
        let pivot = SoleState { pattern: Pattern::Face, mode: Mode::Pivoting(0) };
        assert_eq!(decide(&mut p, SoleState::sliding(Pattern::Face), &last), pivot);
        assert_eq!(decide(&mut p, pivot, &last), pivot);
    }

    #[test]
    fn a_pivot_beyond_its_capacity_slides_with_the_rest() {
        let (mut p, mut last) = standing();
        sliding_along(&mut p, [0.1, -0.1], 0.1);
        let pivot = SoleState { pattern: Pattern::Face, mode: Mode::Pivoting(0) };
        last.tangent[0][0] = Vector2::new(0.0, 5.1);
        assert_eq!(decide(&mut p, pivot, &last), SoleState::sliding(Pattern::Face));
        assert_eq!(p.soles[0].vertices[0].direction, Vector2::new(0.0, -1.0), "against the load beyond its capacity");
    }

    #[test]
    fn a_landing_sole_slides_if_it_is_fast() {
        let (mut p, last) = standing();
        sliding_along(&mut p, [0.2, 0.0], 0.0);
        assert_eq!(decide(&mut p, SoleState::FREE, &last), SoleState::sliding(Pattern::Face));
        sliding_along(&mut p, [0.05, 0.0], 0.0);
        assert_eq!(decide(&mut p, SoleState::FREE, &last), FACE);
    }

    #[test]
    fn an_edge_that_lands_with_a_resting_vertex_turns_about_it() {
        let (mut p, mut last) = standing();
        last.normal[0].copy_from_slice(&[40.0, 0.0, 0.0, 0.0]);
        last.wrench.copy_from_slice(&[0.0, 0.0, 40.0, 40.0, -40.0, 0.0]);
        sliding_along(&mut p, [0.2, -0.2], 0.2);
        p.soles[0].vertices[0].velocity = Vector3::zeros();
        for i in 2..4 {
            p.soles[0].vertices[i].height = 0.01;
        }
        let before = SoleState::fixed(Pattern::Vertex(0));
        let turned = SoleState { pattern: Pattern::Edge(0), mode: Mode::Pivoting(0) };
        assert_eq!(decide(&mut p, before, &last), turned);
    }
}
