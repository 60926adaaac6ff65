//! The HTTP server.

use crate::Error;
use crate::answer::answer;
use crate::engine::Engine;
use crate::guard::Guard;
use axum::body::Body;
use hyper_util::rt::{TokioIo, TokioTimer};
use std::collections::VecDeque;
use std::convert::Infallible;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, UdpSocket};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use tokio::net::{TcpListener, TcpStream};
use tokio::runtime::Runtime;
use tokio::sync::Semaphore;
use tokio::task::AbortHandle;

/// The most pages at once.
pub const MAX_PAGES: usize = 32;

/// The most requests at once, without those of pages that are open.
const MAX_REQUESTS: usize = 128;

/// The longest time of a request: an upload, and the time to show it.
const LONGEST: Duration = Duration::from_secs(1800);

/// Where a server listens.
#[derive(Clone, Debug)]
pub struct Options {
    /// The address. `None` is the loopback address, without a token.
    pub host: Option<IpAddr>,
    /// The port; 0 is a free one.
    pub port: u16,
    /// How long the server waits for a header, for the next 64 kB of a file, and for a sign of life of a page.
    pub patience: Duration,
}

impl Default for Options {
    fn default() -> Self {
        Options { host: None, port: 0, patience: Duration::from_secs(10) }
    }
}

/// What all requests share.
pub(crate) struct Site {
    pub engine: Engine,
    pub guard: Guard,
    pub patience: Duration,
    pub pages: Semaphore,
    /// One file at a time is in memory.
    pub uploads: Semaphore,
    /// One file at a time is made.
    pub saves: Arc<Semaphore>,
}

/// An address that is taken, before a scene is shown there.
#[derive(Debug)]
pub struct Listener {
    listener: std::net::TcpListener,
    address: SocketAddr,
    options: Options,
}

impl Listener {
    /// Starts to listen. Requests wait until [`Listener::serve`].
    ///
    /// # Errors
    /// [`Error::Listen`] if the address cannot be used.
    pub fn bind(options: &Options) -> Result<Self, Error> {
        let host = options.host.unwrap_or(Ipv4Addr::LOCALHOST.into());
        let wanted = SocketAddr::new(host, options.port);
        let failed = |source| Error::Listen { address: wanted.to_string(), source };
        if host.is_multicast() || host == IpAddr::V4(Ipv4Addr::BROADCAST) {
            let what = "it is no address of one machine: 0.0.0.0 and :: are all addresses of this machine";
            return Err(failed(std::io::Error::new(std::io::ErrorKind::AddrNotAvailable, what)));
        }
        // The caller may be in a runtime of its own, so nothing here waits for a future.
        let listener = std::net::TcpListener::bind(wanted).map_err(failed)?;
        listener.set_nonblocking(true).map_err(failed)?;
        let address = listener.local_addr().map_err(failed)?;
        Ok(Listener { listener, address, options: options.clone() })
    }

    /// Answers requests.
    ///
    /// # Errors
    /// [`Error::System`] without threads or random numbers.
    pub fn serve(self, engine: Engine) -> Result<Server, Error> {
        let Listener { listener, address, options } = self;
        let guard = Guard::new(options.host.is_some())?;
        let token = guard.token.clone();
        let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build();
        let system = |source| Error::System { what: "threads", source };
        let runtime = runtime.map_err(system)?;
        let entered = runtime.enter();
        let listener = TcpListener::from_std(listener).map_err(system)?;
        drop(entered);
        let [pages, uploads, saves] = [MAX_PAGES, 1, 1].map(Semaphore::new);
        let patience = options.patience;
        let folder = engine.folder();
        let site = Arc::new(Site { engine, guard, patience, pages, uploads, saves: Arc::new(saves) });
        // It ends with the runtime.
        runtime.spawn(accept(listener, site));
        Ok(Server { runtime: Some(runtime), folder, address, token })
    }
}

/// A running server. It ends when it is dropped.
#[derive(Debug)]
pub struct Server {
    /// `None` only at the end.
    runtime: Option<Runtime>,
    /// The temporary files of the engine.
    folder: Arc<tempfile::TempDir>,
    address: SocketAddr,
    token: Option<String>,
}

