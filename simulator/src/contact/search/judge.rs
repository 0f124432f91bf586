//! Judges a solved candidate: validity and violations (`docs/contact.md`, section 4).
//!
//! Criteria in order of importance:
//!
//! 1. *geometric*: no unclamped vertex below the floor, no clamped one above it;
//! 2. *kinematic* (Signorini): no unclamped vertex driven into the floor, no clamped one that pulls
//!    or separates;
//! 3. *friction* (Coulomb): loads inside the exact capacity, sliding opposed.
//!
//! Each level sums its violations in units of its tolerance. At the velocity level no anti-chatter
//! band is needed: an unclamped touching vertex must not approach beyond rounding.

use crate::contact::model::friction_capacity::{self, Slip};
use crate::contact::model::per_sole::PerSole;
use crate::contact::model::problem::{Level, Problem, SoleProblem, TOUCHING, Tolerances};
use crate::contact::model::sole_group;
use crate::contact::model::solution::Solution;
use crate::contact::model::state::{Mode, Pattern, SoleState, States};
use crate::contact::search::sliding_directions::Onset;
use crate::contact::search::static_loads::edge_load;
use crate::contact::search::turning_modes;
use nalgebra::{Vector2, Vector3};
use std::cmp::Ordering;

/// Violations of one sole of a candidate, by kind.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Faults {
    /// Unclamped vertices that enter the floor, one bit each.
    pub penetrating: u64,
    /// Unclamped vertices that touch and do not leave, one bit each.
    pub resting: u64,
    /// Whether the floor would have to pull, or a clamped vertex is above the floor or leaves it.
    pub pulling: bool,
    /// Whether the friction law is violated.
    pub friction: bool,
}

/// Distance of a sole from leaving its state, in units of [`Problem::scale`]; positive inside.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Margin {
    /// Distance from a pulling floor: least vertex load, or for a face load times the distance of
    /// the centre of pressure from the border over the sole radius.
    pub normal: f64,
    /// Distance from slip of a static pattern or a pivot.
    pub friction: f64,
    /// Slip twist of least margin, in which the sole gives way against the friction it carries.
    pub slip: Slip,
}

impl Default for Margin {
    fn default() -> Self {
        Margin { normal: f64::INFINITY, friction: f64::INFINITY, slip: Slip::zeros() }
    }
}

/// A judged candidate.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Assessment {
    /// Violations by level: geometric, kinematic, friction.
    pub levels: [f64; 3],
    /// Tie-breakers among equals: unclamped vertices that neither carry nor leave, normal rows,
    /// number of dynamic soles, rows, soles that changed state.
    pub rank: [usize; 5],
    /// Action of the floor, `w . W w`: the last tie-breaker, independent of the order of soles and
    /// vertices.
    pub action: f64,
    /// Violations by sole.
    pub faults: PerSole<Faults>,
}

impl Assessment {
    /// Whether there is no violation.
    pub fn valid(&self) -> bool {
        self.levels == [0.0; 3]
    }

    /// Orders candidates; the better one is less.
    ///
    /// A touching vertex that stays on the floor is better clamped: on a body with redundant feet
    /// the smallest set that carries it would depend on their order. Then fewer clamped normals are
    /// better, then sticking rather than sliding: the number of rows alone would prefer slip onset
    /// (3 rows) to a face that sticks within its capacity (6 rows).
    pub fn compare(&self, other: &Assessment) -> Ordering {
        self.levels
            .iter()
            .zip(&other.levels)
            .map(|(a, b)| compare_clearly(*a, *b))
            .find(|o| o.is_ne())
            .unwrap_or_else(|| self.rank.cmp(&other.rank))
            .then_with(|| compare_clearly(self.action, other.action))
    }
}

/// Allowed deviation of a clamped vertex from its target normal velocity, relative to the greatest
/// speed: far above rounding, far below the deviation that contradicting targets cause.
const MISSED: f64 = 1e-6;

/// Part of the accelerations without contact that clamped vertices may have in directions that their states
/// clamp: far above rounding and the digits of robot files. A solution has more where conditions contradict
/// each other, such as those of a body that rests and is moved by a link with a prescribed motion.
pub(crate) const CONTRADICTED: f64 = 1e-6;

