//! Serves pages of runs to browsers on this machine only.
//!
//! The server listens on the loopback address and answers a request only if its `Host` names that
//! address, against pages of other hosts that resolve their name to it (DNS rebinding). Targets are
//! numbers of runs, so no request names a file.

use crate::view::drawn_run::DrawnRun;
use crate::view::http::{self, Request, Response};
use crate::view::packed_run::pack;
use crate::view::run_list_page;
use crate::view::viewable_runs::ViewableRuns;
use crate::view::viewer_page::served_page;
use std::io;
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Duration;

/// Time-out of reading and writing.
const TIMEOUT: Duration = Duration::from_secs(10);
/// Largest number of concurrent connections; browsers open six.
const MAX_CONNECTIONS: usize = 16;

/// The server of the viewer.
pub struct ViewServer {
    listener: TcpListener,
    address: SocketAddr,
    pages: Arc<Pages>,
    stopped: Arc<AtomicBool>,
}

/// A handle that stops the server from another thread.
#[derive(Clone)]
pub struct ServerStopper {
    address: SocketAddr,
    stopped: Arc<AtomicBool>,
}

struct Pages {
    runs: ViewableRuns,
    rate: Option<f64>,
    hosts: [String; 2],
}

impl ViewServer {
    /// Binds a port of the loopback address; 0 selects a free one. With `rate`, at most so many
    /// ticks per second are shown.
    ///
    /// # Errors
    /// The port is in use or not permitted.
    pub fn new(runs: ViewableRuns, rate: Option<f64>, port: u16) -> io::Result<Self> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))?;
        let address = listener.local_addr()?;
        let hosts = ["127.0.0.1", "localhost"].map(|name| format!("{name}:{}", address.port()));
        Ok(Self { listener, address, pages: Arc::new(Pages { runs, rate, hosts }), stopped: Arc::default() })
    }

    /// Its address.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// A handle that stops it.
    pub fn stopper(&self) -> ServerStopper {
        ServerStopper { address: self.address, stopped: self.stopped.clone() }
    }

    /// Answers requests until it is stopped.
    pub fn run(self) {
        let busy = Arc::new(AtomicUsize::new(0));
        for stream in self.listener.incoming() {
            if self.stopped.load(Ordering::SeqCst) {
                break;
            }
            // The browser repeats the request of a connection that broke or is refused.
            let Ok(stream) = stream else { continue };
            if busy.fetch_add(1, Ordering::SeqCst) >= MAX_CONNECTIONS {
                busy.fetch_sub(1, Ordering::SeqCst);
                continue;
            }
            let (pages, busy) = (self.pages.clone(), busy.clone());
            std::thread::spawn(move || {
                // A closed connection needs no further answer.
                let _ = answer(&pages, &stream);
                busy.fetch_sub(1, Ordering::SeqCst);
            });
        }
    }
}

impl ServerStopper {
    /// Stops the server without waiting for answers in progress.
    pub fn stop(&self) {
        self.stopped.store(true, Ordering::SeqCst);
        // Wakes the server, which waits for a connection.
        let _ = TcpStream::connect(self.address);
    }
}

fn answer(pages: &Pages, stream: &TcpStream) -> io::Result<()> {
    stream.set_read_timeout(Some(TIMEOUT))?;
    stream.set_write_timeout(Some(TIMEOUT))?;
    match http::read(stream) {
        Ok(request) => pages.answer(&request).write(request.head_only, stream),
        Err(Some(refusal)) => refusal.write(false, stream),
        Err(None) => Ok(()),
    }
}

impl Pages {
    fn answer(&self, request: &Request) -> Response {
        if !request.host.as_ref().is_some_and(|host| self.hosts.iter().any(|h| h.eq_ignore_ascii_case(host))) {
            return Response::refusal(403, format!("this server answers requests to {} only", self.hosts[0]));
        }
        let path = request.target.split(['?', '#']).next().unwrap_or_default();
        let all = self.runs.runs();
        if path == "/" {
            return match all {
                [_] => Response::redirect("/run/0/"),
                _ => Response::page(run_list_page::page(&self.runs)),
            };
        }
        let Some((number, rest)) = path.strip_prefix("/run/").and_then(|below| below.split_once('/')) else {
            return Response::refusal(404, "there is no such page");
        };
        let digits = !number.is_empty() && number.bytes().all(|b| b.is_ascii_digit());
        let run = number.parse().ok().filter(|_| digits).and_then(|n: usize| all.get(n));
        match (run, rest) {
            (Some(run), "") => Response::page(served_page(&run.title(), all.len() > 1)),
            (Some(run), "data") => match DrawnRun::read(&run.log) {
                Ok(run) => Response::bytes(pack(&run, self.rate).0),
                Err(error) => Response::refusal(500, error.to_string()),
            },
            _ => Response::refusal(404, "there is no such page"),
        }
    }
}
