//! Stiffness of a compliant floor, as part of the stiff part of a step.
//!
//! The force f on vertex i of polygon s depends on its height h and its velocity u. With the Jacobian J of the vertex,
//! n the normal, x the configuration and displacements `E^-1 dx` along the velocities v (`x' = E v`):
//!
//! ```text
//! df = f_h n^T J E^-1 dx + f_u J dv        w_s = sum_i G_i^T f_i
//! A  = sum_s sum_r  c_sr [sum_i G_i^T (f_h n^T J E^-1, f_u J)]_r + N
//! ```
//!
//! c_sr are the accelerations and powers per unit of component r of the wrench w_s, `M^-1 J_s^T e_r`, N is E. The
//! change of J along the solution is a derivative by time, `f_u J' v`. A polygon with one vertex in the floor has three
//! components, the force there.

use super::Plant;
use super::stiff_products::{Derivatives, Evaluation};
use crate::contact::methods::contact_method::VertexSlopes;
use crate::contact::model::solution::wrench_at;
use crate::dynamics::reduced;
use crate::integrate::StiffPart;
use nalgebra::Vector3;

/// A polygon with vertices in the floor; the vertex if there is one only.
type Loaded = (usize, Option<usize>);

/// The polygons of the stiff part.
#[derive(Clone, Debug, Default)]
pub(super) struct ContactStiffness {
    polygons: Vec<Loaded>,
    present: Vec<Loaded>,
    /// Polygon, vertex and slopes of the vertices in the floor.
    vertices: Vec<(usize, usize, VertexSlopes)>,
    /// Of the components of a wrench.
    wrench: [Derivatives; 6],
    /// Of the power lost to friction and to the dampers.
    powers: [Derivatives; 2],
    /// Jacobian of a vertex.
    jacobian: [Vec<f64>; 3],
}

impl ContactStiffness {
    /// Finds the vertices in the floor. Returns whether others have a stiff force.
    pub fn find(&mut self, plant: &Plant) -> bool {
        if plant.is_compliant() {
            self.reserve(plant);
        }
        self.vertices.clear();
        plant.method.slopes(&plant.problem, &mut |s, i, slopes| self.vertices.push((s, i, slopes)));
        self.present.clear();
        for (s, i, _) in &self.vertices {
            match self.present.last_mut() {
                Some((last, vertex)) if last == s => *vertex = None,
                _ => self.present.push((*s, Some(*i))),
            }
        }
        self.present != self.polygons
    }

    /// Adds products with new responses for the polygons found.
    pub fn renew(&mut self, plant: &mut Plant, before: &Evaluation, out: &mut StiffPart) {
        self.polygons.clone_from(&self.present);
        for &(s, vertex) in &self.polygons {
            for r in 0..components(vertex) {
                let Some((_, column)) = out.add() else { return };
                let mut unit = [0.0; 6];
                unit[r] = 1.0;
                if let Some(i) = vertex {
                    let force = Vector3::from_fn(|k, _| f64::from(k == r));
                    unit = wrench_at(&plant.problem.soles[s].vertices[i].r, &force);
                }
                plant.respond_to_wrench(s, &unit, before, column);
            }
        }
    }

    /// Makes room for all vertices of the floor.
    fn reserve(&mut self, plant: &Plant) {
        let vertices = plant.problem.soles.iter().map(|sole| sole.vertices.len()).sum();
        if self.vertices.capacity() < vertices {
            self.vertices.reserve(vertices - self.vertices.len());
            for list in [&mut self.polygons, &mut self.present] {
                list.reserve(plant.polygons.len());
            }
            let nv = plant.acceleration.len();
            self.wrench.iter_mut().chain(&mut self.powers).for_each(|list| list.clear(nv));
            self.jacobian.iter_mut().for_each(|row| row.resize(nv, 0.0));
        }
    }

    /// Most products, with all vertices in the floor.
    pub fn most_products(&self, plant: &Plant) -> usize {
        if plant.is_compliant() { 6 * plant.polygons.len() } else { 0 }
    }

    /// Number of products for the polygons found.
    pub fn products(&self) -> usize {
        self.present.iter().map(|(_, vertex)| components(*vertex)).sum()
    }