/// Greatest acceleration of a clamped vertex of sole `s` in the directions that its state clamps: normal,
/// tangential, relative to `scale`.
fn contradiction(p: &Problem, states: &States, s: usize, solution: &Solution, scale: f64) -> (f64, f64) {
    let (state, k) = (states[s], p.soles[s].vertices.len());
    let clamped = (0..k).filter(|i| state.clamps(*i, k)).map(|i| (i, p.vertex_motion(&solution.motion, s, i) / scale));
    clamped.fold((0.0, 0.0), |(normal, tangential): (f64, f64), (i, motion)| {
        let holds = state.is_static() || state.mode == Mode::Pivoting(i as u8);
        (normal.max(motion.z.abs()), if holds { tangential.max(motion.xy().norm()) } else { tangential })
    })
}

/// Greatest acceleration of a contact without contact forces, m/s^2, at least 1.
fn greatest_drive(p: &Problem) -> f64 {
    let linear = p.b.chunks_exact(6).flat_map(|b| &b[..3]);
    linear.fold(1.0, |most: f64, b| most.max(b.abs()))
}

/// The greatest such acceleration of all soles.
pub(crate) fn greatest_contradiction(p: &Problem, states: &States, solution: &Solution) -> f64 {
    let scale = greatest_drive(p);
    let each = (0..p.soles.len()).map(|s| contradiction(p, states, s, solution, scale));
    each.fold(0.0, |most: f64, (normal, tangential)| most.max(normal).max(tangential))
}

/// Order of two numbers; differences that the order of summation can cause count as equal.
fn compare_clearly(a: f64, b: f64) -> Ordering {
    if (a - b).abs() <= 1e-9 * (a.abs() + b.abs()) { Ordering::Equal } else { a.total_cmp(&b) }
}

/// Inputs of the judge other than the candidate.
#[derive(Clone, Debug)]
pub struct Rules {
    /// The scenario's tolerances.
    pub tolerances: Tolerances,
    /// Previous states.
    pub previous: States,
    /// Soles whose previous state an event has just brought to the limit of its load: bit 0 normal,
    /// bit 1 friction. Their margin must then be clearly positive for that state to remain.
    pub suspect: PerSole<u8>,
    /// Whether an unclamped vertex may leave the floor at up to v_t although it will return. Such
    /// hops are normally stopped to keep bouncing finite; if no valid state stops them they are
    /// physical.
    pub hops: bool,
    /// Rounding allowed in margins, relative to the load scale.
    pub rounding: f64,
    /// Whether all states are searched as a last resort.
    pub exhaustive: bool,
    /// Whether conditions may contradict each other: motions are prescribed, or links coupled. Otherwise
    /// contradictions are errors of the state within the tolerances.
    pub may_contradict: bool,
    /// Whether motion that a new state does not allow will be stopped. Otherwise vertices slide on along
    /// their velocities, however slow.
    pub stops: bool,
}

impl Rules {
    /// Rules without a suspicion.
    pub fn new(tolerances: Tolerances, previous: States) -> Self {
        Rules {
            tolerances,
            previous,
            suspect: PerSole::default(),
            hops: false,
            rounding: ROUNDING,
            exhaustive: true,
            may_contradict: false,
            stops: true,
        }
    }

    /// Suspicions of a sole. Impulses are not the loads that reached their limits.
    pub fn suspect(&self, p: &Problem, s: usize) -> u8 {
        if p.level == Level::Acceleration { self.suspect[s] } else { 0 }
    }
}

/// Speed up to which a vertex does not slide on, m/s: rounding.
pub const STILL: f64 = 1e-12;

/// Bit of `Rules::suspect`: the normal load is in doubt.
pub const SUSPECT_NORMAL: u8 = 1;
/// Bit of `Rules::suspect`: the friction load is in doubt.
pub const SUSPECT_FRICTION: u8 = 2;
/// Bit of `Rules::suspect`: a torsional or rolling moment is in doubt.
pub const SUSPECT_TURNING: u8 = 4;

/// Rounding normally allowed in margins, relative to the load scale: solves with condition numbers
/// up to about 1e4.
pub const ROUNDING: f64 = 1e-12;
/// The same where no state is valid otherwise: condition numbers up to about 1e7, of light feet
/// under a heavy robot.
pub const MOST_ROUNDING: f64 = 1e-9;
/// Margin that clears a suspicion, relative to the load scale.
pub const CLEAR: f64 = 1e-9;