impl Server {
    /// Listens, and answers requests.
    ///
    /// # Errors
    /// As [`Listener::bind`] and [`Listener::serve`].
    pub fn start(engine: Engine, options: &Options) -> Result<Self, Error> {
        Listener::bind(options)?.serve(engine)
    }

    /// Ends the server. Waits up to a second for work that has begun.
    pub fn stop(mut self) {
        if let Some(runtime) = self.runtime.take() {
            // Requests end, and with them the engine.
            runtime.shutdown_timeout(Duration::from_secs(1));
        }
    }

    /// The address of the page, with its token. For a server on all addresses, it is the one that other machines use.
    pub fn url(&self) -> String {
        let token = self.token.as_ref().map_or_else(String::new, |token| format!("{token}/"));
        format!("http://{}/{token}", reachable(self.address))
    }
}

/// An address that a browser can open.
fn reachable(address: SocketAddr) -> SocketAddr {
    if !address.ip().is_unspecified() {
        return address;
    }
    // The system tells the own address of a route to another machine. Nothing is sent: 192.0.2.1 is for documentation.
    let socket = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0));
    let route = socket.and_then(|socket| socket.connect(("192.0.2.1", 9)).and_then(|()| socket.local_addr()));
    let own = route.map_or(IpAddr::V4(Ipv4Addr::LOCALHOST), |route| route.ip());
    SocketAddr::new(own, address.port())
}

impl Drop for Server {
    fn drop(&mut self) {
        if let Some(runtime) = self.runtime.take() {
            runtime.shutdown_background();
        }
        // Work in the background may still use it.
        std::fs::remove_dir_all(self.folder.path()).ok();
    }
}

/// A connection, and whether its request has arrived.
struct Connection {
    task: AbortHandle,
    asked: Arc<AtomicBool>,
}

/// Accepts connections. When there are too many, the one that has waited longest for its request is closed, so that
/// half-sent requests do not keep others out.
async fn accept(listener: TcpListener, site: Arc<Site>) {
    let places = Arc::new(Semaphore::new(MAX_REQUESTS));
    let mut silent: VecDeque<Connection> = VecDeque::new();
    loop {
        let Ok((stream, _)) = listener.accept().await else {
            // Too many open files: some may be closed soon.
            tokio::time::sleep(Duration::from_millis(100)).await;
            continue;
        };
        let is_silent = |c: &Connection| !c.task.is_finished() && !c.asked.load(Ordering::Relaxed);
        silent.retain(is_silent);
        let place = match Arc::clone(&places).try_acquire_owned() {
            Ok(place) => place,
            Err(_) => {
                silent.pop_front().inspect(|oldest| oldest.task.abort());
                let Ok(place) = Arc::clone(&places).acquire_owned().await else { return };
                place
            }
        };
        let asked = Arc::new(AtomicBool::new(false));
        let connection = serve(stream, Arc::clone(&site), Arc::clone(&asked));
        let task = tokio::spawn(async move {
            connection.await;
            drop(place);
        });
        silent.push_back(Connection { task: task.abort_handle(), asked });
    }
}

/// Answers one request. If the peer closes the connection, the work for it ends.
async fn serve(stream: TcpStream, site: Arc<Site>, asked: Arc<AtomicBool>) {
    // Pictures are small and should not wait for more.
    stream.set_nodelay(true).ok();
    let patience = site.patience;
    let service = hyper::service::service_fn(move |request: hyper::Request<hyper::body::Incoming>| {
        asked.store(true, Ordering::Relaxed);
        let site = Arc::clone(&site);
        async move { Ok::<_, Infallible>(answer(site, request.map(Body::new)).await) }
    });
    let mut http = hyper::server::conn::http1::Builder::new();
    http.timer(TokioTimer::new()).header_read_timeout(patience);
    let connection = http.serve_connection(TokioIo::new(stream), service).with_upgrades();
    // Peers that break the protocol or are too slow get no answer.
    let _ = tokio::time::timeout(LONGEST, connection).await;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_server_on_all_addresses_names_one_of_them() {
        for host in ["0.0.0.0:80", "[::]:80"] {
            let own = reachable(host.parse().unwrap());
            assert!(own.port() == 80 && !own.ip().is_unspecified(), "{own}");
        }
        let one: SocketAddr = "127.0.0.1:7878".parse().unwrap();
        assert_eq!(reachable(one), one);
    }
}
