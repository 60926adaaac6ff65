//! The protocol, as a page speaks it: commands, answers, states, pictures, and everything that is refused.

use futures_util::{SinkExt, StreamExt};
use serde_json::{Value, json};
use std::net::{IpAddr, Ipv4Addr};
use std::time::{Duration, Instant};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio_tungstenite::tungstenite::{Message, client::IntoClientRequest};
use tokio_tungstenite::{MaybeTlsStream, WebSocketStream, connect_async};
use vellus_live::{Engine, Options, Server};
use vellus_testing::program::LIMIT;

type Socket = WebSocketStream<MaybeTlsStream<TcpStream>>;

/// The result of something that must not wait for ever.
async fn limited<T>(what: &str, work: impl Future<Output = T>) -> T {
    tokio::time::timeout(LIMIT, work).await.unwrap_or_else(|_| panic!("waited {LIMIT:?} in vain: {what}"))
}

fn server(host: Option<IpAddr>) -> Server {
    let engine = Engine::open("hair-lock", true, None).unwrap();
    Server::start(engine, &Options { host, ..Options::default() }).unwrap()
}

async fn connect(server: &Server) -> Socket {
    let url = server.url().replace("http", "ws") + "ws";
    let (socket, _) = limited("a connection", connect_async(url)).await.unwrap();
    socket
}

