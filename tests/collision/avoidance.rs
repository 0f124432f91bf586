//! For any desired motion the commands are free of collisions and within the limits. An
//! unobstructed motion is unchanged.

use super::cbi;
use crate::support::counting;
use std::sync::{Arc, LazyLock};
use stiction::collision::avoidance::{Avoider, JointCommands, Limits, Settings};
use stiction::collision::{CollisionModel, Detector, LinkPose, link_poses};
use stiction::random::Stream;
use stiction::robot::{Model, Robot};

const MARGIN: f64 = 0.005;

static CBI: LazyLock<(Robot, Arc<CollisionModel>)> = LazyLock::new(|| {
    let robot = cbi();
    let collision = Arc::new(CollisionModel::new(&robot.model, &robot.self_collision));
    (robot, collision)
});

/// A desired motion: posture and velocity at a time.
type Motion = dyn Fn(f64) -> (Vec<f64>, Vec<f64>);

/// Three sines for each joint, around the middle of its range, that fade in within a second from
/// home; `width` is the greatest share of the range that they fill.
fn sines(model: &Model, seed: u64, frequency: f64, width: f64) -> Box<Motion> {
    let mut r = Stream::new(seed, &["sines"]);
    let parts: Vec<[[f64; 2]; 3]> = model
        .joints
        .iter()
        .map(|_| [0.6, 1.0, 1.4].map(|f| [f * frequency * (0.8 + 0.4 * r.unit()), std::f64::consts::TAU * r.unit()]))
        .collect();
    let spans: Vec<[f64; 3]> = model
        .joints
        .iter()
        .zip(&model.home)
        .map(|(j, h)| [*h, 0.5 * (j.lower + j.upper), 0.5 * (j.upper - j.lower)])
        .collect();
    Box::new(move |t| {
        let s = t.clamp(0.0, 1.0);
        let fade = s.powi(3) * (10.0 - 15.0 * s + 6.0 * s * s);
        let rate = 30.0 * (s * (1.0 - s)).powi(2);
        let one = |(parts, [home, middle, half]): (&[[f64; 2]; 3], &[f64; 3])| {
            let angle = |[f, p]: &[f64; 2]| std::f64::consts::TAU * f * t + p;
            let x: f64 = parts.iter().map(|p| angle(p).sin() / 3.0).sum();
            let v: f64 = parts.iter().map(|p| std::f64::consts::TAU * p[0] * angle(p).cos() / 3.0).sum();
            let off = middle + width * half * x - home;
            (home + fade * off, fade * width * half * v + rate * off)
        };
        parts.iter().zip(&spans).map(one).unzip()
    })
}

/// An avoider, its last commands, and a separate detector.
struct Bench {
    avoider: Avoider,
    limits: Vec<Limits>,
    period: f64,
    tick: u64,
    commanded: Vec<Vec<f64>>,
    detector: Detector,
    poses: Vec<LinkPose>,
    /// Smallest distance of any monitored pair on straight lines from tick to tick.
    least: f64,
    /// Number of ticks whose desired posture is within the margin.
    desired_near: u64,
}

impl Bench {
    fn new(method: u8, rate: f64, period: f64) -> Self {
        let (robot, collision) = &*CBI;
        let model = &robot.model;
        let limits: Vec<Limits> = model.joints.iter().map(|j| Limits::new(j, 10.0, 50.0, 1000.0)).collect();
        let settings = Settings { method, rate, margin: MARGIN, limits: limits.clone(), seed: 1 };
        Bench {
            avoider: Avoider::new(model, collision.clone(), settings, &model.home, (0.0, period)),
            limits,
            period,
            tick: 0,
            commanded: vec![model.home.clone(); 4],
            detector: Detector::new(collision),
            poses: vec![LinkPose::IDENTITY; model.links.len()],
            least: f64::INFINITY,
            desired_near: 0,
        }
    }

    /// One tick; returns the commanded positions and velocities.
    fn tick_once(&mut self, (mut position, mut velocity): (Vec<f64>, Vec<f64>)) -> (Vec<f64>, Vec<f64>) {
        let n = position.len();
        let (follows, zero) = (vec![true; n], vec![0.0; n]);
        let mut commanded = JointCommands {
            follows: &follows,
            measured: &zero,
            rates: &zero,
            position: &mut position,
            velocity: &mut velocity,
        };
        self.avoider.tick(&CBI.0.model, self.tick as f64 * self.period, &mut commanded);
        self.tick += 1;
        self.commanded.remove(0);
        self.commanded.push(position.clone());
        (position, velocity)
    }

