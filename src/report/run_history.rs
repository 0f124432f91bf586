//! Time series of a run for its picture, from its log: height of the base, force and state of each sole and other
//! contact.

use crate::log::Trajectory;
use crate::sim::bodies::FLOOR;
use nalgebra::{Rotation3, Vector3};

/// Width of a picture in columns; finer detail is invisible.
const COLUMNS: usize = 480;

/// A run over time. Series are thinned to the resolution of a picture; extremes are kept.
pub(super) struct History {
    /// First and last time, s.
    pub span: (f64, f64),
    /// Height of the root frame's origin in the world, m, over time, s; empty when not logged.
    pub height: Vec<(f64, f64)>,
    /// Empty when not logged.
    pub soles: Vec<SoleHistory>,
}

/// A sole over time.
pub(super) struct SoleHistory {
    pub name: String,
    /// Sum of the vertices' forces, N, over time, s: along the floor's normal, or its magnitude.
    pub force: Vec<(f64, f64)>,
    /// Whether it is the magnitude: the log has no normals of contacts away from the floor.
    pub is_magnitude: bool,
    pub stays: Vec<Stay>,
    /// Changes of state between logged instants; may exceed the number of stays, since short ones
    /// are merged.
    pub changes: usize,
}

/// A time in one state.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Stay {
    pub state: String,
    pub from: f64,
    pub to: f64,
}

impl History {
    /// The series of a logged run; none when the log has no instants.
    pub fn of(log: &Trajectory) -> Option<Self> {
        let (&first, &last) = (log.times.first()?, log.times.last()?);
        let normal = floor_normal(log);
        let series =
            |values: &mut dyn Iterator<Item = f64>| thin(&log.times.iter().copied().zip(values).collect::<Vec<_>>());
        let sole = |sole: &crate::log::SoleSeries| {
            let stays = stays(&log.times, &sole.state);
            let is_magnitude = sole.name.split_once(" on ").is_some_and(|(_, other)| other != FLOOR);
            let force = |f: &Vector3<f64>| if is_magnitude { f.norm() } else { f.dot(&normal) };
            SoleHistory {
                name: sole.name.clone(),
                force: series(&mut sole.force.iter().map(force)),
                is_magnitude,
                changes: stays.len().saturating_sub(1),
                stays: merge(stays, first, last),
            }
        };
        let mut soles: Vec<SoleHistory> = log.soles.iter().flatten().map(sole).collect();
        // Soles, then other contacts in the order of the numbers in their names.
        let number = log.soles.iter().flatten().filter(|sole| !sole.is_link).count();
        soles[number..].sort_by(|a, b| natural_key(&a.name).cmp(&natural_key(&b.name)));
        Some(Self {
            span: (first, last),
            height: log.motion.as_ref().map_or_else(Vec::new, |m| series(&mut m.base_position.iter().map(|p| p.z))),
            soles,
        })
    }
}

/// Texts and the numbers after them in a name, for an order in which 2 comes before 10.
fn natural_key(name: &str) -> Vec<(&str, u64)> {
    let mut key = Vec::new();
    let mut rest = name;
    while !rest.is_empty() {
        let digits = rest.find(|c: char| c.is_ascii_digit()).unwrap_or(rest.len());
        let (text, tail) = rest.split_at(digits);
        let (number, tail) = tail.split_at(tail.find(|c: char| !c.is_ascii_digit()).unwrap_or(tail.len()));
        key.push((text, number.parse().unwrap_or(0)));
        rest = tail;
    }
    key
}

/// The floor's upward normal in the world, from the scenario's tilt.
fn floor_normal(log: &Trajectory) -> Vector3<f64> {
    let rpy = || {
        let scenario: toml::Table = log.scenario_text()?.parse().ok()?;
        let angles = scenario.get("floor")?.get("rpy")?.as_array()?;
        let angle = |i: usize| angles.get(i).and_then(|a| a.as_float().or(a.as_integer().map(|i| i as f64)));
        Some([angle(0)?, angle(1)?, angle(2)?])
    };
    let [roll, pitch, yaw] = rpy().unwrap_or([0.0; 3]);
    Rotation3::from_euler_angles(roll, pitch, yaw) * Vector3::z()
}

/// Least and greatest value of each of [`COLUMNS`] columns, in order of time, without NaN.
fn thin(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let finite: Vec<_> = points.iter().copied().filter(|(_, value)| value.is_finite()).collect();
    if finite.len() <= 2 * COLUMNS {
        return finite;
    }
    let size = finite.len().div_ceil(COLUMNS);
    let extremes = |column: &[(f64, f64)]| {
        let by = |a: &&(f64, f64), b: &&(f64, f64)| a.1.total_cmp(&b.1);
        let ends: [Option<(f64, f64)>; 2] = [column.iter().min_by(by).copied(), column.iter().max_by(by).copied()];
        let mut ends: Vec<_> = ends.into_iter().flatten().collect();
        ends.sort_by(|a, b| a.0.total_cmp(&b.0));
        ends
    };
    // Keep the first and the last instant, the ends of the series.
    let ends = |p: &[(f64, f64)]| (p.first().copied(), p.last().copied());
    let (first, last) = ends(&finite);
    let inner = finite.chunks(size).flat_map(extremes);
    let mut thinned: Vec<_> = first.into_iter().chain(inner).chain(last).collect();
    thinned.dedup();
    thinned
}

