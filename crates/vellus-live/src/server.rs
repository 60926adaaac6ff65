//! The HTTP server.

use crate::engine::Engine;
use crate::guard::Guard;
use crate::save::Save;
use crate::{Error, page, socket};
use axum::Router;
use axum::body::{Body, Bytes};
use axum::extract::{DefaultBodyLimit, FromRequest, Request, State, WebSocketUpgrade};
use axum::http::{HeaderValue, Method, StatusCode, header};
use axum::response::{IntoResponse, Response};
use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::sync::Arc;
use std::time::Duration;
use tokio::net::TcpListener;
use tokio::runtime::Runtime;

/// The largest file that a page may send, in bytes: a .hair file of four million strands of ten points.
pub const MAX_UPLOAD: usize = 512 << 20;

/// The longest time that an upload may take. Others wait until it ends.
const UPLOAD_TIME: Duration = Duration::from_secs(900);

/// The longest message on a WebSocket, in bytes.
pub const MAX_MESSAGE: usize = 64 << 10;

/// The most pages at once.
pub const MAX_PAGES: usize = 32;

/// Where a server listens.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// The address. `None` is the loopback address, without a token.
    pub host: Option<IpAddr>,
    /// The port; 0 is a free one.
    pub port: u16,
}

/// What all requests share.
pub(crate) struct Site {
    pub engine: Engine,
    pub guard: Guard,
    pub pages: tokio::sync::Semaphore,
    /// One file at a time is in memory.
    pub uploads: tokio::sync::Semaphore,
}

/// A running server. It ends when it is dropped.
#[derive(Debug)]
pub struct Server {
    /// `None` only while it is dropped.
    runtime: Option<Runtime>,
    address: SocketAddr,
    token: Option<String>,
}

impl Server {
    /// Starts to listen.
    ///
    /// # Errors
    /// [`Error::Listen`] if the address cannot be used, [`Error::System`] without threads or random numbers.
    pub fn start(engine: Engine, options: &Options) -> Result<Self, Error> {
        let guard = Guard::new(options.host.is_some())?;
        let token = guard.token.clone();
        let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build();
        let runtime = runtime.map_err(|source| Error::System { what: "threads", source })?;
        let wanted = SocketAddr::new(options.host.unwrap_or(Ipv4Addr::LOCALHOST.into()), options.port);
        let failed = |source| Error::Listen { address: wanted.to_string(), source };
        // The caller may be in a runtime of its own, so nothing here waits for a future.
        let listener = std::net::TcpListener::bind(wanted).map_err(failed)?;
        listener.set_nonblocking(true).map_err(failed)?;
        let address = listener.local_addr().map_err(failed)?;
        let entered = runtime.enter();
        let listener = TcpListener::from_std(listener).map_err(failed)?;
        drop(entered);
        let [pages, uploads] = [MAX_PAGES, 1].map(tokio::sync::Semaphore::new);
        let site = Arc::new(Site { engine, guard, pages, uploads });
        let router = Router::new().fallback(answer).layer(DefaultBodyLimit::max(MAX_UPLOAD)).with_state(site);
        // It ends with the runtime.
        runtime.spawn(async move { axum::serve(listener, router).await });
        Ok(Server { runtime: Some(runtime), address, token })
    }

    /// The address of the page, with its token.
    pub fn url(&self) -> String {
        let token = self.token.as_ref().map_or_else(String::new, |token| format!("{token}/"));
        format!("http://{}/{token}", self.address)
    }

    /// Waits for Ctrl-C.
    ///
    /// # Errors
    /// [`Error::System`] if the system reports no signals.
    pub fn wait(mut self) -> Result<(), Error> {
        let Some(runtime) = self.runtime.take() else { return Ok(()) };
        let ended = runtime.block_on(tokio::signal::ctrl_c());
        runtime.shutdown_timeout(Duration::from_secs(1));
        ended.map_err(|source| Error::System { what: "signals", source })
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        if let Some(runtime) = self.runtime.take() {
            runtime.shutdown_background();
        }
    }
}

/// Answers any request.
async fn answer(State(site): State<Arc<Site>>, request: Request) -> Response {
    let mut response = route(site, request).await;
    let headers = response.headers_mut();
    for (name, value) in HEADERS {
        headers.insert(name, HeaderValue::from_static(value));
    }
    response
}

