//! The bytes of an MSH file: sections, and numbers as text or binary.

use super::MeshError;

/// How numbers stand in the sections.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    Text,
    Binary { swapped: bool },
}

/// A place in the file.
pub(super) struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
    pub(super) encoding: Encoding,
}

impl<'a> Cursor<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0, encoding: Encoding::Text }
    }

    /// An error at this place.
    pub(super) fn error(&self, message: impl Into<String>) -> MeshError {
        let line = 1 + self.bytes[..self.at.min(self.bytes.len())].iter().filter(|&&b| b == b'\n').count();
        let line = if self.encoding == Encoding::Text { line } else { 0 };
        MeshError::Format { line, message: message.into() }
    }

    fn skip_blank(&mut self) {
        while self.bytes.get(self.at).is_some_and(u8::is_ascii_whitespace) {
            self.at += 1;
        }
    }

    /// The next `$Section`, `None` at the end of the file.
    pub(super) fn next_section(&mut self) -> Result<Option<&'a str>, MeshError> {
        // As Gmsh does, whatever stands between two sections is passed over.
        loop {
            self.skip_blank();
            if self.at == self.bytes.len() {
                return Ok(None);
            }
            if let Some(name) = self.line()?.strip_prefix('$') {
                return Ok(Some(name));
            }
        }
    }

    /// What is left of the line, without blanks at its ends.
    pub(super) fn line(&mut self) -> Result<&'a str, MeshError> {
        let rest = &self.bytes[self.at..];
        let end = rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
        let text = std::str::from_utf8(&rest[..end]).map_err(|_| self.error("the line is not text"))?;
        self.at += (end + 1).min(rest.len());
        Ok(text.trim())
    }

    /// Goes on after `$End<name>`, whatever stands before it.
    pub(super) fn skip_section(&mut self, name: &str) -> Result<(), MeshError> {
        let end = format!("$End{name}");
        let found = self.bytes[self.at..].windows(end.len()).position(|window| window == end.as_bytes());
        let Some(found) = found else { return Err(self.error(format!("`{end}` is missing"))) };
        self.at += found + end.len();
        Ok(())
    }

    /// Expects `$End<name>`.
    pub(super) fn end_section(&mut self, name: &str) -> Result<(), MeshError> {
        self.skip_blank();
        let found = self.line()?;
        if found.strip_prefix("$End") == Some(name) {
            Ok(())
        } else {
            Err(self.error(format!("`$End{name}` expected, `{}` found", shorten(found))))
        }
    }

    fn word(&mut self) -> Result<&'a str, MeshError> {
        self.skip_blank();
        let rest = &self.bytes[self.at..];
        let end = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        if end == 0 {
            return Err(self.error("the file ends inside a section"));
        }
        let word = std::str::from_utf8(&rest[..end]).map_err(|_| self.error("not text"))?;
        self.at += end;
        Ok(word)
    }

    fn parse<N: std::str::FromStr>(&mut self, what: &str) -> Result<N, MeshError> {
        let word = self.word()?;
        word.parse().map_err(|_| self.error(format!("{what} expected, `{}` found", shorten(word))))
    }

    fn binary<const N: usize>(&mut self) -> Result<[u8; N], MeshError> {
        let bytes = self.bytes.get(self.at..).and_then(|rest| rest.first_chunk::<N>());
        let Some(&(mut bytes)) = bytes else { return Err(self.error("the file ends inside a section")) };
        self.at += N;
        if self.encoding == (Encoding::Binary { swapped: true }) {
            bytes.reverse();
        }
        Ok(bytes)
    }

    /// A signed number of four bytes.
    pub(super) fn int(&mut self) -> Result<i64, MeshError> {
        match self.encoding {
            Encoding::Text => self.parse("a whole number"),
            Encoding::Binary { .. } => Ok(i64::from(i32::from_le_bytes(self.binary()?))),
        }
    }

    /// A count or a tag, of eight bytes.
    pub(super) fn size(&mut self) -> Result<u64, MeshError> {
        match self.encoding {
            Encoding::Text => self.parse("a whole number ≥ 0"),
            Encoding::Binary { .. } => Ok(u64::from_le_bytes(self.binary()?)),
        }
    }

    /// A real number.
    pub(super) fn real(&mut self) -> Result<f64, MeshError> {
        match self.encoding {
            Encoding::Text => self.parse("a number"),
            Encoding::Binary { .. } => Ok(f64::from_le_bytes(self.binary()?)),
        }
    }

    /// A count that binary files of format 2.2 write as text on a line.
    pub(super) fn text_count(&mut self) -> Result<u64, MeshError> {
        self.skip_blank();
        let line = self.line()?;
        line.parse().map_err(|_| self.error(format!("a count expected, `{}` found", shorten(line))))
    }

    /// Reads the number 1 by which binary files show the order of their bytes.
    pub(super) fn detect_order(&mut self) -> Result<(), MeshError> {
        self.encoding = Encoding::Binary { swapped: false };
        let swapped = match self.int()? {
            1 => false,
            n if n == i64::from(1_i32.swap_bytes()) => true,
            n => return Err(self.error(format!("byte order mark {n} is not 1"))),
        };
        self.encoding = Encoding::Binary { swapped };
        Ok(())
    }
}

/// The beginning of a text that may be long.
fn shorten(text: &str) -> String {
    text.chars().take(40).collect()
}