    fn distance(&mut self, q: &[f64]) -> f64 {
        link_poses(&CBI.0.model, q, &mut self.poses);
        self.detector.set_poses(&CBI.1, &self.poses);
        self.detector.closest(&CBI.1, f64::INFINITY).expect("there are pairs").distance
    }

    /// Runs `motion` for some seconds, and checks the motion between the ticks too.
    fn run(&mut self, motion: &Motion, seconds: f64) {
        for _ in 0..(seconds / self.period).round() as u64 {
            let desired = motion(self.tick as f64 * self.period);
            let near = self.distance(&desired.0) < MARGIN;
            self.desired_near += u64::from(near);
            self.tick_once(desired);
            for part in [0.25, 0.5, 0.75, 1.0] {
                let [.., a, b] = self.commanded.as_slice() else { unreachable!() };
                let q: Vec<f64> = a.iter().zip(b).map(|(a, b)| a + part * (b - a)).collect();
                self.least = self.least.min(self.distance(&q));
            }
        }
    }

    /// Checks the limits over the last ticks. Differences of positions are means of the
    /// derivatives, so they are below their bounds.
    fn check_limits(&self) {
        self.check_limits_but(None);
    }

    /// The same, except for one joint.
    fn check_limits_but(&self, except: Option<usize>) {
        let [d, c, b, a] = self.commanded.as_slice() else { unreachable!() };
        let h = self.period;
        for (j, limit) in self.limits.iter().enumerate().filter(|(j, _)| Some(*j) != except) {
            let (a, b, c, d) = (a[j], b[j], c[j], d[j]);
            let rates = [(a - b) / h, (a - 2.0 * b + c) / h.powi(2), (a - 3.0 * b + 3.0 * c - d) / h.powi(3)];
            let bounds = [limit.speed, limit.acceleration, limit.jerk];
            for (k, (rate, bound)) in rates.iter().zip(bounds).enumerate() {
                // Rounding of positions of about 1, each 1e-16, eight times in the third
                // difference.
                let rounding = 2e-15 / h.powi(k as i32 + 1);
                // Where velocities are commanded, their change is the mean acceleration one tick
                // earlier: one tick of jerk.
                let more = if k == 1 { limit.jerk * h } else { 1e-3 * bound };
                assert!(
                    rate.abs() <= bound + more + rounding,
                    "{j}: derivative {} is {rate} at tick {}",
                    k + 1,
                    self.tick
                );
            }
            // Ranges hold to 1e-9 of the position and 1e-9 rad.
            let tolerance = 1e-9 * (2.0 + a.abs());
            assert!(a >= limit.lower - tolerance && a <= limit.upper + tolerance, "{j} at {a}");
        }
    }
}

#[test]
fn every_method_prevents_contact_between_bodies() {
    for method in 1..=4 {
        // At 1 and 2 Hz the prediction is far from the actual motion; the guard between the cycles
        // has to detect it.
        for (seed, frequency, rate) in [(1, 0.1, 10.0), (2, 0.4, 10.0), (2, 0.4, 1.0), (3, 0.3, 2.0)] {
            let motion = sines(&CBI.0.model, seed, frequency, 0.99);
            let mut bench = Bench::new(method, rate, 0.002);
            bench.run(&motion, 20.0);
            // The proof is exact to rounding. Between two ticks the path deviates by at most 50 h^2
            // / 8 from the straight line, 25 um with all joints of a chain of 1 m. This is less
            // than the allowance for the resolution of the proof.
            assert!(bench.least >= MARGIN - 5e-5, "method {method}: {}", bench.least);
            // The test is only meaningful if the avoider had to act.
            assert!(bench.desired_near > 100, "{}", bench.desired_near);
        }
    }
}

#[test]
fn limits_hold_on_smooth_and_discontinuous_motions() {
    let model = &CBI.0.model;
    let smooth = sines(model, 3, 0.2, 0.99);
    let mut r = Stream::new(4, &["jumps"]);
    let postures: Vec<Vec<f64>> = (0..20)
        .map(|_| model.joints.iter().map(|j| j.lower + (j.upper - j.lower) * (1.2 * r.unit() - 0.1)).collect())
        .collect();
    // A jump to a new posture every half a second, also beyond the ranges.
    let jumps = move |t: f64| {
        let posture = &postures[(t / 0.5) as usize % postures.len()];
        (posture.clone(), vec![0.0; posture.len()])
    };
    for method in [1, 2, 4] {
        for motion in [&*smooth, &jumps] {
            let mut bench = Bench::new(method, 10.0, 0.002);
            for _ in 0..5000 {
                bench.tick_once(motion(bench.tick as f64 * bench.period));
                bench.check_limits();
            }
        }
    }
}