/// The headers of all answers: nothing from other servers, no frames, no cache, no address in links.
const HEADERS: [(header::HeaderName, &str); 5] = [
    (
        header::CONTENT_SECURITY_POLICY,
        "default-src 'self'; img-src 'self' blob: data:; style-src 'self' 'unsafe-inline'; frame-ancestors 'none'",
    ),
    (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    (header::X_FRAME_OPTIONS, "DENY"),
    (header::REFERRER_POLICY, "no-referrer"),
    (header::CACHE_CONTROL, "no-store"),
];

async fn route(site: Arc<Site>, request: Request) -> Response {
    if !site.guard.allows(request.headers()) {
        return text(StatusCode::FORBIDDEN, "this server only answers its own page");
    }
    let Some(path) = site.guard.path(request.uri().path()).map(str::to_owned) else {
        return text(StatusCode::FORBIDDEN, "open the address that vellus live printed: it has a token");
    };
    match (request.method(), path.as_str()) {
        (&Method::GET, "/ws") => match WebSocketUpgrade::from_request(request, &()).await {
            Ok(upgrade) => {
                let upgrade = upgrade.max_message_size(MAX_MESSAGE).max_frame_size(MAX_MESSAGE);
                upgrade.on_upgrade(move |socket| socket::serve(site, socket))
            }
            Err(error) => error.into_response(),
        },
        (&Method::POST, "/load") => load(&site, request).await,
        (&Method::GET, path) => match path.strip_prefix("/save/") {
            Some(name) => save(&site, name).await,
            None => match page::file(path) {
                Some((media, content)) => ([(header::CONTENT_TYPE, media)], content).into_response(),
                None => text(StatusCode::NOT_FOUND, "there is no such page"),
            },
        },
        _ => text(StatusCode::METHOD_NOT_ALLOWED, "only GET, and POST for files"),
    }
}

/// A file for the browser to save.
async fn save(site: &Site, name: &str) -> Response {
    let Some(what) = Save::parse(name) else { return text(StatusCode::NOT_FOUND, "there is no such file") };
    let Some(answer) = site.engine.save(what) else { return text(StatusCode::SERVICE_UNAVAILABLE, "too busy") };
    match answer.await {
        Ok(Ok(bytes)) => {
            let disposition = format!("attachment; filename=\"{name}\"");
            let headers = [(header::CONTENT_TYPE, what.media()), (header::CONTENT_DISPOSITION, &disposition)];
            (headers, Body::from(bytes)).into_response()
        }
        Ok(Err(error)) => text(StatusCode::CONFLICT, &error),
        Err(_) => text(StatusCode::SERVICE_UNAVAILABLE, "the renderer has ended"),
    }
}

/// A dropped file: its bytes are the body, and its name is the query.
async fn load(site: &Site, request: Request) -> Response {
    let name = percent_decoded(request.uri().query().unwrap_or_default());
    let too_large = || {
        let what = format!("the file is too large: at most {} MB", MAX_UPLOAD >> 20);
        text(StatusCode::PAYLOAD_TOO_LARGE, &what)
    };
    // A file that says its size is refused before it is read.
    let length = request.headers().get(header::CONTENT_LENGTH).and_then(|value| value.to_str().ok()?.parse().ok());
    if length.is_some_and(|length: u64| length > MAX_UPLOAD as u64) {
        return too_large();
    }
    let Ok(_upload) = site.uploads.try_acquire() else {
        return text(StatusCode::SERVICE_UNAVAILABLE, "another file is being loaded: try again when it is shown");
    };
    let bytes = match tokio::time::timeout(UPLOAD_TIME, Bytes::from_request(request, &())).await {
        Ok(Ok(bytes)) => bytes,
        Ok(Err(error)) if error.status() == StatusCode::PAYLOAD_TOO_LARGE => return too_large(),
        Ok(Err(error)) => return error.into_response(),
        Err(_) => return text(StatusCode::REQUEST_TIMEOUT, "the file did not arrive within 15 minutes"),
    };
    let Some(answer) = site.engine.load(name, bytes.into()) else {
        return text(StatusCode::SERVICE_UNAVAILABLE, "too busy");
    };
    match answer.await {
        Ok(Ok(_)) => text(StatusCode::OK, "the groom is shown"),
        Ok(Err(error)) => text(StatusCode::UNPROCESSABLE_ENTITY, &error),
        Err(_) => text(StatusCode::SERVICE_UNAVAILABLE, "the renderer has ended"),
    }
}

fn text(status: StatusCode, what: &str) -> Response {
    (status, [(header::CONTENT_TYPE, "text/plain; charset=utf-8")], what.to_owned()).into_response()
}

/// A text after percent decoding. Wrong escapes stay as they are.
fn percent_decoded(text: &str) -> String {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let Some((&first, tail)) = rest.split_first() {
        let escape = tail.get(..2).filter(|_| first == b'%').and_then(|digits| std::str::from_utf8(digits).ok());
        match escape.and_then(|digits| u8::from_str_radix(digits, 16).ok()) {
            Some(byte) => {
                bytes.push(byte);
                rest = &tail[2..];
            }
            None => {
                bytes.push(first);
                rest = tail;
            }
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}
