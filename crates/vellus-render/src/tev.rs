//! Live view: pictures sent to the viewer tev as they are rendered.
//!
//! tev listens on a TCP port, 14158 by default. A packet is its length in bytes, itself included, as u32; its kind as a byte; and what the
//! kind has; all little endian, texts ended by a zero, lists without a count of their own.

use crate::say::note;
use anyhow::{Context, Result, bail};
use std::io::Write;
use std::net::{TcpStream, ToSocketAddrs};
use std::path::Path;
use std::time::Duration;
use vellus_render::{Film, Layer};

/// Kinds of packets: an empty image; pixels of one, with a place and a stride for each channel.
const CREATE_IMAGE: u8 = 4;
const UPDATE_IMAGE: u8 = 6;

const CHANNELS: [&str; 4] = ["R", "G", "B", "A"];

/// Longer than this nobody waits for a viewer.
const PATIENCE: Duration = Duration::from_secs(5);

/// A connection.
#[derive(Debug)]
pub struct Viewer {
    address: String,
    /// `None` when it was lost.
    stream: Option<TcpStream>,
    /// The image it shows.
    shown: String,
}

fn packet(kind: u8, fill: impl FnOnce(&mut Vec<u8>)) -> Vec<u8> {
    let mut bytes = vec![0, 0, 0, 0, kind];
    fill(&mut bytes);
    let length = (bytes.len() as u32).to_le_bytes();
    bytes[..4].copy_from_slice(&length);
    bytes
}

fn text(bytes: &mut Vec<u8>, text: &str) {
    bytes.extend(text.bytes().filter(|&b| b != 0));
    bytes.push(0);
}

fn numbers(bytes: &mut Vec<u8>, numbers: impl IntoIterator<Item = usize>) {
    numbers.into_iter().for_each(|n| bytes.extend((n as i32).to_le_bytes()));
}

/// An empty image of that name, brought to the front.
fn create(name: &str, [width, height]: [usize; 2]) -> Vec<u8> {
    packet(CREATE_IMAGE, |bytes| {
        bytes.push(1);
        text(bytes, name);
        numbers(bytes, [width, height, CHANNELS.len()]);
        CHANNELS.iter().for_each(|channel| text(bytes, channel));
    })
}

/// Some rows of a film, where they are in the whole picture.
fn update(name: &str, film: &Film, rows: std::ops::Range<usize>) -> Vec<u8> {
    let [left, top, width, _] = film.area();
    packet(UPDATE_IMAGE, |bytes| {
        bytes.push(0);
        text(bytes, name);
        numbers(bytes, [CHANNELS.len()]);
        CHANNELS.iter().for_each(|channel| text(bytes, channel));
        numbers(bytes, [left, top + rows.start, width, rows.len()]);
        // Channels of a pixel lie beside each other.
        (0..4i64).for_each(|offset| bytes.extend(offset.to_le_bytes()));
        (0..4).for_each(|_| bytes.extend(4i64.to_le_bytes()));
        for (x, y) in rows.flat_map(|y| (0..width).map(move |x| (x, y))) {
            let rgb = [0, 1, 2].map(|c| film.mean(x, y, Layer::Beauty, c));
            let pixel = [rgb[0], rgb[1], rgb[2], film.mean(x, y, Layer::Alpha, 0)];
            pixel.into_iter().for_each(|value| bytes.extend((value as f32).to_le_bytes()));
        }
    })
}

impl Viewer {
    /// Connects to HOST:PORT, or to tev's port of HOST.
    ///
    /// # Errors
    /// Where nothing answers.
    pub fn connect(address: &str) -> Result<Self> {
        let address = if address.contains(':') { address.to_owned() } else { format!("{address}:14158") };
        let connect = || -> Result<TcpStream> {
            let mut last = None;
            for to in address.to_socket_addrs()? {
                match TcpStream::connect_timeout(&to, PATIENCE) {
                    Ok(stream) => return Ok(stream),
                    Err(e) => last = Some(e),
                }
            }
            match last {
                Some(e) => Err(e.into()),
                None => bail!("the host has no address"),
            }
        };
        let stream = connect().with_context(|| format!("--tev {address}: no viewer answers there; start tev first"))?;
        stream.set_write_timeout(Some(PATIENCE))?;
        Ok(Viewer { address, stream: Some(stream), shown: String::new() })
    }

    /// Shows a film under the name of its file. A viewer that went away is told of once, and left alone.
    pub fn show(&mut self, film: &Film, path: &Path) {
        let Some(stream) = &mut self.stream else { return };
        let name = path.display().to_string();
        let mut send = || -> std::io::Result<()> {
            if self.shown != name {
                stream.write_all(&create(&name, film.whole()))?;
                self.shown.clone_from(&name);
            }
            // Packets of a few megabytes.
            let rows = (1 << 18) / film.width() + 1;
            for first in (0..film.height()).step_by(rows) {
                stream.write_all(&update(&name, film, first..(first + rows).min(film.height())))?;
            }
            Ok(())
        };
        if let Err(e) = send() {
            note!("warning: the viewer at {} is gone ({e}): rendering goes on without it", self.address);
            self.stream = None;
        }
    }
}
