//! The WebSocket of one page.

use crate::request::Command;
use crate::server::{MAX_PAGES, Site};
use axum::body::Bytes;
use axum::extract::ws::{Message, WebSocket};
use serde_json::{Value, json};
use std::sync::Arc;
use std::time::Instant;

/// The most pictures that a page has not confirmed. Newer ones replace those that wait, so a slow page gets fewer
/// pictures, and none are queued.
const MAX_IN_FLIGHT: u64 = 2;

/// A page that was silent for this many times [`Options::patience`](crate::Options::patience) is given up. Browsers
/// answer each ping.
const SILENT: u32 = 3;

/// Serves a page until it closes the connection, or neither reads nor answers.
pub async fn serve(site: Arc<Site>, mut socket: WebSocket) {
    let Ok(_page) = site.pages.try_acquire() else {
        let text = format!("at most {MAX_PAGES} pages at once");
        // The connection ends in any case.
        let _ = socket.send(error(&Value::Null, &text)).await;
        return;
    };
    let (mut frames, mut states) = (site.engine.frames(), site.engine.states());
    frames.mark_changed();
    states.mark_changed();
    let mut pings = tokio::time::interval(site.patience);
    let mut heard = Instant::now();
    // The page needs its token for files.
    let hello = text_of(&json!({ "type": "hello", "token": site.guard.page }));
    if socket.send(hello).await.is_err() {
        return;
    }
    let mut sent = 0;
    let mut confirmed = 0;
    loop {
        let message = tokio::select! {
            biased;
            received = socket.recv() => {
                heard = Instant::now();
                match received {
                    Some(Ok(Message::Text(text))) => {
                        let reply = receive(&site, &text, &mut confirmed, sent).await;
                        // Nothing was read while the answer was made.
                        heard = Instant::now();
                        let Some(reply) = reply else { continue };
                        reply
                    }
                    Some(Ok(Message::Binary(_))) => error(&Value::Null, "commands are text"),
                    Some(Ok(Message::Ping(_) | Message::Pong(_))) => continue,
                    Some(Ok(Message::Close(_)) | Err(_)) | None => return,
                }
            }
            _ = pings.tick() => {
                if heard.elapsed() > SILENT * site.patience {
                    return;
                }
                Message::Ping(Bytes::new())
            }
            changed = states.changed() => {
                if changed.is_err() {
                    return;
                }
                let state = states.borrow_and_update().to_string();
                Message::Text(state.into())
            }
            changed = frames.changed(), if sent - confirmed < MAX_IN_FLIGHT => {
                if changed.is_err() {
                    return;
                }
                let Some(frame) = frames.borrow_and_update().clone() else { continue };
                sent += 1;
                Message::Binary(frame.bytes.clone().into())
            }
        };
        let done = tokio::time::timeout(SILENT * site.patience, socket.send(message)).await;
        if !matches!(done, Ok(Ok(()))) {
            return;
        }
    }
}

/// Answers a message. `None` if it needs no answer.
async fn receive(site: &Site, text: &str, confirmed: &mut u64, sent: u64) -> Option<Message> {
    let mut value: Value = match serde_json::from_str(text) {
        Ok(value @ Value::Object(_)) => value,
        Ok(_) => return Some(error(&Value::Null, "a command is a JSON object")),
        Err(reason) => return Some(error(&Value::Null, &format!("not JSON: {reason}"))),
    };
    let id = value.as_object_mut().and_then(|object| object.remove("id")).unwrap_or(Value::Null);
    if value["type"] == "ack" {
        *confirmed = sent.min(*confirmed + 1);
        return None;
    }
    if value["type"] == "ask" {
        // A view of the fibre takes up to a tenth of a second, so it must not block the other pages.
        let request = &value["request"];
        if let Some(text) = request["named_color"].as_str() {
            let answer = vellus_open::color(text);
            let answer = answer.map_or_else(|error| json!({ "error": error }), |color| json!({ "color": color }));
            return Some(text_of(&json!({ "type": "reply", "id": id, "answer": answer })));
        }
        let request = request.to_string();
        let answer = tokio::task::spawn_blocking(move || vellus_views::answer(&request)).await;
        let answer: Value = answer.ok().and_then(|text| serde_json::from_str(&text).ok()).unwrap_or_default();
        return Some(text_of(&json!({ "type": "reply", "id": id, "answer": answer })));
    }
    let command: Command = match serde_json::from_value(value) {
        Ok(command) => command,
        Err(reason) => return Some(error(&id, &reason.to_string())),
    };
    let Some(answer) = site.engine.send(command) else { return Some(error(&id, "too many commands wait")) };
    match answer.await {
        Ok(Ok(answer)) => Some(text_of(&json!({ "type": "reply", "id": id, "answer": answer }))),
        Ok(Err(reason)) => Some(error(&id, &reason)),
        Err(_) => Some(error(&id, "the renderer has ended")),
    }
}

fn error(id: &Value, message: &str) -> Message {
    text_of(&json!({ "type": "error", "id": id, "message": message }))
}

fn text_of(value: &Value) -> Message {
    Message::Text(value.to_string().into())
}
