//! The fields that a script reads of the robot: their names, layout and source.
//!
//! A new part is a line in [`of_tasks`] and its name in [`PARTS`].

use crate::dynamics::{State, Workspace, body, jacobian};
use crate::robot::{LinkId, Model};
use crate::task::{Augmented, Command, Needs, Sensed};
use nalgebra::{Isometry3, Matrix3, Vector3};

/// The robot at one instant.
pub struct View<'a> {
    /// Simulated time, s.
    pub time: f64,
    /// The robot.
    pub model: &'a Model,
    /// Free fall in world axes, m/s^2.
    pub gravity: Vector3<f64>,
    /// Positions and velocities: for tasks as estimated.
    pub state: &'a State,
    /// Kinematics at that state; for tasks only if a requested part depends on it.
    pub kinematics: &'a Workspace,
    /// Additional data of tasks.
    pub task: Option<TaskView<'a>>,
}

/// Data that only tasks read.
pub struct TaskView<'a> {
    /// Sensor readings.
    pub sensed: &'a Sensed,
    /// Augmented data.
    pub data: &'a Augmented,
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
            Shape::Rows(most, columns) => 1 + most * columns,
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
pub fn of_all(model: &Model) -> Vec<Field> {
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
            rows(&view.state.rotation.to_rotation_matrix().into_inner(), out);
        }),
        vector(["base", "linear_velocity"], move |view| base(view, 0)),
        vector(["base", "angular_velocity"], move |view| base(view, 3)),
    ]
}

/// Pose and velocity of a link's URDF frame; `frame` is that frame in the carrying link's internal
/// one.
pub fn of_link(name: &str, link: LinkId, frame: Isometry3<f64>) -> Vec<Field> {
    let (local, turn) = (frame.translation.vector, frame.rotation.to_rotation_matrix().into_inner());
    let point = move |view: &View| view.kinematics.point(link, &local);
    vec![
        vector(["link", name, "position"], point),
        field(["link", name, "rotation"], Shape::Matrix(3, 3), move |view, out| {
            rows(&(view.kinematics.links[link.0].rotation * turn), out);
        }),
        vector(["link", name, "linear_velocity"], move |view| {
            jacobian::point_velocity(view.kinematics, link, &point(view))
        }),
        vector(["link", name, "angular_velocity"], move |view| view.kinematics.links[link.0].velocity.angular),
    ]
}

/// The centre of mass from the present kinematics.
pub fn of_mass() -> Vec<Field> {
    vec![
        vector(["com"], |view| body::center_of_mass(view.kinematics)),
        vector(["com_velocity"], |view| body::center_of_mass_velocity(view.kinematics)),
    ]
}

fn of_data<const N: usize>(path: [&str; N], shape: Shape, read: fn(&Augmented, &mut [f64])) -> Field {
    field(path, shape, move |view, out| {
        if let Some(task) = &view.task {
            read(task.data, out);
        }
    })
}

/// Fields of every task: sensors and joint commands.
pub fn of_sensors(model: &Model) -> Vec<Field> {
    let joints = Shape::List(model.nj());
    let sensed = |path: [&str; 2], read: fn(&Sensed) -> Vector3<f64>| {
        vector(path, move |view| view.task.as_ref().map_or_else(Vector3::zeros, |t| read(t.sensed)))
    };
    let desired = |name: &str, read: fn(&Command) -> &[f64]| {
        field(["desired", name], joints, move |view, out| {
            if let Some(task) = &view.task {
                out.copy_from_slice(read(task.command));
            }
        })
    };
    vec![
        field(["load"], joints, |view, out| {
            if let Some(task) = &view.task {
                out.copy_from_slice(&task.sensed.load);
            }
        }),
        sensed(["imu", "angular_velocity"], |s| s.angular_velocity),
        sensed(["imu", "specific_force"], |s| s.specific_force),
        desired("position", |c| &c.position),
        desired("velocity", |c| &c.velocity),
        desired("effort", |c| &c.effort),
        desired("kp", |c| &c.kp),
        desired("kd", |c| &c.kd),
    ]
}

