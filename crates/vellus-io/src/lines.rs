//! Text whose lines have a bounded length.

use std::io::{Error, ErrorKind, Read, Result};

/// A reader that refuses lines of more than `limit` bytes. Readers of lines keep a whole line in memory, and a file
/// without line breaks is one line.
#[derive(Debug)]
pub struct BoundedLines<R> {
    inner: R,
    limit: usize,
    line: u64,
    length: usize,
}

impl<R: Read> BoundedLines<R> {
    /// Reads from `inner`.
    pub fn new(inner: R, limit: usize) -> Self {
        BoundedLines { inner, limit, line: 1, length: 0 }
    }
}

impl<R: Read> Read for BoundedLines<R> {
    /// # Errors
    /// Those of the inner reader, and [`ErrorKind::InvalidData`] for a line that is too long.
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize> {
        let count = self.inner.read(buffer)?;
        let mut pieces = buffer[..count].split(|byte| *byte == b'\n').map(<[u8]>::len);
        self.length += pieces.next().unwrap_or(0);
        for piece in pieces {
            if self.length > self.limit {
                break;
            }
            (self.line, self.length) = (self.line + 1, piece);
        }
        if self.length > self.limit {
            let (line, limit) = (self.line, self.limit);
            return Err(Error::new(ErrorKind::InvalidData, format!("line {line} is longer than {limit} bytes")));
        }
        Ok(count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_lines_are_refused_by_number() {
        let read = |text: &str| std::io::read_to_string(BoundedLines::new(text.as_bytes(), 5));
        assert_eq!(read("12345\n\n12345").unwrap(), "12345\n\n12345");
        assert_eq!(read("1\n2\n123456\n4").unwrap_err().to_string(), "line 3 is longer than 5 bytes");
        // A line in many pieces.
        let endless = std::io::repeat(b'0').take(1 << 30);
        let error = std::io::copy(&mut BoundedLines::new(endless, 1 << 20), &mut std::io::sink()).unwrap_err();
        assert_eq!(error.to_string(), "line 1 is longer than 1048576 bytes");
    }
}
