//! Log displayed by queries: the present state, or an instant of a recording. The present is
//! written as a log too, so that columns are those of `runner export`.

use crate::console::console_error::ConsoleError;
use crate::console::session::{Session, simulation};
use crate::console::session_observer::SessionObserver;
use crate::dynamics::State;
use crate::export::{self, Selection, Values};
use crate::log::{LogWriter, Motion, TopicGroups, Trajectory};
use crate::robot::{Base, Model};
use crate::sim::{Observer, Snapshot};

impl Session {
    /// Passes the displayed log and the index of the displayed instant to `query`.
    pub(super) fn with_displayed_log<T>(
        &mut self,
        query: impl FnOnce(&Self, &Trajectory, usize) -> Result<T, ConsoleError>,
    ) -> Result<T, ConsoleError> {
        match (&self.cursor, &self.recording) {
            (Some(cursor), Some(recording)) => query(self, &recording.log, cursor.tick),
            _ => {
                let present = self.present_log()?;
                query(self, &present, 0)
            }
        }
    }

    /// A log of the present instant only.
    fn present_log(&mut self) -> Result<Trajectory, ConsoleError> {
        let path = self.folder.path().join("present.mcap");
        let mut log: LogWriter = self.log_writer(&path, TopicGroups { state: true, contact: true, scene: false })?;
        let snapshot = self.present_snapshot()?;
        log.snapshot(&snapshot).map_err(ConsoleError::usage)?;
        log.finish()?;
        Ok(Trajectory::read(&path)?)
    }

    /// Snapshot of the present. Contact states are selected when a run begins, and before that any
    /// value may still be edited; so before the first step a copy of the simulation is begun and
    /// inspected.
    pub(super) fn present_snapshot(&mut self) -> Result<Snapshot, ConsoleError> {
        if self.simulation.has_begun() {
            return Ok(self.simulation.snapshot());
        }
        let mut begun = simulation(&self.document, &self.run, (&self.robot, &self.objects))?;
        begun.begin(&mut SessionObserver::default()).map_err(|error| ConsoleError::Terminated { time: 0.0, error })?;
        Ok(begun.snapshot())
    }

    /// Names and values of columns at the displayed instant, by names and patterns; all columns
    /// without names.
    pub(super) fn displayed_columns(&mut self, names: &[String]) -> Result<Vec<(String, String)>, ConsoleError> {
        self.with_displayed_log(|_, log, tick| columns_at(log, tick, names))
    }

    /// Value of one column as a number.
    pub(super) fn displayed_value(&mut self, name: &str) -> Result<Option<f64>, ConsoleError> {
        let names = [name.to_owned()];
        self.with_displayed_log(|_, log, tick| {
            let at = Some(log.times[tick]);
            let table = export::series(log, &Selection { columns: names.to_vec(), rate: None, from: at, to: at })?;
            match table.columns().iter().find(|(found, _)| found == name).map(|(_, values)| values) {
                Some(Values::Real(values)) => Ok(values.first().copied().flatten()),
                Some(Values::Flag(values)) => Ok(values.first().map(|flag| f64::from(u8::from(*flag)))),
                Some(Values::Text(_)) => Err(ConsoleError::usage(format!("`{name}` is text, not a number"))),
                None => Err(ConsoleError::usage(format!("expected one column, found the pattern `{name}`"))),
            }
        })
    }
}

/// Names and values of columns at an instant of a log.
pub fn columns_at(log: &Trajectory, tick: usize, names: &[String]) -> Result<Vec<(String, String)>, ConsoleError> {
    let at = log.times.get(tick).copied();
    let table = export::series(log, &Selection { columns: names.to_vec(), rate: None, from: at, to: at })?;
    let value = |values: &Values| match values {
        Values::Real(values) => values.first().copied().flatten().map_or("none".to_owned(), digits),
        Values::Text(values) => values.first().cloned().unwrap_or_default(),
        Values::Flag(values) => values.first().map_or(String::new(), |flag| flag.to_string()),
    };
    Ok(table.columns().iter().map(|(name, values)| (name.clone(), value(values))).collect())
}

/// A number with all its digits, with an exponent if very small or large.
pub fn digits(x: f64) -> String {
    let plain = x == 0.0 || (1e-5..1e15).contains(&x.abs());
    if plain { x.to_string() } else { format!("{x:e}") }
}

/// Motion of a log; an error if the log has none.
pub fn motion(log: &Trajectory) -> Result<&Motion, ConsoleError> {
    log.motion.as_ref().ok_or_else(|| ConsoleError::usage("the recording has no motion: its topics lack \"state\""))
}

/// Robot state at an instant of a log, without actuator states.
pub fn state(model: &Model, log: &Trajectory, tick: usize) -> Result<State, ConsoleError> {
    let motion = motion(log)?;
    let named = motion.joints.iter().map(|joint| &joint.name);
    if !named.eq(model.joints.iter().map(|joint| &joint.name)) {
        return Err(ConsoleError::usage(format!("the recording is of another robot, `{}`", log.info.robot)));
    }
    let mut state = State::home(model);
    state.time = log.times[tick];
    (state.position, state.rotation) = (motion.base_position[tick], motion.base_orientation[tick]);
    let nb = model.nb();
    if model.base == Base::Floating {
        state.v[..3].copy_from_slice(motion.base_linear_velocity[tick].as_slice());
        state.v[3..6].copy_from_slice(motion.base_angular_velocity[tick].as_slice());
    }
    for (j, joint) in motion.joints.iter().enumerate() {
        (state.joints[j], state.v[nb + j]) = (joint.position[tick], joint.velocity[tick]);
    }
    Ok(state)
}