/// Fields of the parts that a task has requested.
pub fn of_tasks(model: &Model, needs: Needs) -> Vec<Field> {
    let (nv, nj) = (model.nv(), model.nj());
    let vertices: usize = model.soles.iter().map(|s| s.vertices.len()).sum();
    let mut fields = Vec::new();
    let mut add = |part: Needs, more: Vec<Field>| {
        if needs.contains(part) {
            fields.extend(more);
        }
    };
    add(Needs::COM, of_mass());
    let jacobian = |name, read| of_data([name], Shape::Matrix(3, nv), read);
    add(Needs::COM_JACOBIAN, vec![jacobian("com_jacobian", |d, out| turned(3, &d.com_jacobian, out))]);
    add(
        Needs::COM_JACOBIAN_BASE,
        vec![of_data(["com_jacobian_base"], Shape::Matrix(3, nj), |d, out| turned(3, &d.com_jacobian_base, out))],
    );
    let mass = move |view: &View, out: &mut [f64]| {
        (0..nv * nv).for_each(|i| out[i] = view.kinematics.mass.get(i / nv, i % nv));
    };
    add(Needs::MASS, vec![field(["mass_matrix"], Shape::Matrix(nv, nv), mass)]);
    let bias = of_data(["bias"], Shape::List(nv), |d, out| out.copy_from_slice(&d.workspace.bias));
    add(Needs::BIAS, vec![bias]);
    let hold = of_data(["gravity_effort"], Shape::List(nv), |d, out| out.copy_from_slice(&d.gravity_effort));
    add(Needs::GRAVITY, vec![hold]);
    for s in 0..model.soles.len() {
        of_sole(model, s).into_iter().for_each(|(part, field)| add(part, vec![field]));
    }
    for e in 0..model.end_effectors.len() {
        add(Needs::END_EFFECTORS, of_end_effector(model, e));
    }
    let contacts = of_data(["contacts"], Shape::Rows(vertices, 6), |d, out| {
        let row = |c: &crate::task::augmented::ContactPoint| [c.position, c.force];
        counted(6, d.contacts.iter().map(|c| row(c).into_iter().flat_map(|v| [v.x, v.y, v.z])), out);
    });
    add(Needs::CONTACTS, vec![contacts]);
    let point = |p: &Option<Vector3<f64>>, out: &mut [f64]| counted(3, p.iter().map(|p| [p.x, p.y, p.z]), out);
    let place = |name, read: fn(&Augmented) -> &Option<Vector3<f64>>| {
        field([name], Shape::Optional(3), move |view: &View, out: &mut [f64]| {
            if let Some(task) = &view.task {
                point(read(task.data), out);
            }
        })
    };
    add(Needs::ZMP, vec![place("zmp", |d| &d.zmp)]);
    let polygon = of_data(["support_polygon"], Shape::Rows(vertices, 3), |d, out| {
        counted(3, d.support_polygon.iter().map(|p| [p.x, p.y, p.z]), out);
    });
    add(Needs::SUPPORT, vec![polygon]);
    let radius = of_data(["stable_radius"], Shape::Number, |d, out| out[0] = d.stable_radius);
    add(Needs::STABLE_POINT, vec![place("stable_point", |d| &d.stable_point), radius]);
    fields
}

/// Fills a field from the data of a task.
type ReadTask = dyn Fn(&TaskView, &mut [f64]) + Send;

