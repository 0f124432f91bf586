//! A server for the browser of this machine, and for no other.
//!
//! It listens on the loopback address alone and answers a request only if it names that address as its host, so that a
//! page of elsewhere whose name is made to lead here (DNS rebinding) gets nothing. Targets are numbers of runs, not paths:
//! nothing that is asked leads to a file.

use super::http::{self, Response};
use super::list;
use super::pack::pack;
use super::page::served_page;
use super::replay::Replay;
use super::runs::Runs;
use std::io;
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Duration;

/// Time that a connection may keep silent.
const PATIENCE: Duration = Duration::from_secs(10);
/// Connections answered side by side; browsers open six.
const MOST: usize = 16;

/// Shows runs.
pub struct Server {
    listener: TcpListener,
    address: SocketAddr,
    shown: Arc<Shown>,
    stopped: Arc<AtomicBool>,
}

/// Ends a server from elsewhere.
#[derive(Clone)]
pub struct Stopper {
    address: SocketAddr,
    stopped: Arc<AtomicBool>,
}

struct Shown {
    runs: Runs,
    rate: Option<f64>,
    hosts: [String; 2],
}

impl Server {
    /// Takes a port of the loopback address, any free one for 0. At most `rate` ticks per second are shown where it is given.
    ///
    /// # Errors
    /// The port is taken or not for us.
    pub fn new(runs: Runs, rate: Option<f64>, port: u16) -> io::Result<Self> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))?;
        let address = listener.local_addr()?;
        let hosts = ["127.0.0.1", "localhost"].map(|name| format!("{name}:{}", address.port()));
        Ok(Self { listener, address, shown: Arc::new(Shown { runs, rate, hosts }), stopped: Arc::default() })
    }

    /// Where it listens.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// A handle to end it with.
    pub fn stopper(&self) -> Stopper {
        Stopper { address: self.address, stopped: self.stopped.clone() }
    }

    /// Answers until it is stopped.
    pub fn run(self) {
        let busy = Arc::new(AtomicUsize::new(0));
        for stream in self.listener.incoming() {
            if self.stopped.load(Ordering::SeqCst) {
                break;
            }
            // A connection that broke before it was taken, or one too many: the browser asks again.
            let Ok(stream) = stream else { continue };
            if busy.fetch_add(1, Ordering::SeqCst) >= MOST {
                busy.fetch_sub(1, Ordering::SeqCst);
                continue;
            }
            let (shown, busy) = (self.shown.clone(), busy.clone());
            std::thread::spawn(move || {
                // Who left in the middle of an answer wants no other.
                let _ = converse(&shown, &stream);
                busy.fetch_sub(1, Ordering::SeqCst);
            });
        }
    }
}

impl Stopper {
    /// Ends it; answers under way are not waited for.
    pub fn stop(&self) {
        self.stopped.store(true, Ordering::SeqCst);
        // It waits for a connection: here is one.
        let _ = TcpStream::connect(self.address);
    }
}

fn converse(shown: &Shown, stream: &TcpStream) -> io::Result<()> {
    stream.set_read_timeout(Some(PATIENCE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    match http::read(stream) {
        Ok(request) => shown.answer(&request).write(request.head_only, stream),
        Err(Some(refusal)) => refusal.write(false, stream),
        Err(None) => Ok(()),
    }
}

impl Shown {
    fn answer(&self, request: &http::Request) -> Response {
        if !request.host.as_ref().is_some_and(|host| self.hosts.iter().any(|h| h.eq_ignore_ascii_case(host))) {
            return Response::refusal(403, format!("this is {} and nothing else", self.hosts[0]));
        }
        let path = request.target.split(['?', '#']).next().unwrap_or_default();
        let all = self.runs.shown();
        if path == "/" {
            return match all {
                [_] => Response::elsewhere("/run/0/"),
                _ => Response::page(list::page(&self.runs)),
            };
        }
        let Some((number, rest)) = path.strip_prefix("/run/").and_then(|below| below.split_once('/')) else {
            return Response::refusal(404, "there is no such page");
        };
        let digits = !number.is_empty() && number.bytes().all(|b| b.is_ascii_digit());
        let run = number.parse().ok().filter(|_| digits).and_then(|n: usize| all.get(n));
        match (run, rest) {
            (Some(run), "") => Response::page(served_page(&run.title(), all.len() > 1)),
            (Some(run), "data") => match Replay::read(&run.log) {
                Ok(replay) => Response::bytes(pack(&replay, self.rate).0),
                Err(error) => Response::refusal(500, error.to_string()),
            },
            _ => Response::refusal(404, "there is no such page"),
        }
    }
}
