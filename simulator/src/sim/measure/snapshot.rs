//! Filling of snapshots from the plant and the estimator.

use crate::dynamics::body;
use crate::geometry::stable_point::Edge;
use crate::geometry::{convex_hull, stable_point};
use crate::robot::{DriveMode, Model};
use crate::sim::actuation::joint_efforts;
use crate::sim::plant::Plant;
use crate::sim::report::{EstimateSnapshot, Snapshot, SoleSnapshot};
use crate::sim::sensing::Estimator;
use crate::task::{PointOfInterest, SensorReadings, TaskServer};
use nalgebra::{Isometry3, Rotation3, Translation3, UnitQuaternion, Vector2, Vector3};
use std::fmt::Write;

/// A snapshot with all vectors allocated, to be filled repeatedly.
pub fn blank(model: &Model) -> Snapshot {
    Snapshot {
        q: vec![0.0; model.nj()],
        qd: vec![0.0; model.nj()],
        effort: vec![0.0; model.nj()],
        effort_desired: vec![0.0; model.nj()],
        q_desired: vec![0.0; model.nj()],
        qd_desired: vec![0.0; model.nj()],
        soles: model
            .soles
            .iter()
            .map(|s| {
                let k = s.vertices.len();
                SoleSnapshot {
                    state: String::with_capacity(32),
                    clamped: vec![false; k],
                    positions: vec![Vector3::zeros(); k],
                    velocities: vec![Vector3::zeros(); k],
                    forces: vec![Vector3::zeros(); k],
                }
            })
            .collect(),
        external: Vec::new(),
        ..Snapshot::default()
    }
}

/// An estimate with all vectors allocated.
pub fn blank_estimate(model: &Model) -> EstimateSnapshot {
    EstimateSnapshot {
        q: vec![0.0; model.nj()],
        qd: vec![0.0; model.nj()],
        load: vec![0.0; model.nj()],
        soles: vec![(Vector3::zeros(), Vector3::zeros()); model.soles.len()],
        static_soles: Vec::with_capacity(model.soles.len()),
        ..EstimateSnapshot::default()
    }
}

/// Fills an estimate from the readings and the estimator of the last tick.
pub fn fill_estimate(estimator: &Estimator, readings: &SensorReadings, out: &mut EstimateSnapshot) {
    let state = &estimator.state;
    out.time = state.time;
    out.base_pose = Isometry3::from_parts(Translation3::from(state.position), state.rotation);
    if state.v.len() > state.joints.len() {
        out.base_linear_velocity = Vector3::new(state.v[0], state.v[1], state.v[2]);
        out.base_angular_velocity = Vector3::new(state.v[3], state.v[4], state.v[5]);
    }
    out.q.copy_from_slice(&readings.position);
    out.qd.copy_from_slice(&readings.velocity);
    out.load.copy_from_slice(&readings.load);
    (out.orientation, out.angular_velocity) = (readings.orientation, readings.angular_velocity);
    out.specific_force = readings.specific_force;
    for (to, sole) in out.soles.iter_mut().zip(&readings.soles) {
        *to = (sole.force, sole.moment);
    }
    out.static_soles.clear();
    out.static_soles.extend_from_slice(estimator.static_soles());
}