/// The next message that `accept` turns into a value. Pictures are confirmed.
async fn next<T>(socket: &mut Socket, mut accept: impl FnMut(&Message) -> Option<T>) -> T {
    let found = async {
        loop {
            let message = socket.next().await.unwrap().unwrap();
            if message.is_binary() {
                socket.send(Message::text(r#"{"type":"ack"}"#)).await.unwrap();
            }
            if let Some(found) = accept(&message) {
                return found;
            }
        }
    };
    limited("a message", found).await
}

/// The message, if it is a text after the greeting.
fn json_of(message: &Message) -> Option<Value> {
    let text = message.is_text().then(|| message.to_text().unwrap())?;
    Some(serde_json::from_str(text).unwrap()).filter(|value: &Value| value["type"] != "hello")
}

/// The token that the server tells its page.
async fn token(server: &Server) -> String {
    let hello = |message: &Message| serde_json::from_str::<Value>(message.to_text().ok()?).ok();
    let hello = next(&mut connect(server).await, hello).await;
    assert_eq!(hello["type"], "hello");
    hello["token"].as_str().unwrap().to_owned()
}

/// Sends a text, and returns the answer to it.
async fn raw(socket: &mut Socket, text: &str) -> Value {
    socket.send(Message::text(text)).await.unwrap();
    next(socket, |message| json_of(message).filter(|value| value["type"] != "state")).await
}

async fn ask(socket: &mut Socket, command: Value) -> Value {
    raw(socket, &command.to_string()).await
}

fn header(message: &Message) -> Option<Value> {
    let Message::Binary(bytes) = message else { return None };
    let length = u32::from_le_bytes(bytes[..4].try_into().unwrap()) as usize;
    assert_eq!(&bytes[4 + length..][..8], b"\x89PNG\r\n\x1a\n");
    Some(serde_json::from_slice(&bytes[4..4 + length]).unwrap())
}

fn address(server: &Server) -> String {
    server.url().trim_start_matches("http://").split('/').next().unwrap().to_owned()
}

/// Sends a plain HTTP request, and returns the whole answer.
async fn http(server: &Server, request: &str, body: &[u8]) -> String {
    let whole = async {
        let mut stream = TcpStream::connect(address(server)).await.unwrap();
        stream.write_all(request.as_bytes()).await.unwrap();
        // The server may answer and close before it has read everything.
        let _ = stream.write_all(body).await;
        let mut answer = Vec::new();
        let _ = stream.read_to_end(&mut answer).await;
        String::from_utf8_lossy(&answer).into_owned()
    };
    limited(request.lines().next().unwrap_or_default(), whole).await
}

async fn get(server: &Server, path: &str, headers: &str) -> String {
    http(server, &format!("GET {path} HTTP/1.1\r\nConnection: close\r\n{headers}\r\n"), b"").await
}

/// The header of a page's request for a file, and more.
async fn page_headers(server: &Server) -> String {
    format!("Host: localhost\r\nConnection: close\r\nX-Vellus-Token: {}\r\n", token(server).await)
}

async fn save(server: &Server, name: &str) -> String {
    http(server, &format!("POST /save/{name} HTTP/1.1\r\n{}\r\n", page_headers(server).await), b"").await
}

fn status(answer: &str) -> &str {
    answer.split(' ').nth(1).unwrap_or_default()
}

#[tokio::test]
async fn a_page_gets_state_and_pictures_and_moves_the_camera() {
    let server = server(None);
    let mut socket = connect(&server).await;
    let state = next(&mut socket, json_of).await;
    assert_eq!((&state["type"], &state["scene"]), (&json!("state"), &json!("hair-lock")));
    let first = next(&mut socket, header).await;
    assert!(first["samples"].as_u64().unwrap() >= 1);
    assert_eq!(ask(&mut socket, json!({"type": "target", "samples": 4, "id": 1})).await["type"], "reply");
    ask(&mut socket, json!({"type": "size", "width": 48, "height": 32, "id": 2})).await;
    let done = next(&mut socket, |m| header(m).filter(|h| h["done"] == true && h["size"] == json!([48, 32]))).await;
    assert_eq!((&done["samples"], &done["coarse"]), (&json!(4), &json!(1)));
    let answer = ask(&mut socket, json!({"type": "orbit", "x": 20, "y": 5, "id": "a"})).await;
    assert_eq!(answer, json!({"type": "reply", "id": "a", "answer": null}));
    let moved = next(&mut socket, |m| header(m).filter(|h| h["revision"].as_u64() > done["revision"].as_u64())).await;
    assert!(moved["latency"].as_f64().unwrap() > 0.0, "{moved}");
}

#[tokio::test]
async fn malformed_messages_are_answered_with_an_error() {
    let server = server(None);
    let mut socket = connect(&server).await;
    let mut texts = vec![
        "".to_owned(),
        "{".to_owned(),
        "[]".to_owned(),
        "7".to_owned(),
        r#"{"type":"fly"}"#.to_owned(),
        r#"{"type":"orbit","x":1}"#.to_owned(),
        r#"{"type":"orbit","x":1e39,"y":0}"#.to_owned(),
        r#"{"type":"zoom","factor":0}"#.to_owned(),
        r#"{"type":"pick","x":2,"y":0}"#.to_owned(),
        r#"{"type":"size","width":0,"height":100000}"#.to_owned(),
        r#"{"type":"crop","area":[0.5,0.5,0.5,0.5]}"#.to_owned(),
        r#"{"type":"crop","area":[1]}"#.to_owned(),
        r#"{"type":"target","samples":0}"#.to_owned(),
        r#"{"type":"target","samples":-1}"#.to_owned(),
        r#"{"type":"look","look":9,"fiber":{}}"#.to_owned(),
        r#"{"type":"look","look":0,"fiber":{"eta":99}}"#.to_owned(),
        r#"{"type":"look","look":0,"fiber":{"eat":1}}"#.to_owned(),
        r#"{"type":"look","look":0,"fiber":7}"#.to_owned(),
        r#"{"type":"coat","look":0,"pattern":true,"tip":0}"#.to_owned(),
        r#"{"type":"light","light":99,"gain":1,"shift":[0,0,0]}"#.to_owned(),
        r#"{"type":"light","light":0,"gain":-1,"shift":[0,0,0]}"#.to_owned(),
        r#"{"type":"groom","density":0,"length":1,"clump":0,"clump_strands":10}"#.to_owned(),
        r#"{"type":"model","name":"unicorn"}"#.to_owned(),
        r#"{"type":"open","file":"../../etc/passwd"}"#.to_owned(),
        r#"{"type":"orbit","x":0,"y":0,"z":0}"#.to_owned(),
        format!("{}{}", "[".repeat(20_000), "]".repeat(20_000)),
    ];
    texts.push("x".repeat(60_000));
    for text in texts {
        let answer = raw(&mut socket, &text).await;
        let shown: String = text.chars().take(80).collect();
        assert_eq!(answer["type"], "error", "{shown}: {answer}");
        assert!(!answer["message"].as_str().unwrap().is_empty());
    }
    socket.send(Message::binary(vec![0; 1000])).await.unwrap();
    assert_eq!(next(&mut socket, |m| json_of(m).filter(|v| v["type"] == "error")).await["type"], "error");
    // The connection and the engine still work.
    assert_eq!(ask(&mut socket, json!({"type": "pick", "x": 0.5, "y": 0.5})).await["type"], "reply");
}

#[tokio::test]
async fn a_message_that_is_too_long_ends_the_connection_only() {
    let server = server(None);
    let mut socket = connect(&server).await;
    // The server may close before it has read everything.
    let _ = limited("a long message", socket.send(Message::text("x".repeat(20 << 20)))).await;
    let ended = async { while let Some(Ok(_)) = socket.next().await {} };
    limited("the end of the connection", ended).await;
    let mut other = connect(&server).await;
    assert_eq!(ask(&mut other, json!({"type": "home"})).await["type"], "reply");
}

#[tokio::test]
async fn two_pages_share_the_state_and_one_may_leave() {
    let server = server(None);
    let (mut one, mut two) = (connect(&server).await, connect(&server).await);
    ask(&mut one, json!({"type": "exposure", "stops": 1.5})).await;
    let state = next(&mut two, |m| json_of(m).filter(|v| v["exposure"] == 1.5)).await;
    assert_eq!(state["type"], "state");
    drop(one);
    assert_eq!(ask(&mut two, json!({"type": "azimuth", "degrees": 30})).await["type"], "reply");
    // A page that comes back gets the state and the picture at once.
    let mut again = connect(&server).await;
    next(&mut again, |m| json_of(m).filter(|v| v["azimuth"] == 30.0)).await;
    next(&mut again, header).await;
}

#[tokio::test]
async fn a_slow_page_gets_the_newest_picture_and_no_queue() {
    let server = server(None);
    let mut slow = connect(&server).await;
    let mut fast = connect(&server).await;
    for _ in 0..30 {
        let answer = ask(&mut fast, json!({"type": "orbit", "x": 3, "y": 0})).await;
        assert_eq!(answer["type"], "reply");
        next(&mut fast, header).await;
    }
    // Without confirmation the slow page has two pictures at most.
    let mut pictures = 0;
    let until = Instant::now() + Duration::from_secs(2);
    while let Ok(Some(Ok(message))) = tokio::time::timeout_at(until.into(), slow.next()).await {
        pictures += usize::from(message.is_binary());
    }
    assert_eq!(pictures, 2);
    slow.send(Message::text(r#"{"type":"ack"}"#)).await.unwrap();
    let newest = next(&mut slow, header).await;
    assert!(newest["frame"].as_u64().unwrap() > 10, "{newest}");
}

#[tokio::test]
async fn a_change_cancels_what_is_rendered() {
    let server = server(None);
    let mut socket = connect(&server).await;
    // One sample of this picture takes many times as long as the limit below.
    ask(&mut socket, json!({"type": "size", "width": 4096, "height": 4096})).await;
    next(&mut socket, |m| header(m).filter(|h| h["coarse"].as_u64() <= Some(4))).await;
    let started = Instant::now();
    assert_eq!(ask(&mut socket, json!({"type": "size", "width": 32, "height": 32})).await["type"], "reply");
    let took = started.elapsed();
    assert!(took < Duration::from_secs(3), "{took:?}");
}

#[tokio::test]
async fn foreign_pages_and_paths_are_refused() {
    let server = &server(None);
    assert_eq!(status(&get(server, "/", "Host: localhost:1\r\n").await), "200");
    for headers in [
        "Host: evil.example\r\n",
        "Host: localhost\r\nOrigin: http://evil.example\r\n",
        "Host: localhost:80\r\nOrigin: http://localhost:81\r\n",
        "Host: localhost\r\nOrigin: null\r\n",
        // An image or a script of a foreign page.
        "Host: localhost\r\nSec-Fetch-Site: cross-site\r\n",
        "Host: localhost\r\nSec-Fetch-Site: same-site\r\n",
    ] {
        assert_eq!(status(&get(server, "/", headers).await), "403", "{headers}");
        let token = token(server).await;
        let post = format!("POST /save/picture.png HTTP/1.1\r\nX-Vellus-Token: {token}\r\n{headers}\r\n");
        assert_eq!(status(&http(server, &post, b"").await), "403", "{headers}");
    }
    for path in ["/../Cargo.toml", "/save/picture.png", "/%2e%2e/x", "/app.js/"] {
        let answer = get(server, path, "Host: localhost\r\n").await;
        assert_eq!(status(&answer), "404", "{path}");
        assert!(answer.contains("cross-origin-resource-policy: same-origin"), "{answer}");
    }
    for name in ["../../etc/passwd", "look-99999999.toml"] {
        assert_eq!(status(&save(server, name).await), "404", "{name}");
    }
    // Files need the token of the page.
    for path in ["/save/look-0.toml", "/load?a.hair", "/x"] {
        for token in ["", "X-Vellus-Token: \r\n", &format!("X-Vellus-Token: {}\r\n", "0".repeat(32))] {
            let post = format!("POST {path} HTTP/1.1\r\nHost: localhost\r\n{token}Content-Length: 0\r\n\r\n");
            assert_eq!(status(&http(server, &post, b"").await), "403", "{path} {token}");
        }
    }
    let mut request = (server.url().replace("http", "ws") + "ws").into_client_request().unwrap();
    request.headers_mut().insert("Origin", "http://evil.example".parse().unwrap());
    assert!(limited("a refusal", connect_async(request)).await.is_err());
}

#[tokio::test]
async fn with_a_host_every_request_needs_the_token() {
    let server = server(Some(Ipv4Addr::LOCALHOST.into()));
    let url = server.url();
    let address = url.trim_start_matches("http://").split('/').next().unwrap();
    let token = url.rsplit('/').nth(1).unwrap();
    assert_eq!(token.len(), 32);
    let host = format!("Host: {address}\r\n");
    for path in ["/", "/ws", "/app.js", "/save/picture.png", &format!("/{}/", "0".repeat(32))] {
        assert_eq!(status(&get(&server, path, &host).await), "403", "{path}");
    }
    assert_eq!(status(&get(&server, &format!("/{token}/app.js"), &host).await), "200");
    assert!(limited("a refusal", connect_async(format!("ws://{address}/ws"))).await.is_err());
    next(&mut connect(&server).await, json_of).await;
}

#[tokio::test]
async fn garbage_gives_one_message_and_a_groom_is_shown() {
    let server = server(None);
    let headers = page_headers(&server).await;
    let load = async |name: &str, bytes: &[u8]| {
        let head = format!("POST /load?{name} HTTP/1.1\r\n{headers}Content-Length: {}\r\n\r\n", bytes.len());
        http(&server, &head, bytes).await
    };
    // A fixed pseudo-random sequence (Knuth's MMIX).
    let mut x = 1u64;
    let mut random = || {
        x = x.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (x >> 56) as u8
    };
    let garbage: Vec<u8> = (0..20 << 20).map(|_| random()).collect();
    for name in ["a.hair", "a.tfx", "a.obj", "a.png", "a", "a.usda", "..%2f..%2fa.hair"] {
        let answer = load(name, &garbage).await;
        assert_eq!(status(&answer), "422", "{name}: {}", &answer[..answer.len().min(300)]);
        let message = answer.split("\r\n\r\n").nth(1).unwrap();
        assert!(message.len() > 10 && message.lines().count() == 1, "{name}: {message}");
    }
    let scene = vellus_groom::scene("hair-lock", true).unwrap();
    let bytes = vellus_groom::write_hair(&vellus_groom::flatten(&scene.strands[0], 1)).unwrap();
    assert_eq!(status(&load("my%20lock.hair", &bytes).await), "200");
    let mut socket = connect(&server).await;
    // The answer may come before the new state.
    next(&mut socket, |m| json_of(m).filter(|v| v["scene"] == "my lock.hair")).await;
}

#[tokio::test]
async fn looks_lights_and_groom_change_the_state_and_are_saved() {
    let server = server(None);
    let mut socket = connect(&server).await;
    let state = next(&mut socket, json_of).await;
    let mut fiber = state["looks"][0]["fiber"].clone();
    fiber["beta_m"] = json!(9.0);
    for command in [
        json!({"type": "look", "look": 0, "fiber": fiber}),
        json!({"type": "coat", "look": 0, "pattern": false, "tip": 3.0}),
        json!({"type": "light", "light": 0, "gain": 2.0, "shift": [0, 1, 0]}),
        json!({"type": "model", "name": "chiang2016"}),
        json!({"type": "lens", "angle": 40, "radius": 0.1}),
        json!({"type": "size", "width": 48, "height": 32}),
        json!({"type": "groom", "density": 0.5, "length": 2.0, "clump": 0.5, "clump_strands": 10}),
    ] {
        let answer = ask(&mut socket, command.clone()).await;
        assert_eq!(answer["type"], "reply", "{command}: {answer}");
    }
    let built = |state: &Value| state["busy"].is_null() && state["groom"]["density"] == 0.5;
    let state = next(&mut socket, |m| json_of(m).filter(built)).await;
    assert_eq!(state["looks"][0]["tip"], 3.0);
    next(&mut socket, |m| header(m).filter(|h| h["coarse"] == 1 && h["size"] == json!([48, 32]))).await;
    for (name, part) in [
        ("look-0.toml", "beta_m = 9"),
        ("look-0.usda", "VellusFur"),
        ("scene.usdc", "PXR-USDC"),
        ("lights.usda", "Light "),
        ("camera.usda", "Camera"),
        ("picture.png", "PNG"),
        ("picture.exr", "v/1\u{1}"),
    ] {
        let answer = save(&server, name).await;
        assert_eq!(status(&answer), "200", "{name}: {answer}");
        assert!(answer.contains(part) || name == "picture.exr", "{name}: {answer}");
    }
    assert_eq!(status(&save(&server, "look-7.toml").await), "409");
}

#[tokio::test]
async fn undo_and_versions_cover_fibres_model_lights_and_groom() {
    let server = server(None);
    let mut socket = connect(&server).await;
    let start = next(&mut socket, json_of).await;
    assert_eq!((&start["can_undo"], &start["can_redo"], &start["version"]), (&json!(false), &json!(false), &json!(0)));
    let settings =
        |state: &Value| ["looks", "model", "azimuth", "lights", "groom"].map(|key| state[key].clone()).to_vec();
    let mut fiber = start["looks"][0]["fiber"].clone();
    fiber["sigma_ca"] = json!([3.0, 4.0, 5.0]);
    let commands = [
        json!({"type": "look", "look": 0, "fiber": fiber}),
        json!({"type": "coat", "look": 0, "pattern": false, "tip": 3.0}),
        json!({"type": "light", "light": 0, "gain": 2.0, "shift": [0, 1, 0]}),
        json!({"type": "azimuth", "degrees": 40}),
        json!({"type": "model", "name": "chiang2016"}),
        json!({"type": "groom", "density": 0.5, "length": 2.0, "clump": 0.5, "clump_strands": 10}),
    ];
    let done = async |socket: &mut Socket, command: &Value| {
        ask(socket, json!({"type": "home"})).await;
        let answer = ask(socket, command.clone()).await;
        assert_eq!(answer["type"], "reply", "{command}: {answer}");
        // The state with this angle is newer than the command, because `home` has reset the angle before.
        ask(socket, json!({"type": "lens", "angle": 41.5, "radius": 0})).await;
        let after = |state: &Value| state["camera"]["angle"] == 41.5 && state["busy"].is_null();
        next(socket, |m| json_of(m).filter(after)).await
    };
    let mut states = vec![settings(&start)];
    for command in &commands {
        states.push(settings(&done(&mut socket, command).await));
    }
    for expected in states.iter().rev().skip(1) {
        assert_eq!(settings(&done(&mut socket, &json!({"type": "undo"})).await), *expected);
    }
    assert_eq!(ask(&mut socket, json!({"type": "undo"})).await["type"], "error");
    for expected in states.iter().skip(1) {
        assert_eq!(settings(&done(&mut socket, &json!({"type": "redo"})).await), *expected);
    }
    assert_eq!(ask(&mut socket, json!({"type": "redo"})).await["type"], "error");
    // Version B is still the scene at first: another model, look and groom.
    let b = done(&mut socket, &json!({"type": "version", "index": 1})).await;
    assert_eq!((settings(&b), &b["other"]["model"]), (states[0].clone(), &json!("chiang2016")));
    let a = done(&mut socket, &json!({"type": "version", "index": 0})).await;
    assert_eq!(settings(&a), states[states.len() - 1]);
    done(&mut socket, &json!({"type": "copy-version"})).await;
    let b = done(&mut socket, &json!({"type": "version", "index": 1})).await;
    assert_eq!(settings(&b), settings(&a));
    assert_eq!(ask(&mut socket, json!({"type": "version", "index": 2})).await["type"], "error");
}

#[tokio::test]
async fn a_file_that_is_too_large_is_refused_before_it_is_read() {
    let server = server(None);
    let headers = page_headers(&server).await;
    let head = format!("POST /load?a.hair HTTP/1.1\r\n{headers}Content-Length: {}\r\n\r\n", (512 << 20) + 1);
    // The answer comes before the file.
    assert_eq!(status(&http(&server, &head, b"HAIR").await), "413");
}

/// Files of the largest size would fill the memory if many came at once.
#[tokio::test]
async fn one_file_is_loaded_at_a_time() {
    let server = server(None);
    let headers = page_headers(&server).await;
    let head = &format!("POST /load?a.hair HTTP/1.1\r\n{headers}Content-Length: 1000\r\n\r\n");
    let body = [0; 1000];
    // The first file stops in its middle. If the server reads the second file first, both are sent again, with a longer
    // pause between them.
    let (mut first, mut second) = (None, String::new());
    for attempt in 1..20 {
        drop(first.take());
        let mut stream = TcpStream::connect(address(&server)).await.unwrap();
        stream.write_all(head.as_bytes()).await.unwrap();
        stream.write_all(&body[..500]).await.unwrap();
        first = Some(stream);
        tokio::time::sleep(Duration::from_millis(50 * attempt)).await;
        second = http(&server, head, &body).await;
        if status(&second) == "503" {
            break;
        }
    }
    let mut first = first.unwrap();
    assert!(second.contains("another file is being loaded"), "{second}");
    first.write_all(&body[500..]).await.unwrap();
    let mut answer = String::new();
    limited("the answer to the first file", first.read_to_string(&mut answer)).await.unwrap();
    assert_eq!(status(&answer), "422");
    assert_eq!(status(&http(&server, head, &body).await), "422");
}

/// A server that gives others half a second, so that a test need not wait long.
fn impatient(scene: &str) -> Server {
    let engine = Engine::open(scene, true, None).unwrap();
    Server::start(engine, &Options { patience: Duration::from_millis(500), ..Options::default() }).unwrap()
}

/// Waits until the server closes a connection.
async fn closed(stream: &mut TcpStream, what: &str) {
    let mut rest = Vec::new();
    // It may end with an error, because the server has not read everything.
    let _ = limited(what, stream.read_to_end(&mut rest)).await;
}

#[tokio::test]
async fn half_a_request_keeps_no_one_out() {
    let half = async |server: &Server| {
        let mut stream = TcpStream::connect(address(server)).await.unwrap();
        stream.write_all(b"GET / HTTP/1.1\r\nHost: localhost\r\nX-A: ").await.unwrap();
        stream
    };
    // The first ones make room for others at once.
    let server = server(None);
    let mut many = Vec::new();
    for _ in 0..300 {
        many.push(half(&server).await);
    }
    let started = Instant::now();
    assert_eq!(status(&get(&server, "/", "Host: localhost\r\n").await), "200");
    assert!(started.elapsed() < Duration::from_secs(5), "{:?}", started.elapsed());
    closed(&mut many[0], "the oldest connection").await;
    // A single one ends when the patience does.
    closed(&mut half(&impatient("hair-lock")).await, "half a request").await;
}

#[tokio::test]
async fn a_file_that_stops_is_given_up() {
    let server = impatient("hair-lock");
    let headers = page_headers(&server).await;
    let head = format!("POST /load?a.hair HTTP/1.1\r\n{headers}Content-Length: 1000\r\n\r\n");
    assert_eq!(status(&http(&server, &head, b"HAIR").await), "408");
}

#[tokio::test]
async fn a_page_that_gives_no_sign_of_life_is_given_up() {
    let server = impatient("hair-lock");
    let mut silent = connect(&server).await;
    // A page that reads also answers pings.
    let mut page = connect(&server).await;
    let until = Instant::now() + Duration::from_secs(4);
    while tokio::time::timeout_at(until.into(), page.next()).await.is_ok() {}
    assert_eq!(ask(&mut page, json!({"type": "home"})).await["type"], "reply");
    let end = async { while let Some(Ok(_)) = silent.next().await {} };
    limited("the end of the silent page", end).await;
}

/// A scene of many strands takes a while to write. Only one is written, and no more than its request lasts.
#[tokio::test]
async fn saves_come_one_at_a_time_and_end_with_their_request() {
    let engine = Engine::open("cat", true, None).unwrap();
    let server = Server::start(engine, &Options::default()).unwrap();
    let request = format!("POST /save/scene.usdc HTTP/1.1\r\n{}\r\n", page_headers(&server).await);
    let mut refused = 0;
    for attempt in 0..40 {
        let mut first = TcpStream::connect(address(&server)).await.unwrap();
        first.write_all(request.as_bytes()).await.unwrap();
        tokio::time::sleep(Duration::from_millis(5 * attempt)).await;
        let answer = http(&server, &request.replace("scene.usdc", "look-0.toml"), b"").await;
        refused += usize::from(answer.contains("another file is being saved"));
        drop(first);
        // The place is free again.
        let free = async {
            while status(&http(&server, &request.replace("scene.usdc", "look-0.toml"), b"").await) != "200" {
                tokio::time::sleep(Duration::from_millis(5)).await;
            }
        };
        limited("the end of a save", free).await;
        if refused > 3 {
            return;
        }
    }
    panic!("no request was refused while another one was answered");
}

/// Questions of one page do not stop the picture of another.
#[tokio::test]
async fn questions_do_not_stop_the_picture() {
    let server = server(None);
    let (mut one, mut two) = (connect(&server).await, connect(&server).await);
    ask(&mut one, json!({"type": "size", "width": 1024, "height": 1024})).await;
    ask(&mut one, json!({"type": "target", "samples": 4})).await;
    let asking = tokio::spawn(async move {
        while ask(&mut two, json!({"type": "pick", "x": 0.5, "y": 0.5})).await["type"] == "reply" {}
    });
    let done = next(&mut one, |m| header(m).filter(|h| h["done"] == true && h["size"] == json!([1024, 1024]))).await;
    assert_eq!(done["samples"], 4);
    asking.abort();
}

/// The message names the file, but not its folder.
#[tokio::test]
async fn pages_see_no_paths_of_the_server() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("bad.usda"), "#usda 1.0\n(").unwrap();
    let engine = Engine::open("hair-lock", true, Some(folder.path().to_owned())).unwrap();
    let server = Server::start(engine, &Options::default()).unwrap();
    let mut socket = connect(&server).await;
    assert_eq!(ask(&mut socket, json!({"type": "open", "file": "bad.usda"})).await["type"], "reply");
    let state = next(&mut socket, |m| json_of(m).filter(|v| v["note"].is_string())).await;
    let note = state["note"].as_str().unwrap();
    assert!(note.contains("bad.usda") && !note.contains(folder.path().to_str().unwrap()), "{note}");
}

#[test]
fn addresses_of_many_machines_are_refused() {
    for host in ["224.0.0.1", "255.255.255.255", "ff02::1"] {
        let options = Options { host: Some(host.parse().unwrap()), ..Options::default() };
        let error = vellus_live::Listener::bind(&options).unwrap_err();
        assert!(format!("{error:?}").contains("no address of one machine"), "{error:?}");
    }
}
