//! Fields of the table `robot` that a script reads: their names, layouts and sources.
//!
//! A new part needs a line in [`task_fields`] and its name in [`PARTS`].

use crate::dynamics::{State, Workspace, body, jacobian};
use crate::robot::{LinkId, Model};
use crate::task::augmented::contact_points;
use crate::task::{AugmentedData, Command, Needs, SensorReadings};
use nalgebra::{Isometry3, Matrix3, Vector3};

/// The robot at one instant.
pub struct View<'a> {
    /// Simulated time, s.
    pub time: f64,
    /// The robot.
    pub model: &'a Model,
    /// Free fall in world axes, m/s^2.
    pub gravity: Vector3<f64>,
    /// Positions and velocities; for tasks the estimated ones.
    pub state: &'a State,
    /// Kinematics at that state; for tasks only if a requested part depends on it.
    pub kinematics: &'a Workspace,
    /// Additional data of tasks.
    pub task: Option<TaskView<'a>>,
}

/// Data that only tasks read.
pub struct TaskView<'a> {
    /// Sensor readings.
    pub sensed: &'a SensorReadings,
    /// Augmented data.
    pub data: &'a AugmentedData,
    /// Present joint commands.
    pub command: &'a Command,
}

/// Layout of numbers in a script's tables.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Shape {
    /// One number.
    Number,
    /// `{ .. }` of this length.
    List(usize),
    /// This many rows of this many numbers.
    Matrix(usize, usize),
    /// A list, or nil.
    Optional(usize),
    /// At most this many rows of this many numbers.
    Rows(usize, usize),
}

impl Shape {
    /// Numbers in the buffer; the last two shapes begin with the count of lists or rows.
    pub fn size(self) -> usize {
        match self {
            Shape::Number => 1,
            Shape::List(n) => n,
            Shape::Matrix(rows, columns) => rows * columns,
            Shape::Optional(n) => 1 + n,
            Shape::Rows(rows, columns) => 1 + rows * columns,
        }
    }
}

type Read = Box<dyn Fn(&View, &mut [f64]) + Send>;

/// An entry of the table `robot` and the source of its numbers.
pub struct Field {
    /// Path of keys.
    pub path: Vec<String>,
    /// Layout.
    pub shape: Shape,
    /// Fills its numbers, row by row.
    pub read: Read,
}

fn field<const N: usize>(path: [&str; N], shape: Shape, read: impl Fn(&View, &mut [f64]) + Send + 'static) -> Field {
    Field { path: path.map(str::to_owned).into(), shape, read: Box::new(read) }
}

fn vector<const N: usize>(path: [&str; N], read: impl Fn(&View) -> Vector3<f64> + Send + 'static) -> Field {
    field(path, Shape::List(3), move |view, out| out.copy_from_slice(read(view).as_slice()))
}

/// Names of the parts that a script can request, with the task server's flags.
pub const PARTS: [(&str, Needs); 15] = [
    ("com", Needs::COM),
    ("com_jacobian", Needs::COM_JACOBIAN),
    ("com_jacobian_base", Needs::COM_JACOBIAN_BASE),
    ("mass_matrix", Needs::MASS),
    ("bias", Needs::BIAS),
    ("gravity_effort", Needs::GRAVITY),
    ("soles", Needs::SOLES),
    ("sole_jacobians", Needs::SOLE_JACOBIANS),
    ("vertex_jacobians", Needs::VERTEX_JACOBIANS),
    ("end_effectors", Needs::END_EFFECTORS),
    ("loads", Needs::LOADS),
    ("contacts", Needs::CONTACTS),
    ("zmp", Needs::ZMP),
    ("support", Needs::SUPPORT),
    ("stable_point", Needs::STABLE_POINT),
];

/// Fields of every script.
pub fn common_fields(model: &Model) -> Vec<Field> {
    let nb = model.nb();
    let base = move |view: &View, from: usize| match nb {
        6 => Vector3::from_column_slice(&view.state.v[from..from + 3]),
        _ => Vector3::zeros(),
    };
    vec![
        field(["time"], Shape::Number, |view, out| out[0] = view.time),
        vector(["gravity"], |view| view.gravity),
        field(["q"], Shape::List(model.nj()), |view, out| out.copy_from_slice(&view.state.joints)),
        field(["qd"], Shape::List(model.nj()), move |view, out| out.copy_from_slice(&view.state.v[nb..])),
        vector(["base", "position"], |view| view.state.position),
        field(["base", "rotation"], Shape::Matrix(3, 3), |view, out| {
            write_matrix(&view.state.rotation.to_rotation_matrix().into_inner(), out);
        }),
        vector(["base", "linear_velocity"], move |view| base(view, 0)),
        vector(["base", "angular_velocity"], move |view| base(view, 3)),
    ]
}

