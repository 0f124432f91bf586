//! Samples at given instants, for comparing runs whose steps end at different times.
//!
//! An adaptive step samples its dense output. Within a fixed step from t0 to t1 = t0 + h the
//! configuration follows the cubic that meets position and velocity at both ends,
//!
//! ```text
//! x(t0 + s h) = x0 + (3 s^2 - 2 s^3) (x1 - x0) + s (1 - s)^2 h v0 - s^2 (1 - s) h v1
//! ```
//!
//! (the orientation by its rotation vector from t0). To the errors at the two ends the
//! interpolant adds one of order h^4, far below those of a first-order step. Force and contact states of a fixed step
//! hold from t0 until before t1. At an instant where a force jumps, the sample of every method
//! contains the values after the jump. The end of the run belongs to its last step.

use crate::dynamics::State;
use crate::sim::plant::Plant;
use crate::sim::report::{Observer, Sample};
use crate::sim::run_error::RunError;
use nalgebra::{UnitQuaternion, Vector3};

/// Fraction of the time between two samples. An instant nearer than that to the end of the run is
/// the end.
const SLIVER: f64 = 1e-6;

/// Samples a run at a constant rate.
pub struct Sampler {
    rate: f64,
    /// End of the run, s.
    end: f64,
    sample: Sample,
    /// The states of robot and objects at the start of a fixed step.
    step_start: State,
    object_starts: Vec<State>,
    /// Configuration of an object.
    object: Sample,
    ended: bool,
}

impl Sampler {
    /// For a run from its present state to `end`.
    pub fn new(rate: f64, end: f64, plant: &Plant) -> Self {
        let state = &plant.state;
        let sample = Sample { joints: vec![0.0; state.joints.len()], ..Sample::default() };
        let object_starts = plant.objects.list.iter().map(|object| object.state.clone()).collect();
        let step_start = state.clone();
        Sampler { rate, end, sample, step_start, object_starts, object: Sample::default(), ended: false }
    }

    /// Time of the next sample before the end, s.
    pub fn next(&self) -> Option<f64> {
        let next = self.sample.index as f64 / self.rate;
        (next < self.end - SLIVER / self.rate).then_some(next)
    }

    /// Samples the plant's present state; needs an evaluation at it.
    pub fn sample_state(&mut self, plant: &Plant, observer: &mut dyn Observer) -> Result<(), RunError> {
        let (state, sample) = (&plant.state, &mut self.sample);
        (sample.time, sample.position, sample.rotation) = (state.time, state.position, state.rotation);
        sample.joints.copy_from_slice(&state.joints);
        sample.objects.clear();
        sample.object_joints.clear();
        for object in &plant.objects.list {
            sample.objects.push(object.state.position);
            sample.object_joints.extend_from_slice(&object.state.joints);
        }
        self.emit(plant, observer)
    }

    /// Stores the states at the start of a fixed step.
    pub fn begin_step(&mut self, plant: &Plant) {
        self.step_start.copy_from(&plant.state);
        self.object_starts
            .iter_mut()
            .zip(&plant.objects.list)
            .for_each(|(start, object)| start.copy_from(&object.state));
    }

    /// Samples the fixed step that has just ended, from the plant's forces and states at its end.
    pub fn sample_step(&mut self, plant: &Plant, observer: &mut dyn Observer) -> Result<(), RunError> {
        let end = plant.state.time;
        // Steps of 1e-3 s add up to an instant up to rounding.
        while let Some(t) = self.next().filter(|t| *t < end - SLIVER * (end - self.step_start.time)) {
            self.interpolate(plant, t);
            self.emit(plant, observer)?;
        }
        if end >= self.end && !self.ended {
            self.ended = true;
            self.interpolate(plant, end);
            self.emit(plant, observer)?;
        }
        Ok(())
    }

    /// Configurations at time `t` of the step that has just ended.
    fn interpolate(&mut self, plant: &Plant, t: f64) {
        let (sample, part) = (&mut self.sample, &mut self.object);
        interpolate(&self.step_start, &plant.state, t, sample);
        sample.objects.clear();
        sample.object_joints.clear();
        for (start, object) in self.object_starts.iter().zip(&plant.objects.list) {
            part.joints.resize(object.state.joints.len(), 0.0);
            interpolate(start, &object.state, t, part);
            sample.objects.push(part.position);
            sample.object_joints.extend_from_slice(&part.joints);
        }
    }