/// Fields of sole `s`, by part.
fn of_sole(model: &Model, s: usize) -> Vec<(Needs, Field)> {
    let (nv, sole) = (model.nv(), &model.soles[s]);
    let (name, k) = (sole.name.as_str(), sole.vertices.len());
    let field = |key: &str, shape, read: Box<ReadTask>| {
        field(["sole", name, key], shape, move |view, out| {
            if let Some(task) = &view.task {
                read(task, out);
            }
        })
    };
    let points = |list: &[Vector3<f64>], out: &mut [f64]| {
        out.chunks_exact_mut(3).zip(list).for_each(|(row, p)| row.copy_from_slice(p.as_slice()));
    };
    let mut fields = vec![
        (Needs::LOADS, field("force", Shape::List(3), Box::new(move |t, out| points(&[t.sensed.soles[s].force], out)))),
        (
            Needs::LOADS,
            field("moment", Shape::List(3), Box::new(move |t, out| points(&[t.sensed.soles[s].moment], out))),
        ),
        (
            Needs::SOLES,
            field("position", Shape::List(3), Box::new(move |t, out| points(&[t.data.soles[s].position], out))),
        ),
        (
            Needs::SOLES,
            field("vertices", Shape::Matrix(k, 3), Box::new(move |t, out| points(&t.data.soles[s].vertices, out))),
        ),
        (
            Needs::CONTACTS,
            field(
                "vertex_forces",
                Shape::Matrix(k, 3),
                Box::new(move |t, out| points(&t.data.soles[s].vertex_forces, out)),
            ),
        ),
        (
            Needs::SOLE_JACOBIANS,
            field("jacobian", Shape::Matrix(6, nv), Box::new(move |t, out| turned(6, &t.data.soles[s].jacobian, out))),
        ),
    ];
    for i in 0..k {
        let key = format!("vertex_jacobian_{}", i + 1);
        let read = move |t: &TaskView, out: &mut [f64]| turned(3, &t.data.soles[s].vertex_jacobians[i], out);
        fields.push((Needs::VERTEX_JACOBIANS, field(&key, Shape::Matrix(3, nv), Box::new(read))));
    }
    fields
}

fn of_end_effector(model: &Model, e: usize) -> Vec<Field> {
    let name = model.end_effectors[e].name.as_str();
    let of = |key, shape, read: fn(&crate::task::augmented::EndEffectorData, &mut [f64])| {
        field(["end_effector", name, key], shape, move |view, out| {
            if let Some(task) = &view.task {
                read(&task.data.end_effectors[e], out);
            }
        })
    };
    vec![
        of("position", Shape::List(3), |d, out| out.copy_from_slice(d.pose.translation.vector.as_slice())),
        of("rotation", Shape::Matrix(3, 3), |d, out| rows(&d.pose.rotation.to_rotation_matrix().into_inner(), out)),
        of("linear_velocity", Shape::List(3), |d, out| out.copy_from_slice(d.twist.linear.as_slice())),
        of("angular_velocity", Shape::List(3), |d, out| out.copy_from_slice(d.twist.angular.as_slice())),
        of("jacobian", Shape::Matrix(6, model.nv()), |d, out| turned(6, &d.jacobian, out)),
    ]
}

/// A matrix row by row.
fn rows(matrix: &Matrix3<f64>, out: &mut [f64]) {
    out.copy_from_slice(matrix.transpose().as_slice());
}

/// A column-major matrix of so many rows, row by row.
fn turned(rows: usize, columns: &[f64], out: &mut [f64]) {
    let n = columns.len() / rows;
    columns.iter().enumerate().for_each(|(i, x)| out[i % rows * n + i / rows] = *x);
}

/// The number of rows of `width`, then the rows; rows that do not fit are dropped.
fn counted(width: usize, rows: impl Iterator<Item = impl IntoIterator<Item = f64>>, out: &mut [f64]) {
    let (count, places) = out.split_at_mut(1);
    count[0] = 0.0;
    for (place, row) in places.chunks_exact_mut(width).zip(rows) {
        place.iter_mut().zip(row).for_each(|(p, x)| *p = x);
        count[0] += 1.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn matrices_are_transposed_and_rows_counted() {
        let mut out = [0.0; 6];
        turned(2, &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0], &mut out);
        assert_eq!(out, [1.0, 3.0, 5.0, 2.0, 4.0, 6.0]);
        let mut out = [9.0; 5];
        counted(2, [[1.0, 2.0]].into_iter(), &mut out);
        assert_eq!(out, [1.0, 1.0, 2.0, 9.0, 9.0]);
        counted(2, [[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]].into_iter(), &mut out);
        assert_eq!(out, [2.0, 1.0, 2.0, 3.0, 4.0], "no more than fit");
    }
}