/// Fills a snapshot from the plant's last evaluation. `edges` is scratch.
pub fn fill(plant: &mut Plant, edges: &mut Vec<Edge>, out: &mut Snapshot) {
    out.residual = plant.residual();
    let (state, model) = (&plant.state, &plant.model);
    let nb = model.nb();
    out.time = state.time;
    out.base_pose = Isometry3::from_parts(Translation3::from(state.position), state.rotation);
    if nb == 6 {
        out.base_linear_velocity = Vector3::new(state.v[0], state.v[1], state.v[2]);
        out.base_angular_velocity = Vector3::new(state.v[3], state.v[4], state.v[5]);
    }
    out.q.copy_from_slice(&state.joints);
    out.qd.copy_from_slice(&state.v[nb..]);
    out.effort.copy_from_slice(&plant.drives.efforts);
    for (j, desired) in out.effort_desired.iter_mut().enumerate() {
        let kinematic = plant.command.mode[j] == DriveMode::Kinematic;
        let (q, qd, command) = (state.joints[j], state.v[nb + j], plant.followed_command());
        let (servo, applied) = (joint_efforts::desired_effort(j, q, qd, command), plant.drives.efforts[j]);
        let is_applied = (servo - applied).abs() <= joint_efforts::effort_rounding(j, q, qd, command);
        *desired = if kinematic || is_applied { applied } else { servo };
    }
    plant.read_desired_motion(&mut out.q_desired, &mut out.qd_desired);
    out.object_poses.clear();
    for (object, ws) in plant.objects.list.iter().zip(&plant.objects.ws) {
        for (link, moved) in object.model.links.iter().zip(&ws.links) {
            let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(moved.rotation));
            let origin = Translation3::from(ws.position + moved.origin);
            out.object_poses.push(Isometry3::from_parts(origin, rotation) * link.urdf_frame);
        }
    }
    out.loops.clear();
    out.loops.extend(plant.loop_loads());
    out.couplings.clear();
    out.couplings.extend(plant.coupling_efforts());
    out.com = body::center_of_mass(&plant.ws);
    out.com_velocity = body::center_of_mass_velocity(&plant.ws);
    out.external.clone_from(&plant.arrows);
    let (mut load, mut moment) = (0.0, Vector3::zeros());
    let plane = plant.floor.plane();
    out.support_polygon.clear();
    let links = &plant.polygons[model.soles.len()..];
    out.links.resize_with(links.len(), Default::default);
    for ((name, link), polygon) in out.links.iter_mut().zip(links) {
        let k = polygon.number_of_vertices();
        polygon.name().clone_into(name);
        link.clamped.resize(k, false);
        [&mut link.positions, &mut link.velocities, &mut link.forces]
            .into_iter()
            .for_each(|list| list.resize(k, Vector3::zeros()));
    }
    let all = out.soles.iter_mut().chain(out.links.iter_mut().map(|(_, link)| link));
    for (s, sole) in all.enumerate() {
        let p = &plant.problem.soles[s];
        let k = p.vertices.len();
        let contact = plant.states[s];
        sole.state.clear();
        let _ = write!(sole.state, "{contact}");
        let (axes, origin) = (&plant.reduced.axes[s], plant.reduced.reference[s]);
        for (i, v) in p.vertices.iter().enumerate() {
            let (n, t) = (plant.solution.normal[s][i], plant.solution.tangent[s][i]);
            sole.clamped[i] = contact.clamps(i, k);
            sole.positions[i] = origin + axes * v.r;
            sole.velocities[i] = axes * v.velocity;
            sole.forces[i] = axes * Vector3::new(t.x, t.y, n);
            if plant.polygons[s].pair().is_some() {
                continue;
            }
            load += n;
            moment += sole.positions[i] * n;
            if sole.clamped[i] {
                out.support_polygon.push(plane.project(&sole.positions[i]));
            }
        }
    }
    for contact in plant.sole_contacts().filter(|contact| plant.polygons[contact.polygon].pair().is_some()) {
        let p = &plant.problem.soles[contact.polygon];
        let (axes, origin) = (plant.reduced.axes[contact.polygon], plant.reduced.reference[contact.polygon]);
        let clamped = (0..p.vertices.len()).filter(|i| plant.states[contact.polygon].clamps(*i, p.vertices.len()));
        out.support_polygon.extend(clamped.map(|i| plane.project(&(origin + axes * p.vertices[i].r))));
    }
    out.centre_of_pressure = if plant.pair_patches().next().is_some() {
        zero_moment_point(plant)
    } else {
        (load > 1e-9 * plant.problem.scale).then(|| plane.project(&(moment / load)))
    };
    convex_hull(&mut out.support_polygon, &plane);
    let corners = out.support_polygon.iter().map(|p| plane.flat(p));
    out.stable_point = stable_point(corners, edges).map(|found| plane.world(&found.point));
}

/// The point of the floor plane about which the contacts of the robot have no horizontal moment; none where
/// they do not carry it. On a plane it is the centre of pressure.
///
/// ```text
/// F = sum f_c,  M = sum m_c + (p_c - o) x f_c     o + (-M_y, M_x, 0) / F_z        in the floor's axes, o on the floor
/// ```
fn zero_moment_point(plant: &Plant) -> Option<Vector3<f64>> {
    let plane = plant.floor.plane();
    let (mut force, mut moment) = (Vector3::zeros(), Vector3::zeros());
    for s in 0..plant.polygons.len() {
        let (f, m) = plant.polygon_load(s);
        let arm = plant.reduced.reference[s] - plane.point;
        for (body, sign) in plant.reduced.bodies(s).zip([1.0, -1.0]) {
            if body.mechanism == 0 {
                force += f * sign;
                moment += (m + arm.cross(&f)) * sign;
            }
        }
    }
    let (f, m) = (plane.to_plane(&force), plane.to_plane(&moment));
    (f.z > 1e-9 * plant.problem.scale).then(|| plane.world(&Vector2::new(-m.y / f.z, m.x / f.z)))
}

/// The named points of all tasks, without positions.
pub fn blank_points(tasks: &TaskServer) -> Vec<PointOfInterest> {
    let mut points: Vec<PointOfInterest> = Vec::new();
    for (name, _) in tasks.points() {
        // Points of two tasks may have the same name.
        let taken = |name: &str| points.iter().any(|point| point.name == name);
        let names = std::iter::once(name.to_owned()).chain((2..).map(|n| format!("{name}.{n}")));
        let free = names.into_iter().find(|name| !taken(name)).unwrap_or_default();
        points.push(PointOfInterest::named(free));
    }
    points
}

/// Snapshots at a constant rate, or at given instants.
#[derive(Clone)]
pub struct SnapshotLog {
    /// The last snapshot.
    pub snapshot: Snapshot,
    /// Scratch of the point of optimal stability.
    pub edges: Vec<Edge>,
    /// Snapshots per second; 0 for the last one only.
    rate: f64,
    /// Instants, s, ascending; empty: those of the rate.
    instants: Vec<f64>,
    /// Instants of the log so far.
    count: u64,
    /// Time of the last snapshot, s.
    last: Option<f64>,
}

impl SnapshotLog {
    /// Starts with an empty snapshot.
    pub fn new(snapshot: Snapshot, rate: f64, instants: Vec<f64>) -> Self {
        SnapshotLog { snapshot, edges: Vec::new(), rate, instants, count: 0, last: None }
    }

    /// Time of the next snapshot due, s.
    pub fn next(&self) -> Option<f64> {
        match self.instants.as_slice() {
            [] => (self.rate > 0.0).then(|| self.count as f64 / self.rate),
            given => given.get(usize::try_from(self.count).ok()?).copied(),
        }
    }

    /// Counts an instant of the log at time `now`. Returns whether it differs from the last one.
    pub fn begin(&mut self, now: f64) -> bool {
        self.count += 1;
        self.last.replace(now) != Some(now)
    }
}