    /// Samples the end of the run, unless its last step has done so.
    pub fn sample_end(&mut self, plant: &Plant, observer: &mut dyn Observer) -> Result<(), RunError> {
        if std::mem::replace(&mut self.ended, true) { Ok(()) } else { self.sample_state(plant, observer) }
    }

    /// Adds the forces and states of the plant's soles and emits the sample.
    fn emit(&mut self, plant: &Plant, observer: &mut dyn Observer) -> Result<(), RunError> {
        let (floor, sample) = (&plant.floor.rotation, &mut self.sample);
        // Other links and pairs of bodies, whose number varies, come after the soles.
        let soles = plant.model.soles.len();
        let wrenches = plant.solution.wrench.chunks_exact(6).take(soles);
        sample.forces.clear();
        sample.forces.extend(wrenches.map(|w| floor * Vector3::new(w[0], w[1], w[2])));
        sample.states.clear();
        sample.states.extend((0..soles).map(|s| plant.states[s]));
        let emitted = observer.sample(sample).map_err(RunError::internal);
        sample.index += 1;
        emitted
    }
}

/// The configuration at time `t` of the step from `a` to `b`.
fn interpolate(a: &State, b: &State, t: f64, out: &mut Sample) {
    let h = b.time - a.time;
    let s = ((t - a.time) / h).clamp(0.0, 1.0);
    let nb = a.v.len() - a.joints.len();
    let (end, start, stop) = (s * s * (3.0 - 2.0 * s), s * (1.0 - s) * (1.0 - s) * h, -s * s * (1.0 - s) * h);
    let cubic = |x0: f64, x1: f64, v0: f64, v1: f64| {
        // At the ends equal to the state to the last bit.
        match s {
            0.0 => x0,
            1.0 => x1,
            _ => x0 + (x1 - x0) * end + v0 * start + v1 * stop,
        }
    };
    out.time = t;
    (out.position, out.rotation) = (a.position, a.rotation);
    if nb == 6 {
        out.position = Vector3::from_fn(|i, _| cubic(a.position[i], b.position[i], a.v[i], b.v[i]));
        let turn = (b.rotation * a.rotation.inverse()).scaled_axis();
        let part = Vector3::from_fn(|i, _| cubic(0.0, turn[i], a.v[3 + i], b.v[3 + i]));
        out.rotation = if s == 1.0 { b.rotation } else { UnitQuaternion::from_scaled_axis(part) * a.rotation };
    }
    for (j, q) in out.joints.iter_mut().enumerate() {
        *q = cubic(a.joints[j], b.joints[j], a.v[nb + j], b.v[nb + j]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(time: f64, x: f64, v: f64, turned: f64, spin: f64) -> State {
        let axis = Vector3::new(0.6, 0.0, 0.8);
        let omega = axis * spin;
        State {
            time,
            position: Vector3::new(x, 0.0, 0.0),
            rotation: UnitQuaternion::from_scaled_axis(axis * turned),
            joints: vec![2.0 * x],
            v: vec![v, 0.0, 0.0, omega.x, omega.y, omega.z, 2.0 * v],
            actuators: vec![],
        }
    }

    #[test]
    fn cubic_motion_is_sampled_exactly() {
        // x = t^3 - t, turned by t^2 - 0.3 t^3 about one axis.
        let at = |t: f64| state(t, t * t * t - t, 3.0 * t * t - 1.0, t * t - 0.3 * t * t * t, 2.0 * t - 0.9 * t * t);
        let (a, b) = (at(0.2), at(0.9));
        let mut out = Sample { joints: vec![0.0], ..Sample::default() };
        for t in [0.2, 0.35, 0.61, 0.9] {
            interpolate(&a, &b, t, &mut out);
            let exact = at(t);
            // Rounding alone.
            assert!((out.position - exact.position).norm() < 1e-15, "{t}");
            assert!((out.joints[0] - exact.joints[0]).abs() < 1e-15, "{t}");
            assert!(out.rotation.angle_to(&exact.rotation) < 1e-7, "{t}");
            let apart = (out.rotation.coords - exact.rotation.coords).norm();
            assert!(apart < 1e-15, "{t}: {apart:e}");
        }
        interpolate(&a, &b, 0.2, &mut out);
        assert_eq!((out.position, out.rotation), (a.position, a.rotation), "the start to the last bit");
        interpolate(&a, &b, 0.9, &mut out);
        assert_eq!((out.position, out.rotation, &out.joints), (b.position, b.rotation, &b.joints));
    }
}