/// Pose and velocity of a link's URDF frame; `frame` is that frame in the carrying link's internal
/// one.
pub fn link_fields(name: &str, link: LinkId, frame: Isometry3<f64>) -> Vec<Field> {
    let (local, turn) = (frame.translation.vector, frame.rotation.to_rotation_matrix().into_inner());
    let point = move |view: &View| view.kinematics.point(link, &local);
    vec![
        vector(["link", name, "position"], point),
        field(["link", name, "rotation"], Shape::Matrix(3, 3), move |view, out| {
            write_matrix(&(view.kinematics.links[link.0].rotation * turn), out);
        }),
        vector(["link", name, "linear_velocity"], move |view| {
            jacobian::point_velocity(view.kinematics, link, &point(view))
        }),
        vector(["link", name, "angular_velocity"], move |view| view.kinematics.links[link.0].velocity.angular),
    ]
}

/// The centre of mass from the present kinematics.
pub fn com_fields() -> Vec<Field> {
    vec![
        vector(["com"], |view| body::center_of_mass(view.kinematics)),
        vector(["com_velocity"], |view| body::center_of_mass_velocity(view.kinematics)),
    ]
}

/// A field that reads the data of a task.
fn task_field<const N: usize>(
    path: [&str; N],
    shape: Shape,
    read: impl Fn(&TaskView, &mut [f64]) + Send + 'static,
) -> Field {
    field(path, shape, move |view, out| {
        if let Some(task) = &view.task {
            read(task, out);
        }
    })
}

/// Fields of every task: sensors and joint commands.
pub fn sensor_fields(model: &Model) -> Vec<Field> {
    let joints = Shape::List(model.nj());
    let imu = |name: &str, read: fn(&SensorReadings) -> Vector3<f64>| {
        task_field(["imu", name], Shape::List(3), move |t, out| out.copy_from_slice(read(t.sensed).as_slice()))
    };
    let desired = |name: &str, read: fn(&Command) -> &[f64]| {
        task_field(["desired", name], joints, move |t, out| out.copy_from_slice(read(t.command)))
    };
    vec![
        task_field(["load"], joints, |t, out| out.copy_from_slice(&t.sensed.load)),
        imu("angular_velocity", |s| s.angular_velocity),
        imu("specific_force", |s| s.specific_force),
        desired("position", |c| &c.position),
        desired("velocity", |c| &c.velocity),
        desired("effort", |c| &c.effort),
        desired("kp", |c| &c.kp),
        desired("kd", |c| &c.kd),
    ]
}

/// Fields of the parts that a task has requested.
pub fn task_fields(model: &Model, needs: Needs) -> Vec<Field> {
    let (nv, nj) = (model.nv(), model.nj());
    let points = contact_points(model);
    let mut fields = Vec::new();
    let mut add = |part: Needs, more: Vec<Field>| {
        if needs.contains(part) {
            fields.extend(more);
        }
    };
    let jacobian = |name: &str, columns, read: fn(&AugmentedData) -> &[f64]| {
        task_field([name], Shape::Matrix(3, columns), move |t, out| write_transposed(3, read(t.data), out))
    };
    let list = |name: &str, read: fn(&AugmentedData) -> &[f64]| {
        task_field([name], Shape::List(nv), move |t, out| out.copy_from_slice(read(t.data)))
    };
    let optional_point = |name: &str, read: fn(&AugmentedData) -> &Option<Vector3<f64>>| {
        task_field([name], Shape::Optional(3), move |t, out| {
            write_counted(3, read(t.data).iter().map(|p| [p.x, p.y, p.z]), out);
        })
    };
    add(Needs::COM, com_fields());
    add(Needs::COM_JACOBIAN, vec![jacobian("com_jacobian", nv, |d| &d.com_jacobian)]);
    add(Needs::COM_JACOBIAN_BASE, vec![jacobian("com_jacobian_base", nj, |d| &d.com_jacobian_base)]);
    let mass = move |view: &View, out: &mut [f64]| {
        (0..nv * nv).for_each(|i| out[i] = view.kinematics.mass.get(i / nv, i % nv));
    };
    add(Needs::MASS, vec![field(["mass_matrix"], Shape::Matrix(nv, nv), mass)]);
    add(Needs::BIAS, vec![list("bias", |d| &d.workspace.bias)]);
    add(Needs::GRAVITY, vec![list("gravity_effort", |d| &d.gravity_effort)]);
    for s in 0..model.soles.len() {
        sole_fields(model, s).into_iter().for_each(|(part, field)| add(part, vec![field]));
    }
    for e in 0..model.end_effectors.len() {
        add(Needs::END_EFFECTORS, end_effector_fields(model, e));
    }
    let contacts = task_field(["contacts"], Shape::Rows(points, 6), |t, out| {
        let rows = t.data.contacts.iter().map(|c| [c.position, c.force].into_iter().flat_map(|v| [v.x, v.y, v.z]));
        write_counted(6, rows, out);
    });
    add(Needs::CONTACTS, vec![contacts]);
    add(Needs::ZMP, vec![optional_point("zmp", |d| &d.zmp)]);
    let polygon = task_field(["support_polygon"], Shape::Rows(points, 3), |t, out| {
        write_counted(3, t.data.support_polygon.iter().map(|p| [p.x, p.y, p.z]), out);
    });
    add(Needs::SUPPORT, vec![polygon]);
    let radius = task_field(["stable_radius"], Shape::Number, |t, out| out[0] = t.data.stable_radius);
    add(Needs::STABLE_POINT, vec![optional_point("stable_point", |d| &d.stable_point), radius]);
    fields
}