/// Judges a solved candidate. `slides` is true if all undetermined sliding directions were found.
pub fn judge(p: &Problem, states: &States, solution: &Solution, slides: bool, rules: &Rules) -> Assessment {
    let tol = &rules.tolerances;
    let mut assessment = Assessment::default();
    let (speed, scale) = (greatest_speed(p), greatest_drive(p));
    for (s, sole) in p.soles.iter().enumerate() {
        let state = states[s];
        let mut faults = Faults::default();
        let drive = p.b[6 * s..6 * s + 3].iter().map(|b| b.abs()).fold(0.0, f64::max);
        let k = sole.vertices.len();
        for (i, v) in sole.vertices.iter().enumerate() {
            let motion = p.vertex_motion(&solution.motion, s, i).z;
            let clamped = state.clamps(i, k);
            let (geometric, kinematic) = match p.level {
                Level::Acceleration if clamped => {
                    let high = v.height > tol.distance && sole.clampable(tol) >> i & 1 == 0;
                    let far = if high { v.height / tol.distance } else { f64::from(v.leaves) };
                    let speed = v.velocity.z / tol.velocity;
                    (far, if speed > 1.0 { speed } else { 0.0 })
                }
                // The motion after the impulse decides.
                Level::Velocity if clamped => {
                    // Redundant soles may have contradicting rebound targets; the deviation counts
                    // as a violation.
                    let missed = (motion - sole.vertex_target(i)).abs() / speed;
                    let far = if v.near { 0.0 } else { 1.0 + v.height.max(0.0) / tol.distance };
                    (far, if missed > MISSED { missed } else { 0.0 })
                }
                _ => unclamped_violation(p, s, i, motion, speed, rules),
            };
            let rests = p.level == Level::Acceleration
                && v.height.abs() <= TOUCHING
                && v.velocity.z.abs() <= tol.rest
                && motion.abs() <= CLEAR * drive;
            faults.resting |= u64::from(!clamped && rests) << i;
            faults.pulling |= clamped && geometric + kinematic > 0.0;
            faults.penetrating |= u64::from(!clamped && geometric + kinematic > 0.0) << i;
            assessment.levels[0] += geometric;
            assessment.levels[1] += kinematic;
        }
        assessment.rank[0] += faults.resting.count_ones() as usize;
        if state == SoleState::FREE {
            assessment.faults.set(s, faults);
            continue;
        }
        if rules.may_contradict && p.level == Level::Acceleration {
            let (normal, tangential) = contradiction(p, states, s, solution, scale);
            if normal > CONTRADICTED {
                assessment.levels[1] += normal;
                faults.pulling = true;
            }
            if tangential > CONTRADICTED {
                assessment.levels[2] += tangential;
                faults.friction = true;
            }
        }
        let normal = normal_margin(p, state, s, solution);
        // In another state the friction differs. A lost normal load may also be missing in a
        // smaller pattern.
        let suspect = rules.suspect(p, s) & if state == rules.previous[s] { u8::MAX } else { SUSPECT_NORMAL };
        let floor = |bit: u8| if suspect & bit != 0 { CLEAR } else { -rules.rounding };
        // A face whose pressure rule failed has negative forces, wherever its centre of pressure
        // is.
        if !(normal >= floor(SUSPECT_NORMAL)) || !solution.inside[s] {
            assessment.levels[1] += 1.0 + (-normal).max(0.0);
            faults.pulling = true;
        }
        let legal = match state.mode {
            Mode::Static => sole.vertices.iter().enumerate().all(|(i, v)| !state.clamps(i, k) || !v.moving),
            Mode::Sliding => true,
            Mode::Pivoting(j) => !sole.vertices[j as usize].moving,
        };
        // Usually the vertex forces show that the load is carried, and the margin is not needed.
        let certain = suspect & SUSPECT_FRICTION == 0 && friction_suffices(p, states, s, solution);
        let friction = if certain { 0.0 } else { margin(p, states, s, solution).friction };
        if !legal || (state.is_dynamic() && !slides) || !(friction >= floor(SUSPECT_FRICTION)) {
            assessment.levels[2] += 1.0 + (-friction).clamp(0.0, 1e6) + f64::from(!legal);
            faults.friction = true;
        }
        if turning_modes::fault(p, s, solution, rules).is_some() {
            assessment.levels[2] += 1.0;
            faults.friction = true;
        }
        assessment.faults.set(s, faults);
        assessment.rank[1] += state.normal_rows();
        assessment.rank[2] += usize::from(state.is_dynamic());
        assessment.rank[3] += state.rows();
    }
    assessment.action =
        solution.wrench.iter().zip(solution.motion.iter().zip(&p.b)).map(|(w, (m, b))| w * (m - b)).sum();
    assessment.rank[4] = (0..p.soles.len()).filter(|&s| states[s] != rules.previous[s]).count();
    assessment
}

/// Greatest speed of a vertex, m/s, at least 1: the scale of motions at the velocity level.
pub fn greatest_speed(p: &Problem) -> f64 {
    p.soles.iter().flat_map(|s| &s.vertices).map(|v| v.velocity.norm()).fold(1.0, f64::max)
}

