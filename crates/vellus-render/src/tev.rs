//! Live view: shows films in the viewer [tev](https://github.com/Tom94/tev) while they are rendered.
//!
//! tev listens on a TCP port. A packet is its length in bytes as `u32`, this field included, its kind as a byte, and
//! the fields of its kind. Numbers are little endian, texts end with a zero byte, and lists carry no count.

use crate::film::{Film, Layer};
use std::io::{Error, ErrorKind, Result, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::time::Duration;

/// The port that tev listens on by default.
const PORT: u16 = 14158;

/// Kinds of packets: a new, empty image, and pixels of an image with an offset and a stride for each channel.
const CREATE_IMAGE: u8 = 4;
const UPDATE_IMAGE: u8 = 6;

const CHANNELS: [&str; 4] = ["R", "G", "B", "A"];

/// How long to wait for a viewer.
const TIMEOUT: Duration = Duration::from_secs(5);

/// A connection to the viewer.
#[derive(Debug)]
pub struct Viewer {
    address: String,
    stream: TcpStream,
    /// The name of the image it shows.
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

/// The packet for an empty image with this name, which the viewer shows in front.
fn create(name: &str, [width, height]: [usize; 2]) -> Vec<u8> {
    packet(CREATE_IMAGE, |bytes| {
        bytes.push(1);
        text(bytes, name);
        numbers(bytes, [width, height, CHANNELS.len()]);
        CHANNELS.iter().for_each(|channel| text(bytes, channel));
    })
}

/// Some rows of a film, placed within the whole picture.
fn update(name: &str, film: &Film, rows: std::ops::Range<usize>) -> Vec<u8> {
    let [left, top, width, _] = film.area();
    packet(UPDATE_IMAGE, |bytes| {
        bytes.push(0);
        text(bytes, name);
        numbers(bytes, [CHANNELS.len()]);
        CHANNELS.iter().for_each(|channel| text(bytes, channel));
        numbers(bytes, [left, top + rows.start, width, rows.len()]);
        // The channels of a pixel are adjacent.
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
    /// Connects to HOST:PORT, or to port 14158 of HOST.
    ///
    /// # Errors
    /// What the operating system reports if nothing answers within 5 seconds.
    pub fn connect(address: &str) -> Result<Self> {
        let address = if address.contains(':') { address.to_owned() } else { format!("{address}:{PORT}") };
        let mut last = Error::new(ErrorKind::NotFound, "the host has no address");
        for to in address.to_socket_addrs()? {
            match TcpStream::connect_timeout(&to, TIMEOUT) {
                Ok(stream) => {
                    stream.set_write_timeout(Some(TIMEOUT))?;
                    return Ok(Viewer { address, stream, shown: String::new() });
                }
                Err(e) => last = e,
            }
        }
        Err(last)
    }

    /// HOST:PORT.
    pub fn address(&self) -> &str {
        &self.address
    }

    /// Shows a film under a name. A new name opens a new image.
    ///
    /// # Errors
    /// What the operating system reports if the viewer is gone. The connection cannot be used again.
    pub fn show(&mut self, film: &Film, name: &str) -> Result<()> {
        if self.shown != name {
            self.stream.write_all(&create(name, film.whole()))?;
            name.clone_into(&mut self.shown);
        }
        // Packets have a few megabytes.
        let rows = (1 << 18) / film.width() + 1;
        for first in (0..film.height()).step_by(rows) {
            self.stream.write_all(&update(name, film, first..(first + rows).min(film.height())))?;
        }
        Ok(())
    }
}
