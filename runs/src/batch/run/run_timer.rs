//! Measures the time of a run. A run stays on one thread, so its processor time is the thread's.

use std::time::Instant;

use cpu_time::ThreadTime;

use crate::results::{BUILD, Machine, Repeats, Timing};

/// Clock started with a run, on its thread.
pub(in crate::batch) struct Clock {
    wall: Instant,
    cpu: Option<ThreadTime>,
}

impl Clock {
    pub fn start() -> Self {
        // Without a clock per thread, the processor time is NaN.
        Self { wall: Instant::now(), cpu: ThreadTime::try_now().ok() }
    }

    /// Time since the start; to be called on the same thread.
    pub fn lap(&self) -> Lap {
        let cpu_s = self.cpu.and_then(|c| c.try_elapsed().ok()).map_or(f64::NAN, |d| d.as_secs_f64());
        Lap { wall_s: self.wall.elapsed().as_secs_f64(), cpu_s }
    }

    /// Time since the start, with machine and build.
    pub fn read(&self) -> Timing {
        let Lap { wall_s, cpu_s } = self.lap();
        Timing {
            wall_s,
            cpu_s,
            machine: Machine::here(),
            file: None,
            build: Some(BUILD.into()),
            repeats: None,
            avoidance: None,
        }
    }
}

/// Times of one repetition, s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::batch) struct Lap {
    /// Wall-clock time.
    pub wall_s: f64,
    /// Processor time.
    pub cpu_s: f64,
}

/// Minimum and median of repeated timings; none without repetitions.
pub(in crate::batch) fn repeats(laps: &[Lap]) -> Option<Repeats> {
    let (wall, cpu) = (sorted(laps, |l| l.wall_s), sorted(laps, |l| l.cpu_s));
    Some(Repeats {
        count: laps.len() as u32,
        wall_min_s: *wall.first()?,
        wall_median_s: median(&wall),
        cpu_min_s: *cpu.first()?,
        cpu_median_s: median(&cpu),
    })
}

fn sorted(laps: &[Lap], of: fn(&Lap) -> f64) -> Vec<f64> {
    let mut times: Vec<f64> = laps.iter().map(of).collect();
    times.sort_by(f64::total_cmp);
    times
}

/// Median of at least one sorted value.
fn median(sorted: &[f64]) -> f64 {
    let (low, high) = (sorted[(sorted.len() - 1) / 2], sorted[sorted.len() / 2]);
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn minimum_and_median_of_each_time() {
        let laps =
            |times: &[(f64, f64)]| -> Vec<Lap> { times.iter().map(|&(wall_s, cpu_s)| Lap { wall_s, cpu_s }).collect() };
        let times = |r: Repeats| [r.wall_min_s, r.wall_median_s, r.cpu_min_s, r.cpu_median_s];
        assert_eq!(repeats(&[]), None);
        assert_eq!(times(repeats(&laps(&[(2.0, 1.0)])).unwrap()), [2.0, 2.0, 1.0, 1.0]);
        let three = repeats(&laps(&[(5.0, 0.5), (2.0, 0.75), (3.0, 0.25)])).unwrap();
        assert_eq!((three.count, times(three)), (3, [2.0, 3.0, 0.25, 0.5]));
        assert_eq!(times(repeats(&laps(&[(5.0, 1.0), (2.0, 4.0)])).unwrap()), [2.0, 3.5, 1.0, 2.5]);
    }
}