#[test]
fn free_joints_keep_their_commands() {
    let model = &CBI.0.model;
    // The head alone moves, slowly, far from everything.
    let motion = sines(model, 5, 0.1, 0.9);
    let head = ["B_HN", "B_HR"].map(|n| model.joint(n).expect("it is there").0);
    let mut bench = Bench::new(2, 10.0, 0.002);
    for k in 0..5000 {
        let (q, v) = motion(f64::from(k) * 0.002);
        let (mut position, mut velocity) = (model.home.clone(), vec![0.0; model.nj()]);
        head.iter().for_each(|&j| (position[j], velocity[j]) = (q[j], v[j]));
        assert_eq!(bench.tick_once((position.clone(), velocity.clone())), (position, velocity), "tick {k}");
    }
    assert_eq!((bench.avoider.statistics.blocked, bench.avoider.statistics.greatest), (0, 0.0));
}

#[test]
fn method_1_stops_all_joints_and_method_2_only_the_obstructed_ones() {
    let model = &CBI.0.model;
    let joint = |name: &str| model.joint(name).expect("it is there").0;
    // The right hand moves into the thigh; the left arm and the head move freely.
    let mut goal = model.home.clone();
    for (name, angle) in [("R_SAA", 0.0f64), ("R_HR", -45.0), ("R_WFE", -20.0), ("L_SFE", 40.0), ("B_HN", 15.0)] {
        goal[joint(name)] = angle.to_radians();
    }
    let desired = move |t: f64| {
        let s = (t / 2.0).min(1.0);
        let (x, v) = (s.powi(3) * (10.0 - 15.0 * s + 6.0 * s * s), 15.0 * (s * (1.0 - s)).powi(2));
        let way: Vec<f64> = goal.iter().zip(&model.home).map(|(g, h)| g - h).collect();
        (model.home.iter().zip(&way).map(|(h, w)| h + x * w).collect(), way.iter().map(|w| v * w).collect())
    };
    let mut missed = Vec::new();
    let goal = desired(9.0).0;
    for method in 1..=4 {
        let mut bench = Bench::new(method, 10.0, 0.002);
        bench.run(&desired, 4.0);
        let last = bench.commanded[3].clone();
        let off = |name: &str| (last[joint(name)] - goal[joint(name)]).abs();
        assert!(bench.least >= MARGIN - 5e-5, "method {method}: {}", bench.least);
        if method == 1 {
            assert!(off("L_SFE") > 0.1 && off("B_HN") > 0.05, "{last:?}");
            assert!(bench.avoider.stopped().iter().all(|f| *f));
        } else {
            // Reached up to rounding of the path's sums, or exactly where the path is free.
            assert!(off("L_SFE") < 1e-9 && off("B_HN") < 1e-9, "{last:?}");
            // The waist is at its goal: it stopped with the arm and never moved.
            assert!(["B_TR", "B_TAA", "B_TFE"].iter().all(|n| off(n) == 0.0), "{last:?}");
            let stopped = bench.avoider.stopped();
            assert!(stopped[joint("R_SAA")] && !stopped[joint("L_SFE")] && !stopped[joint("B_HN")]);
        }
        missed.push(["R_SAA", "R_HR", "R_WFE"].iter().map(|n| off(n).powi(2)).sum::<f64>());
    }
    // Random postures bring the hand nearer to its unreachable goal.
    assert!(missed[2] < 0.9 * missed[1] && missed[3] < 0.9 * missed[1], "{missed:?}");
}

#[test]
fn a_removed_obstacle_is_forgotten() {
    let model = &CBI.0.model;
    let motion = sines(model, 2, 0.4, 0.99);
    for method in 1..=4 {
        let mut bench = Bench::new(method, 10.0, 0.002);
        bench.run(&*motion, 15.0);
        assert!(bench.avoider.statistics.blocked > 0);
        // A jump back to home: the robot arrives, and commands equal the desired posture.
        for _ in 0..3000 {
            bench.tick_once((model.home.clone(), vec![0.0; model.nj()]));
            bench.check_limits();
        }
        let (commanded, _) = bench.tick_once((model.home.clone(), vec![0.0; model.nj()]));
        let off = commanded.iter().zip(&model.home).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        // Methods 1 to 3 may find no path.
        if method == 4 {
            assert!(off < 1e-9, "method {method}: {off}");
        }
    }
}

