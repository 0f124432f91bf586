//! Commands of the coming ticks, where they are known: paths of the servos follow them, and the ticks
//! are left out.

use super::RunState;
use crate::sim::actuation::kinematic_paths::{INSTANTS, Span};
use crate::task::Command;
use std::array;

/// Longest span, s.
const LONGEST: f64 = 1.0;

/// Scratch for the commands of a span: at its instants, and one tick before its end.
pub struct CommandsAhead([Command; 7]);

impl CommandsAhead {
    /// For the joints of a command.
    pub fn new(command: &Command) -> Self {
        CommandsAhead(array::from_fn(|_| command.clone()))
    }
}

impl RunState {
    /// Plans the paths of as many ticks as smooth commands are known for, or of one tick with a kink, and leaves out
    /// the ticks between. Returns false, without effect, if no command is known.
    pub(super) fn plan_ahead(&mut self) -> bool {
        let Some(ahead) = &mut self.ahead else { return false };
        let (now, plant, tasks) = (self.plant.state.time, &mut self.plant, &mut self.tasks);
        let foresight = tasks.foresight(now);
        let (known, smooth) = (tasks.ticks_until(foresight.until), tasks.ticks_until(foresight.smooth_until));
        if known == 0 {
            return false;
        }
        let mut ticks = smooth.min((LONGEST / tasks.period()) as u64).max(1);
        loop {
            let span = Span { end: tasks.time_after(ticks), ticks, is_smooth: smooth > 0 };
            let at = |s: f64| if s == 1.0 { span.end } else { now + s * (span.end - now) };
            let times = INSTANTS.map(at).into_iter().chain([tasks.time_after(ticks - 1)]);
            for (time, command) in times.zip(&mut ahead.0) {
                command.copy_from(&plant.command);
                tasks.command_at(time, command);
            }
            if plant.plan_ahead(&span, &ahead.0) {
                tasks.skip_ticks(ticks - 1);
                return true;
            }
            ticks = (ticks / 2).max(1);
        }
    }
}