/// Fields of sole `s`, by part.
fn sole_fields(model: &Model, s: usize) -> Vec<(Needs, Field)> {
    let (nv, sole) = (model.nv(), &model.soles[s]);
    let (name, k) = (sole.name.as_str(), sole.vertices.len());
    let point = |key: &str, read: fn(&TaskView, usize) -> Vector3<f64>| {
        task_field(["sole", name, key], Shape::List(3), move |t, out| out.copy_from_slice(read(t, s).as_slice()))
    };
    let points = |key: &str, read: fn(&AugmentedData, usize) -> &[Vector3<f64>]| {
        task_field(["sole", name, key], Shape::Matrix(k, 3), move |t, out| {
            out.chunks_exact_mut(3).zip(read(t.data, s)).for_each(|(row, p)| row.copy_from_slice(p.as_slice()));
        })
    };
    let jacobian = task_field(["sole", name, "jacobian"], Shape::Matrix(6, nv), move |t, out| {
        write_transposed(6, &t.data.soles[s].jacobian, out);
    });
    let mut fields = vec![
        (Needs::LOADS, point("force", |t, s| t.sensed.soles[s].force)),
        (Needs::LOADS, point("moment", |t, s| t.sensed.soles[s].moment)),
        (Needs::SOLES, point("position", |t, s| t.data.soles[s].position)),
        (Needs::SOLES, points("vertices", |d, s| &d.soles[s].vertices)),
        (Needs::CONTACTS, points("vertex_forces", |d, s| &d.soles[s].vertex_forces)),
        (Needs::SOLE_JACOBIANS, jacobian),
    ];
    for i in 0..k {
        let key = format!("vertex_jacobian_{}", i + 1);
        let read = move |t: &TaskView, out: &mut [f64]| write_transposed(3, &t.data.soles[s].vertex_jacobians[i], out);
        fields.push((Needs::VERTEX_JACOBIANS, task_field(["sole", name, &key], Shape::Matrix(3, nv), read)));
    }
    fields
}

fn end_effector_fields(model: &Model, e: usize) -> Vec<Field> {
    let name = model.end_effectors[e].name.as_str();
    let of = |key, shape, read: fn(&crate::task::augmented::EndEffectorData, &mut [f64])| {
        task_field(["end_effector", name, key], shape, move |t, out| read(&t.data.end_effectors[e], out))
    };
    vec![
        of("position", Shape::List(3), |d, out| out.copy_from_slice(d.pose.translation.vector.as_slice())),
        of("rotation", Shape::Matrix(3, 3), |d, out| {
            write_matrix(&d.pose.rotation.to_rotation_matrix().into_inner(), out)
        }),
        of("linear_velocity", Shape::List(3), |d, out| out.copy_from_slice(d.twist.linear.as_slice())),
        of("angular_velocity", Shape::List(3), |d, out| out.copy_from_slice(d.twist.angular.as_slice())),
        of("jacobian", Shape::Matrix(6, model.nv()), |d, out| write_transposed(6, &d.jacobian, out)),
    ]
}

/// Writes a matrix row by row.
fn write_matrix(matrix: &Matrix3<f64>, out: &mut [f64]) {
    out.copy_from_slice(matrix.transpose().as_slice());
}

/// Writes a column-major matrix with this number of rows row by row.
fn write_transposed(rows: usize, columns: &[f64], out: &mut [f64]) {
    let n = columns.len() / rows;
    columns.iter().enumerate().for_each(|(i, x)| out[i % rows * n + i / rows] = *x);
}

/// Writes the number of rows of length `width`, then the rows; rows that do not fit are dropped.
fn write_counted(width: usize, rows: impl Iterator<Item = impl IntoIterator<Item = f64>>, out: &mut [f64]) {
    let (count, cells) = out.split_at_mut(1);
    count[0] = 0.0;
    for (cells, row) in cells.chunks_exact_mut(width).zip(rows) {
        cells.iter_mut().zip(row).for_each(|(cell, x)| *cell = x);
        count[0] += 1.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn matrices_are_transposed_and_rows_counted() {
        let mut out = [0.0; 6];
        write_transposed(2, &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0], &mut out);
        assert_eq!(out, [1.0, 3.0, 5.0, 2.0, 4.0, 6.0]);
        let mut out = [9.0; 5];
        write_counted(2, [[1.0, 2.0]].into_iter(), &mut out);
        assert_eq!(out, [1.0, 1.0, 2.0, 9.0, 9.0]);
        write_counted(2, [[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]].into_iter(), &mut out);
        assert_eq!(out, [2.0, 1.0, 2.0, 3.0, 4.0], "no more than fit");
    }
}
