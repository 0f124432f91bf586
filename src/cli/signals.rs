//! Handles Ctrl-C and, on Unix, SIGTERM, which schedulers and servers send before they kill. SIGHUP
//! keeps its default action, so that `nohup` works.

use std::sync::{Arc, OnceLock};

use crate::cli::Exit;
use crate::cli::terminal::complain;

/// Exit code of the first signal, once one arrived.
#[derive(Clone, Default)]
pub struct FirstSignal(Arc<OnceLock<Exit>>);

impl FirstSignal {
    /// Exit code of the first signal.
    pub fn exit(&self) -> Exit {
        self.0.get().copied().unwrap_or(Exit::Interrupted)
    }
}

/// Turns SIGXFSZ, which would end the program, into the error of the write that exceeds the limit on
/// file size (`ulimit -f`): it is that run's, or that file's.
pub fn handle_file_size_limit() {
    #[cfg(unix)]
    if let Err(error) = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::default()) {
        complain(&format!("warning: a file above the limit on file size will end the program: {error}"));
    }
}

/// Calls `act` on each signal. Warns of a signal that cannot be handled and so ends the program.
pub fn on_termination_signal(act: impl Fn(Exit) + Clone + Send + 'static) -> FirstSignal {
    let first_signal = FirstSignal::default();
    let handler = |exit: Exit| {
        let (first, act) = (first_signal.0.clone(), act.clone());
        move || {
            let exit = *first.get_or_init(|| exit);
            act(exit);
        }
    };
    if let Err(error) = ctrlc::set_handler(handler(Exit::Interrupted)) {
        complain(&format!("warning: Ctrl-C will end the program at once: {error}"));
    }
    #[cfg(unix)]
    if let Err(error) = terminated(handler(Exit::Terminated)) {
        complain(&format!("warning: SIGTERM will end the program at once: {error}"));
    }
    first_signal
}

/// Calls `act` at each SIGTERM, on a thread of its own.
#[cfg(unix)]
fn terminated(act: impl Fn() + Send + 'static) -> std::io::Result<()> {
    let mut signals = signal_hook::iterator::Signals::new([signal_hook::consts::SIGTERM])?;
    let listen = move || signals.forever().for_each(|_| act());
    std::thread::Builder::new().name("sigterm".into()).spawn(listen).map(|_| ())
}