#[test]
fn uncontrolled_joints_use_their_measured_positions() {
    let model = &CBI.0.model;
    let n = model.nj();
    let joint = |name: &str| model.joint(name).expect("it is there").0;
    // The right shoulder is limp and hangs 8 degrees nearer to the body than commanded. The
    // forearm, commanded through the thigh, must stop for the shoulder's measured position.
    let mut bench = Bench::new(2, 10.0, 0.002);
    let limp = joint("R_SAA");
    let follows: Vec<bool> = (0..n).map(|j| j != limp).collect();
    let mut measured = model.home.clone();
    measured[limp] = 0.0;
    let rates = vec![0.0; n];
    let mut desired_near = 0;
    for k in 0..2000 {
        let t = f64::from(k) * 0.002;
        let x = (t / 2.0).min(1.0);
        let (mut position, mut velocity) = (model.home.clone(), vec![0.0; n]);
        for (name, angle) in [("R_HR", -45.0f64), ("R_WFE", -20.0)] {
            position[joint(name)] = angle.to_radians() * x.powi(3) * (10.0 - 15.0 * x + 6.0 * x * x);
            velocity[joint(name)] = angle.to_radians() * 15.0 * (x * (1.0 - x)).powi(2);
        }
        let mut desired = position.clone();
        desired[limp] = 0.0;
        desired_near += u32::from(bench.distance(&desired) < MARGIN);
        let mut commanded = JointCommands {
            follows: &follows,
            measured: &measured,
            rates: &rates,
            position: &mut position,
            velocity: &mut velocity,
        };
        bench.avoider.tick(model, t, &mut commanded);
        // The limp joint's own entry keeps the task's value.
        assert_eq!(position[limp], model.home[limp]);
        position[limp] = 0.0;
        assert!(bench.distance(&position) > MARGIN, "at {t}");
    }
    assert!(desired_near > 100, "{desired_near}");
    assert!(bench.avoider.statistics.blocked > 0);
}

#[test]
fn repeated_runs_have_equal_bits_without_allocation() {
    let model = &CBI.0.model;
    for method in 1..=4 {
        let motion = sines(model, 6, 0.2, 0.99);
        let (mut one, mut other) = (Bench::new(method, 10.0, 0.002), Bench::new(method, 10.0, 0.002));
        let n = model.nj();
        let (follows, zero) = (vec![true; n], vec![0.0; n]);
        for k in 0..4000 {
            let t = f64::from(k) * 0.002;
            let (mut position, mut velocity) = motion(t);
            let desired = (position.clone(), velocity.clone());
            let mut commanded = JointCommands {
                follows: &follows,
                measured: &zero,
                rates: &zero,
                position: &mut position,
                velocity: &mut velocity,
            };
            let allocated = counting::count(|| one.avoider.tick(model, t, &mut commanded));
            assert_eq!(allocated, 0, "method {method}, tick {k}");
            let (repeated, _) = other.tick_once(desired);
            assert!(
                repeated.iter().zip(&position).all(|(a, b)| a.to_bits() == b.to_bits()),
                "method {method}, tick {k}"
            );
        }
        assert!(one.avoider.statistics.blocked > 0);
    }
}

#[test]
fn a_step_command_obeys_the_limits() {
    let model = &CBI.0.model;
    let nod = model.joint("B_HN").expect("it is there").0;
    for (size, rate, late) in
        [1e-3, 2e-3, 0.01, 0.05, 0.3].into_iter().flat_map(|s| [(s, 10.0, 3), (s, 2.0, 40), (s, 50.0, 1)])
    {
        let mut bench = Bench::new(2, rate, 0.002);
        let mut greatest = 0.0f64;
        for k in 0..1000 {
            let mut position = model.home.clone();
            if k >= 150 + late {
                position[nod] += size;
            }
            let (commanded, _) = bench.tick_once((position, vec![0.0; model.nj()]));
            bench.check_limits_but(if size <= 1e-3 { Some(nod) } else { None });
            greatest = greatest.max(commanded[nod] - model.home[nod]);
        }
        // A path that follows the step overshoots by at most a tenth, which is where two windows of
        // 10 ms agree. A step of 1 mrad counts as measurement noise and may overshoot by a few of
        // them.
        assert!(greatest <= size + if size <= 1e-3 { 5e-3 } else { 0.1 * size }, "{size} at {rate}: {greatest}");
        assert!((bench.commanded[3][nod] - model.home[nod] - size).abs() < 1e-9, "{size} at {rate}");
    }
}