    /// Writes the rows of the products from `product` on, at the plant's last evaluation, and those of the powers.
    /// Returns the next product.
    pub fn write(&mut self, plant: &Plant, mut product: usize, out: &mut StiffPart) -> usize {
        let nv = plant.acceleration.len();
        self.powers.iter_mut().for_each(|power| power.clear(nv));
        let mut next = 0;
        for p in 0..self.polygons.len() {
            let (s, vertex) = self.polygons[p];
            self.wrench.iter_mut().for_each(|component| component.clear(nv));
            while let Some(&at) = self.vertices.get(next).filter(|(of, _, _)| *of == s) {
                self.add_vertex(plant, at, vertex.is_some());
                next += 1;
            }
            for component in &mut self.wrench[..components(vertex)] {
                plant.write_derivatives(component, product, out);
                product += 1;
            }
        }
        product
    }

    /// Adds the derivatives of the force on a vertex to those of the wrench, which is a force at the vertex if it is
    /// the only one, and of the powers.
    fn add_vertex(&mut self, plant: &Plant, (s, i, slopes): (usize, usize, VertexSlopes), is_only: bool) {
        for (d, row) in self.jacobian.iter_mut().enumerate() {
            plant.vertex_row(s, i, d, row);
        }
        let (at, solution) = (&plant.problem.soles[s].vertices[i], &plant.solution);
        let (u, t, n) = (at.velocity, solution.tangent[s][i], solution.normal[s][i]);
        let arm = if is_only { Vector3::zeros() } else { at.r };
        let mut drift = plant.problem.vertex_motion(&solution.motion, s, i);
        let [friction, dampers] = &mut self.powers;
        for (c, acceleration) in plant.acceleration.iter().enumerate() {
            let j = Vector3::new(self.jacobian[0][c], self.jacobian[1][c], self.jacobian[2][c]);
            if j == Vector3::zeros() {
                continue;
            }
            drift -= j * *acceleration;
            let (x, v) = (slopes.by_height * j.z, slopes.by_velocity * j);
            let wrenches = wrench_at(&arm, &x).into_iter().zip(wrench_at(&arm, &v));
            self.wrench.iter_mut().zip(wrenches).for_each(|(component, (x, v))| component.add(c, x, v));
            // Powers -t . u_t and -(n u_n + power of the springs).
            friction.add(c, -x.xy().dot(&u.xy()), -v.xy().dot(&u.xy()) - t.dot(&j.xy()));
            let [by_height, by_velocity] = slopes.power;
            dampers.add(c, -x.z * u.z - by_height * j.z, -v.z * u.z - (n + by_velocity) * j.z);
        }
        let by_time = wrench_at(&arm, &(slopes.by_velocity * drift));
        self.wrench.iter_mut().zip(by_time).for_each(|(component, rate)| component.by_time += rate);
    }

    /// Adds the products of the flows of energy, after [`write`](Self::write).
    pub fn add_powers(&mut self, plant: &Plant, out: &mut StiffPart) {
        if self.polygons.is_empty() {
            return;
        }
        let flows = plant.layout.controlled();
        for (flow, power) in [3, 4].into_iter().zip(&mut self.powers) {
            let product = out.rank();
            let Some((_, column)) = out.add() else { return };
            column[flows + flow] = 1.0;
            plant.write_derivatives(power, product, out);
        }
    }
}

/// Number of products of a polygon.
fn components(vertex: Option<usize>) -> usize {
    if vertex.is_some() { 3 } else { 6 }
}

impl Plant {
    /// Row `d` of the Jacobian of a vertex, contact axes, by all velocities.
    fn vertex_row(&self, s: usize, i: usize, d: usize, out: &mut Vec<f64>) {
        out.clear();
        out.resize(self.acceleration.len(), 0.0);
        let axes = &self.reduced.axes[s];
        let point = self.reduced.reference[s] + axes * self.problem.soles[s].vertices[i].r;
        let axis = axes.column(d).into();
        reduced::add_point_row(self.objects.mechanisms(&self.ws), &self.reduced, s, &point, &axis, out);
    }

    /// Change of accelerations and powers by a wrench on a polygon, from the evaluation `before`. Leaves the
    /// evaluation changed.
    fn respond_to_wrench(&mut self, s: usize, wrench: &[f64; 6], before: &Evaluation, out: &mut [f64]) {
        self.solution.wrench.copy_from_slice(&before.wrenches);
        self.solution.wrench[6 * s..6 * s + 6].iter_mut().zip(wrench).for_each(|(sum, x)| *sum += x);
        self.close();
        before.write_change(self, 1.0, out);
        self.kinematic_paths.joints().iter().for_each(|j| self.layout.hold(*j, out));
    }
}