/// Merges consecutive equal states into one stay.
fn stays(times: &[f64], states: &[String]) -> Vec<Stay> {
    let mut stays: Vec<Stay> = Vec::new();
    for (&time, state) in times.iter().zip(states) {
        if let Some(last) = stays.last_mut() {
            last.to = time;
            if last.state == *state {
                continue;
            }
        }
        stays.push(Stay { state: state.clone(), from: time, to: time });
    }
    stays
}

/// Thins stays to one per column: the state with the longest time in it.
fn merge(stays: Vec<Stay>, first: f64, last: f64) -> Vec<Stay> {
    if stays.len() <= COLUMNS / 2 {
        return stays;
    }
    let edge = |column: usize| first + (last - first) * column as f64 / COLUMNS as f64;
    let mut merged: Vec<Stay> = Vec::new();
    let mut begin = 0;
    for column in 0..COLUMNS {
        let (from, to) = (edge(column), edge(column + 1));
        begin += stays[begin..].iter().take_while(|s| s.to <= from).count();
        let mut shares: Vec<(&str, f64)> = Vec::new();
        for stay in stays[begin..].iter().take_while(|s| s.from < to) {
            let time = stay.to.min(to) - stay.from.max(from);
            match shares.iter_mut().find(|(state, _)| *state == stay.state) {
                Some((_, share)) => *share += time,
                None => shares.push((&stay.state, time)),
            }
        }
        let Some((state, _)) = shares.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)) else { continue };
        match merged.last_mut() {
            Some(stay) if stay.state == state => stay.to = to,
            _ => merged.push(Stay { state: state.to_owned(), from, to }),
        }
    }
    merged
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinning_keeps_ends_and_extremes() {
        let mut points: Vec<(f64, f64)> = (0..10_000).map(|i| (f64::from(i), f64::from(i).sin())).collect();
        points[4321].1 = 7.0;
        points[1234].1 = f64::NAN;
        points[1235].1 = -5.0;
        let thinned = thin(&points);
        assert!(thinned.len() <= 2 * COLUMNS + 2, "{}", thinned.len());
        assert!(thinned.contains(&(4321.0, 7.0)) && thinned.contains(&(1235.0, -5.0)));
        assert_eq!((thinned[0], thinned[thinned.len() - 1]), (points[0], points[9_999]));
        assert!(thinned.windows(2).all(|w| w[0].0 < w[1].0), "in order of time");
        assert_eq!(thin(&points[..900]).len(), 900);
    }

    #[test]
    fn names_are_in_the_order_of_their_numbers() {
        let mut names = ["object.10 on object.11", "object.2 on object.3", "object.0 on floor", "left_hand"];
        names.sort_by(|a, b| natural_key(a).cmp(&natural_key(b)));
        assert_eq!(names, ["left_hand", "object.0 on floor", "object.2 on object.3", "object.10 on object.11"]);
    }

    #[test]
    fn a_stay_lasts_until_the_next() {
        let states: Vec<String> = ["free", "free", "face-static", "free"].map(String::from).to_vec();
        let found = stays(&[0.0, 0.1, 0.2, 0.3], &states);
        let stay = |state: &str, from, to| Stay { state: state.into(), from, to };
        assert_eq!(found, [stay("free", 0.0, 0.2), stay("face-static", 0.2, 0.3), stay("free", 0.3, 0.3)]);
        assert_eq!(merge(found.clone(), 0.0, 0.3), found, "few enough");
    }

    #[test]
    fn chatter_becomes_the_state_that_prevails() {
        // 9 of 10 instants on the face in the first half, in the air in the second.
        let times: Vec<f64> = (0..20_000).map(|i| f64::from(i) * 1e-3).collect();
        let state = |i: usize| if i.is_multiple_of(10) == (i < 10_000) { "free" } else { "face-static" };
        let states: Vec<String> = (0..20_000).map(|i| state(i).to_owned()).collect();
        let merged = merge(stays(&times, &states), 0.0, times[19_999]);
        assert_eq!(merged.iter().map(|s| s.state.as_str()).collect::<Vec<_>>(), ["face-static", "free"]);
        assert!((merged[0].to - 10.0).abs() < 20.0 / COLUMNS as f64, "{merged:?}");
        assert_eq!((merged[0].from, merged[1].to), (0.0, times[19_999]));
    }
}
