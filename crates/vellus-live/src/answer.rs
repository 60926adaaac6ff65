//! The answers to requests.

use crate::guard::PAGE_TOKEN;
use crate::save::Save;
use crate::server::Site;
use crate::{page, socket};
use axum::body::{Body, HttpBody};
use axum::extract::{FromRequest, Request, WebSocketUpgrade};
use axum::http::{HeaderValue, Method, StatusCode, header};
use axum::response::{IntoResponse, Response};
use std::pin::Pin;
use std::sync::Arc;
use std::time::Duration;

/// The largest file that a page may send, in bytes: a .hair file of four million strands of ten points.
pub const MAX_UPLOAD: usize = 512 << 20;

/// The longest time that an upload may take. Others wait until it ends.
const UPLOAD_TIME: Duration = Duration::from_secs(900);

/// A file of which fewer bytes than this arrive within [`Options::patience`](crate::Options::patience) is given up.
const UPLOAD_STEP: usize = 64 << 10;

/// The longest message on a WebSocket, in bytes.
pub const MAX_MESSAGE: usize = 64 << 10;

/// Answers any request.
pub async fn answer(site: Arc<Site>, request: Request) -> Response {
    let mut response = route(site, request).await;
    let headers = response.headers_mut();
    for (name, value) in HEADERS {
        headers.insert(name, HeaderValue::from_static(value));
    }
    // A connection has one request, so none is open in vain.
    if response.status() != StatusCode::SWITCHING_PROTOCOLS {
        response.headers_mut().insert(header::CONNECTION, HeaderValue::from_static("close"));
    }
    response
}

/// The headers of all answers: nothing from and for other servers, no frames, no cache, no address in links.
const HEADERS: [(header::HeaderName, &str); 6] = [
    (
        header::CONTENT_SECURITY_POLICY,
        "default-src 'self'; img-src 'self' blob: data:; style-src 'self' 'unsafe-inline'; frame-ancestors 'none'",
    ),
    (header::HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
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
        (&Method::GET, path) => match page::file(path) {
            Some((media, content)) => ([(header::CONTENT_TYPE, media)], content).into_response(),
            None => text(StatusCode::NOT_FOUND, "there is no such page"),
        },
        (&Method::POST, _) if !site.guard.is_page(request.headers()) => text(
            StatusCode::FORBIDDEN,
            &format!("only the page may do this: the header {PAGE_TOKEN} is missing or wrong"),
        ),
        (&Method::POST, "/load") => load(&site, request).await,
        (&Method::POST, path) => match path.strip_prefix("/save/") {
            Some(name) => save(&site, name).await,
            None => text(StatusCode::NOT_FOUND, "there is no such page"),
        },
        _ => text(StatusCode::METHOD_NOT_ALLOWED, "only GET, and POST for files"),
    }
}

/// A file for the browser to save.
async fn save(site: &Site, name: &str) -> Response {
    let Some(what) = Save::parse(name) else { return text(StatusCode::NOT_FOUND, "there is no such file") };
    let Ok(place) = Arc::clone(&site.saves).try_acquire_owned() else {
        return text(StatusCode::SERVICE_UNAVAILABLE, "another file is being saved: try again when it is done");
    };
    let Some(answer) = site.engine.save(what, place) else {
        return text(StatusCode::SERVICE_UNAVAILABLE, "too busy");
    };
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
    let received = tokio::time::timeout(UPLOAD_TIME, receive(request.into_body(), site.patience)).await;
    let bytes = match received.unwrap_or(Err(Upload::TooSlow)) {
        Ok(bytes) => bytes,
        Err(Upload::TooLarge) => return too_large(),
        Err(Upload::TooSlow) => return text(StatusCode::REQUEST_TIMEOUT, "the file arrives too slowly"),
        Err(Upload::Lost) => return text(StatusCode::BAD_REQUEST, "the file did not arrive as a whole"),
    };
    let Some(answer) = site.engine.load(name, bytes) else {
        return text(StatusCode::SERVICE_UNAVAILABLE, "too busy");
    };
    match answer.await {
        Ok(Ok(_)) => text(StatusCode::OK, "the groom is shown"),
        Ok(Err(error)) => text(StatusCode::UNPROCESSABLE_ENTITY, &error),
        Err(_) => text(StatusCode::SERVICE_UNAVAILABLE, "the renderer has ended"),
    }
}

/// Why a file was not received.
enum Upload {
    TooLarge,
    TooSlow,
    Lost,
}

/// The bytes of a body. Each [`UPLOAD_STEP`] of it must arrive within `patience`.
async fn receive(mut body: Body, patience: Duration) -> Result<Vec<u8>, Upload> {
    let mut bytes = Vec::new();
    loop {
        let wanted = bytes.len() + UPLOAD_STEP;
        let step = async {
            while bytes.len() < wanted {
                let frame = std::future::poll_fn(|context| Pin::new(&mut body).poll_frame(context)).await;
                let Some(frame) = frame else { return Ok(true) };
                if let Some(data) = frame.map_err(|_| Upload::Lost)?.data_ref() {
                    if bytes.len() + data.len() > MAX_UPLOAD {
                        return Err(Upload::TooLarge);
                    }
                    bytes.extend_from_slice(data);
                }
            }
            Ok(false)
        };
        if tokio::time::timeout(patience, step).await.map_err(|_| Upload::TooSlow)?? {
            return Ok(bytes);
        }
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