#[test]
fn speed_limits_hold_where_a_motion_accelerates_through_them() {
    let (model, nod) = (&CBI.0.model, CBI.0.model.joint("B_HR").expect("it is there").0);
    for (speed, acceleration) in [(1.0, 20.0), (2.0, 45.0)] {
        let mut bench = Bench::new(2, 10.0, 0.002);
        bench.limits.iter_mut().for_each(|l| l.speed = speed);
        let settings = Settings { method: 2, rate: 10.0, margin: MARGIN, limits: bench.limits.clone(), seed: 1 };
        bench.avoider = Avoider::new(model, CBI.1.clone(), settings, &model.home, (0.0, 0.002));
        // From rest with a bounded jerk, far beyond the speed limit.
        let (mut q, mut v, mut a) = (model.home[nod], 0.0f64, 0.0f64);
        for _ in 0..400 {
            let (mut position, mut velocity) = (model.home.clone(), vec![0.0; model.nj()]);
            a = (a + 500.0 * 0.002).min(if v < 3.0 { acceleration } else { 0.0 });
            let before = v;
            v += 0.002 * a;
            q += 0.002 * 0.5 * (v + before);
            (position[nod], velocity[nod]) = (q, v);
            bench.tick_once((position, velocity));
            bench.check_limits();
        }
    }
}

#[test]
fn a_joint_outside_its_range_returns() {
    let (model, nod) = (&CBI.0.model, CBI.0.model.joint("B_HN").expect("it is there").0);
    let n = model.nj();
    let mut bench = Bench::new(2, 10.0, 0.002);
    let outside = model.joints[nod].upper + 0.01;
    let mut measured = model.home.clone();
    measured[nod] = outside;
    let zero = vec![0.0; n];
    // Limp against its stop; then it is controlled.
    for k in 0..600 {
        let follows: Vec<bool> = (0..n).map(|j| j != nod || k >= 100).collect();
        let (mut position, mut velocity) = (model.home.clone(), zero.clone());
        let mut commanded = JointCommands {
            follows: &follows,
            measured: &measured,
            rates: &zero,
            position: &mut position,
            velocity: &mut velocity,
        };
        bench.avoider.tick(model, f64::from(k) * 0.002, &mut commanded);
        if k == 100 {
            // From its current position, without a jump.
            assert!((position[nod] - outside).abs() < 1e-3, "{}", position[nod]);
        }
        bench.commanded[3] = position;
    }
    assert!((bench.commanded[3][nod] - model.home[nod]).abs() < 1e-9, "{}", bench.commanded[3][nod]);
}

#[test]
fn free_joints_keep_inconsistent_commanded_velocities() {
    let (model, turn) = (&CBI.0.model, CBI.0.model.joint("B_HR").expect("it is there").0);
    let mut bench = Bench::new(2, 10.0, 0.002);
    for k in 0..2000 {
        let t = f64::from(k) * 0.002;
        let mut position = model.home.clone();
        position[turn] += 0.1 * (1.0 - (1.5 * t).cos());
        let (commanded, velocity) = bench.tick_once((position.clone(), vec![0.0; model.nj()]));
        assert_eq!((commanded, velocity), (position, vec![0.0; model.nj()]), "tick {k}");
    }
}

#[test]
fn a_short_fast_motion_is_not_extrapolated() {
    let (model, nod) = (&CBI.0.model, CBI.0.model.joint("B_HN").expect("it is there").0);
    // 1 degree within 20 ms, with velocities: 20 times the allowed acceleration. Cycles fall
    // before, into and after it.
    for late in 0..12 {
        let mut bench = Bench::new(2, 10.0, 0.002);
        let (way, begin, mut greatest) = (1f64.to_radians(), 0.29 + 0.002 * f64::from(late), 0.0f64);
        for k in 0..600 {
            let s = ((f64::from(k) * 0.002 - begin) / 0.02).clamp(0.0, 1.0);
            let (mut position, mut velocity) = (model.home.clone(), vec![0.0; model.nj()]);
            position[nod] += way * s.powi(3) * (10.0 - 15.0 * s + 6.0 * s * s);
            velocity[nod] = way * 30.0 * (s * (1.0 - s)).powi(2) / 0.02;
            let (commanded, _) = bench.tick_once((position, velocity));
            greatest = greatest.max(commanded[nod] - model.home[nod]);
        }
        // A path that meets it may overshoot by some of it; extrapolation would reach 24 degrees.
        assert!(greatest < 1.5 * way, "{late}: {greatest}");
    }
}
