//! The viewer beside hostile peers: half requests, requests of foreign pages, noise, files that stop, silent pages,
//! closed outputs and signals. It must answer its own page, end with the code of the signal, and leave no files.

use super::Attack;
use crate::child::{Sink, When};
use crate::dice::Dice;
use crate::trial::{Stop, Trial};
use rustix::process::Signal;
use std::io::{Read, Write};
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// The processor time of a viewer that renders all the time, seconds.
const CPU: u64 = 100;

/// The longest time until the scene is shown.
const OPENING: Duration = Duration::from_secs(30);

/// The longest time of an answer beside hostile peers.
const ANSWER: Duration = Duration::from_secs(5);

#[derive(Default)]
pub struct Viewer;

impl Attack for Viewer {
    fn name(&self) -> &'static str {
        "viewer"
    }

    fn case(&mut self, trial: &mut Trial) -> Result<(), Stop> {
        let port = TcpListener::bind((Ipv4Addr::LOCALHOST, 0))?.local_addr()?.port();
        let mut call = trial.vellus(&format!("live hair-lock --small --no-open --port {port}"));
        call.cpu_seconds = CPU;
        let outputs = [Sink::Read, Sink::ClosedPipe, Sink::Closed, Sink::File("/dev/full".into())];
        call.stderr = trial.dice.pick(&outputs[..3]).clone();
        call.stdout = if trial.dice.chance(0.05) { outputs[3].clone() } else { trial.dice.pick(&outputs[..3]).clone() };
        if matches!(call.stdout, Sink::File(_)) {
            trial.tried += 1;
            let outcome = trial.run(&call)?;
            trial.ended_with(&outcome, &[75], "a viewer whose output is full");
            return Ok(());
        }
        let signal = *trial.dice.pick(&[Signal::INT, Signal::TERM, Signal::HUP]);
        let told = Arc::new(AtomicBool::new(false));
        call.signal = Some((When::Told(Arc::clone(&told)), signal));
        let peers: Vec<Peer> = (0..trial.dice.number(1..40)).map(|_| Peer::new(&mut trial.dice)).collect();
        trial.tried += peers.len() as u64;
        let visit = std::thread::spawn(move || {
            let findings = visit(port, &peers);
            told.store(true, Ordering::Relaxed);
            findings
        });
        let outcome = trial.run(&call)?;
        let findings = visit.join().unwrap_or_else(|_| vec!["this program panicked".to_owned()]);
        if outcome.code == Some(2) && outcome.stderr.contains("cannot listen") {
            return Ok(());
        }
        trial.kills += u64::from(outcome.signalled);
        for finding in findings {
            trial.finding(finding, String::new());
        }
        trial.ended_with(&outcome, &[128 + signal.as_raw()], "a viewer after a signal");
        if trial.at("tmp").read_dir()?.next().is_some() {
            trial.finding("the viewer leaves temporary files", String::new());
        }
        Ok(())
    }
}

/// One hostile connection, and whether it is closed at once.
struct Peer {
    bytes: Vec<u8>,
    copies: usize,
    closed: bool,
    /// What the answer must begin with, if it is waited for.
    answer: Option<&'static str>,
}

impl Peer {
    fn new(dice: &mut Dice) -> Self {
        let own = "Host: localhost\r\n";
        let path = *dice.pick(&["/", "/ws", "/save/scene.usdc", "/save/picture.exr", "/load?a.hair", "/app.js"]);
        let method = *dice.pick(&["GET", "POST"]);
        let (mut text, mut answer) = match dice.number(0..6) {
            0 => (format!("{method} {path} HTTP/1.1\r\n{own}X-A: "), None),
            1 => {
                let foreign = dice.pick(&[
                    "Sec-Fetch-Site: cross-site",
                    "Sec-Fetch-Site: same-site",
                    "Origin: http://evil.example",
                    "Origin: null",
                ]);
                (format!("{method} {path} HTTP/1.1\r\n{own}{foreign}\r\n\r\n"), Some("HTTP/1.1 403"))
            }
            2 => (format!("POST {path} HTTP/1.1\r\n{own}Content-Length: 5000000\r\n\r\nHAIR"), None),
            3 => {
                let key = "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==";
                (format!("GET /ws HTTP/1.1\r\n{own}Connection: Upgrade\r\nUpgrade: websocket\r\n{key}\r\n\r\n"), None)
            }
            4 => {
                (format!("{method} {path} HTTP/1.1\r\n{own}X-A: {}\r\n\r\n", "x".repeat(dice.number(0..500_000))), None)
            }
            _ => (String::new(), None),
        };
        if dice.chance(0.1) {
            text.truncate(dice.number(0..text.len() + 1));
            answer = None;
        }
        let mut bytes = text.into_bytes();
        if answer.is_none() {
            let noise = dice.number(0..300);
            bytes.extend((0..noise).map(|_| dice.byte()));
        }
        let copies = if dice.chance(0.1) { 150 } else { 1 };
        Peer { bytes, copies, closed: dice.chance(0.3) && answer.is_none(), answer }
    }
}

/// Connects all peers, and the own page beside them. Returns findings.
fn visit(port: u16, peers: &[Peer]) -> Vec<String> {
    let connect = || {
        let stream = TcpStream::connect((Ipv4Addr::LOCALHOST, port))?;
        stream.set_read_timeout(Some(ANSWER))?;
        stream.set_write_timeout(Some(ANSWER))?;
        Ok::<_, std::io::Error>(stream)
    };
    let ask = |bytes: &[u8]| {
        let mut stream = connect()?;
        stream.write_all(bytes)?;
        let mut answer = [0; 12];
        stream.read_exact(&mut answer).map(|()| String::from_utf8_lossy(&answer).into_owned())
    };
    let page = || ask(b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n").is_ok_and(|answer| answer == "HTTP/1.1 200");
    let end = Instant::now() + OPENING;
    while !page() {
        if Instant::now() > end {
            return vec!["the viewer does not answer its page".to_owned()];
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    let (mut open, mut findings) = (Vec::new(), Vec::new());
    for peer in peers {
        for _ in 0..peer.copies {
            if let Some(expected) = peer.answer {
                match ask(&peer.bytes) {
                    Ok(answer) if answer == expected => {}
                    Ok(answer) => findings.push(format!("a foreign page gets {answer}")),
                    Err(error) => findings.push(format!("a foreign page gets no answer: {}", error.kind())),
                }
            } else if let Ok(mut stream) = connect() {
                // The viewer may close it before it has read everything.
                stream.write_all(&peer.bytes).ok();
                open.extend((!peer.closed).then_some(stream));
            }
        }
    }
    if !page() {
        findings.push("the viewer does not answer its page beside hostile peers".to_owned());
    }
    findings
}
