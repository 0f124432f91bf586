//! Serves pages of runs to browsers on this machine only.
//!
//! The server listens on the loopback address and answers a request only if [`LocalAccess`] permits
//! it, against pages of other sites. Targets are numbers of runs, so no request names a file.
//! [`Connections`] bounds the time and number of connections.

use crate::view::connections::{Connection, ConnectionLimits, Connections};
use crate::view::drawn_run::DrawnRun;
use crate::view::http::{self, Response};
use crate::view::packed_run::pack;
use crate::view::run_list_page;
use crate::view::viewable_runs::{ViewableRun, ViewableRuns};
use crate::view::viewer_page::served_page;
use crate::web::{LocalAccess, RequestHead};
use std::io;
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Wait after the system refused a connection or a thread, as when files run out.
const BUSY: Duration = Duration::from_millis(20);

/// The server of the viewer.
pub struct ViewServer {
    listener: TcpListener,
    address: SocketAddr,
    pages: Arc<Pages>,
    limits: ConnectionLimits,
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
    access: LocalAccess,
    address: SocketAddr,
}

/// Content of a response.
enum Page<'a> {
    Ready(Response),
    /// The data of a run, which take long to read.
    Data(&'a ViewableRun),
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
        let access = LocalAccess { port: Some(address.port()), ..LocalAccess::default() };
        let pages = Arc::new(Pages { runs, rate, access, address });
        Ok(Self { listener, address, pages, limits: ConnectionLimits::default(), stopped: Arc::default() })
    }

    /// Sets the limits of its connections.
    pub fn with_limits(self, limits: ConnectionLimits) -> Self {
        Self { limits, ..self }
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
        let connections = Connections::new(self.limits);
        for stream in self.listener.incoming() {
            if self.stopped.load(Ordering::SeqCst) {
                break;
            }
            // The browser repeats the request of a connection that broke or is refused.
            let Ok(stream) = stream else {
                std::thread::sleep(BUSY);
                continue;
            };
            let (pages, mut connection) = (self.pages.clone(), connections.add(stream));
            let answering = std::thread::Builder::new().spawn(move || {
                // A closed connection needs no further answer.
                let _ = pages.serve(&mut connection);
            });
            if answering.is_err() {
                std::thread::sleep(BUSY);
            }
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

impl Pages {
    fn serve(&self, connection: &mut Connection) -> io::Result<()> {
        let request = match http::read(&mut *connection) {
            Ok(request) => request,
            Err(refusal) => {
                connection.begin_response();
                return refusal.map_or(Ok(()), |refusal| refusal.write(false, connection));
            }
        };
        let head_only = request.method == "HEAD";
        match self.answer(&request) {
            Page::Ready(response) => {
                connection.begin_response();
                response.write(head_only, connection)
            }
            Page::Data(run) => {
                if !connection.begin_transfer() {
                    return Ok(());
                }
                let response = self.data(run);
                connection.begin_sending();
                response.write(head_only, connection)
            }
        }
    }

    /// The data of a run.
    fn data(&self, run: &ViewableRun) -> Response {
        match DrawnRun::read(&run.log) {
            Ok(run) => Response::bytes(pack(&run, self.rate).0),
            Err(error) => Response::refusal(500, error.to_string()),
        }
    }

    fn answer(&self, request: &RequestHead) -> Page<'_> {
        if self.access.check(request).is_err() {
            return Page::Ready(Response::refusal(
                403,
                format!("this server answers requests to {} and from its own pages only", self.address),
            ));
        }
        let path = request.target.split(['?', '#']).next().unwrap_or_default();
        let all = self.runs.runs();
        if path == "/" {
            return Page::Ready(match all {
                [_] => Response::redirect("/run/0/"),
                _ => Response::page(run_list_page::page(&self.runs)),
            });
        }
        let Some((number, rest)) = path.strip_prefix("/run/").and_then(|below| below.split_once('/')) else {
            return Page::Ready(Response::refusal(404, "there is no such page"));
        };
        let digits = !number.is_empty() && number.bytes().all(|b| b.is_ascii_digit());
        let run = number.parse().ok().filter(|_| digits).and_then(|n: usize| all.get(n));
        match (run, rest) {
            (Some(run), "") => Page::Ready(Response::page(served_page(&run.title(), all.len() > 1))),
            (Some(run), "data") => Page::Data(run),
            _ => Page::Ready(Response::refusal(404, "there is no such page")),
        }
    }
}

impl ViewServer {
    /// The response to the bytes of one connection, empty for a closed one, without a socket.
    #[doc(hidden)]
    pub fn answer_bytes(&self, bytes: &[u8]) -> Vec<u8> {
        let mut response = Vec::new();
        // Writing to memory cannot fail.
        let _ = match http::read(bytes) {
            Ok(request) => {
                let answer = match self.pages.answer(&request) {
                    Page::Ready(answer) => answer,
                    Page::Data(run) => self.pages.data(run),
                };
                answer.write(request.method == "HEAD", &mut response)
            }
            Err(Some(refusal)) => refusal.write(false, &mut response),
            Err(None) => Ok(()),
        };
        response
    }
}