/// Geometric and kinematic violation of the unclamped vertex `i` of sole `s` with the normal motion
/// `motion`. `scale` is [`greatest_speed`].
pub fn unclamped_violation(p: &Problem, s: usize, i: usize, motion: f64, scale: f64, rules: &Rules) -> (f64, f64) {
    let (v, tol) = (&p.soles[s].vertices[i], &rules.tolerances);
    if p.level == Level::Velocity {
        // Above the floor and within d of it, an approach up to v_t is tolerated until the vertex
        // arrives.
        let tolerated = if v.height > TOUCHING { tol.velocity } else { 0.0 };
        let short = (p.soles[s].vertex_target(i) - motion - tolerated) / scale;
        return (0.0, if v.near && short > 1e-10 { short } else { 0.0 });
    }
    let (height, speed) = (v.height / tol.distance, v.velocity.z / tol.velocity);
    if height > 1.0 || v.leaves {
        return (0.0, 0.0);
    }
    let kinematic = if speed < -1.0 {
        -speed
    } else if speed <= 1.0 && motion < -tol.acceleration && !(rules.hops && v.velocity.z > tol.rest) {
        -motion / tol.acceleration
    } else {
        0.0
    };
    // A vertex that an event found at the edge of the band may continue there.
    let deep = v.height < -(tol.distance + TOUCHING);
    let rises = speed > 0.0 || v.velocity.z > -tol.rest && motion > 0.0;
    (if deep && !rises { -height } else { 0.0 }, kinematic)
}

/// Margins of one sole in its state. Needs the vertex forces of the solution. Static soles of one
/// body have the friction margin of their group.
pub fn margin(p: &Problem, states: &States, s: usize, solution: &Solution) -> Margin {
    let state = states[s];
    let sole = &p.soles[s];
    let k = sole.vertices.len();
    let (n, t) = (&solution.normal[s], &solution.tangent[s]);
    let w = &solution.wrench[6 * s..6 * s + 6];
    let mut m = Margin::default();
    if state.pattern == Pattern::Free {
        return m;
    }
    m.normal = normal_margin(p, state, s, solution);
    if sole_group::is_shared(p, states, s) {
        let group = sole_group::group_margin(p, states, s, solution);
        m.friction = group.margin / p.scale;
        m.slip = group.slip(p, s);
        return m;
    }
    let capacity = |i: usize| sole.vertices[i].stick_mu(p.level) * n[i].max(0.0);
    m.friction = match (state.mode, state.pattern) {
        (Mode::Sliding, _) => f64::INFINITY,
        (Mode::Pivoting(j), _) => friction_capacity::vertex(capacity(j as usize), &t[j as usize]),
        (Mode::Static, Pattern::Vertex(i)) => {
            let t = &t[i as usize];
            let size = t.norm();
            if size > 0.0 {
                m.slip = Vector3::new(-t.x / size, -t.y / size, 0.0);
            }
            friction_capacity::vertex(capacity(i as usize), t)
        }
        (Mode::Static, Pattern::Edge(i)) => {
            let (i, j) = (i as usize, (i as usize + 1) % k);
            let (_, side, along, unit) = edge_load(sole, i, j, w);
            let across = Vector2::new(-unit.y, unit.x);
            let pull = across * (side[0] + side[1]) + unit * along;
            let size = pull.norm();
            if size > 0.0 {
                m.slip = Vector3::new(-pull.x / size, -pull.y / size, 0.0);
            }
            friction_capacity::edge([capacity(i), capacity(j)], side, along)
        }
        (Mode::Static, _) => {
            let mut points = [(0.0, Vector2::zeros()); 64];
            (0..k).for_each(|i| points[i] = (capacity(i), sole.vertices[i].r.xy()));
            let (margin, slip) = friction_capacity::face(&points[..k], &Vector2::new(w[0], w[1]), w[5], sole.radius);
            m.slip = -slip;
            margin
        }
    } / p.scale;
    m
}

/// [`Margin::normal`] of one sole in its state.
fn normal_margin(p: &Problem, state: SoleState, s: usize, solution: &Solution) -> f64 {
    let sole = &p.soles[s];
    let k = sole.vertices.len();
    let n = &solution.normal[s];
    let w = &solution.wrench[6 * s..6 * s + 6];
    let margin = match state.pattern {
        Pattern::Free => f64::INFINITY,
        Pattern::Vertex(i) => n[i as usize],
        Pattern::Edge(i) => n[i as usize].min(n[(i as usize + 1) % k]),
        Pattern::Face if state.is_static() => border_margin(sole, w[2], [-w[4], w[3]]),
        Pattern::Face => {
            let moment = |axis: usize| sole.vertices.iter().zip(n).map(|(v, n)| v.r[axis] * n).sum::<f64>();
            border_margin(sole, n.iter().sum(), [moment(0), moment(1)])
        }
    } / p.scale;
    // Without a non-negative pressure the load is outside, wherever its centre of pressure is.
    if solution.inside[s] { margin } else { margin.min(-ROUNDING) }
}

/// Whether the vertex forces of a static face prove that friction carries the load. False proves
/// nothing.
pub fn friction_suffices(p: &Problem, states: &States, s: usize, solution: &Solution) -> bool {
    let sole = &p.soles[s];
    let w = &solution.wrench[6 * s..6 * s + 6];
    let vertices = sole.vertices.iter().zip(&solution.normal[s]);
    let points = vertices.map(|(v, n)| (v.stick_mu(p.level) * n.max(0.0), v.r.xy()));
    states[s] == SoleState::fixed(Pattern::Face)
        && !sole_group::is_shared(p, states, s)
        && friction_capacity::carries(points, &solution.tangent[s], &Vector2::new(w[0], w[1]), w[5], sole.radius)
}

/// Slip directions of the vertices of a sole whose friction load is at its limit. Vertices that
/// hold, such as the centre of a turn, are left out.
pub fn onset(p: &Problem, states: &States, s: usize, solution: &Solution, out: &mut Onset) {
    let state = states[s];
    let sole = &p.soles[s];
    let k = sole.vertices.len();
    let (n, t) = (&solution.normal[s], &solution.tangent[s]);
    out.vertices = 0;
    let shared = sole_group::is_shared(p, states, s);
    match (state.mode, state.pattern) {
        (Mode::Sliding, _) | (_, Pattern::Free) => {}
        (Mode::Pivoting(j), _) => out.against(j as usize, &t[j as usize]),
        (Mode::Static, Pattern::Vertex(i)) if !shared => out.against(i as usize, &t[i as usize]),
        (Mode::Static, Pattern::Edge(i)) if !shared => {
            let (i, j) = (i as usize, (i as usize + 1) % k);
            let (_, side, along, unit) = edge_load(sole, i, j, &solution.wrench[6 * s..6 * s + 6]);
            let across = Vector2::new(-unit.y, unit.x);
            let capacity = [i, j].map(|i| sole.vertices[i].stick_mu(p.level) * n[i].max(0.0));
            let room = [0, 1].map(|c| (capacity[c] * capacity[c] - side[c] * side[c]).max(0.0).sqrt());
            let spare = [0, 1].map(|c| capacity[c] - side[c].abs());
            let reach = room[0] + room[1] - along.abs();
            // Either the whole edge slips along itself, or one end slips across it and turns about
            // the other.
            for (c, vertex) in [i, j].into_iter().enumerate() {
                if reach <= spare[0].min(spare[1]) {
                    out.against(vertex, &(across * side[c] + unit * (room[c] * along.signum())));
                } else if spare[c] <= spare[1 - c] {
                    out.against(vertex, &(across * side[c]));
                }
            }
        }
        (Mode::Static, _) => {
            let slip = margin(p, states, s, solution).slip;
            for (i, v) in sole.vertices.iter().enumerate().filter(|(i, _)| state.clamps(*i, k)) {
                let motion = slip.xy() + Vector2::new(-v.r.y, v.r.x) * (slip.z / sole.radius);
                // A vertex that does not move in the twist of least margin is its centre.
                if motion.norm() > 1e-9 * slip.norm() {
                    out.against(i, &-motion);
                }
            }
        }
    }
}

/// Load times the least distance of the centre of pressure from the polygon's edges (positive
/// inside), over the radius. `moment` is the first moment of the pressure, sum of r N, in x and y.
fn border_margin(sole: &SoleProblem, load: f64, moment: [f64; 2]) -> f64 {
    let k = sole.vertices.len();
    let first = Vector2::new(moment[0], moment[1]);
    (0..k).fold(f64::INFINITY, |least, i| {
        let (a, b) = (sole.vertices[i].r.xy(), sole.vertices[(i + 1) % k].r.xy());
        let d = b - a;
        let inward = Vector2::new(-d.y, d.x).normalize();
        // The reference point is the vertices' centroid, so it lies inside.
        let inward = if inward.dot(&a) > 0.0 { -inward } else { inward };
        least.min(inward.dot(&(first - a * load)) / sole.radius)
    })
}
